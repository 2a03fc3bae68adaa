//! Accuracy report of `petzval accuracy`: page, plot, CSV, JSON and advice.

mod advice;
mod crops;
mod export;
mod page;
mod plot;

use std::time::Duration;

use petzval_render::plan::Effect;
use petzval_tools::accuracy::{Ladder, LadderRun, Machine, Point, RelativeTime, RunEnd};

use super::svg;
use advice::{recommendation, two_digits, verdicts};

pub use advice::Verdict;

/// Names of the report's files, the page last.
pub const FILES: [&str; 5] =
    ["accuracy.csv", "accuracy.json", "plot.svg", "plot.png", "index.html"];

/// The measurements of a ladder and what they were made with.
#[derive(Clone, Debug)]
pub struct AccuracyReport<'a> {
    /// Name of the scene file.
    pub scene: String,
    /// Command line of the run, without the program's folder.
    pub command: String,
    /// Camera models.
    pub ladder: &'a Ladder,
    /// Their measurements.
    pub run: &'a LadderRun,
    /// Allowed time.
    pub budget: Duration,
    /// Machine of the measurements.
    pub machine: Machine,
}

/// Formats a relative time for a table; a question mark for one that is not reliable.
pub fn times(time: Option<RelativeTime>) -> String {
    match time {
        None => "-".to_owned(),
        Some(time) if !time.reliable() => "?".to_owned(),
        Some(time) => format!("{:.2}", time.times),
    }
}

impl AccuracyReport<'_> {
    /// Judges every rung that was measured.
    pub fn verdicts(&self) -> Vec<Verdict> {
        verdicts(self.ladder, self.run)
    }

    /// Recommends a model in a sentence or more; `None` if a rung was not measured.
    pub fn recommendation(&self) -> Option<String> {
        let Self { ladder, budget, .. } = self;
        let names: Vec<&str> = ladder.rungs.iter().map(|rung| rung.name.as_str()).collect();
        recommendation(&names, ladder.usual()?, &self.verdicts(), *budget)
    }

    /// Returns the contents of all files, in the order of [`FILES`].
    ///
    /// # Errors
    /// Returns an error if a file cannot be encoded.
    pub fn files(&self) -> Result<[Vec<u8>; 5], Box<dyn std::error::Error>> {
        let verdicts = self.verdicts();
        let recommendation = self.recommendation();
        let svg = plot::file(self);
        let png = svg::png(&svg)?;
        let json = export::json(self, &verdicts, recommendation.as_deref());
        let page = page::page(self, &verdicts, recommendation.as_deref())?;
        let json = format!("{json:#}\n").into_bytes();
        Ok([export::csv(self)?, json, svg.into_bytes(), png, page.into_bytes()])
    }

    /// Says why the report is not whole, if so.
    pub fn partial(&self) -> Option<&'static str> {
        match self.run.end {
            RunEnd::Planned => None,
            RunEnd::Early => Some(
                "This report is partial: the budget was over before every model had a picture.",
            ),
            RunEnd::Interrupted => Some("This report is partial: it was interrupted."),
        }
    }

    /// Formats the model's own error at this point, or the change by the effect that it adds, with
    /// two significant digits (%).
    pub fn own(&self, point: &Point) -> String {
        let sign = if self.ladder.rungs[point.rung].adds.is_some() { "+" } else { "" };
        match point.bias {
            Some(bias) if bias.certain() => format!("{sign}{}", two_digits(100.0 * bias.size())),
            Some(bias) => format!("<{}", two_digits(100.0 * bias.at_most())),
            None => "-".to_owned(),
        }
    }

    /// Lists the effects that the ladder does not compare.
    pub fn not_compared(&self) -> Option<String> {
        let one = |(effect, why): &(Effect, &str)| format!("{} ({why})", effect.name());
        let words: Vec<String> = self.ladder.not_compared.iter().map(one).collect();
        (!words.is_empty()).then(|| format!("Effects not compared: {}.", words.join(", ")))
    }
}
