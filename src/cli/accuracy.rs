//! `petzval accuracy`

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use petzval::accuracy::{Budget, Ended, FILES, Ladder, Machine, Report, Watch, climb};
use petzval::image::replace;
use petzval::job::Changes;
use petzval::scene::pbrt;

use super::progress::TimeBar;
use super::{AccuracyArguments, Failure, Outcome};

/// The most samples where nobody says how many.
const SAMPLES: u32 = 1 << 20;

pub(super) fn run(arguments: &AccuracyArguments) -> Result<Outcome, Failure> {
    let begun = Instant::now();
    let AccuracyArguments { output, budget: time, crop, picture } = arguments;
    let description = pbrt::read(&picture.scene)?;
    // A long run must not end at a folder that nothing can be written to.
    let folder = output.display();
    std::fs::create_dir_all(output).and_then(|()| tempfile::tempfile_in(output)).map_err(
        |error| format!("cannot write to the folder {folder}: {error}; name another with -o"),
    )?;
    let crop = crop.map(|[x0, y0, x1, y1]| [[x0, y0], [x1, y1]]);
    let changes = Changes { crop, ..picture.changes() };
    let watch = Arc::new(Watch::default());
    let stop = watch.clone();
    // Where no handler can be had, Ctrl-C ends the program at once, as ever.
    let _ = ctrlc::set_handler(move || {
        // Asked twice, it does not wait for anything.
        if !stop.interrupt() {
            std::process::exit(i32::from(super::INTERRUPTED));
        }
    });
    let mut ladder = Ladder::new(&description, &changes)?;
    for warning in &ladder.warnings {
        say!("petzval: warning: {warning}");
    }
    let samples = picture.spp.unwrap_or(SAMPLES);
    let budget = Budget { begun, time: *time, samples };
    let bar = TimeBar::start(begun, *time, watch.clone());
    let found = climb(&mut ladder, &budget, &watch);
    bar.finish();
    let found = found?;
    let scene = picture.scene.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let report =
        Report { scene, ladder: &ladder, climb: &found, budget: *time, machine: Machine::this() };
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

/// Writes all files, each at once; none before all are made.
fn write(report: &Report, folder: &Path) -> Result<(), Failure> {
    use std::io::Write as _;
    let files = report.files()?;
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
        let own = match point.bias {
            Some(bias) if bias.certain() => format!("{:.3}", 100.0 * bias.size()),
            Some(bias) => format!("<{:.3}", 100.0 * bias.at_most()),
            None => "-".to_owned(),
        };
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
