//! Finder of the pupil's outline as a film point sees it.

use glam::DVec2;

use super::scan::{BoxSearch, PupilScan, rough_surfaces};
use crate::prescription::Prescription;

/// Directions from the centre of the pupil in which its edge is searched: over 180 degrees if the
/// other half is the mirror image, else over 360.
const DIRECTIONS: usize = 96;
/// Points along a direction in the first round, and in each refining round.
const ROUNDS: [usize; 3] = [24, 8, 8];
/// Columns and rows of the search grid.
const GRID: usize = 33;

/// A rectangle of pupil points, mm.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PupilBox {
    low: [f64; 2],
    high: [f64; 2],
}

impl PupilBox {
    pub fn around(points: &[[f64; 2]]) -> Self {
        let start = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        points.iter().fold(start, |pupil_box, point| Self {
            low: [0, 1].map(|i| pupil_box.low[i].min(point[i])),
            high: [0, 1].map(|i| pupil_box.high[i].max(point[i])),
        })
    }

    pub fn grown(self, by: [f64; 2]) -> Self {
        Self {
            low: [0, 1].map(|i| self.low[i] - by[i]),
            high: [0, 1].map(|i| self.high[i] + by[i]),
        }
    }

    pub fn moved(self, by: [f64; 2]) -> Self {
        Self {
            low: [0, 1].map(|i| self.low[i] + by[i]),
            high: [0, 1].map(|i| self.high[i] + by[i]),
        }
    }

    /// Returns its lowest corner.
    pub fn corner(self) -> [f64; 2] {
        self.low
    }

    pub fn centre(self) -> [f64; 2] {
        [0, 1].map(|i| (self.low[i] + self.high[i]) / 2.0)
    }

    pub fn size(self) -> [f64; 2] {
        [0, 1].map(|i| self.high[i] - self.low[i])
    }

    /// Returns the boxes that are larger on each side by these shares of its size. There are none if
    /// it is not finite: first-order optics gives no estimate for a telecentric lens.
    pub fn enlarged(self, by: [f64; 3]) -> impl Iterator<Item = Self> {
        let grown = move |by: f64| self.grown(self.size().map(|size| by * size));
        by.into_iter().map(grown).filter(|grown| grown.size().iter().all(|v| v.is_finite()))
    }

    /// Returns the box around it and its mirror image in v.
    pub fn mirrored(self) -> Self {
        let half = self.high[1].max(-self.low[1]);
        Self { low: [self.low[0], -half], high: [self.high[0], half] }
    }
}

/// The outline of the pupil for one film point.
#[derive(Clone, Debug)]
pub(crate) struct PupilOutline {
    pub bounds: PupilBox,
    /// A point inside the outline.
    pub centre: [f64; 2],
    /// Counter-clockwise around the centre, and relative to it.
    pub outline: Vec<[f64; 2]>,
}

/// Known symmetry of pupils.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PupilSymmetry {
    /// Symmetric in v: all film points lie on the u axis behind a round lens.
    Mirrored,
    /// No known symmetry.
    None,
}

/// Finds the pupil of film points by tracing rays.
#[derive(Clone)]
pub(crate) struct OutlineFinder {
    /// A scan of each lens.
    scans: Vec<PupilScan>,
    /// Whether the pupil of a film point is symmetric in v.
    mirrored: bool,
    /// Cosine and sine of the angle from the x axis of the lens to the u axis of all boxes and
    /// outlines.
    pub turn: [f64; 2],
}

impl OutlineFinder {
    /// Makes a finder of light that passes any of the lenses: one lens at several wavelengths.
    pub fn new<'a>(
        lenses: impl Iterator<Item = &'a Prescription>,
        distance: f64,
        symmetry: PupilSymmetry,
    ) -> Self {
        let scan = |lens| PupilScan::new(lens, distance, rough_surfaces(lens, distance));
        Self {
            scans: lenses.map(scan).collect(),
            mirrored: symmetry == PupilSymmetry::Mirrored,
            turn: [1.0, 0.0],
        }
    }

    /// Returns the outline for a film point (x, y, and z towards the scene from the plane of the
    /// untilted film). It searches around the expected box first, then everywhere inside `whole`.
    pub fn find(
        &mut self,
        film: [f64; 3],
        expected: PupilBox,
        whole: PupilBox,
    ) -> Option<PupilOutline> {
        let pupil_box = self.find_bounds(film, expected, whole)?;
        Some(self.outline(film, pupil_box))
    }

    /// Returns a tight box around that light.
    pub fn find_bounds(
        &mut self,
        film: [f64; 3],
        expected: PupilBox,
        whole: PupilBox,
    ) -> Option<PupilBox> {
        let mirrored = self.mirrored;
        let search = BoxSearch { points: GRID, margin: 1.0, mirrored };
        let mut starts = expected.enlarged([1.0, 5.0, 12.0]).chain([whole]);
        starts
            .find_map(|start| search.zoom(start, |grid| self.lit(film, grid.len(), |i| grid.at(i))))
    }

    /// Returns the edge of the light inside a box: the outermost lit point in every direction.
    fn outline(&mut self, film: [f64; 3], pupil_box: PupilBox) -> PupilOutline {
        let (middle, half) = (pupil_box.centre(), pupil_box.size().map(|size| size / 2.0));
        let turn = if self.mirrored { 1.0 } else { 2.0 };
        let count = if self.mirrored { DIRECTIONS / 2 + 1 } else { DIRECTIONS };
        let steps = if self.mirrored { DIRECTIONS / 2 } else { DIRECTIONS };
        let directions: Vec<[f64; 2]> = (0..count)
            .map(|k| {
                let (sin, cos) = (turn * std::f64::consts::PI * k as f64 / steps as f64).sin_cos();
                // Uniform in units of the box: a narrow pupil is resolved as well as a round one.
                let to_edge = 1.0 / cos.abs().max(sin.abs());
                [half[0] * cos * to_edge, half[1] * sin * to_edge]
            })
            .collect();
        // For every direction a lit and a dark position, relative to the box.
        let mut edges = vec![[0.0, 1.0]; count];
        for points in ROUNDS {
            let share = |edges: &[[f64; 2]], i: usize| {
                let [inner, outer] = edges[i / points];
                inner + (outer - inner) * (i % points + 1) as f64 / points as f64
            };
            let known = edges.clone();
            let lit = self.lit(film, count * points, |i| {
                let at = share(&known, i);
                [0, 1].map(|axis| middle[axis] + directions[i / points][axis] * at)
            });
            for k in 0..count {
                let last = (0..points).rev().find(|j| lit[k * points + j]);
                let step = |j: usize| share(&known, k * points + j);
                edges[k] = match last {
                    None => [known[k][0], step(0)],
                    Some(j) if j + 1 < points => [step(j), step(j + 1)],
                    Some(j) => [step(j), known[k][1]],
                };
            }
        }
        let mut outline: Vec<[f64; 2]> =
            (0..count).map(|k| directions[k].map(|d| d * edges[k][1])).collect();
        if self.mirrored {
            let lower = outline[1..count - 1].iter().rev().map(|&[u, v]| [u, -v]);
            let lower: Vec<_> = lower.collect();
            outline.extend(lower);
        }
        let outline = with_corners(&outline);
        PupilOutline { bounds: PupilBox::around(&outline).moved(middle), centre: middle, outline }
    }

    /// Returns through which points of the vertex plane a film point sees light.
    pub(super) fn lit(
        &mut self,
        film: [f64; 3],
        count: usize,
        at: impl Fn(usize) -> [f64; 2],
    ) -> Vec<bool> {
        let mut lit = vec![false; count];
        let [cos, sin] = self.turn;
        let turned = |[u, v]: [f64; 2]| [cos * u - sin * v, sin * u + cos * v];
        for scan in &mut self.scans {
            scan.trace(film, count, |i| turned(at(i)), |i, _| lit[i] = true);
        }
        lit
    }
}

/// Adds a corner between each two points of a closed outline, where the sides before and after them
/// meet. The light bulges out between points, and has a corner that no direction hits where the
/// rims of two surfaces cross.
fn with_corners(outline: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let count = outline.len();
    let at = |i: usize| DVec2::from(outline[i % count]);
    let mut all = Vec::with_capacity(2 * count);
    for i in 0..count {
        let (before, from, to, after) = (at(i + count - 1), at(i), at(i + 1), at(i + 2));
        let (one, other, side) = (from - before, to - after, to - from);
        let determinant = one.perp_dot(other);
        let [s, t] = [side.perp_dot(other), side.perp_dot(one)].map(|area| area / determinant);
        all.push(outline[i]);
        // An angle of more than 120 degrees is not a corner but a gap, or the point of a star.
        let near = |reach: f64| reach > 0.0 && reach <= side.length();
        if near(s * one.length()) && near(t * other.length()) {
            all.push((from + one * s).to_array());
        }
    }
    all
}
