//! Renders that are stopped and resumed many times, at points spread over all of their samples: no sample
//! is lost or counted twice.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use crate::support::workspace::{Workspace, forge};
use petzval_base::io::{OutputFile, Outputs};
use petzval_base::stats::Stats;
use petzval_render::aov::Aov;
use petzval_render::checkpoint::{Head, SavedRender};
use petzval_render::job::{Job, StopCriteria};
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{
    Checkpointer, Progress, RenderError, RenderOptions, RenderOutput, render_resumable,
};
use petzval_scene_formats::pbrt;

/// Number of times that a render is stopped.
const STOPS: u64 = 12;

fn job(workspace: &Workspace, changes: Changes) -> Job {
    let description =
        pbrt::read(&workspace.path("scene.pbrt")).expect("the scene of the workspace");
    let effects = "+ghosts".parse().expect("an effect");
    let changes = Changes { effects, holds_layers: true, ..changes };
    prepare(description, &changes).expect("a job").job
}

fn output(path: &Path) -> OutputFile {
    Outputs::without_inputs().claim(path).expect("an output")
}

fn checkpointer(path: &Path) -> Checkpointer {
    Checkpointer {
        path: output(path),
        interval: Some(Duration::from_secs(3600)),
        part_path: None,
        head: Head::default(),
        existing_samples: 0,
        on_error: |error| panic!("{error}"),
    }
}

/// Renders, from a checkpoint if there is one, until `samples` film samples are taken in all. Returns the
/// output and the number of samples taken in all.
fn render(job: &Job, path: &Path, samples: u64) -> (RenderOutput, u64) {
    let (exposed, taken) = try_render(job, &checkpointer(path), samples);
    (exposed.expect("a complete or partial picture"), taken)
}

fn try_render(
    job: &Job,
    checkpointer: &Checkpointer,
    samples: u64,
) -> (Result<RenderOutput, RenderError>, u64) {
    let path = checkpointer.path.path();
    let from = SavedRender::open(path).ok();
    let progress = Progress::default();
    let earlier = from.as_ref().map_or(0, |saved| saved.head.film_samples);
    progress.samples.store(earlier, Ordering::Relaxed);
    let exposed = std::thread::scope(|scope| {
        let render = scope.spawn(|| {
            let options =
                RenderOptions { threads: 2, progress: Some(&progress), ..RenderOptions::default() };
            render_resumable(job, options, Some(checkpointer), from)
        });
        while progress.samples.load(Ordering::Relaxed) < samples && !render.is_finished() {
            std::thread::yield_now();
        }
        progress.stop.store(samples < u64::MAX, Ordering::Relaxed);
        render.join().expect("a render")
    });
    (exposed, progress.samples.into_inner())
}

/// Returns the pixels and layers of a picture, bit for bit.
fn bits(job: &Job, exposed: &RenderOutput) -> Vec<(String, Vec<u32>)> {
    let picture = exposed.picture(job);
    let colours = picture.pixels.iter().flatten().map(|value| value.to_bits()).collect();
    let mut all = vec![("colours".to_owned(), colours)];
    for layer in exposed.layers(job) {
        for (name, values) in layer.channels {
            let name = format!("{}.{name}", layer.name);
            all.push((name, values.iter().map(|value| value.to_bits()).collect()));
        }
    }
    all
}

/// Returns the counters, without times.
fn counts(stats: &Stats) -> String {
    let stages = stats.stages.map(|stage| (stage.rays, stage.occupancy));
    format!("{stages:?} {:?} {:?}", stats.lens, stats.bounces)
}

fn survives_stops(job: &Job) {
    let folder = crate::support::folder();
    let (whole, all) = render(job, &folder.path().join("none"), u64::MAX);
    let path = folder.path().join("checkpoint");
    let (mut kept, mut stopped) = (Vec::new(), 0);
    let (exposed, taken) = loop {
        let until = match stopped < STOPS {
            true => (stopped + 1) * all / (STOPS + 1),
            false => u64::MAX,
        };
        stopped += 1;
        let (exposed, taken) = render(job, &path, until);
        if exposed.partial_mean_spp.is_none() {
            break (exposed, taken);
        }
        kept.push(SavedRender::open(&path).expect("a checkpoint").head.film_samples);
    };
    kept.dedup();
    assert!(kept.len() > 2, "too few stops took samples: {kept:?}");
    assert_eq!(taken, all, "samples are taken twice: {kept:?}");
    assert_eq!(counts(&exposed.stats), counts(&whole.stats));
    assert_eq!(exposed.convergence, whole.convergence);
    let [one, other] = [&exposed, &whole].map(|exposed| bits(job, exposed));
    assert_eq!(one.len(), other.len());
    for (one, other) in one.iter().zip(&other) {
        assert!(one == other, "{}", other.0);
    }
}

#[test]
fn a_uniform_render_loses_nothing_when_it_is_stopped() {
    let workspace = Workspace::new();
    let layers = vec![Aov::Variance, Aov::Depth, Aov::Samples, Aov::Object, Aov::DualPixel];
    // Enough samples for more than one pass.
    survives_stops(&job(&workspace, Changes { samples: Some(400), layers, ..Changes::default() }));
}

#[test]
fn an_adaptive_render_loses_nothing_when_it_is_stopped() {
    let workspace = Workspace::new();
    let layers = vec![Aov::Variance, Aov::Depth, Aov::Samples, Aov::DualPixel];
    let until = StopCriteria { noise: Some(0.02), time: None };
    survives_stops(&job(
        &workspace,
        Changes { stop_criteria: until, layers, ..Changes::default() },
    ));
}

/// A grey sky, and lights much smaller than a pixel. Few samples hit them; a hit in one half buffer
/// triggers pilot samples in the other.
const SPECKS: &str = r#"
    Film "rgb" "integer xresolution" 64 "integer yresolution" 48
    Camera "perspective" "float fov" 40
    WorldBegin
    LightSource "infinite" "rgb L" [0.5 0.5 0.5]
    AreaLightSource "diffuse" "rgb L" [3e4 3e4 3e4]
    AttributeBegin Translate 0.6 0.5 5 Shape "sphere" "float radius" 0.004 AttributeEnd
    AttributeBegin Translate -0.9 -0.4 5 Shape "sphere" "float radius" 0.006 AttributeEnd
    AttributeBegin Translate -0.8 0.7 5 Shape "sphere" "float radius" 0.009 AttributeEnd
    AttributeBegin Translate 0.7 -0.6 5 Shape "sphere" "float radius" 0.013 AttributeEnd"#;

/// Returns whether a checkpoint of an adaptive render of `tiles` tiles holds pilot samples.
fn holds_pilots(path: &Path, tiles: usize) -> bool {
    let bytes = std::fs::read(path).expect("a checkpoint");
    let head = u64::from_le_bytes(bytes[12..20].try_into().expect("8 bytes")) as usize;
    // Behind the head, its checksum, the length of the body and a time stand counts by tile: of both half
    // buffers, then of the pilot samples of each.
    let counts = bytes[20 + head + 4 + 8 + 8..].as_chunks::<4>().0;
    counts[2 * tiles..4 * tiles].iter().any(|count| *count != [0; 4])
}

#[test]
fn an_adaptive_render_keeps_its_pilot_samples() {
    let workspace = Workspace::new();
    std::fs::write(workspace.path("scene.pbrt"), SPECKS).expect("a scene");
    let until = StopCriteria { noise: Some(0.01), time: None };
    let layers = vec![Aov::Variance, Aov::Samples];
    let changes =
        Changes { stop_criteria: until, layers, samples: Some(192), ..Changes::default() };
    let job = job(&workspace, changes);
    let (whole, all) = render(&job, &workspace.path("none"), u64::MAX);
    // Stops before, during and after the pilot samples. The rest is rendered without a further stop, so that
    // nothing hides what a checkpoint forgets. A busy machine may stop later than requested.
    let stops = [4, 12, 17, 20, 24, 32, 48, 64, 96, 128, 160];
    let (mut before, mut behind) = (0, 0);
    for stop in stops.into_iter().cycle().take(10 * stops.len()) {
        if stop == stops[0] && before > 0 && behind > 3 {
            return;
        }
        let path = workspace.path("checkpoint");
        let _ = std::fs::remove_file(&path);
        let (exposed, _) = render(&job, &path, stop * 64 * 48);
        if exposed.partial_mean_spp.is_none() {
            continue;
        }
        let pilots = holds_pilots(&path, job.tiles().len());
        *(if pilots { &mut behind } else { &mut before }) += 1;
        let (exposed, taken) = render(&job, &path, u64::MAX);
        assert_eq!(taken, all, "stop {stop}, pilots: {pilots}");
        assert_eq!(exposed.convergence, whole.convergence, "stop {stop}, pilots: {pilots}");
        assert!(bits(&job, &exposed) == bits(&job, &whole), "stop {stop}, pilots: {pilots}");
    }
    panic!("stopped {before} times before pilots and {behind} times behind");
}

#[test]
fn the_time_before_a_stop_counts_after_resuming() {
    let workspace = Workspace::new();
    let time = Duration::from_secs(30);
    let until = StopCriteria { noise: None, time: Some(time) };
    let job = job(&workspace, Changes { stop_criteria: until, ..Changes::default() });
    let path = workspace.path("checkpoint");
    render(&job, &path, 1);
    // The checkpoint now claims an hour of rendering, so only the current round remains.
    forge(&path, |_, body| {
        body[..8].copy_from_slice(&(3600 * 1_000_000_000u64).to_le_bytes());
    });
    let (exposed, _) = render(&job, &path, u64::MAX);
    let reached = exposed.convergence.expect("a convergence");
    assert!(exposed.partial_mean_spp.is_none());
    // A round takes 4 samples per pixel, half a minute takes hundreds.
    assert!(reached.max_spp < 32, "{reached:?}");
}

#[test]
fn a_part_that_cannot_be_written_leaves_a_checkpoint() {
    let (workspace, folder) = (Workspace::new(), crate::support::folder());
    let path = folder.path().join("checkpoint");
    let job = job(&workspace, Changes { samples: Some(4), ..Changes::default() });
    let checkpointer = Checkpointer {
        part_path: Some(output(&folder.path().join("no/part"))),
        ..checkpointer(&path)
    };
    let (exposed, taken) = try_render(&job, &checkpointer, u64::MAX);
    assert!(exposed.expect_err("no part").to_string().contains("cannot write"));
    assert_eq!(SavedRender::open(&path).expect("a checkpoint").head.film_samples, taken);
    let part = Some(output(&folder.path().join("part")));
    let (_, again) = try_render(&job, &Checkpointer { part_path: part, ..checkpointer }, u64::MAX);
    assert_eq!(again, taken, "all samples were there");
    assert!(SavedRender::open(&folder.path().join("part")).expect("a part").head.complete);
}

#[test]
fn impossible_sample_counts_are_refused() {
    let workspace = Workspace::new();
    let until = StopCriteria { noise: Some(0.001), time: None };
    let job = job(&workspace, Changes { stop_criteria: until, ..Changes::default() });
    let folder = crate::support::folder();
    let path = folder.path().join("checkpoint");
    render(&job, &path, 1);
    let honest = std::fs::read(&path).expect("a checkpoint");
    let tiles = job.tiles().len();
    // A time, then the samples that the tiles have taken, then those that they want.
    for (taken, wanted) in [(0, 1 << 28), (1 << 28, 1 << 28), (1 << 28, 1 << 29), (16, 4)] {
        forge(&path, |_, body| {
            for (first, count) in [(0, taken), (4 * tiles, wanted)] {
                let at = 8 + 4 * first;
                body[at..at + 4].copy_from_slice(&u32::to_le_bytes(count));
            }
        });
        let (exposed, samples) = try_render(&job, &checkpointer(&path), 1 << 20);
        let error = exposed.expect_err("such counts").to_string();
        assert!(error.contains("damaged"), "{error}");
        assert_eq!(
            samples,
            SavedRender::open(&path).expect("a checkpoint").head.film_samples,
            "{taken} {wanted}"
        );
        std::fs::write(&path, &honest).expect("a checkpoint");
    }
    forge(&path, |_, _| {});
    render(&job, &path, 1);
}
