//! Summary of a finished render: what, time, plan, file, and what to do next.

use std::path::Path;
use std::time::Duration;

use petzval_image::{BitDepth, EncodingOptions, ImageFormat, Note, Notes, find_note};
use petzval_render::job::Job;
use petzval_render::plan::Plan;

use crate::cli::arguments::argv::{parse_render, shell_line};
use crate::cli::screen::{columns, wrap};

/// Width of the first column (characters).
const LABEL: usize = 9;

/// Facts about a finished picture that is alone, not one of a sweep.
pub(super) struct RenderSummary<'a> {
    pub job: &'a Job,
    pub notes: &'a Notes,
    /// The command line that rendered it.
    pub rendered_by: &'a [String],
    pub output: &'a Path,
    pub size: [usize; 2],
    /// Samples per pixel, with their noise if it was measured.
    pub samples: &'a str,
    /// Time of the command, and of its parts.
    pub time: &'a str,
    pub encoding: EncodingOptions,
    /// Exposure in stops that an automatic choice found, for files for display.
    pub found_stops: Option<f64>,
    /// Chromaticities of the white that an automatic choice found.
    pub found_white: Option<[f64; 2]>,
}

impl RenderSummary<'_> {
    /// Prints five lines, which are broken if the terminal is narrower.
    pub fn print(&self) {
        let lines = [
            ("picture", self.picture()),
            ("time", self.time.to_owned()),
            ("plan", plan_line(&self.job.plan)),
            ("file", self.file()),
            ("next", self.next()),
        ];
        for (label, text) in lines {
            let line = format!("{:<LABEL$}{text}", format!("{label}:"));
            say!("{}", wrap(&line, columns(), LABEL));
        }
    }

    fn picture(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!("{width} x {height} pixels, {}", self.samples);
        if let Some(Note::Text(lens)) = self.note("lensModel") {
            text += &format!("; {lens}");
            if let Some(Note::Number(f_number)) = self.note("aperture") {
                text += &format!(", f/{}", significant(*f_number));
            }
            if let Some(Note::Number(focus)) = self.note("focus") {
                text += &match focus.is_finite() {
                    true => format!(", focus {} m", significant(*focus)),
                    false => ", focus at infinity".to_owned(),
                };
            }
        }
        text
    }

    fn note(&self, name: &str) -> Option<&Note> {
        find_note(self.notes, name)
    }

    fn file(&self) -> String {
        let name = self.output.display();
        let format = ImageFormat::of(self.output).ok();
        if let (Some(ImageFormat::Dng), Some(sensor)) = (format, &self.job.sensor) {
            return format!("{name}, raw mosaic, {}-bit codes", sensor.bits);
        }
        let depth = format.and_then(|format| format.display_depth(self.encoding.bit_depth));
        let Some(depth) = depth else {
            let bits = if self.encoding.half { 16 } else { 32 };
            let buckets = self.job.buckets().map_or(String::new(), |shares| {
                let buckets = shares.buckets();
                let (count, [first, last]) = (buckets.count(), buckets.range());
                format!(", {count} buckets of wavelength from {first} to {last} nm")
            });
            return format!("{name}, linear light, {bits}-bit floats{buckets}");
        };
        let bits = match depth {
            BitDepth::Eight => 8,
            BitDepth::Sixteen => 16,
        };
        let mut found = Vec::new();
        let mut locks = Vec::new();
        if let Some(stops) = self.found_stops {
            found.push(format!("{stops:+.2} EV"));
            locks.push(format!("--exposure={stops:.2}"));
        }
        if let Some([x, y]) = self.found_white {
            found.push(format!("white {x:.4},{y:.4}"));
            locks.push(format!("--white-balance={x:.4},{y:.4}"));
        }
        let locks_them = match locks.len() {
            0 => return format!("{name}, {bits} bits"),
            1 => "locks it",
            _ => "lock them",
        };
        let (found, locks) = (found.join(" and "), locks.join(" "));
        format!("{name}, {bits} bits, {found} found; {locks} {locks_them} for a series")
    }

    fn is_linear(&self) -> bool {
        ImageFormat::of(self.output).is_ok_and(ImageFormat::is_linear)
    }

    fn next(&self) -> String {
        let scene = parse_render(self.rendered_by).map(|arguments| arguments.picture.scene);
        let view = scene.map_or_else(
            |_| "petzval view".to_owned(),
            |scene| {
                let words = ["petzval", "view", &scene.to_string_lossy()].map(str::to_owned);
                shell_line(&words)
            },
        );
        let screen = if self.is_linear() { "; -o FILE.png for any screen" } else { "" };
        format!("{view} to try focus and stop{screen}; -v for tables")
    }
}

/// Lists the simulated effects in a line.
fn plan_line(plan: &Plan) -> String {
    let on = plan.effects.iter().filter(|decision| decision.on);
    let on: Vec<&str> = on.map(|decision| decision.effect.name()).collect();
    let off = plan.effects.len() - on.len();
    match (on.is_empty(), off) {
        (true, _) => "no effects are simulated; petzval plan says why".to_owned(),
        (false, 0) => format!("{}: all effects", on.join(", ")),
        (false, 1) => format!("{}; 1 effect is off; petzval plan says why", on.join(", ")),
        (false, off) => format!("{}; {off} effects are off; petzval plan says why", on.join(", ")),
    }
}

/// Formats a number above 0 with three significant digits.
fn significant(number: f64) -> String {
    let decimals = match number.abs() {
        size if size >= 100.0 => 0,
        size if size >= 10.0 => 1,
        _ => 2,
    };
    format!("{number:.decimals$}")
}

/// Formats seconds.
pub(super) fn seconds(time: Duration) -> String {
    format!("{:.2} s", time.as_secs_f64())
}
