//! `petzval plan`: the effects of a picture, also in the log of a render.

use petzval::plan::{Cost, Decision, LightPathDecision, OmissionError, Plan};
use petzval::prepare::prepare;
use petzval::scene;
use serde_json::{Value, json};

use super::arguments::PictureArguments;
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
    let description = scene::read(&arguments.picture.scene)?;
    let (job, _, warnings) = prepare(description, &arguments.picture.changes())?;
    message::warnings(&warnings);
    let text = match arguments.json {
        true => format!("{:#}\n", json(&job.plan)),
        false => table(&job.plan),
    };
    super::print(&text)
}

/// Returns the plan as a JSON object.
pub(super) fn json(plan: &Plan) -> Value {
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
            }),
            "cost": cost.map(|Cost { ns_per_ray, percent }| {
                json!({ "ns_per_ray": ns_per_ray, "percent": percent })
            }),
        })
    };
    let LightPathDecision { on, by, reason } = &plan.light_paths;
    json!({
        "effects": plan.effects.iter().map(row).collect::<Vec<Value>>(),
        "light_paths": { "on": on, "by": by.name(), "reason": reason },
    })
}

/// Formats the plan as a table, a line for each effect, and a line for the light paths.
pub(super) fn table(plan: &Plan) -> String {
    let mut text = format!(
        "{:<16}{:<5}{:<7}{:>18}{:>10}  {}\n",
        "effect", "on", "by", "without it", "ns/ray", "reason"
    );
    for Decision { effect, on, by, reason, error, cost } in &plan.effects {
        let dash = || "-".to_owned();
        let error = error.map_or_else(dash, |harm| harm.to_string());
        let cost = cost.map_or_else(dash, |cost| format!("{:.1}", cost.ns_per_ray));
        let on = if *on { "on" } else { "off" };
        text += &format!(
            "{:<16}{on:<5}{:<7}{error:>18}{cost:>10}  {reason}\n",
            effect.name(),
            by.name()
        );
    }
    text + &format!("light paths: {}\n", plan.light_paths)
}
