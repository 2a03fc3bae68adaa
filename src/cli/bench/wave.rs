//! A wave of rays that all come through a lens.

use std::hint::black_box;

use petzval::lanes::Real;
use petzval::lens::{From, Prescription, Surface, sequence, trace};
use petzval::rays::LensBatch;

/// Rays from points near the axis that all come through.
pub fn starts(count: usize, film: f64, reach: f64) -> Vec<[[f64; 3]; 2]> {
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

/// A wave of them.
pub fn wave<R: Real>(starts: &[[[f64; 3]; 2]]) -> Box<LensBatch<R::Scalar>> {
    let mut batch = Box::<LensBatch<R::Scalar>>::default();
    for (i, [p, t]) in starts.iter().enumerate() {
        [batch.x[i], batch.y[i], batch.z[i]] = p.map(R::scalar);
        [batch.tx[i], batch.ty[i], batch.tz[i]] = t.map(R::scalar);
    }
    batch.resize::<R>(starts.len());
    batch
}

/// Copies what a trace changes; a traced wave cannot be traced again.
fn refill<T: bytemuck::Pod>(batch: &mut LensBatch<T>, fresh: &LensBatch<T>) {
    let rays = fresh.len;
    (batch.len, batch.living) = (fresh.len, fresh.living);
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

/// A lens whose rays are traced in batches.
pub struct Bench<R: Real> {
    surfaces: Vec<Surface<R::Scalar>>,
    fresh: Box<LensBatch<R::Scalar>>,
    batch: Box<LensBatch<R::Scalar>>,
    blocked: Vec<u64>,
}

impl<R: Real> Bench<R> {
    /// Rays from a film at this distance, mm, to points within a reach of the axis of the rear vertex.
    pub fn new(lens: &Prescription, film: f64, rays: usize, reach: f64) -> Self {
        let fresh = wave::<R>(&starts(rays, film, reach));
        let mut bench = Self {
            surfaces: sequence::<R>(lens, From::Film(film)),
            batch: fresh.clone(),
            fresh,
            blocked: vec![0; lens.rows.len()],
        };
        bench.trace();
        assert_eq!(bench.blocked, vec![0; lens.rows.len()], "the bench means rays that pass");
        assert!(bench.batch.doubtful.is_empty(), "and need no second trace");
        bench
    }

    /// Traces all of them, from the start.
    pub fn trace(&mut self) {
        refill(&mut self.batch, &self.fresh);
        trace::<R>(black_box(&mut self.batch), &self.surfaces, &mut self.blocked);
    }
}
