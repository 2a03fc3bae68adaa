//! Optical image: the light on the film after diffraction, until a sensor reads it out.

use crate::aov::half_layers;
use crate::film::FilmSums;
use crate::job::Job;
use crate::plan::Effect;
use crate::sensor::Sensor;
use petzval_image::{ImageLayer, Picture};

/// Light on the film after diffraction, which the sensor has not read out yet.
#[derive(Clone, Debug)]
pub struct OpticalImage {
    picture: Picture,
    /// The part of its light that passed the left half of the exit pupil, if a dual pixel is simulated.
    left_half: Option<Picture>,
}

/// A picture that was read out.
#[derive(Clone, Debug)]
pub struct ReadPicture {
    /// The picture.
    pub picture: Picture,
    /// The layers `left` and `right` of a dual pixel, linear sRGB; empty without one.
    pub halves: Vec<ImageLayer>,
}

impl From<Picture> for OpticalImage {
    /// Takes a picture of all light.
    fn from(picture: Picture) -> Self {
        Self { picture, left_half: None }
    }
}

impl OpticalImage {
    /// Returns the light of a film of so many samples a pixel, before diffraction.
    pub(crate) fn of_film(film: &FilmSums, samples: u32) -> Self {
        Self { picture: film.picture(samples), left_half: film.left_half(samples) }
    }

    /// Returns the same as [`Self::of_film`], in less memory.
    pub(crate) fn from_film(film: FilmSums, samples: u32) -> Self {
        let left_half = film.left_half(samples);
        Self { picture: film.into_picture(samples), left_half }
    }

    /// Spreads the light by diffraction, if that is planned: that of half a pupil by the point spread of the
    /// whole one.
    pub(crate) fn diffracted(self, job: &Job) -> Self {
        if !job.plan.has(Effect::Diffraction) {
            return self;
        }
        let spreads = job.point_spreads();
        Self {
            picture: spreads.spread(&self.picture),
            left_half: self.left_half.map(|half| spreads.spread(&half)),
        }
    }

    /// Returns the picture of all light.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// Returns the image with another picture of the same light, such as a denoised one. In each pixel and
    /// channel, the left half keeps its share.
    #[must_use]
    pub fn with_picture(self, picture: Picture) -> Self {
        let left_half = self.left_half.map(|mut half| {
            let known = self.picture.pixels.iter().zip(&picture.pixels);
            for (left, (old, new)) in half.pixels.iter_mut().zip(known) {
                *left = [0, 1, 2].map(|c| match old[c] > 0.0 {
                    true => left[c] / old[c] * new[c],
                    false => 0.5 * new[c],
                });
            }
            half
        });
        Self { picture, left_half }
    }

    /// Reads the image out by the sensor of a job; without one, the light is the picture.
    pub fn read_out(self, job: &Job) -> ReadPicture {
        self.read_out_by(job.sensor.as_ref(), job.frame.low, job.seed)
    }

    /// Reads the image out by a sensor. `origin` is the position of its first pixel in its frame.
    pub fn read_out_by(self, sensor: Option<&Sensor>, origin: [u32; 2], seed: u32) -> ReadPicture {
        let Self { picture, left_half } = self;
        let Some(mut left) = left_half else {
            let picture = match sensor {
                Some(sensor) => sensor.read_out(picture, origin, seed),
                None => picture,
            };
            return ReadPicture { picture, halves: Vec::new() };
        };
        if sensor.is_some() {
            // Filters with negative weights may leave light below 0 in one half. A photodiode has none, and the sum of
            // both is that of the picture.
            for (left, whole) in left.pixels.iter_mut().zip(&picture.pixels) {
                *left = [0, 1, 2].map(|c| left[c].clamp(0.0, whole[c].max(0.0)));
            }
        }
        let mut right = picture.clone();
        for (right, left) in right.pixels.iter_mut().zip(&left.pixels) {
            *right = [0, 1, 2].map(|c| right[c] - left[c]);
        }
        let (picture, halves) = match sensor {
            Some(sensor) => {
                drop(picture);
                sensor.read_out_halves([left, right], origin, seed)
            }
            None => (picture, [left, right]),
        };
        let mosaic = sensor.is_some_and(|sensor| sensor.bayer.is_some());
        ReadPicture { picture, halves: half_layers(&halves, mosaic) }
    }
}

impl ReadPicture {
    /// Adds the halves, in the colour space of the file of a job, to its layers. Returns the picture.
    pub fn into_picture(mut self, job: &Job, layers: &mut Vec<ImageLayer>) -> Picture {
        job.convert_layers(&mut self.halves);
        layers.append(&mut self.halves);
        self.picture
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(pixels: &[[f32; 3]]) -> Picture {
        Picture { size: [pixels.len(), 1], pixels: pixels.to_vec() }
    }

    #[test]
    fn halves_keep_their_share_of_a_denoised_picture() {
        let image = OpticalImage {
            picture: picture(&[[1.0, 2.0, 0.0], [4.0, 0.5, 8.0]]),
            left_half: Some(picture(&[[0.25, 1.0, 0.0], [4.0, 0.0, 2.0]])),
        };
        let clean = picture(&[[2.0, 2.0, 3.0], [1.0, 1.0, 1.0]]);
        let OpticalImage { picture: found, left_half } = image.with_picture(clean.clone());
        assert_eq!(found, clean);
        let expected = picture(&[[0.5, 1.0, 1.5], [1.0, 0.0, 0.25]]);
        assert_eq!(left_half, Some(expected));
    }

    #[test]
    fn a_half_below_zero_leaves_the_sum_of_both_as_it_is() {
        let sensor = "iso=100,well=1e9,read=0,bits=16".parse::<crate::sensor::SensorSettings>();
        let sensor = sensor.expect("a sensor").sensor(100.0, 1.0, 0.0);
        let image = OpticalImage {
            picture: picture(&[[0.5, 0.5, 0.5]]),
            left_half: Some(picture(&[[-0.25, 0.75, 0.25]])),
        };
        let ReadPicture { picture: found, halves } = image.read_out_by(Some(&sensor), [0, 0], 1);
        assert!(found.pixels[0].iter().all(|value| (value - 0.5).abs() < 1e-4), "{found:?}");
        let expected = [[0.0, 0.5, 0.25], [0.5, 0.0, 0.25]];
        for (half, expected) in halves.iter().zip(expected) {
            for (channel, expected) in half.channels.iter().zip(expected) {
                assert!((channel.1[0] - expected).abs() < 1e-4, "{half:?}");
            }
        }
    }
}
