//! Rays from a wide film that graze a rear hemisphere.

use petzval_base::lanes::f32x8;

use crate::support::grazing::Hemisphere;
use crate::support::probe::{Bench, distance, start};
use crate::support::{Random, in_parallel};

/// Promised error of f32 with rays retraced in f64, urad.
const PROMISE: f64 = 5.0;

#[test]
fn rays_that_graze_a_rear_hemisphere_stay_within_the_bound() {
    let seeds: Vec<u64> = (0..150).collect();
    let worst = in_parallel(&seeds, |&seed| {
        let mut random = Random::new(seed);
        let hemisphere = Hemisphere::random(&mut random);
        let radius = hemisphere.radius();
        // A film cannot lie inside the rim of a concave face.
        let least = if hemisphere.is_concave() { 1.05 } else { 0.05 };
        let film = radius * 10f64.powf(random.between(f64::log10(least), 0.6));
        let bench = Bench::new(&hemisphere.lens, film);
        let mut rays = Vec::new();
        while rays.len() < 10_000 {
            let [p, d] = hemisphere.ray(&mut random);
            let back = (p[2] + film) / d[2];
            let [x, y] = [0, 1].map(|i| p[i] - back * d[i]);
            if x.hypot(y) < film + radius {
                rays.push(start([x, y, 0.0], d));
            }
        }
        let retraced = bench.trace_batch::<f32x8>(&rays, &bench.single, true);
        let mut through = 0;
        let off = rays.iter().zip(&retraced.rays).map(|(&ray, ours)| {
            match (ours, bench.trace_one(ray)) {
                (Some(ours), Ok(exact)) => {
                    through += 1;
                    1e6 * distance(ours.d, exact.d)
                }
                _ => 0.0,
            }
        });
        let worst = off.fold(0.0, f64::max);
        assert!(through > 1000, "lens {seed}: {through} rays come through");
        worst
    });
    for (seed, worst) in seeds.iter().zip(worst) {
        assert!(worst < PROMISE, "lens {seed}: {worst} urad");
    }
}
