//! Arguments of every command that prepares a picture: the scene, and changes to it.

use std::path::PathBuf;

use petzval_lens::{Coating, FocusModel};
use petzval_render::plan::{EffectSelection, VisibilityThreshold};
use petzval_render::prepare::{Changes, FocusOn, Viewpoint};
use petzval_render::sensor::{Bayer, SensorSettings};
use petzval_scene::shutter;
use petzval_spectrum::Passband;

use super::lens_file::LensFileArguments;
use super::values::{
    LightPathChoice, coating, f_number, focus, focus_model, length, light_paths, passband, sensor,
    shift, size, tilt, viewpoint,
};

/// A scene, and changes to it.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct PictureArguments {
    /// Scene file: pbrt-v4, glTF, or the pbrt-v2 of the 2016 course
    pub scene: PathBuf,
    /// Samples per pixel
    #[arg(
        long,
        value_name = "N",
        value_parser = clap::value_parser!(u32).range(1..=1 << 30),
        help_heading = "Picture"
    )]
    pub spp: Option<u32>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", help_heading = "Picture")]
    pub seed: Option<u32>,
    /// Size of the picture in pixels, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size, help_heading = "Picture")]
    pub resolution: Option<[u32; 2]>,
    /// Lens file, instead of the scene's; the scene's aperture diameter and film distance or focus
    /// stay
    #[arg(long, value_name = "FILE", help_heading = "Lens")]
    pub lens: Option<PathBuf>,
    #[command(flatten)]
    pub lens_file: LensFileArguments,
    /// Place the camera: its own place, a point in the middle of the picture, and the direction up
    /// (default 0,1,0), in the world of the scene
    ///
    /// The camera then stands still
    #[arg(
        long,
        value_name = "X,Y,Z,X,Y,Z[,X,Y,Z]",
        value_parser = viewpoint,
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub look_at: Option<Viewpoint>,
    /// Distance in focus from the film, such as 2m or 850mm
    ///
    /// A number alone is in metres. It is also inf, or auto for the surface in the middle of the
    /// picture, or auto@X,Y for the surface in that pixel
    #[arg(
        long,
        value_name = "2m|850mm|inf|auto[@X,Y]",
        value_parser = focus,
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub focus: Option<FocusOn>,
    /// Film position for the distance in focus
    ///
    /// sharpest, where the rays of the whole aperture make the smallest spot, or pbrt, by the
    /// thick-lens formula of pbrt-v4
    #[arg(
        long,
        value_name = "sharpest|pbrt",
        value_parser = focus_model,
        default_value = "sharpest",
        help_heading = "Camera"
    )]
    pub focus_model: FocusModel,
    /// f-number that the lens is stopped down to, such as f/8 or 8
    ///
    /// It is that of a traced marginal ray
    #[arg(
        long,
        value_name = "f/N",
        value_parser = f_number,
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub fstop: Option<f64>,
    /// Diagonal of the film, such as 43mm, instead of the scene's
    ///
    /// A number alone is in mm. Its sides are as those of the picture
    #[arg(
        long,
        value_name = "43mm",
        value_parser = length,
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub film_diagonal: Option<f64>,
    /// Shift the film right and up, such as 1mm,2mm
    ///
    /// Numbers alone are in mm. The picture shows more of the scene to the right and above
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = shift,
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub film_shift: Option<[f64; 2]>,
    /// Tilt the film about its middle, in degrees
    ///
    /// It turns about the horizontal axis, which moves the top away from the lens, then about its
    /// own vertical axis (swing), which moves the right edge, as seen from behind the camera,
    /// towards the lens. The focus applies to the film's middle
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = tilt,
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub film_tilt: Option<[f64; 2]>,
    /// Effects to simulate: auto for those that are visible, all, none, or a list such as
    /// +dispersion,-iris
    #[arg(
        long,
        value_name = "auto|all|none|LIST",
        default_value = "auto",
        allow_hyphen_values = true,
        help_heading = "Effects"
    )]
    pub effects: EffectSelection,
    /// Trace light paths from small bright lamps in view through the lens to the film, besides the
    /// camera's paths: auto where they pay, on for all lamps, off
    ///
    /// The picture has less noise and the same light
    #[arg(
        long,
        value_name = "auto|on|off",
        value_parser = light_paths,
        default_value = "auto",
        help_heading = "Effects"
    )]
    pub light_paths: LightPathChoice,
    /// Visibility threshold of effects: displacement or blur in pixels
    ///
    /// Veiling light, of ghosts and of diffraction stars, is visible from 1 % of the picture's mean
    /// on
    #[arg(
        long,
        value_name = "PIXELS",
        default_value = "0.5px",
        allow_hyphen_values = true,
        help_heading = "Effects"
    )]
    pub visible: VisibilityThreshold,
    /// Guess the Abbe number of glass whose lens file gives only the index, by the catalogue glass
    /// that it may be, for dispersion
    #[arg(long, help_heading = "Lens")]
    pub assume_vd: bool,
    /// Film or filter for a part of the visible light, within 400..704 nm; the picture is grey
    #[arg(long, value_name = "NM..NM", value_parser = passband, help_heading = "Lens")]
    pub passband: Option<Passband>,
    /// Simulate the light that lens surfaces lose by reflection, with this coating on glass-air
    /// surfaces for which the lens file gives none
    ///
    /// none, mgf2, broadband or perfect
    #[arg(long, value_name = "COATING", value_parser = coating, help_heading = "Lens")]
    pub coating: Option<Coating>,
    /// Shutter, instead of the scene's
    ///
    /// NAME=VALUE, any of open, close (times), time (how long it is open; changes the exposure),
    /// ramp (time to open and to close, within that time), opening, closing, curve (transmitted
    /// shares of the light at equal intervals, such as 0/.5/1/1/0)
    #[arg(
        long,
        value_name = "time=1/60,ramp=2ms,...",
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub shutter: Option<shutter::ShutterSettings>,
    /// Read the rows of the sensor one after another
    ///
    /// The time from the first to the last, and the direction of reading in the upright picture
    #[arg(
        long,
        value_name = "20ms[,down|up|left|right]",
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub rolling_shutter: Option<shutter::RollingShutter>,
    /// Simulate the readout of a camera sensor: photon and read noise, full well, quantisation
    ///
    /// NAME=VALUE, any of iso (default: the scene's; a higher value means less light at the same
    /// brightness), pixel (pitch, um; default: the film's), well (electrons; 1500 per um^2 of
    /// pixel), read (electrons; 2.5), bits (14), black (a code; 1/32 of the range), bayer
    #[arg(
        long,
        value_name = "iso=800,read=3,...",
        num_args = 0..=1,
        default_missing_value = "",
        value_parser = sensor,
        help_heading = "Camera"
    )]
    pub sensor: Option<SensorSettings>,
    /// Write the mosaic of a sensor with colour filters, one channel per pixel, in grey
    #[arg(
        long,
        value_name = "PATTERN",
        num_args = 0..=1,
        default_missing_value = "rggb",
        help_heading = "Camera"
    )]
    pub bayer: Option<Bayer>,
}

impl PictureArguments {
    /// Returns the changes to the scene.
    pub fn changes(&self) -> Changes {
        Changes {
            lens: self.lens.clone(),
            lens_options: self.lens_file.options(),
            viewpoint: self.look_at,
            focus: self.focus,
            focus_model: self.focus_model,
            f_number: self.fstop,
            assume_vd: self.assume_vd,
            passband: self.passband,
            film_diagonal: self.film_diagonal,
            film_shift: self.film_shift,
            film_tilt: self.film_tilt,
            coating: self.coating,
            resolution: self.resolution,
            samples: self.spp,
            seed: self.seed,
            effects: self.effects.clone(),
            light_paths: self.light_paths.0,
            threshold: self.visible,
            shutter: self.shutter.clone(),
            rolling: self.rolling_shutter,
            sensor: self.sensor(),
            ..Changes::default()
        }
    }

    /// Returns the requested sensor; --bayer implies one.
    fn sensor(&self) -> Option<SensorSettings> {
        match self.bayer {
            Some(_) => {
                Some(SensorSettings { bayer: self.bayer, ..self.sensor.unwrap_or_default() })
            }
            None => self.sensor,
        }
    }
}
