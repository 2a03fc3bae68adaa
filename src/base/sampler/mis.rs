//! Multiple importance sampling: the power heuristic (Veach 1997, "Robust Monte Carlo methods for
//! light transport simulation", section 9.2.4).
//!
//! A sample that a technique has drawn with density `mine`, and that one other technique could have
//! drawn with density `other`, has the weight `mine^2 / (mine^2 + other^2)`. Densities are >= 0:
//!
//! | `mine` | `other` | weight |
//! |---|---|---|
//! | any | 0 or NaN | 1: no other technique finds the sample |
//! | 0 | > 0 | 0 |
//! | infinite | finite | 1 |
//! | finite | infinite | 0 |
//! | infinite | infinite | 1/2 |

use crate::lanes::Real;

/// Returns `other / mine`. Their ratio is squared, not they, because squares of densities could
/// leave the range of f32.
#[inline(always)]
fn density_ratio<R: Real<Scalar = f32>>(mine: R, other: R) -> R {
    let (zero, infinity) = (R::splat(0.0), R::splat(f32::INFINITY));
    let ratio =
        R::select(mine.equals(infinity) & other.equals(infinity), R::splat(1.0), other / mine);
    R::select(zero.lt(other), ratio, zero)
}

/// Returns the power heuristic's weight of a sample.
#[inline(always)]
pub fn power_heuristic<R: Real<Scalar = f32>>(mine: R, other: R) -> R {
    let (one, ratio) = (R::splat(1.0), density_ratio(mine, other));
    one / (one + ratio * ratio)
}

/// [`power_heuristic`] with one rounding less where the build has fused multiply-add.
///
/// The two differ in the last bit. Each caller keeps to one, so that pictures stay the same bit
/// for bit.
#[inline(always)]
pub fn power_heuristic_fused<R: Real<Scalar = f32>>(mine: R, other: R) -> R {
    let (one, ratio) = (R::splat(1.0), density_ratio(mine, other));
    one / ratio.mul_add(ratio, one)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::f32x8;

    /// The weight of both functions, in one lane and in eight.
    fn weight(mine: f32, other: f32) -> f32 {
        let one = power_heuristic(mine, other);
        let (mine, other) = (f32x8::splat(mine), f32x8::splat(other));
        assert_eq!(power_heuristic(mine, other).to_array(), [one; 8]);
        for fused in power_heuristic_fused(mine, other).to_array() {
            assert!((fused - one).abs() <= f32::EPSILON, "{fused}, not {one}");
        }
        one
    }

    #[test]
    fn edge_cases_have_the_documented_weights() {
        for mine in [0.0, 1.0, f32::INFINITY] {
            assert_eq!([weight(mine, 0.0), weight(mine, f32::NAN)], [1.0; 2], "{mine}");
        }
        assert_eq!(weight(0.0, 1e-30), 0.0);
        assert_eq!(weight(f32::INFINITY, f32::MAX), 1.0);
        assert_eq!(weight(f32::MAX, f32::INFINITY), 0.0);
        assert_eq!(weight(f32::INFINITY, f32::INFINITY), 0.5);
        assert_eq!(weight(0.0, f32::INFINITY), 0.0);
    }

    #[test]
    fn weights_of_two_techniques_add_up_to_one() {
        let densities = [1e-38, 3e-7, 0.1, 0.5, 1.0, 2.5, 1e8, 1e30, f32::MAX, f32::INFINITY];
        for a in densities {
            for b in densities {
                let sum = weight(a, b) + weight(b, a);
                assert!((sum - 1.0).abs() <= 2.0 * f32::EPSILON, "{a} {b}: {sum}");
            }
        }
    }

    #[test]
    fn weights_follow_the_squares_of_the_densities() {
        for (mine, other) in [(1.0f64, 2.0f64), (0.3, 0.1), (7.0, 7.0), (1e-3, 2e-2)] {
            let expected = mine * mine / (mine * mine + other * other);
            let off = f64::from(weight(mine as f32, other as f32)) / expected - 1.0;
            assert!(off.abs() < 1e-6, "{mine} {other}: {off}");
        }
    }
}
