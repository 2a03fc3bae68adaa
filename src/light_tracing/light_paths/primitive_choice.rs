//! Choice of a triangle of a mesh.

/// Choice of a triangle in proportion to its area.
#[derive(Clone, Debug)]
pub(crate) struct PrimitiveChoice {
    cumulative: Vec<f32>,
}

impl PrimitiveChoice {
    /// Prepares the choice; `None` if no triangle has an area.
    pub fn new(areas: &[f64]) -> Option<Self> {
        let total: f64 = areas.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut sum = 0.0;
        let mut cumulative: Vec<f32> = areas
            .iter()
            .map(|area| {
                sum += area;
                (sum / total) as f32
            })
            .collect();
        // Rounding must leave no gap at the end.
        let last = areas.iter().rposition(|&area| area > 0.0).unwrap_or(0);
        cumulative[last..].fill(1.0);
        Some(Self { cumulative })
    }

    /// Returns the triangle that a number in [0, 1) selects.
    pub fn choose(&self, u: f32) -> u32 {
        let i = self.cumulative.partition_point(|&sum| sum <= u);
        i.min(self.cumulative.len() - 1) as u32
    }

    /// Returns the probability of a triangle.
    pub fn probability(&self, primitive: u32) -> f32 {
        let i = primitive as usize;
        let below = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        self.cumulative.get(i).map_or(0.0, |sum| sum - below)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_are_chosen_by_their_areas() {
        let choice = PrimitiveChoice::new(&[1.0, 0.0, 2.0, 1.0, 0.0]).expect("areas above 0");
        for (u, expected) in [(0.0, 0), (0.24, 0), (0.25, 2), (0.74, 2), (0.76, 3), (0.999_999, 3)]
        {
            assert_eq!(choice.choose(u), expected, "{u}");
        }
        let all: Vec<f32> = (0..6).map(|i| choice.probability(i)).collect();
        assert_eq!(all, [0.25, 0.0, 0.5, 0.25, 0.0, 0.0]);
        assert!(PrimitiveChoice::new(&[0.0; 3]).is_none());
    }
}
