//! Limits of camera paths, as a scene sets them.

/// Length and kind of the camera paths of a picture, and what they may see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathLimits {
    /// Largest number of surfaces that scatter light. A path collects only emission beyond them.
    pub max_depth: u32,
    /// Whether paths continue only from mirrors and clear glass, so that other surfaces receive
    /// direct light alone.
    pub direct_only: bool,
    /// Whether surfaces behind others that scatter are rougher than they are, which removes
    /// caustics and their noise (pbrt-v4's `regularize`).
    pub regularize: bool,
}
