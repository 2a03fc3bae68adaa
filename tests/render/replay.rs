//! Replay of single samples: equal to the render, and with the path that geometry predicts.

use std::collections::BTreeMap;

use crate::support::{folder, root, write};
use petzval_image::Picture;
use petzval_lens::{LensModel, RayPath};
use petzval_render::film::SampleId;
use petzval_render::job::Job;
use petzval_render::plan::{Effect, EffectSelection};
use petzval_render::prepare::{Changes, prepare};
use petzval_render::shade::PathOutcome;
use petzval_render::{Backend, RenderOptions, Replay, render, replay};
use petzval_scene_formats::pbrt;

fn job(scene: &str, changes: &Changes) -> Job {
    let resolution = Some([24, 16]);
    let changes = Changes { resolution, ..changes.clone() };
    let description = pbrt::read(&root().join("scenes").join(scene)).expect("a scene");
    prepare(description, &changes).expect("a job").job
}

/// A thin lens, a filter with negative lobes, and surfaces of most kinds.
const THIN: &str = r#"
    Film "rgb" "integer xresolution" 24 "integer yresolution" 16 "float maxcomponentvalue" 4
    PixelFilter "mitchell"
    Camera "perspective" "float fov" 50 "float lensradius" 0.05 "float focaldistance" 4
    Integrator "path" "integer maxdepth" 8
    WorldBegin
    LightSource "infinite" "rgb L" [0.3 0.4 0.5]
    LightSource "point" "rgb I" [8 6 4] "point3 from" [1 3 2]
    AttributeBegin AreaLightSource "diffuse" "rgb L" [3 3 3]
    Translate 0 1.2 3.5 Shape "sphere" "float radius" 0.2 AttributeEnd
    MakeNamedMaterial "a" "string type" "diffuse" "rgb reflectance" [0.8 0.6 0.4]
    MakeNamedMaterial "b" "string type" "conductor" "float roughness" 0.3
    Material "mix" "string materials" ["a" "b"] "float amount" 0.4
    Shape "trianglemesh" "point3 P" [-5 -1 1  -5 -1 9  5 -1 9  5 -1 1] "integer indices" [0 1 2 0 2 3]
    Material "dielectric" AttributeBegin Translate -1 -0.5 4 Shape "sphere" "float radius" 0.5 AttributeEnd
    Material "dielectric" "float roughness" 0.2
    AttributeBegin Translate 0 -0.5 4 Shape "sphere" "float radius" 0.5 AttributeEnd
    Material "coateddiffuse" AttributeBegin Translate 1 -0.5 4 Shape "sphere" "float radius" 0.5 AttributeEnd
    Material "interface" AttributeBegin Translate 0 0.4 3 Shape "sphere" "float radius" 0.3 AttributeEnd"#;

fn thin() -> Job {
    let folder = folder();
    let path = write(&folder, "thin.pbrt", THIN);
    prepare(pbrt::read(&path).expect("a scene"), &Changes::default()).expect("a job").job
}

/// Returns options that turn on every effect on a sample through a real lens.
fn all_options(effects: &str) -> Changes {
    let effects: EffectSelection = effects.parse().expect("effects");
    // Light paths belong to no sample.
    Changes { effects, light_paths: Some(false), ..Changes::default() }
}

fn jobs() -> Vec<(&'static str, Job)> {
    let lens = |name: &str| Some(root().join("lenses").join(name));
    let glass =
        Changes { lens: lens("triplet.toml"), ..all_options("+dispersion,+fresnel,-ghosts") };
    let moving = all_options("+motion,+rolling_shutter,-ghosts");
    let moving = Changes { rolling: "30ms".parse().ok(), ..moving };
    let tilted = Changes { film_tilt: Some([6.0, -4.0]), ..all_options("-ghosts") };
    let jobs = vec![
        ("dgauss", job("dgauss.pbrt", &all_options("-ghosts"))),
        ("fisheye", job("fisheye.pbrt", &all_options("-ghosts"))),
        ("thin", thin()),
        ("glass", job("atelier.pbrt", &glass)),
        ("motion", job("propeller.pbrt", &moving)),
        ("tilted", job("atelier.pbrt", &tilted)),
    ];
    let has = |i: usize, effect| assert!(jobs[i].1.plan.has(effect), "{}", jobs[i].0);
    has(3, Effect::Dispersion);
    has(3, Effect::Fresnel);
    has(4, Effect::Motion);
    has(4, Effect::RollingShutter);
    jobs
}

fn picture(job: &Job, backend: Backend) -> Picture {
    let exposed = render(job, RenderOptions { backend, threads: 1, ..RenderOptions::default() })
        .expect("a render");
    assert_eq!(exposed.film.dropped.count(), 0);
    exposed.film.picture(job.samples.len() as u32)
}

/// Returns the pixels of a job.
fn pixels(job: &Job) -> impl Iterator<Item = [u32; 2]> + use<> {
    let [[x0, y0], [x1, y1]] = [job.frame.low, job.frame.high];
    (y0..y1).flat_map(move |y| (x0..x1).map(move |x| [x, y]))
}

fn value(job: &Job, backend: Backend, pixel: [u32; 2], sample: u32) -> ([f64; 3], Option<Replay>) {
    let replay = replay(job, backend, SampleId::new(pixel, sample, job.seed));
    let value = replay.as_ref().map_or([0.0; 3], |replay| replay.value.expect("a number"));
    (value, replay)
}

#[test]
fn a_replayed_sample_equals_the_render_bit_for_bit() {
    let mut fates: BTreeMap<String, u32> = BTreeMap::new();
    let mut count = |fate: String| *fates.entry(fate).or_default() += 1;
    for (name, mut job) in jobs() {
        job.samples = 5..6;
        for backend in [Backend::Simd, Backend::Scalar] {
            let picture = picture(&job, backend);
            for (pixel, found) in pixels(&job).zip(&picture.pixels) {
                let (value, replay) = value(&job, backend, pixel, 5);
                let bits = |v: [f32; 3]| v.map(f32::to_bits);
                let own = value.map(|v| v as f32);
                assert_eq!(bits(own), bits(*found), "{name}, {pixel:?}: {own:?} for {found:?}");
                let Some(replay) = replay else {
                    count("dark".into());
                    continue;
                };
                if let Some(passage) = &replay.ray_path {
                    assert_eq!(passage.end.is_ok(), replay.ray.is_some(), "{name}, {pixel:?}");
                    count(
                        passage
                            .end
                            .as_ref()
                            .err()
                            .map_or("through".into(), |b| format!("{:?}", b.reason)),
                    );
                }
                for step in &replay.steps {
                    match step.record.outcome {
                        PathOutcome::Roulette { .. } => count("Roulette".into()),
                        fate => count(format!("{fate:?}")),
                    }
                    if let Some(shadow) = step.shadow {
                        count(format!("light arrives: {}", shadow.unoccluded));
                    }
                }
                assert_eq!(replay.first_non_finite(), None);
            }
        }
    }
    for fate in [
        "Clip",
        "Stop",
        "through",
        "Escapes",
        "Complete",
        "DepthLimit",
        "Roulette",
        "Continues",
        "light arrives: true",
        "light arrives: false",
        "dark",
    ] {
        assert!(fates.contains_key(fate), "{fate} of {fates:?}");
    }
}

#[test]
fn samples_add_up_to_the_picture() {
    for mut job in [thin(), job("atelier.pbrt", &all_options("-ghosts"))] {
        job.samples = 3..9;
        let picture = picture(&job, Backend::Simd);
        for (pixel, found) in pixels(&job).zip(&picture.pixels) {
            let mut sum = [0.0; 3];
            for sample in job.samples.clone() {
                let (value, _) = value(&job, Backend::Simd, pixel, sample);
                sum = [0, 1, 2].map(|c| sum[c] + value[c]);
            }
            for c in 0..3 {
                let mean = sum[c] / 6.0;
                // The sums in f64 have another order and are rounded to f32.
                let off = (mean - f64::from(found[c])).abs();
                assert!(off <= 1.2e-7 * mean.abs() + 1e-15, "{pixel:?}: {mean} for {found:?}");
            }
        }
    }
}

#[test]
fn the_contributions_of_all_steps_add_up_to_the_radiance() {
    let job = thin();
    for pixel in pixels(&job) {
        let (_, replay) = value(&job, Backend::Simd, pixel, 0);
        let replay = replay.expect("a pinhole sees everywhere");
        let mut so_far = [0.0f32; 3];
        for (i, step) in replay.steps.iter().enumerate() {
            for c in 0..3 {
                so_far[c] += step.emission[c];
                so_far[c] +=
                    step.shadow.filter(|s| s.unoccluded).map_or(0.0, |s| s.contribution[c]);
                let off = (so_far[c] - step.radiance[c]).abs();
                assert!(off <= 1e-6 * so_far[c].abs(), "{pixel:?}: {so_far:?} for {step:?}");
            }
            if let (Some((ray, carried, _)), Some(then)) = (step.next, replay.steps.get(i + 1)) {
                assert_eq!((ray, carried), (then.ray, then.throughput));
            }
        }
        assert_eq!(replay.steps.last().map(|step| step.radiance), Some(replay.radiance));
    }
}

#[test]
fn a_path_between_two_points_is_that_of_a_sample_through_them() {
    let tilted = Changes {
        film_tilt: Some([3.0, -2.0]),
        film_shift: Some([1.0, 2.0]),
        ..Changes::default()
    };
    for changes in [Changes::default(), tilted] {
        let job = job("dgauss.pbrt", &changes);
        let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
        assert_eq!(lens.bands.len(), 1, "the same wavelength");
        let (mut through, mut blocked) = (0, 0);
        for pixel in pixels(&job) {
            let replay = value(&job, Backend::Simd, pixel, 1).1;
            let Some((film, path)) = replay.and_then(|r| Some((r.film, r.ray_path?))) else {
                continue;
            };
            let (start, direction) = (path.start, path.direction);
            let steps = (lens.prescription.length() - start[2]) / direction[2];
            let rear = [0, 1].map(|i| start[i] + steps * direction[i]);
            let again = lens.path_between(film.map(f64::from), rear);
            assert_eq!(again.crossings.len(), path.crossings.len(), "{pixel:?}");
            let points = |path: &RayPath| -> Vec<[f64; 3]> {
                path.crossings.iter().filter_map(|crossing| crossing.point).collect()
            };
            for (one, other) in points(&again).iter().flatten().zip(points(&path).iter().flatten())
            {
                // The sample is traced in f32.
                assert!((one - other).abs() < 1e-3, "{pixel:?}: {one} and {other}");
            }
            match (&path.end, &again.end) {
                (Ok(_), Ok(_)) => through += 1,
                (Err(one), Err(other)) => {
                    assert_eq!(one, other, "{pixel:?}");
                    blocked += 1;
                }
                _ => panic!("{pixel:?}: {:?} and {:?}", path.end, again.end),
            }
        }
        assert!(through > 100 && blocked > 3, "{through} and {blocked}");
    }
}

#[test]
fn replayed_crossings_lie_on_spheres_and_obey_snells_law() {
    let job = job("dgauss.pbrt", &Changes::default());
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let (rows, vertices) = (&lens.prescription.rows, lens.prescription.vertex_positions());
    let minus = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let mut checked = 0;
    for pixel in pixels(&job) {
        let Some(passage) = value(&job, Backend::Simd, pixel, 1).1.and_then(|r| r.ray_path) else {
            continue;
        };
        let mut before = passage.start;
        // Normal of the last surface, its n sin(i), and the index behind it.
        let mut last: Option<([f64; 3], f64, f64)> = None;
        for crossing in &passage.crossings {
            let Some(at) = crossing.point else { continue };
            let row = &rows[crossing.row];
            let height = at[0].hypot(at[1]);
            let sag = row.sag(height);
            assert!((at[2] - vertices[crossing.row] - sag).abs() < 2e-5, "{pixel:?} {crossing:?}");
            assert!((height - crossing.height.expect("a height")).abs() < 1e-5);
            assert_eq!(
                crossing.transmittance.is_some(),
                height < crossing.semi_diameter,
                "{crossing:?}"
            );
            let way = minus(at, before);
            // The normal points from the surface to the centre of the sphere.
            let centre = [0.0, 0.0, vertices[crossing.row] + row.radius];
            let normal = if row.stop { [0.0, 0.0, 1.0] } else { minus(centre, at) };
            let cosine = dot(way, normal).abs() / (dot(way, way) * dot(normal, normal)).sqrt();
            let angle = cosine.min(1.0).acos().to_degrees();
            let found = crossing.incidence.expect("an angle");
            assert!((angle - found).abs() < 0.01, "{pixel:?}: {angle} for {crossing:?}");
            if let Some((normal, invariant, index)) = last {
                let cosine = dot(way, normal).powi(2) / (dot(way, way) * dot(normal, normal));
                let behind = index * (1.0 - cosine).max(0.0).sqrt();
                assert!((behind - invariant).abs() < 2e-4, "Snell: {behind} and {invariant}");
            }
            last = Some((normal, crossing.index[0] * found.to_radians().sin(), crossing.index[1]));
            before = at;
            checked += 1;
        }
    }
    assert!(checked > 1000, "{checked}");
}

#[test]
fn any_sample_can_be_replayed() {
    let job = job("dgauss.pbrt", &Changes { samples: Some(2), ..Changes::default() });
    assert!(value(&job, Backend::Simd, [12, 8], 1_000_000).1.is_some());
    assert!(replay(&job, Backend::Simd, SampleId::new([12, 8], u32::MAX, 7)).is_none());
}

#[test]
fn a_picture_and_a_replay_need_a_megabyte_of_stack() {
    let job = job("night.pbrt", &Changes { samples: Some(1), ..Changes::default() });
    let work = move || {
        render(&job, RenderOptions { threads: 1, ..RenderOptions::default() }).expect("a render");
        let sample = SampleId::new([12, 8], 0, job.seed);
        replay(&job, Backend::Simd, sample).expect("a lit pixel").steps.len()
    };
    let thread = std::thread::Builder::new().stack_size(1 << 20).spawn(work).expect("a thread");
    assert!(thread.join().expect("a path") > 0);
}
