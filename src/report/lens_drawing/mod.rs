//! SVG drawing of a lens's cross-section, for papers.
//!
//! The scene is at the left and the film at the right. The rays are traced from three film points
//! to the scene, by the arithmetic of the renderer. A tilted or decentred element is drawn by the
//! section through its own vertex, as seen from the side.

mod bundle;
mod caption;
mod element;
mod paths;
#[cfg(test)]
mod tests;

use bundle::{Bundle, DrawnRay, Tracer};
use caption::{Figure, LegendEntry};
use element::{Element, arc, arc_between, drawn, elements, opening};

pub use bundle::aims;
pub use paths::{DrawnPath, draw_paths};

use glam::DAffine3;

use petzval_lens::{Prescription, Row, SurfaceAperture};

use super::svg::{Position, Sheet};

/// Fields in units of the full field, with colours that colour-blind readers can tell apart (Okabe
/// & Ito 2008) and dashes for prints in grey.
const FIELDS: [(f64, &str); 3] = [
    (0.0, "stroke=\"#0072b2\""),
    (0.7, "stroke=\"#d55e00\" stroke-dasharray=\"8 2\""),
    (1.0, "stroke=\"#009e73\" stroke-dasharray=\"3 1.5\""),
];

/// Length of rays in front of the lens, in units of the distance from its front to the film.
const RAY_LENGTH: f64 = 0.2;

/// Largest height of drawn rays, in units of the largest height of glass and film.
const RAY_HEIGHT: f64 = 1.35;

/// Least length of the marks at the stop's opening, in units of the mean of that height and half
/// the length.
const MARK: f64 = 0.08;

/// Draws the section of a lens with the y-z plane. Returns an SVG file.
///
/// The film is `film_distance` behind the rear vertex (mm); without it, neither film nor rays are
/// drawn. The full field is the largest height on the film, up to `film_radius` (mm), that a chief
/// ray reaches. The film is drawn as high as that.
pub fn draw(lens: &Prescription, film_distance: Option<f64>, film_radius: f64) -> String {
    let distance = film_distance.filter(|d| d.is_finite() && *d > 0.0);
    let section = Section::of(lens, distance, film_radius);
    let keys =
        section.bundles.iter().map(|(bundle, style, _)| LegendEntry::new(bundle, style)).collect();
    let figure = Figure::new(lens, distance, keys, section.bounds());
    let mut sheet = Sheet::default();
    figure.title(&mut sheet);
    section.draw(&figure, &mut sheet);
    figure.legend(&mut sheet);
    figure.scale_bar(&mut sheet);
    sheet.finish(figure.size(), &lens.name)
}

/// Draws what [`draw`] draws, without words, legend and scale: for drawings so small that nobody could
/// read them.
pub fn draw_small(lens: &Prescription, film_distance: Option<f64>, film_radius: f64) -> String {
    let distance = film_distance.filter(|d| d.is_finite() && *d > 0.0);
    let section = Section::of(lens, distance, film_radius);
    let figure = Figure::plain(section.bounds());
    let mut sheet = Sheet::default();
    section.draw(&figure, &mut sheet);
    sheet.finish(figure.size(), &lens.name)
}

/// Points of a line.
type Line = Vec<Position>;

/// Everything that is drawn to scale: z from the front vertex, y up (mm).
struct Section {
    elements: Vec<Element>,
    /// Obstructions.
    disks: Vec<Line>,
    /// Mirrors.
    mirrors: Vec<Line>,
    /// The edges of the stop's opening, each with the outer end of its mark.
    stop: [[Position; 2]; 2],
    film: Option<[Position; 2]>,
    /// Rays of each field point, with their stroke, and clipped to the drawing.
    bundles: Vec<(Bundle, &'static str, Vec<Line>)>,
}

impl Section {
    fn of(lens: &Prescription, distance: Option<f64>, film_radius: f64) -> Self {
        let placed = lens.surface_transforms();
        let elements = elements(lens, &placed);
        let disk = |(row, placed): (_, &DAffine3)| {
            let row: &Row = row;
            (row.obstruction > 0.0).then(|| arc(row, placed, row.obstruction / 2.0))
        };
        let mut disks: Vec<Line> = lens.rows.iter().zip(&placed).filter_map(disk).collect();
        for (row, placed) in lens.rows.iter().zip(&placed) {
            let drawn = |one: &&SurfaceAperture| one.obscures && !one.is_arm(row.diameter / 2.0);
            let obscurations = row.apertures.iter().filter(drawn);
            disks.extend(obscurations.map(|one| arc_between(row, placed, one.range_along_y())));
        }
        let mirrors: Vec<Line> = (0..lens.rows.len())
            .filter(|&i| lens.rows[i].mirror)
            .map(|i| match &lens.rows[i] {
                row if row.apertures.is_empty() => arc(row, &placed[i], row.diameter / 2.0),
                row => arc_between(row, &placed[i], opening(row)),
            })
            .collect();
        let (stop_marks, film, bundles) = Default::default();
        let mut section = Self { elements, disks, mirrors, stop: stop_marks, film, bundles };

        let glass = section.elements.iter().flat_map(|element| &element.outline);
        let glass = glass.chain(section.mirrors.iter().flatten());
        // Off-axis parts may lie below the axis.
        let decentred = lens.rows.iter().any(|row| !row.apertures.is_empty());
        let reach = |y: f64| if decentred { y.abs() } else { y };
        let mut height = glass.fold(0.0, |height: f64, point| height.max(reach(point[1])));
        let mut bundles = Vec::new();
        if let Some(distance) = distance {
            let tracer = Tracer::new(lens, &placed, distance);
            let field = tracer.field(film_radius);
            let fields = if field > 0.0 { &FIELDS[..] } else { &FIELDS[..1] };
            let bundle = |&(share, style)| Some((tracer.bundle(share * field)?, style));
            bundles.extend(fields.iter().filter_map(bundle));
            let half = if field > 0.0 { field } else { film_radius.min(height) };
            let z = lens.travel_before(lens.rows.len()) * distance;
            section.film = Some([-half, half].map(|h| drawn(&lens.film_axis(), [0.0, h, z])));
            height = height.max(half);
        }
        let [left, right, ..] = section.bounds();
        section.stop = stop(lens, &placed, MARK * (height + (right - left) / 2.0) / 2.0);
        let [left, right, bottom, top] = section.bounds();
        let aside = RAY_HEIGHT * top.max(-bottom);
        let window = [left - RAY_LENGTH * (right - left), right, aside];
        let seen = |(bundle, style): (Bundle, _)| {
            let one = |ray: &DrawnRay| line(&ray.points, Some(ray.towards), window);
            let lines = bundle.rays().map(one).collect();
            (bundle, style, lines)
        };
        section.bundles = bundles.into_iter().map(seen).collect();
        section
    }

    /// Returns the least and greatest z, and the least and greatest y (mm).
    fn bounds(&self) -> [f64; 4] {
        let mut bounds = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        let glass = self.elements.iter().flat_map(|element| &element.outline);
        let rays = self.bundles.iter().flat_map(|(_, _, lines)| lines).flatten();
        let marks = self.stop.iter().chain(&self.film).flatten();
        let glass = glass.chain(self.mirrors.iter().flatten());
        for &[z, y] in glass.chain(rays).chain(marks).chain(self.disks.iter().flatten()) {
            if z.is_finite() && y.is_finite() {
                bounds = [bounds[0].min(z), bounds[1].max(z), bounds[2].min(y), bounds[3].max(y)];
            }
        }
        if bounds[0] <= bounds[1] { bounds } else { [0.0; 4] }
    }

    fn draw(&self, figure: &Figure, sheet: &mut Sheet) {
        self.draw_glass(figure, sheet);
        self.draw_bundles(figure, sheet);
        self.draw_marks(figure, sheet);
    }

    fn draw_glass(&self, figure: &Figure, sheet: &mut Sheet) {
        sheet.open(
            "class=\"glass\" stroke=\"#2b3a4a\" stroke-width=\"0.9\" stroke-linejoin=\"round\"",
        );
        for element in &self.elements {
            let fill = format!("fill=\"{}\"", tint(element.index));
            sheet.path(&figure.line(&element.outline), true, &fill);
        }
        sheet.close();
    }

    fn draw_bundles(&self, figure: &Figure, sheet: &mut Sheet) {
        for (bundle, style, lines) in &self.bundles {
            let between = lines.len() - bundle.between.len();
            sheet.open(&format!("class=\"field\" fill=\"none\" {style} stroke-width=\"1.1\""));
            for (i, line) in lines.iter().enumerate() {
                // Off the axis, three rays are enough; more would clutter the drawing.
                if i < between {
                    sheet.path(&figure.line(line), false, "");
                } else if bundle.height == 0.0 {
                    sheet.path(&figure.line(line), false, "stroke-width=\"0.5\"");
                }
            }
            sheet.close();
        }
    }

    /// Draws the axis, disks, mirrors, stop and film.
    fn draw_marks(&self, figure: &Figure, sheet: &mut Sheet) {
        sheet.path(
            &figure.axis(),
            false,
            "class=\"axis\" stroke=\"#000\" stroke-width=\"0.6\" stroke-dasharray=\"16 6 2 6\"",
        );
        for disk in &self.disks {
            sheet.path(
                &figure.line(disk),
                false,
                "class=\"disk\" fill=\"none\" stroke=\"#000\" stroke-width=\"3\"",
            );
        }
        for mirror in &self.mirrors {
            sheet.path(
                &figure.line(mirror),
                false,
                "class=\"mirror\" fill=\"none\" stroke=\"#2b3a4a\" stroke-width=\"2.5\"",
            );
        }
        for &[edge, end] in &self.stop {
            let ([x, y], [_, y_end]) = (figure.at(edge), figure.at(end));
            let wedge = [[x, y], [x - 3.0, y_end], [x + 3.0, y_end]];
            sheet.path(&wedge, true, "class=\"stop\"");
        }
        if let Some(film) = &self.film {
            sheet.path(
                &figure.line(film),
                false,
                "class=\"film\" stroke=\"#000\" stroke-width=\"3.5\"",
            );
        }
    }
}

/// Returns the edges of the stop's opening, each with the outer end of its mark. The marks reach as
/// far as the clear aperture of the surfaces before and behind, so that a closed stop looks closed,
/// and are at least `mark` long.
fn stop(lens: &Prescription, placed: &[DAffine3], mark: f64) -> [[Position; 2]; 2] {
    let i = lens.stop();
    let row = &lens.rows[i];
    let [low, high] = opening(row);
    let half = high.abs().max(low.abs());
    let near = &lens.rows[i.saturating_sub(1)..lens.rows.len().min(i + 2)];
    let clear = near.iter().fold(0.0, |clear: f64, row| clear.max(row.diameter / 2.0));
    let end = clear.max(half + mark);
    [[high, end], [low, -end]].map(|[edge, end]| {
        let z = row.sag_at(0.0, edge);
        [edge, end].map(|h| drawn(&placed[i], [0.0, h, z]))
    })
}

/// Returns a ray from where it enters the window (least z, greatest z, greatest height) to the
/// film. The points begin at the film; a ray that goes nowhere ends at the last one.
fn line(points: &[Position], towards: Option<Position>, window: [f64; 3]) -> Line {
    let ([left, right, aside], &[z, y]) = (window, points.last().unwrap_or(&[0.0; 2]));
    let across = |here: f64, there: f64, speed: f64| match speed {
        0.0 => f64::INFINITY,
        _ => ((there - here) / speed).max(0.0),
    };
    let start = towards.and_then(|[dz, dy]| {
        let wall = across(z, if dz < 0.0 { left } else { right }, dz);
        let way = wall.min(across(y, aside.copysign(dy), dy));
        way.is_finite().then_some([z + way * dz, y + way * dy])
    });
    start.into_iter().chain(points.iter().rev().copied()).collect()
}

/// Returns the colour of glass: light blue-grey, deeper for a higher index.
fn tint(index: f64) -> String {
    let depth = ((index - 1.45) / 0.5).clamp(0.0, 1.0);
    let mix = |thin: f64, dense: f64| (thin + depth * (dense - thin)).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(234.0, 163.0), mix(241.0, 188.0), mix(247.0, 213.0))
}
