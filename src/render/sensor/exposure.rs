//! Exposure value of camera settings.

/// Returns the exposure value at ISO 100: log2(N^2 / t) - log2(S / 100) (ISO 2720:1974). A scene of
/// this EV is exposed correctly at f-number N, t seconds and speed S.
pub fn ev100(f_number: f64, seconds: f64, iso: f64) -> f64 {
    (f_number * f_number / seconds).log2() - (iso / 100.0).log2()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sunshine_is_ev_15() {
        // "Sunny 16": f/16 at 1/ISO seconds, nominally 1/125.
        assert!((ev100(16.0, 1.0 / 125.0, 100.0) - 14.9658).abs() < 1e-4);
        assert_eq!(ev100(1.0, 1.0, 100.0), 0.0);
        assert_eq!(ev100(4.0, 0.25, 800.0), 3.0);
    }
}
