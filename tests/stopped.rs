//! Renders that are stopped again and again, at moments spread over all of their samples, and gone
//! on with: nothing is lost, and nothing counts twice.

mod support;

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use petzval::aov::{Aov, layers};
use petzval::checkpoint::{Head, Saved};
use petzval::job::{Changes, prepare};
use petzval::render::{Backend, Exposed, Job, Keeper, Progress, RenderError, Until, render_kept};
use petzval::scene::pbrt;
use petzval::stats::Stats;
use support::kept::{Studio, forge};

/// How often a render is stopped.
const STOPS: u64 = 12;

fn job(studio: &Studio, changes: Changes) -> Job {
    let description = pbrt::read(&studio.path("scene.pbrt")).expect("the scene of the studio");
    let effects = "+ghosts".parse().expect("an effect");
    let changes = Changes { effects, holds_layers: true, ..changes };
    prepare(description, &changes).expect("a job").0
}

fn keeper(path: &Path) -> Keeper {
    Keeper {
        path: path.to_owned(),
        every: Some(Duration::from_secs(3600)),
        part: None,
        head: Head::default(),
        standing: 0,
        tell: |error| panic!("{error}"),
    }
}

/// Renders until so many film samples are taken, on from what is there: what came of it, and the
/// samples that were taken in all.
fn render(job: &Job, path: &Path, samples: u64) -> (Exposed, u64) {
    let (exposed, taken) = try_render(job, &keeper(path), samples);
    (exposed.expect("a picture, or what there is of it"), taken)
}

fn try_render(job: &Job, keeper: &Keeper, samples: u64) -> (Result<Exposed, RenderError>, u64) {
    let path = &keeper.path;
    let from = Saved::open(path).ok();
    let progress = Progress::default();
    let earlier = from.as_ref().map_or(0, |saved| saved.head.taken);
    progress.samples.store(earlier, Ordering::Relaxed);
    let exposed = std::thread::scope(|scope| {
        let render =
            scope.spawn(|| render_kept(job, Backend::Simd, 2, &progress, Some(keeper), from));
        while progress.samples.load(Ordering::Relaxed) < samples && !render.is_finished() {
            std::thread::yield_now();
        }
        progress.stop.store(samples < u64::MAX, Ordering::Relaxed);
        render.join().expect("a render")
    });
    (exposed, progress.samples.into_inner())
}

/// All that is known of a picture, bit for bit.
fn bits(job: &Job, exposed: &Exposed) -> Vec<(String, Vec<u32>)> {
    let picture = exposed.picture(job);
    let colours = picture.pixels.iter().flatten().map(|value| value.to_bits()).collect();
    let mut all = vec![("colours".to_owned(), colours)];
    for layer in layers(job, &exposed.film, exposed.features.as_ref()) {
        for (name, values) in layer.channels {
            let name = format!("{}.{name}", layer.name);
            all.push((name, values.iter().map(|value| value.to_bits()).collect()));
        }
    }
    all
}

/// What was counted, without times.
fn counts(stats: &Stats) -> String {
    let stages = stats.stages.map(|stage| (stage.rays, stage.lanes));
    format!("{stages:?} {:?} {:?}", stats.lens, stats.bounces)
}

fn survives_stops(job: &Job) {
    let folder = support::folder();
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
        if exposed.partial.is_none() {
            break (exposed, taken);
        }
        kept.push(Saved::open(&path).expect("a checkpoint").head.taken);
    };
    kept.dedup();
    assert!(kept.len() > 2, "something was done between stops: {kept:?}");
    assert_eq!(taken, all, "samples that were done are not done again: {kept:?}");
    assert_eq!(counts(&exposed.stats), counts(&whole.stats));
    assert_eq!(exposed.reached, whole.reached);
    let [one, other] = [&exposed, &whole].map(|exposed| bits(job, exposed));
    assert_eq!(one.len(), other.len());
    for (one, other) in one.iter().zip(&other) {
        assert!(one == other, "{}", other.0);
    }
}

#[test]
fn an_even_render_loses_nothing_when_it_is_stopped() {
    let studio = Studio::new();
    let layers = vec![Aov::Variance, Aov::Depth, Aov::Samples, Aov::Object];
    // More than one pass.
    survives_stops(&job(&studio, Changes { samples: Some(400), layers, ..Changes::default() }));
}

#[test]
fn an_adaptive_render_loses_nothing_when_it_is_stopped() {
    let studio = Studio::new();
    let layers = vec![Aov::Variance, Aov::Depth, Aov::Samples];
    let until = Until { noise: Some(0.02), time: None };
    survives_stops(&job(&studio, Changes { until, layers, ..Changes::default() }));
}

/// A grey sky, and lamps that are much smaller than a pixel: few samples meet them, and those of one
/// half of the samples send pilots of the other after them.
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

/// Whether a checkpoint of an adaptive render of so many tiles holds pilot samples.
fn holds_pilots(path: &Path, tiles: usize) -> bool {
    let bytes = std::fs::read(path).expect("a checkpoint");
    let head = u64::from_le_bytes(bytes[12..20].try_into().expect("8 bytes")) as usize;
    // The head and its checksum, the length of the body, a time; then counts by tile, of both halves of
    // the picture and of the pilots of each.
    let counts = bytes[20 + head + 4 + 8 + 8..].as_chunks::<4>().0;
    counts[2 * tiles..4 * tiles].iter().any(|count| *count != [0; 4])
}

#[test]
fn an_adaptive_render_remembers_its_pilot_samples() {
    let studio = Studio::new();
    std::fs::write(studio.path("scene.pbrt"), SPECKS).expect("a scene");
    let until = Until { noise: Some(0.01), time: None };
    let layers = vec![Aov::Variance, Aov::Samples];
    let changes = Changes { until, layers, samples: Some(192), ..Changes::default() };
    let job = job(&studio, changes);
    let (whole, all) = render(&job, &studio.path("none"), u64::MAX);
    // Stopped before, while and behind pilots are taken; each time what follows is done in one go, so
    // that nothing hides what a checkpoint forgets. A busy machine may stop later than it is asked to.
    let stops = [4, 12, 17, 20, 24, 32, 48, 64, 96, 128, 160];
    let (mut before, mut behind) = (0, 0);
    for stop in stops.into_iter().cycle().take(10 * stops.len()) {
        if stop == stops[0] && before > 0 && behind > 3 {
            return;
        }
        let path = studio.path("checkpoint");
        let _ = std::fs::remove_file(&path);
        let (exposed, _) = render(&job, &path, stop * 64 * 48);
        if exposed.partial.is_none() {
            continue;
        }
        let pilots = holds_pilots(&path, job.frame.tiles().len());
        *(if pilots { &mut behind } else { &mut before }) += 1;
        let (exposed, taken) = render(&job, &path, u64::MAX);
        assert_eq!(taken, all, "stop {stop}, pilots: {pilots}");
        assert_eq!(exposed.reached, whole.reached, "stop {stop}, pilots: {pilots}");
        assert!(bits(&job, &exposed) == bits(&job, &whole), "stop {stop}, pilots: {pilots}");
    }
    panic!("stopped {before} times before pilots and {behind} times behind");
}

#[test]
fn the_time_that_a_render_has_had_counts_when_it_goes_on() {
    let studio = Studio::new();
    let time = Duration::from_secs(30);
    let until = Until { noise: None, time: Some(time) };
    let job = job(&studio, Changes { until, ..Changes::default() });
    let path = studio.path("checkpoint");
    render(&job, &path, 1);
    // It says that an hour has gone: all that is left to do is the round that it was in.
    forge(&path, |_, body| {
        body[..8].copy_from_slice(&(3600 * 1_000_000_000u64).to_le_bytes());
    });
    let begun = Instant::now();
    let (exposed, _) = render(&job, &path, u64::MAX);
    assert!(exposed.partial.is_none() && exposed.reached.is_some());
    assert!(begun.elapsed() < time / 2, "it took {:?} more", begun.elapsed());
}

#[test]
fn a_part_that_cannot_be_written_leaves_a_checkpoint() {
    let (studio, folder) = (Studio::new(), support::folder());
    let path = folder.path().join("checkpoint");
    let job = job(&studio, Changes { samples: Some(4), ..Changes::default() });
    let keeper = Keeper { part: Some(folder.path().join("no/part")), ..keeper(&path) };
    let (exposed, taken) = try_render(&job, &keeper, u64::MAX);
    assert!(exposed.expect_err("no part").to_string().contains("cannot write"));
    assert_eq!(Saved::open(&path).expect("a checkpoint").head.taken, taken);
    let part = Some(folder.path().join("part"));
    let (_, again) = try_render(&job, &Keeper { part, ..keeper }, u64::MAX);
    assert_eq!(again, taken, "all samples were there");
    assert!(Saved::open(&folder.path().join("part")).expect("a part").head.complete);
}

#[test]
fn counts_that_no_render_has_are_refused_at_once() {
    let studio = Studio::new();
    let until = Until { noise: Some(0.001), time: None };
    let job = job(&studio, Changes { until, ..Changes::default() });
    let folder = support::folder();
    let path = folder.path().join("checkpoint");
    render(&job, &path, 1);
    let honest = std::fs::read(&path).expect("a checkpoint");
    let tiles = job.frame.tiles().len();
    // A time, then what the tiles of four pairs have taken, then what they want.
    for (taken, wanted) in [(0, 1 << 28), (1 << 28, 1 << 28), (1 << 28, 1 << 29), (16, 4)] {
        forge(&path, |_, body| {
            for (first, count) in [(0, taken), (4 * tiles, wanted)] {
                let at = 8 + 4 * first;
                body[at..at + 4].copy_from_slice(&u32::to_le_bytes(count));
            }
        });
        let (exposed, samples) = try_render(&job, &keeper(&path), 1 << 20);
        let error = exposed.expect_err("such counts").to_string();
        assert!(error.contains("damaged"), "{error}");
        assert_eq!(
            samples,
            Saved::open(&path).expect("a checkpoint").head.taken,
            "{taken} {wanted}"
        );
        std::fs::write(&path, &honest).expect("a checkpoint");
    }
    forge(&path, |_, _| {});
    render(&job, &path, 1);
}
