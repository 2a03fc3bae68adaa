//! Shutter: exposure time, transmission during the exposure, and readout of the sensor's rows.
//!
//! Times are in seconds, on the time axis of the scene file.

mod curtain;
mod curve;
mod duration;
mod rolling;
mod settings;

pub use curtain::Curtain;
pub use curve::ShutterCurve;
pub use duration::parse_seconds;
pub use rolling::{ReadoutDirection, RollingShutter};
pub use settings::ShutterSettings;

/// When and how the film is exposed.
#[derive(Clone, Debug, PartialEq)]
pub struct Shutter {
    /// When the shutter begins to open, s.
    pub open: f64,
    /// When the shutter has closed, s.
    pub close: f64,
    /// How it opens and closes.
    pub curtain: Curtain,
    /// Readout of the rows, if they are not all exposed at once. The first row read is exposed from
    /// `open` to `close`; the others equally long, but later.
    pub rolling: Option<RollingShutter>,
}

impl Default for Shutter {
    /// Returns an ideal shutter that is open for one second, as in pbrt.
    fn default() -> Self {
        Self { open: 0.0, close: 1.0, curtain: Curtain::Ideal, rolling: None }
    }
}

impl Shutter {
    /// Returns the exposure time, s.
    pub fn time(&self) -> f64 {
        self.close - self.open
    }

    /// Returns the middle of the exposure, s.
    pub fn middle(&self) -> f64 {
        0.5 * (self.open + self.close)
    }

    /// Returns the transmission during the exposure.
    ///
    /// # Errors
    /// Returns an error if the shutter takes longer to open and close than it is open.
    pub fn curve(&self) -> Result<ShutterCurve, String> {
        self.curtain.curve(self.time())
    }
}
