//! Layout of a drawing, its caption, legend and scale bar.

use petzval_lens::{Paraxial, Prescription, RealRayFocus, TransverseAxis};

use super::bundle::Bundle;
use crate::svg::{Position, Sheet, shortened, width};

/// Margin [px].
const MARGIN: f64 = 28.0;
/// Largest size of the part drawn to scale [px].
const ROOM: [f64; 2] = [904.0, 520.0];
/// Size of a drawing without words, in units of one with them.
const PLAIN: f64 = 0.45;
/// Least width of the sheet, so that scale bar and legend fit beside each other [px].
const MIN_WIDTH: f64 = 820.0;
/// Type size of the title [px].
const TITLE: f64 = 18.0;
/// Type size of other text [px].
const TEXT: f64 = 13.0;
/// Heights of the strips above and below [px].
const ABOVE: f64 = 54.0;
const BELOW: f64 = 52.0;
/// Length of the axis beyond the drawing at both ends [px].
const AXIS: f64 = 12.0;
/// Length of the line of a legend's entry, and the gap after line and entry [px].
const SAMPLE: f64 = 26.0;
const GAP: f64 = 6.0;

/// Largest f-number in the caption.
const MAX_F_NUMBER: f64 = 1e4;

/// An entry of the legend.
pub(super) struct LegendEntry {
    style: String,
    words: String,
}

impl LegendEntry {
    pub(super) fn new(bundle: &Bundle, style: &str) -> Self {
        let words = match &bundle.chief {
            _ if bundle.height == 0.0 => "on axis".to_owned(),
            Some(chief) => {
                let [dz, dy] = chief.towards;
                let angle = dy.abs().atan2(-dz).to_degrees();
                let degrees =
                    if angle < 0.95 { format!("{angle:.3}") } else { format!("{angle:.1}") };
                format!("{}, {degrees}\u{b0}", length(bundle.height))
            }
            None => length(bundle.height),
        };
        Self { style: style.to_owned(), words }
    }
}

/// Layout of the sheet, which maps mm in the lens to px, and its text.
pub(super) struct Figure {
    name: String,
    words: String,
    keys: Vec<LegendEntry>,
    bounds: [f64; 4],
    /// Pixels per mm.
    scale: f64,
    /// Upper left corner of the part drawn to scale [px].
    corner: Position,
    size: Position,
}

impl Figure {
    /// Lays out a drawing with these bounds: least and greatest z, least and greatest y (mm).
    pub(super) fn new(
        lens: &Prescription,
        distance: Option<f64>,
        keys: Vec<LegendEntry>,
        bounds: [f64; 4],
    ) -> Self {
        let [left, right, bottom, top] = bounds;
        let scale = scale(bounds);
        let inside = [scale * (right - left), scale * (top - bottom)];
        let width = (inside[0] + 2.0 * MARGIN).max(MIN_WIDTH);
        let corner = [(width - inside[0]) / 2.0, MARGIN + ABOVE];
        let size = [width, corner[1] + inside[1] + BELOW + MARGIN];
        Self {
            name: lens.name.clone(),
            words: description(lens, distance),
            keys,
            bounds,
            scale,
            corner,
            size,
        }
    }

    /// Maps a point of the lens to the sheet.
    pub(super) fn at(&self, [z, y]: Position) -> Position {
        let [left, _, _, top] = self.bounds;
        [self.corner[0] + self.scale * (z - left), self.corner[1] + self.scale * (top - y)]
    }

    /// Lays out a drawing with these bounds (mm) alone, without words.
    pub(super) fn plain(bounds: [f64; 4]) -> Self {
        let [left, right, bottom, top] = bounds;
        let scale = scale(bounds) * PLAIN;
        let edge = AXIS + 2.0;
        let size = [right - left, top - bottom].map(|side| scale * side + 2.0 * edge);
        let (name, words, keys) = Default::default();
        Self { name, words, keys, bounds, scale, corner: [edge; 2], size }
    }

    /// Maps a line of the lens to the sheet.
    pub(super) fn line(&self, line: &[Position]) -> Vec<Position> {
        line.iter().map(|&point| self.at(point)).collect()
    }

    /// Returns width and height of the sheet [px].
    pub(super) fn size(&self) -> Position {
        self.size
    }

    /// Returns the ends of the optical axis [px].
    pub(super) fn axis(&self) -> [Position; 2] {
        let [left, right, ..] = self.bounds;
        let ([x, y], [x_end, _]) = (self.at([left, 0.0]), self.at([right, 0.0]));
        [[x - AXIS, y], [x_end + AXIS, y]]
    }

    /// Writes the lens's name and data, above.
    pub(super) fn title(&self, sheet: &mut Sheet) {
        let name = shortened(&self.name, TITLE, self.size[0] - 2.0 * MARGIN);
        sheet.text([MARGIN, MARGIN + 14.0], TITLE, "font-weight=\"bold\"", &name);
        sheet.text([MARGIN, MARGIN + 34.0], TEXT, "", &self.words);
    }

    /// Writes the field points, below at the right.
    pub(super) fn legend(&self, sheet: &mut Sheet) {
        if self.keys.is_empty() {
            return;
        }
        let room = |key: &LegendEntry| SAMPLE + GAP + width(&key.words, TEXT) + GAP;
        let mut x = self.size[0] - MARGIN - self.keys.iter().map(room).sum::<f64>();
        let y = self.size[1] - MARGIN;
        sheet.text([x, y - 20.0], TEXT, "", "Film height, field angle:");
        for key in &self.keys {
            let sample = [[x, y - 4.5], [x + SAMPLE, y - 4.5]];
            sheet.path(
                &sample,
                false,
                &format!("class=\"key\" fill=\"none\" {} stroke-width=\"2\"", key.style),
            );
            sheet.text([x + SAMPLE + GAP, y], TEXT, "", &key.words);
            x += room(key);
        }
    }

    /// Draws a scale bar of a round length, up to 28 % of the width, below at the left.
    pub(super) fn scale_bar(&self, sheet: &mut Sheet) {
        let most = 0.28 * (self.bounds[1] - self.bounds[0]);
        let power = 10f64.powf(most.log10().floor());
        let Some(bar) = [5.0, 2.0, 1.0].map(|n| n * power).into_iter().find(|&bar| bar <= most)
        else {
            return;
        };
        let y = self.size[1] - MARGIN - 4.5;
        let end = MARGIN + bar * self.scale;
        let ticks = [
            [MARGIN, y - 4.0],
            [MARGIN, y + 4.0],
            [MARGIN, y],
            [end, y],
            [end, y - 4.0],
            [end, y + 4.0],
        ];
        sheet.path(
            &ticks,
            false,
            "class=\"scale\" fill=\"none\" stroke=\"#000\" stroke-width=\"1.2\"",
        );
        sheet.text([end + 8.0, y + 4.5], TEXT, "", &round(&length(bar)));
    }
}

/// Returns the pixels per mm at which a drawing with these bounds has room.
fn scale([left, right, bottom, top]: [f64; 4]) -> f64 {
    let scale = (ROOM[0] / (right - left)).min(ROOM[1] / (top - bottom));
    if scale.is_finite() && scale > 0.0 { scale } else { 1.0 }
}

/// Describes focal length, f-number and focus.
fn description(lens: &Prescription, distance: Option<f64>) -> String {
    let paraxial = Paraxial::new(lens);
    let focal_length = paraxial.focal_length;
    let open = RealRayFocus::new(lens).f_number().unwrap_or(f64::INFINITY);
    let bends = !paraxial.is_afocal();
    let mut words =
        if bends { format!("f = {}", length(focal_length)) } else { "afocal".to_owned() };
    if lens.rows.iter().any(|row| row.is_anamorphic()) {
        let drawn = Paraxial::in_plane(lens, TransverseAxis::Y).focal_length;
        words = format!("{words} along x, {} along y (drawn)", length(drawn));
    }
    if bends && open < MAX_F_NUMBER {
        words += &format!(", f/{open:.1}");
    }
    let Some(distance) = distance else {
        words += match paraxial.film_for_focus(f64::INFINITY) {
            Ok(_) => "; drawn without film",
            Err(_) => "; forms no real image of distant objects, drawn without film",
        };
        return words;
    };
    match RealRayFocus::new(lens).object_distance(distance) {
        Some(focus) if focus.is_infinite() => words += ", focused at infinity",
        Some(focus) => {
            words += &format!(
                ", focused at {} from the film",
                length(focus + lens.film_position(distance))
            );
        }
        None => {}
    }
    words
}

/// Formats a length with about three digits, in a suitable unit.
fn length(mm: f64) -> String {
    let size = mm.abs();
    let (number, unit) = match size {
        _ if size >= 1000.0 => (mm / 1000.0, "m"),
        _ if size >= 0.1 || size == 0.0 => (mm, "mm"),
        _ => (mm * 1000.0, "\u{b5}m"),
    };
    let size = number.abs();
    match size {
        _ if size >= 1e5 || (size < 0.01 && size > 0.0) => format!("{number:.2e} {unit}"),
        _ if size >= 10.0 => format!("{number:.1} {unit}"),
        _ if size >= 1.0 => format!("{number:.2} {unit}"),
        _ => format!("{number:.3} {unit}"),
    }
}

/// Removes the trailing zeros of a formatted length.
fn round(length: &str) -> String {
    match length.split_once(' ') {
        Some((number, unit)) if number.contains('.') && !number.contains('e') => {
            format!("{} {unit}", number.trim_end_matches('0').trim_end_matches('.'))
        }
        _ => length.to_owned(),
    }
}
