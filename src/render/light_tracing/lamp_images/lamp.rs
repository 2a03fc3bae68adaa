//! Lamp: an area light or a sky, with the sampling densities of its light paths.

use super::reach::EntryReach;
use crate::light_tracing::entry::EntryGrid;
use petzval_base::distribution::{DiscreteDistribution, Distribution};

/// Cells of the square of entry points.
pub(super) const ENTRY_GRID: EntryGrid = EntryGrid { side: 32 };
/// Share of the entry points that are uniform over the square, so that every path can be sampled.
const UNIFORM: f64 = 0.1;

/// An area light or a sky of the scene that light paths start from.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    /// Index of the light.
    pub light: u32,
    /// Probability that a light path starts from this lamp.
    pub share: f32,
    /// Sampling density of the entry points, over the square about the front vertex.
    pub entry: Distribution,
    /// Probability of each of its triangles, by area; one for a quadric or a sky.
    pub primitives: DiscreteDistribution,
    /// Where its light paths must enter to reach the rendered pixels; `None` in a whole picture, where
    /// most of them do.
    pub reach: Option<EntryReach>,
}

impl Lamp {
    /// Returns a lamp whose light may enter anywhere, with the areas of its triangles; `None` if they
    /// have none.
    pub fn seen_everywhere(light: u32, areas: &[f64]) -> Option<Self> {
        let primitives = DiscreteDistribution::new(areas)?;
        let entry = entry_distribution(&vec![1; ENTRY_GRID.cells()])?;
        Some(Self { light, share: 1.0, entry, primitives, reach: None })
    }

    /// Returns whether a light path that enters at a point of the square (0 to 1) is traced.
    pub fn is_traced(&self, entry: [f32; 2]) -> bool {
        self.reach.as_ref().is_none_or(|reach| reach.contains(entry))
    }
}

/// Returns the density of entry points: uniform over the cells in and next to which light came, and
/// small elsewhere.
pub(super) fn entry_distribution(arrivals: &[u32]) -> Option<Distribution> {
    let lit = |cell: usize| ENTRY_GRID.around(cell).any(|i| arrivals[i] > 0);
    let cells = ENTRY_GRID.cells();
    let count = (0..cells).filter(|&cell| lit(cell)).count();
    let uniform = UNIFORM / (1.0 - UNIFORM) * count as f64 / cells as f64;
    ENTRY_GRID.density(|cell| uniform + f64::from(u8::from(lit(cell))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entry_points_fall_near_the_arrivals_and_one_in_ten_anywhere() {
        let side = ENTRY_GRID.side;
        let mut arrivals = vec![0; side * side];
        arrivals[5 * side + 9] = 3;
        let entry = entry_distribution(&arrivals).expect("an arrival");
        let cell = |x: f64, y: f64| [x, y].map(|v| ((v + 0.5) / side as f64) as f32);
        let [inside, outside] = [cell(10.0, 6.0), cell(20.0, 6.0)].map(|uv| entry.density(uv));
        let cells = (side * side) as f32;
        assert!((outside - 0.1).abs() < 1e-3, "{outside}");
        assert!((inside / (0.1 + 0.9 * cells / 9.0) - 1.0).abs() < 1e-3, "{inside}");
    }
}
