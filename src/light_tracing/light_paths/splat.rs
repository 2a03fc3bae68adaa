//! Splats: light that light paths add to pixels, in an order that no thread changes.

use std::ops::Range;
use std::time::Duration;

use rayon::prelude::*;

use super::LightPathInput;
use super::front::FrontEntry;
use crate::film::{FilmSums, PixelFilter};
use crate::lens::RealLens;
use crate::rays::WAVE_SIZE;
use crate::stats::{Stage, Stats, thread_time};

/// Most splats that wait to be added to the film: 10 MB.
const MOST_WAITING: u64 = 1 << 19;

/// A pixel of the picture and the light that is added to it.
#[derive(Clone, Copy)]
pub(crate) struct Splat {
    pub pixel: [u32; 2],
    pub light: [f32; 3],
}

/// Number of the light paths of a sample number, in whole waves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathCount {
    waves: u32,
}

impl PathCount {
    /// One path for every `samples_per_path` pixels of a picture of this width and height.
    pub fn new([width, height]: [u32; 2], samples_per_path: u64) -> Self {
        let pixels = u64::from(width) * u64::from(height);
        Self { waves: pixels.div_ceil(samples_per_path * WAVE_SIZE as u64) as u32 }
    }

    /// Returns the number of paths.
    pub fn paths(self) -> f64 {
        f64::from(self.waves) * WAVE_SIZE as f64
    }

    /// Returns the number of a wave of a sample number, given as `[wave, sample]`, among the waves of
    /// all sample numbers.
    pub fn wave_number(self, [wave, sample]: [u32; 2]) -> u32 {
        sample.wrapping_mul(self.waves).wrapping_add(wave)
    }

    /// Returns the factor from the flux of a path (radiance times mm^2 sr) to the value of the pixel
    /// that receives it.
    pub fn splat_scale(self, input: &LightPathInput<'_>) -> f64 {
        let pitch = input.camera.pixel_pitch(input.frame.resolution);
        // The film divides by the number of samples.
        input.camera.imaging_ratio / (pitch[0] * pitch[1] * self.paths())
    }
}

/// Stage that adds light paths to the film.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SplatStage {
    /// Number of light paths of a sample number.
    pub count: PathCount,
    /// Largest number of pixels that a path adds light to.
    pub splats_per_path: u64,
}

impl SplatStage {
    /// Returns the stage of a number of paths, each of which is splatted through the filter in
    /// several bands.
    pub fn filtered(count: PathCount, filter: &PixelFilter, lens: &RealLens) -> Self {
        let [columns, rows] = filter.margin().map(|margin| (2.0 * margin).ceil() as u64 + 2);
        Self { count, splats_per_path: columns * rows * FrontEntry::bands_per_path(lens) }
    }

    /// Returns the number of waves that are traced before their splats are added to the film.
    fn chunk(self) -> u32 {
        (MOST_WAITING / (self.splats_per_path * WAVE_SIZE as u64)).max(1) as u32
    }

    /// Returns the largest size of the splats that wait to be added to the film (bytes).
    pub fn bytes_waiting(self) -> u64 {
        let paths = u64::from(self.count.waves.min(self.chunk())) * WAVE_SIZE as u64;
        paths * self.splats_per_path * size_of::<Splat>() as u64
    }

    /// Adds the splats of all waves of some sample numbers to the film, in the order of the waves.
    /// `splats_of` returns the splats of a wave of a sample number, given as `[wave, sample]`; each
    /// thread has its own columns `C`.
    pub fn run<C: Default + Send>(
        self,
        input: &LightPathInput<'_>,
        samples: Range<u32>,
        film: &mut FilmSums,
        stats: &mut Stats,
        splats_of: impl Fn(&mut C, [u32; 2]) -> Vec<Splat> + Sync,
    ) {
        let (waves, chunk) = (self.count.waves, self.chunk());
        for (sample, first) in
            samples.flat_map(|sample| (0..waves).step_by(chunk as usize).map(move |i| (sample, i)))
        {
            let one = |columns: &mut C, wave| {
                if input.is_stopped() {
                    return Default::default();
                }
                let start = thread_time();
                let splats = splats_of(columns, [wave, sample]);
                (splats, thread_time().saturating_sub(start))
            };
            let traced: Vec<(Vec<Splat>, Duration)> = (first..waves.min(first + chunk))
                .into_par_iter()
                .map_init(C::default, one)
                .collect();
            let stage = &mut stats.stages[Stage::LightPaths as usize];
            for (splats, time) in traced {
                stage.time += time;
                stage.rays += WAVE_SIZE as u64;
                for Splat { pixel, light } in splats {
                    film.add_light(pixel, input.response.apply_colour(light.map(f64::from)));
                }
            }
        }
    }
}

/// Returns the position of a film point (mm) in the whole picture, in pixels from its top left.
pub(crate) fn film_pixels(input: &LightPathInput<'_>, point: [f64; 2]) -> [f64; 2] {
    let share = [0, 1].map(|i| point[i] / input.camera.film[i]);
    // The picture is mirrored in x and upside down in y, as in the film stage.
    let share = [0.5 - share[0], 0.5 + share[1]];
    [0, 1].map(|i| share[i] * f64::from(input.frame.resolution[i]))
}
