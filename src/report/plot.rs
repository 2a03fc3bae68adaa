//! Plots: curves and points on linear axes.

use crate::svg::{Position, Sheet, width};

/// Colours that readers with colour blindness can tell apart (Okabe & Ito 2008), from short to long
/// wavelengths.
const COLOURS: [&str; 7] =
    ["#0072b2", "#56b4e9", "#009e73", "#e69f00", "#d55e00", "#cc79a7", "#7f7f7f"];

/// A plot.
#[derive(Clone, Debug, Default)]
pub struct Plot {
    /// Name of the file, without the section's name.
    pub name: String,
    /// Title, above the plot.
    pub title: String,
    /// Names of the axes, with units.
    pub axes: [String; 2],
    /// Curves and points.
    pub series: Vec<Series>,
    /// Whether a unit has the same length along both axes.
    pub square: bool,
    /// Ranges of the axes; without one, that of the data.
    pub ranges: [Option<[f64; 2]>; 2],
    /// Whether the legend is left out.
    pub bare: bool,
    /// Whether it is small enough for a column beside a picture.
    pub narrow: bool,
    /// Whether it takes the whole width of the page.
    pub broad: bool,
    /// Labels along x in place of numbers.
    pub ticks: Vec<(f64, String)>,
    /// Lines of text below the legend.
    pub captions: Vec<String>,
}

/// A curve or a cloud of points.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Name in the legend; without one it has no entry.
    pub name: String,
    /// Number of its colour.
    pub colour: usize,
    /// Look of the points.
    pub style: Style,
    /// Points along both axes.
    pub points: Vec<[f64; 2]>,
}

/// Look of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Style {
    /// A curve.
    #[default]
    Line,
    /// A dashed curve.
    Dashed,
    /// A cloud of points.
    Dots,
    /// Few points, each of which counts.
    Marks,
    /// A closed outline.
    Outline,
    /// Bars between the points of each pair, seven side by side within a unit of x.
    Bars,
}

/// Size of a plot [px].
const WIDE: Position = [480.0, 320.0];
const SQUARE: Position = [300.0, 320.0];
const NARROW: Position = [300.0, 220.0];
const BROAD: Position = [976.0, 340.0];
/// Height of a line of the legend or of text below it [px].
const ROW: f64 = 15.0;
/// Width of a bar along x.
const BAR: f64 = 0.11;
/// Least distance between two labels along x [px].
const LABEL: f64 = 24.0;
/// Margins: left, top, right, bottom [px].
const MARGIN: [f64; 4] = [62.0, 28.0, 14.0, 46.0];
const TYPE: f64 = 11.0;
/// Most points of a cloud that are drawn.
const DOTS: usize = 900;

/// Returns the colour of a wavelength among `count`, which are numbered from short to long.
pub(crate) fn colour(rank: usize, count: usize) -> usize {
    match count {
        1 => 0,
        _ => rank * (COLOURS.len() - 2).min(count.max(3) - 1) / (count - 1),
    }
}

impl Plot {
    /// Returns the plot as an SVG file.
    pub fn file(&self) -> String {
        let (sheet, size) = self.draw();
        sheet.finish(size, &self.title)
    }

    /// Returns the plot as a part of a page.
    pub fn inline(&self) -> String {
        let (sheet, size) = self.draw();
        sheet.inline(size, &self.title)
    }

    /// Returns the range of the data along an axis, with a margin.
    fn range(&self, axis: usize) -> [f64; 2] {
        if let Some(range) = self.ranges[axis] {
            return range;
        }
        let values = self.series.iter().flat_map(|series| &series.points).map(|p| p[axis]);
        let [low, high] = values
            .filter(|v| v.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        if low > high {
            return [-1.0, 1.0];
        }
        let room = 0.05 * (high - low);
        // Rounding is no range.
        let least = 1e-6 * low.abs().max(high.abs());
        if high.abs().max(low.abs()) < 1e-9 {
            return [-1.0, 1.0];
        }
        match high - low > least {
            true => [low - room, high + room],
            false => [low - 0.05 * low.abs(), high + 0.05 * high.abs()],
        }
    }

    fn draw(&self) -> (Sheet, Position) {
        let legend: Vec<&Series> =
            self.series.iter().filter(|series| !series.name.is_empty()).collect();
        let size = match self {
            Self { square: true, .. } => SQUARE,
            Self { narrow: true, .. } => NARROW,
            Self { broad: true, .. } => BROAD,
            _ => WIDE,
        };
        let rows = if self.bare { 0 } else { legend_rows(&legend, size[0]) };
        let captions: &[String] = if self.narrow { &[] } else { &self.captions };
        let below = ROW * (rows + captions.len()) as f64;
        let size = [size[0], size[1] + below];
        let [left, top, right, bottom] = MARGIN;
        let frame = [[left, size[0] - right], [size[1] - bottom - below, top]];
        let mut ranges = [self.range(0), self.range(1)];
        if self.square {
            let half = ranges.map(|[low, high]| (high - low) / 2.0);
            let most =
                half[0].max(half[1] * (frame[0][1] - frame[0][0]) / (frame[1][0] - frame[1][1]));
            let scale = most / (frame[0][1] - frame[0][0]);
            for axis in 0..2 {
                let middle = (ranges[axis][0] + ranges[axis][1]) / 2.0;
                let reach = scale * (frame[axis][1] - frame[axis][0]).abs();
                ranges[axis] = [middle - reach, middle + reach];
            }
        }
        let place = |axis: usize, value: f64| {
            let [low, high] = ranges[axis];
            let [from, to] = frame[axis];
            from + (value - low) / (high - low) * (to - from)
        };
        let mut sheet = Sheet::default();
        sheet.text([left, 17.0], 13.0, "font-weight=\"bold\"", &self.title);
        for axis in 0..2 {
            self.axis(&mut sheet, axis, ranges[axis], frame);
        }
        for series in &self.series {
            let points: Vec<Position> =
                series.points.iter().map(|p| [place(0, p[0]), place(1, p[1])]).collect();
            draw_series(&mut sheet, series, &points, frame, BAR * (place(0, 1.0) - place(0, 0.0)));
        }
        let captions_top = size[1] - ROW * captions.len() as f64;
        if !self.bare {
            self.legend(&mut sheet, &legend, [size[0], captions_top], rows);
        }
        for (i, caption) in captions.iter().enumerate() {
            let y = captions_top + ROW * i as f64 + 7.0;
            sheet.text([MARGIN[0] - 40.0, y], TYPE, "", caption);
        }
        (sheet, size)
    }

    /// Draws the lines and labels of an axis.
    fn axis(&self, sheet: &mut Sheet, axis: usize, [low, high]: [f64; 2], frame: [[f64; 2]; 2]) {
        let step = tick_step(
            (high - low) / if axis == 0 && (self.square || self.narrow) { 4.0 } else { 6.0 },
        );
        let [from, to] = frame[axis];
        let middle = f64::midpoint(from, to);
        let name = &self.axes[axis];
        if axis == 0 && !self.ticks.is_empty() {
            let mut free = f64::NEG_INFINITY;
            for (value, label) in &self.ticks {
                let at = from + (value - low) / (high - low) * (to - from);
                // The last label is that of a sum.
                let last = self.ticks.last().is_some_and(|(end, _)| end == value);
                if at >= free || last {
                    let place = [at, frame[1][0] + 14.0];
                    sheet.text(place, TYPE, "text-anchor=\"middle\"", label);
                    free = at + LABEL;
                }
            }
            let place = [middle, frame[1][0] + 31.0];
            sheet.text(place, TYPE, "text-anchor=\"middle\"", name);
            return;
        }
        let digits = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        let first = (low / step).ceil() as i64;
        let last = (high / step).floor() as i64;
        for i in first..=last {
            let value = i as f64 * step;
            let at = from + (value - low) / (high - low) * (to - from);
            let line = match axis {
                0 => [[at, frame[1][0]], [at, frame[1][1]]],
                _ => [[frame[0][0], at], [frame[0][1], at]],
            };
            let zero = if i == 0 { 0.55 } else { 0.16 };
            sheet.path(&line, false, &format!("stroke=\"currentColor\" stroke-opacity=\"{zero}\""));
            let label = format!("{value:.digits$}");
            match axis {
                0 => sheet.text([at, frame[1][0] + 14.0], TYPE, "text-anchor=\"middle\"", &label),
                _ => sheet.text([frame[0][0] - 5.0, at + 4.0], TYPE, "text-anchor=\"end\"", &label),
            }
        }
        match axis {
            0 => {
                sheet.text([middle, frame[1][0] + 31.0], TYPE, "text-anchor=\"middle\"", name);
            }
            _ => {
                let turn =
                    format!("text-anchor=\"middle\" transform=\"rotate(-90 13 {middle:.1})\"");
                sheet.text([13.0, middle], TYPE, &turn, name);
            }
        }
    }

    fn legend(&self, sheet: &mut Sheet, legend: &[&Series], size: Position, rows: usize) {
        let (mut x, mut row) = (MARGIN[0] - 40.0, 0);
        for series in legend {
            let room = entry_width(series);
            if x + room > size[0] && x > MARGIN[0] - 40.0 {
                (x, row) = (MARGIN[0] - 40.0, row + 1);
            }
            let y = size[1] - 8.0 - ROW * (rows - 1 - row) as f64;
            let line = [[x, y - 4.0], [x + 18.0, y - 4.0]];
            let sample = Series { points: Vec::new(), ..(*series).clone() };
            match series.style {
                Style::Dots | Style::Marks => {
                    sheet.circle([x + 9.0, y - 4.0], 2.5, &fill(series.colour));
                }
                _ => sheet.path(&line, false, &stroke(&sample)),
            }
            sheet.text([x + 22.0, y], TYPE, "", &series.name);
            x += room;
        }
    }
}

fn entry_width(series: &Series) -> f64 {
    36.0 + width(&series.name, TYPE) * 0.8
}

fn legend_rows(legend: &[&Series], width: f64) -> usize {
    let (mut x, mut rows) = (MARGIN[0] - 40.0, usize::from(!legend.is_empty()));
    for series in legend {
        let room = entry_width(series);
        if x + room > width && x > MARGIN[0] - 40.0 {
            (x, rows) = (MARGIN[0] - 40.0, rows + 1);
        }
        x += room;
    }
    rows
}

fn fill(colour: usize) -> String {
    format!("fill=\"{}\"", COLOURS[colour % COLOURS.len()])
}

fn stroke(series: &Series) -> String {
    let dashes = match series.style {
        Style::Dashed => " stroke-dasharray=\"5 3\"",
        _ => "",
    };
    let colour = COLOURS[series.colour % COLOURS.len()];
    format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"{dashes}")
}

/// Draws a series; bars are `bar` px wide.
fn draw_series(
    sheet: &mut Sheet,
    series: &Series,
    points: &[Position],
    frame: [[f64; 2]; 2],
    bar: f64,
) {
    let inside = |p: &Position| {
        let within = |v: f64, [a, b]: [f64; 2]| (a.min(b) - 0.5..=a.max(b) + 0.5).contains(&v);
        within(p[0], frame[0]) && within(p[1], frame[1])
    };
    match series.style {
        Style::Dots => {
            let every = points.len().div_ceil(DOTS).max(1);
            for point in points.iter().step_by(every).filter(|p| inside(p)) {
                sheet.circle(*point, 0.9, &fill(series.colour));
            }
        }
        Style::Marks => {
            for point in points.iter().filter(|p| inside(p)) {
                sheet.circle(*point, 2.5, &fill(series.colour));
            }
        }
        Style::Outline => sheet.path(points, true, &stroke(series)),
        Style::Bars => {
            let wide = stroke(series).replace("1.6", &format!("{:.2}", bar.clamp(0.5, 8.0)));
            points.chunks(2).for_each(|pair| sheet.path(pair, false, &wide));
        }
        Style::Line | Style::Dashed => {
            for run in points.split(|p| !inside(p)).filter(|run| run.len() > 1) {
                sheet.path(run, false, &stroke(series));
            }
        }
    }
}

/// Returns a round step of about this size: 1, 2 or 5 times a power of ten.
fn tick_step(wanted: f64) -> f64 {
    let power = 10f64.powf(wanted.log10().floor());
    let share = wanted / power;
    power
        * if share <= 1.0 {
            1.0
        } else if share <= 2.0 {
            2.0
        } else if share <= 5.0 {
            5.0
        } else {
            10.0
        }
}
