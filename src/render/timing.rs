//! Times of samples.

use crate::film::{Frame, Tile};
use petzval_base::rays::SampleBatch;
use petzval_base::sampler::{Dimension, fill_1d};
use petzval_scene::motion::Motion;
use petzval_scene::shutter::{RollingShutter, Shutter, ShutterCurve};

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

/// A time at which a light path arrives on the film, in whichever row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ArrivalTime {
    /// Time of the scene, as a fraction of its motion.
    pub scene: f32,
    /// Time since the first row was opened, as a fraction of its exposure.
    since_opening: f32,
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

    /// Returns when the exposure of a pixel begins and ends.
    pub fn exposure_of(&self, pixel: [u32; 2], resolution: [u32; 2]) -> [f64; 2] {
        let delay = self.readout.as_ref().map_or(0.0, |Readout { shutter, duration }| {
            duration * shutter.readout_fraction(pixel, resolution)
        });
        [0.0, self.duration].map(|since| self.clamp(self.open + delay + since))
    }

    fn readout_duration(&self) -> f64 {
        self.readout.as_ref().map_or(0.0, |readout| readout.duration)
    }

    #[inline(always)]
    fn clamp(&self, time: f64) -> f64 {
        time.max(0.0).min(self.end)
    }

    /// Returns whether rows are read one after another, each at a single time.
    pub fn rows_are_instants(&self) -> bool {
        self.readout.is_some() && self.curve.is_none()
    }

    /// Returns the time at which a light path arrives, from a random number in [0, 1): distributed as
    /// the samples of all rows are, or uniform over the whole readout of a rolling shutter. If rows are
    /// instants, it is the time of the first.
    pub fn arrival_time(&self, u: f32) -> ArrivalTime {
        let u = f64::from(u);
        let place = match (&self.curve, &self.readout) {
            (None, _) => 0.5,
            (Some(curve), None) => curve.sample_time(u),
            (Some(_), Some(readout)) => u * (1.0 + readout.duration / self.duration),
        };
        let scene = self.clamp(self.duration.mul_add(place, self.open)) as f32;
        ArrivalTime { scene, since_opening: place as f32 }
    }

    /// Returns the density with which the row of a pixel samples a time, relative to that with which
    /// [`Self::arrival_time`] does. It is 0 where the row is not exposed then, and 1 without a rolling
    /// shutter.
    pub fn row_exposure(&self, time: ArrivalTime, pixel: [u32; 2], resolution: [u32; 2]) -> f64 {
        let (Some(curve), Some(Readout { shutter, duration })) = (&self.curve, &self.readout)
        else {
            return 1.0;
        };
        let delay = duration / self.duration;
        let row = delay * shutter.readout_fraction(pixel, resolution);
        let transmission = curve.transmission(f64::from(time.since_opening) - row);
        (1.0 + delay) * transmission / curve.efficiency()
    }

    /// Returns the mean of [`Self::row_exposure`] over the exposure of an ideal shutter.
    pub fn mean_row_exposure(&self) -> f64 {
        match (&self.curve, &self.readout) {
            (Some(_), Some(readout)) => 1.0 + readout.duration / self.duration,
            _ => 1.0,
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_scene::shutter::{Curtain, ReadoutDirection};

    /// Returns a shutter that is open from 0.2 to 0.6 s, with a readout of 0.3 s.
    fn timing(curtain: Curtain, readout: f64) -> Timing {
        let rolling = RollingShutter { time: readout, direction: ReadoutDirection::Down };
        let shutter = Shutter { open: 0.2, close: 0.6, curtain, rolling: Some(rolling) };
        Timing::new(&shutter, [0.0, 1.0], TimingEffects::ALL).expect("a sound shutter")
    }

    #[test]
    fn arrivals_weighted_by_the_exposure_of_a_row_are_distributed_as_its_samples() {
        const COUNT: u32 = 100_000;
        let ramps = Curtain::Ramps { opening: 0.1, closing: 0.2 };
        for (curtain, readout) in
            [(Curtain::Ideal, 0.3), (ramps.clone(), 0.3), (ramps.clone(), 5.0), (ramps, 0.0)]
        {
            let timing = timing(curtain, readout);
            for row in [0, 1, 7, 9] {
                // Moments of the time: of all arrivals, and of the samples of the row.
                let (mut found, mut expected) = ([0.0; 3], [0.0; 3]);
                let delay = readout * f64::from(row) / 9.0;
                for i in 0..COUNT {
                    let u = (f64::from(i) + 0.5) / f64::from(COUNT);
                    let arrival = timing.arrival_time(u as f32);
                    let weight = timing.row_exposure(arrival, [3, row], [5, 10]);
                    let curve = timing.curve.as_ref().expect("a curve");
                    let sampled = 0.2 + 0.4 * curve.sample_time(u) + delay;
                    for power in 0..3 {
                        let power_of = |t: f64| (t - delay).powi(power as i32) / f64::from(COUNT);
                        found[power] +=
                            weight * power_of(0.2 + 0.4 * f64::from(arrival.since_opening));
                        expected[power] += power_of(sampled);
                    }
                }
                for (found, expected) in found.into_iter().zip(expected) {
                    assert!(
                        (found / expected - 1.0).abs() < 1e-3,
                        "{readout} {row}: {found} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_row_is_exposed_after_those_above_it() {
        let timing = timing(Curtain::Ideal, 0.3);
        for (row, delay) in [(0, 0.0), (3, 0.1), (9, 0.3)] {
            let [from, to] = timing.exposure_of([2, row], [5, 10]);
            assert!((from - (0.2 + delay)).abs() < 1e-12 && (to - (0.6 + delay)).abs() < 1e-12);
        }
    }

    #[test]
    fn arrivals_after_the_motion_see_the_scene_at_its_end() {
        let shutter = Shutter { open: 0.5, close: 1.5, ..Shutter::default() };
        let timing =
            Timing::new(&shutter, [0.0, 1.0], TimingEffects::ALL).expect("a sound shutter");
        assert_eq!([0.25, 0.9].map(|u| timing.arrival_time(u).scene), [0.75, 1.0]);
    }
}
