//! The 24 patches of a colour checker, in four rows of six.

use super::patch::{Patch, PatchShape, Reflectance};
use super::view::{ChartError, ChartView};

/// Columns and rows of patches.
pub(crate) const GRID: [usize; 2] = [6, 4];
/// Distance between patches relative to their side: that of the ColorChecker, as ArgyllCMS has measured one
/// (ColorChecker.cht).
const GAP: f64 = 0.14;
/// Least shorter side of a picture with patches (pixels), which have a tenth of it then.
const LEAST: u32 = 120;
/// Share of the picture that the patches fill in the direction in which it is tight.
const FILL: f64 = 0.8;

/// Returns the sides of a region of patches, relative to that of a patch.
fn sides() -> [f64; 2] {
    GRID.map(|n| n as f64 * (1.0 + GAP) - GAP)
}

/// Returns the borders of a patch in a region of patches, row after row: the share of its sides before `from` and up to
/// `to` is between them.
pub(crate) fn patch_borders(
    region: [[f64; 2]; 2],
    patch: usize,
    [from, to]: [f64; 2],
) -> [[f64; 2]; 2] {
    let [low, high] = region;
    let place = [patch % GRID[0], patch / GRID[0]];
    let at = |share: f64| {
        [0, 1].map(|i| {
            let side = (high[i] - low[i]) / sides()[i];
            low[i] + side * (place[i] as f64 * (1.0 + GAP) + share)
        })
    };
    [at(from), at(to)]
}

/// Adds the patches, and returns the region of the picture that they fill (pixels).
pub(super) fn colours(
    view: &ChartView<'_>,
    to: &mut Vec<Patch>,
) -> Result<[[u32; 2]; 2], ChartError> {
    view.check_size(LEAST)?;
    let resolution = view.resolution();
    let side = [0, 1].map(|i| FILL * f64::from(resolution[i]) / sides()[i]);
    let side = side[0].min(side[1]);
    let size = [0, 1].map(|i| (side * sides()[i]).round() as u32);
    let low = [0, 1].map(|i| (resolution[i] - size[i]) / 2);
    let region = [low, [0, 1].map(|i| low[i] + size[i])];
    // The centre of the first pixel is at 0.
    let borders = region.map(|at| at.map(|n| f64::from(n) - 0.5));
    for patch in 0..GRID[0] * GRID[1] {
        let [[left, top], [right, bottom]] = patch_borders(borders, patch, [0.0, 1.0]);
        let corners = [[left, bottom], [right, bottom], [right, top], [left, top]];
        let mut points = [[0.0; 2]; 4];
        for (point, corner) in points.iter_mut().zip(corners) {
            *point = view.chart_point(corner)?;
        }
        to.push(Patch {
            reflectance: Reflectance::OfChecker(patch),
            shape: PatchShape::Quad(points),
        });
    }
    Ok(region)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_fill_their_region_row_after_row() {
        let region = [[10.0, 20.0], [681.0, 463.0]];
        let first = patch_borders(region, 0, [0.0, 1.0]);
        let last = patch_borders(region, 23, [0.0, 1.0]);
        assert_eq!(first[0], region[0]);
        assert!((0..2).all(|i| (last[1][i] - region[1][i]).abs() < 1e-9), "{last:?}");
        let [low, high] = patch_borders(region, 7, [0.25, 0.75]);
        let side = (first[1][0] - first[0][0], first[1][1] - first[0][1]);
        assert!((high[0] - low[0] - side.0 / 2.0).abs() < 1e-9);
        assert!(
            (low[0] - 10.0 - side.0 * 1.39).abs() < 1e-9
                && (low[1] - 20.0 - side.1 * 1.39).abs() < 1e-9
        );
    }
}
