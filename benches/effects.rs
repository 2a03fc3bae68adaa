//! Cost of effects: each off and on in the same run.

use std::hint::black_box;
use std::path::Path;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use petzval_base::io::OutputFile;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{LensBatch, WAVE_SIZE};
use petzval_base::stats::Stats;
use petzval_image::{DisplayExposure, Picture};
use petzval_lens::{
    Coating, CoatingLayer, FilmPlane, LayerStack, LensModel, Pose, PupilSampling, RealLens, Side,
    Surface, TiltDecenter, sequence, trace, trace_lossy,
};
use petzval_lens_formats::read;
use petzval_render::diffraction::Diffraction;
use petzval_render::film::{FilmSums, Frame};
use petzval_render::job::Job;
use petzval_render::light_tracing::ghosts::estimate;
use petzval_render::light_tracing::{SplatStage, Strategy};
use petzval_render::plan::{Effect, EffectSelection};
use petzval_render::prepare::{Changes, prepare};
use petzval_render::sensor::{Bayer, Components, Sensor, SensorSettings};
use petzval_render::{OpticalImage, RenderOptions, RenderOutput, render};
use petzval_scene_formats::pbrt;
use petzval_spectrum::Glass;
use petzval_tools::bench::launch::Launch;
use petzval_tools::bench::lens_wave::{batch, starts};

/// The double Gauss of the course and the film distance of its scene (mm).
const LENS: (&str, f64) = ("lenses/dgauss.50mm.dat", 36.77);

/// Prints the cost of an effect that the plan estimates, for comparison with the measurement.
fn print_estimate(job: &Job, effect: Effect) {
    let row = job.plan.effects.iter().find(|row| row.effect == effect && row.on);
    if let Some(cost) = row.and_then(|row| row.cost) {
        println!("{}: the plan says {:.1} ns a film sample", effect.name(), cost.ns_per_ray);
    }
}

type Trace = fn(&mut LensBatch<f32>, &[Surface<f32>], &mut [u64]);

/// Returns a coating of six films.
fn six_layers() -> Coating {
    let film =
        |[index, thickness]: [f64; 2]| CoatingLayer { index, glass: Glass::Constant, thickness };
    let films = [[1.38, 92.0], [2.1, 110.0], [1.46, 35.0], [2.1, 25.0], [1.62, 60.0], [2.3, 15.0]];
    Coating::Stack(LayerStack { name: "six layers".into(), layers: films.map(film).into() })
}

/// Measures the trace of a wave without reflection losses and with each coating.
fn fresnel(criterion: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let bare = read(&folder.join(LENS.0)).expect("a lens of the repository");
    let mut group = criterion.benchmark_group("effect/fresnel");
    group.throughput(Throughput::Elements(WAVE_SIZE as u64));
    let fresh = batch::<f32x8>(&starts(WAVE_SIZE, LENS.1, 1.0));
    let cases: [(&str, Coating, Trace); 5] = [
        ("off", Coating::Bare, trace::<f32x8>),
        ("on", Coating::Bare, trace_lossy::<f32x8>),
        ("on, broadband", Coating::Broadband, trace_lossy::<f32x8>),
        ("on, mgf2", Coating::Mgf2, trace_lossy::<f32x8>),
        ("on, six layers", six_layers(), trace_lossy::<f32x8>),
    ];
    for (name, coating, trace) in cases {
        let mut lens = bare.clone();
        lens.coat(&coating);
        let surfaces = sequence::<f32>(&lens, Side::Film(LENS.1));
        let mut blocked = vec![0; lens.rows.len()];
        let mut batch = fresh.clone();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                // Tracing changes the wave, so each iteration starts from a copy.
                (*batch).clone_from(&fresh);
                trace(black_box(&mut batch), &surfaces, &mut blocked);
            });
        });
        assert_eq!(blocked, vec![0; lens.rows.len()], "all rays of the bench must pass");
    }
    let scene = pbrt::read(&folder.join("scenes/dgauss.pbrt")).expect("a scene of the repository");
    let changes = Changes { coating: Some(Coating::Mgf2), ..Changes::default() };
    print_estimate(&prepare(scene, &changes).expect("a job").job, Effect::Fresnel);
    // The estimate of the loss takes 33 film points.
    let lens = RealLens::new(bare, LENS.1, 21.6, PupilSampling::Pupil, 1.0, 0.0);
    group.throughput(Throughput::Elements(1));
    group.bench_function("estimate", |bencher| bencher.iter(|| lens.throughput(21.6)));
    group.finish();
}

/// Measures a picture with the effects that are planned, and with everything off, on one thread.
fn everything_off(criterion: &mut Criterion) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    let job = |effects: &str| {
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let changes = Changes {
            resolution: Some([64, 64]),
            samples: Some(64),
            effects: effects.parse().expect("effects"),
            ..Changes::default()
        };
        prepare(description, &changes).expect("a job").job
    };
    let mut group = criterion.benchmark_group("effect/everything_off");
    group.throughput(Throughput::Elements(64 * 64 * 64));
    for (name, job) in [("planned", job("auto")), ("off", job("none"))] {
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                render(&job, RenderOptions { threads: 1, ..RenderOptions::default() })
                    .expect("a render")
            });
        });
    }
    group.finish();
}

const SIZE: [u32; 2] = [256, 256];

/// Measures the sensor on one thread, per pixel of the finished picture.
fn sensor(bench: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut group = bench.benchmark_group("effect/sensor");
    group.throughput(Throughput::Elements(u64::from(SIZE[0] * SIZE[1])));

    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    let description = pbrt::read(&scene).expect("a scene of the repository");
    let job = prepare(description, &Changes::default()).expect("a job").job;
    let frame = Frame::whole(SIZE);
    let job = Job { frame, sensor: None, ..job };
    let exposed = RenderOutput {
        film: FilmSums::new(frame),
        features: None,
        stats: Stats::default(),
        convergence: None,
        partial_mean_spp: None,
    };
    // The estimate is for one sample per pixel.
    let description = pbrt::read(&scene).expect("a scene of the repository");
    let asked = Some(Default::default());
    let changes = Changes { sensor: asked, samples: Some(1), ..Changes::default() };
    print_estimate(&prepare(description, &changes).expect("a job").job, Effect::Sensor);
    group.bench_function("without", |bencher| bencher.iter(|| exposed.film.picture(16)));
    group.bench_function("off", |bencher| bencher.iter(|| exposed.picture(&job)));

    let on = Sensor {
        iso: 800.0,
        full_well: 54_000.0,
        read_noise: Components { pixel: 2.5, ..Components::default() },
        bits: 14,
        black_level: 512,
        ..Sensor::default()
    };
    let mosaic = Sensor { bayer: Some(Bayer::Rggb), ..on };
    let settings: SensorSettings =
        "iso=800,well=54000,read=2/1/1,dark=5,time=1,dsnu=2/1/1,prnu=1/1/1,hot=0.001/500"
            .parse()
            .expect("settings");
    let patterns = settings.sensor(100.0, 6.0, 1.0);
    for (name, sensor, value) in [
        ("on", on, 0.18),
        ("on/dark", on, 5e-4),
        ("on/bayer", mosaic, 0.18),
        ("on/patterns", patterns, 0.18),
    ] {
        let size = SIZE.map(|n| n as usize);
        let picture = Picture { size, pixels: vec![[value; 3]; size[0] * size[1]] };
        group.bench_function(name, |bencher| {
            let read = |picture| pool.install(|| sensor.read_out(picture, [0, 0], 0));
            bencher.iter_batched(|| picture.clone(), read, BatchSize::LargeInput);
        });
    }
    group.finish();
}

/// Measures a raw file of 12 megapixels from a finished picture, on all threads: sensor, codes and file.
fn raw_file(criterion: &mut Criterion) {
    let size = [4000, 3000];
    let changes = Changes {
        sensor: Some("iso=100,pixel=3,bayer".parse().expect("settings")),
        resolution: Some(size),
        ..Changes::default()
    };
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    let job = prepare(pbrt::read(&scene).expect("a scene"), &changes).expect("a job").job;
    let encoding = job.encoding(DisplayExposure::default());
    let folder = tempfile::tempdir().expect("a folder");
    let file = OutputFile::new(folder.path().join("a.dng"), &job.files).expect("a new file");
    let pixels = size.map(|n| n as usize);
    let picture = Picture { size: pixels, pixels: vec![[0.18; 3]; pixels[0] * pixels[1]] };
    let mut group = criterion.benchmark_group("effect/raw");
    group.sample_size(10);
    group.bench_function("12 megapixels", |bencher| {
        let write = |picture| {
            let raw = OpticalImage::from(picture).read_out(&job).picture;
            raw.write(&file, job.frame.window(), encoding, &Vec::new()).expect("a file");
        };
        bencher.iter_batched(|| picture.clone(), write, BatchSize::PerIteration);
    });
    group.finish();
}

/// Measures the camera, from film points to rays in the world, with and without dispersion.
fn dispersion(criterion: &mut Criterion) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/dgauss.pbrt");
    // The lens has no dispersion data; guessed glasses take as long as known ones.
    let job = |effects: &str| {
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let changes = Changes {
            resolution: Some([64, 64]),
            samples: Some(64),
            assume_vd: true,
            effects: effects.parse().expect("effects"),
            ..Changes::default()
        };
        prepare(description, &changes).expect("a job").job
    };
    let (off, on) = (job("-dispersion"), job("+dispersion"));
    print_estimate(&on, Effect::Dispersion);
    let mut group = criterion.benchmark_group("effect/dispersion");
    group.throughput(Throughput::Elements(64 * 64 * 64));
    let mut launch = Launch::default();
    for (name, job) in [("off", &off), ("on", &on)] {
        group.bench_function(name, |bencher| bencher.iter(|| launch.job(job)));
    }
    group.finish();
}

/// Measures ghosts: paths from lights over two reflections to the film, per film sample of the picture.
fn ghosts(criterion: &mut Criterion) {
    const SAMPLES: u32 = 16;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let mut group = criterion.benchmark_group("effect/ghosts");
    for name in ["dgauss", "fisheye"] {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.pbrt"));
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let effects = EffectSelection::Overrides(vec![(Effect::Ghosts, true)]);
        let changes = Changes { samples: Some(SAMPLES), effects, ..Changes::default() };
        let job = prepare(description, &changes).expect("a job").job;
        let ghosts = [Strategy::Ghosts(job.ghosts.as_ref().expect("they are asked for"))];
        let stage = SplatStage::default();
        print_estimate(&job, Effect::Ghosts);
        let samples = |tile| job.sampler(tile, job.samples.clone()).count();
        group.throughput(Throughput::Elements(job.tiles().iter().map(samples).sum()));
        let mut film = FilmSums::new(job.frame);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                pool.install(|| {
                    let (samples, mut stats) = (job.samples.clone(), Stats::default());
                    let (input, film) = (job.light_path_input(), &mut film);
                    stage.run::<f32x8>(&input, &ghosts, samples, &|| true, film, &mut stats);
                });
            });
        });
        group.throughput(Throughput::Elements(1));
        group.bench_function(format!("{name}/survey"), |bencher| {
            bencher.iter(|| black_box(estimate(&job.light_path_input())));
        });
    }
    group.finish();
}

/// Measures a picture of two objects over a floor with motion effects: with still objects, with moving
/// objects, and with a moving camera.
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
        prepare(scene(camera, things), &changes).expect("a job").job
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
        print_estimate(&job, Effect::Motion);
        print_estimate(&job, Effect::RollingShutter);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                render(&job, RenderOptions { threads: 1, ..RenderOptions::default() })
                    .expect("a render")
            });
        });
    }
    group.finish();
}

/// Measures diffraction on one thread, per pixel of the finished picture: off, with one zone, and with
/// many.
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
        prepare(description, &changes).expect("a job").job
    };
    group.throughput(Throughput::Elements(u64::from(LARGE[0] * LARGE[1])));
    group.sample_size(10);
    for (name, f_number, effects) in [
        ("off", Some(22.0), "-diffraction"),
        ("on", Some(22.0), "+diffraction"),
        ("on, wide open", None, "+diffraction"),
    ] {
        let job = job(f_number, effects);
        let film = FilmSums::new(job.frame);
        let stats = Stats::default();
        let exposed =
            RenderOutput { film, features: None, stats, convergence: None, partial_mean_spp: None };
        print_estimate(&job, Effect::Diffraction);
        let zones = Diffraction::new(&job.camera, &job.frame, &job.bands).zones();
        group.bench_function(format!("{name} ({zones} zones)"), |bencher| {
            bencher.iter(|| pool.install(|| exposed.picture(&job)));
        });
    }
    group.finish();
}

/// Resolution of a picture that is small for a photograph.
const LARGE: [u32; 2] = [1200, 800];

/// Measures the camera, from film points to rays in the world: aligned, with a tilted film, and with a
/// tilted element.
fn tilt_shift(criterion: &mut Criterion) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let square = read(&folder.join(LENS.0)).expect("a lens of the repository");
    let mut element = square.clone();
    let pose = Pose { decentre: [0.02, 0.01], tilt: [0.05, 0.0] };
    element.tilt_decenters = vec![TiltDecenter { rows: [2, 4], pose }];
    let scene = folder.join("scenes/dgauss.pbrt");
    let wanted: EffectSelection = "-ghosts".parse().expect("a list");
    let mut group = criterion.benchmark_group("effect/tilt_shift");
    group.throughput(Throughput::Elements(64 * 64 * 64));
    let cases = [
        ("off", &square, Pose::ALIGNED),
        ("shift", &square, Pose::of_film([3.0, -2.0], [0.0; 2])),
        ("tilt", &square, Pose::of_film([0.0; 2], [3.0, 1.0])),
        ("element", &element, Pose::ALIGNED),
    ];
    for (name, lens, pose) in cases {
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let changes = Changes {
            resolution: Some([64, 64]),
            samples: Some(64),
            effects: wanted.clone(),
            ..Changes::default()
        };
        let mut job = prepare(description, &changes).expect("a job").job;
        let half = job.camera.film.map(|side| side / 2.0);
        let film = FilmPlane { distance: LENS.1, pose, radius: half[0].hypot(half[1]), half };
        let model = RealLens::with_film(lens.clone(), &film, PupilSampling::Pupil, 1.0, 0.0);
        job.camera.model = LensModel::Real(Box::new(model));
        let mut launch = Launch::default();
        group.bench_function(name, |bencher| bencher.iter(|| launch.job(&job)));
    }
    for (film_shift, film_tilt) in [(Some([3.0, -2.0]), None), (None, Some([3.0, 1.0]))] {
        let description = pbrt::read(&scene).expect("a scene of the repository");
        let changes = Changes { film_shift, film_tilt, ..Changes::default() };
        print_estimate(&prepare(description, &changes).expect("a job").job, Effect::TiltShift);
    }
    // The change of frame alone: the trace of a wave with and without two changes around an element.
    group.throughput(Throughput::Elements(WAVE_SIZE as u64));
    let fresh = batch::<f32x8>(&starts(WAVE_SIZE, LENS.1, 1.0));
    for (name, lens) in [("trace, off", &square), ("trace, element", &element)] {
        let surfaces = sequence::<f32>(lens, Side::Film(LENS.1));
        let mut blocked = vec![0; lens.rows.len()];
        let mut batch = fresh.clone();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                (*batch).clone_from(&fresh);
                trace::<f32x8>(black_box(&mut batch), &surfaces, &mut blocked);
            });
        });
        assert_eq!(blocked, vec![0; lens.rows.len()], "all rays of the bench must pass");
    }
    group.finish();
}

/// Measures a picture of a ball over a floor without media, with a homogeneous medium, with a cloud, and
/// with subsurface scattering.
fn media(criterion: &mut Criterion) {
    const COEFFICIENTS: &str = "\"rgb sigma_a\" [.1 .1 .1] \"rgb sigma_s\" [1 1 1]";
    let scene = |medium: &str, material: &str| {
        let text = format!(
            "Film \"rgb\" \"integer xresolution\" 128 \"integer yresolution\" 128\n\
             Sampler \"zsobol\" \"integer pixelsamples\" 16\n\
             Camera \"perspective\" \"float fov\" 50 WorldBegin\n\
             LightSource \"distant\" \"point3 from\" [1 3 -1] \"point3 to\" [0 0 0]\n\
             LightSource \"infinite\"\n\
             Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n\
             \"point3 P\" [-9 -1 -9  9 -1 -9  9 -1 9  -9 -1 9]\n\
             Translate 0 0 3 {medium} {material} Shape \"sphere\""
        );
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("media.pbrt");
        std::fs::write(&path, text).expect("a file in it");
        pbrt::read(&path).expect("a scene")
    };
    let inside = |kind: &str| {
        let named = format!("MakeNamedMedium \"m\" \"string type\" {kind} {COEFFICIENTS}");
        scene(&format!("{named} MediumInterface \"m\" \"\""), "Material \"interface\"")
    };
    let cloud = "\"cloud\" \"point3 p0\" [-1 -1 -1] \"point3 p1\" [1 1 1]";
    let skin = format!("Material \"subsurface\" {COEFFICIENTS} \"float scale\" 10");
    let mut group = criterion.benchmark_group("effect/media");
    group.throughput(Throughput::Elements(128 * 128 * 16));
    for (name, scene, effects) in [
        ("without", scene("", "Material \"interface\""), "auto"),
        ("off", inside("\"homogeneous\""), "none"),
        ("homogeneous", inside("\"homogeneous\""), "auto"),
        ("cloud", inside(cloud), "auto"),
        ("subsurface", scene("", &skin), "auto"),
    ] {
        let effects: EffectSelection = effects.parse().expect("effects");
        let job = prepare(scene, &Changes { effects, ..Changes::default() }).expect("a job").job;
        print_estimate(&job, Effect::Media);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                render(&job, RenderOptions { threads: 1, ..RenderOptions::default() })
                    .expect("a render")
            });
        });
    }
    group.finish();
}

/// Measures pictures of the gallery in RGB and by wavelength, without light that starts at lamps.
fn spectra(criterion: &mut Criterion) {
    const SIZE: [u32; 2] = [150, 100];
    let mut group = criterion.benchmark_group("effect/spectra");
    group.throughput(Throughput::Elements(u64::from(SIZE[0] * SIZE[1]) * 64)).sample_size(10);
    for scene in ["snowman", "dgauss", "night", "atelier"] {
        for sign in ["-", "+"] {
            let effects = format!("{sign}spectra,-dispersion,-diffraction,-ghosts");
            let changes = Changes {
                effects: effects.parse().expect("effects"),
                resolution: Some(SIZE),
                samples: Some(64),
                light_paths: Some(false),
                ..Changes::default()
            };
            let description = pbrt::read(Path::new(&format!("scenes/{scene}.pbrt")));
            let job = prepare(description.expect("a scene"), &changes).expect("a job").job;
            print_estimate(&job, Effect::Spectra);
            group.bench_function(format!("{scene}/{sign}spectra"), |bencher| {
                bencher.iter(|| {
                    render(&job, RenderOptions { threads: 1, ..RenderOptions::default() })
                        .expect("a render")
                });
            });
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = diffraction, dispersion, everything_off, fresnel, ghosts, media, motion, raw_file, sensor, spectra, tilt_shift
}
criterion_main!(benches);
