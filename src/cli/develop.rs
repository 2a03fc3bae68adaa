//! From what the film received to a picture in a file, and what is said about it.

use std::path::Path;
use std::time::{Duration, Instant};

use petzval::aov::{self, Aov};
use petzval::film::{Dropped, SampleName};
use petzval::image::{Encoding, Format, Note, Notes, Window};
use petzval::lens::Model;
use petzval::plan::Effect;
use petzval::render::{Exposed, Job, Reached};
use petzval::stats::{Lanes, Stage, StageStats, Stats};

use super::inputs::line;
use super::{Failure, replay};

/// A picture that is still on the film.
pub(super) struct Development<'a> {
    pub job: &'a Job,
    /// What is known about it.
    pub notes: Notes,
    /// The command line that asks for it.
    pub words: &'a [String],
    /// The one that rendered it, or its parts.
    pub rendered_by: &'a [String],
    /// Which one it is, where it is one of many: then less is said about it.
    pub among: Option<&'a str>,
    pub output: &'a Path,
    pub encoding: Encoding,
    pub threads: usize,
    /// When the command began, and how long it read.
    pub start: Instant,
    pub read: Duration,
}

impl Development<'_> {
    /// Writes the picture, and says how it came about.
    pub fn develop(self, mut exposed: Exposed) -> Result<(), Failure> {
        let Self { job, mut notes, words, rendered_by, among, output, encoding, threads, .. } =
            self;
        let Self { start, read, .. } = self;
        let rendered = start.elapsed();
        let taken = taken(&exposed);
        notes.retain(|(name, _)| taken.iter().all(|(other, _)| other != name));
        notes.extend(taken);
        notes.extend(dropped(&exposed.film.dropped));
        notes.push(("software", Note::Text(format!("petzval {}", env!("CARGO_PKG_VERSION")))));
        notes.push(("commandLine", Note::Text(line(words))));
        let window = Window { origin: job.frame.low, frame: job.frame.resolution };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
        let layers = match Format::of(output)? {
            Format::Exr => {
                pool.install(|| aov::layers(job, &exposed.film, exposed.features.as_ref()))
            }
            _ => Vec::new(),
        };
        let layered = start.elapsed();
        let stats = std::mem::take(&mut exposed.stats);
        let (reached, partial) = (exposed.reached.take(), exposed.partial);
        let (left_out, dark) = (std::mem::take(&mut exposed.film.dropped), exposed.film.dark());
        let picture = pool.install(|| exposed.into_picture(job));
        let developed = start.elapsed();
        picture.write_with_layers(&layers, output, window, encoding, &notes)?;

        if among.is_none() {
            say!("{}", super::plan::table(&job.plan).trim_end());
            print_table(job, &stats);
            print_exposure(job, &notes);
        }
        let samples = match (&reached, partial) {
            (Some(Reached { noise, mean, least, most }), _) => {
                say!("noise: {:.3} %; samples a pixel: {least} to {most}", 100.0 * noise);
                format!("{mean:.1}")
            }
            (None, Some(mean)) => format!("{mean:.1}"),
            (None, None) => job.samples.end.to_string(),
        };
        say_dropped(&left_out, rendered_by, job.seed);
        if dark && partial.is_none() {
            say!("petzval: warning: {}", why_black(job, &stats));
        }
        if partial.is_some() && job.layers.contains(&Aov::Variance) {
            say!(
                "petzval: warning: {} has no layer of variance: how exact it is nobody knows yet",
                output.display()
            );
        }
        let mut also = String::new();
        if job.plan.has(Effect::Diffraction) || job.sensor.is_some() {
            let seconds = (developed - layered).as_secs_f64();
            also += &format!(", diffraction and sensor {seconds:.2}");
        }
        if !layers.is_empty() {
            also += &format!(", layers {:.2}", (layered - rendered).as_secs_f64());
        }
        say!(
            "{}{}: {} x {} pixels, {samples} samples, {:.2} s (read {:.2}, render {:.2}{also}, write {:.2})",
            among.map_or_else(String::new, |among| format!("{among}: ")),
            output.display(),
            picture.size[0],
            picture.size[1],
            start.elapsed().as_secs_f64(),
            read.as_secs_f64(),
            (rendered - read).as_secs_f64(),
            (start.elapsed() - developed).as_secs_f64(),
        );
        Ok(())
    }
}

/// How many samples were taken, where that is not what was asked for, and how good it became.
fn taken(exposed: &Exposed) -> Notes {
    let number = |name, value| (name, Note::Number(value));
    let reached = exposed.reached.iter().flat_map(|reached| {
        [
            number("noise", reached.noise),
            number("samplesPerPixel", reached.mean),
            number("leastSamplesPerPixel", f64::from(reached.least)),
            number("mostSamplesPerPixel", f64::from(reached.most)),
        ]
    });
    let partial = exposed
        .partial
        .into_iter()
        .flat_map(|mean| [number("samplesPerPixel", mean), number("complete", 0.0)]);
    reached.chain(partial).collect()
}

/// Which samples were left out, if any.
fn dropped(dropped: &Dropped) -> Notes {
    if dropped.count() == 0 {
        return Notes::new();
    }
    let name = |name: &SampleName| {
        let ([x, y], SampleName { sample, seed, .. }) = (name.pixel(), name);
        format!("pixel {x},{y} sample {sample} seed {seed}")
    };
    let names: Vec<String> = dropped.first().iter().map(name).collect();
    vec![
        ("droppedSamples", Note::Number(dropped.count() as f64)),
        ("firstDropped", Note::Text(names.join("; "))),
    ]
}

/// Says which samples were left out, and how their ways can be seen.
fn say_dropped(dropped: &Dropped, words: &[String], seed: u32) {
    let (count, first) = (dropped.count(), dropped.first());
    if count == 0 {
        return;
    }
    say!("petzval: warning: {count} samples were no numbers and were left out; see their ways by");
    for name in first {
        say!("  {}", replay::command(words, name, seed));
    }
    let more = count.saturating_sub(first.len() as u64);
    if more > 0 {
        say!("  and {more} more");
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
            "{:<12}{:>12}{:>10.3}{:>7.1}%{:>10}{:>8}",
            stage.name(),
            part.rays,
            part.time.as_secs_f64(),
            100.0 * part.time.as_secs_f64() / total.as_secs_f64().max(1e-9),
            per_ray(part),
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
    let lost = stats.lens.blocked.iter().fold(0, |sum: u64, &rays| sum.saturating_add(rays));
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
    say!("{name}: {:.1}% of the rays leave the lens{blocked}", share(sent.saturating_sub(lost)));
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

/// Nanoseconds a ray; a dash where there was none.
fn per_ray(part: StageStats) -> String {
    match part.rays {
        0 => "-".into(),
        rays => format!("{:.1}", part.time.as_nanos() as f64 / rays as f64),
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
