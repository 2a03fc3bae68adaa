//! Monte Carlo analysis of tolerances, and the sensitivity to each of them.

use super::distribution::correlation;
use super::figure::{LensFigures, Refocus};
use super::grade::ToleranceLimits;
use super::parameter::{ToleranceParameter, parameters};
use super::perturbed_lens::NominalLens;
use super::random_deviation::deviation;
use crate::imaging::conditions::ImagingConditions;
use crate::imaging::frozen_imaging::{FrozenImaging, FrozenImagingError, RimPolicy};
use crate::imaging::image_quality::in_parallel;
use petzval_lens::Fields;
use petzval_lens::Prescription;

/// Distribution of the deviations within their limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviationShape {
    /// Normal with a standard deviation of half the limit, cut off at the limit.
    Normal,
    /// Equally likely everywhere.
    Uniform,
    /// One limit or the other.
    Extremes,
}

/// Choices of an analysis.
#[derive(Clone, Debug, PartialEq)]
pub struct ToleranceSettings {
    /// Limits of the deviations.
    pub limits: ToleranceLimits,
    /// Their distribution.
    pub shape: DeviationShape,
    /// Adjustment of the film.
    pub refocus: Refocus,
    /// Fields as shares of the largest, of either sign.
    pub shares: Vec<f64>,
    /// Hexapolar rings of rays over the stop.
    pub rings: u32,
    /// Spatial frequency of the MTF (cycles / mm).
    pub frequency: f64,
    /// Seed of the trials.
    pub seed: u64,
    /// Threads that share the work. The results do not depend on them.
    pub threads: usize,
}

/// A lens as it may be made.
#[derive(Clone, Debug, PartialEq)]
pub struct ToleranceTrial {
    /// Deviation of each parameter, in its unit.
    pub deviations: Vec<f64>,
    /// Figures of merit.
    pub figures: LensFigures,
}

/// Effect of one tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct ToleranceEffect {
    /// Number of the parameter.
    pub parameter: usize,
    /// Figures with the parameter alone at its lower and at its upper limit.
    pub at_limits: [LensFigures; 2],
    /// Correlation of the spot radius of all fields with the deviation, over the trials.
    pub linear: f64,
    /// Correlation with the square of the deviation.
    pub square: f64,
}

/// Analysis of the tolerances of a lens.
#[derive(Clone, Debug)]
pub struct ToleranceAnalysis {
    /// Quantities with tolerances.
    pub parameters: Vec<ToleranceParameter>,
    /// Figures of the lens without errors.
    pub nominal: LensFigures,
    settings: ToleranceSettings,
    imaging: FrozenImaging,
    lens: NominalLens,
}

impl ToleranceAnalysis {
    /// Prepares a lens.
    ///
    /// # Errors
    /// Returns an error if a glass has no data at a wavelength, or if a field is dark.
    pub fn new(
        lens: &Prescription,
        conditions: ImagingConditions,
        settings: ToleranceSettings,
    ) -> Result<Self, FrozenImagingError> {
        let imaging = FrozenImaging::new(
            lens,
            conditions,
            &settings.shares,
            settings.rings,
            settings.threads,
        )?;
        let lines = &imaging.conditions.wavelengths;
        let mut analysis = Self {
            parameters: parameters(lens, &settings.limits),
            nominal: LensFigures::dark(0),
            lens: NominalLens::new(lens, lines),
            settings,
            imaging,
        };
        analysis.nominal = analysis.figures(&vec![0.0; analysis.parameters.len()]);
        Ok(analysis)
    }

    /// Returns the conditions; the field is an angle or an object height.
    pub fn conditions(&self) -> &ImagingConditions {
        &self.imaging.conditions
    }

    /// Returns the field coordinates along y.
    pub fn fields(&self) -> &[f64] {
        &self.imaging.fields
    }

    /// Returns the number of rays of a trial, over all fields and wavelengths.
    pub fn rays(&self) -> usize {
        self.imaging.rays()
    }

    /// Returns the figures of the lens with these deviations, one for each parameter in its unit.
    pub fn figures(&self, deviations: &[f64]) -> LensFigures {
        let lens = self.lens.perturbed(&self.parameters, deviations);
        let film = self.imaging.conditions.film_distance;
        let spots = self
            .imaging
            .spots(film, RimPolicy::Moving, |wavelength| Some(lens.at_wavelength(wavelength)));
        let ToleranceSettings { refocus, frequency, .. } = self.settings;
        match spots {
            Some(spots) => LensFigures::new(self.fields(), &spots, refocus, frequency),
            None => LensFigures::dark(self.fields().len()),
        }
    }

    /// Returns the deviations of a trial: a pure function of seed, trial and parameter.
    pub fn deviations(&self, trial: u64) -> Vec<f64> {
        let ToleranceSettings { shape, seed, .. } = self.settings;
        let one = |(number, parameter): (u64, &ToleranceParameter)| {
            parameter.limit * deviation(shape, seed, trial, number)
        };
        (0..).zip(&self.parameters).map(one).collect()
    }

    /// Runs trials 0 to `count` - 1.
    pub fn trials(&self, count: u64) -> Vec<ToleranceTrial> {
        let numbers: Vec<u64> = (0..count).collect();
        in_parallel(&numbers, self.settings.threads, |&trial| {
            let deviations = self.deviations(trial);
            ToleranceTrial { figures: self.figures(&deviations), deviations }
        })
    }

    /// Returns the effect of each tolerance, the largest increase of the spot radius of all fields
    /// first.
    pub fn effects(&self, trials: &[ToleranceTrial]) -> Vec<ToleranceEffect> {
        let numbers: Vec<usize> = (0..self.parameters.len()).collect();
        let spots = || trials.iter().map(|trial| trial.figures.spot());
        let mut effects = in_parallel(&numbers, self.settings.threads, |&parameter| {
            let at = |sign: f64| {
                let mut deviations = vec![0.0; self.parameters.len()];
                deviations[parameter] = sign * self.parameters[parameter].limit;
                self.figures(&deviations)
            };
            let values = || trials.iter().map(|trial| trial.deviations[parameter]);
            ToleranceEffect {
                parameter,
                at_limits: [at(-1.0), at(1.0)],
                linear: correlation(values(), spots()),
                square: correlation(values().map(|value| value * value), spots()),
            }
        });
        effects.sort_by(|a, b| b.worst_spot().total_cmp(&a.worst_spot()));
        effects
    }

    /// Returns the lens of a trial for a lens file: with its wavelengths, fields and film, so that
    /// reading it gives the figures of the trial.
    pub fn lens(&self, trial: &ToleranceTrial) -> Prescription {
        let mut lens = self.lens.perturbed(&self.parameters, &trial.deviations).prescription();
        let conditions = self.conditions();
        let design = &mut lens.design;
        design.wavelengths = conditions.wavelengths.clone();
        design.primary = conditions.primary;
        let finite = conditions.object_distance.is_finite();
        design.object_distance = finite.then_some(conditions.object_distance);
        design.film_distance = Some(conditions.film_distance + trial.figures.defocus);
        // The largest field first: shares of it are the fields of the trial.
        let mut points = vec![[0.0, conditions.largest_field]];
        points.extend(self.fields().iter().map(|field| [0.0, *field]));
        design.fields = Some(Fields { kind: conditions.field_kind, points });
        design.configurations.clear();
        lens
    }
}

impl ToleranceEffect {
    /// Returns the larger spot radius of all fields at the two limits (mm).
    pub fn worst_spot(&self) -> f64 {
        self.at_limits.iter().map(LensFigures::spot).fold(0.0, f64::max)
    }

    /// Returns the lower modulation at the two limits.
    pub fn worst_modulation(&self) -> f64 {
        self.at_limits.iter().map(LensFigures::modulation).fold(f64::INFINITY, f64::min)
    }

    /// Returns the correlation of larger size: with the deviation or with its square.
    pub fn correlation(&self) -> f64 {
        if self.linear.abs() >= self.square.abs() { self.linear } else { self.square }
    }
}
