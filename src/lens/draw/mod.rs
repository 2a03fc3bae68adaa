//! The cross-section of a lens, as a drawing for a paper: SVG.
//!
//! The scene is at the left and the film at the right. What is drawn of rays is traced, from
//! three film points to the scene, by the same arithmetic that takes pictures. Of a part that does
//! not stand square the section through its own vertex is drawn, as it looks from the side.

mod bundle;
mod caption;
mod element;

use bundle::{Bundle, Ray, Tracer};
use caption::{Figure, Key};
use element::{Element, arc, drawn, elements};

use glam::DAffine3;

use super::prescription::Prescription;
use crate::svg::{Point, Sheet};

/// The fields in units of the full one, with colours that the colour-blind tell apart (Okabe &
/// Ito 2008) and dashes for those who print in grey.
const FIELDS: [(f64, &str); 3] = [
    (0.0, "stroke=\"#0072b2\""),
    (0.7, "stroke=\"#d55e00\" stroke-dasharray=\"8 2\""),
    (1.0, "stroke=\"#009e73\" stroke-dasharray=\"3 1.5\""),
];

/// How far rays show before the lens, in units of the length from there to the film.
const AHEAD: f64 = 0.2;

/// How far from the axis rays show, in units of the greatest height of glass and film.
const ASIDE: f64 = 1.35;

/// How far the marks of the stop reach beyond its opening, in units of the mean of that height
/// and half the length.
const MARK: f64 = 0.08;

/// Draws the section of a lens with the y-z plane, as an SVG file.
///
/// The film is `film_distance` mm behind the rear vertex, or left out, and with it the rays. The
/// full field is the greatest height on the film, up to `film_radius` mm, that a chief ray
/// reaches. The film is drawn as high as that.
///
/// # Panics
/// Where no row is the stop; no reader makes such a lens.
pub fn draw(lens: &Prescription, film_distance: Option<f64>, film_radius: f64) -> String {
    let distance = film_distance.filter(|d| d.is_finite() && *d > 0.0);
    let section = Section::of(lens, distance, film_radius);
    let keys = section.bundles.iter().map(|(bundle, style, _)| Key::of(bundle, style)).collect();
    let figure = Figure::new(lens, distance, keys, section.bounds());
    let mut sheet = Sheet::default();
    figure.title(&mut sheet);
    section.draw(&figure, &mut sheet);
    figure.legend(&mut sheet);
    figure.scale_bar(&mut sheet);
    sheet.finish(figure.size(), &lens.name)
}

/// A ray's points from the scene to the film.
type Line = Vec<Point>;

/// Everything that is drawn to scale, mm: z from the front vertex, y up.
struct Section {
    elements: Vec<Element>,
    /// Opaque disks.
    disks: Vec<Line>,
    /// The edges of the stop's opening, each with the outer end of its mark.
    stop: [[Point; 2]; 2],
    film: Option<[Point; 2]>,
    /// What each field point sees, with its stroke, and how that looks inside the drawing.
    bundles: Vec<(Bundle, &'static str, Vec<Line>)>,
}

impl Section {
    fn of(lens: &Prescription, distance: Option<f64>, film_radius: f64) -> Self {
        let placed = lens.placements();
        let elements = elements(lens, &placed);
        let disk = |(row, placed): (_, &DAffine3)| {
            let row: &super::Row = row;
            (row.obstruction > 0.0).then(|| arc(row, placed, row.obstruction / 2.0))
        };
        let disks = lens.rows.iter().zip(&placed).filter_map(disk).collect();
        let mut section =
            Self { elements, disks, stop: Default::default(), film: None, bundles: Vec::new() };

        let glass = section.elements.iter().flat_map(|element| &element.outline);
        let mut height = glass.fold(0.0, |height: f64, point| height.max(point[1]));
        let mut bundles = Vec::new();
        if let Some(distance) = distance {
            let tracer = Tracer::new(lens, &placed, distance);
            let field = tracer.field(film_radius);
            let fields = if field > 0.0 { &FIELDS[..] } else { &FIELDS[..1] };
            let bundle = |&(share, style)| Some((tracer.bundle(share * field)?, style));
            bundles.extend(fields.iter().filter_map(bundle));
            let half = if field > 0.0 { field } else { film_radius.min(height) };
            let z = lens.length() + distance;
            section.film = Some([[z, -half], [z, half]]);
            height = height.max(half);
        }
        let [left, right, ..] = section.bounds();
        section.stop = stop(lens, &placed, MARK * (height + (right - left) / 2.0) / 2.0);
        let [left, right, bottom, top] = section.bounds();
        let aside = ASIDE * top.max(-bottom);
        let window = [left - AHEAD * (right - left), right, aside];
        let seen = |(bundle, style): (Bundle, _)| {
            let lines = bundle.rays().map(|ray| line(ray, window)).collect();
            (bundle, style, lines)
        };
        section.bundles = bundles.into_iter().map(seen).collect();
        section
    }

    /// Least and greatest z, least and greatest y, mm.
    fn bounds(&self) -> [f64; 4] {
        let mut bounds = [f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY];
        let glass = self.elements.iter().flat_map(|element| &element.outline);
        let rays = self.bundles.iter().flat_map(|(_, _, lines)| lines).flatten();
        let marks = self.stop.iter().chain(&self.film).flatten();
        for &[z, y] in glass.chain(rays).chain(marks).chain(self.disks.iter().flatten()) {
            if z.is_finite() && y.is_finite() {
                bounds = [bounds[0].min(z), bounds[1].max(z), bounds[2].min(y), bounds[3].max(y)];
            }
        }
        if bounds[0] <= bounds[1] { bounds } else { [0.0; 4] }
    }

    fn draw(&self, figure: &Figure, sheet: &mut Sheet) {
        let on_sheet = |line: &[Point]| line.iter().map(|&p| figure.at(p)).collect::<Vec<_>>();
        sheet.open(
            "class=\"glass\" stroke=\"#2b3a4a\" stroke-width=\"0.9\" stroke-linejoin=\"round\"",
        );
        for element in &self.elements {
            let fill = format!("fill=\"{}\"", tint(element.index));
            sheet.path(&on_sheet(&element.outline), true, &fill);
        }
        sheet.close();
        for (bundle, style, lines) in &self.bundles {
            let between = lines.len() - bundle.between.len();
            sheet.open(&format!("class=\"field\" fill=\"none\" {style} stroke-width=\"1.1\""));
            for (i, line) in lines.iter().enumerate() {
                // Off the axis three rays say it; more would only be in the way.
                if i < between {
                    sheet.path(&on_sheet(line), false, "");
                } else if bundle.height == 0.0 {
                    sheet.path(&on_sheet(line), false, "stroke-width=\"0.5\"");
                }
            }
            sheet.close();
        }
        sheet.path(
            &figure.axis(),
            false,
            "class=\"axis\" stroke=\"#000\" stroke-width=\"0.6\" stroke-dasharray=\"16 6 2 6\"",
        );
        for disk in &self.disks {
            sheet.path(
                &on_sheet(disk),
                false,
                "class=\"disk\" fill=\"none\" stroke=\"#000\" stroke-width=\"3\"",
            );
        }
        for &[edge, end] in &self.stop {
            let ([x, y], [_, y_end]) = (figure.at(edge), figure.at(end));
            let wedge = [[x, y], [x - 3.0, y_end], [x + 3.0, y_end]];
            sheet.path(&wedge, true, "class=\"stop\"");
        }
        if let Some(film) = &self.film {
            sheet.path(
                &on_sheet(film),
                false,
                "class=\"film\" stroke=\"#000\" stroke-width=\"3.5\"",
            );
        }
    }
}

/// The edges of the stop's opening, each with the outer end of its mark: as far out as the glass
/// before and behind is clear, so that a closed stop looks closed, and at least `mark`.
fn stop(lens: &Prescription, placed: &[DAffine3], mark: f64) -> [[Point; 2]; 2] {
    let i = lens.stop();
    let row = &lens.rows[i];
    let half = row.diameter / 2.0;
    let z = row.sag_at(0.0, half);
    let near = &lens.rows[i.saturating_sub(1)..lens.rows.len().min(i + 2)];
    let clear = near.iter().fold(0.0, |clear: f64, row| clear.max(row.diameter / 2.0));
    let end = clear.max(half + mark);
    [1.0, -1.0].map(|side| [half, end].map(|h| drawn(&placed[i], [0.0, side * h, z])))
}

/// A ray from where it enters the window (least z, greatest z, greatest height) to the film.
fn line(ray: &Ray, [left, right, aside]: [f64; 3]) -> Line {
    let &[z, y] = ray.points.last().unwrap_or(&[0.0; 2]);
    let [dz, dy] = ray.towards;
    let across = |here: f64, there: f64, speed: f64| match speed {
        0.0 => f64::INFINITY,
        _ => ((there - here) / speed).max(0.0),
    };
    let wall = across(z, if dz < 0.0 { left } else { right }, dz);
    let way = wall.min(across(y, aside.copysign(dy), dy));
    let start = way.is_finite().then_some([z + way * dz, y + way * dy]);
    start.into_iter().chain(ray.points.iter().rev().copied()).collect()
}

/// Light blue-grey, deeper for a higher index.
fn tint(index: f64) -> String {
    let depth = ((index - 1.45) / 0.5).clamp(0.0, 1.0);
    let mix = |thin: f64, dense: f64| (thin + depth * (dense - thin)).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(234.0, 163.0), mix(241.0, 188.0), mix(247.0, 213.0))
}
