//! `petzval bench`: the same short benchmarks on every machine.

mod files;
mod suite;

use std::hint::black_box;

use petzval_base::lanes::{f32x8, f64x8};
use petzval_base::rays::{Column, HitBatch, WAVE_SIZE};
use petzval_base::stats::{Stage, Stats};
use petzval_lens::{
    Coating, Fidelity, LensModel, LensRay, Prescription, RealLens, Side, ThinLens, sequence,
    trace_one,
};
use petzval_lens_formats::read;
use petzval_render::film::FilmSums;
use petzval_render::job::Job;
use petzval_render::light_tracing::{SplatStage, Strategy};
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Progress, RenderOptions, render};
use petzval_scene::TraversalStack;
use petzval_scene_formats::pbrt;
use petzval_spectrum::bands;
use petzval_tools::bench::launch::Launch;
use petzval_tools::bench::lens_wave::{LensWave, starts};
use petzval_tools::bench::{hills, textbook};

use super::{Failure, Outcome};
use files::Files;
use suite::{Suite, fastest};

/// Arguments of `petzval bench`.
#[derive(Debug, clap::Args)]
pub(super) struct BenchArguments {
    /// Print a JSON list of name, value and unit
    #[arg(long)]
    json: bool,
}

/// Distance of the film behind the rear vertex of the double Gauss in the course's scene (mm).
const FILM: f64 = 36.77;

pub(super) fn run(arguments: &BenchArguments) -> Result<Outcome, Failure> {
    let files = Files::write()?;
    let mut suite = Suite::default();
    say!(
        "petzval: measuring on one core for about 10 s; other load on the machine distorts the \
         results"
    );
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
        ("ratio.f64_f32", ["lens.trace.dgauss.f64x8", "lens.trace.dgauss.f32x8"]),
        ("ratio.real_thin", ["render.dgauss.real", "render.dgauss.thin"]),
        ("ratio.real_pinhole", ["render.dgauss.real", "render.dgauss.pinhole"]),
    ] {
        suite.ratio(name, of);
    }
    let text = match arguments.json {
        true => suite.json(),
        false => suite.table(),
    };
    super::print(&text)
}

/// Measures rays through all surfaces of a lens.
fn traces(suite: &mut Suite, lens: &Prescription) {
    let rays = WAVE_SIZE as u64;
    let mut wide = LensWave::<f32x8>::new(lens, FILM, WAVE_SIZE, 1.0);
    suite.rate("lens.trace.dgauss.f32x8", rays, || wide.trace());
    let surfaces = sequence::<f32>(lens, Side::Film(FILM));
    let single: Vec<LensRay<f32>> = starts(WAVE_SIZE, FILM, 1.0)
        .iter()
        .map(|[p, t]| LensRay::new(p.map(|v| v as f32), t.map(|v| v as f32)))
        .collect();
    suite.rate("lens.trace.dgauss.f32", rays, || {
        black_box(single.iter().filter(|ray| trace_one::<f32>(**ray, &surfaces).is_ok()).count());
    });
    let mut wide_double = LensWave::<f64x8>::new(lens, FILM, WAVE_SIZE, 1.0);
    suite.rate("lens.trace.dgauss.f64x8", rays, || wide_double.trace());
    let mut double = LensWave::<f64>::new(lens, FILM, WAVE_SIZE, 1.0);
    suite.rate("lens.trace.dgauss.f64", rays, || double.trace());
    let table = textbook::table(lens, FILM);
    let others: Vec<textbook::TextbookRay> =
        single.iter().map(|ray| textbook::TextbookRay::leaving(ray.p, ray.t)).collect();
    suite.rate("lens.trace.dgauss.textbook", rays, || {
        black_box(others.iter().filter(|ray| textbook::trace(&table, **ray).is_some()).count());
    });
}

/// Prepares a course scene without effects.
fn job(files: &Files, scene: &str, changes: Changes) -> Result<Job, Failure> {
    let description = pbrt::read(&files.path(&format!("scenes/{scene}.pbrt")))?;
    let effects = "none".parse()?;
    Ok(prepare(description, &Changes { effects, ..changes })?.job)
}

fn small() -> Changes {
    Changes { resolution: Some([96, 96]), samples: Some(32), ..Changes::default() }
}

/// Measures valid rays from film points, and the share of rays that are valid.
fn pupil(suite: &mut Suite, files: &Files) -> Result<(), Failure> {
    for scene in ["dgauss", "fisheye", "telephoto", "wide"] {
        for stop in [1.0, 8.0] {
            let mut job = job(files, scene, small())?;
            let LensModel::Real(lens) = &mut job.camera.model else { continue };
            if stop > 1.0 {
                let mut closed = lens.prescription.clone();
                let opened = closed.rows[closed.stop()].diameter;
                closed.stop_down(opened / stop);
                let radius = job.camera.film[0].hypot(job.camera.film[1]) / 2.0;
                let (film, unit, front) = (lens.film_distance, lens.units_per_mm, lens.front_depth);
                **lens = RealLens::new(closed, film, radius, Default::default(), unit, front);
            }
            let mut launch = Launch::default();
            let left = launch.job(&job);
            let suffix = if stop > 1.0 { ".stop8" } else { "" };
            let share = left as f64 / launch.stats.aimed as f64;
            suite.put(format!("pupil.survival.{scene}{suffix}"), share, "share");
            if stop == 1.0 {
                suite.rate(&format!("lens.valid.{scene}"), left, || {
                    black_box(launch.job(&job));
                });
            }
        }
    }
    Ok(())
}

/// Measures valid rays from film points by lens model.
fn models(suite: &mut Suite, files: &Files) -> Result<(), Failure> {
    let real = job(files, "dgauss", small())?;
    for fidelity in Fidelity::ALL {
        let mut job = real.clone();
        job.camera = real.camera.with_fidelity(fidelity);
        let mut launch = Launch::default();
        let left = launch.job(&job);
        suite.rate(&format!("lens.model.dgauss.{fidelity}"), left, || {
            black_box(launch.job(&job));
        });
    }
    Ok(())
}

/// Measures nearest hits and any hits on hills of 130,000 triangles.
fn scene(suite: &mut Suite) {
    let scene = hills::built(hills::hills(255));
    let [camera, diffuse, shadow] = hills::waves(&scene);
    let (mut hits, mut stack) = (HitBatch::default(), TraversalStack::default());
    for (name, waves) in [("camera", &camera), ("diffuse", &diffuse)] {
        suite.rate(&format!("scene.closest.{name}"), (waves.len() * WAVE_SIZE) as u64, || {
            for wave in waves {
                scene.intersect::<f32x8>(black_box(wave), &mut hits, &mut stack);
            }
        });
    }
    let mut radiance: [Column<f32>; 3] = Default::default();
    suite.rate("scene.any.shadow", (shadow.len() * WAVE_SIZE) as u64, || {
        for wave in &shadow {
            scene.occlude::<f32x8>(black_box(wave), &mut stack, &mut radiance);
        }
    });
}

/// Measures film samples of whole pictures on one core, and the time by stage.
fn pictures(suite: &mut Suite, files: &Files) -> Result<(), Failure> {
    let mut take = |name: &str, job: &Job| -> Result<(), Failure> {
        let [width, height] = job.frame.size();
        let samples = u64::from(width * height * (job.samples.end - job.samples.start));
        let progress = Progress::default();
        let options =
            RenderOptions { threads: 1, progress: Some(&progress), ..RenderOptions::default() };
        let stats = render(job, options)?.stats;
        suite.rate(&format!("render.{name}"), samples, || {
            black_box(render(job, options).is_ok());
        });
        for stage in [Stage::Lens, Stage::Intersect, Stage::Shade, Stage::Occlude] {
            let part = stats.stage(stage);
            let ns = part.time.as_nanos() as f64 / part.rays.max(1) as f64;
            suite.put(format!("render.{name}.{}.ns", stage.name()), ns, "ns/ray");
        }
        Ok(())
    };
    // Every lens illuminates the middle, so every camera takes the same samples.
    let middle = || Changes { crop: Some([[28, 44], [68, 84]]), ..small() };
    for scene in ["dgauss", "fisheye", "telephoto", "wide"] {
        take(&format!("{scene}.real"), &job(files, scene, middle())?)?;
    }
    for (name, radius) in [("dgauss.thin", 0.0124), ("dgauss.pinhole", 0.0)] {
        let mut job = job(files, "dgauss", middle())?;
        let LensModel::Real(lens) = &job.camera.model else { continue };
        let focal = lens.paraxial.focal_length;
        job.camera.film = job.camera.film.map(|side| side / focal);
        job.camera.model = LensModel::Thin(ThinLens { radius, focus: 3.88, middle: [0.0; 2] });
        take(name, &job)?;
    }
    Ok(())
}

/// Measures what effects add to a film sample (ns).
fn effects(suite: &mut Suite, files: &Files, lens: &Prescription) -> Result<(), Failure> {
    let off = job(files, "dgauss", small())?;
    let samples = (96 * 96 * 32) as f64;
    let mut launch = Launch::default();
    let mut ns = |job: &Job| {
        1e9 * fastest(&mut || {
            black_box(launch.job(job));
        }) / samples
    };
    let without = ns(&off);
    let mut dispersed = off.clone();
    if let LensModel::Real(lens) = &mut dispersed.camera.model {
        lens.disperse(&bands());
    }
    suite.put("effect.dispersion.ns", ns(&dispersed) - without, "ns/sample");
    let mut lossy = off.clone();
    if let LensModel::Real(real) = &mut lossy.camera.model {
        let mut coated = lens.clone();
        coated.coat(&Coating::Mgf2);
        let radius = off.camera.film[0].hypot(off.camera.film[1]) / 2.0;
        let (film, unit, front) = (real.film_distance, real.units_per_mm, real.front_depth);
        **real = RealLens::new(coated, film, radius, Default::default(), unit, front);
        real.fresnel = true;
    }
    suite.put("effect.fresnel.ns", ns(&lossy) - without, "ns/sample");
    let description = pbrt::read(&files.path("scenes/fisheye.pbrt"))?;
    let with_ghosts =
        prepare(description, &Changes { effects: "+ghosts".parse()?, ..small() })?.job;
    if let Some(ghosts) = &with_ghosts.ghosts {
        let (stage, ghosts) = (SplatStage::default(), [Strategy::Ghosts(ghosts)]);
        let mut film = FilmSums::new(with_ghosts.frame);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let seconds = fastest(&mut || {
            let mut stats = Stats::default();
            let samples = with_ghosts.samples.clone();
            pool.install(|| {
                let input = with_ghosts.light_path_input();
                stage.run::<f32x8>(&input, &ghosts, samples, &|| true, &mut film, &mut stats);
            });
        });
        suite.put("effect.ghosts.ns", 1e9 * seconds / samples, "ns/sample");
    }
    Ok(())
}
