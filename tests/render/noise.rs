//! Adaptive renders that stop at a noise level: they reach it, without bias, with fewer samples.

use std::path::Path;
use std::process::{Command, Output};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::support::reference::by_tier;
use crate::support::{folder, promptly, root, write};
use petzval_image::Picture;
use petzval_render::aov::Aov;
use petzval_render::job::{Job, StopCriteria};
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Backend, RenderOptions, RenderOutput, render};
use petzval_scene::luminance;
use petzval_scene_formats::pbrt;

/// A room with an area light, a diffuse ball and a metal ball.
const ROOM: &str = r#"
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [20 18 15]
        Shape "trianglemesh" "point3 P" [-0.5 1.9 4  0.5 1.9 4  0.5 1.9 5  -0.5 1.9 5]
            "integer indices" [0 1 2 0 2 3]
    AttributeEnd
    LightSource "infinite" "rgb L" [0.2 0.25 0.3]
    Material "diffuse" "rgb reflectance" [0.7 0.6 0.5]
    Shape "trianglemesh" "point3 P" [-3 -1 1  -3 -1 9  3 -1 9  3 -1 1] "integer indices" [0 1 2 0 2 3]
    Shape "trianglemesh" "point3 P" [-3 -1 7  -3 3 7  3 3 7  3 -1 7] "integer indices" [0 1 2 0 2 3]
    Material "diffuse" AttributeBegin Translate -0.7 -0.4 4 Shape "sphere" "float radius" 0.6 AttributeEnd
    Material "conductor" "float roughness" 0.3
    AttributeBegin Translate 0.8 -0.4 5 Shape "sphere" "float radius" 0.6 AttributeEnd"#;

/// A sky, and balls in the lower left corner, lit by a ball of light above them.
const CORNER: &str = r#"
    LightSource "infinite" "rgb L" [0.5 0.5 0.5]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [60 60 60]
        Translate -1.2 2.5 3 Shape "sphere" "float radius" 0.4
    AttributeEnd
    Material "diffuse" "rgb reflectance" [0.8 0.5 0.5]
    AttributeBegin Translate -1.35 0 3.6 Shape "sphere" "float radius" 0.3 AttributeEnd
    AttributeBegin Translate -1.35 -1.1 4 Shape "sphere" "float radius" 0.6 AttributeEnd"#;

fn job(world: &str, changes: &Changes) -> Job {
    let text = format!(
        "Film \"rgb\" \"integer xresolution\" 48 \"integer yresolution\" 48
         PixelFilter \"box\" Integrator \"path\" \"integer maxdepth\" 5
         Camera \"perspective\" \"float fov\" 50\nWorldBegin\n{world}"
    );
    let folder = folder();
    let description = pbrt::read(&write(&folder, "scene.pbrt", text)).expect("a scene of a test");
    prepare(description, changes).expect("a job").job
}

/// Returns options that stop at this noise.
fn until(noise: f64) -> Changes {
    Changes { stop_criteria: StopCriteria { noise: Some(noise), time: None }, ..Changes::default() }
}

fn expose(job: &Job) -> RenderOutput {
    render(job, RenderOptions { threads: 1, ..RenderOptions::default() })
        .expect("a render that is not stopped")
}

/// Renders a picture with the same number of samples in every pixel.
fn uniform_picture(world: &str, samples: u32, seed: u32) -> Picture {
    let changes = Changes { samples: Some(samples), seed: Some(seed), ..Changes::default() };
    let job = job(world, &changes);
    expose(&job).picture(&job)
}

fn light(picture: &Picture) -> Vec<f64> {
    picture.pixels.iter().map(|&pixel| f64::from(luminance(pixel))).collect()
}

/// Returns the mean squared error relative to the reference plus a tenth of its mean.
fn square_error(picture: &Picture, reference: &[f64]) -> f64 {
    let count = reference.len() as f64;
    let floor = 0.1 * reference.iter().sum::<f64>() / count;
    let error = |(a, b): (f64, &f64)| ((a - b) / (b + floor)).powi(2);
    light(picture).into_iter().zip(reference).map(error).sum::<f64>() / count
}

/// Renders references of [`ROOM`] and [`CORNER`], once for all tests: each is the mean of two pictures, with
/// an estimate of its own mean squared error.
fn reference(world: &str) -> &'static (Vec<f64>, f64) {
    static REFERENCES: [OnceLock<(Vec<f64>, f64)>; 2] = [const { OnceLock::new() }; 2];
    let index = [ROOM, CORNER].iter().position(|known| *known == world).expect("a known world");
    REFERENCES[index].get_or_init(|| {
        let [one, other] = [1001, 1002].map(|seed| uniform_picture(world, 4096, seed));
        let own = square_error(&one, &light(&other)) / 4.0;
        let mean = light(&one).iter().zip(light(&other)).map(|(a, b)| (a + b) / 2.0).collect();
        (mean, own)
    })
}

#[test]
fn the_error_equals_the_requested_noise() {
    // No sample may influence how many follow it in its half of the picture, so a render that met bright
    // rare light ends above the requested noise: the fewer samples it takes, the farther.
    let cases = [(ROOM, 0.02, 0.25), (CORNER, 0.004, 0.15), (ROOM, 0.012, 0.15)];
    for &(world, asked, spread) in by_tier(&cases[..2], &cases[..]) {
        let (reference, own) = reference(world);
        let job = job(world, &until(asked));
        let (mut errors, mut estimate, seeds) = (0.0, 0.0, 20);
        for seed in 0..seeds {
            let job = Job { seed, ..job.clone() };
            let exposed = expose(&job);
            let reached = exposed.convergence.expect("a convergence");
            let error = square_error(&exposed.picture(&job), reference) - own;
            println!("{seed}: {:.4} {reached:?}", error.sqrt());
            assert!((reached.noise / asked - 1.0).abs() < spread, "{seed}: {reached:?}");
            errors += error / f64::from(seeds);
            estimate += reached.noise.powi(2) / f64::from(seeds);
        }
        let [error, estimate] = [errors, estimate].map(f64::sqrt);
        println!("error {error}, estimated {estimate}; error of the reference {}", own.sqrt());
        assert!((error / asked - 1.0).abs() < 0.15, "{error} where {asked} was requested");
        assert!((error / estimate - 1.0).abs() < 0.1, "{error} where {estimate} was estimated");
    }
}

#[test]
fn the_mean_of_many_adaptive_pictures_is_unbiased() {
    let (reference, _) = reference(CORNER);
    let expected = reference.iter().sum::<f64>() / reference.len() as f64;
    let job = job(CORNER, &until(0.005));
    let runs = 64;
    let (mut means, mut most) = (Vec::new(), 0);
    let mut all = vec![0.0; reference.len()];
    let mut squares = vec![0.0; reference.len()];
    for seed in 0..runs {
        let job = Job { seed, ..job.clone() };
        let exposed = expose(&job);
        most = most.max(exposed.convergence.map_or(0, |reached| reached.max_spp));
        let picture = light(&exposed.picture(&job));
        means.push(picture.iter().sum::<f64>() / reference.len() as f64);
        for (i, light) in picture.into_iter().enumerate() {
            all[i] += light;
            squares[i] += light * light;
        }
    }
    let n = f64::from(runs);
    let mean = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let deviations = (mean - expected) / (variance / n).sqrt();
    println!("{mean} {expected}: {deviations} standard errors");
    assert!(deviations.abs() < 5.0, "{mean} is {deviations} standard errors from {expected}");
    // The mean of the squared standardised deviations of pixels is 1, and slightly more for Student's
    // distribution of 63 degrees of freedom and for the error of the reference.
    let own = n * f64::from(most) / 8192.0;
    let (mut sum, mut noisy) = (0.0, 0.0);
    for (i, expected) in reference.iter().enumerate() {
        let mean = all[i] / n;
        let variance = (squares[i] / n - mean * mean) / (n - 1.0);
        if variance > 1e-12 {
            sum += (mean - expected).powi(2) / variance;
            noisy += 1.0;
        }
    }
    println!("{noisy} pixels: {}", sum / noisy);
    assert!(noisy > 100.0 && (sum / noisy) < (1.0 + own) * (1.1 + 6.0 * (2.0f64 / noisy).sqrt()));
}

/// Few samples carry much of the light of some pixels. A render that stops when they happen to be missing
/// is too dark.
#[test]
fn rare_light_is_not_lost() {
    let glass = ROOM
        .replace("Material \"diffuse\" AttributeBegin", "Material \"dielectric\" AttributeBegin");
    let mean = |job: &Job, exposed: &RenderOutput| {
        let light = light(&exposed.picture(job));
        light.iter().sum::<f64>() / light.len() as f64
    };
    let resolution = Some([24, 24]);
    let uniform =
        Changes { resolution, samples: Some(8192), seed: Some(1001), ..Changes::default() };
    let uniform = self::job(&glass, &uniform);
    let job = self::job(&glass, &Changes { resolution, ..until(0.08) });
    let runs = 150;
    let mut sums = [0.0; 2];
    let mut samples = 0.0;
    for seed in 0..runs {
        let job = Job { seed, ..job.clone() };
        let exposed = expose(&job);
        let light = mean(&job, &exposed);
        samples += exposed.convergence.map_or(0.0, |reached| reached.mean_spp) / f64::from(runs);
        sums = [sums[0] + light, sums[1] + light * light];
    }
    let n = f64::from(runs);
    let found = sums[0] / n;
    let variance = (sums[1] / n - found * found) / (n - 1.0);
    // The variance of the reference is smaller by its number of samples.
    let count = uniform.samples.end;
    let expected = mean(&uniform, &expose(&uniform));
    let variance = variance * (1.0 + n * samples / f64::from(count));
    let deviations = (found - expected) / variance.sqrt();
    println!("{samples} samples: {found} {expected}: {deviations} standard errors");
    assert!(deviations.abs() < 5.0, "{found} is {deviations} standard errors from {expected}");
}

#[test]
fn samples_go_where_they_are_needed() {
    let (reference, _) = reference(CORNER);
    let job = job(CORNER, &until(0.003));
    let (mut adaptive, mut uniform, mut ratio) = (0.0, 0.0, 0.0);
    for seed in 0..4 {
        let job = Job { seed, ..job.clone() };
        let exposed = expose(&job);
        let reached = exposed.convergence.expect("a convergence");
        let samples = (reached.mean_spp / 0.7) as u32;
        adaptive += square_error(&exposed.picture(&job), reference);
        let error = square_error(&uniform_picture(CORNER, samples, seed), reference);
        uniform += error;
        ratio += 0.7 * square_error(&exposed.picture(&job), reference) / error / 4.0;
        assert!(reached.max_spp > 3 * reached.min_spp, "{reached:?}");
    }
    println!("samples for the same error: {ratio:.2} of those of a uniform picture");
    assert!(adaptive < uniform, "{adaptive} and {uniform} for 1 / 0.7 of the samples");
}

/// A light of two thousandths of a pixel is found by chance. The estimate of the noise must then learn how
/// small it is.
#[test]
fn a_tiny_light_does_not_keep_the_render_from_stopping() {
    let world = r#"
        LightSource "infinite" "rgb L" [0.5 0.5 0.5]
        AttributeBegin
            AreaLightSource "diffuse" "rgb L" [5e3 5e3 5e3]
            Translate 0.31 0.52 4 Shape "sphere" "float radius" 0.004
        AttributeEnd"#;
    let job = job(world, &until(0.05));
    let mut met = 0;
    for seed in 0..80 {
        let job = Job { seed, ..job.clone() };
        let reached = expose(&job).convergence.expect("a convergence");
        println!("{seed}: {reached:?}");
        met += u32::from(reached.max_spp > 1000);
        assert!(reached.mean_spp < 4000.0, "{seed}: {reached:?}");
    }
    assert!(met > 0, "no sample hits the light");
}

#[test]
fn threads_and_lanes_do_not_change_when_a_render_stops() {
    let job = job(ROOM, &until(0.15));
    let picture = |backend, threads| {
        let exposed = render(&job, RenderOptions { backend, threads, ..RenderOptions::default() })
            .expect("a render");
        (exposed.picture(&job), exposed.convergence)
    };
    let one = picture(Backend::Simd, 1);
    assert!(one.0.pixels.iter().any(|pixel| pixel[0] > 0.0));
    for (backend, threads) in [(Backend::Simd, 2), (Backend::Simd, 7), (Backend::Scalar, 2)] {
        assert!(one == picture(backend, threads), "{backend:?}, {threads} threads");
    }
}

#[test]
fn a_sample_count_limits_an_adaptive_render() {
    for most in [4, 10, 40] {
        let job = job(CORNER, &Changes { samples: Some(most), ..until(0.0001) });
        let reached = expose(&job).convergence.expect("a convergence");
        let most = f64::from(most);
        assert!(reached.mean_spp <= most && reached.mean_spp > most - 4.0, "{most}: {reached:?}");
        assert!(reached.noise > 0.0001);
    }
}

#[test]
fn layers_cover_all_samples_of_an_adaptive_render() {
    let layers = vec![Aov::Samples, Aov::Variance, Aov::Depth];
    let job = job(ROOM, &Changes { layers, ..until(0.1) });
    let exposed = expose(&job);
    let reached = exposed.convergence.expect("a convergence");
    let layers = exposed.layers(&job);
    let channel = |layer: usize, channel: usize| layers[layer].channels[channel].1.as_slice();
    let taken = channel(0, 0);
    let mean = taken.iter().map(|&n| f64::from(n)).sum::<f64>() / taken.len() as f64;
    assert!((mean / reached.mean_spp - 1.0).abs() < 1e-9, "{mean} {reached:?}");
    let ends = [f32::min, f32::max].map(|f| taken.iter().copied().reduce(f).unwrap_or(0.0));
    assert_eq!(ends, [reached.min_spp as f32, reached.max_spp as f32]);
    // The variance of green is close to that of luminance.
    let green: Vec<f64> = exposed.picture(&job).pixels.iter().map(|p| f64::from(p[1])).collect();
    let floor = 0.1 * green.iter().sum::<f64>() / green.len() as f64;
    let error = |(v, g): (&f32, &f64)| f64::from(*v) / (g + floor).powi(2);
    let sum: f64 = channel(1, 1).iter().zip(&green).map(error).sum();
    let noise = (sum / green.len() as f64).sqrt();
    assert!((noise / reached.noise - 1.0).abs() < 0.1, "{noise} {reached:?}");
    assert!((channel(2, 0)[47 * 48 + 24] - 2.2).abs() < 0.2, "the depth of the floor");
}

#[test]
fn black_pictures_stop_early() {
    let job = job("Shape \"sphere\" \"float radius\" 9", &until(0.01));
    let reached = expose(&job).convergence.expect("a convergence");
    assert!(reached.noise == 0.0 && reached.min_spp >= 256 && reached.max_spp < 512, "{reached:?}");
}

#[test]
fn a_time_limit_stops_a_render() {
    let time = Some(Duration::from_secs(1));
    let changes =
        Changes { stop_criteria: StopCriteria { noise: None, time }, ..Changes::default() };
    let job = job(ROOM, &changes);
    let start = Instant::now();
    let exposed = promptly("a render of one second", || expose(&job));
    let reached = exposed.convergence.expect("a convergence");
    let took = start.elapsed().as_secs_f64();
    println!("{took} s: {reached:?}");
    assert!(took > 0.5, "{took} s: {reached:?}");
    assert!(reached.min_spp > 4 && reached.noise > 0.0);
}

fn petzval(output: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
    command.args(["render", "scenes/dgauss.pbrt", "--resolution", "40x30", "-o"]);
    command.arg(output).args(arguments).current_dir(root());
    command.output().expect("the command starts")
}

#[test]
fn the_picture_records_the_noise_and_samples_reached() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let output = petzval(&path, &["--noise", "0.1", "--spp", "400"]);
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{stderr}");
    assert!(stderr.contains(", noise ") && stderr.contains(" samples a pixel ("), "{stderr}");
    let meta = exr::meta::MetaData::read_from_file(&path, true).expect("a picture");
    let other = &meta.headers[0].own_attributes.other;
    let number = |name: &str| match other.get(&exr::meta::attribute::Text::from(name)) {
        Some(exr::meta::attribute::AttributeValue::F32(value)) => *value,
        found => panic!("{name}: {found:?}"),
    };
    assert!((number("noise") / 0.1 - 1.0).abs() < 0.15, "{}", number("noise"));
    let mean = number("samplesPerPixel");
    assert!(number("leastSamplesPerPixel") <= mean && mean <= number("mostSamplesPerPixel"));
}

#[test]
fn invalid_limits_are_refused() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    for (arguments, expected) in [
        (&["--noise", "0"][..], "expected a relative error"),
        (&["--noise", "-1"], "expected a relative error"),
        (&["--noise", "nan"], "expected a relative error"),
        (&["--noise", "2"], "expected a relative error"),
        (&["--noise", "low"], "expected a relative error"),
        (&["--time", "0"], "expected a time above 0"),
        (&["--time", "-1s"], "expected a time above 0"),
        (&["--time", "inf"], "expected a time above 0"),
        (&["--time", "1e300"], "expected a time above 0"),
        (&["--noise", "0.1", "--spp", "3"], "need 4 samples a pixel or more"),
    ] {
        let output = petzval(&path, arguments);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(expected) && !path.exists(), "{arguments:?}: {stderr}");
    }
}
