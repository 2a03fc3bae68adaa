//! Distortion and lateral colour from a picture of a grid of dots.

use petzval_base::least_squares::least_squares;
use petzval_base::plane_newton::PlaneNewton;
use petzval_image::Picture;

use super::dots::{Dot, find_dots};
use super::grid_order::order;

/// Least number of dots along both directions of the grid, and of all.
const MIN_LINE: i32 = 5;
const MIN_DOTS: usize = 25;
/// Largest RMS distance of dots from the polynomial of the distortion, relative to the step.
const MAX_RESIDUAL: f64 = 0.03;
/// Largest share of the dots that stand between the columns and rows.
const MAX_STRAY: f64 = 0.2;

/// Why a grid cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// Too few dots were found.
    #[error(
        "{found} dark dots, of which {columns} x {rows} form a grid about the middle of the picture; expected {MIN_LINE} x \
         {MIN_LINE} or more on a bright ground, each of 3 pixels or more, as of petzval chart grid"
    )]
    Few {
        /// Dots.
        found: usize,
        /// Columns of the grid.
        columns: i32,
        /// Rows of the grid.
        rows: i32,
    },
    /// Dots stand between columns and rows.
    #[error(
        "{stray} of {found} dark dots stand in no column and row of the grid; expected a square grid of dots, and nothing \
         else that is dark"
    )]
    Stray {
        /// Dots that have no place in the grid.
        stray: usize,
        /// Dots.
        found: usize,
    },
    /// No polynomial describes the places of the dots.
    #[error(
        "dots are {residual:.2} pixels (RMS) from the polynomial of the distortion; expected {most:.2} or less: sharper dots \
         of a plane chart"
    )]
    Irregular {
        /// RMS distance (pixels).
        residual: f64,
        /// Largest one that is accepted (pixels).
        most: f64,
    },
    /// The grid does not reach the middle of the picture.
    #[error(
        "the middle of the picture lies outside the grid of dots; expected one that fills the picture"
    )]
    Outside,
}

/// A dot of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridDot {
    /// Column and row from the dot nearest to the middle of the picture.
    pub index: [i32; 2],
    /// Its centroid in green (pixels; the centre of the first is at 0).
    pub at: [f64; 2],
    /// Centroids in red and in blue less that in green (pixels).
    pub colour: [[f64; 2]; 2],
    /// Its distance from the middle of the picture relative to that without distortion, less 1.
    pub distortion: f64,
}

/// A grid of dots in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct DotGrid {
    /// Dots, by row and column.
    pub dots: Vec<GridDot>,
    /// The middle of the picture (pixels).
    pub middle: [f64; 2],
    /// Steps from column to column and from row to row in the middle of the picture (pixels).
    pub steps: [[f64; 2]; 2],
    /// Root mean square distance of the dots from the polynomial of the distortion (pixels).
    pub residual: f64,
}

impl DotGrid {
    /// Measures the grid of dark dots in a picture.
    ///
    /// # Errors
    /// Returns an error if the dots are too few, form no regular grid, or are all beside the middle of the picture.
    pub fn measure(picture: &Picture) -> Result<Self, GridError> {
        let found = find_dots(picture);
        let indices = order(&found, picture.size);
        let reach = |axis: usize| {
            let of = indices.iter().map(|(index, _)| index[axis]);
            of.clone().max().zip(of.min()).map_or(0, |(last, first)| last - first + 1)
        };
        let [columns, rows] = [reach(0), reach(1)];
        if columns.min(rows) < MIN_LINE || indices.len() < MIN_DOTS {
            return Err(GridError::Few { found: found.len(), columns, rows });
        }
        let stray = found.len() - indices.len();
        if stray as f64 > MAX_STRAY * found.len() as f64 {
            return Err(GridError::Stray { stray, found: found.len() });
        }
        let bounds = [0, 1].map(|axis| {
            let of = indices.iter().map(|(index, _)| f64::from(index[axis]));
            [of.clone().fold(f64::MAX, f64::min), of.fold(f64::MIN, f64::max)]
        });
        let middle = picture.size.map(|n| (n as f64 - 1.0) / 2.0);
        let (grid, centre) = Self::of(indices, middle).ok_or(GridError::Outside)?;
        if !(0..2).all(|axis| (bounds[axis][0]..=bounds[axis][1]).contains(&centre[axis])) {
            return Err(GridError::Outside);
        }
        let most = MAX_RESIDUAL * grid.steps[0][0].hypot(grid.steps[0][1]);
        match grid.residual <= most {
            true => Ok(grid),
            false => Err(GridError::Irregular { residual: grid.residual, most }),
        }
    }

    /// Fits the distortion of dots: a polynomial of their places in the grid, odd about the middle but for keystone.
    /// Returns also the place in the grid that the middle of the picture shows; `None` if it shows none.
    fn of(mut dots: Vec<([i32; 2], Dot)>, middle: [f64; 2]) -> Option<(Self, [f64; 2])> {
        dots.sort_by_key(|([column, row], _)| [*row, *column]);
        let places: Vec<[f64; 2]> = dots.iter().map(|(index, _)| index.map(f64::from)).collect();
        let columns: Vec<Vec<f64>> =
            (0..TERMS).map(|k| places.iter().map(|&place| terms(place)[k]).collect()).collect();
        let sides = [0, 1].map(|axis| dots.iter().map(|(_, dot)| dot.at[axis]).collect::<Vec<_>>());
        let fit = least_squares(columns, sides.to_vec());
        let at = |place: [f64; 2]| {
            [0, 1].map(|axis| terms(place).iter().zip(&fit[axis]).map(|(t, c)| t * c).sum::<f64>())
        };
        let newton = PlaneNewton { difference: 1e-3, precision: 1e-9, acceptable: 1e-6 };
        let centre = newton
            .solve([0.0; 2], |place| Some([0, 1].map(|axis| at(place)[axis] - middle[axis])))?;
        let steps = steps_at(&at, centre);
        let mut squares = 0.0;
        let dots: Vec<GridDot> = dots
            .into_iter()
            .zip(&places)
            .map(|((index, dot), place)| {
                let fitted = at(*place);
                squares += (fitted[0] - dot.at[0]).powi(2) + (fitted[1] - dot.at[1]).powi(2);
                let [u, v] = [place[0] - centre[0], place[1] - centre[1]];
                let ideal = [0, 1].map(|axis| u * steps[0][axis] + v * steps[1][axis]);
                let seen = [0, 1].map(|axis| dot.at[axis] - middle[axis]);
                let length = ideal[0].hypot(ideal[1]);
                // Near the middle there is no distortion to tell.
                let near = 0.5 * steps[0][0].hypot(steps[0][1]);
                let distortion =
                    if length < near { 0.0 } else { seen[0].hypot(seen[1]) / length - 1.0 };
                GridDot { index, at: dot.at, colour: dot.colour, distortion }
            })
            .collect();
        let residual = (squares / dots.len() as f64).sqrt();
        Some((Self { dots, middle, steps, residual }, centre))
    }

    /// Returns the dot that is farthest from the middle of the picture.
    pub fn farthest(&self) -> &GridDot {
        let radius = |dot: &GridDot| self.radius(dot);
        let farther = |best, dot| if radius(dot) > radius(best) { dot } else { best };
        self.dots.iter().fold(&self.dots[0], farther)
    }

    /// Returns the distance of a dot from the middle of the picture (pixels).
    pub fn radius(&self, dot: &GridDot) -> f64 {
        (dot.at[0] - self.middle[0]).hypot(dot.at[1] - self.middle[1])
    }

    /// Returns how much farther red and blue show a dot from the middle than green (pixels).
    pub fn lateral_colour(&self, dot: &GridDot) -> [f64; 2] {
        let radius = self.radius(dot).max(f64::MIN_POSITIVE);
        let outwards = [0, 1].map(|axis| (dot.at[axis] - self.middle[axis]) / radius);
        dot.colour.map(|[x, y]| x * outwards[0] + y * outwards[1])
    }
}

/// Number of terms of the polynomial.
const TERMS: usize = 12;

/// Returns the terms of the polynomial at a place of the grid.
fn terms([u, v]: [f64; 2]) -> [f64; TERMS] {
    // Near 1 at the border, which keeps the columns of the fit apart.
    let [u, v] = [u / 10.0, v / 10.0];
    let r = u * u + v * v;
    [
        1.0,
        u,
        v,
        u * u,
        u * v,
        v * v,
        u * r,
        v * r,
        u * r * r,
        v * r * r,
        u * r * r * r,
        v * r * r * r,
    ]
}

/// Returns the steps of a map from column to column and from row to row at a place.
fn steps_at(at: &impl Fn([f64; 2]) -> [f64; 2], [u, v]: [f64; 2]) -> [[f64; 2]; 2] {
    let h = 0.05;
    let difference = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|i| (b[i] - a[i]) / (2.0 * h));
    [difference(at([u - h, v]), at([u + h, v])), difference(at([u, v - h]), at([u, v + h]))]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [400, 300];
    const STEP: f64 = 28.0;
    /// Barrel distortion: the grid's place of a pixel grows by this share of the squared radius, in halves of the
    /// shorter side.
    const BARREL: f64 = 0.03;
    /// Size of red and of blue relative to green.
    const COLOUR: [f64; 3] = [1.002, 1.0, 0.997];

    /// Returns the place in the grid that a point of the picture shows in a channel. The grid is turned by 7 degrees.
    fn place(point: [f64; 2], channel: usize) -> [f64; 2] {
        let [x, y] = [0, 1].map(|i| (point[i] - (SIZE[i] as f64 - 1.0) / 2.0) / COLOUR[channel]);
        let r = x.hypot(y) / 150.0;
        let scale = (1.0 + BARREL * r * r) / STEP;
        let (sin, cos) = 7.0_f64.to_radians().sin_cos();
        [scale * (cos * x + sin * y), scale * (cos * y - sin * x)]
    }

    /// Draws dots of a grid in light that falls off, without those for which `is_there` is false.
    fn draw(is_there: impl Fn([f64; 2]) -> bool) -> Picture {
        let points = 8;
        let value = |x: usize, y: usize, channel: usize| {
            let mut sum = 0.0;
            for i in 0..points * points {
                let offset = |k: usize| (k as f64 + 0.5) / points as f64 - 0.5;
                let at = [x as f64 + offset(i % points), y as f64 + offset(i / points)];
                let [u, v] = place(at, channel);
                let dot = [u.round(), v.round()];
                let is_dark = (u - dot[0]).hypot(v - dot[1]) < 1.0 / 6.0 && is_there(dot);
                sum += if is_dark { 0.04 } else { 1.0 };
            }
            let falloff = 1.0 - 0.3 * (x as f64 / SIZE[0] as f64).powi(2);
            (falloff * sum / (points * points) as f64) as f32
        };
        let pixel = |i: usize| [0, 1, 2].map(|c| value(i % SIZE[0], i / SIZE[0], c));
        Picture { size: SIZE, pixels: (0..SIZE[0] * SIZE[1]).map(pixel).collect() }
    }

    #[test]
    fn distortion_and_lateral_colour_are_those_of_the_picture() {
        // Some dots are missing.
        let grid = DotGrid::measure(&draw(|[u, v]| [u, v] != [2.0, 1.0] && u != -4.0)).unwrap();
        assert!(grid.dots.len() > 80, "{}", grid.dots.len());
        assert!(grid.residual < 0.01, "{}", grid.residual);
        let [[x, y], [_, down]] = grid.steps;
        assert!((x.hypot(y) - STEP).abs() < 0.02 && down > 0.0, "{:?}", grid.steps);
        assert!((y.atan2(x).to_degrees() - 7.0).abs() < 0.05, "{:?}", grid.steps);
        for dot in &grid.dots {
            let [u, v] = place(dot.at, 1);
            let [column, row] = dot.index.map(f64::from);
            let off = (u - column).hypot(v - row) * STEP;
            assert!(off < 0.03, "{dot:?}: {off} pixels");
            let radius = grid.radius(dot);
            if radius > STEP {
                let barrel = 1.0 / (1.0 + BARREL * (radius / 150.0).powi(2)) - 1.0;
                assert!((dot.distortion - barrel).abs() < 1e-3, "{dot:?}, not {barrel}");
            }
            let [red, blue] = grid.lateral_colour(dot);
            assert!((red - 0.002 * radius).abs() < 0.03, "{dot:?}: {red}");
            assert!((blue + 0.003 * radius).abs() < 0.03, "{dot:?}: {blue}");
        }
        assert!(grid.farthest().distortion < -0.05, "{}", grid.farthest().distortion);
    }

    #[test]
    fn a_missing_neighbour_of_the_middle_does_not_change_the_grid() {
        let whole = DotGrid::measure(&draw(|_| true)).unwrap();
        for gap in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, 0.0]] {
            let grid = DotGrid::measure(&draw(|dot| dot != gap)).unwrap();
            assert_eq!(grid.dots.len(), whole.dots.len() - 1, "{gap:?}");
            assert!((grid.steps[0][0] - whole.steps[0][0]).abs() < 0.05, "{:?}", grid.steps);
        }
    }

    #[test]
    fn grids_beside_the_middle_are_refused() {
        for side in [-1.0, 1.0] {
            let beside = DotGrid::measure(&draw(|[u, _]| side * u > 1.0)).unwrap_err().to_string();
            assert!(beside.contains("middle of the picture lies outside"), "{beside}");
        }
    }

    #[test]
    fn pictures_without_a_grid_are_refused() {
        let few = DotGrid::measure(&draw(|[u, v]| u.abs() < 2.0 && v.abs() < 2.0)).unwrap_err();
        assert!(few.to_string().starts_with("9 dark dots, of which 3 x 3 form a grid"), "{few}");
        for value in [0.0, 1.0, -1.0, 1e30] {
            let plain = Picture { size: [60, 40], pixels: vec![[value; 3]; 2400] };
            assert!(DotGrid::measure(&plain).is_err());
        }
        for size in [[0, 0], [1, 1], [3, 1]] {
            let tiny = Picture { size, pixels: vec![[0.5; 3]; size[0] * size[1]] };
            assert!(DotGrid::measure(&tiny).is_err());
        }
        // Noise has dots, and no grid of them.
        let noise = |i: usize| {
            let mix = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
            [(mix as f32 / (1 << 24) as f32).powi(3); 3]
        };
        let noise = Picture { size: [200, 150], pixels: (0..30_000).map(noise).collect() };
        assert!(DotGrid::measure(&noise).is_err());
    }
}
