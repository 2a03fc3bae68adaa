//! A lens file with a film behind it: arguments of calibration and of charts.

use std::path::PathBuf;

use petzval_base::io::ReadContext;
use petzval_lens::{FocusModel, Pose, Prescription};
use petzval_optics::{CalibrationSetup, FieldRay, PixelGrid};
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

/// A lens in focus.
pub(in crate::cli) struct FocusedLens {
    /// The lens, with the stop and the groups as they are for the picture.
    pub lens: Prescription,
    film_distance: f64,
    pixels: PixelGrid,
}

impl FocusedLens {
    /// Returns the camera, whose pixels are seen by the centroids of their bundles.
    pub fn setup(&self) -> CalibrationSetup<'_> {
        CalibrationSetup {
            lens: &self.lens,
            film_distance: self.film_distance,
            film_pose: Pose::ALIGNED,
            pixels: self.pixels,
            ray: FieldRay::Centroid,
        }
    }
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
        let named = |problem: String| Failure::from(format!("{}: {problem}", self.lens.display()));
        let film = PixelGrid::used_part(self.resolution, self.sensor);
        let pixels = PixelGrid::new(self.resolution, film[0]);
        self.stop.stop_down(&mut lens)?;
        let (focus, diagonal) = (self.focus, film[0].hypot(film[1]));
        let (lens, film_distance) = lens
            .focused(focus, FocusModel::Sharpest, diagonal)
            .map_err(|error| named(error.to_string()))?;
        let rim = lens.rear_reach();
        match film_distance > rim {
            true => Ok(FocusedLens { lens, film_distance, pixels }),
            false => Err(named(format!(
                "the film, {film_distance:.4} mm behind the rear vertex, would stand inside the lens, which \
                 reaches {rim:.4} mm behind it; focus nearer"
            ))),
        }
    }
}
