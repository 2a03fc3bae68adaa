//! Sparse grids of voxels: bricks of eight voxels along each axis, where there are any.

use super::grid::Voxels;
use crate::rays::NO_INDEX;

/// Voxels of a brick along an axis.
const SIDE: u32 = 8;

/// A sparse grid. Voxels outside its bricks are 0.
#[derive(Clone, Debug)]
pub struct BrickGrid {
    resolution: [u32; 3],
    /// Numbers of bricks along the axes.
    bricks: [u32; 3],
    /// Index of every brick, x fastest, or [`NO_INDEX`].
    index: Box<[u32]>,
    /// Voxels of the bricks, x fastest.
    values: Vec<[f32; (SIDE * SIDE * SIDE) as usize]>,
}

impl BrickGrid {
    /// The grid of this resolution without bricks.
    pub fn empty(resolution: [u32; 3]) -> Self {
        let bricks = resolution.map(|n| n.div_ceil(SIDE));
        let count = bricks.iter().map(|&n| n as usize).product();
        Self { resolution, bricks, index: vec![NO_INDEX; count].into(), values: Vec::new() }
    }

    /// Returns the memory of an empty grid of a resolution (bytes).
    pub fn index_bytes(resolution: [u32; 3]) -> u64 {
        resolution.iter().map(|&n| u64::from(n.div_ceil(SIDE))).product::<u64>() * 4
    }

    /// Memory of a brick (bytes).
    pub const BRICK_BYTES: u64 = 4 * (SIDE * SIDE * SIDE) as u64;

    /// Sets a voxel, and adds its brick if it is not 0. Voxels outside the grid are left out.
    pub fn set(&mut self, voxel: [u32; 3], value: f32) {
        if (0..3).any(|axis| voxel[axis] >= self.resolution[axis]) {
            return;
        }
        let (brick, within) = self.place(voxel);
        if self.index[brick] == NO_INDEX {
            if value == 0.0 {
                return;
            }
            self.index[brick] = self.values.len() as u32;
            self.values.push([0.0; (SIDE * SIDE * SIDE) as usize]);
        }
        self.values[self.index[brick] as usize][within] = value;
    }

    /// Returns its memory (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&self.index[..]) + size_of_val(&self.values[..])
    }

    /// Returns the place of a voxel: its brick, and its index there.
    #[inline(always)]
    fn place(&self, [x, y, z]: [u32; 3]) -> (usize, usize) {
        let [bx, by, _] = self.bricks;
        let brick = ((z / SIDE) * by + y / SIDE) * bx + x / SIDE;
        let within = ((z % SIDE) * SIDE + y % SIDE) * SIDE + x % SIDE;
        (brick as usize, within as usize)
    }
}

impl Voxels for BrickGrid {
    type Value = f32;

    fn resolution(&self) -> [u32; 3] {
        self.resolution
    }

    #[inline(always)]
    fn value(&self, voxel: [u32; 3]) -> f32 {
        let (brick, within) = self.place(voxel);
        match self.index[brick] {
            NO_INDEX => 0.0,
            brick => self.values[brick as usize][within],
        }
    }
}
