//! States of a lens, and its zoom settings.
//!
//! A file gives a few states. A state between two of them is interpolated linearly: in the gaps and
//! curvatures of the rows, until the focal length (zoom) or the sharp image (focus) is that which
//! is asked for. Real lenses move their groups along curves that pass through the given states.

use petzval_base::bisection::bisect;

use super::Prescription;
use super::design::{Configuration, Quantity, Setting};
use crate::focus::paraxial::Paraxial;

/// Steps of bisection: they reach the precision of f64.
pub(super) const HALVINGS: u32 = 60;

/// Relative distance to a given state within which it is taken itself.
const SAME: f64 = 5e-3;

/// A zoom setting that is asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Zoom {
    /// Focal length (mm).
    FocalLength(f64),
    /// Name of a state, or its number from 1.
    State(String),
}

/// A zoom setting that the lens does not have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{found}; expected {expected}")]
pub struct ZoomError {
    found: String,
    expected: String,
}

impl Configuration {
    /// Returns whether the state focuses on distant objects.
    fn is_distant(&self) -> bool {
        self.object_distance.is_none_or(f64::is_infinite)
            && self.magnification.is_none_or(|magnification| magnification == 0.0)
    }

    /// Returns the state between this one (`t` = 0) and another (1).
    pub(super) fn between(&self, other: &Self, t: f64, lens: &Prescription) -> Self {
        let mix = |a: f64, b: f64| if t == 0.0 { a } else { a + t * (b - a) };
        let both = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(mix(a, b)),
            (a, b) => {
                if t < 1.0 {
                    a
                } else {
                    b
                }
            }
        };
        let value = |state: &Self, setting: &Setting| {
            let same = |s: &&Setting| (s.row, s.quantity) == (setting.row, setting.quantity);
            let own = state.settings.iter().find(same).map(|setting| setting.value);
            own.unwrap_or_else(|| lens.quantity(setting.row, setting.quantity))
        };
        let mut settings: Vec<Setting> = Vec::new();
        for setting in self.settings.iter().chain(&other.settings) {
            let known = |s: &Setting| (s.row, s.quantity) == (setting.row, setting.quantity);
            if !settings.iter().any(known) {
                let value = mix(value(self, setting), value(other, setting));
                settings.push(Setting { value, ..*setting });
            }
        }
        Self {
            name: if t == 0.0 { self.name.clone() } else { String::new() },
            focal_length: both(self.focal_length, other.focal_length),
            f_number: both(self.f_number, other.f_number),
            object_distance: self.object_distance,
            magnification: both(self.magnification, other.magnification),
            film_distance: both(self.film_distance, other.film_distance),
            settings,
        }
    }
}

impl Prescription {
    fn quantity(&self, row: usize, quantity: Quantity) -> f64 {
        let row = &self.rows[row];
        match quantity {
            Quantity::Thickness => row.thickness,
            Quantity::Curvature => row.curvature(),
            Quantity::Diameter => row.diameter,
        }
    }

    /// Moves the rows to a state.
    pub(super) fn apply(&mut self, state: &Configuration) {
        for &Setting { row, quantity, value } in &state.settings {
            let row = &mut self.rows[row];
            match quantity {
                Quantity::Thickness => row.thickness = value,
                Quantity::Curvature => row.radius = value.recip(),
                Quantity::Diameter => row.diameter = value,
            }
        }
        if state.film_distance.is_some() {
            self.design.film_distance = state.film_distance;
        }
    }

    /// Opens the stop to an f-number, by first-order optics.
    fn open_to(&mut self, f_number: f64) {
        let stop = self.stop();
        let paraxial = Paraxial::new(self);
        let diameter = self.rows[stop].diameter * paraxial.f_number() / f_number;
        if diameter.is_finite() && diameter > 0.0 {
            self.rows[stop].diameter = diameter;
        }
    }

    /// Returns the states that focus on distant objects, each with the states that focus nearer at
    /// the same zoom setting, in the order of the file.
    pub(super) fn zoom_chains(&self) -> Vec<Vec<&Configuration>> {
        let states = &self.design.configurations;
        let distant: Vec<usize> = (0..states.len()).filter(|&i| states[i].is_distant()).collect();
        let Some(&first) = distant.first() else { return Vec::new() };
        let block = distant.iter().enumerate().all(|(k, &i)| i == first + k);
        let mut chains: Vec<Vec<&Configuration>> =
            distant.iter().map(|&i| vec![&states[i]]).collect();
        for (i, state) in states.iter().enumerate().filter(|(_, state)| !state.is_distant()) {
            let chain = match block {
                // All settings at infinity, then all of them nearer, and so on.
                true => i.wrapping_sub(first) % distant.len(),
                false => distant.partition_point(|&at| at < i).saturating_sub(1),
            };
            chains[chain].push(state);
        }
        chains
    }

    /// Returns the focal lengths of the zoom states (mm), as stated or by first-order optics; empty
    /// for a lens that does not zoom.
    pub fn zoom_range(&self) -> Vec<f64> {
        let chains = self.zoom_chains();
        let lengths: Vec<f64> = chains.iter().map(|chain| self.focal_length_in(chain[0])).collect();
        if lengths.len() < 2 { Vec::new() } else { lengths }
    }

    fn focal_length_in(&self, state: &Configuration) -> f64 {
        let mut lens = self.clone();
        lens.apply(state);
        Paraxial::new(&lens).focal_length
    }

    /// Returns the lens at a zoom setting, focused on distant objects, and a note if the state lies
    /// between two of the file.
    ///
    /// # Errors
    /// Returns an error if the lens does not zoom or has no such setting.
    pub fn at_zoom(&self, zoom: &Zoom) -> Result<(Self, Option<String>), ZoomError> {
        let chains = self.zoom_chains();
        let lengths = self.zoom_range();
        let names: Vec<String> = chains.iter().map(|chain| chain[0].name.clone()).collect();
        let range = || {
            let low = lengths.iter().copied().fold(f64::INFINITY, f64::min);
            let high = lengths.iter().copied().fold(0.0, f64::max);
            format!("{low:.2} to {high:.2} mm")
        };
        if lengths.is_empty() {
            return Err(ZoomError {
                found: format!("{} has one focal length", self.name),
                expected: "a lens whose file gives several zoom states".to_owned(),
            });
        }
        match zoom {
            Zoom::State(name) => {
                let number = name.parse::<usize>().ok().and_then(|n| n.checked_sub(1));
                let named = names.iter().position(|known| known.eq_ignore_ascii_case(name));
                let Some(i) = named.or(number).filter(|&i| i < chains.len()) else {
                    return Err(ZoomError {
                        found: format!("{} has no zoom state \"{name}\"", self.name),
                        expected: format!("a focal length of {}, or {}", range(), list(&names)),
                    });
                };
                Ok((self.zoomed(&chains[i], &chains[i], 0.0), None))
            }
            &Zoom::FocalLength(asked) => {
                let near = |&i: &usize| (lengths[i] - asked).abs() <= SAME * asked;
                let given = (0..chains.len()).filter(near).min_by(|&i, &j| {
                    (lengths[i] - asked).abs().total_cmp(&(lengths[j] - asked).abs())
                });
                if let Some(i) = given {
                    return Ok((self.zoomed(&chains[i], &chains[i], 0.0), None));
                }
                let bracket =
                    |&i: &usize| (lengths[i] - asked).signum() != (lengths[i + 1] - asked).signum();
                let Some(i) = (0..chains.len() - 1).find(bracket) else {
                    return Err(ZoomError {
                        found: format!("{} has no focal length of {asked} mm", self.name),
                        expected: range(),
                    });
                };
                let (one, other) = (&chains[i], &chains[i + 1]);
                let rises = lengths[i + 1] > lengths[i];
                let reached = |t: f64| {
                    let state = one[0].between(other[0], t, self);
                    (self.focal_length_in(&state) > asked) == rises
                };
                let [t, _] = bisect([1.0, 0.0], HALVINGS, reached);
                let note = format!(
                    "zoom: {asked} mm lies between the states of {:.2} and {:.2} mm; the moving \
                     groups are interpolated",
                    lengths[i],
                    lengths[i + 1]
                );
                Ok((self.zoomed(one, other, t), Some(note)))
            }
        }
    }

    /// Returns the lens between two zoom states, with its focus states there.
    fn zoomed(&self, one: &[&Configuration], other: &[&Configuration], t: f64) -> Self {
        let mut lens = self.clone();
        let states: Vec<Configuration> =
            one.iter().zip(other).map(|(a, b)| a.between(b, t, self)).collect();
        lens.apply(&states[0]);
        let sets_stop = |setting: &Setting| {
            setting.row == self.stop() && setting.quantity == Quantity::Diameter
        };
        if let (Some(f_number), false) =
            (states[0].f_number, states[0].settings.iter().any(sets_stop))
        {
            lens.open_to(f_number);
        }
        lens.stated_focal_length = states[0].focal_length;
        lens.stated_f_number = states[0].f_number;
        lens.design.configurations = states;
        lens
    }
}

fn list(names: &[String]) -> String {
    let quoted = (1..).zip(names).map(|(number, name): (usize, _)| match name.is_empty() {
        true => number.to_string(),
        false => format!("\"{name}\""),
    });
    quoted.collect::<Vec<_>>().join(", ")
}
