//! Rays of arrays through a lens.

use std::time::{Duration, Instant};

use petzval::Prescription;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{LensBatch, WAVE_SIZE};
use petzval_lens::{LensRay, Side, retrace_in_f64, sequence, trace as trace_batch, trace_one};
use pyo3::PyResult;
use rayon::prelude::*;

use crate::error::value_error;

/// Squares of lengths that f32 holds with all its digits.
const SQUARES: std::ops::Range<f32> = 1e-30..1e30;

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

/// Returns a direction of any length as one whose length is the refractive index.
fn unit_direction(direction: [f32; 3], index: f64) -> [f64; 3] {
    let direction = direction.map(f64::from);
    let length = direction.iter().map(|t| t * t).sum::<f64>().sqrt();
    direction.map(|t| t / length * index)
}

/// Fills a wave with rays.
fn load_wave(batch: &mut LensBatch<f32>, points: [&[f32]; 3], directions: [&[f32]; 3], index: f64) {
    let count = points[0].len();
    batch.x[..count].copy_from_slice(points[0]);
    batch.y[..count].copy_from_slice(points[1]);
    batch.z[..count].copy_from_slice(points[2]);
    let [tx, ty, tz] = directions;
    let mut regular = true;
    for i in 0..count {
        let direction = [tx[i], ty[i], tz[i]];
        let square: f32 = direction.iter().map(|t| t * t).sum();
        let scale = index as f32 / square.sqrt();
        [batch.tx[i], batch.ty[i], batch.tz[i]] = direction.map(|t| t * scale);
        regular &= SQUARES.contains(&square);
    }
    if !regular {
        for i in 0..count {
            let direction = unit_direction([tx[i], ty[i], tz[i]], index);
            [batch.tx[i], batch.ty[i], batch.tz[i]] = direction.map(|t| t as f32);
        }
    }
    batch.weight[..count].fill(1.0);
    batch.resize::<f32x8>(count);
}

/// Returns the time (s) that the kernel takes on one thread for rays from the scene, without what
/// [`trace`] adds: loads, stores and the status.
pub fn kernel_seconds(lens: &Prescription, points: &[f32], directions: &[f32]) -> f64 {
    let (side, index, count) = (Side::Scene(0.0), lens.index_before(0), points.len() / 3);
    let (surfaces, exact) = (sequence::<f32x8>(lens, side), sequence::<f64>(lens, side));
    let (points, directions) = (columns(points, count), columns(directions, count));
    let (mut batch, mut blocked) = (Box::<LensBatch<f32>>::default(), vec![0; lens.rows.len()]);
    let mut time = Duration::ZERO;
    for start in (0..count).step_by(WAVE_SIZE) {
        let rays = start..count.min(start + WAVE_SIZE);
        let [points, directions] =
            [points, directions].map(|all| all.map(|column| &column[rays.clone()]));
        load_wave(&mut batch, points, directions, index);
        let ray = |i: usize| {
            let direction = directions.map(|column| column[i]);
            let point = points.map(|column| f64::from(column[i]));
            LensRay::new(point, unit_direction(direction, index))
        };
        let begun = Instant::now();
        trace_batch::<f32x8>(&mut batch, &surfaces, &mut blocked);
        retrace_in_f64::<f32x8>(&mut batch, &exact, &mut blocked, ray);
        time += begun.elapsed();
    }
    time.as_secs_f64()
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
    let (side, index) = match from {
        TravelFrom::Scene => (Side::Scene(0.0), lens.index_before(0)),
        TravelFrom::Film => (Side::Film(0.0), lens.rear().index),
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
            let unit = |i: usize| unit_direction([tx[i], ty[i], tz[i]], index);
            load_wave(batch, [px, py, pz], [tx, ty, tz], index);
            let start = |i: usize| LensRay::new([px[i], py[i], pz[i]].map(f64::from), unit(i));
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
                    let ray = LensRay::new([px[i], py[i], pz[i]], unit(i).map(|t| t as f32));
                    let end = trace_one(ray, &surfaces).err();
                    let end = end.or_else(|| trace_one(start(i), &exact).err());
                    status[i] = end.map_or(lens.stop(), |end| end.row) as u16 + 1;
                }
            }
        },
    );
}
