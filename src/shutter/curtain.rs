//! What a shutter lets through while it opens and closes.

use super::Efficiency;

/// The share of the light that comes through.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Curtain {
    /// All of it, from the first moment to the last.
    #[default]
    Ideal,
    /// It takes time to open and to close, both within the time that it is open, and lets through
    /// more and more evenly.
    Ramps {
        /// From the first light to all of it, s.
        opening: f64,
        /// From all of it to none, s.
        closing: f64,
    },
    /// Shares at times that are equally far apart, the first when it opens, the last when it
    /// closes; straight between them.
    Table(Vec<f64>),
}

impl Curtain {
    /// The curve of a shutter that is open for so long, s.
    ///
    /// # Errors
    /// Where ramps take longer.
    pub fn over(&self, time: f64) -> Result<Efficiency, String> {
        match self {
            Self::Ideal => Ok(Efficiency::ideal()),
            Self::Ramps { opening, closing } if opening + closing <= 0.0 => Ok(Efficiency::ideal()),
            Self::Ramps { opening, closing } => {
                let both = opening + closing;
                if both > time * (1.0 + 1e-9) {
                    return Err(format!(
                        "a shutter that opens in {opening} s and closes in {closing} s; expected \
                         {time} s together at most, which is how long it is open"
                    ));
                }
                let [opened, closes] = [opening / time, 1.0 - closing / time];
                let corners = [[0.0, 0.0], [opened, 1.0], [closes.max(opened), 1.0], [1.0, 0.0]];
                Efficiency::new(&corners)
            }
            Self::Table(shares) => {
                let steps = shares.len().saturating_sub(1).max(1) as f64;
                let corner = |(i, &share): (usize, &f64)| [i as f64 / steps, share];
                Efficiency::new(&shares.iter().enumerate().map(corner).collect::<Vec<_>>())
            }
        }
    }
}
