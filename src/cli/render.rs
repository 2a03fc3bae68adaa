//! `petzval render`

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use petzval::aov;
use petzval::image::{Encoding, Format, ImageError, Note, Notes, Window};
use petzval::job::{Changes, fits, prepare};
use petzval::lens::{Aim, Model};
use petzval::plan::Effect;
use petzval::render::{Backend, Job, Progress, Reached, RenderError, Until, render};
use petzval::scene::pbrt;
use petzval::stats::{Lanes, Stage, Stats};

use super::progress::Bar;
use super::{BackendArgument, Failure, Outcome, PupilArgument, RenderArguments};

pub(super) fn run(arguments: &RenderArguments) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let description = pbrt::read(&arguments.picture.scene)?;
    let named = description.film.filename.clone();
    let output = arguments.output.clone().or(named).unwrap_or_else(|| {
        PathBuf::from(arguments.picture.scene.file_stem().unwrap_or_default()).with_extension("exr")
    });
    // A long render must not end at a name that nothing can be written to.
    let holds_layers = Format::of(&output)? == Format::Exr;
    if !holds_layers && !arguments.aov.is_empty() {
        return Err(ImageError::NoLayers { path: output }.into());
    }
    check_folder(&output)?;
    let changes = Changes {
        crop: arguments.crop.map(|[x0, y0, x1, y1]| [[x0, y0], [x1, y1]]),
        aim: match arguments.pupil {
            PupilArgument::Exit => Aim::Pupil,
            PupilArgument::Rear => Aim::RearDisk,
        },
        layers: arguments.aov.iter().map(|&aov| aov.into()).collect(),
        holds_layers,
        until: Until { noise: arguments.noise, time: arguments.time },
        ..arguments.picture.changes()
    };
    let (job, mut notes, warnings) = prepare(description, &changes)?;
    fits(&job)?;
    for warning in &warnings {
        say!("petzval: warning: {warning}");
    }
    if arguments.half && Format::of(&output)? != Format::Exr {
        say!("petzval: warning: --half is for EXR; {} has 8 bits", output.display());
    }
    let backend = match arguments.backend {
        BackendArgument::Simd => Backend::Simd,
        BackendArgument::Scalar => Backend::Scalar,
    };
    let read = start.elapsed();

    let progress = Arc::new(Progress::default());
    let stop = progress.clone();
    // Where no handler can be had, Ctrl-C ends the program at once, as ever.
    let _ = ctrlc::set_handler(move || {
        // Asked twice, it does not wait for anything.
        if stop.stop.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(super::INTERRUPTED));
        }
    });
    let bar = Bar::start(&job, progress.clone());
    let threads = arguments.threads.map_or(0, usize::from);
    let exposed = render(&job, backend, threads, &progress);
    bar.finish();
    let exposed = match exposed {
        Ok(exposed) => exposed,
        Err(RenderError::Stopped) => {
            say!("petzval: interrupted; {} was not written", output.display());
            return Ok(Outcome::Interrupted);
        }
        Err(other) => return Err(other.into()),
    };
    let rendered = start.elapsed();

    if let Some(reached) = &exposed.reached {
        let number = |name, value| (name, Note::Number(value));
        notes.extend([
            number("noise", reached.noise),
            number("samplesPerPixel", reached.mean),
            number("leastSamplesPerPixel", f64::from(reached.least)),
            number("mostSamplesPerPixel", f64::from(reached.most)),
        ]);
    }
    notes.push(("software", Note::Text(format!("petzval {}", env!("CARGO_PKG_VERSION")))));
    let words: Vec<String> =
        std::env::args_os().map(|word| quoted(&word.to_string_lossy())).collect();
    notes.push(("commandLine", Note::Text(words.join(" "))));
    let window = Window { origin: job.frame.low, frame: job.frame.resolution };
    let encoding = Encoding { half: arguments.half, exposure: arguments.exposure };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let picture = pool.install(|| exposed.picture(&job));
    let developed = start.elapsed();
    let layers = pool.install(|| aov::layers(&job, &exposed.film, exposed.features.as_ref()));
    let layered = start.elapsed();
    picture.write_with_layers(&layers, &output, window, encoding, &notes)?;

    say!("{}", super::plan::table(&job.plan).trim_end());
    print_table(&job, &exposed.stats);
    print_exposure(&job, &notes);
    let samples = match &exposed.reached {
        None => job.samples.end.to_string(),
        Some(Reached { noise, mean, least, most }) => {
            say!("noise: {:.3} %; samples a pixel: {least} to {most}", 100.0 * noise);
            format!("{mean:.1}")
        }
    };
    if exposed.film.dropped > 0 {
        say!(
            "petzval: warning: {} samples were no numbers and were left out",
            exposed.film.dropped
        );
    }
    if exposed.film.dark() {
        say!("petzval: warning: {}", why_black(&job, &exposed.stats));
    }
    let mut also = String::new();
    if job.plan.has(Effect::Diffraction) || job.sensor.is_some() {
        also += &format!(", diffraction and sensor {:.2}", (developed - rendered).as_secs_f64());
    }
    if !layers.is_empty() {
        also += &format!(", layers {:.2}", (layered - developed).as_secs_f64());
    }
    say!(
        "{}: {} x {} pixels, {samples} samples, {:.2} s (read {:.2}, render {:.2}{also}, write {:.2})",
        output.display(),
        picture.size[0],
        picture.size[1],
        start.elapsed().as_secs_f64(),
        read.as_secs_f64(),
        (rendered - read).as_secs_f64(),
        (start.elapsed() - layered).as_secs_f64(),
    );
    Ok(Outcome::Done)
}

/// A word of a command line as a shell would take it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

fn check_folder(output: &Path) -> Result<(), Failure> {
    let folder = match output.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if output.is_dir() {
        return Err(format!("{} is a folder; name a picture in it", output.display()).into());
    }
    match tempfile::tempfile_in(folder) {
        Ok(_) => Ok(()),
        Err(error) => {
            Err(format!("cannot write {}: {error}; name another picture with -o", output.display())
                .into())
        }
    }
}

/// Time and rays by stage, and which surface of the lens let how many rays through.
fn print_table(job: &Job, stats: &Stats) {
    let total: Duration = stats.stages.iter().map(|stage| stage.time).sum();
    say!(
        "{:<12}{:>12}{:>10}{:>8}{:>10}{:>8}",
        "stage",
        "rays",
        "cpu s",
        "share",
        "ns/ray",
        "lanes"
    );
    for stage in Stage::ALL {
        let part = stats.stage(stage);
        if matches!(stage, Stage::Record | Stage::Ghosts) && part.rays == 0 {
            continue;
        }
        say!(
            "{:<12}{:>12}{:>10.3}{:>7.1}%{:>10.1}{:>8}",
            stage.name(),
            part.rays,
            part.time.as_secs_f64(),
            100.0 * part.time.as_secs_f64() / total.as_secs_f64().max(1e-9),
            part.time.as_nanos() as f64 / part.rays.max(1) as f64,
            live(part.lanes),
        );
    }
    print_bounces(stats);
    let Model::Real(lens) = &job.camera.model else { return };
    let sent = stats.lens.aimed;
    if sent == 0 {
        return;
    }
    let share = |count: u64| 100.0 * count as f64 / sent as f64;
    let lost: u64 = stats.lens.blocked.iter().sum();
    let ends: Vec<String> = stats
        .lens
        .blocked
        .iter()
        .enumerate()
        .filter(|(_, rays)| **rays > 0)
        .map(|(row, &rays)| {
            let stop = if lens.prescription.rows[row].stop { " (stop)" } else { "" };
            format!("{}{stop} {:.2}%", row + 1, share(rays))
        })
        .collect();
    let blocked = match ends.is_empty() {
        true => String::new(),
        false => format!("; blocked at surface {}", ends.join(", ")),
    };
    let name = &lens.prescription.name;
    say!("{name}: {:.1}% of the rays leave the lens{blocked}", share(sent - lost));
    let redone = 1e6 * stats.lens.redone as f64 / sent as f64;
    say!("{name}: {redone:.0} of a million rays redone in f64");
}

/// What the camera was set to, where that is known, and what its sensor does.
fn print_exposure(job: &Job, notes: &Notes) {
    let number = |name: &str| match notes.iter().find(|(other, _)| *other == name) {
        Some((_, Note::Number(number))) => Some(*number),
        _ => None,
    };
    if let [Some(ev), Some(f_number), Some(seconds), Some(iso)] =
        ["exposureValue", "aperture", "expTime", "isoSpeed"].map(number)
    {
        let time = match seconds < 0.3 {
            true => format!("1/{:.0}", 1.0 / seconds),
            false => format!("{seconds:.1}"),
        };
        say!("exposure: f/{f_number:.1}, {time} s, ISO {iso}: EV {ev:.2} at ISO 100");
    }
    let Some(sensor) = &job.sensor else { return };
    say!(
        "sensor: {sensor}; white is {:.0} electrons, middle grey has {:.1} % of noise",
        sensor.white(),
        sensor.relative_noise(0.18)
    );
    if let Some(bayer) = sensor.bayer {
        say!("sensor: the picture is the mosaic, {bayer}: one channel a pixel, in grey");
    }
}

/// How full the packets were at the first surfaces of paths.
fn print_bounces(stats: &Stats) {
    say!("{:<12}{:>12}{:>10}{:>8}{:>10}", "bounce", "rays", "intersect", "shade", "occlude");
    for (depth, bounce) in stats.bounces.iter().enumerate().take(6) {
        say!(
            "{:<12}{:>12}{:>10}{:>8}{:>10}",
            depth,
            bounce.intersect.live,
            live(bounce.intersect),
            live(bounce.shade),
            live(bounce.occlude)
        );
    }
}

/// The share of live lanes; a dash where nothing went by lanes.
fn live(lanes: Lanes) -> String {
    lanes.share().map_or("-".into(), |share| format!("{:.1}%", 100.0 * share))
}

/// The likeliest reason why nothing arrived.
fn why_black(job: &Job, stats: &Stats) -> &'static str {
    if job.scene.lights.all.is_empty() {
        "the picture is black: the scene has no light"
    } else if stats.stage(Stage::Lens).rays == 0 {
        "the picture is black: no light comes through the lens to this part of the film"
    } else if stats.stage(Stage::Intersect).rays == 0 {
        "the picture is black: no ray leaves the lens"
    } else if job.scene.bounds().is_none() {
        "the picture is black: the scene holds no shapes"
    } else {
        "the picture is black: nothing that the camera sees is lit; check where it looks, and \
         which side of the lights shines"
    }
}
