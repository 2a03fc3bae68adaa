//! Hero wavelengths: bands of light that share rays give the picture of separate bands, with less
//! noise.

use crate::support::{Random, folder, mean, picture, root, write};
use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, ReprojectionBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;
use petzval_lens::{Coating, LensColumns, LensModel, RealLens};
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;
use petzval_spectrum::{LightBand, bands};

/// A flint singlet of about 100 mm focal length, with the stop 30 mm before it.
const SINGLET: &str = "[[surface]]\nstop = true\ndiameter = 5.0\nthickness = 30.0
[[surface]]\nradius = 120.0\nthickness = 2.0\ndiameter = 20.0\nglass = \"SF5\"
[[surface]]\nradius = -120.0\nthickness = 90.0\ndiameter = 20.0\n";

/// Tilt and decentre of the singlet's glass.
const TILTED: &str = "[[askew]]\nsurfaces = [2, 3]\ndecentre = [0.05, -0.03]\ntilt = [1.5, -2.0]\n";

const MITCHELL: &str = "\"mitchell\" \"float xradius\" 2 \"float yradius\" 2";

/// A white disc 2 degrees off the axis, an orange one beside it, and a dim sky.
const DISCS: &str = "LightSource \"infinite\" \"rgb L\" [.1 .1 .1]
    AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 1 1]
    Translate 34.9 0.8 1000 Shape \"sphere\" \"float radius\" 0.8 AttributeEnd
    AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 .5 .2]
    Translate 34.9 -0.8 1000 Shape \"sphere\" \"float radius\" 0.8 AttributeEnd";

/// Returns the job of a world seen through a lens on 12 mm film; the world's unit is the metre.
fn job(lens: &str, filter: &str, world: &str, changes: &Changes) -> Job {
    let folder = folder();
    let file = match lens.ends_with(".toml") {
        true => root().join("lenses").join(lens),
        false => write(&folder, "test.toml", lens),
    };
    let text = format!(
        "Film \"rgb\" \"float diagonal\" 12 PixelFilter {filter}
         Integrator \"path\" \"integer maxdepth\" 0
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 30
         \"float focusdistance\" 1000\nWorldBegin\n{world}",
        file.display()
    );
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    let effects = "-dispersion,-ghosts,-diffraction".parse().expect("effects");
    prepare(description, &Changes { effects, ..changes.clone() }).expect("a job").job
}

fn lens(job: &mut Job) -> &mut RealLens {
    let LensModel::Real(lens) = &mut job.camera.model else { panic!("a real lens") };
    lens
}

/// Returns the job with its light in these bands.
fn in_bands(job: &Job, bands: &[LightBand]) -> Job {
    let mut job = job.clone();
    lens(&mut job).disperse(bands);
    lens(&mut job).bound_all_bands();
    job
}

/// Returns the mean of the pictures that each band makes alone.
fn band_by_band(job: &Job) -> Vec<[f64; 3]> {
    let mut sums = Vec::new();
    let mut one = job.clone();
    for band in lens(&mut job.clone()).bands.drain(..) {
        lens(&mut one).bands = vec![band];
        let picture = picture(&one, Backend::Simd, 1);
        sums.resize(picture.pixels.len(), [0.0; 3]);
        for (sum, pixel) in sums.iter_mut().zip(&picture.pixels) {
            *sum = [0, 1, 2].map(|c| sum[c] + f64::from(pixel[c]) / 32.0);
        }
    }
    sums
}

/// Returns the means of five vertical strips of the picture, from left to right.
fn parts(pixels: &[[f64; 3]], width: usize) -> [[f64; 3]; 5] {
    let mut means = [[0.0; 3]; 5];
    for (i, pixel) in pixels.iter().enumerate() {
        let sum = &mut means[i % width * 5 / width];
        *sum = [0, 1, 2].map(|c| sum[c] + 5.0 * pixel[c] / pixels.len() as f64);
    }
    means
}

/// Checks that bands that share rays make the same picture as separate bands.
fn assert_shared_equals_separate(lens: &str, filter: &str, changes: &Changes) {
    let mut shared = in_bands(&job(lens, filter, DISCS, changes), &bands());
    let [width, height] = shared.frame.size();
    shared.samples = 0..3_000_000 / (width * height);
    let few = Job { samples: 0..100_000 / (width * height), ..shared.clone() };
    let width = width as usize;
    let found = picture(&shared, Backend::Simd, 1);
    let found: Vec<[f64; 3]> = found.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
    let [found, expected] = [found, band_by_band(&few)].map(|pixels| parts(&pixels, width));
    let most = expected.iter().flatten().fold(0.0, |a: f64, &b| a.max(b));
    let mut off = 0.0f64;
    let mut fringe = 0.0f64;
    for (found, expected) in found.iter().zip(&expected) {
        fringe = fringe.max((expected[0] / expected[1] - expected[2] / expected[1]).abs());
        for c in 0..3 {
            off = off.max((found[c] - expected[c]).abs() / most);
        }
    }
    println!("{:.3} % off, a fringe of {fringe:.2}", 100.0 * off);
    assert!(fringe > 0.2, "the picture has coloured fringes: {fringe}");
    assert!(off < 0.01, "{off}: {found:?}, not {expected:?}");
}

/// Pictures with pixels of 14 um and 56 um. The singlet disperses colours by more than the former,
/// and by less than the latter.
fn sizes() -> [Changes; 2] {
    let of = |resolution, crop| Changes {
        resolution: Some([resolution; 2]),
        crop: Some(crop),
        ..Changes::default()
    };
    [of(600, [[524, 285], [569, 315]]), of(150, [[128, 67], [146, 83]])]
}

#[test]
fn shared_bands_have_the_colours_of_separate_bands() {
    for changes in sizes() {
        assert_shared_equals_separate(SINGLET, "\"box\"", &changes);
    }
}

#[test]
fn signed_filters_and_coatings_keep_the_colours() {
    for changes in sizes() {
        let coated = Changes { coating: Some(Coating::Mgf2), ..changes };
        assert_shared_equals_separate(SINGLET, MITCHELL, &coated);
    }
}

#[test]
fn tilted_film_and_elements_keep_the_colours() {
    for changes in sizes() {
        let posed = Changes { film_tilt: Some([4.0, -3.0]), ..changes };
        assert_shared_equals_separate(&format!("{TILTED}{SINGLET}"), "\"gaussian\"", &posed);
    }
}

#[test]
fn reprojection_into_the_same_band_returns_to_the_film_point() {
    let tilted = Changes {
        film_tilt: Some([4.0, -3.0]),
        film_shift: Some([1.0, 0.5]),
        ..Changes::default()
    };
    let bladed = SINGLET.replace("stop = true", "stop = true\nblades = 5");
    let cases = [
        (SINGLET.to_owned(), Changes::default()),
        (bladed, Changes { coating: Some(Coating::Mgf2), ..Changes::default() }),
        (format!("{TILTED}{SINGLET}"), tilted),
        ("triplet.toml".to_owned(), Changes::default()),
    ];
    for (file, changes) in cases {
        let mut job = in_bands(&job(&file, "\"box\"", "", &changes), &bands());
        lens(&mut job).fresnel = changes.coating.is_some();
        let mut random = Random::new(3);
        let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
        for i in 0..WAVE_SIZE {
            for axis in 0..2 {
                samples.film[axis][i] = (random.between(-0.5, 0.5) * job.camera.film[axis]) as f32;
                samples.pupil[axis][i] = random.next() as f32;
            }
        }
        for band in [0, 17, 31] {
            samples.band = band;
            let (mut columns, mut rays) = (LensColumns::default(), RayBatch::default());
            let mut stats = LensStats::default();
            job.camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
            let (mut back, mut own) = (ReprojectionBatch::default(), ReprojectionBatch::default());
            columns.passed(WAVE_SIZE, &mut own.transmission);
            job.camera.reproject::<f32x8>(band, &mut columns, &mut back);
            assert!(rays.len > WAVE_SIZE / 2, "{}", rays.len);
            let mut lost = 0;
            for &slot in &rays.slot[..rays.len] {
                let i = slot as usize;
                // A ray along a rim may be blocked there on its way back.
                if back.transmission[i] == 0.0 {
                    lost += 1;
                    continue;
                }
                let off = (back.transmission[i] / own.transmission[i] - 1.0).abs();
                assert!(off < 1e-4, "{} of {}", back.transmission[i], own.transmission[i]);
                for axis in 0..2 {
                    let off = (back.film[axis][i] - samples.film[axis][i]).abs();
                    assert!(off < 2e-4, "sample {i} returns {off} mm off");
                }
            }
            assert!(lost <= 2, "{lost} of {}", rays.len);
        }
    }
}

/// Returns the variance of red - green plus that of blue - green, with each channel's mean as 1.
fn chroma(job: &Job) -> f64 {
    let picture = picture(job, Backend::Simd, 1);
    let all = mean(&picture);
    let mut sum = 0.0;
    for pixel in &picture.pixels {
        let [r, g, b] = [0, 1, 2].map(|c| f64::from(pixel[c]) / all[c]);
        sum += (r - g).powi(2) + (b - g).powi(2);
    }
    sum / picture.pixels.len() as f64
}

#[test]
fn few_samples_have_little_chroma_noise() {
    let world = "LightSource \"infinite\" \"rgb L\" [1 1 1]";
    let changes = Changes { resolution: Some([32; 2]), ..Changes::default() };
    let plain = job("triplet.toml", "\"box\"", world, &changes);
    let shared = in_bands(&plain, &bands());
    // Thirty bands are no multiple of four, so they share no rays.
    let alone = in_bands(&plain, &bands()[1..31]);
    for (samples, least) in [(4, 15.0), (8, 8.0), (16, 3.0)] {
        let [shared, alone] =
            [&shared, &alone].map(|job| chroma(&Job { samples: 0..samples, ..job.clone() }));
        println!("{samples} samples: {shared:.2e}, alone {alone:.2e}, {:.0} times", alone / shared);
        assert!(alone / shared > least, "{shared} and {alone}");
    }
}

#[test]
fn white_has_the_brightness_of_separate_bands() {
    let world = "LightSource \"infinite\" \"rgb L\" [1 1 1]";
    let changes = Changes { resolution: Some([32; 2]), samples: Some(64), ..Changes::default() };
    for filter in ["\"box\"", MITCHELL] {
        let plain = job("triplet.toml", filter, world, &changes);
        let shared = in_bands(&plain, &bands());
        let alone = band_by_band(&shared);
        let found = mean(&picture(&shared, Backend::Simd, 1));
        for c in 0..3 {
            let sum: f64 = alone.iter().map(|pixel| pixel[c]).sum();
            let off = found[c] * alone.len() as f64 / sum - 1.0;
            println!("channel {c}: {off:.2e} off");
            assert!(off.abs() < 0.003, "channel {c}: {off}");
        }
    }
}

#[test]
fn one_lane_and_eight_give_the_same_picture() {
    let [_, changes] = sizes();
    let changes = Changes {
        samples: Some(40),
        film_tilt: Some([4.0, -3.0]),
        coating: Some(Coating::Mgf2),
        ..changes
    };
    let lens = format!("{TILTED}{SINGLET}");
    let job = in_bands(&job(&lens, MITCHELL, DISCS, &changes), &bands());
    let eight = picture(&job, Backend::Simd, 2);
    assert_eq!(eight.pixels, picture(&job, Backend::Scalar, 1).pixels, "bit for bit");
}
