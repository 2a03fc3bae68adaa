//! The report: everything that was found, and its files.

use std::time::Duration;

use super::advice::{Verdict, choice, verdicts};
use super::climb::Climb;
use super::machine::Machine;
use super::rung::Ladder;
use super::{page, plot, table};

/// The files of a report, the page last.
pub const FILES: [&str; 5] =
    ["accuracy.csv", "accuracy.json", "plot.svg", "plot.png", "index.html"];

/// What there is to report.
#[derive(Clone, Debug)]
pub struct Report<'a> {
    /// Name of the scene.
    pub scene: String,
    /// The command line that made it, without the program's folder.
    pub command: String,
    /// The models.
    pub ladder: &'a Ladder,
    /// What was found of them.
    pub climb: &'a Climb,
    /// The time that was allowed.
    pub budget: Duration,
    /// What it was measured on.
    pub machine: Machine,
}

impl Report<'_> {
    /// What is to be said of every rung.
    pub fn verdicts(&self) -> Vec<Verdict> {
        verdicts(self.ladder, self.climb)
    }

    /// What to take, in a sentence; `None` where not everything could be tried.
    pub fn choice(&self) -> Option<String> {
        let Self { ladder, budget, .. } = self;
        let names: Vec<&str> = ladder.rungs.iter().map(|rung| rung.name.as_str()).collect();
        choice(&names, ladder.usual()?, &self.verdicts(), *budget)
    }

    /// Every file of the report, in the order of [`FILES`].
    ///
    /// # Errors
    /// Where one cannot be made: no report does that to its writer.
    pub fn files(&self) -> Result<[Vec<u8>; 5], Box<dyn std::error::Error>> {
        let verdicts = self.verdicts();
        let choice = self.choice();
        let svg = plot::alone(self);
        let png = crate::svg::raster(&svg)?;
        let json = table::json(self, &verdicts, choice.as_deref());
        let page = page::page(self, &verdicts, choice.as_deref())?;
        let json = format!("{json:#}\n").into_bytes();
        Ok([table::csv(self)?, json, svg.into_bytes(), png, page.into_bytes()])
    }
}
