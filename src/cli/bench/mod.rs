//! `petzval bench`: the same short measurements on every machine.

mod files;
mod hills;
mod textbook;
mod wave;

use std::hint::black_box;
use std::time::{Duration, Instant};

use petzval::film::{FilmSums, sample};
use petzval::job::{Changes, prepare};
use petzval::lanes::f32x8;
use petzval::lens::{
    Coating, Fidelity, From, LensColumns, LensRay, Model, Prescription, RealLens, ThinLens, read,
    sequence, trace_one,
};
use petzval::rays::{Column, HitBatch, RayBatch, SampleBatch, WAVE};
use petzval::render::{Backend, Job, Progress, render};
use petzval::scene::{TraversalStack, pbrt};
use petzval::spectrum::bands;
use petzval::stats::{LensStats, Stage, Stats};
use serde_json::{Value, json};

use super::{BenchArguments, Failure, Outcome};
use files::Files;
use wave::{Bench, starts};

/// Film of the double Gauss behind its rear vertex in the course's scene, mm.
const FILM: f64 = 36.77;

/// How long one thing is measured.
const WHILE: Duration = Duration::from_millis(300);

/// What was measured.
struct Measure {
    name: String,
    value: f64,
    unit: &'static str,
}

/// The suite, and what it found.
#[derive(Default)]
struct Suite {
    measures: Vec<Measure>,
}

impl Suite {
    fn put(&mut self, name: impl Into<String>, value: f64, unit: &'static str) {
        self.measures.push(Measure { name: name.into(), value, unit });
    }

    /// Millions a second, by the fastest of several runs: others on the machine only slow it.
    fn rate(&mut self, name: &str, elements: u64, mut run: impl FnMut()) -> f64 {
        let seconds = fastest(&mut run);
        let rate = elements as f64 / seconds / 1e6;
        self.put(name, rate, "M/s");
        rate
    }

    fn of(&self, name: &str) -> f64 {
        self.measures.iter().find(|measure| measure.name == name).map_or(f64::NAN, |m| m.value)
    }

    fn ratio(&mut self, name: &str, [of, over]: [&str; 2]) {
        self.put(name, self.of(of) / self.of(over), "x");
    }
}

/// Seconds of the fastest run of many.
fn fastest(run: &mut impl FnMut()) -> f64 {
    run();
    let (begun, mut best) = (Instant::now(), f64::INFINITY);
    while begun.elapsed() < WHILE {
        let start = Instant::now();
        run();
        best = best.min(start.elapsed().as_secs_f64());
    }
    best
}

pub(super) fn run(arguments: &BenchArguments) -> Result<Outcome, Failure> {
    let files = Files::write()?;
    let mut suite = Suite::default();
    say!("petzval: measuring on one core, some 10 s; other work on the machine falsifies it");
    let lens = read(&files.path("lenses/dgauss.50mm.dat"))?;
    traces(&mut suite, &lens);
    pupil(&mut suite, &files)?;
    models(&mut suite, &files)?;
    scene(&mut suite);
    pictures(&mut suite, &files)?;
    effects(&mut suite, &files, &lens)?;
    for (name, of) in [
        ("ratio.simd_scalar", ["lens.trace.dgauss.f32x8", "lens.trace.dgauss.f32"]),
        ("ratio.simd_textbook", ["lens.trace.dgauss.f32x8", "lens.trace.dgauss.textbook"]),
        ("ratio.f64_f32", ["lens.trace.dgauss.f64", "lens.trace.dgauss.f32x8"]),
        ("ratio.real_thin", ["render.dgauss.real", "render.dgauss.thin"]),
        ("ratio.real_pinhole", ["render.dgauss.real", "render.dgauss.pinhole"]),
    ] {
        suite.ratio(name, of);
    }
    let row = |Measure { name, value, unit }: &Measure| json!({ "name": name, "value": value, "unit": unit });
    let text = match arguments.json {
        true => format!("{:#}\n", Value::Array(suite.measures.iter().map(row).collect())),
        false => suite
            .measures
            .iter()
            .map(|Measure { name, value, unit }| format!("{name:<32}{value:>12.3} {unit}\n"))
            .collect(),
    };
    super::print(&text)
}

/// Rays through all surfaces of a lens.
fn traces(suite: &mut Suite, lens: &Prescription) {
    let rays = WAVE as u64;
    let mut wide = Bench::<f32x8>::new(lens, FILM, WAVE, 1.0);
    suite.rate("lens.trace.dgauss.f32x8", rays, || wide.trace());
    let surfaces = sequence::<f32>(lens, From::Film(FILM));
    let single: Vec<LensRay<f32>> = starts(WAVE, FILM, 1.0)
        .iter()
        .map(|[p, t]| LensRay::new(p.map(|v| v as f32), t.map(|v| v as f32)))
        .collect();
    suite.rate("lens.trace.dgauss.f32", rays, || {
        black_box(single.iter().filter(|ray| trace_one::<f32>(**ray, &surfaces).is_ok()).count());
    });
    let mut double = Bench::<f64>::new(lens, FILM, WAVE, 1.0);
    suite.rate("lens.trace.dgauss.f64", rays, || double.trace());
    let table = textbook::table(lens, FILM);
    let others: Vec<textbook::Ray> =
        single.iter().map(|ray| textbook::Ray::leaving(ray.p, ray.t)).collect();
    suite.rate("lens.trace.dgauss.textbook", rays, || {
        black_box(others.iter().filter(|ray| textbook::trace(&table, **ray).is_some()).count());
    });
}

/// The stages from film points to rays in the world.
struct Launch {
    samples: SampleBatch,
    columns: LensColumns,
    rays: RayBatch,
    stats: LensStats,
}

impl Launch {
    fn new(job: &Job) -> Self {
        let rows = match &job.camera.model {
            Model::Real(lens) => lens.prescription.rows.len(),
            Model::Thin(_) => 0,
        };
        Self {
            samples: SampleBatch::default(),
            columns: LensColumns::default(),
            rays: RayBatch::default(),
            stats: LensStats { blocked: vec![0; rows], ..LensStats::default() },
        }
    }

    /// All waves of a picture; answers how many rays left the lens.
    fn all(&mut self, job: &Job) -> u64 {
        let Self { samples, columns, rays, stats } = self;
        let (film, filter) = (job.camera.film, &job.film.filter);
        let mut left = 0;
        for tile in job.frame.tiles() {
            let mut tile = job.sampler(&tile, job.samples.clone());
            while sample(&mut tile, &job.frame, filter, film, 0, samples) {
                job.camera.expose::<f32x8>(samples, columns, black_box(rays), stats);
                left += rays.len as u64;
            }
        }
        left
    }
}

/// A course scene as it stands but for size and samples, with no effects.
fn job(files: &Files, scene: &str, changes: Changes) -> Result<Job, Failure> {
    let description = pbrt::read(&files.path(&format!("scenes/{scene}.pbrt")))?;
    let effects = "none".parse()?;
    Ok(prepare(description, &Changes { effects, ..changes })?.0)
}

fn small() -> Changes {
    Changes { resolution: Some([96, 96]), samples: Some(32), ..Changes::default() }
}

/// Film points to valid rays, and the share of rays that are.
fn pupil(suite: &mut Suite, files: &Files) -> Result<(), Failure> {
    for scene in ["dgauss", "fisheye", "telephoto", "wide"] {
        for stop in [1.0, 8.0] {
            let mut job = job(files, scene, small())?;
            let Model::Real(lens) = &mut job.camera.model else { continue };
            if stop > 1.0 {
                let mut closed = lens.prescription.clone();
                let opened = closed.rows[closed.stop()].diameter;
                closed.stop_down(opened / stop);
                let radius = job.camera.film[0].hypot(job.camera.film[1]) / 2.0;
                let (film, unit, front) = (lens.film_distance, lens.unit, lens.front);
                **lens = RealLens::new(closed, film, radius, Default::default(), unit, front);
            }
            let mut launch = Launch::new(&job);
            let left = launch.all(&job);
            let suffix = if stop > 1.0 { ".stop8" } else { "" };
            let share = left as f64 / launch.stats.aimed as f64;
            suite.put(format!("pupil.survival.{scene}{suffix}"), share, "share");
            if stop == 1.0 {
                suite.rate(&format!("lens.valid.{scene}"), left, || {
                    black_box(launch.all(&job));
                });
            }
        }
    }
    Ok(())
}

/// Film points to valid rays, by the model of the lens.
fn models(suite: &mut Suite, files: &Files) -> Result<(), Failure> {
    let real = job(files, "dgauss", small())?;
    for fidelity in Fidelity::ALL {
        let mut job = real.clone();
        job.camera = real.camera.simulated(fidelity);
        let mut launch = Launch::new(&job);
        let left = launch.all(&job);
        suite.rate(&format!("lens.model.dgauss.{fidelity}"), left, || {
            black_box(launch.all(&job));
        });
    }
    Ok(())
}

/// Nearest hits and any hits on hills of 130,000 triangles.
fn scene(suite: &mut Suite) {
    let scene = hills::built(hills::hills(255));
    let [camera, diffuse, shadow] = hills::waves(&scene);
    let (mut hits, mut stack) = (HitBatch::default(), TraversalStack::default());
    for (name, waves) in [("camera", &camera), ("diffuse", &diffuse)] {
        suite.rate(&format!("scene.closest.{name}"), (waves.len() * WAVE) as u64, || {
            for wave in waves {
                scene.intersect::<f32x8>(black_box(wave), &mut hits, &mut stack);
            }
        });
    }
    let mut radiance: [Column<f32>; 3] = Default::default();
    suite.rate("scene.any.shadow", (shadow.len() * WAVE) as u64, || {
        for wave in &shadow {
            scene.occlude::<f32x8>(black_box(wave), &mut stack, &mut radiance);
        }
    });
}

/// Film samples of whole pictures on one core, and where their time goes.
fn pictures(suite: &mut Suite, files: &Files) -> Result<(), Failure> {
    let mut take = |name: &str, job: &Job| -> Result<(), Failure> {
        let [width, height] = job.frame.size();
        let samples = u64::from(width * height * (job.samples.end - job.samples.start));
        let progress = Progress::default();
        let stats = render(job, Backend::Simd, 1, &progress)?.stats;
        suite.rate(&format!("render.{name}"), samples, || {
            black_box(render(job, Backend::Simd, 1, &progress).is_ok());
        });
        for stage in [Stage::Lens, Stage::Intersect, Stage::Shade, Stage::Occlude] {
            let part = stats.stage(stage);
            let ns = part.time.as_nanos() as f64 / part.rays.max(1) as f64;
            suite.put(format!("render.{name}.{}.ns", stage.name()), ns, "ns/ray");
        }
        Ok(())
    };
    // The middle, that every lens lights, so that every camera takes the same samples.
    let middle = || Changes { crop: Some([[28, 44], [68, 84]]), ..small() };
    for scene in ["dgauss", "fisheye", "telephoto", "wide"] {
        take(&format!("{scene}.real"), &job(files, scene, middle())?)?;
    }
    for (name, radius) in [("dgauss.thin", 0.0124), ("dgauss.pinhole", 0.0)] {
        let mut job = job(files, "dgauss", middle())?;
        let Model::Real(lens) = &job.camera.model else { continue };
        let focal = lens.paraxial.focal_length;
        job.camera.film = job.camera.film.map(|side| side / focal);
        job.camera.model = Model::Thin(ThinLens { radius, focus: 3.88, middle: [0.0; 2] });
        take(name, &job)?;
    }
    Ok(())
}

/// What effects add to a film sample, ns.
fn effects(suite: &mut Suite, files: &Files, lens: &Prescription) -> Result<(), Failure> {
    let off = job(files, "dgauss", small())?;
    let samples = (96 * 96 * 32) as f64;
    let mut launch = Launch::new(&off);
    let mut ns = |job: &Job| {
        1e9 * fastest(&mut || {
            black_box(launch.all(job));
        }) / samples
    };
    let without = ns(&off);
    let mut dispersed = off.clone();
    if let Model::Real(lens) = &mut dispersed.camera.model {
        lens.disperse(&bands());
    }
    suite.put("effect.dispersion.ns", ns(&dispersed) - without, "ns/sample");
    let mut lossy = off.clone();
    if let Model::Real(real) = &mut lossy.camera.model {
        let mut coated = lens.clone();
        coated.coat(Coating::Mgf2);
        let radius = off.camera.film[0].hypot(off.camera.film[1]) / 2.0;
        let (film, unit, front) = (real.film_distance, real.unit, real.front);
        **real = RealLens::new(coated, film, radius, Default::default(), unit, front);
        real.fresnel = true;
    }
    suite.put("effect.fresnel.ns", ns(&lossy) - without, "ns/sample");
    let description = pbrt::read(&files.path("scenes/fisheye.pbrt"))?;
    let haunted = prepare(description, &Changes { effects: "+ghosts".parse()?, ..small() })?.0;
    if let Some(ghosts) = &haunted.ghosts {
        let mut film = FilmSums::new(haunted.frame, false);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let seconds = fastest(&mut || {
            let (mut stats, progress) = (Stats::default(), Progress::default());
            let samples = haunted.samples.clone();
            pool.install(|| {
                ghosts.expose::<f32x8>(&haunted, samples, &mut film, &mut stats, &progress);
            });
        });
        suite.put("effect.ghosts.ns", 1e9 * seconds / samples, "ns/sample");
    }
    Ok(())
}
