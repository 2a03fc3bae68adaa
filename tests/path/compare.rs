//! Means of pictures with what is known of their errors.

use petzval::aov::Aov;
use petzval::job::{Changes, prepare};
use petzval::render::{Backend, Job, render};
use petzval::scene::pbrt;

use crate::matter::Colour;
use crate::support::{Random, folder, write};
use crate::world::{FIELD, World};

/// A mean and its standard error, by channel.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    pub mean: Colour,
    pub error: Colour,
}

/// Means agree within so many standard errors of their difference: of all comparisons in these
/// tests, one in ten thousand sets of them would fail by chance.
const SIGMAS: f64 = 5.0;
/// So many of them may be at most these shares of the mean, of the real path tracer, of the naive
/// one, and of their difference: a wrong 1 % is seen.
const SEEN: [f64; 3] = [0.0045, 0.006, 0.008];

/// Pixels on a side: so many that textures are hardly averaged over a pixel.
const SIDE: u32 = 64;

/// A job for a world in text; a picture of the sky may stand beside it.
pub fn job(text: &str, sky: Option<Vec<u8>>, depth: u32) -> Job {
    let text = format!(
        r#"Film "rgb" "integer xresolution" {SIDE} "integer yresolution" {SIDE}
           PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
           Sampler "independent" "integer pixelsamples" 4
           Integrator "path" "integer maxdepth" {depth}
           Camera "perspective" "float fov" {FIELD}
           WorldBegin
           {text}"#
    );
    let folder = folder();
    if let Some(sky) = sky {
        write(&folder, "sky.pfm", sky);
    }
    let description = match pbrt::read(&write(&folder, "scene.pbrt", &text)) {
        Ok(description) => description,
        Err(error) => panic!("{error}\n{text}"),
    };
    let layers = vec![Aov::Variance];
    prepare(description, &Changes { layers, ..Changes::default() }).expect("a job").0
}

/// What the real path tracer finds.
pub fn found(job: &Job) -> Estimate {
    let exposed = render(job, Backend::Simd, 1, &Default::default()).expect("a picture");
    assert_eq!(exposed.film.dropped.count(), 0, "no sample may be other than a number");
    let samples = job.samples.end - job.samples.start;
    let mean = crate::support::mean(&exposed.film.picture(samples));
    let variance = exposed.film.variance(samples).expect("the squares were added up");
    let n = variance.len() as f64;
    let error = [0, 1, 2].map(|c| {
        let sum: f64 = variance.iter().map(|pixel| f64::from(pixel[c])).sum();
        sum.sqrt() / n
    });
    Estimate { mean, error }
}

/// As much of a picture as it takes to know its mean.
pub fn well_known(mut job: Job) -> Estimate {
    loop {
        let found = found(&job);
        let excess = (0..3).map(|c| SIGMAS * found.error[c] / (SEEN[0] * found.mean[c]));
        let excess = excess.fold(0.0, f64::max);
        if excess <= 1.0 || job.samples.end > 512 {
            println!("{} samples a pixel", job.samples.end);
            return found;
        }
        let more = 1.1 * excess * excess * f64::from(job.samples.end);
        job.samples.end = more.min(600.0) as u32;
    }
}

/// What the naive path tracer finds, with as many rays as it takes: always two in every cell of
/// the picture, whose difference tells the error.
pub fn expected(world: &World, depth: u32) -> Estimate {
    const CELLS: u32 = 160;
    let mut random = Random::new(7);
    let (mut n, mut sum, mut squares) = (0.0, [0.0; 3], [0.0; 3]);
    loop {
        for cell in (0..CELLS).flat_map(|y| (0..CELLS).map(move |x| [x, y])) {
            let [a, b] = [(); 2].map(|()| world.sample(cell, CELLS, depth, &mut random));
            sum = [0, 1, 2].map(|c| sum[c] + a[c] + b[c]);
            squares = [0, 1, 2].map(|c| squares[c] + (a[c] - b[c]).powi(2));
        }
        n += f64::from(2 * CELLS * CELLS);
        let (mean, error) = (sum.map(|s| s / n), squares.map(|s| s.sqrt() / n));
        if n > 4e6 || (0..3).all(|c| SIGMAS * error[c] <= SEEN[1] * mean[c]) {
            println!("{n} naive rays");
            return Estimate { mean, error };
        }
    }
}

/// Two estimates of the same.
pub fn assert_same(found: Estimate, expected: Estimate) {
    let bound = |c| SIGMAS * f64::hypot(found.error[c], expected.error[c]);
    for c in 0..3 {
        let (mean, truth) = (found.mean[c], expected.mean[c]);
        let off = (mean / truth - 1.0) * 100.0;
        println!("channel {c}: {mean:.5}, expected {truth:.5} +- {:.5}; {off:.2} %", bound(c));
    }
    for c in 0..3 {
        let (mean, truth, bound) = (found.mean[c], expected.mean[c], bound(c));
        assert!(bound <= SEEN[2] * truth, "channel {c}: {mean} and {truth} known to {bound} only");
        assert!((mean - truth).abs() <= bound, "channel {c}: {mean}, not {truth} +- {bound}");
    }
}

/// Both path tracers see the same in a world.
pub fn agree(world: &World, depth: u32) {
    agree_with(&world.text(), world, depth);
}

/// The real one sees in a scene file what the naive one sees in a world.
pub fn agree_with(text: &str, world: &World, depth: u32) {
    let found = well_known(job(text, world.pfm(), depth));
    let expected = expected(world, depth);
    assert_same(found, expected);
}
