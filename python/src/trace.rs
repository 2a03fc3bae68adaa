//! Rays of arrays through a lens.

use petzval::Prescription;
use petzval::lanes::f32x8;
use petzval::lens::{LensRay, Side, retrace_in_f64, sequence, trace as trace_batch, trace_one};
use petzval::rays::{LensBatch, WAVE_SIZE};
use pyo3::PyResult;
use rayon::prelude::*;

use crate::error::value_error;

/// Side of the lens from which rays come.
#[derive(Clone, Copy)]
pub enum TravelFrom {
    /// Before the front vertex.
    Scene,
    /// Behind the rear vertex.
    Film,
}

impl TravelFrom {
    /// Returns the side of this name.
    pub fn named(name: &str) -> PyResult<Self> {
        match name {
            "scene" => Ok(Self::Scene),
            "film" => Ok(Self::Film),
            _ => Err(value_error(format!("side={name:?}: expected \"scene\" or \"film\""))),
        }
    }
}

/// Where rays behind the lens go, in columns of x, y and z.
pub struct TracedRays<'a> {
    /// Points relative to the last vertex (mm).
    pub points: &'a mut [f32],
    /// Unit directions.
    pub directions: &'a mut [f32],
    /// 0, or the number of the surface that ended the ray, from 1.
    pub status: &'a mut [u16],
}

/// Returns the columns of an array of 3 x `count`.
fn columns(values: &[f32], count: usize) -> [&[f32]; 3] {
    [0, 1, 2].map(|i| &values[i * count..(i + 1) * count])
}

/// Returns the columns of an array of 3 x `count`.
fn columns_mut(values: &mut [f32], count: usize) -> [&mut [f32]; 3] {
    let (x, rest) = values.split_at_mut(count);
    let (y, z) = rest.split_at_mut(count);
    [x, y, z]
}

/// Traces rays, wave by wave, on all cores. Directions may have any length.
pub fn trace(
    lens: &Prescription,
    from: TravelFrom,
    points: &[f32],
    directions: &[f32],
    traced: TracedRays<'_>,
) {
    let count = traced.status.len();
    let side = match from {
        TravelFrom::Scene => Side::Scene(0.0),
        TravelFrom::Film => Side::Film(0.0),
    };
    let index = match from {
        TravelFrom::Scene => lens.index_before(0),
        TravelFrom::Film => lens.rear().index,
    };
    let (surfaces, exact) = (sequence::<f32x8>(lens, side), sequence::<f64>(lens, side));
    let (points, directions) = (columns(points, count), columns(directions, count));
    let [x, y, z] = columns_mut(traced.points, count);
    let [dx, dy, dz] = columns_mut(traced.directions, count);
    let waves = (
        x.par_chunks_mut(WAVE_SIZE),
        y.par_chunks_mut(WAVE_SIZE),
        z.par_chunks_mut(WAVE_SIZE),
        dx.par_chunks_mut(WAVE_SIZE),
        dy.par_chunks_mut(WAVE_SIZE),
        dz.par_chunks_mut(WAVE_SIZE),
        traced.status.par_chunks_mut(WAVE_SIZE),
    );
    let scratch = || (Box::<LensBatch<f32>>::default(), vec![0; lens.rows.len()]);
    waves.into_par_iter().enumerate().for_each_init(
        scratch,
        |(batch, blocked), (wave, (x, y, z, dx, dy, dz, status))| {
            let rays = wave * WAVE_SIZE..wave * WAVE_SIZE + x.len();
            let [px, py, pz] = points.map(|column| &column[rays.clone()]);
            let [tx, ty, tz] = directions.map(|column| &column[rays.clone()]);
            batch.x[..px.len()].copy_from_slice(px);
            batch.y[..px.len()].copy_from_slice(py);
            batch.z[..px.len()].copy_from_slice(pz);
            let unit = |i: usize| {
                let length = (tx[i] * tx[i] + ty[i] * ty[i] + tz[i] * tz[i]).sqrt();
                [tx[i], ty[i], tz[i]].map(|t| t * (index as f32 / length))
            };
            for i in 0..px.len() {
                [batch.tx[i], batch.ty[i], batch.tz[i]] = unit(i);
            }
            batch.weight[..px.len()].fill(1.0);
            batch.resize::<f32x8>(px.len());
            let start = |i: usize| {
                let direction = [tx[i], ty[i], tz[i]].map(f64::from);
                let length = direction.iter().map(|t| t * t).sum::<f64>().sqrt();
                LensRay::new(
                    [px[i], py[i], pz[i]].map(f64::from),
                    direction.map(|t| t / length * index),
                )
            };
            trace_batch::<f32x8>(batch, &surfaces, blocked);
            retrace_in_f64::<f32x8>(batch, &exact, blocked, start);
            for i in 0..px.len() {
                let t = [batch.tx[i], batch.ty[i], batch.tz[i]];
                let length = (t[0] * t[0] + t[1] * t[1] + t[2] * t[2]).sqrt();
                [x[i], y[i], z[i]] = [batch.x[i], batch.y[i], batch.z[i]];
                [dx[i], dy[i], dz[i]] = t.map(|t| t / length);
                status[i] = 0;
                if batch.x[i].is_nan() {
                    [x[i], y[i], z[i], dx[i], dy[i], dz[i]] = [f32::NAN; 6];
                    // A ray that only f64 can trace exactly enough may pass in f32.
                    let ray = LensRay::new([px[i], py[i], pz[i]], unit(i));
                    let end = trace_one(ray, &surfaces).err();
                    let end = end.or_else(|| trace_one(start(i), &exact).err());
                    status[i] = end.map_or(lens.stop(), |end| end.row) as u16 + 1;
                }
            }
        },
    );
}
