//! Rays of a camera by its pupil sampler: irradiance of film points, and the share that leaves the lens.

use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, fill_2d};
use petzval_base::stats::LensStats;
use petzval_lens::{Camera, LensColumns};

use super::Random;

/// Returns random samples on a film of this size, mm.
pub fn random_samples(film: [f64; 2], random: &mut Random) -> SampleBatch {
    let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
    for i in 0..WAVE_SIZE {
        for axis in 0..2 {
            samples.film[axis][i] = (film[axis] * (random.next() - 0.5)) as f32;
            samples.pupil[axis][i] = random.next() as f32;
        }
    }
    samples
}

/// Returns the share of rays, aimed from random points of the film, that leave the lens.
pub fn transmitted_share(camera: &Camera, waves: u32) -> f64 {
    let mut rays = RayBatch::default();
    let mut columns = LensColumns::default();
    let mut stats = LensStats::default();
    let mut random = Random::new(11);
    let mut alive = 0;
    for _ in 0..waves {
        let samples = random_samples(camera.film, &mut random);
        camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        alive += rays.len as u64;
    }
    let blocked: u64 = stats.blocked().iter().sum();
    assert_eq!(stats.aimed, alive + blocked, "every aimed ray leaves the lens or ends");
    alive as f64 / stats.aimed as f64
}

/// Returns the mean weight of the rays of a film point, mm, which is its irradiance under a uniform sky of
/// radiance 1, and the share of the rays that leaves the lens. `key` selects the random numbers.
pub fn irradiance_and_share(camera: &Camera, film: [f64; 2], waves: u32, key: u32) -> (f64, f64) {
    let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
    let (mut rays, mut columns) = (RayBatch::default(), LensColumns::default());
    let mut stats = LensStats::default();
    let (mut sum, mut alive) = (0.0, 0);
    for wave in 0..waves {
        for i in 0..WAVE_SIZE {
            samples.key[i] = key;
            samples.sample[i] = wave * WAVE_SIZE as u32 + i as u32;
            (samples.film[0][i], samples.film[1][i]) = (film[0] as f32, film[1] as f32);
        }
        let [u, v] = &mut samples.pupil;
        fill_2d(&samples.key[..], &samples.sample[..], Dimension::Pupil, &mut u[..], &mut v[..]);
        camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        sum += (0..rays.len).map(|i| f64::from(rays.throughput[0][i])).sum::<f64>();
        alive += rays.len;
    }
    let total = f64::from(waves) * WAVE_SIZE as f64;
    (sum / total, alive as f64 / total)
}
