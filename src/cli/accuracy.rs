//! `petzval accuracy`

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use petzval::accuracy::{Budget, Ended, FILES, Ladder, Machine, Report, Watch, climb};
use petzval::image::replace;
use petzval::job::{Changes, JobError};
use petzval::render::RenderError;
use petzval::scene::pbrt;

use super::folders::Folders;
use super::message;
use super::outputs::check_distinct;
use super::progress::TimeBar;
use super::signals::stop_by;
use super::{AccuracyArguments, Failure, Outcome};

/// The most samples where nobody says how many.
const SAMPLES: u32 = 1 << 20;

/// The fewest: one of every quarter.
const FEWEST: u32 = 4;

/// Where a partial report goes if there is a whole one.
const BESIDE: &str = "report.partial";

pub(super) fn run(arguments: &AccuracyArguments) -> Result<Outcome, Failure> {
    let begun = Instant::now();
    let AccuracyArguments { output, budget: time, crop, picture } = arguments;
    if let Some(spp) = picture.spp.filter(|&spp| spp < FEWEST) {
        let words = "every model takes four quarters of its samples, so that noise can be told";
        return Err(format!("--spp {spp}: {words}; expected {FEWEST} or more").into());
    }
    let description = pbrt::read(&picture.scene)?;
    // A long run must not end at a folder that nothing can be written to.
    let folder = output.display();
    let mut folders = Folders::default();
    folders.make(output).and_then(|()| tempfile::tempfile_in(output)).map_err(|error| {
        format!("cannot write to the folder {folder}: {error}; name another with -o")
    })?;
    let crop = crop.map(|[x0, y0, x1, y1]| [[x0, y0], [x1, y1]]);
    let changes = Changes { crop, ..picture.changes() };
    let watch = Arc::new(Watch::default());
    let stop = watch.clone();
    stop_by(move || stop.interrupt());
    let made = watch.until(begun + *time, || Ladder::new(&description, &changes, &watch));
    let mut ladder = match made {
        Err(JobError::Level(RenderError::Stopped)) => return nothing(&watch, *time),
        other => other?,
    };
    let written = [output.clone(), output.join(BESIDE)];
    let written = written.iter().flat_map(|folder| FILES.map(|name| folder.join(name)));
    check_distinct(written, "-o", ladder.files())?;
    message::warnings(&ladder.warnings);
    let samples = picture.spp.unwrap_or(SAMPLES);
    let budget = Budget { begun, time: *time, samples };
    let bar = TimeBar::start(begun, *time, watch.clone());
    let found = climb(&mut ladder, &budget, &watch);
    bar.finish();
    let found = found?;
    let scene = picture.scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if found.points.is_empty() {
        return nothing(&watch, *time);
    }
    let command = command();
    let report = Report {
        scene,
        command,
        ladder: &ladder,
        climb: &found,
        budget: *time,
        machine: Machine::this(),
    };
    let output = &place(output, report.partial().is_some());
    let folder = output.display();
    write(&report, output)?;
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
    Ok(match found.ended {
        Ended::Interrupted => Outcome::Interrupted,
        Ended::Planned | Ended::Early => Outcome::Done,
    })
}

/// How it ends without a report.
fn nothing(watch: &Watch, time: Duration) -> Result<Outcome, Failure> {
    if watch.interrupted() {
        say!("petzval: interrupted before anything could be compared; nothing was written");
        return Ok(Outcome::Interrupted);
    }
    Err(format!(
        "the budget of {} s was over before anything could be compared; nothing was written, give \
         it more with --budget",
        time.as_secs_f64()
    )
    .into())
}

/// Where a report goes: a partial one not where there is a whole one, but beside it.
fn place(output: &Path, partial: bool) -> PathBuf {
    let whole = || {
        let text = std::fs::read(output.join("accuracy.json")).ok()?;
        let found: serde_json::Value = serde_json::from_slice(&text).ok()?;
        Some(found["ended"] == "planned")
    };
    if !partial || whole() != Some(true) {
        return output.to_owned();
    }
    let beside = output.join(BESIDE);
    say!("petzval: {} holds a whole report, which stays", output.display());
    beside
}

/// The command line, as it may be given to a shell again.
fn command() -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+:%@".contains(c);
    let quoted = |word: String| match !word.is_empty() && word.chars().all(plain) {
        true => word,
        false => format!("'{}'", word.replace('\'', "'\\''")),
    };
    let words = std::env::args_os().skip(1).map(|word| quoted(word.to_string_lossy().into_owned()));
    std::iter::once("petzval".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Writes all files, each at once; none before all are made.
fn write(report: &Report, folder: &Path) -> Result<(), Failure> {
    use std::io::Write as _;
    let files = report.files()?;
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    for (name, bytes) in FILES.iter().zip(&files) {
        let path = folder.join(name);
        replace(&path, |file| file.write_all(bytes))
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    }
    Ok(())
}

/// The last point of every model, for a terminal of 80, and the advice.
fn table(report: &Report) -> String {
    let mut text = format!(
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
        let Some(point) = report.climb.last(i) else {
            text += &format!("{:<24}{:>6}\n", rung.name, "-");
            continue;
        };
        let times = verdicts.iter().find(|verdict| verdict.rung == i).and_then(|v| v.pace);
        let own = report.own(point);
        let best = report.climb.points.iter().any(|point| point.rung == i && point.on_frontier);
        text += &format!(
            "{:<24}{:>6}{:>9.2}{:>7}{:>10.2}{:>9.2}{:>9}{:>6}\n",
            rung.name,
            point.samples,
            point.seconds,
            times.map_or_else(|| "-".to_owned(), |pace| format!("{:.2}", pace.times)),
            rung.film.rms_um,
            100.0 * point.error.max(0.0).sqrt(),
            own,
            if best { "*" } else { "" },
        );
    }
    text.push('\n');
    if let Some(choice) = report.choice() {
        text += &format!("{choice}\n");
    }
    for verdict in verdicts {
        text += &format!("{}: {}\n", report.ladder.rungs[verdict.rung].name, verdict.sentence);
    }
    text
}

/// A budget of time.
pub(super) fn budget(text: &str) -> Result<Duration, String> {
    let time = super::values::time(text)?;
    match time <= Duration::from_secs(7 * 24 * 3600) {
        true => Ok(time),
        false => Err("expected a time of a week at most, such as 60s".to_owned()),
    }
}
