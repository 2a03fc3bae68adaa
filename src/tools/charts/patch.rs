//! Patches of charts, in the plane of the chart: mm from the axis, x to the right and y up.

use super::view::{ChartError, ChartView, MIN_EDGES, MIN_GRID};

/// Reflectance of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reflectance {
    /// The same at every wavelength.
    Grey(f64),
    /// That of a patch of the colour checker.
    OfChecker(usize),
}

/// A patch of one reflectance.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Patch {
    pub reflectance: Reflectance,
    pub shape: PatchShape,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum PatchShape {
    /// Corners, in turn.
    Quad([[f64; 2]; 4]),
    Disk {
        centre: [f64; 2],
        radius: f64,
    },
}

/// Size of the background relative to the picture.
const MARGIN: f64 = 1.25;
/// Side of a slanted square, relative to the height of the picture, and its slant (degrees).
const SQUARE: f64 = 0.14;
const SLANT: f64 = 5.0;
/// Length and width of the region of an edge, relative to the square.
const REGION: [f64; 2] = [0.6, 0.5];
/// Places of squares: the field on the longer axis, relative to half of the diagonal, that on the shorter one, relative
/// to half of it, and the distance of the last ones from the borders, relative to the square.
const FIELD: f64 = 0.7;
const SHORT_FIELD: f64 = 0.6;
const CORNER: f64 = 0.8;
/// Rows of dots in the height of the picture, the radius of a dot relative to their distance, and its reflectance.
const DOT_ROWS: f64 = 12.0;
const DOT: f64 = 1.0 / 6.0;
const DOT_REFLECTANCE: f64 = 0.04;

/// Returns a background that is larger than the picture.
pub(super) fn flat(view: &ChartView<'_>, reflectance: f64) -> Result<Patch, ChartError> {
    let [x, y] = view.reach()?.map(|reach| MARGIN * reach);
    let reflectance = Reflectance::Grey(reflectance);
    Ok(Patch { reflectance, shape: PatchShape::Quad([[-x, -y], [x, -y], [x, y], [-x, y]]) })
}

/// Adds dots that fill the picture, one of them on the axis, and returns their distance (mm).
pub(super) fn dots(view: &ChartView<'_>, to: &mut Vec<Patch>) -> Result<f64, ChartError> {
    view.check_size(MIN_GRID)?;
    let height = view.resolution()[0].min(view.resolution()[1]);
    let spacing = f64::from(height) * view.pixel_width()? / DOT_ROWS;
    let count = view.reach()?.map(|reach| (reach / spacing).ceil() as i32);
    for row in -count[1]..=count[1] {
        for column in -count[0]..=count[0] {
            let centre = [column, row].map(|n| spacing * f64::from(n));
            let shape = PatchShape::Disk { centre, radius: DOT * spacing };
            to.push(Patch { reflectance: Reflectance::Grey(DOT_REFLECTANCE), shape });
        }
    }
    Ok(spacing)
}

/// Adds slanted squares, and returns the regions of their left and their upper edges.
pub(super) fn squares(
    view: &ChartView<'_>,
    reflectance: f64,
    to: &mut Vec<Patch>,
) -> Result<Vec<[[u32; 2]; 2]>, ChartError> {
    let [width, height] = view.resolution();
    view.check_size(MIN_EDGES)?;
    let half = [width, height].map(|n| f64::from(n) / 2.0);
    let side = 2.0 * SQUARE * half[0].min(half[1]);
    let long = usize::from(half[1] > half[0]);
    let field = FIELD * half[0].hypot(half[1]);
    let corner = half.map(|half| half - CORNER * side);
    let along = |axis: usize, by: f64| if axis == 0 { [by, 0.0] } else { [0.0, by] };
    let mut places = vec![[0.0; 2]];
    for sign in [-1.0, 1.0] {
        places.push(along(long, sign * field.min(corner[long])));
        places.push(along(1 - long, sign * SHORT_FIELD * half[1 - long]));
        places.push([sign * corner[0], corner[1]]);
        places.push([sign * corner[0], -corner[1]]);
    }
    let (sin, cos) = SLANT.to_radians().sin_cos();
    let mut regions = Vec::new();
    for place in places {
        let middle = [0, 1].map(|i| view.middle()[i] + place[i]);
        let corner = |u: f64, v: f64| {
            let [u, v] = [u * side / 2.0, v * side / 2.0];
            view.chart_point([middle[0] + cos * u - sin * v, middle[1] + sin * u + cos * v])
        };
        let corners =
            [corner(-1.0, -1.0)?, corner(1.0, -1.0)?, corner(1.0, 1.0)?, corner(-1.0, 1.0)?];
        to.push(Patch {
            reflectance: Reflectance::Grey(reflectance),
            shape: PatchShape::Quad(corners),
        });
        let [length, across] = REGION.map(|share| share * side / 2.0);
        let region = |at: [f64; 2], half: [f64; 2]| {
            let low = [0, 1].map(|i| (at[i] - half[i] + 0.5).round().max(0.0) as u32);
            let high = [0, 1].map(|i| (at[i] + half[i] + 0.5).round() as u32);
            [low, [high[0].min(width), high[1].min(height)]]
        };
        let [x, y] = middle;
        // The middles of the edges.
        regions.push(region([x - cos * side / 2.0, y - sin * side / 2.0], [across, length]));
        regions.push(region([x + sin * side / 2.0, y - cos * side / 2.0], [length, across]));
    }
    Ok(regions)
}
