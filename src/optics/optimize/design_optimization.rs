//! Optimization of a lens.

use super::constraint::EdgeConstraint;
use super::merit::{DesignMerit, FilmedLens, MeritValue};
use super::target::DesignTarget;
use super::variable::DesignVariable;
use crate::damped_least_squares::{Residuals, StopReason, minimize};
use crate::imaging::conditions::ImagingConditions;
use crate::imaging::frozen_imaging::{FrozenImaging, FrozenImagingError};
use crate::imaging::image_quality::in_parallel;
use crate::tolerance::figure::Refocus;
use petzval_lens::Prescription;

/// Times that the rays are chosen anew, for the lens found so far.
const ROUNDS: u32 = 5;
/// Relative decrease of the merit by a round that calls for another one.
const ROUND_DECREASE: f64 = 1e-4;

/// Variables, targets and constraints of an optimization.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignGoal {
    /// Variables.
    pub variables: Vec<DesignVariable>,
    /// Targets.
    pub targets: Vec<DesignTarget>,
    /// Adjustment of the film of each lens that is tried.
    pub refocus: Refocus,
    /// Least thickness at the rims of elements and gaps (mm).
    pub least_edge: f64,
    /// Fields as shares of the largest.
    pub shares: Vec<f64>,
    /// Hexapolar rings of rays over the stop.
    pub rings: u32,
    /// Most iterations.
    pub iterations: u32,
    /// Threads that share the work.
    pub threads: usize,
}

/// State of a lens before or after an optimization.
#[derive(Clone, Debug, PartialEq)]
pub struct DesignState {
    /// Square root of the weighted sum of squares (mm).
    pub merit: f64,
    /// Value of each variable: a curvature for a radius.
    pub variables: Vec<f64>,
    /// Value of each target, in its unit.
    pub targets: Vec<f64>,
    /// Distance from the rear vertex to the film, after refocus (mm).
    pub film_distance: f64,
}

/// Result of an optimization.
#[derive(Clone, Debug, PartialEq)]
pub struct OptimizedDesign {
    /// The lens, with its film distance.
    pub lens: Prescription,
    /// The lens at the start.
    pub start: DesignState,
    /// The lens that was found.
    pub end: DesignState,
    /// Iterations.
    pub iterations: u32,
    /// Why it stopped.
    pub reason: StopReason,
}

/// Why a lens cannot be optimized.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptimizationError {
    /// The rays cannot be chosen.
    #[error("{0}")]
    Imaging(#[from] FrozenImagingError),
    /// The merit has no value at the start.
    #[error(
        "the lens has no merit to begin with: a ray of a field is lost, or a distortion target has \
         no field beside the axis; give smaller fields with 'fields' or 'image_height'"
    )]
    Start,
}

/// The merit as a function of the variables.
struct VariableMerit<'a> {
    goal: &'a DesignGoal,
    merit: DesignMerit,
    design: FilmedLens,
}

impl VariableMerit<'_> {
    fn new<'a>(
        goal: &'a DesignGoal,
        design: FilmedLens,
        conditions: &ImagingConditions,
        edges: &EdgeConstraint,
    ) -> Result<VariableMerit<'a>, FrozenImagingError> {
        let conditions = ImagingConditions { film_distance: design.film, ..conditions.clone() };
        let imaging =
            FrozenImaging::new(&design.lens, conditions, &goal.shares, goal.rings, goal.threads)?;
        let (targets, refocus, edges) = (goal.targets.clone(), goal.refocus, edges.clone());
        let merit = DesignMerit { imaging, targets, refocus, edges };
        Ok(VariableMerit { goal, merit, design })
    }

    fn changed(&self, values: &[f64]) -> FilmedLens {
        let FilmedLens { mut lens, mut film } = self.design.clone();
        for (variable, value) in self.goal.variables.iter().zip(values) {
            variable.set(&mut lens, &mut film, *value);
        }
        FilmedLens { lens, film }
    }

    fn values(&self) -> Vec<f64> {
        let FilmedLens { lens, film } = &self.design;
        self.goal.variables.iter().map(|variable| variable.value(lens, *film)).collect()
    }

    fn state(&self) -> Option<DesignState> {
        let MeritValue { residuals, values, film } = self.merit.evaluate(&self.design)?;
        let merit = residuals.iter().map(|r| r * r).sum::<f64>().sqrt();
        Some(DesignState { merit, variables: self.values(), targets: values, film_distance: film })
    }
}

impl Residuals for VariableMerit<'_> {
    fn at(&self, variables: &[f64]) -> Option<Vec<f64>> {
        self.merit.evaluate(&self.changed(variables)).map(|value| value.residuals)
    }

    fn derivatives(&self, variables: &[f64], residuals: &[f64]) -> Option<Vec<Vec<f64>>> {
        let numbers: Vec<usize> = (0..variables.len()).collect();
        Some(in_parallel(&numbers, self.goal.threads, |&i| {
            let step = self.goal.variables[i].step(&self.design.lens);
            // A step that leaves the bounds or loses a ray is taken to the other side.
            let along = |step: f64| {
                let mut near = variables.to_vec();
                near[i] += step;
                let found = self.at(&near)?;
                Some(found.iter().zip(residuals).map(|(a, b)| (a - b) / step).collect())
            };
            let inside = variables[i] + step <= self.goal.variables[i].bounds[1];
            let step = if inside { step } else { -step };
            along(step).or_else(|| along(-step)).unwrap_or_else(|| vec![0.0; residuals.len()])
        }))
    }

    fn bounds(&self, variable: usize) -> [f64; 2] {
        self.goal.variables[variable].bounds
    }
}

/// Optimizes a lens by damped least squares. `goes_on` is called at each iteration with its number
/// and the merit (mm); if it returns false, the best lens so far is the result.
///
/// # Errors
/// Returns an error if a glass has no data at a wavelength, a field is dark, or the lens at the
/// start has no merit.
pub fn optimize_design(
    lens: &Prescription,
    conditions: &ImagingConditions,
    goal: &DesignGoal,
    mut goes_on: impl FnMut(u32, f64) -> bool,
) -> Result<OptimizedDesign, OptimizationError> {
    let edges = EdgeConstraint::new(lens, goal.least_edge);
    let design = FilmedLens { lens: lens.clone(), film: conditions.film_distance };
    let mut function = VariableMerit::new(goal, design, conditions, &edges)?;
    // An image height that became an angle stays that angle.
    let conditions = function.merit.imaging.conditions.clone();
    let start = function.state().ok_or(OptimizationError::Start)?;
    let (mut end, mut done, mut reason) = (start.clone(), 0, StopReason::IterationLimit);
    for _ in 0..ROUNDS {
        let mut own = 0;
        let call = |iteration: u32, sum: f64| {
            own = iteration + 1;
            goes_on(done + iteration, sum.sqrt())
        };
        let found = minimize(&function, function.values(), goal.iterations - done, call);
        let Some((values, why)) = found else { break };
        (done, reason) = (done + own, why);
        let mut design = function.changed(&values);
        if goal.refocus != Refocus::Off {
            let film = function.merit.evaluate(&design).map_or(design.film, |value| value.film);
            design.film = film;
        }
        let Ok(next) = VariableMerit::new(goal, design, &conditions, &edges) else { break };
        let Some(state) = next.state() else { break };
        let before = end.merit;
        if state.merit >= before {
            break;
        }
        (function, end) = (next, state);
        let improves = before - end.merit > ROUND_DECREASE * before;
        if !improves || why == StopReason::Interrupted || done >= goal.iterations {
            break;
        }
    }
    let mut lens = function.design.lens;
    lens.design.film_distance = Some(end.film_distance);
    lens.design.configurations.clear();
    // The figures that the file states are those of the lens at the start.
    (lens.stated_focal_length, lens.stated_f_number) = (None, None);
    Ok(OptimizedDesign { lens, start, end, iterations: done, reason })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imaging::conditions::ConditionChoices;
    use petzval_lens::Row;

    #[test]
    fn derivatives_of_a_mirror_are_those_of_its_formula_from_inside_the_bounds() {
        let row =
            Row { radius: -200.0, diameter: 40.0, mirror: true, stop: true, ..Row::default() };
        let lens = Prescription::new("mirror", vec![row]).expect("one stop");
        let choices = ConditionChoices { image_height: Some(1.0), ..Default::default() };
        let conditions = ImagingConditions::new(&lens, choices).expect("a focus");
        let named = |name| DesignVariable::named(name, &lens).expect("a variable");
        let mut goal = DesignGoal {
            variables: ["film", "c1"].map(named).to_vec(),
            targets: ["film=90", "efl=90"].map(|target| target.parse().expect("a target")).to_vec(),
            refocus: Refocus::Off,
            least_edge: 0.1,
            shares: vec![0.0],
            rings: 2,
            iterations: 1,
            threads: 1,
        };
        let mut slopes = |most: f64| {
            goal.variables[1].bounds[1] = most;
            let design = FilmedLens { lens: lens.clone(), film: conditions.film_distance };
            let edges = EdgeConstraint::new(&lens, goal.least_edge);
            let merit = VariableMerit::new(&goal, design, &conditions, &edges).expect("rays");
            let at = merit.values();
            let residuals = merit.at(&at).expect("residuals");
            let [film, c] = &merit.derivatives(&at, &residuals).expect("derivatives")[..] else {
                panic!("two columns")
            };
            assert!(
                (film[0] - 1.0).abs() < 1e-6 && film[1] == 0.0 && c[0] == 0.0,
                "{film:?} {c:?}"
            );
            c[1]
        };
        // f = -1 / (2 c) has the slope 1 / (2 c²), which grows with c.
        let (free, bound, exact) = (slopes(f64::INFINITY), slopes(-0.005), 20_000.0);
        assert!(exact < free && free < exact * (1.0 + 1e-5), "{free}");
        assert!(exact * (1.0 - 1e-5) < bound && bound < exact, "{bound}");
    }
}
