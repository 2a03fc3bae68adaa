//! Section of a lens with given ray paths.

use petzval_lens::Prescription;

use super::caption::Figure;
use super::{RAY_LENGTH, Section, line};
use crate::svg::{Position, Sheet};

/// Radius of the mark at the end of a blocked ray [px].
const END: f64 = 2.5;

/// The path of a ray in the plane of the drawing: z from the front vertex, then the height (mm).
#[derive(Clone, Debug)]
pub struct DrawnPath {
    /// The film point and the points on the surfaces, in the order of the path.
    pub points: Vec<Position>,
    /// Direction in which it leaves the lens; `None` if it is blocked at the last point.
    pub towards: Option<Position>,
    /// Colour, as in SVG.
    pub colour: &'static str,
}

/// Draws the section of a lens with these paths, without words. Returns an SVG file. The scale does
/// not depend on the paths. `film` holds the ends of the film (mm).
pub fn draw_paths(lens: &Prescription, film: [Position; 2], paths: &[DrawnPath]) -> String {
    let mut section = Section::of(lens, None, 0.0);
    section.film = Some(film);
    let [left, right, bottom, top] = section.bounds();
    let left = left - RAY_LENGTH * (right - left);
    let height = top.max(-bottom);
    let figure = Figure::plain([left, right, bottom.min(-height), top.max(height)]);
    let mut sheet = Sheet::default();
    section.draw_glass(&figure, &mut sheet);
    for path in paths {
        let DrawnPath { points, towards, colour } = path;
        let drawn = figure.line(&line(points, *towards, [left, right, height]));
        let width = if towards.is_some() { 1.3 } else { 1.0 };
        let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"");
        sheet.path(&drawn, false, &style);
        if let (None, Some(&end)) = (towards, points.last()) {
            sheet.circle(figure.at(end), END, &format!("fill=\"{colour}\""));
        }
    }
    section.draw_marks(&figure, &mut sheet);
    sheet.finish(figure.size(), &lens.name)
}
