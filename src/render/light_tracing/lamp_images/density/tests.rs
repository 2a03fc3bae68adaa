//! Tests of the densities and weights of lamp images.

use std::fs::File;
use std::path::Path;

use glam::{DAffine3, DVec3};

use super::*;
use crate::job::Job;
use crate::light_tracing::lamp_images::LampColumns;
use crate::light_tracing::light_paths::{CameraPose, LightPath, sample_film};
use crate::prepare::{Changes, prepare};
use crate::timing::{ArrivalTime, TimingEffects};
use crate::{DisperseColumns, disperse};
use petzval_base::lanes::f32x8;
use petzval_base::rays::{HitBatch, NO_INDEX, Ray, SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, pixel_key, sample_2d};
use petzval_base::stats::LensStats;
use petzval_image::write_pfm;
use petzval_lens::LensColumns;
use petzval_scene::TraversalStack;
use petzval_scene::motion::Motion;
use petzval_scene::shutter::{ReadoutDirection, RollingShutter, Shutter};
use petzval_scene_formats::pbrt;

fn night(effects: &str) -> Job {
    cropped_night(effects, None)
}

fn cropped_night(effects: &str, crop: Option<[[u32; 2]; 2]>) -> Job {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/night.pbrt");
    let changes = Changes {
        effects: effects.parse().expect("effects"),
        light_paths: Some(true),
        assume_vd: true,
        resolution: Some([90, 60]),
        crop,
        ..Changes::default()
    };
    prepare(pbrt::read(&path).expect("a scene"), &changes).expect("a job").job
}

/// A sky with a sun in view, and a lamp before it.
fn sunny(effects: &str) -> Job {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let sky = File::create(path("sky.pfm")).expect("a file");
    let sun = |i: usize| if i == 126 * 256 + 131 { [9e4, 8e4, 7e4] } else { [0.1, 0.2, 0.3] };
    write_pfm([256; 2], sun, sky).expect("a sky");
    let lens = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lenses/dgauss.50mm.dat");
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32 "float diagonal" 22
           Camera "realistic" "string lensfile" "{}" "float focusdistance" 2
           WorldBegin LightSource "infinite" "string filename" "sky.pfm"
           AreaLightSource "diffuse" "rgb L" [500 400 200] Translate 0.3 0.2 6
           Shape "sphere" "float radius" 0.04"#,
        lens.display()
    );
    std::fs::write(path("sky.pbrt"), text).expect("a scene");
    let changes = Changes {
        effects: effects.parse().expect("effects"),
        light_paths: Some(true),
        ..Changes::default()
    };
    let job = prepare(pbrt::read(&path("sky.pbrt")).expect("a scene"), &changes);
    let job = job.expect("a job").job;
    assert_eq!(job.plan.light_paths.reason.split(';').next(), Some("one lamp and a sky in view"));
    job
}

/// Calls `check` with the index, the time and the find of every ray of a wave that finds a lamp or a sky
/// with an image.
fn for_lamps(
    job: &Job,
    (rays, times): (&RayBatch, &[f32]),
    mut check: impl FnMut(usize, f32, LightSource),
) {
    let (mut hits, mut stack) = (Box::<HitBatch>::default(), TraversalStack::default());
    job.scene.intersect::<f32x8>(rays, &mut hits, &mut stack);
    for i in 0..rays.len {
        let (hit, ray) = (&hits[i], rays.ray(i));
        let mut found = |source| check(i, times[rays.slot[i] as usize], source);
        if hit.shape == NO_INDEX {
            job.scene.lights.sampled_skies().for_each(|sky| found(LightSource::Sky(sky)));
        } else if job.scene.shapes[hit.shape as usize].light != NO_INDEX {
            found(LightSource::Shape(hit, &job.scene.surface(&ray, hit).1));
        }
    }
}

#[test]
fn weights_of_camera_path_and_light_path_add_up_to_one() {
    check_weights(&night("+iris,+fresnel,-ghosts,-diffraction,-dispersion"));
    check_weights(&sunny("none"));
}

#[test]
fn weights_add_up_to_one_for_every_hero() {
    for (spectra, bands) in [("-", 32), ("+", 192)] {
        let effects = format!("{spectra}spectra,+iris,+fresnel,+dispersion,-ghosts,-diffraction");
        let job = night(&effects);
        assert_eq!(job.camera.bands(), bands);
        check_weights(&job);
    }
}

#[test]
fn weights_add_up_to_one_while_the_camera_moves_and_rows_are_read() {
    let mut job = night("+iris,+fresnel,-dispersion,-ghosts,-diffraction");
    let rolling = RollingShutter { time: 3.0, direction: ReadoutDirection::Up };
    let shutter = Shutter { rolling: Some(rolling), ..Shutter::default() };
    let timing = Timing::new(&shutter, [0.0, 4.0], TimingEffects::ALL);
    let mut timing = timing.expect("a sound shutter");
    let end =
        DAffine3::from_translation(DVec3::new(0.3, 0.1, 0.2)) * DAffine3::from_rotation_y(0.02);
    timing.camera_motion = Motion::between([DAffine3::IDENTITY, end]);
    job.timing = Some(timing);
    check_weights(&job);
}

/// Compares the weight of every camera ray with that of the light path along it, in the band of its
/// hero.
fn check_weights(job: &Job) {
    let LensModel::Real(lens) = &job.camera.model else { panic!("a lens") };
    let weights = job.lamp_image_weights().expect("lamps");
    let lamps = weights.lamp_images;
    let (mut columns, mut paths) = (Box::<LensColumns>::default(), LampColumns::default());
    let (mut rays, mut stats) = (Box::<RayBatch>::default(), LensStats::default());
    let mut samples = Box::<SampleBatch>::default();
    let mut dispersed = DisperseColumns::default();
    let (mut compared, mut shared) = (0, 0);
    let key = pixel_key(0, 0, 0);
    for wave in 0..64 {
        sample_film(&job.camera, key, wave, &mut samples);
        samples.band = wave as usize % job.camera.bands();
        job.camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        disperse::<f32x8>(job, &samples, &mut columns, &mut dispersed, &mut rays);
        columns.write_densities(&mut rays);
        if let Some(timing) = &job.timing {
            for i in 0..samples.len {
                let u = sample_2d(key, samples.sample[i], Dimension::Time)[0];
                samples.time[i] = timing.arrival_time(u).scene;
            }
            let motion = timing.camera_motion.as_ref().expect("a moving camera");
            motion.transform_rays(&samples.time, &mut rays);
        }
        let mut expected = Vec::new();
        paths.paths.clear();
        for_lamps(job, (&rays, &samples.time[..]), |i, time, source| {
            let density = weights.light_path_density(&job.scene, &rays.ray(i), time, source);
            let Some(density) = density else { return };
            let Ray { origin, direction, .. } = rays.ray(i);
            let (at_front, towards) = CameraPose::at(&job.camera, job.timing.as_ref(), time)
                .crossing(lens, origin.into(), direction.into())
                .expect("a ray from the lens");
            let start = lamps.front.start(at_front, towards);
            let shadow = Ray { origin: [0.0; 3], direction: [0.0, 0.0, 1.0], t_max: 1.0 };
            let arrival = ArrivalTime::default();
            let path = LightPath { start, towards, shadow, time: arrival, sample: [0; 2] };
            paths.paths.push(&path, [1.0; 3], [0.5; 2]);
            expected.push((density, weights.camera_weight(&job.scene, &rays, i, time, source)));
        });
        lamps.front.trace::<f32x8>(lens, samples.band, &mut paths.paths);
        for (i, (density, camera)) in expected.into_iter().enumerate() {
            // Rounding may block a ray at the rim of an element in one direction only.
            let Some(hit) = paths.paths.film_hit(i) else { continue };
            let sum = camera + weights.light_weight(lens, density, &hit);
            assert!((sum - 1.0).abs() < 1e-4, "{camera} of {sum} at {:?}", hit.point);
            compared += 1;
            shared += i32::from((0.01..0.99).contains(&camera));
        }
    }
    assert!(compared > 500 && shared > 50, "{compared}, {shared}");
}

#[test]
fn the_density_of_a_light_path_is_that_of_its_sample() {
    check_densities(&night("+iris,+fresnel,-ghosts,-diffraction"));
    check_densities(&sunny("none"));
}

fn check_densities(job: &Job) {
    let input = job.light_path_input();
    let LensModel::Real(lens) = &job.camera.model else { panic!("a lens") };
    let weights = job.lamp_image_weights().expect("lamps");
    let (mut columns, mut rays) = (LampColumns::default(), Box::<RayBatch>::default());
    let mut compared = 0;
    for wave in 0..4 {
        weights.lamp_images.sample(&input, lens, &mut columns, pixel_key(7, 0, 0), wave);
        rays.len = 0;
        for i in 0..columns.paths.len() {
            let ray = Ray { t_max: f32::INFINITY, ..columns.paths.shadow_ray(i) };
            rays.push(ray, [1.0; 3], i as u32);
        }
        for_lamps(job, (&rays, &[0.0; WAVE_SIZE]), |i, time, source| {
            let density = weights.light_path_density(&job.scene, &rays.ray(i), time, source);
            let ratio = density.unwrap_or(0.0) / columns.densities[i];
            // Another lamp may be before the one that was sampled.
            if (0.5..2.0).contains(&ratio) {
                assert!((ratio - 1.0).abs() < 1e-2, "{ratio}");
                compared += 1;
            }
        });
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn a_crop_traces_only_the_light_paths_that_can_reach_it() {
    /// Returns the number of light paths, and where they arrive (pixels).
    fn trace(crop: Option<[[u32; 2]; 2]>) -> (usize, Vec<[f64; 2]>) {
        let job = cropped_night("+iris,+fresnel,-ghosts,-diffraction", crop);
        let input = job.light_path_input();
        let LensModel::Real(lens) = &job.camera.model else { panic!("a lens") };
        let lamps = job.lamp_image_weights().expect("lamps").lamp_images;
        let mut columns = LampColumns::default();
        let (mut traced, mut arrivals) = (0, Vec::new());
        for wave in 0..8 {
            lamps.sample(&input, lens, &mut columns, pixel_key(7, 0, 0), wave);
            lamps.front.trace::<f32x8>(lens, 0, &mut columns.paths);
            traced += columns.paths.len();
            let hits = (0..columns.paths.len()).filter_map(|i| columns.paths.film_hit(i));
            arrivals.extend(hits.map(|hit| input.film_map().pixel(hit.point)));
        }
        (traced, arrivals)
    }
    let (all, arrivals) = trace(None);
    let inside = |[x, y]: &[f64; 2]| (4.0..82.0).contains(x) && (4.0..52.0).contains(y);
    let of_picture: Vec<[f64; 2]> = arrivals.iter().copied().filter(inside).collect();
    let low = of_picture[of_picture.len() / 2].map(|x| x as u32 - 4);
    let high = low.map(|x| x + 8);
    let in_crop =
        |at: &&[f64; 2]| (0..2).all(|i| (f64::from(low[i])..f64::from(high[i])).contains(&at[i]));
    let arrive: Vec<&[f64; 2]> = arrivals.iter().filter(in_crop).collect();
    let (few, of_few) = trace(Some([low, high]));
    println!("{} of {all} paths arrive; {few} of them are traced", arrive.len());
    assert!(arrive.len() > 50, "{}", arrive.len());
    assert_eq!(arrive, of_few.iter().filter(in_crop).collect::<Vec<_>>());
    assert!(few < all / 2, "{few} of {all}");
}

#[test]
fn camera_paths_take_the_light_that_a_crop_traces_no_light_path_for() {
    let job = cropped_night("+iris,+fresnel,-ghosts,-diffraction", Some([[0, 0], [9, 9]]));
    let weights = job.lamp_image_weights().expect("lamps");
    let (mut columns, mut rays) = (Box::<LensColumns>::default(), Box::<RayBatch>::default());
    let (mut samples, mut stats) = (Box::<SampleBatch>::default(), LensStats::default());
    let mut alone = 0;
    for wave in 0..16 {
        sample_film(&job.camera, pixel_key(0, 0, 0), wave, &mut samples);
        job.camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        for_lamps(&job, (&rays, &samples.time[..]), |i, time, source| {
            let density = weights.light_path_density(&job.scene, &rays.ray(i), time, source);
            let weight = weights.camera_weight(&job.scene, &rays, i, time, source);
            let is_alone = density.is_none();
            assert_eq!(is_alone, weight == 1.0, "{weight}");
            alone += i32::from(is_alone);
        });
    }
    assert!(alone > 100, "{alone}");
}
