//! `petzval accuracy`: measures a ladder of camera models and reports what accuracy costs.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use petzval_base::io::OutputFile;
use petzval_render::RenderError;
use petzval_render::prepare::{Changes, PrepareError, settings};
use petzval_tools::accuracy::{Budget, Ladder, Machine, RunEnd, RunMonitor, run_ladder};

use super::arguments::PictureArguments;
use super::arguments::argv::{argv, shell_line};
use super::arguments::values::typed;
use super::message;
use super::outputs::{CreatedFolders, claim};
use super::progress::TimeBar;
use super::signals::on_stop;
use super::{Failure, Outcome};
use petzval_report::accuracy::{AccuracyReport, FILES, times as relative_time};

/// Arguments of `petzval accuracy`.
#[derive(Debug, clap::Args)]
pub(super) struct AccuracyArguments {
    /// Folder for the report: index.html, plot.svg, plot.png, accuracy.csv, accuracy.json
    #[arg(short, long, value_name = "FOLDER", default_value = "report")]
    output: PathBuf,
    /// Total time; --spp is then the largest number of samples per pixel
    ///
    /// Reading the scene counts, but is not cut short
    #[arg(
        long,
        value_name = "60s",
        value_parser = budget,
        allow_hyphen_values = true,
        default_value = "60s"
    )]
    budget: Duration,
    /// Render only a part of the picture; X1 and Y1 are not included
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = typed(settings::crop))]
    crop: Option<[[u32; 2]; 2]>,
    #[command(flatten)]
    picture: PictureArguments,
}

/// Most samples per pixel without --spp.
pub(super) const DEFAULT_SAMPLES: u32 = 1 << 20;

/// Fewest samples per pixel: one for each quarter.
const MIN_SAMPLES: u32 = 4;

/// Subfolder of a partial report if there is a whole one.
const PARTIAL: &str = "report.partial";

pub(super) fn run(arguments: &AccuracyArguments) -> Result<Outcome, Failure> {
    let begun = Instant::now();
    let AccuracyArguments { output, budget: time, crop, picture } = arguments;
    let changes = Changes { crop: *crop, ..picture.changes() };
    if let Some(spp) = changes.samples.filter(|&spp| spp < MIN_SAMPLES) {
        let reason = "every model takes four quarters of its samples, to measure noise";
        return Err(format!("--spp {spp}: {reason}; expected {MIN_SAMPLES} or more").into());
    }
    let description = petzval_scene_formats::read(&picture.scene)?;
    // Fail now rather than after a long run.
    let folder = output.display();
    let mut folders = CreatedFolders::default();
    let probe = || petzval_base::io::check_writable(&output.join(FILES[0]));
    folders.create(output).and_then(|()| probe()).map_err(|error| {
        format!("cannot write to the folder {folder}: {error}; name another with -o")
    })?;
    let monitor = Arc::new(RunMonitor::default());
    let stop = monitor.clone();
    on_stop(move || stop.interrupt());
    let ladder = monitor.until(begun + *time, || Ladder::new(&description, &changes, &monitor));
    let mut ladder = match ladder {
        Err(PrepareError::Pilot(RenderError::Stopped)) => {
            return end_without_report(&monitor, *time);
        }
        other => other?,
    };
    let outputs = picture.lens_file.outputs(ladder.files());
    let claim = |folder: &Path| -> Result<Vec<OutputFile>, Failure> {
        FILES.iter().map(|name| claim(&outputs, folder.join(name), "-o")).collect()
    };
    let (whole, partial) = (claim(output)?, claim(&output.join(PARTIAL))?);
    message::warnings(&ladder.warnings);
    let samples = changes.samples.unwrap_or(DEFAULT_SAMPLES);
    let budget = Budget { begun, time: *time, samples };
    let bar = TimeBar::start(begun, *time, monitor.clone());
    let run = run_ladder(&mut ladder, &budget, &monitor);
    bar.finish();
    let run = run?;
    let scene = picture.scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if run.points.is_empty() {
        return end_without_report(&monitor, *time);
    }
    let report = AccuracyReport {
        scene,
        command: shell_line(&argv()),
        ladder: &ladder,
        run: &run,
        budget: *time,
        machine: Machine::this(),
    };
    let beside = keeps_whole(output, report.partial().is_some());
    let output = &if beside { output.join(PARTIAL) } else { output.clone() };
    let folder = output.display();
    write(&report, output, if beside { &partial } else { &whole })?;
    super::print(&table(&report))?;
    if let Some(words) = report.partial() {
        say!("petzval: {words}");
    }
    say!(
        "{folder}: {} in {:.1} s, of a budget of {} s; see {}",
        FILES.join(", "),
        begun.elapsed().as_secs_f64(),
        time.as_secs_f64(),
        output.join("index.html").display()
    );
    Ok(match run.end {
        RunEnd::Interrupted => Outcome::Interrupted,
        RunEnd::Planned | RunEnd::Early => Outcome::Done,
    })
}

/// Ends the command without a report.
fn end_without_report(monitor: &RunMonitor, time: Duration) -> Result<Outcome, Failure> {
    if monitor.interrupted() {
        say!("petzval: interrupted before the first comparison; nothing was written");
        return Ok(Outcome::Interrupted);
    }
    Err(format!(
        "the budget of {} s was over before the first comparison; nothing was written; give a \
         longer --budget",
        time.as_secs_f64()
    )
    .into())
}

/// Returns whether a report goes into a subfolder: a partial one does if there is a whole one.
fn keeps_whole(output: &Path, partial: bool) -> bool {
    let whole = || {
        let text = std::fs::read(output.join("accuracy.json")).ok()?;
        let found: serde_json::Value = serde_json::from_slice(&text).ok()?;
        Some(found["ended"] == "planned")
    };
    if !partial || whole() != Some(true) {
        return false;
    }
    say!("petzval: {} holds a whole report, which is kept", output.display());
    true
}

/// Writes all files atomically, after all have been encoded.
fn write(report: &AccuracyReport, folder: &Path, to: &[OutputFile]) -> Result<(), Failure> {
    use std::io::Write as _;
    let files = report.files()?;
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot create the folder {}: {error}", folder.display()))?;
    for (file, bytes) in to.iter().zip(&files) {
        file.write(|file| file.write_all(bytes))
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

/// Returns the advice, the table of the last point of every model, 80 columns wide, and the verdicts.
fn table(report: &AccuracyReport) -> String {
    let mut text = report.recommendation().map_or_else(String::new, |words| words + "\n\n");
    text += &format!(
        "{:<24}{:>6}{:>9}{:>7}{:>10}{:>9}{:>9}{:>6}\n{:<24}{:>6}{:>9}{:>7}{:>10}{:>9}{:>9}{:>6}\n",
        "model",
        "spp",
        "time",
        "time",
        "on film",
        "error",
        "model's",
        "best",
        "",
        "",
        "s",
        "x f32",
        "um",
        "%",
        "own, %",
        "",
    );
    let verdicts = report.verdicts();
    for (i, rung) in report.ladder.rungs.iter().enumerate() {
        let Some(point) = report.run.last(i) else {
            text += &format!("{:<24}{:>6}\n", rung.name, "-");
            continue;
        };
        let times = verdicts.iter().find(|verdict| verdict.rung == i).and_then(|v| v.time);
        let own = report.own(point);
        let best = report.run.points.iter().any(|point| point.rung == i && point.on_frontier);
        text += &format!(
            "{:<24}{:>6}{:>9.2}{:>7}{:>10.2}{:>9.2}{:>9}{:>6}\n",
            rung.name,
            point.samples,
            point.seconds,
            relative_time(times),
            rung.film.rms_um,
            100.0 * point.error.max(0.0).sqrt(),
            own,
            if best { "*" } else { "" },
        );
    }
    text.push('\n');
    for verdict in verdicts {
        text += &format!("{}: {}\n", report.ladder.rungs[verdict.rung].name, verdict.sentence);
    }
    text
}

/// Parses --budget.
fn budget(text: &str) -> Result<Duration, String> {
    let time = typed(settings::time)(text)?;
    match time <= Duration::from_secs(7 * 24 * 3600) {
        true => Ok(time),
        false => Err("expected a time of a week at most, such as 60s".to_owned()),
    }
}
