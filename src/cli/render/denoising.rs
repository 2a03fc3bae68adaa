//! Denoising of a rendered picture: before the sensor reads it out, with the noisy one kept.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use petzval_image::{EncodingOptions, ImageFormat, ImageLayer, Picture};
use petzval_render::aov::Aov;
use petzval_render::job::Job;
use petzval_render::{OpticalImage, ReadPicture};
use petzval_spectrum::Primaries;

use crate::cli::Failure;
use crate::cli::denoise::{DenoiseError, Denoiser, Guides};
use crate::cli::outputs::check_writable;

/// Layers that the denoiser needs.
const GUIDES: [Aov; 2] = [Aov::Albedo, Aov::Normal];

/// How a picture is denoised.
pub(in crate::cli) struct Denoising<'a> {
    pub denoiser: &'a Denoiser,
    /// Ends the program.
    pub stop: &'a AtomicBool,
}

/// Error of a picture that was not denoised, and where the noisy one is.
#[derive(Debug, thiserror::Error)]
#[error("{cause}; {} is the noisy picture, with the layers albedo and normal", noisy.display())]
pub(in crate::cli) struct Undenoised {
    pub cause: DenoiseError,
    pub noisy: PathBuf,
}

/// Adds the layers that the denoiser needs. Returns those that were added.
pub(in crate::cli) fn add_guides(job: &mut Job) -> Vec<Aov> {
    let missing: Vec<Aov> =
        GUIDES.into_iter().filter(|guide| !job.layers.contains(guide)).collect();
    job.layers.extend(&missing);
    missing
}

/// Returns whether a job has the layers that the denoiser needs.
pub(in crate::cli) fn has_guides(job: &Job) -> bool {
    GUIDES.iter().all(|guide| job.layers.contains(guide))
}

impl Denoising<'_> {
    /// Denoises the light on the film. Returns the denoised and the noisy picture, both read out by
    /// the sensor if there is one: a denoiser must not take away the noise of the sensor.
    ///
    /// # Errors
    /// Returns an error, with the noisy picture, if that fails.
    pub fn apply(
        &self,
        image: OpticalImage,
        layers: &[ImageLayer],
        job: &Job,
    ) -> Result<(ReadPicture, Picture), (DenoiseError, ReadPicture)> {
        let layer = |aov: Aov| layers.iter().find(|layer| layer.name == aov.name());
        let clean = match GUIDES.map(layer) {
            [Some(albedo), Some(normal)] => {
                self.denoiser.run(image.picture(), &Guides { albedo, normal }, self.stop)
            }
            _ => Err(DenoiseError::Failed("there are no layers albedo and normal".to_owned())),
        };
        match clean {
            Ok(clean) => {
                Ok((image.clone().with_picture(clean).read_out(job), image.read_out(job).picture))
            }
            Err(error) => Err((error, image.read_out(job))),
        }
    }
}

/// Returns the noisy picture as a layer of a file with this encoding.
pub(super) fn noisy_layer(picture: &Picture, encoding: &EncodingOptions) -> ImageLayer {
    let matrix =
        encoding.space.filter(|_| !encoding.grey).and_then(|space| Primaries::SRGB.to(&space));
    let channel = |c: usize| {
        let value = |pixel: &[f32; 3]| match &matrix {
            Some(matrix) => matrix.row(c).dot(DVec3::from_array(pixel.map(f64::from))) as f32,
            None => pixel[c],
        };
        picture.pixels.iter().map(value).collect()
    };
    let names: &[&str] = if encoding.grey { &["Y"] } else { &["R", "G", "B"] };
    let channels = names.iter().zip(0..);
    let channels = channels.map(|(name, c)| ((*name).to_owned(), channel(c)));
    ImageLayer::new("noisy", channels.collect())
}

/// Returns the names that the noisy picture of a picture may have: beside a picture in a format without
/// layers, and if it could not be denoised.
pub(in crate::cli) fn noisy_files(output: &Path) -> [PathBuf; 2] {
    let extension = output.extension().unwrap_or_default().to_string_lossy();
    [&*extension, "exr"].map(|extension| output.with_extension(format!("noisy.{extension}")))
}

/// Returns whether the noisy picture of a denoised one is there: as a layer, or beside it.
pub(in crate::cli) fn has_noisy_picture(output: &Path) -> bool {
    let [beside, _] = noisy_files(output);
    ImageFormat::of(output).is_ok_and(|format| format == ImageFormat::Exr) || beside.is_file()
}

/// Checks that the noisy picture can be written under each of its names.
///
/// # Errors
/// Returns an error if it cannot.
pub(in crate::cli) fn check_noisy_files(output: &Path) -> Result<(), Failure> {
    noisy_files(output).iter().try_for_each(|file| check_writable(file, "-o"))
}

/// Returns the memory that denoising takes besides picture and layers of the file (bytes).
pub(in crate::cli) fn bytes(job: &Job, holds_layers: bool) -> u64 {
    // The second picture, and the file of the first, its values and its pixels while it is read; or the
    // second picture and its layer.
    const PIXEL: u64 = 4 * 12;
    const LAYERS: u64 = 2 * 12;
    // A copy of the light of the left half.
    const HALF: u64 = 12;
    let pixels = job.frame.size().map(u64::from).iter().product::<u64>();
    let half = if job.records_halves() { HALF } else { 0 };
    pixels * (PIXEL + half + if holds_layers { 0 } else { LAYERS })
}
