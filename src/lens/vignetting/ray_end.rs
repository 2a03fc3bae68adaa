//! Ends of the rays of a film point inside the lens.

use crate::trace::surface::Surface;
use crate::trace::trace;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{LensBatch, WAVE_SIZE};

/// The film point where a ray starts. The film's centre is `distance` mm behind the rear vertex, in
/// a medium of `index`.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilmPoint {
    /// x, y, and z towards the scene from the centre of the film, mm.
    pub film: [f64; 3],
    /// Normal of the film, towards the scene.
    pub normal: [f64; 3],
    pub distance: f64,
    pub index: f64,
}

/// End of a ray in the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RayEnd {
    /// The row where it ends, or [`RayEnd::PASSED`].
    pub row: u32,
    /// Transmittance of the shaped openings on its way.
    pub transmittance: f32,
}

impl RayEnd {
    /// No row: the ray passes all surfaces.
    pub const PASSED: u32 = u32::MAX;

    pub fn passes(self) -> bool {
        self.row == Self::PASSED
    }
}

/// Working columns of a wave.
#[derive(Clone, Debug, Default)]
pub(super) struct RayEndTracer {
    batch: Box<LensBatch<f32>>,
    ends: Vec<RayEnd>,
    /// Blocked rays by row of the surface that was crossed last.
    blocked: Vec<u64>,
}

impl RayEndTracer {
    /// Traces at most [`WAVE_SIZE`] rays to points of the plane of the rear vertex and through
    /// surfaces; returns where they end.
    pub fn trace(
        &mut self,
        start: FilmPoint,
        count: usize,
        at: impl Fn(usize) -> [f64; 2],
        surfaces: &[Surface<f32>],
    ) -> &[RayEnd] {
        let Self { batch, ends, blocked } = self;
        let count = count.min(WAVE_SIZE);
        for i in 0..count {
            let [u, v] = at(i);
            let t = start.direction([u, v]);
            [batch.x[i], batch.y[i], batch.z[i]] = start.film.map(|v| v as f32);
            [batch.tx[i], batch.ty[i], batch.tz[i]] = t.map(|t| t as f32);
            batch.weight[i] = 1.0;
        }
        batch.resize::<f32x8>(count);
        ends.clear();
        ends.resize(count, RayEnd { row: RayEnd::PASSED, transmittance: 1.0 });
        let rows = surfaces.iter().map(|surface| surface.row + 1).max().unwrap_or(0);
        blocked.clear();
        blocked.resize(rows, 0);
        let mut ended = 0;
        for surface in surfaces {
            // The trace counts from the start of the batch: all rays that have ended so far.
            blocked[surface.row] = 0;
            trace::<f32x8>(batch, std::slice::from_ref(surface), blocked);
            // Most surfaces block nothing, and need no look at the rays.
            if blocked[surface.row] == ended {
                continue;
            }
            ended = blocked[surface.row];
            for (i, end) in ends.iter_mut().enumerate() {
                if end.passes() && batch.x[i].is_nan() {
                    end.row = surface.row as u32;
                }
            }
            if ended == count as u64 {
                break;
            }
        }
        for (i, end) in ends.iter_mut().enumerate() {
            end.transmittance = batch.weight[i];
        }
        ends
    }
}

impl FilmPoint {
    /// Returns the direction to a point of the plane of the rear vertex, of the length of the
    /// index.
    pub fn direction(&self, point: [f64; 2]) -> [f64; 3] {
        let way = self.way(point);
        let scale = self.index / squared(way).sqrt();
        way.map(|v| v * scale)
    }

    /// Returns the weight of a ray to a point of the plane of the rear vertex [mm^-2]: the cosines
    /// at the film and at that plane over the square of its length, times the square of the index.
    pub fn weight(&self, point: [f64; 2]) -> f64 {
        let (way, [nx, ny, nz]) = (self.way(point), self.normal);
        let along = (nx * way[0] + ny * way[1] + nz * way[2]).max(0.0);
        self.index * self.index * along * way[2] / squared(way).powi(2)
    }

    fn way(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let [x, y, z] = self.film;
        [u - x, v - y, self.distance - z]
    }
}

fn squared([x, y, z]: [f64; 3]) -> f64 {
    x * x + y * y + z * z
}
