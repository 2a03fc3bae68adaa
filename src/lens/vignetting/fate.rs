//! Waves of rays from a film point, and where in the lens they end.

use crate::lanes::f32x8;
use crate::lens::surface::Surface;
use crate::lens::trace::trace;
use crate::rays::{LensBatch, WAVE};

/// Where a ray starts: on a film whose middle is `distance` mm behind the rear vertex, in a medium.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    /// x, y, and z towards the scene from the middle of the film.
    pub film: [f64; 3],
    /// The film's own, towards the scene.
    pub normal: [f64; 3],
    pub distance: f64,
    pub index: f64,
}

/// What became of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fate {
    /// The row where it ended, or [`Fate::ALIVE`].
    pub row: u16,
    /// What shaped openings have let through of it.
    pub left: f32,
}

impl Fate {
    /// No row: the ray came through all surfaces.
    pub const ALIVE: u16 = u16::MAX;

    pub fn alive(self) -> bool {
        self.row == Self::ALIVE
    }
}

/// The columns of a wave.
#[derive(Clone, Debug, Default)]
pub(super) struct Fates {
    batch: Box<LensBatch<f32>>,
    fates: Vec<Fate>,
}

impl Fates {
    /// Sends rays, [`WAVE`] at most, to points of the plane of the rear vertex and through
    /// surfaces.
    pub fn of(
        &mut self,
        start: Start,
        count: usize,
        at: impl Fn(usize) -> [f64; 2],
        surfaces: &[Surface<f32>],
    ) -> &[Fate] {
        let Self { batch, fates } = self;
        let count = count.min(WAVE);
        for i in 0..count {
            let [u, v] = at(i);
            let t = start.towards([u, v]);
            [batch.x[i], batch.y[i], batch.z[i]] = start.film.map(|v| v as f32);
            [batch.tx[i], batch.ty[i], batch.tz[i]] = t.map(|t| t as f32);
            batch.weight[i] = 1.0;
        }
        batch.resize::<f32x8>(count);
        fates.clear();
        fates.resize(count, Fate { row: Fate::ALIVE, left: 1.0 });
        let rows = surfaces.iter().map(|surface| surface.row + 1).max().unwrap_or(0);
        let mut uncounted = vec![0; rows];
        for surface in surfaces {
            trace::<f32x8>(batch, std::slice::from_ref(surface), &mut uncounted);
            for (i, fate) in fates.iter_mut().enumerate() {
                if fate.alive() && batch.x[i].is_nan() {
                    fate.row = surface.row as u16;
                }
            }
        }
        for (i, fate) in fates.iter_mut().enumerate() {
            fate.left = batch.weight[i];
        }
        fates
    }
}

impl Start {
    /// The direction to a point of the plane of the rear vertex, of the length of the index.
    pub fn towards(&self, point: [f64; 2]) -> [f64; 3] {
        let way = self.way(point);
        let scale = self.index / squared(way).sqrt();
        way.map(|v| v * scale)
    }

    /// What a ray to a point of the plane of the rear vertex counts, mm^-2: the cosines at the film
    /// and at that plane over the square of its length.
    pub fn light(&self, point: [f64; 2]) -> f64 {
        let (way, [nx, ny, nz]) = (self.way(point), self.normal);
        let along = (nx * way[0] + ny * way[1] + nz * way[2]).max(0.0);
        along * way[2] / squared(way).powi(2)
    }

    fn way(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        let [x, y, z] = self.film;
        [u - x, v - y, self.distance - z]
    }
}

fn squared([x, y, z]: [f64; 3]) -> f64 {
    x * x + y * y + z * z
}
