//! Diameter of the stop for an f-number.

use std::fmt;

use petzval_base::bisection::bisect;

use crate::focus::real_ray::RealRayFocus;
use crate::prescription::Prescription;

/// Bisection steps: they reach the precision of f64.
const HALVINGS: u32 = 50;

/// Excess of the widest f-number over one that is asked for at which the widest is meant: makers round,
/// so that a lens sold as 50 mm f/2 opens to f/2.02.
const ROUNDED: f64 = 0.03;

/// Why a lens has no such f-number.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FNumberError {
    /// The lens forms no image.
    #[error("forms no image")]
    NoImage,
    /// The lens does not open so wide.
    #[error("opens to f/{open:.2} and no wider; expected {open:.2} or more")]
    TooFast {
        /// Its f-number when open.
        open: f64,
    },
}

impl Prescription {
    /// Returns the diameter of the stop (mm) that gives an f-number, measured by a traced marginal
    /// ray ([`RealRayFocus::f_number`]). So the light on the film follows the f-number whatever the
    /// aberrations of the pupil. Up to 3 % below its widest f-number, the stop is wide open
    /// ([`Self::rounded_f_number`]).
    ///
    /// # Errors
    /// Returns an error if the lens forms no image or does not open so wide.
    pub fn f_number_diameter(&self, asked: f64) -> Result<f64, FNumberError> {
        let f_number = |diameter: f64| {
            let mut closed = self.clone();
            closed.stop_down(diameter);
            RealRayFocus::new(&closed).f_number().unwrap_or(f64::INFINITY)
        };
        let wide = self.rows[self.stop()].diameter;
        let open = f_number(wide);
        if open.is_infinite() {
            return Err(FNumberError::NoImage);
        }
        if asked < open * (1.0 - ROUNDED) {
            return Err(FNumberError::TooFast { open });
        }
        let [_, diameter] = bisect([0.0, wide], HALVINGS, |diameter| f_number(diameter) > asked);
        Ok(diameter)
    }

    /// Returns the widest f-number of the lens if it is meant by a slightly smaller one that is asked for
    /// ([`Self::f_number_diameter`]), and differs from it by more than a rounding to two digits.
    pub fn rounded_f_number(&self, asked: f64) -> Option<RoundedFNumber> {
        let open = RealRayFocus::new(self).f_number()?;
        let meant = (open * (1.0 - ROUNDED)..open * (1.0 - 5e-3)).contains(&asked);
        meant.then_some(RoundedFNumber { asked, open })
    }
}

/// An f-number as a maker rounds it. It prints as a sentence for the user.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RoundedFNumber {
    /// The one that is asked for.
    pub asked: f64,
    /// The widest one of the lens, which is meant.
    pub open: f64,
}

impl fmt::Display for RoundedFNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { asked, open } = self;
        write!(f, "f/{asked} is the widest of this lens, which opens to f/{open:.2}")
    }
}
