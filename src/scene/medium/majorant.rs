//! Majorants: upper bounds of the extinction coefficient in the cells of a grid.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::field::Field;

/// Voxels along an axis that share a cell.
const VOXELS: u32 = 4;
/// Most cells along an axis.
const MAX_CELLS: u32 = 64;

/// Upper bounds of the extinction coefficient in the cells of the unit cube.
#[derive(Clone, Debug)]
pub struct MajorantGrid {
    /// Numbers of cells along the axes.
    pub(super) resolution: [u32; 3],
    /// Bounds, x fastest.
    values: Arc<[f32]>,
}

impl MajorantGrid {
    /// The bounds of a field.
    pub(super) fn new(field: &Field) -> Self {
        let resolution = field.resolution().map(|n| n.div_ceil(VOXELS).min(MAX_CELLS));
        let [nx, ny, nz] = resolution;
        let size = Vec3::from(resolution.map(|n| n as f32));
        let value = |i: u32| {
            let cell = [i % nx, i / nx % ny, i / (nx * ny)].map(|v| v as f32);
            let low = Vec3::from(cell);
            field.maximum([low / size, (low + 1.0) / size])
        };
        Self { resolution, values: (0..nx * ny * nz).into_par_iter().map(value).collect() }
    }

    /// The bounds times a factor.
    pub(super) fn scaled(&self, factor: f32) -> Self {
        let values = self.values.iter().map(|value| value * factor).collect();
        Self { resolution: self.resolution, values }
    }

    /// Returns the bound of a cell, 0 outside the cube.
    #[inline(always)]
    pub(super) fn at(&self, cell: [f32; 3]) -> f32 {
        let [nx, ny, nz] = self.resolution;
        let inside = (0..3).all(|axis| cell[axis] >= 0.0)
            && cell[0] < nx as f32
            && cell[1] < ny as f32
            && cell[2] < nz as f32;
        let [x, y, z] = cell.map(|v| v as usize);
        if inside { self.values[(z * ny as usize + y) * nx as usize + x] } else { 0.0 }
    }

    /// Returns its memory (bytes).
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.values[..])
    }
}
