//! Absorption inside glass: what its maker measured.

use std::sync::Arc;

/// Least internal transmittance that is told from none: tables state three decimals, and 0 below.
const LEAST: f64 = 1e-4;

/// Internal transmittance of a glass at one wavelength: without the reflections at its faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InternalTransmittance {
    /// Wavelength (nm).
    pub nm: f64,
    /// Share of the light that passes, from 0 to 1.
    pub share: f64,
    /// Path length (mm).
    pub thickness: f64,
}

impl InternalTransmittance {
    /// Returns whether it can have been measured.
    pub fn is_valid(&self) -> bool {
        let Self { nm, share, thickness } = *self;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        positive(nm) && positive(thickness) && (0.0..=1.0).contains(&share)
    }

    /// Returns the absorption coefficient a (1/mm) of the share e^(-a thickness) (Lambert 1760).
    fn coefficient(&self) -> f64 {
        -self.share.max(LEAST).ln() / self.thickness
    }
}

/// Absorption of a glass by wavelength. It is 0 without data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Absorption {
    /// Measurements by ascending wavelength.
    measured: Arc<[InternalTransmittance]>,
    /// First line of the catalogue that states no internal transmittance, from 1, and the number of
    /// such lines.
    pub unusable: Option<[usize; 2]>,
}

impl Absorption {
    /// Takes the valid measurements, in any order. At each wavelength the longest path is the most exact,
    /// unless no light is left.
    pub fn new(mut measured: Vec<InternalTransmittance>) -> Self {
        measured.retain(InternalTransmittance::is_valid);
        let length = |entry: &InternalTransmittance| match entry.share > 0.0 {
            true => entry.thickness,
            false => 0.0,
        };
        measured.sort_by(|a, b| a.nm.total_cmp(&b.nm).then(length(b).total_cmp(&length(a))));
        measured.dedup_by_key(|entry| entry.nm);
        Self { measured: measured.into(), unusable: None }
    }

    /// Returns the measurements by ascending wavelength.
    pub fn measured(&self) -> &[InternalTransmittance] {
        &self.measured
    }

    /// Returns the absorption coefficient (1/mm) at a wavelength (nm): linear between two entries,
    /// and that of the nearer end beyond them.
    pub fn coefficient(&self, nm: f64) -> f64 {
        let after = self.measured.partition_point(|entry| entry.nm <= nm);
        match (self.measured.get(after.wrapping_sub(1)), self.measured.get(after)) {
            (Some(low), Some(high)) => {
                let share = (nm - low.nm) / (high.nm - low.nm);
                let [low, high] = [low, high].map(InternalTransmittance::coefficient);
                low + share * (high - low)
            }
            (Some(end), None) | (None, Some(end)) => end.coefficient(),
            (None, None) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(entries: &[[f64; 3]]) -> Absorption {
        let entry =
            |&[nm, share, thickness]: &[f64; 3]| InternalTransmittance { nm, share, thickness };
        Absorption::new(entries.iter().map(entry).collect())
    }

    #[test]
    fn the_share_falls_with_the_way_as_lambert_says() {
        let glass = measured(&[[400.0, 0.9, 10.0], [500.0, 0.81, 20.0]]);
        let expected = -0.9f64.ln() / 10.0;
        for nm in [1.0, 400.0, 450.0, 500.0, 9e9] {
            assert!((glass.coefficient(nm) - expected).abs() < 1e-12, "{nm}");
        }
    }

    #[test]
    fn entries_may_come_in_any_order_and_the_longest_way_counts() {
        let sorted = measured(&[[400.0, 0.5, 10.0], [500.0, 0.8, 10.0], [600.0, 1.0, 10.0]]);
        let other = measured(&[
            [600.0, 1.0, 10.0],
            [500.0, 0.9, 5.0],
            [500.0, 0.8, 10.0],
            [400.0, 0.5, 10.0],
            [500.0, 0.1, 1.0],
        ]);
        assert_eq!(sorted, other);
        assert_eq!(sorted.coefficient(600.0), 0.0);
        let middle = 0.5 * (sorted.coefficient(400.0) + sorted.coefficient(500.0));
        assert!((sorted.coefficient(450.0) - middle).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_have_been_measured_does_not_count() {
        for entry in [
            [400.0, 1.01, 10.0],
            [400.0, -999.0, 10.0],
            [400.0, f64::NAN, 10.0],
            [400.0, 0.5, 0.0],
            [400.0, 0.5, f64::INFINITY],
            [0.0, 0.5, 10.0],
        ] {
            let glass = measured(&[entry]);
            assert!(glass.measured().is_empty(), "{entry:?}");
            assert_eq!(glass.coefficient(400.0), 0.0);
        }
        // Opaque, and still a number.
        let opaque = measured(&[[400.0, 0.0, 10.0]]).coefficient(400.0);
        assert!(opaque > 0.9 && opaque < 1.0, "{opaque}");
    }
}
