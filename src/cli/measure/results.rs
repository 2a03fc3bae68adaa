//! Output options of a measurement.

use std::path::PathBuf;

use petzval_base::io::{Outputs, ReadContext};
use petzval_report::measurement::MeasurementReport;
use serde_json::Value;

use super::super::arguments::argv::{argv, shell_line};
use super::super::outputs::write_text;
use super::super::{Failure, Outcome};

/// Options for the results.
#[derive(Debug, clap::Args)]
pub(super) struct ResultArguments {
    /// Write the numbers as a table
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write the plot
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Write one page with plots and numbers
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl ResultArguments {
    /// Writes and prints the results: a table, a report and a JSON object of the same numbers. Files are none of those that
    /// were read.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn finish(
        &self,
        context: &ReadContext,
        table: &str,
        report: &MeasurementReport,
        json: &Value,
    ) -> Result<Outcome, Failure> {
        let outputs = Outputs::beside(&context.files());
        if let Some(csv) = &self.csv {
            write_text(&outputs, csv, "--csv", table)?;
        }
        if let Some(svg) = &self.svg {
            write_text(&outputs, svg, "--svg", &report.svg())?;
        }
        if let Some(html) = &self.html {
            write_text(&outputs, html, "--html", &report.page(&shell_line(&argv())))?;
        }
        super::super::print(&match self.json {
            true => format!("{json:#}\n"),
            false => report.text.clone(),
        })
    }
}
