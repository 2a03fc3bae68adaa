//! The shutter: when the film is exposed, how much of the light comes through meanwhile, and
//! when each row of a sensor is read.
//!
//! Times are in seconds, as scene files count them.

mod curtain;
mod duration;
mod efficiency;
mod rolling;
mod settings;
mod timing;

pub use curtain::Curtain;
pub use duration::seconds;
pub use efficiency::Efficiency;
pub use rolling::{Reading, Rolling};
pub use settings::Settings;
pub use timing::Timing;

/// When and how the film is exposed.
#[derive(Clone, Debug, PartialEq)]
pub struct Shutter {
    /// When the first light comes through.
    pub open: f64,
    /// When the last does.
    pub close: f64,
    /// How much comes through between the two.
    pub curtain: Curtain,
    /// The time that the sensor takes to read its rows, if it does not take all at once. The
    /// first row that is read is exposed from `open` to `close`, others as long but later.
    pub rolling: Option<Rolling>,
}

impl Default for Shutter {
    /// Ideal and open for a second, as in pbrt.
    fn default() -> Self {
        Self { open: 0.0, close: 1.0, curtain: Curtain::Ideal, rolling: None }
    }
}

impl Shutter {
    /// How long it is open.
    pub fn time(&self) -> f64 {
        self.close - self.open
    }

    /// The middle of the time that it is open.
    pub fn middle(&self) -> f64 {
        0.5 * (self.open + self.close)
    }

    /// How much of the light comes through in the course of the exposure.
    ///
    /// # Errors
    /// Where it takes longer to open and close than it is open.
    pub fn efficiency(&self) -> Result<Efficiency, String> {
        self.curtain.over(self.time())
    }
}
