//! The report for programs: CSV and JSON.

use serde_json::{Value, json};

use super::Ended;
use super::advice::Verdict;
use super::point::Point;
use super::report::Report;
use crate::stats::Stage;

/// Columns of the CSV before those of the stages.
const COLUMNS: [&str; 18] = [
    "model",
    "spp",
    "seconds",
    "lens_seconds",
    "film_error_um",
    "film_corner_um",
    "error",
    "mse",
    "relmse",
    "flip",
    "noise",
    "bias",
    "bias_error",
    "bias_deviations",
    "bias_certain",
    "on_frontier",
    "rays_per_second",
    "film_error_px",
];

/// A row for every point.
pub(super) fn csv(report: &Report) -> Result<Vec<u8>, csv::Error> {
    let mut file = csv::Writer::from_writer(Vec::new());
    let stages = Stage::ALL.map(|stage| format!("cpu_{}_seconds", stage.name()));
    file.write_record(COLUMNS.iter().map(|name| (*name).to_owned()).chain(stages))?;
    for point in &report.climb.points {
        file.write_record(row(report, point))?;
    }
    file.into_inner().map_err(|error| error.into_error().into())
}

fn row(report: &Report, point: &Point) -> Vec<String> {
    let rung = &report.ladder.rungs[point.rung];
    let number = |value: f64| format!("{value:.6e}");
    let of_bias =
        |f: fn(&super::Bias) -> f64| point.bias.map_or_else(String::new, |bias| number(f(&bias)));
    let mut row = vec![
        rung.name.clone(),
        point.samples.to_string(),
        number(point.seconds),
        number(point.lens_seconds()),
        number(rung.film.rms_um),
        number(rung.film.corner_um),
        number(point.error),
        number(point.mse),
        number(point.relmse),
        number(point.flip),
        number(point.noise),
        of_bias(|bias| bias.square),
        of_bias(|bias| bias.error),
        of_bias(|bias| bias.deviations),
        point.bias.map_or_else(String::new, |bias| bias.certain().to_string()),
        point.on_frontier.to_string(),
        number(point.rays),
        number(rung.film.rms_um / report.ladder.pitch()),
    ];
    row.extend(point.stages.iter().map(|&seconds| number(seconds)));
    row
}

/// Everything, as one object.
pub(super) fn json(report: &Report, verdicts: &[Verdict], choice: Option<&str>) -> Value {
    let Report { scene, command, ladder, climb, budget, machine } = report;
    let point = |point: &Point| {
        let stages: serde_json::Map<String, Value> = Stage::ALL
            .iter()
            .map(|&stage| (stage.name().to_owned(), json!(point.stages[stage as usize])))
            .collect();
        json!({
            "spp": point.samples,
            "seconds": point.seconds,
            "cpu_seconds": stages,
            "rays_per_second": point.rays,
            "error": point.error,
            "mse": point.mse,
            "relmse": point.relmse,
            "flip": point.flip,
            "noise": point.noise,
            "bias": point.bias.map(|bias| json!({
                "square": bias.square,
                "error": bias.error,
                // JSON has no infinity.
                "deviations": bias.deviations.clamp(-1e9, 1e9),
                "certain": bias.certain(),
            })),
            "on_frontier": point.on_frontier,
        })
    };
    let rung = |(i, rung): (usize, &super::Rung)| {
        let film = &rung.film;
        let verdict = verdicts.iter().find(|verdict| verdict.rung == i);
        json!({
            "model": rung.name,
            "about": rung.sentence,
            "fidelity": rung.fidelity.name(),
            "film": {
                "rms_um": film.rms_um,
                "corner_um": film.corner_um,
                "p95_um": film.p95_um,
                "lost": film.lost,
                "light": film.light,
            },
            "adds": rung.adds.map(|effect| effect.name()),
            "times": verdict.and_then(|verdict| verdict.pace).map(|pace| pace.times),
            "times_tolerance": verdict.and_then(|verdict| verdict.pace).map(|pace| pace.tolerance),
            "visible": verdict.and_then(|verdict| verdict.visible),
            "verdict": verdict.map(|verdict| &verdict.sentence),
            "points": climb.points.iter().filter(|p| p.rung == i).map(point).collect::<Vec<_>>(),
        })
    };
    json!({
        "scene": scene,
        "lens": ladder.lens,
        "resolution": ladder.size(),
        "pixel_um": ladder.pitch(),
        "budget_seconds": budget.as_secs_f64(),
        "seconds": climb.seconds,
        "ended": match climb.ended {
            Ended::Planned => "planned",
            Ended::Early => "early",
            Ended::Interrupted => "interrupted",
        },
        "left_out": ladder.aside.iter().map(|(effect, why)| {
            json!({ "effect": effect.name(), "why": why })
        }).collect::<Vec<_>>(),
        "command": command,
        "machine": {
            "cpu": machine.cpu,
            "threads": machine.threads,
            "system": machine.system,
        },
        "version": machine.version,
        "reference": climb.reference.as_ref().map(|reference| json!({
            "spp": reference.samples,
            "seconds": reference.seconds,
            "noise": reference.noise,
        })),
        "models": ladder.rungs.iter().enumerate().map(rung).collect::<Vec<_>>(),
        "advice": choice,
    })
}
