//! Report of a measurement: plots, numbers, and one page of both.

mod plots;

use std::fmt::Write as _;

use crate::page::{begin, end};
use crate::plot::Plot;
use crate::svg::escape;

/// A measurement for people to read.
#[derive(Clone, Debug)]
pub struct MeasurementReport {
    /// Name of the measurement and of what was measured.
    pub title: String,
    /// Plots, the first of which tells most.
    pub plots: Vec<Plot>,
    /// Numbers as text in columns.
    pub text: String,
}

impl MeasurementReport {
    /// Returns the first plot as an SVG file.
    pub fn svg(&self) -> String {
        self.plots.first().map(Plot::file).unwrap_or_default()
    }

    /// Returns one page of HTML without scripts or other files. `command` made it.
    pub fn page(&self, command: &str) -> String {
        let mut page = begin(&self.title);
        let _ = writeln!(page, "<h1>{}</h1>\n<div class=\"plots\">", escape(&self.title));
        for plot in &self.plots {
            let _ = writeln!(page, "<figure>{}</figure>", plot.inline());
        }
        let _ = writeln!(page, "</div>\n<pre>{}</pre>", escape(&self.text));
        end(&mut page, command);
        page
    }
}
