//! Waves of rays that all pass a lens.

use std::hint::black_box;

use bytemuck::Pod;

use petzval_base::lanes::Real;
use petzval_base::rays::LensBatch;
use petzval_lens::{Prescription, Side, Surface, sequence, trace};

/// Origin on the film and unit direction of a ray; the film is at z = 0 and +z leads to the scene.
pub type Start = [[f64; 3]; 2];

/// Returns rays from points within `2 reach` of the axis to points within `reach` of it in a plane
/// `film` mm away.
pub fn starts(count: usize, film: f64, reach: f64) -> Vec<Start> {
    (0..count)
        .map(|i| {
            let t = i as f64 / count as f64;
            let (sin, cos) = (t * 40.0).sin_cos();
            let start = [2.0 * reach * t * cos, 2.0 * reach * t * sin, 0.0];
            let d = [reach * sin - start[0], reach * cos - start[1], film];
            let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            [start, d.map(|v| v / length)]
        })
        .collect()
}

/// Fills a batch with these rays, of weight 1, none of them blocked.
pub fn batch<R: Real>(starts: &[Start]) -> Box<LensBatch<R::Scalar>> {
    let mut batch = Box::<LensBatch<R::Scalar>>::default();
    for (i, [p, t]) in starts.iter().enumerate() {
        [batch.x[i], batch.y[i], batch.z[i]] = p.map(R::from_f64);
        [batch.tx[i], batch.ty[i], batch.tz[i]] = t.map(R::from_f64);
        batch.weight[i] = R::from_f64(1.0);
    }
    batch.resize::<R>(starts.len());
    batch
}

/// Copies the columns that a trace changes: a traced wave cannot be traced again.
fn refill<T: Pod>(batch: &mut LensBatch<T>, fresh: &LensBatch<T>) {
    let rays = fresh.len;
    (batch.len, batch.live) = (fresh.len, fresh.live);
    for (to, from) in [
        (&mut batch.x, &fresh.x),
        (&mut batch.y, &fresh.y),
        (&mut batch.z, &fresh.z),
        (&mut batch.tx, &fresh.tx),
        (&mut batch.ty, &fresh.ty),
        (&mut batch.tz, &fresh.tz),
    ] {
        to[..rays].copy_from_slice(&from[..rays]);
    }
}

/// A lens and one wave of rays, traced again and again.
#[derive(Debug)]
pub struct LensWave<R: Real> {
    surfaces: Vec<Surface<R::Scalar>>,
    fresh: Box<LensBatch<R::Scalar>>,
    batch: Box<LensBatch<R::Scalar>>,
    blocked: Vec<u64>,
}

impl<R: Real> LensWave<R> {
    /// Makes the rays of [`starts`] from a film `film` mm behind the rear vertex.
    ///
    /// # Panics
    /// If a ray does not pass, or f32 cannot trace it exactly enough: the rate would mean nothing.
    pub fn new(lens: &Prescription, film: f64, rays: usize, reach: f64) -> Self {
        let fresh = batch::<R>(&starts(rays, film, reach));
        let mut wave = Self {
            surfaces: sequence::<R>(lens, Side::Film(film)),
            batch: fresh.clone(),
            fresh,
            blocked: vec![0; lens.rows.len()],
        };
        wave.trace();
        assert_eq!(wave.blocked, vec![0; lens.rows.len()], "a ray of the bench is blocked");
        assert!(wave.batch.needs_f64.is_empty(), "a ray of the bench needs f64");
        wave
    }

    /// Traces all rays from the start.
    pub fn trace(&mut self) {
        refill(&mut self.batch, &self.fresh);
        trace::<R>(black_box(&mut self.batch), &self.surfaces, &mut self.blocked);
    }
}
