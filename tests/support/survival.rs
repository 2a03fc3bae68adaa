//! How many of the rays that are aimed come through.

use petzval::lanes::f32x8;
use petzval::lens::{Camera, LensColumns};
use petzval::rays::{RayBatch, SampleBatch, WAVE};
use petzval::stats::LensStats;

use super::Random;

/// Share of the rays aimed from points all over the film that leave the lens.
pub fn survival(camera: &Camera, waves: u32) -> f64 {
    let mut samples = SampleBatch::default();
    let mut rays = RayBatch::default();
    let mut columns = LensColumns::default();
    let mut stats = LensStats { blocked: vec![0; 32], ..LensStats::default() };
    let mut random = Random::new(11);
    let mut alive = 0;
    for _ in 0..waves {
        samples.len = WAVE;
        for i in 0..WAVE {
            for axis in 0..2 {
                samples.film[axis][i] = (camera.film[axis] * (random.next() - 0.5)) as f32;
                samples.pupil[axis][i] = random.next() as f32;
            }
        }
        camera.expose::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        alive += rays.len as u64;
    }
    let blocked: u64 = stats.blocked.iter().sum();
    assert_eq!(stats.aimed, alive + blocked, "every aimed ray leaves or ends somewhere");
    alive as f64 / stats.aimed as f64
}
