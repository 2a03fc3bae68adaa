//! Log lines of a finished render: time by stage, lens losses, exposure, dropped samples.

use std::time::Duration;

use petzval_base::stats::{LaneOccupancy, Stage, StageStats, Stats};
use petzval_image::{Notes, find_number};
use petzval_lens::LensModel;
use petzval_render::film::DroppedSamples;
use petzval_render::job::Job;

use crate::cli::replay::replay_command;

/// Logs which samples were dropped, and the commands that replay them.
pub(super) fn log_dropped(dropped: &DroppedSamples, argv: &[String], seed: u32) {
    let (count, first) = (dropped.count(), dropped.first());
    if count == 0 {
        return;
    }
    say!(
        "petzval: warning: {count} samples were not finite and were dropped; to see their paths, \
         run"
    );
    for id in first {
        say!("  {}", replay_command(argv, id, seed));
    }
    let more = count.saturating_sub(first.len() as u64);
    if more > 0 {
        say!("  and {more} more");
    }
}

/// Logs time and rays by stage, and the share of rays that each surface of the lens blocks.
pub(super) fn log_statistics(job: &Job, stats: &Stats) {
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
        if matches!(stage, Stage::Record | Stage::LightPaths) && part.rays == 0 {
            continue;
        }
        say!(
            "{:<12}{:>12}{:>10.3}{:>7.1}%{:>10}{:>8}",
            stage.name(),
            part.rays,
            part.time.as_secs_f64(),
            100.0 * part.time.as_secs_f64() / total.as_secs_f64().max(1e-9),
            per_ray(part),
            occupancy(part.occupancy),
        );
    }
    log_bounces(stats);
    let LensModel::Real(lens) = &job.camera.model else { return };
    let sent = stats.lens.aimed;
    if sent == 0 {
        return;
    }
    let share = |count: u64| 100.0 * count as f64 / sent as f64;
    let lost = stats.lens.lost();
    let ends: Vec<String> = stats
        .lens
        .blocked()
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
    let redone = 1e6 * stats.lens.retraced as f64 / sent as f64;
    say!("{name}: {redone:.0} of a million rays retraced in f64");
}

/// Logs the camera's exposure settings, if known, and its sensor.
pub(super) fn log_exposure(job: &Job, notes: &Notes) {
    if let [Some(ev), Some(f_number), Some(seconds), Some(iso)] =
        ["exposureValue", "aperture", "expTime", "isoSpeed"].map(|name| find_number(notes, name))
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
        sensor.white_electrons(),
        sensor.relative_noise(0.18)
    );
    if let Some([red, green, blue]) = sensor.filters.map(|filters| filters.white()) {
        say!(
            "sensor: in white, the camera's red, green and blue get {red:.2}, {green:.2} and {blue:.2} \
             of these electrons"
        );
    }
    if let Some(bayer) = sensor.bayer {
        say!("sensor: the picture is the mosaic, {bayer}: one channel a pixel, in grey");
    }
}

/// Logs the occupancy of lanes over the first bounces.
fn log_bounces(stats: &Stats) {
    say!("{:<12}{:>12}{:>10}{:>8}{:>10}", "bounce", "rays", "intersect", "shade", "occlude");
    for (depth, bounce) in stats.bounces.iter().enumerate().take(6) {
        say!(
            "{:<12}{:>12}{:>10}{:>8}{:>10}",
            depth,
            bounce.intersect.live,
            occupancy(bounce.intersect),
            occupancy(bounce.shade),
            occupancy(bounce.occlude)
        );
    }
}

/// Formats nanoseconds per ray; a dash without rays.
fn per_ray(part: StageStats) -> String {
    match part.rays {
        0 => "-".into(),
        rays => format!("{:.1}", part.time.as_nanos() as f64 / rays as f64),
    }
}

/// Formats the share of live lanes; a dash without packets.
fn occupancy(lanes: LaneOccupancy) -> String {
    lanes.share().map_or("-".into(), |share| format!("{:.1}%", 100.0 * share))
}

/// Returns the likeliest reason for a black picture.
pub(super) fn reason_for_black(job: &Job, stats: &Stats) -> &'static str {
    if job.scene.lights.all.is_empty() {
        "the picture is black: the scene has no light"
    } else if stats.stage(Stage::Lens).rays == 0 {
        "the picture is black: no light passes the lens to this part of the film"
    } else if stats.stage(Stage::Intersect).rays == 0 {
        "the picture is black: no ray leaves the lens"
    } else if job.scene.bounds().is_none() {
        "the picture is black: the scene has no shapes"
    } else {
        "the picture is black: nothing that the camera sees is lit; check where it points, and \
         which side of the lights emits"
    }
}
