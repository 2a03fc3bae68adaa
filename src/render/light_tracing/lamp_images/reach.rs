//! Reach of a lamp: where its light can enter the lens and arrive at the rendered pixels.
//!
//! A crop needs only the light paths that arrive in it. A sample number has the same paths in the crop
//! as in the whole picture, so that both have the same pixels; those that cannot reach the crop are
//! left out before they are traced. The reach is estimated from samples, with a margin. Camera paths
//! take the light of a cell beyond it, so that an error of the estimate is noise, not a bias.

use super::lamp::ENTRY_GRID;
use crate::film::Frame;
use crate::light_tracing::light_paths::LightPathInput;

/// Margin about the places where samples arrive, as a share of their extent.
const MARGIN: f64 = 0.5;
/// Margin beside that of the filter (pixels).
const MARGIN_PIXELS: f64 = 4.0;

/// Cells of the entry points from which light can reach the rendered pixels.
#[derive(Clone, Debug)]
pub(super) struct EntryReach {
    cells: Vec<bool>,
}

impl EntryReach {
    /// Returns whether no light of the lamp can reach the pixels.
    pub fn is_empty(&self) -> bool {
        !self.cells.contains(&true)
    }

    /// Returns whether light that enters at a point of the square (0 to 1) can reach the pixels.
    pub fn contains(&self, entry: [f32; 2]) -> bool {
        self.cells[ENTRY_GRID.cell(entry)]
    }
}

/// Places where the light of a lamp arrives in the plane of the film, by cell of its entry points.
#[derive(Clone, Debug)]
pub(super) struct ArrivalBounds {
    /// Smallest and largest position in the whole picture (pixels).
    cells: Vec<[[f64; 2]; 2]>,
}

const NOWHERE: [[f64; 2]; 2] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];

impl ArrivalBounds {
    pub fn new() -> Self {
        Self { cells: vec![NOWHERE; ENTRY_GRID.cells()] }
    }

    /// Adds a path that entered at a point of the square (0 to 1) and arrived at a film point (mm).
    pub fn add(&mut self, input: &LightPathInput<'_>, entry: [f32; 2], film: [f64; 2]) {
        let at = input.film_map().pixel(film);
        let cell = &mut self.cells[ENTRY_GRID.cell(entry)];
        *cell = union(*cell, [at; 2]);
    }

    /// Returns the cells from which light can reach the rendered pixels, by the arrivals of each and of
    /// its neighbours.
    pub fn reach(&self, input: &LightPathInput<'_>) -> EntryReach {
        let filter = input.response.filter.margin();
        let Frame { low, high, .. } = input.frame;
        let reaches = |cell: usize| {
            let near = ENTRY_GRID.around(cell).map(|i| self.cells[i]);
            let [first, last] = near.fold(NOWHERE, union);
            (0..2).all(|i| {
                let margin = MARGIN * (last[i] - first[i]) + filter[i] + MARGIN_PIXELS;
                first[i] - margin < f64::from(high[i]) && last[i] + margin > f64::from(low[i])
            })
        };
        EntryReach { cells: (0..self.cells.len()).map(reaches).collect() }
    }
}

fn union([a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [[a[0].min(c[0]), a[1].min(c[1])], [b[0].max(d[0]), b[1].max(d[1])]]
}
