//! Dispersion in pictures: white stays white, and colours are where theory predicts.

use crate::support::sampling::random_samples;
use crate::support::{Random, folder, mean, picture, root, write};
use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, SampleBatch};
use petzval_base::stats::LensStats;
use petzval_lens::{LensColumns, LensModel, Paraxial};
use petzval_render::job::Job;
use petzval_render::plan::{Effect, EffectSelection, OmissionError};
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Backend, RenderOptions, render};
use petzval_scene_formats::pbrt;
use petzval_spectrum::{Passband, bands};

/// A flint singlet of about 100 mm at f/20 with its stop on the front surface.
const SINGLET: &str =
    "[[surface]]\nradius = 120.0\nthickness = 2.0\ndiameter = 5.0\nglass = \"SF5\"
stop = true\n[[surface]]\nradius = -120.0\nthickness = 90.0\ndiameter = 20.0\n";

/// The singlet with its stop 30 mm in front, so that each field uses another part of it.
const STOP_BEFORE: &str = "[[surface]]\nstop = true\ndiameter = 5.0\nthickness = 30.0
[[surface]]\nradius = 120.0\nthickness = 2.0\ndiameter = 20.0\nglass = \"SF5\"
[[surface]]\nradius = -120.0\nthickness = 90.0\ndiameter = 20.0\n";

/// Prepares a render of a world, in metres, through a lens.
fn job(lens: &str, film: &str, world: &str, changes: &Changes) -> Job {
    let folder = folder();
    let file = match lens {
        "singlet" => write(&folder, "singlet.toml", SINGLET),
        "stop before" => write(&folder, "stop_before.toml", STOP_BEFORE),
        name => root().join("lenses").join(name),
    };
    let text = format!(
        "Film \"rgb\" {film} PixelFilter \"box\" Integrator \"path\" \"integer maxdepth\" 1
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 30
         \"float focusdistance\" 1000\nWorldBegin\n{world}",
        file.display()
    );
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    prepare(description, changes).expect("a job").job
}

fn dispersed(mut job: Job) -> Job {
    let LensModel::Real(lens) = &mut job.camera.model else { panic!() };
    lens.disperse(&bands());
    job
}

const SMALL: &str = "\"integer xresolution\" 24 \"integer yresolution\" 24 \"float diagonal\" 20";

#[test]
fn grey_stays_grey_through_glass_without_dispersion() {
    let world = "LightSource \"infinite\" \"rgb L\" [1 1 1] Material \"diffuse\"
        \"rgb reflectance\" [0.5 0.5 0.5] Translate 0 0 3 Shape \"sphere\" \"float radius\" 0.3";
    let changes = Changes { samples: Some(256), ..Changes::default() };
    let plain = job("dgauss.50mm.dat", SMALL, world, &changes);
    let [one, other] =
        [&plain, &dispersed(plain.clone())].map(|job| picture(job, Backend::Simd, 1));
    let [white, found] = [mean(&one), mean(&other)];
    for c in 0..3 {
        assert!((found[c] / white[c] - 1.0).abs() < 0.002, "{found:?} for {white:?}");
    }
    // 256 samples cover all bands equally and share their rays, so no pixel is coloured.
    for [r, g, b] in &other.pixels {
        assert!((r / g - 1.0).abs() < 0.03 && (b / g - 1.0).abs() < 0.03, "{r} {g} {b}");
    }
}

#[test]
fn the_blur_of_colours_follows_their_focal_lengths() {
    // A star on the axis, focused at the d line. Each wavelength gives a disc of diameter D |f - s| / f
    // behind a thin lens; each channel is the mean of its wavelengths.
    let world = "AreaLightSource \"diffuse\" \"rgb L\" [1e6 1e6 1e6] Translate 0 0 1000
        Shape \"sphere\" \"float radius\" 0.08";
    let size = 60.0;
    let film = format!(
        "\"integer xresolution\" {size} \"integer yresolution\" {size} \"float diagonal\" 0.42426"
    );
    let changes = Changes { samples: Some(4096), ..Changes::default() };
    let job = job("singlet", &film, world, &changes);
    assert!(job.plan.has(Effect::Dispersion), "{:?}", job.plan);
    let LensModel::Real(lens) = &job.camera.model else { panic!() };
    let file = &lens.prescription;
    let pupil = Paraxial::new(file).entrance_pupil.diameter;
    // The film is at the focus of the d line for all wavelengths.
    let mut expected = [0.0; 3];
    let mut weights = [0.0; 3];
    for band in bands() {
        let paraxial = Paraxial::new(&file.at_wavelength(band.wavelength).unwrap());
        // Distance of the image of the star behind the rear vertex.
        let f = paraxial.focal_length;
        let image = paraxial.back_focal_distance + f * f / (1e6 - f);
        let disc = pupil * (image - lens.film_distance).abs() / image;
        for c in 0..3 {
            expected[c] += band.response[c] * disc * disc / 8.0;
            weights[c] += band.response[c];
        }
    }
    let seen = picture(&job, Backend::Simd, 1);
    let pitch = 0.3 / size;
    let mut luminance = 0.0;
    for c in 0..3 {
        let (mut sum, mut moments) = (0.0, [0.0; 3]);
        for (i, pixel) in seen.pixels.iter().enumerate() {
            let [x, y] = [i % 60, i / 60].map(|p| p as f64 * pitch);
            let value = f64::from(pixel[c]);
            sum += value;
            moments[0] += value * x;
            moments[1] += value * y;
            moments[2] += value * (x * x + y * y);
        }
        let [x, y, square] = moments.map(|moment| moment / sum);
        // Without the disc of the star and the width of a pixel.
        let star = 8e-5 * Paraxial::new(file).focal_length;
        let found = square - x * x - y * y - pitch * pitch / 6.0 - star * star / 2.0;
        let expected = expected[c] / weights[c];
        println!(
            "channel {c}: {:.2} um, expected {:.2} um",
            1e3 * found.sqrt(),
            1e3 * expected.sqrt()
        );
        assert!((found.sqrt() / expected.sqrt() - 1.0).abs() < 0.06, "{found} and {expected}");
        luminance += [0.2126, 0.7152, 0.0722][c] * found;
    }
    // The plan estimates the blur of the point that the star is without dispersion.
    let row = job.plan.effects.iter().find(|row| row.effect == Effect::Dispersion);
    let Some(OmissionError::Blur { um, .. }) = row.expect("a row").error else {
        panic!("an estimate")
    };
    let found = 1e3 * luminance.sqrt();
    println!("{um:.1} um estimated, {found:.1} um found");
    assert!((um / found - 1.0).abs() < 0.2, "{um} estimated, {found} found");
}

#[test]
fn the_magnification_of_colours_follows_their_chief_rays() {
    // A bright disc 2 degrees off the axis, in pictures of blue and of red light.
    let tangent = 2f64.to_radians().tan();
    let world = format!(
        "AreaLightSource \"diffuse\" \"rgb L\" [1e6 1e6 1e6] Translate {} 0 1000
         Shape \"sphere\" \"float radius\" 1",
        1000.0 * tangent
    );
    let film = "\"integer xresolution\" 600 \"integer yresolution\" 600 \"float diagonal\" 12";
    let width = 12.0 / 2f64.sqrt();
    let seen = |range: [f64; 2]| {
        let changes = Changes {
            samples: Some(128),
            passband: Some(Passband { range }),
            effects: "+dispersion".parse().expect("effects"),
            crop: Some([[490, 270], [600, 330]]),
            ..Changes::default()
        };
        let job = job("stop before", film, &world, &changes);
        let picture = picture(&job, Backend::Simd, 1);
        let (mut sum, mut moment) = (0.0, 0.0);
        for (i, pixel) in picture.pixels.iter().enumerate() {
            assert_eq!(pixel[0], pixel[2], "a passband gives a grey picture");
            sum += f64::from(pixel[0]);
            moment += f64::from(pixel[0]) * ((i % 110) as f64 + 0.5 + 490.0 - 300.0);
        }
        let LensModel::Real(lens) = &job.camera.model else { panic!() };
        // The paraxial chief ray: y and n u from surface to surface.
        let row = &lens.prescription.rows[1];
        let n = row.glass.index(row.index, (range[0] + range[1]) / 2.0).unwrap();
        let (mut y, mut nu) = (30.0 * tangent, tangent);
        nu -= y * (n - 1.0) / 120.0;
        y += nu / n * 2.0;
        nu -= y * (n - 1.0) / 120.0;
        (moment / sum * width / 600.0, y + nu * lens.film_distance)
    };
    let (blue, red) = (seen([480.0, 492.0]), seen([650.0, 662.0]));
    let (found, expected) = (red.0 - blue.0, red.1 - blue.1);
    println!("{blue:?} {red:?}: {:.2} um, expected {:.2} um", 1e3 * found, 1e3 * expected);
    assert!(expected > 0.02 && (found / expected - 1.0).abs() < 0.03, "{found}, not {expected}");
}

/// Returns the share of the light that is found by samples outside the fan of the pupil, which weigh
/// at least 48 times as much as those inside.
fn light_outside_the_fan(job: &Job) -> f64 {
    let LensModel::Real(lens) = &job.camera.model else { panic!() };
    let mut random = Random::new(41);
    let (mut rays, mut columns) = (RayBatch::default(), LensColumns::default());
    let (mut outside, mut all) = (0.0, 0.0);
    for band in 0..lens.bands.len() {
        let mut weights = Vec::new();
        for _ in 0..200 {
            let samples = SampleBatch { band, ..random_samples(job.camera.film, &mut random) };
            let mut stats = LensStats::default();
            job.camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
            let weight = |i| rays.throughput.iter().map(|column| f64::from(column[i])).sum::<f64>();
            weights.extend((0..rays.len).map(weight));
        }
        weights.sort_by(f64::total_cmp);
        let usual = weights[weights.len() / 2];
        all += weights.iter().sum::<f64>();
        outside += weights.iter().filter(|&&weight| weight > 10.0 * usual).sum::<f64>();
    }
    outside / all
}

#[test]
fn a_white_sky_has_no_fireflies() {
    // The rim of the pupil differs by colour. If only the few rays outside the fan found its light,
    // pixels would be noisy.
    let world = "LightSource \"infinite\" \"rgb L\" [1 1 1]";
    let film = "\"integer xresolution\" 64 \"integer yresolution\" 64 \"float diagonal\" 10";
    let job = |effects: &str| {
        let effects = effects.parse().expect("effects");
        let changes = Changes { samples: Some(256), effects, ..Changes::default() };
        job("stop before", film, world, &changes)
    };
    let (held, missed) = (job("+dispersion,-ghosts"), dispersed(job("-dispersion,-ghosts")));
    assert!(held.plan.has(Effect::Dispersion));
    let off = |job: &Job| {
        let seen = picture(job, Backend::Simd, 1);
        let mean = mean(&seen);
        let off = |pixel: &[f32; 3]| {
            [0, 1, 2].map(|c| (f64::from(pixel[c]) / mean[c] - 1.0).abs()).into_iter()
        };
        seen.pixels.iter().flat_map(off).fold(0.0, f64::max)
    };
    let outside = [&held, &missed].map(light_outside_the_fan);
    let [held, missed] = [held, missed].map(|job| off(&job));
    println!("a pixel is off by {held:.3}, and by {missed:.3} with the pupil of one colour");
    println!("light outside the fan: {outside:?}");
    // The bounds of all colours enclose the light of each, and those of one colour do not.
    assert!(outside[0] < 1e-4 && outside[1] > 3e-3, "light outside the fan: {outside:?}");
    assert!(held < 0.3 && missed > (3.0 * held).max(0.5), "{held} and {missed}");
}

#[test]
fn bands_do_not_depend_on_threads_or_lanes() {
    let world = "LightSource \"infinite\" Translate 0.2 0 3 Shape \"sphere\" \"float radius\" 0.3";
    let changes = Changes { samples: Some(40), ..Changes::default() };
    let job = dispersed(job("triplet.toml", SMALL, world, &changes));
    let one = picture(&job, Backend::Simd, 1);
    assert_eq!(one.pixels, picture(&job, Backend::Simd, 3).pixels);
    assert_eq!(one.pixels, picture(&job, Backend::Scalar, 2).pixels);
    // Every sample is traced once.
    let taken =
        render(&job, RenderOptions { threads: 2, ..RenderOptions::default() }).expect("a picture");
    assert_eq!(taken.stats.stages[0].rays, 24 * 24 * 40);
}

#[test]
fn lens_file_and_command_line_decide_about_dispersion() {
    let of = |lens: &str, effects: &str| {
        let effects: EffectSelection = effects.parse().expect("a list of effects");
        let job = job(lens, SMALL, "", &Changes { effects, ..Changes::default() });
        let LensModel::Real(lens) = &job.camera.model else { panic!() };
        let bands = lens.bands.len();
        assert_eq!(job.plan.has(Effect::Dispersion), bands > 1, "plan and camera differ");
        bands > 1
    };
    // The course's lenses have no dispersion data, so the effect is off even if it is requested.
    assert!(!of("dgauss.50mm.dat", "auto") && !of("dgauss.50mm.dat", "all"));
    // At 24 pixels across 14 mm the colours of the triplet are invisible, so only a request turns it on.
    assert!(!of("triplet.toml", "auto") && of("triplet.toml", "+dispersion"));
    assert!(
        of("singlet", "+dispersion") && !of("singlet", "none") && !of("singlet", "-dispersion")
    );
    for (wrong, expected) in [
        ("dispersion", "\"dispersion\"; expected auto, all, none, or a list"),
        ("+dispersoin", "no effect \"dispersoin\"; expected one of dispersion, fresnel"),
    ] {
        let message = wrong.parse::<EffectSelection>().expect_err("no list of effects");
        assert!(message.contains(expected), "{message}");
    }
}
