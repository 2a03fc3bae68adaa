//! When a picture is good enough.

use std::time::Duration;

/// When a render ends, where not by the count of its samples alone: whichever comes first. The
/// samples of the job are the most then, as a mean over the pixels that light comes to.
///
/// A picture that ends by noise or count is the same whatever computes it; one that ends by time
/// is another picture on another day.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Until {
    /// When the picture's noise is this.
    ///
    /// The error of a pixel is the standard error of its luminance, over that luminance and a
    /// tenth of the picture's mean together, so that darkness need not be exact. The picture's
    /// noise is the root of its mean square over all pixels.
    pub noise: Option<f64>,
    /// After so much time, without what comes before and after the render; but every pixel takes
    /// some samples.
    pub time: Option<Duration>,
}

impl Until {
    /// The fewest samples of a pixel that such a render can be content with: the quarters that
    /// tell the noise have one each.
    pub const FEWEST: u32 = 4;
    /// The most where nobody says how many.
    pub const MOST: u32 = 1 << 20;

    /// Whether the count of samples alone ends the render: all pixels take as many.
    pub fn count_only(&self) -> bool {
        *self == Self::default()
    }
}

/// How good a picture became.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// The estimate of its noise, as [`Until::noise`] has it.
    pub noise: f64,
    /// Samples of a pixel that light comes to: the mean over those pixels.
    pub mean: f64,
    /// The fewest.
    pub least: u32,
    /// The most.
    pub most: u32,
}
