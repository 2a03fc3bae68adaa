//! Numbers on which kernels break, shared by all tests that hunt for special cases.

/// Zeros of both signs, units and their neighbours, subnormal numbers, integers at the limit of f32,
/// powers from 1e-300 to 1e300, the limits of f32, infinities and NaN. A test may add its own.
pub const NASTY: [f64; 32] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1.0 - 0.5 * f32::EPSILON as f64,
    1.0 + f32::EPSILON as f64,
    0.3,
    -3.5,
    16_777_217.0,
    f32::EPSILON as f64,
    f32::MIN_POSITIVE as f64,
    1e-45,
    -1e-45,
    1e-40,
    1e-30,
    1e-20,
    -1e-20,
    1e-300,
    1e9,
    1e10,
    -1e10,
    1e20,
    -1e20,
    1e30,
    -1e30,
    1e300,
    -1e300,
    f32::MAX as f64,
    f32::MIN as f64,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Returns the list in f32, in which 1e-300 is 0 and 1e300 is infinite.
pub fn nasty_f32() -> [f32; NASTY.len()] {
    NASTY.map(|value| value as f32)
}
