//! Amplitudes of a pupil on a regular grid.

use super::ExitPupil;

/// A regular grid of square cells over the plane of T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilRaster {
    /// T of the middle of the first cell.
    pub first: [f64; 2],
    /// Side of a cell.
    pub step: f64,
    /// Cells along each side.
    pub side: usize,
}

impl ExitPupil {
    /// Returns the amplitudes of the cells of a grid, row by row: the mean along the horizontal
    /// line through the middle of each.
    pub fn raster(&self, PupilRaster { first, step, side }: PupilRaster) -> Vec<f64> {
        let mut amplitudes = vec![0.0; side * side];
        for (row, amplitudes) in amplitudes.chunks_exact_mut(side).enumerate() {
            let y = first[1] + step * row as f64;
            for edge in &self.edges {
                let ([x0, y0], [x1, y1]) = (edge.from, edge.to);
                if (y0 <= y) == (y1 <= y) {
                    continue;
                }
                let x = x0 + (x1 - x0) * (y - y0) / (y1 - y0);
                // To the right of an edge that rises lies its right side.
                let change = if y1 > y0 { -edge.step } else { edge.step };
                for (column, amplitude) in amplitudes.iter_mut().enumerate() {
                    let right = first[0] + step * (column as f64 + 0.5);
                    *amplitude += change * ((right - x) / step).clamp(0.0, 1.0);
                }
            }
        }
        // Rounding errors outside the pupil are no light.
        amplitudes.iter_mut().filter(|a| **a < 1e-9).for_each(|a| *a = 0.0);
        amplitudes
    }
}
