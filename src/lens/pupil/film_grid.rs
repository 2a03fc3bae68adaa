//! Regular grid over the film.

use super::CELLS;

/// A grid of cells over a film, about its centre.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FilmGrid {
    pub per_mm: [f32; 2],
    /// Half the width and half the height, mm.
    pub half: [f32; 2],
}

impl FilmGrid {
    pub fn new(half: [f64; 2]) -> Self {
        let per_mm = half.map(|half| (CELLS as f64 / (2.0 * half)) as f32);
        Self { per_mm, half: half.map(|half| half as f32) }
    }

    /// Returns the cell of a film point, along x and y, and the position of the point in it, 0 to
    /// 1.
    #[inline(always)]
    pub fn cell(&self, film: [f32; 2]) -> [(usize, f32); 2] {
        let split = |axis: usize| {
            let place = (film[axis] + self.half[axis]) * self.per_mm[axis];
            let place = place.clamp(0.0, CELLS as f32);
            let cell = (place as usize).min(CELLS - 1);
            (cell, place - cell as f32)
        };
        [split(0), split(1)]
    }

    /// Returns the corners of the cell around a film point, and their bilinear weights.
    pub fn corners(&self, film: [f32; 2]) -> [(usize, f32); 4] {
        let [(i, s), (j, t)] = self.cell(film);
        let corner = |i: usize, j: usize| j * (CELLS + 1) + i;
        [
            (corner(i, j), (1.0 - s) * (1.0 - t)),
            (corner(i + 1, j), s * (1.0 - t)),
            (corner(i, j + 1), (1.0 - s) * t),
            (corner(i + 1, j + 1), s * t),
        ]
    }
}
