//! When samples are taken: a stage.

use super::{Efficiency, Rolling, Shutter};
use crate::film::{Frame, Tile};
use crate::motion::Motion;
use crate::rays::SampleBatch;
use crate::sampler::{Dimension, firsts};

/// The times of samples, as shares of the motion that the scene file describes: 0 at its start,
/// 1 at its end (`TransformTimes`).
///
/// Before its start and after its end things stand still, as in pbrt. Only what still moves when
/// the shutter closes goes on at the same rate for the rows of a sensor that are read later.
#[derive(Clone, Debug, PartialEq)]
pub struct Timing {
    /// When the shutter opens, and how long it is open.
    open: f64,
    lasts: f64,
    /// When in between; all samples are taken in the middle where there is none.
    efficiency: Option<Efficiency>,
    /// How rows are read, and how long after the first the last is.
    rolling: Option<(Rolling, f64)>,
    /// When everything has come to where it stays.
    end: f64,
    /// World space of a camera at rest, in the middle of the exposure, to that of one that moves;
    /// where it does.
    pub ride: Option<Motion>,
}

impl Timing {
    /// Of a shutter and a motion from one time to another, s. `blur`: samples are taken while the
    /// shutter is open, by its efficiency; else in the middle of that time. `rolls`: rows are read
    /// one after another, if the shutter says so; else all with the first.
    ///
    /// # Errors
    /// Where the shutter takes longer to open and close than it is open.
    pub fn new(
        shutter: &Shutter,
        [start, end]: [f64; 2],
        blur: bool,
        rolls: bool,
    ) -> Result<Self, String> {
        let efficiency = shutter.efficiency()?;
        let per_second = 1.0 / (end - start);
        let read = |rolling: Rolling| (rolling, rolling.time * per_second);
        Ok(Self {
            open: (shutter.open - start) * per_second,
            lasts: shutter.time() * per_second,
            efficiency: blur.then_some(efficiency),
            rolling: shutter.rolling.filter(|rolling| rolls && rolling.time > 0.0).map(read),
            end: if shutter.close <= end { f64::INFINITY } else { 1.0 },
            ride: None,
        })
    }

    /// The middle of the exposure of the first row.
    pub fn middle(&self) -> f64 {
        self.within(self.open + 0.5 * self.lasts)
    }

    /// The middle of the exposure of the last row.
    pub fn last_middle(&self) -> f64 {
        self.within(self.open + 0.5 * self.lasts + self.reading())
    }

    /// When the first light of the picture comes, and the last.
    pub fn range(&self) -> [f64; 2] {
        match self.efficiency {
            Some(_) => [self.open, self.open + self.lasts + self.reading()].map(|t| self.within(t)),
            None => [self.middle(), self.last_middle()],
        }
    }

    /// When the first light of the first row comes, and the last.
    pub fn exposure(&self) -> [f64; 2] {
        [self.open, self.open + self.lasts].map(|t| self.within(t))
    }

    fn reading(&self) -> f64 {
        self.rolling.map_or(0.0, |(_, reading)| reading)
    }

    #[inline(always)]
    fn within(&self, time: f64) -> f64 {
        time.max(0.0).min(self.end)
    }

    /// When light comes to the first row, by a random number from 0 to 1.
    pub fn moment(&self, u: f32) -> f32 {
        let place = self.efficiency.as_ref().map_or(0.5, |curve| curve.when(f64::from(u)));
        self.within(self.lasts.mul_add(place, self.open)) as f32
    }

    /// Tells when the samples of a wave are taken: a stage.
    pub fn tell(&self, tile: &Tile, frame: &Frame, samples: &mut SampleBatch) {
        let len = samples.len;
        let SampleBatch { key, sample, pixel, time, .. } = samples;
        if let Some(efficiency) = &self.efficiency {
            firsts(&key[..len], &sample[..len], Dimension::Time, &mut time[..]);
            if !efficiency.is_ideal() {
                for time in &mut time[..len] {
                    *time = efficiency.when(f64::from(*time)) as f32;
                }
            }
        } else {
            time[..len].fill(0.5);
        }
        for i in 0..len {
            let mut when = self.lasts.mul_add(f64::from(time[i]), self.open);
            if let Some((rolling, reading)) = &self.rolling {
                when += reading * rolling.turn(tile.pixel(pixel[i]), frame.resolution);
            }
            time[i] = self.within(when) as f32;
        }
    }
}
