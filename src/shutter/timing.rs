//! Times of samples.

use super::{RollingShutter, Shutter, ShutterCurve};
use crate::film::{Frame, Tile};
use crate::motion::Motion;
use crate::rays::SampleBatch;
use crate::sampler::{Dimension, fill_1d};

/// The times of samples, relative to the motion that the scene file describes: 0 at its start, 1 at
/// its end (`TransformTimes`).
///
/// As in pbrt, objects rest before the start and after the end. If they still move when the shutter
/// closes, they continue at the same rate for sensor rows that are read later.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// When the shutter opens.
    open: f64,
    /// How long it is open.
    duration: f64,
    /// Distribution of the samples over the exposure; `None` takes all of them in its middle.
    curve: Option<ShutterCurve>,
    readout: Option<Readout>,
    /// Time after which everything rests.
    end: f64,
    /// Motion of the camera, if it moves: from the world space of the camera at rest in the middle
    /// of the exposure to that of the moving camera.
    pub camera_motion: Option<Motion>,
}

/// Readout of a rolling shutter.
#[derive(Clone, Debug, PartialEq)]
struct Readout {
    shutter: RollingShutter,
    /// Time from the first row to the last.
    duration: f64,
}

/// The effects of a shutter that are simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimingEffects {
    /// Whether samples are distributed over the exposure by the shutter's transmission; otherwise
    /// all are taken in its middle.
    pub motion_blur: bool,
    /// Whether rows are read one after another if the shutter says so; otherwise all with the
    /// first.
    pub rolling_shutter: bool,
}

impl TimingEffects {
    /// All effects.
    pub const ALL: Self = Self { motion_blur: true, rolling_shutter: true };
}

impl Timing {
    /// Returns the timing of a shutter and a motion from `start` to `end`, s.
    ///
    /// # Errors
    /// Returns an error if the shutter takes longer to open and close than it is open.
    pub fn new(
        shutter: &Shutter,
        [start, end]: [f64; 2],
        effects: TimingEffects,
    ) -> Result<Self, String> {
        let curve = shutter.curve()?;
        let per_second = 1.0 / (end - start);
        let rolling =
            shutter.rolling.filter(|rolling| effects.rolling_shutter && rolling.time > 0.0);
        let readout = |rolling: RollingShutter| Readout {
            shutter: rolling,
            duration: rolling.time * per_second,
        };
        Ok(Self {
            open: (shutter.open - start) * per_second,
            duration: shutter.time() * per_second,
            curve: effects.motion_blur.then_some(curve),
            readout: rolling.map(readout),
            end: if shutter.close <= end { f64::INFINITY } else { 1.0 },
            camera_motion: None,
        })
    }

    /// Returns the middle of the exposure of the first row.
    pub fn first_row_middle(&self) -> f64 {
        self.clamp(self.open + 0.5 * self.duration)
    }

    /// Returns the middle of the exposure of the last row.
    pub fn last_row_middle(&self) -> f64 {
        self.clamp(self.open + 0.5 * self.duration + self.readout_duration())
    }

    /// Returns the first and the last time of any sample of the picture.
    pub fn range(&self) -> [f64; 2] {
        match self.curve {
            Some(_) => [self.open, self.open + self.duration + self.readout_duration()]
                .map(|t| self.clamp(t)),
            None => [self.first_row_middle(), self.last_row_middle()],
        }
    }

    /// Returns when the exposure of the first row begins and ends.
    pub fn first_row_range(&self) -> [f64; 2] {
        [self.open, self.open + self.duration].map(|t| self.clamp(t))
    }

    fn readout_duration(&self) -> f64 {
        self.readout.as_ref().map_or(0.0, |readout| readout.duration)
    }

    #[inline(always)]
    fn clamp(&self, time: f64) -> f64 {
        time.max(0.0).min(self.end)
    }

    /// Returns a sample time of the first row, from a random number in [0, 1).
    pub fn first_row_time(&self, u: f32) -> f32 {
        let place = self.curve.as_ref().map_or(0.5, |curve| curve.sample_time(f64::from(u)));
        self.clamp(self.duration.mul_add(place, self.open)) as f32
    }

    /// Assigns their times to the samples of a wave: a stage.
    pub fn assign_times(&self, tile: &Tile, frame: &Frame, samples: &mut SampleBatch) {
        let len = samples.len;
        let SampleBatch { key, sample, pixel, time, .. } = samples;
        if let Some(curve) = &self.curve {
            fill_1d(&key[..len], &sample[..len], Dimension::Time, &mut time[..]);
            if !curve.is_ideal() {
                for time in &mut time[..len] {
                    *time = curve.sample_time(f64::from(*time)) as f32;
                }
            }
        } else {
            time[..len].fill(0.5);
        }
        for i in 0..len {
            let mut when = self.duration.mul_add(f64::from(time[i]), self.open);
            if let Some(Readout { shutter, duration }) = &self.readout {
                when += duration * shutter.readout_fraction(tile.pixel(pixel[i]), frame.resolution);
            }
            time[i] = self.clamp(when) as f32;
        }
    }
}
