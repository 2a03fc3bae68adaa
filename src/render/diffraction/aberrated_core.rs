//! What an aberrated wavefront changes in the spread of light near its centre.
//!
//! The picture already contains the blur of the rays, with the transfer function G. The light has
//! the transfer function H of the aberrated wavefront: the correct kernel is H / G, which is F, that
//! of a flat wavefront, only if the wavefront is good or so bad that G vanishes before F falls. So
//! the kernel is
//!
//! K = (H conj(G) + e^2 F) / (|G|^2 + e^2),
//!
//! a Wiener quotient that returns to F where no light of the rays is left, and at most 1: it never
//! amplifies noise. The quotient suits points in the plane of focus. Light far from the centre comes from the edge of the pupil, whatever the wavefront.

use std::f64::consts::{PI, TAU};

use petzval_base::sinc::sinc;
use petzval_lens::FilmMap;
use rayon::prelude::*;

use super::fourier::{Complex, PlaneFft};
use petzval_lens::{ExitPupil, PupilRaster, WavefrontFit};
use petzval_spectrum::LightBand;

/// Cells along each side of the pupil.
const CELLS: usize = 64;
/// Rays along each side of a cell.
const RAYS: usize = 4;
/// Bands of light that share a wavelength.
const SHARED: usize = 4;
/// Transfer of the rays below which the flat wavefront takes over: e.
const LEAST_TRANSFER: f64 = 0.05;
/// Largest spot and widest kernel, relative to the distance at which the image of a pupil in cells
/// repeats. Larger spots are images by rays alone.
const LARGEST_SPOT: f64 = 0.25;
const WIDEST: f64 = 0.9;
/// Most samples along each side of the image.
const MOST_SAMPLES: usize = 255;
/// Width of the kernel beside the spot on each side, in fringes.
const FRINGES: f64 = 6.0;
/// Smallest root mean square path difference (waves) and radius of the spot (pixels) that count.
const LEAST_WAVES: f64 = 0.02;
const LEAST_SPOT: f64 = 1.0 / 16.0;

/// Differences of the shares of a pixel's light to those of a flat wavefront, by channel. Their sum
/// is 0.
#[derive(Clone, Debug)]
pub(super) struct AberratedCore {
    /// Columns and rows beside the centre.
    pub reach: [usize; 2],
    /// Row by row from the top.
    pub shares: Vec<[f32; 3]>,
}

impl AberratedCore {
    /// Computes the differences for a pupil, its wavefront and pixels of this width and height
    /// (um). `None` if the wavefront is good, or
    /// the spot much smaller than a pixel, or so large that rays alone make the image.
    pub fn new(
        pupil: &ExitPupil,
        wavefront: &WavefrontFit,
        light: &[LightBand],
        pitch: [f64; 2],
    ) -> Option<Self> {
        let width = pupil.width(0.0).max(pupil.width(PI / 2.0));
        let rays = PupilRays::new(pupil, wavefront, width);
        let waves: Vec<LightBand> = light.chunks(SHARED).map(mean_band).collect();
        let shortest =
            waves.iter().map(|band| band.wavelength).fold(f64::INFINITY, f64::min) * 1e-3;
        let fringe = shortest / width;
        let repeat = CELLS as f64 * fringe;
        let spot = rays.radius();
        let least = pitch[0].min(pitch[1]);
        if rays.rms() < LEAST_WAVES * shortest
            || spot < LEAST_SPOT * least
            || spot > LARGEST_SPOT * repeat
        {
            return None;
        }
        // Odd numbers of pixels, and of samples per pixel, so that a sample lies in the middle.
        let reach = pitch.map(|pitch| ((spot + FRINGES * fringe) / pitch).ceil() as usize);
        let samples = pitch.map(|pitch| ((2.0 * pitch / fringe).ceil() as usize) | 1);
        let reach = [0, 1].map(|i| {
            let widest = (WIDEST * repeat / pitch[i] / 2.0) as usize;
            reach[i].min(widest).min(MOST_SAMPLES / samples[i] / 2)
        });
        if reach.contains(&0) {
            return None;
        }
        let side = [0, 1].map(|i| (2 * reach[i] + 1) * samples[i]);
        let step = [0, 1].map(|i| pitch[i] / samples[i] as f64);
        let plane = PlaneFft::new(side);
        let geometric = plane.transform(&rays.image(side, step), side);
        let images: Vec<[Vec<f64>; 2]> = waves
            .par_iter()
            .map(|band| {
                [true, false].map(|flat| rays.wave_image(band.wavelength, side, step, flat))
            })
            .collect();
        let mut shares = vec![[0.0; 3]; (2 * reach[0] + 1) * (2 * reach[1] + 1)];
        for channel in 0..3 {
            let total: f64 = waves.iter().map(|band| band.response[channel]).sum();
            let [flat, real] = [0, 1].map(|kind| {
                let mut sum = vec![0.0; side[0] * side[1]];
                for (band, images) in waves.iter().zip(&images) {
                    let weight = band.response[channel] / total;
                    sum.iter_mut().zip(&images[kind]).for_each(|(sum, v)| *sum += weight * v);
                }
                plane.transform(&sum, side)
            });
            let [columns, rows] = plane.size;
            let mut change = flat.clone();
            for (i, change) in change.iter_mut().enumerate() {
                // Rays were shared among four samples each.
                let tent = sinc((i / rows) as f64 / columns as f64)
                    * sinc(wrapped(i % rows, rows) / rows as f64);
                let g = geometric[i] / (tent * tent);
                let least = LEAST_TRANSFER * LEAST_TRANSFER;
                let kernel = (real[i] * g.conj() + flat[i] * least) / (g.norm_sqr() + least);
                *change = kernel / kernel.norm().max(1.0) - flat[i];
            }
            change[0] = Complex::default();
            let mut differences = vec![0.0; columns * rows];
            plane.inverse_rows(change, &mut differences, columns, |row, into| {
                into.copy_from_slice(row);
            });
            for (i, share) in shares.iter_mut().enumerate() {
                let at = [i % (2 * reach[0] + 1), i / (2 * reach[0] + 1)];
                let first = [0, 1].map(|axis| {
                    let offset = at[axis] as isize - reach[axis] as isize;
                    isize::from(FilmMap::DIRECTIONS[axis]) * offset
                });
                let mut sum = 0.0;
                for k in 0..samples[0] * samples[1] {
                    let part = [k % samples[0], k / samples[0]];
                    let place = |axis: usize| {
                        let along = first[axis] * samples[axis] as isize + part[axis] as isize
                            - samples[axis] as isize / 2;
                        along.rem_euclid(plane.size[axis] as isize) as usize
                    };
                    sum += differences[place(1) * columns + place(0)];
                }
                share[channel] = sum as f32;
            }
        }
        Some(Self { reach, shares })
    }

    /// Returns the differences, by channel, for the pixel at this offset to the right and below.
    pub fn at(&self, offset: [isize; 2]) -> [f32; 3] {
        if (0..2).any(|i| offset[i].unsigned_abs() > self.reach[i]) {
            return [0.0; 3];
        }
        let [x, y] = [0, 1].map(|i| (offset[i] + self.reach[i] as isize) as usize);
        self.shares[y * (2 * self.reach[0] + 1) + x]
    }

    /// Returns the sum of the differences at the offsets from which light comes to a pixel with
    /// this many pixels of the picture before it and after it, along each axis.
    pub fn change_within(&self, channel: usize, before: [usize; 2], after: [usize; 2]) -> f64 {
        if (0..2).all(|i| before[i].min(after[i]) >= self.reach[i]) {
            return 0.0;
        }
        let range = |i: usize| {
            -(after[i].min(self.reach[i]) as isize)..=before[i].min(self.reach[i]) as isize
        };
        let row =
            |y: isize| range(0).map(move |x| f64::from(self.at([x, y])[channel])).sum::<f64>();
        range(1).map(row).sum()
    }
}

impl PlaneFft<f64> {
    /// Returns the transform of an image of odd width and height about its middle.
    fn transform(&self, image: &[f64], side: [usize; 2]) -> Vec<Complex<f64>> {
        let [columns, rows] = self.size;
        self.spectrum(rows, |y, row| {
            let y = (y + side[1] / 2) % rows;
            if y >= side[1] {
                return false;
            }
            for (x, value) in image[y * side[0]..(y + 1) * side[0]].iter().enumerate() {
                row[(x + columns - side[0] / 2) % columns] = *value;
            }
            true
        })
    }
}

/// Rays through a grid of pupil points.
struct PupilRays {
    /// Distance of neighbouring points in T.
    step: f64,
    /// T of the first point.
    first: [f64; 2],
    /// Amplitude, path difference (um) and place on the film (um), row by row.
    points: Vec<PupilRay>,
}

#[derive(Clone, Copy)]
struct PupilRay {
    amplitude: f64,
    path: f64,
    place: [f64; 2],
}

impl PupilRays {
    /// Traces the rays of a pupil relative to the centre of their spot.
    fn new(pupil: &ExitPupil, wavefront: &WavefrontFit, width: f64) -> Self {
        let side = CELLS * RAYS;
        let step = width / side as f64;
        let centre = pupil.centre();
        let first = centre.map(|c| c - step * (side as f64 - 1.0) / 2.0);
        let amplitudes = pupil.raster(PupilRaster { first, step, side });
        let direction =
            |i: usize| [first[0] + step * (i % side) as f64, first[1] + step * (i / side) as f64];
        let mut points: Vec<PupilRay> = amplitudes
            .into_iter()
            .enumerate()
            .map(|(i, amplitude)| {
                if amplitude == 0.0 {
                    return PupilRay { amplitude, path: 0.0, place: [0.0; 2] };
                }
                let (path, place) = wavefront.at(direction(i));
                PupilRay { amplitude, path: 1e3 * path, place: place.map(|v| 1e3 * v) }
            })
            .collect();
        let light: f64 = points.iter().map(|point| point.amplitude.powi(2)).sum();
        let middle = [0, 1].map(|axis| {
            let places = points.iter().map(|point| point.amplitude.powi(2) * point.place[axis]);
            places.sum::<f64>() / light
        });
        for (i, point) in points.iter_mut().enumerate().filter(|(_, point)| point.amplitude > 0.0) {
            let t = direction(i);
            point.path -= (0..2).map(|axis| middle[axis] * (t[axis] - centre[axis])).sum::<f64>();
            point.place = [0, 1].map(|axis| point.place[axis] - middle[axis]);
        }
        Self { step, first, points }
    }

    fn open(&self) -> impl Iterator<Item = &PupilRay> {
        self.points.iter().filter(|point| point.amplitude > 0.0)
    }

    /// Returns the radius around all rays on the film (um).
    fn radius(&self) -> f64 {
        self.open().map(|point| point.place[0].hypot(point.place[1])).fold(0.0, f64::max)
    }

    /// Returns the root mean square path difference (um).
    fn rms(&self) -> f64 {
        let light: f64 = self.open().map(|point| point.amplitude.powi(2)).sum();
        let moment = |power: i32| {
            let terms = self.open().map(|point| point.amplitude.powi(2) * point.path.powi(power));
            terms.sum::<f64>() / light
        };
        (moment(2) - moment(1).powi(2)).max(0.0).sqrt()
    }

    /// Returns the light of the rays on a grid of samples about their centroid, each shared by the
    /// four samples around it. Its sum is 1.
    fn image(&self, side: [usize; 2], step: [f64; 2]) -> Vec<f64> {
        let mut image = vec![0.0; side[0] * side[1]];
        let light: f64 = self.open().map(|point| point.amplitude.powi(2)).sum();
        for point in self.open() {
            let own = point.amplitude.powi(2) / light;
            let place = [0, 1].map(|i| point.place[i] / step[i] + (side[i] / 2) as f64);
            let low = [0, 1].map(|i| place[i].floor().clamp(0.0, side[i] as f64 - 2.0));
            let part = [0, 1].map(|i| (place[i] - low[i]).clamp(0.0, 1.0));
            let corner = low[1] as usize * side[0] + low[0] as usize;
            for (dy, y) in [1.0 - part[1], part[1]].into_iter().enumerate() {
                for (dx, x) in [1.0 - part[0], part[0]].into_iter().enumerate() {
                    image[corner + dy * side[0] + dx] += own * x * y;
                }
            }
        }
        image
    }

    /// Returns the light of a wavelength (nm) on the same samples, as diffracted by this wavefront
    /// or by a flat one: the sum of the plane waves of all cells, as a product of three matrices
    /// (Soummer et al. 2007).
    fn wave_image(&self, nm: f64, side: [usize; 2], step: [f64; 2], flat: bool) -> Vec<f64> {
        let wave_number = TAU / (nm * 1e-3);
        let fine = CELLS * RAYS;
        let mut cells = vec![Complex::default(); CELLS * CELLS];
        for (i, point) in self.points.iter().enumerate().filter(|(_, p)| p.amplitude > 0.0) {
            let phase = if flat { 0.0 } else { wave_number * point.path };
            let cell = (i / fine / RAYS) * CELLS + (i % fine) / RAYS;
            cells[cell] += Complex::from_polar(point.amplitude / (RAYS * RAYS) as f64, phase);
        }
        let light: f64 =
            self.open().map(|p| p.amplitude.powi(2)).sum::<f64>() / (RAYS * RAYS) as f64;
        let cell_step = self.step * RAYS as f64;
        let waves = |axis: usize| -> Vec<Complex<f64>> {
            let first = self.first[axis] + self.step * (RAYS as f64 - 1.0) / 2.0;
            (0..side[axis] * CELLS)
                .map(|i| {
                    let place = step[axis] * ((i / CELLS) as f64 - (side[axis] / 2) as f64);
                    let t = first + cell_step * (i % CELLS) as f64;
                    Complex::from_polar(1.0, -wave_number * t * place)
                })
                .collect()
        };
        let (by_x, by_y) = (waves(0), waves(1));
        let inner = |a: &[Complex<f64>], b: &[Complex<f64>]| -> Complex<f64> {
            a.iter().zip(b).map(|(a, b)| a * b).sum()
        };
        let mut half = vec![Complex::default(); side[0] * CELLS];
        for (row, cells) in cells.chunks_exact(CELLS).enumerate() {
            for (x, waves) in by_x.chunks_exact(CELLS).enumerate() {
                half[x * CELLS + row] = inner(cells, waves);
            }
        }
        let share = cell_step * cell_step * step[0] * step[1] / ((nm * 1e-3).powi(2) * light);
        let columns = || half.chunks_exact(CELLS);
        by_y.chunks_exact(CELLS)
            .flat_map(|waves| columns().map(|column| share * inner(column, waves).norm_sqr()))
            .collect()
    }
}

/// Returns the mean of several bands.
fn mean_band(bands: &[LightBand]) -> LightBand {
    let count = bands.len() as f64;
    LightBand {
        wavelength: bands.iter().map(|band| band.wavelength).sum::<f64>() / count,
        response: [0, 1, 2].map(|c| bands.iter().map(|band| band.response[c]).sum::<f64>()),
    }
}

/// Returns a frequency with its sign.
fn wrapped(i: usize, count: usize) -> f64 {
    if 2 * i > count { i as f64 - count as f64 } else { i as f64 }
}
