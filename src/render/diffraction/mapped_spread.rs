//! Point spreads of pupils that are affine images of one another.
//!
//! If T' = A T takes one pupil to another, the density of its light at an offset x is |det A| times that of
//! the first at A^T x: one table serves all fields of a lens whose iris alone bounds the pupil, which
//! changes its scale, along the radius more than across, and its orientation.

use std::f64::consts::TAU;

use glam::{DMat2, DVec2};
use petzval_base::lanes::f32x8;
use petzval_lens::ExitPupil;

use super::point_spread::{PointSpread, RATIO};

/// Directions in which outlines are compared.
const DIRECTIONS: usize = 48;
/// Largest distance of two outlines that count as the same, relative to the width of the pupil, and of
/// their areas.
const SAME_OUTLINE: f64 = 0.005;
const SAME_AREA: f64 = 0.01;
/// Offsets (fringes) at which densities are compared, and their largest difference relative to the centre.
const OFFSETS: [f64; 5] = [0.4, 0.8, 1.5, 3.0, 6.0];
const SAME_DENSITY: f64 = 0.005;
/// Largest rotation of a pupil that is searched for (rad), and steps of the search.
const TURN: f64 = 0.3;
const TURN_STEPS: usize = 24;

/// The pupil that a point spread was computed for, and the affine map from it to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct PupilShape {
    /// Index of the pupil with a table.
    pub base: usize,
    /// The map A.
    pub map: DMat2,
}

impl PupilShape {
    pub fn own(base: usize) -> Self {
        Self { base, map: DMat2::IDENTITY }
    }
}

/// A pupil, prepared for comparison with others.
#[derive(Clone, Debug)]
pub(super) struct Outline<'a> {
    pupil: &'a ExitPupil,
    /// Second moments about the centroid, over the integral of the amplitude.
    second: DMat2,
    /// Corners of the convex hull, relative to the centroid.
    hull: Vec<DVec2>,
}

impl<'a> Outline<'a> {
    pub fn new(pupil: &'a ExitPupil) -> Self {
        let (mut whole, mut first, mut second) = (0.0, DVec2::ZERO, DMat2::ZERO);
        // Sums over triangles from the origin to the edges.
        for edge in &pupil.edges {
            let [a, b] = [edge.from, edge.to].map(DVec2::from_array);
            let area = edge.step * a.perp_dot(b) / 2.0;
            whole += area;
            first += area * (a + b) / 3.0;
            let outer = |p: DVec2| DMat2::from_cols(p * p.x, p * p.y);
            second += (outer(a) + outer(b) + outer(a + b)) * (area / 12.0);
        }
        let centre = first / whole;
        let square = DMat2::from_cols(centre * centre.x, centre * centre.y);
        let points = pupil.edges.iter().map(|edge| DVec2::from_array(edge.from) - centre);
        Self { pupil, second: second * whole.recip() - square, hull: hull(points.collect()) }
    }

    pub fn pupil(&self) -> &'a ExitPupil {
        self.pupil
    }

    /// Returns the largest coordinate of the outline along a direction, from the centroid.
    fn support(&self, direction: DVec2) -> f64 {
        self.hull.iter().map(|at| at.dot(direction)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the affine map that takes this pupil to another; `None` if there is none. `tolerance` is
    /// relative to that of light that is spread near.
    pub fn map_to(&self, other: &Outline, tolerance: f64) -> Option<DMat2> {
        // The map takes the second moments to each other, which leaves a rotation.
        let (inner, outer) = (root(self.second)?.inverse(), root(other.second)?);
        let map = |turn: f64| outer * DMat2::from_angle(turn) * inner;
        let angle = |i: usize| TAU * i as f64 / DIRECTIONS as f64;
        let directions = || (0..DIRECTIONS).map(|i| DVec2::from_angle(angle(i)));
        let wanted: Vec<f64> = directions().map(|u| other.support(u)).collect();
        let off = |turn: f64| {
            let map = map(turn).transpose();
            let pairs = directions().zip(&wanted);
            pairs.map(|(u, wanted)| (self.support(map * u) - wanted).abs()).fold(0.0, f64::max)
        };
        let turn = least(off);
        let map = map(turn);
        let width = 2.0 * wanted.iter().fold(0.0, |a, &b| f64::max(a, b));
        let (from, to) = (self.pupil, other.pupil);
        let area = map.determinant().abs() * from.area / to.area;
        if off(turn) > tolerance * SAME_OUTLINE * width
            || (area - 1.0).abs() > tolerance * SAME_AREA
        {
            return None;
        }
        // In units of the wavelength.
        let centre = to.density([0.0; 2], 1.0);
        let same = (0..DIRECTIONS / 2).zip(OFFSETS.iter().cycle()).all(|(i, offset)| {
            let at = DVec2::from_angle(angle(i)) * *offset / width;
            let mapped = (map.transpose() * at).to_array();
            let found = map.determinant().abs() * from.density(mapped, 1.0);
            (found - to.density(at.to_array(), 1.0)).abs() < tolerance * SAME_DENSITY * centre
        });
        same.then_some(map)
    }
}

/// Returns the corners of the convex hull of points (Andrew 1979, "Another efficient algorithm for convex
/// hulls in two dimensions").
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut chain: Vec<DVec2> = Vec::new();
    let mut half = |points: &mut dyn Iterator<Item = &DVec2>| {
        let start = chain.len();
        for point in points {
            while let [.., a, b] = chain[start..]
                && (b - a).perp_dot(point - a) <= 0.0
            {
                chain.pop();
            }
            chain.push(*point);
        }
    };
    half(&mut points.iter());
    half(&mut points.iter().rev());
    chain
}

/// Returns the rotation (rad) that minimizes a function: a coarse search, then halved steps.
fn least(off: impl Fn(f64) -> f64) -> f64 {
    let mut step = 2.0 * TURN / TURN_STEPS as f64;
    let row = (0..=TURN_STEPS).map(|i| -TURN + step * i as f64).map(|turn| (off(turn), turn));
    // A round pupil has no orientation.
    let better = |best: (f64, f64), other: (f64, f64)| match other.0 < 0.98 * best.0 {
        true => other,
        false => best,
    };
    let mut best = row.fold((off(0.0), 0.0), better);
    for _ in 0..10 {
        step *= 0.5;
        let sides = [best.1 - step, best.1 + step].map(|turn| (off(turn), turn));
        best = sides.into_iter().fold(best, better);
    }
    best.1
}

/// Returns the symmetric square root of a symmetric matrix; `None` if it is not positive.
fn root(m: DMat2) -> Option<DMat2> {
    // Cayley and Hamilton: (M + sqrt(det M)) / sqrt(trace M + 2 sqrt(det M)).
    let s = m.determinant().sqrt();
    let t = (m.x_axis.x + m.y_axis.y + 2.0 * s).sqrt();
    (s > 0.0 && t > 0.0).then(|| (m + DMat2::from_diagonal(DVec2::splat(s))) * t.recip())
}

/// The point spread of an affine image of the pupil of a table.
#[derive(Clone, Copy, Debug)]
pub(super) struct MappedSpread<'a> {
    spread: &'a PointSpread,
    /// A^T.
    map: DMat2,
    /// |det A|.
    factor: f64,
}

impl<'a> MappedSpread<'a> {
    pub fn new(spread: &'a PointSpread, shape: &PupilShape) -> Self {
        Self { spread, map: shape.map.transpose(), factor: shape.map.determinant().abs() }
    }

    /// Returns the density, by channel [um^-2], at an offset from the point (um, the film's frame).
    pub fn at(&self, offset: [f64; 2]) -> [f64; 3] {
        self.spread.at((self.map * DVec2::from_array(offset)).to_array()).map(|v| self.factor * v)
    }

    /// Returns the densities at eight offsets, and a number without meaning.
    #[inline(always)]
    pub fn at_lanes(&self, [x, y]: [f32x8; 2]) -> [[f32; 4]; 8] {
        let DMat2 { x_axis, y_axis } = self.map;
        let [a, b, c, d] = [x_axis.x, y_axis.x, x_axis.y, y_axis.y].map(|v| f32x8::splat(v as f32));
        let there = self.spread.at_lanes([a * x + b * y, c * x + d * y]);
        there.map(|value| value.map(|v| self.factor as f32 * v))
    }

    /// Returns the share of the light, by channel, outside a rectangle of these half sizes (um) about
    /// the point.
    pub fn outside(&self, half: [f64; 2]) -> [f64; 3] {
        const SPOKES: usize = 1440;
        let mut sum = [0.0; 3];
        for spoke in 0..SPOKES {
            let direction = DVec2::from_angle(TAU / 2.0 * (spoke as f64 + 0.5) / SPOKES as f64);
            let mut radius = (half[0] / direction.x.abs()).min(half[1] / direction.y.abs());
            let last = self.spread.last() / (self.map * direction).length();
            while radius < last {
                let next = radius * RATIO;
                let middle = (radius + next) / 2.0;
                let there = self.at((middle * direction).to_array());
                sum = [0, 1, 2].map(|c| sum[c] + there[c] * middle * (next - radius));
                radius = next;
            }
            // The rest decays as the cube of the distance.
            let there = self.at((radius * direction).to_array());
            sum = [0, 1, 2].map(|c| sum[c] + there[c] * radius * radius);
        }
        sum.map(|sum| sum * TAU / SPOKES as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::lanes::Real as _;

    fn polygon(corners: usize, map: DMat2, shift: DVec2) -> ExitPupil {
        let corner = |i: usize| {
            let round = DVec2::from_angle(0.4 + TAU * i as f64 / corners as f64) * 0.05;
            (map * round + shift).to_array()
        };
        ExitPupil::polygon(&(0..corners).map(corner).collect::<Vec<_>>())
    }

    #[test]
    fn eight_lanes_have_the_densities_of_one() {
        let spread = PointSpread::new(
            &polygon(5, DMat2::IDENTITY, DVec2::ZERO),
            &petzval_spectrum::bands(),
            2000.0,
            5.0,
        );
        let shape = PupilShape { base: 0, map: DMat2::from_angle(0.2) * 1.3 };
        for shape in [PupilShape::own(0), shape] {
            let mapped = MappedSpread::new(&spread, &shape);
            for radius in [3.0f64, 40.0, 700.0, 9000.0] {
                let angle = |k: usize| TAU * k as f64 / 8.0;
                for turn in [0.0, 0.1, 0.7] {
                    let at = |k: usize| {
                        [radius * (angle(k) + turn).cos(), radius * (angle(k) + turn).sin()]
                    };
                    let lanes = [0, 1].map(|axis| {
                        f32x8::load(&std::array::from_fn::<f32, 8, _>(|k| at(k)[axis] as f32))
                    });
                    for (k, found) in mapped.at_lanes(lanes).into_iter().enumerate() {
                        let expected = mapped.at(at(k));
                        for c in 0..3 {
                            let off = f64::from(found[c]) / expected[c] - 1.0;
                            // Places in the table are rounded to f32.
                            assert!(off.abs() < 2e-3, "{radius}, {k}: {found:?}, not {expected:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_map_between_pupils_is_found() {
        let base = polygon(5, DMat2::IDENTITY, DVec2::ZERO);
        for (turn, scale) in [(0.0, [1.0, 1.0]), (0.1, [0.6, 0.9]), (-0.2, [1.3, 0.8])] {
            let map = DMat2::from_angle(turn) * DMat2::from_diagonal(DVec2::from_array(scale));
            let other = polygon(5, map, DVec2::new(0.1, -0.2));
            let found =
                Outline::new(&base).map_to(&Outline::new(&other), 1.0).expect("an affine image");
            let at = [20.0, -31.0];
            let mapped = (found.transpose() * DVec2::from_array(at)).to_array();
            let density = found.determinant().abs() * base.density(mapped, 1.0);
            let expected = other.density(at, 1.0);
            let centre = other.density([0.0; 2], 1.0);
            assert!((density - expected).abs() < 1e-3 * centre, "{density}, not {expected}");
        }
    }

    #[test]
    fn a_mapped_table_is_that_of_the_image() {
        let base = polygon(5, DMat2::IDENTITY, DVec2::ZERO);
        let map = DMat2::from_angle(0.25) * DMat2::from_diagonal(DVec2::new(0.6, 0.9));
        let other = polygon(5, map, DVec2::ZERO);
        let table = |pupil| PointSpread::new(pupil, &petzval_spectrum::bands(), 2000.0, 5.0);
        let (spread, expected) = (table(&base), table(&other));
        let mapped = MappedSpread::new(&spread, &PupilShape { base: 0, map });
        for (radius, turn) in [(4.0, 0.2), (9.0, 1.0), (9.0, 2.6), (20.0, 0.7), (20.0, 2.0)] {
            let at = (DVec2::from_angle(turn) * radius).to_array();
            let (found, expected) = (mapped.at(at), expected.at(at));
            for c in 0..3 {
                let off = found[c] / expected[c] - 1.0;
                assert!(off.abs() < 0.05, "{at:?}: {found:?}, not {expected:?}");
            }
        }
    }

    #[test]
    fn other_shapes_have_tables_of_their_own() {
        let base = polygon(5, DMat2::IDENTITY, DVec2::ZERO);
        for corners in [4, 6, 60] {
            let other = polygon(corners, DMat2::IDENTITY, DVec2::ZERO);
            assert!(Outline::new(&base).map_to(&Outline::new(&other), 1.0).is_none());
        }
        // A disk that lacks a part.
        let disk = polygon(200, DMat2::IDENTITY, DVec2::ZERO);
        let cut = |i: usize| {
            let at = DVec2::from_angle(TAU * i as f64 / 200.0) * 0.05;
            [at.x.min(0.035), at.y]
        };
        let cut = ExitPupil::polygon(&(0..200).map(cut).collect::<Vec<_>>());
        assert!(Outline::new(&disk).map_to(&Outline::new(&cut), 1.0).is_none());
        let narrow = polygon(200, DMat2::from_diagonal(DVec2::new(1.0, 0.7)), DVec2::ZERO);
        assert!(Outline::new(&disk).map_to(&Outline::new(&narrow), 1.0).is_some());
    }
}
