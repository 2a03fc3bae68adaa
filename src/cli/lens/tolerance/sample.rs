//! Trials of an analysis, ranked.

use petzval_optics::{LensFigures, ToleranceAnalysis, ToleranceEffect, ToleranceTrial, percentile};

/// Figure that ranks lenses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Criterion {
    /// Spot radius of all fields.
    Spot,
    /// Lowest modulation.
    Modulation,
}

/// An analysis with its trials.
pub(super) struct ToleranceSample {
    pub analysis: ToleranceAnalysis,
    pub trials: Vec<ToleranceTrial>,
    /// Numbers of the trials, the worst first.
    pub ranked: Vec<usize>,
    /// Effects of the tolerances, the worst first.
    pub effects: Vec<ToleranceEffect>,
}

/// Shares of the lenses whose figures are printed.
pub(super) const SHARES: [f64; 5] = [0.1, 0.5, 0.8, 0.9, 0.98];

impl ToleranceSample {
    pub fn new(analysis: ToleranceAnalysis, count: u64, criterion: Criterion) -> Self {
        let trials = analysis.trials(count);
        let mut effects = analysis.effects(&trials);
        let mut ranked: Vec<usize> = (0..trials.len()).collect();
        let figures = |i: usize| &trials[i].figures;
        match criterion {
            Criterion::Spot => {
                ranked.sort_by(|&a, &b| figures(b).spot().total_cmp(&figures(a).spot()));
            }
            Criterion::Modulation => {
                ranked
                    .sort_by(|&a, &b| figures(a).modulation().total_cmp(&figures(b).modulation()));
                effects.sort_by(|a, b| a.worst_modulation().total_cmp(&b.worst_modulation()));
            }
        }
        Self { analysis, trials, ranked, effects }
    }

    /// Returns the values of a figure that these shares of the lenses keep, and the worst: no more
    /// than each, or no less if `larger` values are better.
    pub fn distribution(&self, larger: bool, figure: impl Fn(&LensFigures) -> f64) -> Vec<f64> {
        let mut values: Vec<f64> = self.trials.iter().map(|trial| figure(&trial.figures)).collect();
        values.sort_by(f64::total_cmp);
        if larger {
            values.reverse();
        }
        SHARES.iter().chain(&[1.0]).map(|share| percentile(&values, *share)).collect()
    }
}
