//! Focus by moving groups.

use petzval_base::bisection::bisect;

use super::Prescription;
use super::configuration::HALVINGS;
use super::design::Configuration;
use crate::focus::focus_model::FocusModel;
use crate::focus::paraxial::{FocusError, Paraxial};
use crate::focus::real_ray::RealRayFocus;

/// Error of the film that is not worth another step (mm).
const PRECISION: f64 = 1e-8;

impl Prescription {
    /// Focuses at a distance from the film (mm) by the groups that the file moves, with the film
    /// where the file has it. Returns the lens and the distance of its film, or `None` if the file
    /// moves no group for focus.
    ///
    /// # Errors
    /// Returns an error if the lens cannot focus so near, or forms no image.
    pub fn focus_by_groups(
        &self,
        focus: f64,
        model: FocusModel,
        diagonal: f64,
    ) -> Option<Result<(Self, f64), FocusError>> {
        let chains = self.zoom_chains();
        let chain = chains.first()?;
        if chain.len() < 2 || chain.iter().any(|state| state.film_distance.is_none()) {
            return None;
        }
        Some(self.focus_along(chain, focus, model, diagonal))
    }

    /// Focuses at a distance from the film (mm): by the groups that the file moves, otherwise by the film. Returns the lens
    /// and the distance of its film.
    ///
    /// # Errors
    /// As [`Self::focus_by_groups`].
    pub fn focused(
        &self,
        focus: f64,
        model: FocusModel,
        diagonal: f64,
    ) -> Result<(Self, f64), FocusError> {
        match self.focus_by_groups(focus, model, diagonal) {
            Some(focused) => focused,
            None => model.film(self, focus, diagonal).map(|film| (self.clone(), film)),
        }
    }

    fn focus_along(
        &self,
        chain: &[&Configuration],
        focus: f64,
        model: FocusModel,
        diagonal: f64,
    ) -> Result<(Self, f64), FocusError> {
        let at = |s: f64| {
            let i = (s as usize).min(chain.len() - 2);
            let state = chain[i].between(chain[i + 1], s - i as f64, self);
            let mut lens = self.clone();
            lens.apply(&state);
            (lens, state.film_distance.unwrap_or(0.0))
        };
        // Real rays are sharpest next to the film of the file; the difference stays.
        let (distant, film) = at(0.0);
        let shift = model.film(&distant, f64::INFINITY, diagonal)? - film;
        if focus.is_infinite() {
            return Ok((distant, film + shift));
        }
        let last = (chain.len() - 1) as f64;
        // Positive while the image lies behind the film.
        let behind = |s: f64| {
            let (lens, film) = at(s);
            model.film(&lens, focus, diagonal).map(|sharp| sharp - film - shift)
        };
        let nearest = behind(last);
        if nearest.as_ref().is_ok_and(|behind| *behind > 0.0) {
            let (lens, film) = at(last);
            let paraxial = Paraxial::new(&lens);
            let by_rays = RealRayFocus::new(&lens).object_distance(film + shift);
            let object = by_rays.unwrap_or(paraxial.object_distance(film + shift));
            let nearest = object + lens.film_position(film + shift);
            return Err(match object > 0.0 {
                true => FocusError::TooNear { asked: focus, nearest },
                // The states of the file move the wrong way.
                false => FocusError::NoImage {
                    focal_length: paraxial.focal_length,
                    back_focal_distance: paraxial.back_focal_distance,
                },
            });
        }
        let quick = match (behind(0.0), nearest) {
            (Ok(far), Ok(near)) => root([0.0, last], [far, near], |s| behind(s).ok()),
            _ => None,
        };
        // Next to the nearest state the image may be lost.
        let near = |share: f64| behind(share * last).is_ok_and(|behind| behind <= 0.0);
        let slow = || last * bisect([1.0, 0.0], HALVINGS, near)[0];
        let s = quick.unwrap_or_else(slow);
        let (lens, film) = at(s);
        Ok((lens, film + shift))
    }
}

/// Returns where a function becomes zero between two places, positive at the first and not at the
/// second, by false position with halved weights (Illinois; Dowell & Jarratt 1971). Each evaluation
/// traces rays. `None` if the function has no value at a place between.
fn root(
    mut at: [f64; 2],
    mut value: [f64; 2],
    function: impl Fn(f64) -> Option<f64>,
) -> Option<f64> {
    if value[0] <= 0.0 {
        return Some(at[0]);
    }
    let mut replaced = None;
    for _ in 0..HALVINGS {
        let middle = (at[0] * value[1] - at[1] * value[0]) / (value[1] - value[0]);
        let there = function(middle)?;
        if there.abs() < PRECISION {
            return Some(middle);
        }
        let end = usize::from(there <= 0.0);
        if replaced.replace(end) == Some(end) {
            value[1 - end] /= 2.0;
        }
        (at[end], value[end]) = (middle, there);
    }
    Some(at[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_is_found_in_few_steps() {
        let count = std::cell::Cell::new(0);
        let f = |s: f64| {
            count.set(count.get() + 1);
            Some((0.3f64 - s).powi(3) + 0.1 * (0.3 - s))
        };
        let found = root([0.0, 2.0], [0.057, -5.083], f).expect("a value everywhere");
        assert!((found - 0.3).abs() < 1e-6, "{found}");
        assert!(count.get() < 20, "{} steps", count.get());
        assert_eq!(root([0.0, 2.0], [1.0, -1.0], |_| None), None);
        assert_eq!(root([0.0, 2.0], [0.0, -1.0], |_| None), Some(0.0));
    }
}
