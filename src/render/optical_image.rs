//! Optical image: the light on the film after diffraction, until a sensor reads it out.

use crate::aov::half_layers;
use crate::job::Job;
use crate::plan::Effect;
use crate::sensor::Sensor;
use petzval_image::{ImageLayer, Picture};

/// Light on the film after diffraction, which the sensor has not read out yet.
#[derive(Clone, Debug)]
pub struct OpticalImage {
    /// The picture.
    pub picture: Picture,
    /// The part of its light that passed the left half of the exit pupil, if a dual pixel is simulated.
    pub left_half: Option<Picture>,
}

/// A picture that was read out.
#[derive(Clone, Debug)]
pub struct ReadPicture {
    /// The picture.
    pub picture: Picture,
    /// The layers `left` and `right` of a dual pixel, linear sRGB; empty without one.
    pub halves: Vec<ImageLayer>,
}

impl OpticalImage {
    /// Spreads the light on the film by diffraction, if that is planned: that of half a pupil by the point
    /// spread of the whole one.
    pub(crate) fn new(picture: Picture, left_half: Option<Picture>, job: &Job) -> Self {
        if !job.plan.has(Effect::Diffraction) {
            return Self { picture, left_half };
        }
        let spreads = job.point_spreads();
        let left_half = left_half.map(|half| spreads.spread(&half));
        Self { picture: spreads.spread(&picture), left_half }
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
        let Some(left) = left_half else {
            let picture = match sensor {
                Some(sensor) => sensor.read_out(picture, origin, seed),
                None => picture,
            };
            return ReadPicture { picture, halves: Vec::new() };
        };
        let right = picture.minus(&left);
        let (picture, halves) = match sensor {
            Some(sensor) => sensor.read_out_halves([left, right], origin, seed),
            None => (picture, [left, right]),
        };
        ReadPicture { picture, halves: half_layers(&halves) }
    }
}

impl ReadPicture {
    /// Puts the halves, in the colour space of the file of a job, in the place of the layers of the same names.
    /// Returns the picture.
    pub fn with_layers(mut self, job: &Job, layers: &mut [ImageLayer]) -> Picture {
        job.convert_layers(&mut self.halves);
        for half in self.halves {
            if let Some(layer) = layers.iter_mut().find(|layer| layer.name == half.name) {
                *layer = half;
            }
        }
        self.picture
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_keep_their_share_of_a_denoised_picture() {
        let picture =
            |pixels: &[[f32; 3]]| Picture { size: [pixels.len(), 1], pixels: pixels.to_vec() };
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
}
