//! How a shutter opens and closes.

use super::ShutterCurve;

/// The transmission of a shutter during the exposure.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Curtain {
    /// Fully open all the time.
    #[default]
    Ideal,
    /// Linear ramps; both lie within the time that the shutter is open.
    Ramps {
        /// From closed to fully open, s.
        opening: f64,
        /// From fully open to closed, s.
        closing: f64,
    },
    /// Transmission at equally spaced times, from the moment the shutter opens to the moment it has
    /// closed; linear between them.
    Table(Vec<f64>),
}

impl Curtain {
    /// Returns the transmission curve of a shutter that is open for `time` seconds.
    ///
    /// # Errors
    /// Returns an error if the ramps take longer than that, or if a table is invalid.
    pub fn curve(&self, time: f64) -> Result<ShutterCurve, String> {
        match self {
            Self::Ideal => Ok(ShutterCurve::ideal()),
            Self::Ramps { opening, closing } if opening + closing <= 0.0 => {
                Ok(ShutterCurve::ideal())
            }
            Self::Ramps { opening, closing } => {
                let both = opening + closing;
                if both > time * (1.0 + 1e-9) {
                    return Err(format!(
                        "the shutter opens in {opening} s and closes in {closing} s; expected \
                         {time} s together at most, the exposure time"
                    ));
                }
                let [opened, closes] = [opening / time, 1.0 - closing / time];
                let corners = [[0.0, 0.0], [opened, 1.0], [closes.max(opened), 1.0], [1.0, 0.0]];
                ShutterCurve::from_points(&corners)
            }
            Self::Table(shares) => {
                let steps = shares.len().saturating_sub(1).max(1) as f64;
                let corner = |(i, &share): (usize, &f64)| [i as f64 / steps, share];
                ShutterCurve::from_points(
                    &shares.iter().enumerate().map(corner).collect::<Vec<_>>(),
                )
            }
        }
    }
}
