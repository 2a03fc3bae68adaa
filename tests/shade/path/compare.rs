//! Means of pictures, their standard errors, and comparisons of the two path tracers.

use std::fmt::Debug;

use petzval_render::aov::Aov;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{RenderOptions, render};
use petzval_scene_formats::pbrt;

use super::material::Colour;
use super::world::{FIELD, World};
use crate::support::reference::{means_agree, reference};
use crate::support::{Random, folder, write};

/// A mean and its standard error, by channel.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    pub mean: Colour,
    pub error: Colour,
}

/// Largest difference of two means, in standard errors. By chance, all comparisons of these tests
/// together fail once in ten thousand runs.
const SIGMAS: f64 = 5.0;
/// Largest [`SIGMAS`] standard errors relative to the mean: of the real path tracer, of the naive
/// one, and of their difference. With these, an error of 1 % is detected.
const PRECISION: [f64; 3] = [0.0045, 0.006, 0.008];

/// Side of the picture (pixels), large enough that textures are hardly filtered.
const SIDE: u32 = 64;

/// Returns the job of a scene file's world, with an optional picture of the sky.
pub fn job(text: &str, sky: Option<Vec<u8>>, depth: u32) -> Job {
    job_around("", text, sky, depth)
}

/// Returns the same job with directives before the camera.
pub fn job_around(before: &str, text: &str, sky: Option<Vec<u8>>, depth: u32) -> Job {
    let text = format!(
        r#"Film "rgb" "integer xresolution" {SIDE} "integer yresolution" {SIDE}
           PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
           Sampler "independent" "integer pixelsamples" 4
           Integrator "volpath" "integer maxdepth" {depth}
           {before}
           Camera "perspective" "float fov" {FIELD}
           WorldBegin
           {text}"#
    );
    job_of(&text, sky)
}

/// Returns the job of a scene file, with an optional picture of the sky.
pub fn job_of(text: &str, sky: Option<Vec<u8>>) -> Job {
    let folder = folder();
    if let Some(sky) = sky {
        write(&folder, "sky.pfm", sky);
    }
    let description = match pbrt::read(&write(&folder, "scene.pbrt", text)) {
        Ok(description) => description,
        Err(error) => panic!("{error}\n{text}"),
    };
    let layers = vec![Aov::Variance];
    // The naive path tracer follows rays of one wavelength; media are left as they are.
    let effects = "-dispersion,-fresnel,-ghosts,-iris,-diffraction".parse().expect("effects");
    prepare(description, &Changes { layers, effects, ..Changes::default() }).expect("a job").job
}

/// Returns the estimate of the real path tracer.
pub fn found(job: &Job) -> Estimate {
    let exposed =
        render(job, RenderOptions { threads: 1, ..RenderOptions::default() }).expect("a picture");
    assert_eq!(exposed.film.dropped.count(), 0, "all samples are finite");
    let samples = job.samples.end - job.samples.start;
    let mean = crate::support::mean(&exposed.film.picture(samples));
    let variance = exposed.film.variance(samples).expect("the film knows its variance");
    let n = variance.len() as f64;
    let error = [0, 1, 2].map(|c| {
        let sum: f64 = variance.iter().map(|pixel| f64::from(pixel[c])).sum();
        sum.sqrt() / n
    });
    Estimate { mean, error }
}

/// Returns the estimate of the real path tracer, with as many samples as its precision needs.
pub fn well_known(mut job: Job) -> Estimate {
    loop {
        let found = found(&job);
        let excess = (0..3).map(|c| SIGMAS * found.error[c] / (PRECISION[0] * found.mean[c]));
        let excess = excess.fold(0.0, f64::max);
        if excess <= 1.0 || job.samples.end > 512 {
            println!("{} samples a pixel", job.samples.end);
            return found;
        }
        let more = 1.1 * excess * excess * f64::from(job.samples.end);
        job.samples.end = more.min(600.0) as u32;
    }
}

/// Returns an estimate from the file of references, which the full tier computes again.
pub fn stored(label: &str, subject: impl Debug, compute: impl FnOnce() -> Estimate) -> Estimate {
    let subject = (PRECISION[1], subject);
    let numbers = reference("path", label, subject, means_agree(SIGMAS), || {
        let Estimate { mean, error } = compute();
        (0..3).flat_map(|c| [mean[c], error[c]]).collect()
    });
    let column = |part: usize| [0, 1, 2].map(|c| numbers[2 * c + part]);
    Estimate { mean: column(0), error: column(1) }
}

/// Returns the estimate of the naive path tracer.
pub fn expected(world: &World, depth: u32) -> Estimate {
    let label = format!("{}, depth {depth}", world.summary());
    stored(&label, (world, depth), || computed(world, depth))
}

/// Computes the estimate of the naive path tracer, with as many rays as its precision needs. Every
/// cell of the picture gets two rays, whose difference gives the error.
fn computed(world: &World, depth: u32) -> Estimate {
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
        if n > 1.2e7 || (0..3).all(|c| SIGMAS * error[c] <= PRECISION[1] * mean[c]) {
            println!("{n} naive rays");
            return Estimate { mean, error };
        }
    }
}

/// Returns the estimate from batches of independent values, as many as its precision needs.
pub fn expected_by(mut batch: impl FnMut() -> Vec<Colour>) -> Estimate {
    let (mut n, mut sum, mut squares) = (0.0, [0.0; 3], [0.0; 3]);
    loop {
        for value in batch() {
            n += 1.0;
            sum = [0, 1, 2].map(|c| sum[c] + value[c]);
            squares = [0, 1, 2].map(|c| squares[c] + value[c] * value[c]);
        }
        let mean = sum.map(|sum| sum / n);
        let error = [0, 1, 2].map(|c| ((squares[c] / n - mean[c] * mean[c]).max(0.0) / n).sqrt());
        let precise = (0..3).all(|c| SIGMAS * error[c] <= PRECISION[1] * mean[c]);
        if n > 2e7 || n > 1e5 && precise {
            println!("{n} naive rays");
            return Estimate { mean, error };
        }
    }
}

/// Checks that two estimates of the same value agree.
pub fn assert_same(found: Estimate, expected: Estimate) {
    let bound = |c| SIGMAS * f64::hypot(found.error[c], expected.error[c]);
    for c in 0..3 {
        let (mean, truth) = (found.mean[c], expected.mean[c]);
        let off = (mean / truth - 1.0) * 100.0;
        println!("channel {c}: {mean:.5}, expected {truth:.5} +- {:.5}; {off:.2} %", bound(c));
    }
    for c in 0..3 {
        let (mean, truth, bound) = (found.mean[c], expected.mean[c], bound(c));
        assert!(
            bound <= PRECISION[2] * truth,
            "channel {c}: {mean} and {truth} known to {bound} only"
        );
        assert!((mean - truth).abs() <= bound, "channel {c}: {mean}, not {truth} +- {bound}");
    }
}

/// Checks that both path tracers agree on a world.
pub fn agree(world: &World, depth: u32) {
    agree_with(&world.text(), world, depth);
}

/// Checks that the real path tracer with a scene file agrees with the naive one with a world.
pub fn agree_with(text: &str, world: &World, depth: u32) {
    let found = well_known(job_around(&world.prelude(), text, world.pfm(), depth));
    let expected = expected(world, depth);
    assert_same(found, expected);
}
