//! Options of how a picture is written.

use std::path::Path;

use petzval_image::{
    BitDepth, DisplayExposure, EncodingOptions, ImageFormat, LensCorrection, ToneCurve,
    WhiteBalance,
};
use petzval_optics::{CalibrationSetup, RawCorrection};
use petzval_render::job::Job;
use petzval_render::plan::Effect;

use super::values::{bit_depth, white_balance};
use crate::cli::Failure;

/// Least width and height of raw files in libraw (pixels).
const LEAST_RAW: u32 = 22;

/// Bit depth and tone curve of a file.
#[derive(Clone, Debug, PartialEq, clap::Args)]
pub(in crate::cli) struct FileArguments {
    /// Write 16-bit floats (EXR)
    #[arg(long, help_heading = "Picture")]
    pub half: bool,
    /// Bits of a channel of PNG, 8 or 16. TIFF has 16
    #[arg(long, value_name = "BITS", value_parser = bit_depth, help_heading = "Picture")]
    pub bit_depth: Option<BitDepth>,
    /// Tone curve of PNG, JPEG and TIFF
    ///
    /// linear, which clips light above white, or filmic, which keeps middle grey and rolls
    /// highlights off over three more stops without a change of hue
    #[arg(long, value_name = "linear|filmic", default_value = "linear", help_heading = "Picture")]
    pub tone: ToneCurve,
}

impl FileArguments {
    /// Warns of a bit depth that the format does not have.
    pub fn warn(&self, output: &Path, format: ImageFormat) {
        if self.half && format != ImageFormat::Exr {
            let (name, bits) = (output.display(), format.bits(self.bit_depth));
            say!("petzval: warning: --half is for EXR; {name} has {bits}");
        }
    }
}

/// How a picture is written.
#[derive(Clone, Debug, PartialEq, clap::Args)]
pub(in crate::cli) struct EncodingArguments {
    #[command(flatten)]
    pub file: FileArguments,
    /// Write each layer into a part of its own (EXR)
    ///
    /// Programs then read the layers that they show, and no others. The names of the channels are the same
    #[arg(long, help_heading = "Picture")]
    pub multipart: bool,
    /// Brightness of PNG, JPEG and TIFF in stops, such as -1.5 or 2EV, or auto (default)
    ///
    /// The summary of the render prints the stops that auto finds, and the files store them. 0 shows
    /// a value of 1 as white. It is the default with --sensor, whose white is the full well, and
    /// with --sweep, whose pictures are compared
    #[arg(long, value_name = "EV|auto", allow_hyphen_values = true, help_heading = "Picture")]
    pub exposure: Option<DisplayExposure>,
    /// Light that PNG, JPEG and TIFF show as white: a colour temperature such as 3200K, D65, A,
    /// chromaticities x,y, auto or off (default)
    ///
    /// auto finds the mean colour of the picture; the summary of the render prints it, and the file
    /// stores it. Temperatures from 4000 K on are daylight, those below black bodies
    #[arg(
        long,
        value_name = "K|x,y|auto",
        value_parser = white_balance,
        default_value = "off",
        hide_default_value = true,
        help_heading = "Picture"
    )]
    pub white_balance: WhiteBalance,
    /// Write opcodes into DNG that correct distortion, lateral colour and falloff of the lens
    #[arg(long, help_heading = "Picture")]
    pub lens_correction: bool,
}

impl EncodingArguments {
    /// Checks the options and the format against the picture, and warns of what has no effect. `format` is
    /// `None` for a part of a picture.
    ///
    /// # Errors
    /// Returns an error for a white balance of a mosaic, a DNG without one, and a number of bits that the format
    /// does not have.
    pub fn check(
        &self,
        output: &Path,
        format: Option<ImageFormat>,
        job: &Job,
    ) -> Result<(), Failure> {
        if job.has_mosaic() && self.white_balance != WhiteBalance::Off {
            return Err("--white-balance: a mosaic of --bayer has no colours yet; balance the \
                        picture that is made of it"
                .into());
        }
        let Some(format) = format else { return Ok(()) };
        self.uncorrected(job, false).check(output)?;
        if self.lens_correction {
            if format != ImageFormat::Dng {
                let name = output.display();
                return Err(format!(
                    "--lens-correction: {name}: only DNG holds opcodes; name a picture.dng"
                )
                .into());
            }
            if !LensCorrection::is_for(job.frame.size(), job.frame.window()) {
                return Err("--lens-correction: the crop does not hold the middle of the frame, about which opcodes correct"
                    .into());
            }
            warn_of_error(&raw_correction(job)?);
        }
        self.file.warn(output, format);
        if self.multipart && format != ImageFormat::Exr {
            let name = output.display();
            say!("petzval: warning: --multipart is for EXR; {name} has one part");
        }
        if format == ImageFormat::Dng && job.frame.size().into_iter().any(|n| n < LEAST_RAW) {
            let name = output.display();
            say!(
                "petzval: warning: {name} is smaller than {LEAST_RAW} x {LEAST_RAW} pixels; libraw, which many \
                 programs use, does not open it"
            );
        }
        Ok(())
    }

    /// Returns the exposure of files for display. A sensor and the pictures of a sweep have a white of their
    /// own.
    fn exposure_of(&self, job: &Job, in_sweep: bool) -> DisplayExposure {
        self.exposure.unwrap_or(match in_sweep || job.sensor.is_some() {
            true => DisplayExposure::Stops(0.0),
            false => DisplayExposure::Auto,
        })
    }

    /// Returns the options of the file of a picture.
    ///
    /// # Errors
    /// Returns an error if opcodes cannot correct the lens.
    pub fn options(&self, job: &Job, in_sweep: bool) -> Result<EncodingOptions, Failure> {
        let mut options = self.uncorrected(job, in_sweep);
        if let (Some(raw), true) = (&mut options.raw, self.lens_correction) {
            let RawCorrection { warp, gain, .. } = raw_correction(job)?;
            raw.correction = Some(LensCorrection { warp, gain });
        }
        Ok(options)
    }

    /// Returns the options without a correction of the lens.
    fn uncorrected(&self, job: &Job, in_sweep: bool) -> EncodingOptions {
        let scene = job.encoding(self.exposure_of(job, in_sweep));
        EncodingOptions {
            half: scene.half || self.file.half,
            multipart: self.multipart,
            bit_depth: self.file.bit_depth,
            tone: self.file.tone,
            white_balance: self.white_balance,
            ..scene
        }
    }
}

/// Errors of a correction without a warning: of places (pixels), and of the light.
const MAX_ERROR: [f64; 2] = [0.5, 0.01];

fn warn_of_error(correction: &RawCorrection) {
    let [pixels, light] = correction.error;
    if pixels > MAX_ERROR[0] || light > MAX_ERROR[1] {
        say!(
            "petzval: warning: --lens-correction: the polynomials of DNG are off by up to {pixels:.2} pixels and {:.1} % \
             of the light",
            100.0 * light
        );
    }
}

/// Returns the polynomials that correct the lens of a job, with lateral colour if its picture disperses light.
fn raw_correction(job: &Job) -> Result<RawCorrection, Failure> {
    let failed = |problem: &str| Failure::from(format!("--lens-correction: {problem}"));
    let setup = CalibrationSetup::of_camera(&job.camera, job.frame.resolution)
        .ok_or_else(|| failed("the camera has no lens file"))?;
    let calibration = setup.calibrate_quickly().map_err(|error| failed(&error.to_string()))?;
    let channels = match job.plan.has(Effect::Dispersion) {
        true => setup.channel_fields().map_err(|error| failed(&error.to_string()))?,
        false => None,
    };
    calibration.raw_correction(channels.as_ref()).ok_or_else(|| {
        failed(match calibration.is_fisheye() {
            true => "the field is too wide for a rectilinear picture; leave it out for a fisheye",
            false => "lens and film are not round about the middle of the picture; expected a centred lens",
        })
    })
}
