//! What effects cost: each off and on beside each other in the same run.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use petzval::diffraction::Diffraction;
use petzval::film::{FilmSums, Frame, sample};
use petzval::ghosts::survey;
use petzval::image::Picture;
use petzval::job::{Changes, prepare};
use petzval::lanes::f32x8;
use petzval::lens::{
    Aim, Askew, Coating, FilmPlane, From, LensColumns, Model, Pose, RealLens, Surface, read,
    sequence, trace, trace_lossy,
};
use petzval::plan::{Effect, Wanted};
use petzval::rays::{LensBatch, RayBatch, SampleBatch, WAVE};
use petzval::render::{Backend, DisperseColumns, Exposed, Job, Progress, disperse, render};
use petzval::scene::pbrt;
use petzval::sensor::{Bayer, Sensor};
use petzval::stats::{LensStats, Stats};

/// The double Gauss of the course and the film distance of its scene, mm.
const LENS: (&str, f64) = ("lenses/dgauss.50mm.dat", 36.77);

/// Prints what the plan of a job says that an effect costs, to stand beside what is measured.
fn planned(job: &Job, effect: Effect) {
    let row = job.plan.effects.iter().find(|row| row.effect == effect && row.on);
    if let Some(cost) = row.and_then(|row| row.cost) {
        println!("{}: the plan says {:.1} ns a film sample", effect.name(), cost.ns_per_ray);
    }
}

type Trace = fn(&mut LensBatch<f32>, &[Surface<f32>], &mut [u64]);

/// Rays of a wave from near the axis, all of which come through.
fn wave() -> Box<LensBatch<f32>> {
    let mut batch = Box::<LensBatch<f32>>::default();
    for i in 0..WAVE {
        let share = i as f32 / WAVE as f32;
        let (sin, cos) = (40.0 * share).sin_cos();
        let [x, y] = [2.0 * share * cos, 2.0 * share * sin];
        let d = [sin - x, cos - y, LENS.1 as f32];
        let length = d.iter().map(|v| v * v).sum::<f32>().sqrt();
        (batch.x[i], batch.y[i]) = (x, y);
        [batch.tx[i], batch.ty[i], batch.tz[i]] = d.map(|v| v / length);
        batch.weight[i] = 1.0;
    }
    batch.resize::<f32x8>(WAVE);
    batch
}

/// Losses of surfaces: the trace of a wave without them, and with each coating.
fn fresnel(criterion: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let bare = read(&folder.join(LENS.0)).expect("a lens of the repository");
    let mut group = criterion.benchmark_group("effect/fresnel");
    group.throughput(Throughput::Elements(WAVE as u64));
    let fresh = wave();
    let cases: [(&str, Coating, Trace); 4] = [
        ("off", Coating::Bare, trace::<f32x8>),
        ("on", Coating::Bare, trace_lossy::<f32x8>),
        ("on, broadband", Coating::Broadband, trace_lossy::<f32x8>),
        ("on, mgf2", Coating::Mgf2, trace_lossy::<f32x8>),
    ];
    for (name, coating, trace) in cases {
        let mut lens = bare.clone();
        lens.coat(coating);
        let surfaces = sequence::<f32>(&lens, From::Film(LENS.1));
        let mut blocked = vec![0; lens.rows.len()];
        let mut batch = fresh.clone();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                // A traced wave cannot be traced again.
                (*batch).clone_from(&fresh);
                trace(black_box(&mut batch), &surfaces, &mut blocked);
            });
        });
        assert_eq!(blocked, vec![0; lens.rows.len()], "the bench means rays that pass");
    }
    let scene = pbrt::read(&folder.join("scenes/dgauss.pbrt")).expect("a scene of the repository");
    let changes = Changes { coating: Some(Coating::Mgf2), ..Changes::default() };
    planned(&prepare(scene, &changes).expect("a job").0, Effect::Fresnel);
    // What it takes to know the loss: 33 film points.
    let lens = RealLens::new(bare, LENS.1, 21.6, Aim::Pupil, 1.0, 0.0);
    group.throughput(Throughput::Elements(1));
    group.bench_function("estimate", |bencher| bencher.iter(|| lens.throughput(21.6)));
    group.finish();
}

const SIZE: [u32; 2] = [256, 256];

/// ns a pixel of the finished picture, on one thread.
fn sensor(bench: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut group = bench.benchmark_group("effect/sensor");
    group.throughput(Throughput::Elements(u64::from(SIZE[0] * SIZE[1])));

    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    let description = pbrt::read(&scene).expect("a scene of the repository");
    let job = prepare(description, &Changes::default()).expect("a job").0;
    let frame = Frame::whole(SIZE);
    let job = Job { frame, sensor: None, ..job };
    let exposed = Exposed {
        film: FilmSums::new(frame, false),
        features: None,
        stats: Stats::default(),
        reached: None,
        partial: None,
    };
    // Of one sample a pixel.
    let description = pbrt::read(&scene).expect("a scene of the repository");
    let asked = Some(Default::default());
    let changes = Changes { sensor: asked, samples: Some(1), ..Changes::default() };
    planned(&prepare(description, &changes).expect("a job").0, Effect::Sensor);
    group.bench_function("without", |bencher| bencher.iter(|| exposed.film.picture(16)));
    group.bench_function("off", |bencher| bencher.iter(|| exposed.picture(&job)));

    let on = Sensor { iso: 800.0, well: 54_000.0, read: 2.5, bits: 14, black: 512, bayer: None };
    let mosaic = Sensor { bayer: Some(Bayer::Rggb), ..on };
    for (name, sensor, value) in
        [("on", on, 0.18), ("on/dark", on, 5e-4), ("on/bayer", mosaic, 0.18)]
    {
        let size = SIZE.map(|n| n as usize);
        let picture = Picture { size, pixels: vec![[value; 3]; size[0] * size[1]] };
        group.bench_function(name, |bencher| {
            bencher.iter(|| pool.install(|| sensor.read_out(&picture, [0, 0], 0)));
        });
    }
    group.finish();
}

/// The stages from film points to rays in the world.
struct Launch {
    samples: SampleBatch,
    columns: LensColumns,
    disperse: DisperseColumns,
    rays: RayBatch,
    stats: LensStats,
}

impl Default for Launch {
    fn default() -> Self {
        Self {
            samples: SampleBatch::default(),
            columns: LensColumns::default(),
            disperse: DisperseColumns::default(),
            rays: RayBatch::default(),
            stats: LensStats { blocked: vec![0; 99], ..LensStats::default() },
        }
    }
}

impl Launch {
    /// All waves of a picture.
    fn all(&mut self, job: &Job) {
        let Self { samples, columns, disperse: shared, rays, stats } = self;
        let (film, filter) = (job.camera.film, &job.film.filter);
        for tile in job.frame.tiles() {
            let mut tile = job.sampler(&tile, job.samples.clone());
            while sample(&mut tile, &job.frame, filter, film, 0, samples) {
                job.camera.expose::<f32x8>(samples, columns, rays, stats);
                disperse::<f32x8>(job, samples, columns, shared, rays);
                black_box(&*rays);
            }
        }
    }
}

/// Film points to rays in the world, with all light together and taken apart.
fn dispersion(criterion: &mut Criterion) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    // The lens says nothing of its glass; what is guessed takes as long as what is known.
    let job = |effects: &str| {
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let changes = Changes {
            resolution: Some([64, 64]),
            samples: Some(64),
            assume_vd: true,
            effects: effects.parse().expect("effects"),
            ..Changes::default()
        };
        prepare(description, &changes).expect("a job").0
    };
    let (off, on) = (job("-dispersion"), job("+dispersion"));
    planned(&on, Effect::Dispersion);
    let mut group = criterion.benchmark_group("effect/dispersion");
    group.throughput(Throughput::Elements(64 * 64 * 64));
    let mut launch = Launch::default();
    for (name, job) in [("off", &off), ("on", &on)] {
        group.bench_function(name, |bencher| bencher.iter(|| launch.all(job)));
    }
    group.finish();
}

/// Light paths from lamps over two mirrorings to the film, by film sample of the picture.
fn ghosts(criterion: &mut Criterion) {
    const SAMPLES: u32 = 16;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut group = criterion.benchmark_group("effect/ghosts");
    for name in ["dgauss", "fisheye"] {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.pbrt"));
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let effects = Wanted::But(vec![(Effect::Ghosts, true)]);
        let changes = Changes { samples: Some(SAMPLES), effects, ..Changes::default() };
        let job = prepare(description, &changes).expect("a job").0;
        let ghosts = job.ghosts.as_ref().expect("they are asked for");
        planned(&job, Effect::Ghosts);
        let [width, height] = job.frame.resolution;
        group.throughput(Throughput::Elements(u64::from(width * height * SAMPLES)));
        let mut film = FilmSums::new(job.frame, false);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                pool.install(|| {
                    let progress = Progress::default();
                    let (samples, mut stats) = (job.samples.clone(), Stats::default());
                    ghosts.expose::<f32x8>(&job, samples, &mut film, &mut stats, &progress);
                });
            });
        });
        group.throughput(Throughput::Elements(1));
        group.bench_function(format!("{name}/survey"), |bencher| {
            bencher.iter(|| black_box(survey(&job)));
        });
    }
    group.finish();
}

/// A picture of two things in the sun over a floor, by effects of motion: of one scene in which they
/// stand still, and of one in which they, or the camera, move.
fn motion(criterion: &mut Criterion) {
    let scene = |camera: &str, move_by: &str| {
        let text = format!(
            "Film \"rgb\" \"integer xresolution\" 128 \"integer yresolution\" 128\n\
             Sampler \"zsobol\" \"integer pixelsamples\" 16\n\
             Integrator \"path\" \"integer maxdepth\" 3\n{camera}\n\
             Camera \"perspective\" \"float fov\" 50 WorldBegin\n\
             LightSource \"distant\" \"point3 from\" [1 3 -1] \"point3 to\" [0 0 0]\n\
             LightSource \"infinite\"\n\
             Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n\
             \"point3 P\" [-9 -1 -9  9 -1 -9  9 -1 9  -9 -1 9]\n\
             ObjectBegin \"thing\" Shape \"sphere\" \"float radius\" .5\n\
             Shape \"cylinder\" \"float radius\" .2 ObjectEnd\n\
             Translate -.8 0 3 {move_by} ObjectInstance \"thing\"\n\
             Translate 1.6 0 0 Rotate 90 1 0 0 ObjectInstance \"thing\""
        );
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("motion.pbrt");
        std::fs::write(&path, text).expect("a file in it");
        pbrt::read(&path).expect("a scene")
    };
    let end = |what: &str| format!("ActiveTransform EndTime {what} ActiveTransform All");
    let turn = "Translate .1 .05 0 Rotate 40 0 1 1";
    let job = |camera: &str, things: &str, effects: &str, rolling: Option<&str>| {
        let rolling = rolling.map(|text| text.parse().expect("a time"));
        let effects = effects.parse().expect("effects");
        let changes = Changes { effects, rolling, ..Changes::default() };
        prepare(scene(camera, things), &changes).expect("a job").0
    };
    let ride = end("Rotate 2 0 1 0");
    let mut group = criterion.benchmark_group("effect/motion");
    group.throughput(Throughput::Elements(128 * 128 * 16));
    for (name, job) in [
        ("without", job("", "Translate .05 .025 0 Rotate 20 0 1 1", "auto", None)),
        ("off", job("", &end(turn), "none", None)),
        ("things go", job("", &end("Translate .3 0 0"), "auto", None)),
        ("things turn", job("", &end(turn), "auto", None)),
        ("camera", job(&ride, "", "auto", None)),
        ("rolling, things turn", job("", &end(turn), "auto", Some("100ms"))),
    ] {
        planned(&job, Effect::Motion);
        planned(&job, Effect::RollingShutter);
        group.bench_function(name, |bencher| {
            bencher
                .iter(|| render(&job, Backend::Simd, 1, &Progress::default()).expect("a render"));
        });
    }
    group.finish();
}

/// ns a pixel of the finished picture, on one thread: without diffraction, and with one zone and
/// with many.
fn diffraction(bench: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut group = bench.benchmark_group("effect/diffraction");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    let job = |f_number: Option<f64>, effects: &str| {
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let effects = effects.parse().expect("effects");
        let changes = Changes {
            f_number,
            effects,
            resolution: Some(LARGE),
            samples: Some(16),
            ..Changes::default()
        };
        prepare(description, &changes).expect("a job").0
    };
    group.throughput(Throughput::Elements(u64::from(LARGE[0] * LARGE[1])));
    group.sample_size(10);
    for (name, f_number, effects) in [
        ("off", Some(22.0), "-diffraction"),
        ("on", Some(22.0), "+diffraction"),
        ("on, wide open", None, "+diffraction"),
    ] {
        let job = job(f_number, effects);
        let film = FilmSums::new(job.frame, false);
        let stats = Stats::default();
        let exposed = Exposed { film, features: None, stats, reached: None, partial: None };
        planned(&job, Effect::Diffraction);
        let zones = Diffraction::new(&job.camera, &job.frame, &job.light).zones();
        group.bench_function(format!("{name} ({zones} zones)"), |bencher| {
            bencher.iter(|| pool.install(|| exposed.picture(&job)));
        });
    }
    group.finish();
}

/// A picture that is small for a photograph.
const LARGE: [u32; 2] = [1200, 800];

/// Film points to rays in the world: with everything square, with the film and with an element
/// askew.
fn tilt_shift(criterion: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let square = read(&folder.join(LENS.0)).expect("a lens of the repository");
    let mut element = square.clone();
    let pose = Pose { decentre: [0.02, 0.01], tilt: [0.05, 0.0] };
    element.askew = vec![Askew { rows: [2, 4], pose }];
    let scene = folder.join("scenes/dgauss.pbrt");
    let wanted: Wanted = "-ghosts".parse().expect("a list");
    let mut group = criterion.benchmark_group("effect/tilt_shift");
    group.throughput(Throughput::Elements(64 * 64 * 64));
    let mut launch = Launch::default();
    let cases = [
        ("off", &square, Pose::SQUARE),
        ("shift", &square, Pose::of_film([3.0, -2.0], [0.0; 2])),
        ("tilt", &square, Pose::of_film([0.0; 2], [3.0, 1.0])),
        ("element", &element, Pose::SQUARE),
    ];
    for (name, lens, pose) in cases {
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let changes = Changes {
            resolution: Some([64, 64]),
            samples: Some(64),
            effects: wanted.clone(),
            ..Changes::default()
        };
        let mut job = prepare(description, &changes).expect("a job").0;
        let half = job.camera.film.map(|side| side / 2.0);
        let film = FilmPlane { distance: LENS.1, pose, radius: half[0].hypot(half[1]), half };
        let model = RealLens::posed(lens.clone(), &film, Aim::Pupil, 1.0, 0.0);
        job.camera.model = Model::Real(Box::new(model));
        group.bench_function(name, |bencher| bencher.iter(|| launch.all(&job)));
    }
    for (film_shift, film_tilt) in [(Some([3.0, -2.0]), None), (None, Some([3.0, 1.0]))] {
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let changes = Changes { film_shift, film_tilt, ..Changes::default() };
        planned(&prepare(description, &changes).expect("a job").0, Effect::TiltShift);
    }
    // A turn alone: the trace of a wave, with two turns around an element and without.
    group.throughput(Throughput::Elements(WAVE as u64));
    let fresh = wave();
    for (name, lens) in [("trace, off", &square), ("trace, element", &element)] {
        let surfaces = sequence::<f32>(lens, From::Film(LENS.1));
        let mut blocked = vec![0; lens.rows.len()];
        let mut batch = fresh.clone();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                (*batch).clone_from(&fresh);
                trace::<f32x8>(black_box(&mut batch), &surfaces, &mut blocked);
            });
        });
        assert_eq!(blocked, vec![0; lens.rows.len()], "the bench means rays that pass");
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = diffraction, dispersion, fresnel, ghosts, motion, sensor, tilt_shift
}
criterion_main!(benches);
