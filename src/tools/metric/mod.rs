//! Image error metrics: MSE, relMSE, MAPE, FLIP and PSNR.

mod flip;

pub use flip::{HdrFlip, flip_hdr, flip_ldr, pixels_per_degree};

use std::str::FromStr;

use petzval_image::{Picture, srgb_encode};

/// A measure of the difference of two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Metric {
    /// Mean squared difference over pixels and channels, of linear light.
    Mse,
    /// The same, each difference relative to the reference squared plus 0.01 (Rousselle, Knaus &
    /// Zwicker 2011, "Adaptive sampling and reconstruction using greedy error minimization", sec.
    /// 6).
    RelMse,
    /// Mean absolute difference, each relative to the reference plus 0.01.
    Mape,
    /// Difference that an observer notices when the pictures alternate, from 0 to 1
    /// (Andersson et al. 2020, "FLIP: A difference evaluator for alternating images", and 2021,
    /// "Visualizing errors in rendered high dynamic range images").
    Flip,
    /// 10 log10 (1 / MSE) of the pictures as displayed, in sRGB and clipped at white (dB).
    Psnr,
}

impl Metric {
    /// All metrics.
    pub const ALL: [Self; 5] = [Self::Mse, Self::RelMse, Self::Mape, Self::Flip, Self::Psnr];

    /// Returns the name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mse => "mse",
            Self::RelMse => "relmse",
            Self::Mape => "mape",
            Self::Flip => "flip",
            Self::Psnr => "psnr",
        }
    }

    /// Returns whether a larger value means a smaller difference.
    pub fn higher_is_better(self) -> bool {
        self == Self::Psnr
    }
}

impl FromStr for Metric {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|metric| metric.name() == name).ok_or_else(|| {
            let known = Self::ALL.map(Self::name).join(", ");
            format!("no metric \"{name}\"; expected one of {known}")
        })
    }
}

/// Range of the light in a pair of pictures, for [`Metric::Flip`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DynamicRange {
    /// A display shows both pictures as they are: linear light from 0 to 1.
    Low,
    /// Either picture exceeds a display, so they are compared at several exposures.
    High,
}

/// The difference of two pictures by a metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// The metric over the whole picture.
    pub value: f64,
    /// The metric per pixel, row after row; the squared difference for [`Metric::Psnr`].
    pub map: Vec<f32>,
}

/// Pictures of different sizes, which no metric compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the picture has {} x {} pixels and the reference {} x {}; expected pictures of one size",
    .picture[0], .picture[1], .reference[0], .reference[1]
)]
pub struct SizeMismatch {
    /// Width and height of the picture (pixels).
    pub picture: [usize; 2],
    /// Width and height of the reference (pixels).
    pub reference: [usize; 2],
}

/// Keeps relative differences of dark pixels finite.
const FLOOR: f64 = 0.01;

/// Measures how far a picture is from a reference of the same size.
///
/// # Errors
/// Returns an error if the sizes differ.
pub fn measure(
    metric: Metric,
    picture: &Picture,
    reference: &Picture,
    range: DynamicRange,
) -> Result<Measurement, SizeMismatch> {
    if picture.size != reference.size {
        return Err(SizeMismatch { picture: picture.size, reference: reference.size });
    }
    if metric == Metric::Flip {
        let map = match range {
            DynamicRange::High => flip_hdr(picture, reference, pixels_per_degree()).map,
            DynamicRange::Low => flip_ldr(picture, reference, pixels_per_degree()),
        };
        return Ok(Measurement { value: mean(&map), map });
    }
    let error = |a: f32, b: f32| {
        let (a, b) = match metric {
            Metric::Psnr => (displayed(a), displayed(b)),
            _ => (f64::from(a), f64::from(b)),
        };
        let difference = a - b;
        match metric {
            Metric::RelMse => difference * difference / (b * b + FLOOR),
            Metric::Mape => difference.abs() / (b.abs() + FLOOR),
            _ => difference * difference,
        }
    };
    let mut sum = 0.0;
    let pixels = picture.pixels.iter().zip(&reference.pixels);
    let map = pixels.map(|(a, b)| {
        let error: f64 = (0..3).map(|c| error(a[c], b[c])).sum();
        sum += error;
        (error / 3.0) as f32
    });
    let map: Vec<f32> = map.collect();
    let mean = sum / (3.0 * picture.pixels.len() as f64);
    let value = if metric == Metric::Psnr { -10.0 * mean.log10() } else { mean };
    Ok(Measurement { value, map })
}

fn displayed(linear: f32) -> f64 {
    f64::from(srgb_encode(linear.clamp(0.0, 1.0)))
}

fn mean(map: &[f32]) -> f64 {
    map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_different_sizes_are_an_error() {
        let of = |size: [usize; 2]| Picture { size, pixels: vec![[0.5; 3]; size[0] * size[1]] };
        for metric in Metric::ALL {
            let found = measure(metric, &of([4, 2]), &of([2, 4]), DynamicRange::High);
            let error = found.expect_err("sizes differ");
            assert_eq!(error, SizeMismatch { picture: [4, 2], reference: [2, 4] });
            assert!(error.to_string().contains("4 x 2 pixels and the reference 2 x 4"), "{error}");
        }
    }
}
