//! Arguments of every command that prepares a picture: the scene, and changes to it.

use std::path::PathBuf;

use petzval_render::prepare::Changes;
use petzval_render::prepare::settings::Assignment;

use super::lens_file::LensFileArguments;
use super::values::{sensor, setting};

/// A scene, and changes to it.
#[derive(Debug, clap::Args)]
pub(in crate::cli) struct PictureArguments {
    /// Scene file: pbrt-v4, glTF, or the pbrt-v2 of the 2016 course
    pub scene: PathBuf,
    /// Samples per pixel
    #[arg(
        long,
        value_name = "N",
        value_parser = setting("spp"),
        help_heading = "Picture"
    )]
    pub spp: Option<Assignment>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N", value_parser = setting("seed"), help_heading = "Picture")]
    pub seed: Option<Assignment>,
    /// Size of the picture in pixels, instead of the scene's
    #[arg(
        long,
        value_name = "WxH",
        value_parser = setting("resolution"),
        help_heading = "Picture"
    )]
    pub resolution: Option<Assignment>,
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
        value_parser = setting("look_at"),
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub look_at: Option<Assignment>,
    /// Distance in focus from the film, such as 2m or 850mm
    ///
    /// A number alone is in metres. It is also inf, or auto for the surface in the middle of the
    /// picture, or auto@X,Y for the surface in that pixel
    #[arg(
        long,
        value_name = "2m|850mm|inf|auto[@X,Y]",
        value_parser = setting("focus"),
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub focus: Option<Assignment>,
    /// Film position for the distance in focus
    ///
    /// sharpest, where the rays of the whole aperture make the smallest spot, or pbrt, by the
    /// thick-lens formula of pbrt-v4
    #[arg(
        long,
        value_name = "sharpest|pbrt",
        value_parser = setting("focus_model"),
        default_value = "sharpest",
        help_heading = "Camera"
    )]
    pub focus_model: Assignment,
    /// f-number that the lens is stopped down to, such as f/8 or 8
    ///
    /// It is that of a traced marginal ray
    #[arg(
        long,
        value_name = "f/N",
        value_parser = setting("fstop"),
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub fstop: Option<Assignment>,
    /// Diagonal of the film, such as 43mm, instead of the scene's
    ///
    /// A number alone is in mm. Its sides are as those of the picture
    #[arg(
        long,
        value_name = "43mm",
        value_parser = setting("film_diagonal"),
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub film_diagonal: Option<Assignment>,
    /// Shift the film right and up, such as 1mm,2mm
    ///
    /// Numbers alone are in mm. The picture shows more of the scene to the right and above
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = setting("film_shift"),
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub film_shift: Option<Assignment>,
    /// Tilt the film about its middle, in degrees
    ///
    /// It turns about the horizontal axis, which moves the top away from the lens, then about its
    /// own vertical axis (swing), which moves the right edge, as seen from behind the camera,
    /// towards the lens. The focus applies to the film's middle
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = setting("film_tilt"),
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub film_tilt: Option<Assignment>,
    /// Effects to simulate: auto for those that are visible, all, none, or a list such as
    /// +dispersion,-iris
    #[arg(
        long,
        value_name = "auto|all|none|LIST",
        value_parser = setting("effects"),
        default_value = "auto",
        allow_hyphen_values = true,
        help_heading = "Effects"
    )]
    pub effects: Assignment,
    /// Trace light paths from small bright lamps in view through the lens to the film, besides the
    /// camera's paths: auto where they pay, on for all lamps, off
    ///
    /// The picture has less noise and the same light
    #[arg(
        long,
        value_name = "auto|on|off",
        value_parser = setting("light_paths"),
        default_value = "auto",
        help_heading = "Effects"
    )]
    pub light_paths: Assignment,
    /// Visibility threshold of effects: displacement or blur in pixels
    ///
    /// Veiling light, of ghosts and of diffraction stars, is visible from 1 % of the picture's mean
    /// on
    #[arg(
        long,
        value_name = "PIXELS",
        value_parser = setting("visible"),
        default_value = "0.5px",
        allow_hyphen_values = true,
        help_heading = "Effects"
    )]
    pub visible: Assignment,
    /// Guess the Abbe number of glass whose lens file gives only the index, by the catalogue glass
    /// that it may be, for dispersion
    #[arg(long, help_heading = "Lens")]
    pub assume_vd: bool,
    /// Film or filter for a part of the visible light, within 400..704 nm; the picture is grey
    #[arg(
        long,
        value_name = "NM..NM",
        value_parser = setting("passband"),
        help_heading = "Lens"
    )]
    pub passband: Option<Assignment>,
    /// Add the spectral radiance in equal buckets of wavelength, of 360 to 830 nm or of a range, to the picture
    /// (EXR; a .npy holds it alone)
    ///
    /// Paths then carry wavelengths (--effects +spectra). none: a film without buckets, whatever the
    /// scene says
    #[arg(
        long,
        value_name = "N[@NM..NM]",
        value_parser = setting("buckets"),
        help_heading = "Picture"
    )]
    pub buckets: Option<Assignment>,
    /// Simulate the light that lens surfaces lose by reflection, with this coating on glass-air
    /// surfaces for which the lens file gives none
    ///
    /// none, mgf2, broadband or perfect
    #[arg(
        long,
        value_name = "COATING",
        value_parser = setting("coating"),
        help_heading = "Lens"
    )]
    pub coating: Option<Assignment>,
    /// Shutter, instead of the scene's
    ///
    /// NAME=VALUE, any of open, close (times), time (how long it is open; changes the exposure),
    /// ramp (time to open and to close, within that time), opening, closing, curve (transmitted
    /// shares of the light at equal intervals, such as 0/.5/1/1/0)
    #[arg(
        long,
        value_name = "time=1/60,ramp=2ms,...",
        value_parser = setting("shutter"),
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub shutter: Option<Assignment>,
    /// Read the rows of the sensor one after another
    ///
    /// The time from the first to the last, and the direction of reading in the upright picture
    #[arg(
        long,
        value_name = "20ms[,down|up|left|right]",
        value_parser = setting("rolling_shutter"),
        allow_hyphen_values = true,
        help_heading = "Camera"
    )]
    pub rolling_shutter: Option<Assignment>,
    /// Simulate the readout of a camera sensor: photon and read noise, full well, quantisation
    ///
    /// A sensor file NAME.toml, if there is one, then NAME=VALUE, any of iso (default: the scene's; a higher
    /// value means less light at the same brightness), gain (codes per electron, in place of iso), pixel
    /// (pitch, um; default: the film's), well (electrons; 1500 per um^2 of pixel), read (electrons; 2.5; or
    /// PIXEL/ROW/COLUMN), dark (electrons a second, or CURRENT@CELSIUS/KELVIN: at a temperature, and the
    /// rise that doubles it), temperature (degrees Celsius), time (seconds of dark current; the
    /// shutter's), dsnu (electrons; or PIXEL/ROW/COLUMN), prnu (%; or
    /// PIXEL/ROW/COLUMN), hot (SHARE/CURRENT), pattern (seed of dsnu, prnu and hot; 0), crosstalk (% that
    /// neighbours collect; or RED/GREEN/BLUE), bits (14), black (a code; 1/32 of the range), bayer
    #[arg(
        long,
        value_name = "iso=800,read=3,...",
        num_args = 0..=1,
        default_missing_value = "",
        value_parser = sensor,
        help_heading = "Camera"
    )]
    pub sensor: Option<Assignment>,
    /// Write the mosaic of a sensor with colour filters, one channel per pixel, in grey
    ///
    /// rggb, bggr, grbg or gbrg; quad-rggb and so on have filters of two by two pixels
    #[arg(
        long,
        value_name = "PATTERN",
        value_parser = setting("bayer"),
        num_args = 0..=1,
        default_missing_value = "rggb",
        help_heading = "Camera"
    )]
    pub bayer: Option<Assignment>,
}

impl PictureArguments {
    /// Returns the changes to the scene.
    pub fn changes(&self) -> Changes {
        let given = [
            &self.spp,
            &self.seed,
            &self.resolution,
            &self.look_at,
            &self.focus,
            &self.fstop,
            &self.film_diagonal,
            &self.film_shift,
            &self.film_tilt,
            &self.passband,
            &self.buckets,
            &self.coating,
            &self.shutter,
            &self.rolling_shutter,
            &self.sensor,
            &self.bayer,
        ];
        let defaults = [&self.focus_model, &self.effects, &self.light_paths, &self.visible];
        Changes {
            lens: self.lens.clone(),
            lens_options: self.lens_file.options(),
            assume_vd: self.assume_vd,
            ..Changes::of(given.into_iter().flatten().chain(defaults))
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;
    use petzval_render::prepare::settings::SETTINGS;

    use crate::cli::Arguments;
    use crate::cli::arguments::argv::parse_render;

    #[test]
    fn every_setting_is_an_option_and_every_option_a_setting() {
        let command = Arguments::command();
        let render = command.find_subcommand("render").expect("a command");
        let options: Vec<&str> = render.get_arguments().filter_map(clap::Arg::get_long).collect();
        for setting in SETTINGS.iter() {
            let option = setting.name.replace('_', "-");
            assert!(options.contains(&option.as_str()), "no option --{option}");
        }
        let line = "petzval render a.pbrt --spp 4 --seed 7 --resolution 6x4 --look-at 0,0,0,0,0,1 \
                    --focus 2m --focus-model pbrt --fstop f/4 --film-diagonal 43mm --film-shift 1,2 \
                    --film-tilt 3,4 --effects none --light-paths off --visible 2px --passband 540..560 --buckets 31@400..710 \
                    --coating mgf2 --shutter time=1/60 --rolling-shutter 20ms --bayer bggr \
                    --sensor iso=800,bayer=rggb";
        let argv: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
        let changes = parse_render(&argv).map_err(|failure| failure.to_string()).unwrap();
        let changes = changes.picture.changes();
        assert_eq!((changes.samples, changes.seed), (Some(4), Some(7)));
        assert_eq!((changes.f_number, changes.film_diagonal), (Some(4.0), Some(43.0)));
        let buckets = changes.buckets.flatten().expect("buckets");
        assert_eq!((buckets.count(), buckets.range()), (31, [400.0, 710.0]));
        assert_eq!((changes.light_paths, changes.threshold.pixels), (Some(false), 2.0));
        // The option of the mosaic alone counts before that of the sensor.
        let sensor = changes.sensor.expect("a sensor");
        assert_eq!((sensor.iso, sensor.bayer.map(|b| b.name())), (Some(800.0), Some("bggr")));
    }
}
