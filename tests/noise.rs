//! A picture that ends when it is exact enough: it is, it is not biased, and it costs less.

mod support;

use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use petzval::aov::{self, Aov};
use petzval::image::Picture;
use petzval::job::{Changes, prepare};
use petzval::render::{Backend, Exposed, Job, Progress, Until, render};
use petzval::scene::{luminance, pbrt};
use support::{folder, root, write};

/// A room with a lamp, a dull ball and one of metal.
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

/// A sky, and balls in the lower left corner, half in the shadow of what hangs above them.
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
    prepare(description, changes).expect("a job").0
}

/// Ends at this noise.
fn until(noise: f64) -> Changes {
    Changes { until: Until { noise: Some(noise), time: None }, ..Changes::default() }
}

fn expose(job: &Job) -> Exposed {
    render(job, Backend::Simd, 2, &Progress::default()).expect("a render that nobody stops")
}

/// A picture of as many samples everywhere, of other random numbers.
fn even(world: &str, samples: u32, seed: u32) -> Picture {
    let changes = Changes { samples: Some(samples), seed: Some(seed), ..Changes::default() };
    let job = job(world, &changes);
    expose(&job).picture(&job)
}

fn light(picture: &Picture) -> Vec<f64> {
    picture.pixels.iter().map(|&pixel| f64::from(luminance(pixel))).collect()
}

/// The mean square of the relative difference from a reference: with a tenth of the mean.
fn square_error(picture: &Picture, reference: &[f64]) -> f64 {
    let count = reference.len() as f64;
    let floor = 0.1 * reference.iter().sum::<f64>() / count;
    let error = |(a, b): (f64, &f64)| ((a - b) / (b + floor)).powi(2);
    light(picture).into_iter().zip(reference).map(error).sum::<f64>() / count
}

/// A picture of many samples, the mean of two, and its own mean square error.
fn reference(world: &str) -> (Vec<f64>, f64) {
    let [one, other] = [1001, 1002].map(|seed| even(world, 4096, seed));
    let own = square_error(&one, &light(&other)) / 4.0;
    let mean = light(&one).iter().zip(light(&other)).map(|(a, b)| (a + b) / 2.0).collect();
    (mean, own)
}

#[test]
fn a_picture_is_as_exact_as_was_asked() {
    for (world, asked) in [(ROOM, 0.02), (CORNER, 0.004)] {
        let (reference, own) = reference(world);
        let job = job(world, &until(asked));
        let (mut errors, mut said, seeds) = (0.0, 0.0, 20);
        for seed in 0..seeds {
            let job = Job { seed, ..job.clone() };
            let exposed = expose(&job);
            let reached = exposed.reached.expect("what was reached");
            let error = square_error(&exposed.picture(&job), &reference) - own;
            println!("{seed}: {:.4} {reached:?}", error.sqrt());
            assert!((reached.noise / asked - 1.0).abs() < 0.15, "{seed}: {reached:?}");
            errors += error / f64::from(seeds);
            said += reached.noise.powi(2) / f64::from(seeds);
        }
        let [error, said] = [errors, said].map(f64::sqrt);
        println!("error {error} said {said}; the reference's own is {}", own.sqrt());
        assert!((error / asked - 1.0).abs() < 0.15, "{error} where {asked} was asked");
        assert!((error / said - 1.0).abs() < 0.1, "{error} where {said} was said");
    }
}

#[test]
fn many_pictures_have_the_mean_of_a_long_one() {
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
        most = most.max(exposed.reached.map_or(0, |reached| reached.most));
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
    // Pixel by pixel the squares of deviations are 1 in the mean, and a little more for Student's
    // distribution of 63 degrees; the reference has errors too.
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

/// Much of the light of few pixels comes by few samples: where those that are not there would end
/// the render early, it would be too dark.
#[test]
fn rare_light_is_not_lost() {
    let glass = ROOM
        .replace("Material \"diffuse\" AttributeBegin", "Material \"dielectric\" AttributeBegin");
    let mean = |job: &Job, exposed: &Exposed| {
        let light = light(&exposed.picture(job));
        light.iter().sum::<f64>() / light.len() as f64
    };
    let resolution = Some([24, 24]);
    let even = Changes { resolution, samples: Some(8192), seed: Some(1001), ..Changes::default() };
    let even = self::job(&glass, &even);
    let job = self::job(&glass, &Changes { resolution, ..until(0.08) });
    let runs = 150;
    let mut sums = [0.0; 2];
    let mut samples = 0.0;
    for seed in 0..runs {
        let job = Job { seed, ..job.clone() };
        let exposed = expose(&job);
        let light = mean(&job, &exposed);
        samples += exposed.reached.map_or(0.0, |reached| reached.mean) / f64::from(runs);
        sums = [sums[0] + light, sums[1] + light * light];
    }
    let n = f64::from(runs);
    let found = sums[0] / n;
    let variance = (sums[1] / n - found * found) / (n - 1.0);
    // The reference is as exact as its share of samples says.
    let count = even.samples.end;
    let expected = mean(&even, &expose(&even));
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
        let reached = exposed.reached.expect("what was reached");
        let samples = (reached.mean / 0.7) as u32;
        adaptive += square_error(&exposed.picture(&job), &reference);
        let error = square_error(&even(CORNER, samples, seed), &reference);
        uniform += error;
        ratio += 0.7 * square_error(&exposed.picture(&job), &reference) / error / 4.0;
        assert!(reached.most > 3 * reached.least, "{reached:?}");
    }
    println!("samples for the same error: {ratio:.2} of those of an even picture");
    assert!(adaptive < uniform, "{adaptive} and {uniform} for 1 / 0.7 of the samples");
}

/// Who meets a lamp as small as two thousandths of a pixel by chance must learn how small it is.
#[test]
fn a_speck_of_light_does_not_keep_the_render_from_ending() {
    let lamp = r#"
        LightSource "infinite" "rgb L" [0.5 0.5 0.5]
        AttributeBegin
            AreaLightSource "diffuse" "rgb L" [5e3 5e3 5e3]
            Translate 0.31 0.52 4 Shape "sphere" "float radius" 0.004
        AttributeEnd"#;
    let job = job(lamp, &until(0.05));
    let mut met = 0;
    for seed in 0..80 {
        let job = Job { seed, ..job.clone() };
        let reached = expose(&job).reached.expect("what was reached");
        println!("{seed}: {reached:?}");
        met += u32::from(reached.most > 1000);
        assert!(reached.mean < 4000.0, "{seed}: {reached:?}");
    }
    assert!(met > 0, "the lamp was never met");
}

#[test]
fn threads_and_lanes_do_not_change_what_is_enough() {
    let job = job(ROOM, &until(0.15));
    let picture = |backend, threads| {
        let exposed = render(&job, backend, threads, &Progress::default()).expect("a render");
        (exposed.picture(&job), exposed.reached)
    };
    let one = picture(Backend::Simd, 1);
    assert!(one.0.pixels.iter().any(|pixel| pixel[0] > 0.0));
    for (backend, threads) in [(Backend::Simd, 2), (Backend::Simd, 7), (Backend::Scalar, 2)] {
        assert!(one == picture(backend, threads), "{backend:?}, {threads} threads");
    }
}

#[test]
fn a_count_is_the_most_that_is_taken() {
    for most in [4, 10, 40] {
        let job = job(CORNER, &Changes { samples: Some(most), ..until(0.0001) });
        let reached = expose(&job).reached.expect("what was reached");
        let most = f64::from(most);
        assert!(reached.mean <= most && reached.mean > most - 4.0, "{most}: {reached:?}");
        assert!(reached.noise > 0.0001);
    }
}

#[test]
fn layers_know_all_samples() {
    let layers = vec![Aov::Samples, Aov::Variance, Aov::Depth];
    let job = job(ROOM, &Changes { layers, ..until(0.1) });
    let exposed = expose(&job);
    let reached = exposed.reached.expect("what was reached");
    let layers = aov::layers(&job, &exposed.film, exposed.features.as_ref());
    let channel = |layer: usize, channel: usize| layers[layer].channels[channel].1.as_slice();
    let taken = channel(0, 0);
    let mean = taken.iter().map(|&n| f64::from(n)).sum::<f64>() / taken.len() as f64;
    assert!((mean / reached.mean - 1.0).abs() < 1e-9, "{mean} {reached:?}");
    let ends = [f32::min, f32::max].map(|f| taken.iter().copied().reduce(f).unwrap_or(0.0));
    assert_eq!(ends, [reached.least as f32, reached.most as f32]);
    // The variance of green is that of luminance, nearly.
    let green: Vec<f64> = exposed.picture(&job).pixels.iter().map(|p| f64::from(p[1])).collect();
    let floor = 0.1 * green.iter().sum::<f64>() / green.len() as f64;
    let error = |(v, g): (&f32, &f64)| f64::from(*v) / (g + floor).powi(2);
    let sum: f64 = channel(1, 1).iter().zip(&green).map(error).sum();
    let noise = (sum / green.len() as f64).sqrt();
    assert!((noise / reached.noise - 1.0).abs() < 0.1, "{noise} {reached:?}");
    assert!((channel(2, 0)[47 * 48 + 24] - 2.2).abs() < 0.2, "the floor is near below");
}

#[test]
fn black_pictures_end() {
    let job = job("Shape \"sphere\" \"float radius\" 9", &until(0.01));
    let reached = expose(&job).reached.expect("what was reached");
    assert!(reached.noise == 0.0 && reached.least >= 256 && reached.most < 512, "{reached:?}");
}

#[test]
fn time_ends_a_render() {
    let time = Some(Duration::from_secs(1));
    let changes = Changes { until: Until { noise: None, time }, ..Changes::default() };
    let job = job(ROOM, &changes);
    let start = Instant::now();
    let reached = expose(&job).reached.expect("what was reached");
    let took = start.elapsed().as_secs_f64();
    println!("{took} s: {reached:?}");
    assert!(took > 0.5 && took < 3.0, "{took} s: {reached:?}");
    assert!(reached.least > 4 && reached.noise > 0.0);
}

fn petzval(output: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
    command.args(["render", "scenes/dgauss.pbrt", "--resolution", "40x30", "-o"]);
    command.arg(output).args(arguments).current_dir(root());
    command.output().expect("the command starts")
}

#[test]
fn the_picture_says_what_was_reached() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let output = petzval(&path, &["--noise", "0.1", "--spp", "400"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("noise: ") && said.contains("samples a pixel: "), "{said}");
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
fn nonsense_is_refused() {
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
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(expected) && !path.exists(), "{arguments:?}: {said}");
    }
}
