//! CSV and JSON of the report, for programs.

use petzval_base::stats::Stage;
use petzval_tools::accuracy::{Bias, Point, RunEnd, Rung};
use serde_json::{Value, json};

use super::{AccuracyReport, Verdict};

/// A point of the report, for the columns of the CSV.
struct CsvRow<'a> {
    report: &'a AccuracyReport<'a>,
    rung: &'a Rung,
    point: &'a Point,
}

/// Name of a column, and its cell in a row.
type CsvColumn = (&'static str, fn(&CsvRow) -> String);

/// Columns of the CSV before those of the stages.
const COLUMNS: [CsvColumn; 18] = [
    ("model", |row| row.rung.name.clone()),
    ("spp", |row| row.point.samples.to_string()),
    ("seconds", |row| number(row.point.seconds)),
    ("lens_seconds", |row| number(row.point.lens_seconds())),
    ("film_error_um", |row| number(row.rung.film.rms_um)),
    ("film_corner_um", |row| number(row.rung.film.corner_um)),
    ("error", |row| number(row.point.error)),
    ("mse", |row| number(row.point.mse)),
    ("relmse", |row| number(row.point.relmse)),
    ("flip", |row| number(row.point.flip)),
    ("noise", |row| number(row.point.noise)),
    ("bias", |row| row.bias(|bias| number(bias.square))),
    ("bias_error", |row| row.bias(|bias| number(bias.error))),
    ("bias_deviations", |row| row.bias(|bias| number(bias.deviations))),
    ("bias_certain", |row| row.bias(|bias| bias.certain().to_string())),
    ("on_frontier", |row| row.point.on_frontier.to_string()),
    ("rays_per_second", |row| number(row.point.rays)),
    ("film_error_px", |row| number(row.rung.film.rms_um / row.report.ladder.pitch())),
];

impl CsvRow<'_> {
    /// Returns a cell about the bias, empty for the richest model.
    fn bias(&self, cell: fn(&Bias) -> String) -> String {
        self.point.bias.as_ref().map_or_else(String::new, cell)
    }
}

fn number(value: f64) -> String {
    format!("{value:.6e}")
}

/// Returns the CSV, a row for every point.
pub(super) fn csv(report: &AccuracyReport) -> Result<Vec<u8>, csv::Error> {
    let mut file = csv::Writer::from_writer(Vec::new());
    let stages = Stage::ALL.map(|stage| format!("cpu_{}_seconds", stage.name()));
    file.write_record(COLUMNS.iter().map(|(name, _)| (*name).to_owned()).chain(stages))?;
    for point in &report.run.points {
        let row = CsvRow { report, rung: &report.ladder.rungs[point.rung], point };
        let stages = point.stages.iter().map(|&seconds| number(seconds));
        file.write_record(COLUMNS.iter().map(|(_, cell)| cell(&row)).chain(stages))?;
    }
    file.into_inner().map_err(|error| error.into_error().into())
}

/// Returns the whole report as one JSON object.
pub(super) fn json(
    report: &AccuracyReport,
    verdicts: &[Verdict],
    recommendation: Option<&str>,
) -> Value {
    let AccuracyReport { scene, command, ladder, run, budget, machine } = report;
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
    let rung = |(i, rung): (usize, &Rung)| {
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
            "times": verdict.and_then(|verdict| verdict.time).map(|time| time.times),
            "times_tolerance": verdict.and_then(|verdict| verdict.time).map(|time| time.tolerance),
            "times_reliable": verdict.and_then(|verdict| verdict.time).map(|time| time.reliable()),
            "visible": verdict.and_then(|verdict| verdict.visible),
            "verdict": verdict.map(|verdict| &verdict.sentence),
            "points": run.points.iter().filter(|p| p.rung == i).map(point).collect::<Vec<_>>(),
        })
    };
    json!({
        "scene": scene,
        "lens": ladder.lens,
        "resolution": ladder.size(),
        "pixel_um": ladder.pitch(),
        "budget_seconds": budget.as_secs_f64(),
        "seconds": run.seconds,
        "ended": match run.end {
            RunEnd::Planned => "planned",
            RunEnd::Early => "early",
            RunEnd::Interrupted => "interrupted",
        },
        "left_out": ladder.not_compared.iter().map(|(effect, why)| {
            json!({ "effect": effect.name(), "why": why })
        }).collect::<Vec<_>>(),
        "command": command,
        "machine": {
            "cpu": machine.cpu,
            "threads": machine.threads,
            "system": machine.system,
        },
        "version": machine.version,
        "reference": run.reference.as_ref().map(|reference| json!({
            "spp": reference.samples,
            "seconds": reference.seconds,
            "noise": reference.noise,
        })),
        "models": ladder.rungs.iter().enumerate().map(rung).collect::<Vec<_>>(),
        "advice": recommendation,
    })
}
