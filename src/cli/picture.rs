//! What every command that makes ready a picture understands.

use std::path::PathBuf;

use petzval::job::{Changes, FocusOn};
use petzval::lens::{Coating, FocusModel};
use petzval::plan::{Visible, Wanted};
use petzval::sensor::{Bayer, Settings};
use petzval::shutter;
use petzval::spectrum::Passband;

use super::values::{coating, f_number, focus, focus_model, passband, sensor, shift, size, tilt};

/// A scene, and what is to be otherwise than it says.
#[derive(Debug, clap::Args)]
pub(super) struct PictureArguments {
    /// Scene file, pbrt-v4 or the pbrt-v2 of the 2016 course
    pub scene: PathBuf,
    /// Samples a pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 30))]
    pub spp: Option<u32>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// Another size of the picture, pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub resolution: Option<[u32; 2]>,
    /// Another lens file; the stop is opened as far as the scene says, the scene's film
    /// distance or focus stays
    #[arg(long, value_name = "FILE")]
    pub lens: Option<PathBuf>,
    /// What is in focus: metres from the film, or inf, or auto for what the middle of the picture
    /// sees, or auto@X,Y for what that pixel sees
    #[arg(long, value_name = "M|inf|auto[@X,Y]", value_parser = focus, allow_hyphen_values = true)]
    pub focus: Option<FocusOn>,
    /// Where the film stands for the distance in focus: sharpest, where the rays of the whole opening
    /// make the smallest spot, or pbrt, where the thick-lens formula of pbrt-v4 puts it
    #[arg(long, value_name = "sharpest|pbrt", value_parser = focus_model, default_value = "sharpest")]
    pub focus_model: FocusModel,
    /// f-number, by a traced marginal ray: closes the stop of the lens
    #[arg(long, value_name = "N", value_parser = f_number, allow_hyphen_values = true)]
    pub fstop: Option<f64>,
    /// Shift the film, mm: the picture shows as much more of what is to the right and above
    #[arg(long, value_name = "X,Y", value_parser = shift, allow_hyphen_values = true)]
    pub film_shift: Option<[f64; 2]>,
    /// Tilt the film about its middle, degrees: about the horizontal axis, the top going away from
    /// the lens, then about its own vertical axis (swing), the right edge, as seen from behind the
    /// camera, going towards the lens. Focus is that of the film's middle
    #[arg(long, value_name = "X,Y", value_parser = tilt, allow_hyphen_values = true)]
    pub film_tilt: Option<[f64; 2]>,
    /// Effects to simulate: auto for what can be seen, all, none, or a list such as
    /// +dispersion,-iris
    #[arg(
        long,
        value_name = "auto|all|none|LIST",
        default_value = "auto",
        allow_hyphen_values = true
    )]
    pub effects: Wanted,
    /// From what on an effect counts as visible: displacement or blur, pixels. Veils of light, of
    /// ghosts and of stars, count from 1 % of the picture's mean on
    #[arg(long, value_name = "PIXELS", default_value = "0.5px", allow_hyphen_values = true)]
    pub visible: Visible,
    /// Take the Abbe number of glass of which the lens file gives the index only from a glass of the
    /// catalogue that it may be: a guess, for dispersion
    #[arg(long)]
    pub assume_vd: bool,
    /// A film, or filter, for a part of the visible light: it sees grey; within 400..704 nm
    #[arg(long, value_name = "NM..NM", value_parser = passband)]
    pub passband: Option<Passband>,
    /// Let surfaces take what they reflect, and coat faces to air that the lens file says nothing
    /// of: none, mgf2, broadband or perfect
    #[arg(long, value_name = "COATING", value_parser = coating)]
    pub coating: Option<Coating>,
    /// Another shutter: NAME=VALUE, any of open, close (when), time (how long it is open; changes
    /// the exposure), ramp (to open and to close, within that time), opening, closing, curve
    /// (shares of the light that comes through, equally far apart, such as 0/.5/1/1/0)
    #[arg(long, value_name = "time=1/60,ramp=2ms,...", allow_hyphen_values = true)]
    pub shutter: Option<shutter::Settings>,
    /// Read the rows of the sensor one after another: the time from the first to the last, and
    /// where the reading goes in the picture as it is seen
    #[arg(long, value_name = "20ms[,down|up|left|right]", allow_hyphen_values = true)]
    pub rolling_shutter: Option<shutter::Rolling>,
    /// Read the picture out as a camera's sensor does: photon and read noise, full well, codes.
    /// NAME=VALUE, any of iso (the scene's; the picture stays as bright, with less light), pixel
    /// (pitch, um; the film's), well (electrons; 1500 per um^2 of pixel), read (electrons; 2.5),
    /// bits (14), black (a code; a thirty-second of all), bayer
    #[arg(
        long,
        value_name = "iso=800,read=3,...",
        num_args = 0..=1,
        default_missing_value = "",
        value_parser = sensor
    )]
    pub sensor: Option<Settings>,
    /// Write the mosaic of a sensor behind colour filters, one channel a pixel, in grey
    #[arg(long, value_name = "PATTERN", num_args = 0..=1, default_missing_value = "rggb")]
    pub bayer: Option<Bayer>,
}

impl PictureArguments {
    /// What is to be otherwise than the scene says.
    pub fn changes(&self) -> Changes {
        Changes {
            lens: self.lens.clone(),
            focus: self.focus,
            focus_model: self.focus_model,
            f_number: self.fstop,
            assume_vd: self.assume_vd,
            passband: self.passband,
            film_shift: self.film_shift,
            film_tilt: self.film_tilt,
            coating: self.coating,
            resolution: self.resolution,
            samples: self.spp,
            seed: self.seed,
            effects: self.effects.clone(),
            visible: self.visible,
            shutter: self.shutter.clone(),
            rolling: self.rolling_shutter,
            sensor: self.sensor(),
            ..Changes::default()
        }
    }

    /// The sensor that is asked for: a mosaic needs one too.
    fn sensor(&self) -> Option<Settings> {
        match self.bayer {
            Some(_) => Some(Settings { bayer: self.bayer, ..self.sensor.unwrap_or_default() }),
            None => self.sensor,
        }
    }
}
