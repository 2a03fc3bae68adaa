//! Patches in rows and columns: a colour checker, and steps of grey.

use super::patch::{Patch, PatchShape, Reflectance};
use super::view::{ChartError, ChartView};

/// Distance between patches relative to their side: that of the ColorChecker, as ArgyllCMS has measured one
/// (ColorChecker.cht).
const GAP: f64 = 0.14;
/// Least shorter side of a picture with patches (pixels), which have a tenth of it then.
const LEAST: u32 = 120;
/// Share of the picture that the patches fill in the direction in which it is tight.
const FILL: f64 = 0.8;

/// Columns and rows of patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PatchGrid([usize; 2]);

impl PatchGrid {
    /// The 24 patches of the ColorChecker.
    pub const COLOURS: Self = Self([6, 4]);
    /// The 20 steps of [`grey_reflectance`].
    pub const GREYS: Self = Self([5, 4]);

    /// Returns the number of patches.
    pub fn len(self) -> usize {
        self.0[0] * self.0[1]
    }

    /// Returns row and column of a patch, from 0.
    pub fn place(self, patch: usize) -> [usize; 2] {
        [patch / self.0[0], patch % self.0[0]]
    }

    /// Returns the sides of a region of patches, relative to that of a patch.
    fn sides(self) -> [f64; 2] {
        self.0.map(|n| n as f64 * (1.0 + GAP) - GAP)
    }

    /// Returns the borders of a patch in a region of patches, row after row: the share of its sides before `from` and up
    /// to `to` is between them.
    pub fn borders(
        self,
        region: [[f64; 2]; 2],
        patch: usize,
        [from, to]: [f64; 2],
    ) -> [[f64; 2]; 2] {
        let [low, high] = region;
        let [row, column] = self.place(patch);
        let place = [column, row];
        let at = |share: f64| {
            [0, 1].map(|i| {
                let side = (high[i] - low[i]) / self.sides()[i];
                low[i] + side * (place[i] as f64 * (1.0 + GAP) + share)
            })
        };
        [at(from), at(to)]
    }

    /// Adds the patches, and returns the region of the picture that they fill (pixels).
    pub(super) fn draw(
        self,
        view: &ChartView<'_>,
        reflectance: fn(usize) -> Reflectance,
        to: &mut Vec<Patch>,
    ) -> Result<[[u32; 2]; 2], ChartError> {
        view.check_size(LEAST)?;
        let (resolution, sides) = (view.resolution(), self.sides());
        let side = [0, 1].map(|i| FILL * f64::from(resolution[i]) / sides[i]);
        let side = side[0].min(side[1]);
        let size = sides.map(|n| (side * n).round() as u32);
        let low = [0, 1].map(|i| (resolution[i] - size[i]) / 2);
        let region = [low, [0, 1].map(|i| low[i] + size[i])];
        // The centre of the first pixel is at 0.
        let borders = region.map(|at| at.map(|n| f64::from(n) - 0.5));
        for patch in 0..self.len() {
            let corners = view.corners(self.borders(borders, patch, [0.0, 1.0]))?;
            to.push(Patch { reflectance: reflectance(patch), shape: PatchShape::Quad(corners) });
        }
        Ok(region)
    }
}

/// Returns the reflectance of a step of grey: densities in steps of 0.2 from white on, 12.6 stops in all.
pub(crate) fn grey_reflectance(step: usize) -> f64 {
    0.9 * 10.0_f64.powf(-0.2 * step as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_fill_their_region_row_after_row() {
        let grid = PatchGrid::COLOURS;
        let region = [[10.0, 20.0], [681.0, 463.0]];
        let first = grid.borders(region, 0, [0.0, 1.0]);
        let last = grid.borders(region, 23, [0.0, 1.0]);
        assert_eq!(first[0], region[0]);
        assert!((0..2).all(|i| (last[1][i] - region[1][i]).abs() < 1e-9), "{last:?}");
        let [low, high] = grid.borders(region, 7, [0.25, 0.75]);
        let side = (first[1][0] - first[0][0], first[1][1] - first[0][1]);
        assert!((high[0] - low[0] - side.0 / 2.0).abs() < 1e-9);
        assert!(
            (low[0] - 10.0 - side.0 * 1.39).abs() < 1e-9
                && (low[1] - 20.0 - side.1 * 1.39).abs() < 1e-9
        );
    }

    #[test]
    fn greys_reach_over_twelve_stops() {
        let last = PatchGrid::GREYS.len() - 1;
        let stops = (grey_reflectance(0) / grey_reflectance(last)).log2();
        assert!((stops - 12.62).abs() < 0.01, "{stops}");
    }
}
