//! Batches of film samples, and of rays inside a lens.

use bytemuck::Pod;

use super::{Column, WAVE_SIZE};
use crate::lanes::Real;
use crate::sampler::{Dimension, sample_2d};

/// Rays inside a lens; +z is the direction of travel. A blocked ray has a NaN in `x`.
#[derive(Clone, Debug)]
pub struct LensBatch<T: Pod> {
    /// Number of rays. Blocked rays pad the last packet behind them.
    pub len: usize,
    /// Number of rays that are not blocked at the start.
    pub live: usize,
    /// Position relative to the vertex of the surface last crossed, x (mm).
    pub x: Column<T>,
    /// Position, y (mm).
    pub y: Column<T>,
    /// Position, z (mm).
    pub z: Column<T>,
    /// Optical direction cosine (unit direction times refractive index), x.
    pub tx: Column<T>,
    /// Optical direction cosine, y.
    pub ty: Column<T>,
    /// Optical direction cosine, z.
    pub tz: Column<T>,
    /// Weight; changed only by apertures of partial transmission and, if losses are simulated, by
    /// surfaces and by glass that absorbs.
    pub weight: Column<T>,
    /// Positions at the surface crossed before, on the way through glass that absorbs.
    pub departure: Option<Box<[Column<T>; 3]>>,
    /// Indices of the rays that this precision cannot trace exactly enough.
    pub needs_f64: Vec<u32>,
}

impl<T: Pod> Default for LensBatch<T> {
    fn default() -> Self {
        let [x, y, z, tx, ty, tz, weight] = std::array::from_fn(|_| Column::default());
        // No ray is listed twice, so nothing is allocated inside a wave.
        let needs_f64 = Vec::with_capacity(WAVE_SIZE);
        Self { len: 0, live: 0, x, y, z, tx, ty, tz, weight, departure: None, needs_f64 }
    }
}

impl<T: Pod> LensBatch<T> {
    /// Sets the number of rays, none of them blocked, and blocks the lanes behind them up to a
    /// whole packet.
    pub fn resize<R: Real<Scalar = T>>(&mut self, rays: usize) {
        (self.len, self.live) = (rays, rays);
        for i in rays..rays.next_multiple_of(R::LANES) {
            self.x[i] = R::from_f64(f64::NAN);
        }
    }
}

impl LensBatch<f32> {
    /// Returns the sum of the weights of rays that are not blocked.
    pub fn total_weight(&self) -> f64 {
        let living = (0..self.len).filter(|&i| !self.x[i].is_nan());
        living.map(|i| f64::from(self.weight[i])).sum()
    }
}

/// Samples of the film stage for the camera, one per entry.
#[derive(Clone, Debug, Default)]
pub struct SampleBatch {
    /// Number of samples.
    pub len: usize,
    /// Index of the pixel in its tile.
    pub pixel: Column<u32>,
    /// Key of the pixel's random numbers.
    pub key: Column<u32>,
    /// Index of the sample in its pixel.
    pub sample: Column<u32>,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Point on the film [units of the film; mm for a real lens], x to the right and y up as seen
    /// from behind the camera. The image on the film is upside down.
    pub film: [Column<f32>; 2],
    /// The same point relative to the centre of its pixel, to the right and down in the picture
    /// (pixels); set only if the lens disperses light.
    pub offset: [Column<f32>; 2],
    /// Weight of the sample in its pixel; set only if the filter has negative lobes.
    pub weight: Column<f32>,
    /// Spectral band of all samples, if the lens disperses light.
    pub band: usize,
    /// Set of the wavelengths that the channels of all paths stand for, if paths carry spectra.
    pub set: usize,
    /// The channel whose wavelength alone goes on behind glass of the scene that disperses.
    pub hero: usize,
    /// Two numbers in [0, 1) that select a point of the pupil.
    pub pupil: [Column<f32>; 2],
    /// Time as a fraction of the motion in the scene file; set only if something moves
    /// (`Timing` of the renderer).
    pub time: Column<f32>,
    /// Whether the ray passes the left half of the exit pupil; set only if halves are recorded.
    pub left_half: Column<bool>,
}

impl SampleBatch {
    /// Distributes the samples evenly over a film of this half width and half height and over the
    /// pupil. Different waves get different points.
    pub fn fill_evenly(&mut self, half: [f64; 2], wave: usize) {
        for i in 0..self.len {
            let numbers = |dimension| sample_2d(0, (wave * WAVE_SIZE + i) as u32, dimension);
            let (point, pupil) = (numbers(Dimension::Film), numbers(Dimension::Pupil));
            for axis in 0..2 {
                let film = (2.0 * f64::from(point[axis]) - 1.0) * half[axis];
                (self.film[axis][i], self.pupil[axis][i]) = (film as f32, pupil[axis]);
            }
        }
    }
}

/// Points at which the light of a wave would meet the film if it were of another spectral band.
#[derive(Clone, Debug, Default)]
pub struct ReprojectionBatch {
    /// Point on the film, as in [`SampleBatch`].
    pub film: [Column<f32>; 2],
    /// Transmission of the lens; 0 if the light does not reach the film.
    pub transmission: Column<f32>,
}
