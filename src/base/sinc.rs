//! Normalised sinc function.

use std::f64::consts::PI;

/// Returns sin(pi x) / (pi x).
///
/// ```
/// use petzval_base::sinc::sinc;
///
/// assert_eq!(sinc(0.0), 1.0);
/// assert!(sinc(1.0).abs() < 1e-15);
/// assert!((sinc(0.5) - std::f64::consts::FRAC_2_PI).abs() < 1e-15);
/// ```
pub fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) }
}
