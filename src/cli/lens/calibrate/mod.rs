//! `petzval lens calibrate`: describes a lens by the camera models of other programs.

mod colmap;
mod json;
mod kalibr;
mod lensfun;
mod maps;

mod opencv;
mod openlensio;
mod psf;
mod summary;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use petzval_base::io::{OutputFile, Outputs, ReadContext};
use petzval_lens::RealRayFocus;
use petzval_optics::{Calibration, CalibrationSetup, FieldRay};

use super::camera::LensCameraArguments;
use crate::cli::outputs::{CreatedFolders, check_writable, claim};
use crate::cli::progress::StepBar;
use crate::cli::{Failure, Outcome};

/// Largest number of pixels: each map has an entry for every one.
const MAX_PIXELS: u64 = 1 << 26;

/// Arguments of `petzval lens calibrate`.
#[derive(Debug, clap::Args)]
pub(super) struct CalibrateArguments {
    #[command(flatten)]
    camera: LensCameraArguments,
    /// Ray that stands for a pixel
    ///
    /// The centroid of all rays that pass, where pictures show points, or the chief ray through the
    /// centre of the stop
    #[arg(long, value_enum, default_value_t)]
    ray: RayArgument,
    /// Folder for the files; it is made if it is missing
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
}

/// Argument of `--ray`.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum RayArgument {
    #[default]
    Centroid,
    Chief,
}

impl From<RayArgument> for FieldRay {
    fn from(argument: RayArgument) -> Self {
        match argument {
            RayArgument::Centroid => Self::Centroid,
            RayArgument::Chief => Self::Chief,
        }
    }
}

/// A calibrated camera with the data that files name.
struct Report<'a> {
    setup: CalibrationSetup<'a>,
    calibration: Calibration,
    /// Largest distance between images by chief rays and by centroids (pixels).
    chief_difference: Option<f64>,
    /// The size of the whole sensor (mm).
    sensor: [f64; 2],
    f_number: Option<f64>,
    stop_diameter: f64,
}

/// The files that the command may write, by name.
struct CalibrationFiles(Vec<(&'static str, OutputFile)>);

impl CalibrationFiles {
    fn new(folder: &Path, outputs: &Outputs) -> Result<Self, Failure> {
        let named = |name| Ok((name, claim(outputs, folder.join(name), "-o")?));
        Ok(Self(NAMES.into_iter().map(named).collect::<Result<_, Failure>>()?))
    }

    fn named(&self, name: &str) -> Result<&OutputFile, Failure> {
        let found = self.0.iter().find(|(other, _)| *other == name);
        Ok(&found.ok_or_else(|| format!("{name} is no file of a calibration"))?.1)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        let file = self.named(name)?;
        file.write(|file| file.write_all(bytes))
            .map_err(|error| format!("cannot write {}: {error}", file.display()).into())
    }
}

/// All names that the command may write.
const NAMES: [&str; 15] = [
    "calibration.json",
    "opencv_brown_conrady.yaml",
    "opencv_rational.yaml",
    "opencv_thin_prism.yaml",
    "opencv_fisheye.yaml",
    "cameras.txt",
    "kalibr_radtan.yaml",
    "kalibr_equidistant.yaml",
    "lensfun.xml",
    "openlensio.json",
    "st_undistort.exr",
    "st_redistort.exr",
    "illumination.exr",
    "psf.exr",
    "psf.npy",
];

pub(super) fn run(arguments: &CalibrateArguments) -> Result<Outcome, Failure> {
    let CalibrateArguments { camera, output, ray } = arguments;
    let LensCameraArguments { lens: file, sensor, resolution, .. } = camera;
    let pixels = u64::from(resolution[0]) * u64::from(resolution[1]);
    if pixels > MAX_PIXELS {
        return Err(format!(
            "--resolution {}x{}: {pixels} pixels; expected at most {MAX_PIXELS}",
            resolution[0], resolution[1]
        )
        .into());
    }
    let context = ReadContext::default();
    let lens = camera.read(&context)?;
    let mut folders = CreatedFolders::default();
    folders
        .create(output)
        .map_err(|error| format!("cannot make the folder {}: {error}", output.display()))?;
    let files = CalibrationFiles::new(output, &camera.file.outputs(&context.files()))?;
    check_writable(&output.join(NAMES[0]), "-o")?;

    let bar = StepBar::start("calibration");
    let focused = camera.focused(lens)?;
    let setup = CalibrationSetup { ray: (*ray).into(), ..focused.setup() };
    let lens = &focused.lens;
    let named = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
    let calibration = setup.calibrate().map_err(|error| named(&error))?;
    let other = match setup.ray {
        FieldRay::Centroid => FieldRay::Chief,
        _ => FieldRay::Centroid,
    };
    let other = CalibrationSetup { ray: other, ..setup }.calibrate().ok();
    let report = Report {
        chief_difference: other.and_then(|other| calibration.largest_difference(&other)),
        f_number: RealRayFocus::new(lens).f_number(),
        stop_diameter: lens.rows[lens.stop()].diameter,
        sensor: *sensor,
        setup,
        calibration,
    };
    bar.begin("maps and point spreads", 0);
    let written = report.write(&files)?;
    drop(bar);
    for (_, file) in files.0.iter().filter(|(name, _)| !written.contains(name)) {
        // A file of an earlier calibration does not describe this camera.
        let _ = file.remove();
    }
    crate::cli::print(&summary::text(&report, output, &written))
}

impl Report<'_> {
    /// Writes all files that describe this camera, and returns their names.
    fn write(&self, files: &CalibrationFiles) -> Result<Vec<&'static str>, Failure> {
        let mut written = Vec::new();
        let mut put = |name: &'static str, text: Option<String>| -> Result<(), Failure> {
            let Some(text) = text else { return Ok(()) };
            files.write(name, text.as_bytes())?;
            written.push(name);
            Ok(())
        };
        for (name, text) in opencv::files(self) {
            put(name, Some(text))?;
        }
        put("cameras.txt", colmap::text(self))?;
        for (name, text) in kalibr::files(self) {
            put(name, Some(text))?;
        }
        let colour = self.setup.channel_fields();
        if let Err(error) = &colour {
            say!("petzval: warning: lateral colour and point spreads are left out: {error}");
        }
        let channels = colour.as_ref().ok().and_then(Option::as_ref);
        let photographic = lensfun::Photographic::new(&self.calibration, channels);
        put("lensfun.xml", lensfun::text(self, &photographic))?;
        put("openlensio.json", openlensio::text(self))?;
        let maps = maps::write(self, files)?;
        let spots = match colour {
            Ok(_) => Some(psf::write(self, files)?),
            Err(_) => None,
        };
        let text = json::describe(self, &photographic, maps.as_ref(), spots.as_ref());
        put("calibration.json", Some(text))?;
        written.push("illumination.exr");
        if maps.is_some() {
            written.extend(["st_undistort.exr", "st_redistort.exr"]);
        }
        if spots.is_some() {
            written.extend(["psf.exr", "psf.npy"]);
        }
        Ok(written)
    }

    /// Returns the distance in focus as words.
    fn focus(&self) -> String {
        match self.calibration.focus {
            focus if focus.is_finite() => format!("{:.6} m", focus * 1e-3),
            _ => "infinity".to_owned(),
        }
    }

    /// Returns a line that says what a file describes.
    fn headline(&self) -> String {
        let name: String =
            self.setup.lens.name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        let f_number = self.f_number.map_or_else(String::new, |n| format!(", f/{n:.3}"));
        format!(
            "{name}, focus {} from the film{f_number}, {} rays at {:.1} nm, by petzval {}",
            self.focus(),
            self.calibration.ray.name(),
            self.calibration.wavelength,
            env!("CARGO_PKG_VERSION"),
        )
    }
}

/// Returns numbers with every digit, with commas between.
fn list(numbers: &[f64]) -> String {
    // 0 has no sign.
    let texts: Vec<String> = numbers.iter().map(|number| format!("{:?}", number + 0.0)).collect();
    texts.join(", ")
}
