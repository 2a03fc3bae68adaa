//! Choice between the reflection and the transmission of an interface.

use petzval_base::lanes::Real;

/// Lobes among which a direction is sampled, and how often each is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LobeChoice {
    /// Both, each in proportion to the light that it scatters.
    Both,
    /// Both, the fainter one more often: the interface of a body of glass.
    OfGlass,
    /// Both, the fainter one even more often: the outer side of a coat.
    OfCoat,
    /// Reflection alone.
    Reflection,
    /// Transmission alone.
    Transmission,
}

impl LobeChoice {
    /// Returns the probabilities of reflection and of transmission, for a reflectance.
    ///
    /// Glass reflects 4 % of the light, but the lamps and windows that it mirrors are often more than
    /// 25 times as bright as what lies behind. The probability therefore follows a power of the share
    /// of light: 3/4 for glass, 1/2 for coats. No sample then weighs more than 1.09 or 1.21. In the
    /// atelier (300 x 200, 96 samples) relative variance times CPU time falls 1.11 times with 3/4 for
    /// glass, and 1.07 times with 1/2: a path meets many interfaces of glass, but one coat.
    #[inline(always)]
    pub(super) fn chances<R: Real<Scalar = f32>>(self, reflectance: R) -> [R; 2] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let shares = [reflectance, one - reflectance];
        let powers = match self {
            Self::Both => return shares,
            Self::Reflection => return [one, zero],
            Self::Transmission => return [zero, one],
            Self::OfGlass => shares.map(|share| share.sqrt() * share.sqrt().sqrt()),
            Self::OfCoat => shares.map(|share| share.sqrt()),
        };
        let scale = one / (powers[0] + powers[1]);
        powers.map(|power| power * scale)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lobe_is_sampled_and_no_sample_weighs_much_more_than_1() {
        let tiny = [f32::MIN_POSITIVE, 1e-8, 1.0 - f32::EPSILON / 2.0];
        for reflectance in (0..=1000).map(|i| i as f32 / 1000.0).chain(tiny) {
            for (lobes, heaviest) in [(LobeChoice::OfGlass, 1.09), (LobeChoice::OfCoat, 1.21)] {
                let chances = lobes.chances(reflectance);
                let sum = chances[0] + chances[1];
                assert!((sum - 1.0).abs() < 1e-6, "{lobes:?}, {reflectance}: {chances:?}");
                for (share, chance) in [reflectance, 1.0 - reflectance].into_iter().zip(chances) {
                    assert_eq!(share > 0.0, chance > 0.0, "{lobes:?}, {reflectance}: {chances:?}");
                    assert!(share <= heaviest * chance, "{lobes:?}, {reflectance}: {chances:?}");
                }
            }
        }
    }
}
