//! Ranges that all readers of lens files share with the prescription.

/// Distance (in units of the file) from which an object is at infinity: optical-design programs write
/// 1e10 to 1e20.
pub const INFINITE: f64 = 1e9;

/// Smallest refractive index, relative to air: gases and vacuum have a little less than 1.
pub const MIN_INDEX: f64 = 0.99;

/// Largest refractive index. Germanium in the far infrared has 4.
pub const MAX_INDEX: f64 = 10.0;
