//! How far a picture is from a reference: the measures that papers state.

mod flip;

pub use flip::{HdrFlip, flip_hdr, flip_ldr, pixels_per_degree};

use std::str::FromStr;

use crate::image::{Picture, srgb_encode};

/// A measure of the difference of two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// Mean of the squared differences over pixels and channels, linear light.
    Mse,
    /// The same, each over the square of the reference and 0.01 (Rousselle, Knaus & Zwicker 2011,
    /// "Adaptive sampling and reconstruction using greedy error minimization", sec. 6).
    RelMse,
    /// Mean of the absolute differences, each over the reference and 0.01.
    Mape,
    /// What an observer would notice when the pictures are shown in turn, from 0 to 1
    /// (Andersson et al. 2020, "FLIP: A difference evaluator for alternating images", and 2021,
    /// "Visualizing errors in rendered high dynamic range images").
    Flip,
    /// 10 log10 (1 / MSE) of the pictures as they are displayed: sRGB, clipped at white; dB.
    Psnr,
}

impl Metric {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Mse, Self::RelMse, Self::Mape, Self::Flip, Self::Psnr];

    /// Its name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mse => "mse",
            Self::RelMse => "relmse",
            Self::Mape => "mape",
            Self::Flip => "flip",
            Self::Psnr => "psnr",
        }
    }

    /// Whether more is better.
    pub fn rises(self) -> bool {
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

/// What keeps relative errors of the dark finite.
const FLOOR: f64 = 0.01;

/// How far a picture is from a reference of the same size, and where: the measure, and its value
/// by pixel (for PSNR the squared difference). `hdr` says whether either holds more than a display
/// shows, for [`Metric::Flip`].
///
/// # Panics
/// Where the sizes differ.
pub fn measure(
    metric: Metric,
    picture: &Picture,
    reference: &Picture,
    hdr: bool,
) -> (f64, Vec<f32>) {
    assert_eq!(picture.size, reference.size, "pictures of one size");
    if metric == Metric::Flip {
        let map = match hdr {
            true => flip_hdr(picture, reference, pixels_per_degree()).map,
            false => flip_ldr(picture, reference, pixels_per_degree()),
        };
        return (mean(&map), map);
    }
    let of = |a: f32, b: f32| {
        let (a, b) = match metric {
            Metric::Psnr => (shown(a), shown(b)),
            _ => (f64::from(a), f64::from(b)),
        };
        let off = a - b;
        match metric {
            Metric::RelMse => off * off / (b * b + FLOOR),
            Metric::Mape => off.abs() / (b.abs() + FLOOR),
            _ => off * off,
        }
    };
    let mut sum = 0.0;
    let pixels = picture.pixels.iter().zip(&reference.pixels);
    let map = pixels.map(|(a, b)| {
        let off: f64 = (0..3).map(|c| of(a[c], b[c])).sum();
        sum += off;
        (off / 3.0) as f32
    });
    let map: Vec<f32> = map.collect();
    let mean = sum / (3.0 * picture.pixels.len() as f64);
    match metric {
        Metric::Psnr => (-10.0 * mean.log10(), map),
        _ => (mean, map),
    }
}

fn shown(linear: f32) -> f64 {
    f64::from(srgb_encode(linear.clamp(0.0, 1.0)))
}

fn mean(map: &[f32]) -> f64 {
    map.iter().map(|&v| f64::from(v)).sum::<f64>() / map.len() as f64
}
