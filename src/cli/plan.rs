//! `petzval plan`: the effects of a picture, also in the log of a render.

use petzval_render::job::Job;
use petzval_render::memory::machine;
use petzval_render::plan::{Cost, Decision, LightTracingDecision, OmissionError, Plan};
use petzval_render::prepare::{Prepared, prepare};

use serde_json::{Value, json};

use super::arguments::PictureArguments;
use super::progress::film_samples;
use super::screen::{output_columns, wrap};
use super::{Failure, Outcome, message};

/// Arguments of `petzval plan`.
#[derive(Debug, clap::Args)]
pub(super) struct PlanArguments {
    #[command(flatten)]
    picture: PictureArguments,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &PlanArguments) -> Result<Outcome, Failure> {
    let description = petzval_scene_formats::read(&arguments.picture.scene)?;
    let Prepared { job, warnings, .. } = prepare(description, &arguments.picture.changes())?;
    message::warnings(&warnings);
    let work = Work::of(&job, machine::cores());
    let text = match arguments.json {
        true => format!("{:#}\n", json(&job.plan, work)),
        false => table(&job.plan, work, output_columns()),
    };
    super::print(&text)
}

/// Returns the plan as a JSON object.
pub(super) fn json(plan: &Plan, work: Work) -> Value {
    let row = |decision: &Decision| {
        let Decision { effect, on, by, reason, error, cost } = decision;
        json!({
            "effect": effect.name(),
            "on": on,
            "by": by.name(),
            "reason": reason,
            "error": error.map(|harm| match harm {
                OmissionError::Blur { um, pixels } => json!({ "um": um, "px": pixels }),
                OmissionError::Signal(percent) => json!({ "percent": percent }),
                OmissionError::Colour { percent, difference } => {
                    json!({ "percent": percent, "de2000": difference })
                }
            }),
            "cost": cost.map(|cost| {
                let Cost { ns_per_ray, percent } = cost;
                let seconds = work.seconds(cost);
                json!({ "ns_per_ray": ns_per_ray, "percent": percent, "seconds": seconds })
            }),
        })
    };
    let LightTracingDecision { on, by, reason } = &plan.light_paths;
    json!({
        "effects": plan.effects.iter().map(row).collect::<Vec<Value>>(),
        "light_paths": { "on": on, "by": by.name(), "reason": reason },
    })
}

/// Work of a picture, for the prices of its effects.
#[derive(Clone, Copy, Debug)]
pub(super) struct Work {
    /// Samples of all pixels.
    samples: u64,
    threads: usize,
}

impl Work {
    /// Returns the work of a picture on this many threads.
    pub fn of(job: &Job, threads: usize) -> Self {
        Self { samples: film_samples(job), threads: threads.max(1) }
    }

    /// Returns the expected time that an effect takes of this picture (s).
    fn seconds(self, Cost { ns_per_ray, .. }: Cost) -> f64 {
        1e-9 * ns_per_ray * self.samples as f64 / self.threads as f64
    }
}

/// Width of the columns before the reason (characters).
const BEFORE_REASON: usize = 68;

/// Formats the plan as a table, a line for each effect, and a line for the light paths. Reasons are
/// broken to lines of this width.
pub(super) fn table(plan: &Plan, work: Work, columns: usize) -> String {
    // Reasons stand beside the numbers if there is room, and below them on a narrow terminal.
    let indent = if columns > BEFORE_REASON + 30 { BEFORE_REASON } else { 4 };
    let row = |numbers: String, reason: &str| match indent == BEFORE_REASON {
        true => wrap(&format!("{numbers:<BEFORE_REASON$}{reason}"), columns, indent) + "\n",
        false => {
            let reason = wrap(&format!("{:indent$}{reason}", ""), columns, indent);
            format!("{}\n{}\n", numbers.trim_end(), reason)
        }
    };
    let mut text = row(
        format!(
            "{:<16}{:<5}{:<7}{:>18}{:>9}{:>11}",
            "effect", "on", "by", "without it", "adds", "ns/sample"
        ),
        "reason",
    );
    for Decision { effect, on, by, reason, error, cost } in &plan.effects {
        let dash = || "-".to_owned();
        let error = error.map_or_else(dash, |harm| harm.to_string());
        let seconds = cost.map_or_else(dash, |cost| brief_seconds(work.seconds(cost)));
        let cost = cost.map_or_else(dash, |cost| format!("{:.1}", cost.ns_per_ray));
        let on = if *on { "on" } else { "off" };
        let (effect, by) = (effect.name(), by.name());
        text +=
            &row(format!("{effect:<16}{on:<5}{by:<7}{error:>18}{seconds:>9}{cost:>11}"), reason);
    }
    let light_paths = wrap(&format!("light paths: {}", plan.light_paths), columns, 4);
    let Work { samples, threads } = work;
    let basis = format!(
        "adds: estimated time for this picture of {} samples on {threads} threads",
        grouped(samples)
    );
    text + &format!("{light_paths}\n{}\n", wrap(&basis, columns, 4))
}

/// Formats a duration with its unit and two or three digits.
fn brief_seconds(seconds: f64) -> String {
    match seconds {
        s if s < 0.001 => "< 1 ms".to_owned(),
        s if s < 1.0 => format!("{:.0} ms", 1e3 * s),
        s if s < 100.0 => format!("{s:.1} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// Formats a number of samples: `960`, `1.2 million`.
fn grouped(samples: u64) -> String {
    match samples {
        0..=999_999 => samples.to_string(),
        _ => format!("{:.1} million", samples as f64 / 1e6),
    }
}
