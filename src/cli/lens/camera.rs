//! A lens file with a film behind it: arguments of calibration and of charts.

use std::path::PathBuf;

use petzval_base::io::ReadContext;
use petzval_lens::Prescription;
use petzval_optics::FocusedLens;
use petzval_render::prepare::settings;

use super::conditions::StopArguments;
use crate::cli::Failure;
use crate::cli::arguments::lens_file::LensFileArguments;
use crate::cli::arguments::values::{focus_distance, sensor_size, typed};

/// Lens, film, focus and stop.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct LensCameraArguments {
    /// Lens file of any format that petzval reads
    pub lens: PathBuf,
    /// Size of the film or sensor, such as 36x24 or 36mmx24mm (numbers alone are in mm), or a name such as 35mm or
    /// nikon-d850
    ///
    /// The picture uses the largest part of it that has the aspect of --resolution: pixels are
    /// square
    // --sensor is its older name, which petzval render has for the readout.
    #[arg(
        long = "film-size",
        alias = "sensor",
        value_name = "WxH|NAME",
        value_parser = sensor_size,
        allow_hyphen_values = true
    )]
    pub sensor: [f64; 2],
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = typed(settings::resolution))]
    pub resolution: [u32; 2],
    /// Distance in focus from the film plane, such as 2m, 850mm or inf
    ///
    /// A number alone is in metres
    #[arg(
        long,
        value_name = "2m|850mm|inf",
        value_parser = focus_distance,
        allow_hyphen_values = true,
        default_value = "inf"
    )]
    pub focus: f64,
    #[command(flatten)]
    stop: StopArguments,
    #[command(flatten)]
    pub file: LensFileArguments,
}

impl LensCameraArguments {
    /// Reads the lens, and warns of what it leaves open.
    pub fn read(&self, context: &ReadContext) -> Result<Prescription, Failure> {
        let lens = self.file.options().read(&self.lens, context)?;
        super::warn_of_notes(&self.lens, &lens);
        super::warn_indices(&self.lens, &lens, [lens.design.primary_wavelength(); 2]);
        Ok(lens)
    }

    /// Stops the lens down and focuses it.
    pub fn focused(&self, mut lens: Prescription) -> Result<FocusedLens, Failure> {
        self.stop.stop_down(&mut lens)?;
        FocusedLens::new(&lens, self.focus, self.sensor, self.resolution)
            .map_err(|error| format!("{}: {error}", self.lens.display()).into())
    }
}
