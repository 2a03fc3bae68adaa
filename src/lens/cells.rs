//! A grid over a film.

use super::pupil::CELLS;

/// Cells over a film, around its own centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    pub per_mm: [f32; 2],
    /// Half the width and the height, mm.
    pub half: [f32; 2],
}

impl Cells {
    pub fn over(half: [f64; 2]) -> Self {
        let per_mm = half.map(|half| (CELLS as f64 / (2.0 * half)) as f32);
        Self { per_mm, half: half.map(|half| half as f32) }
    }

    /// The cell of a film point, along x and y, and where in it the point stands.
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

    /// The corners of the cell around a film point, and how much each counts.
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
