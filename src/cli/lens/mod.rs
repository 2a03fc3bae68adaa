//! `petzval lens`: shows, draws and traces a lens file.

mod calibrate;
mod camera;
mod conditions;
mod convert;
mod depth_of_field;
mod json;
mod optimize;
mod psf;
mod report;
mod summary;
mod tolerance;
mod trace;
mod vignetting;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Subcommand;
use petzval_base::io::{OutputFile, ReadContext};
use petzval_lens::{Coating, FocusModel, Prescription};
use petzval_render::prepare::settings;

use super::arguments::lens_file::LensFileArguments;
use super::arguments::values::{focus_distance, length, point, typed};
use super::outputs::claim_writable;
use super::progress::StepBar;
use super::{Failure, Outcome, message};
use calibrate::CalibrateArguments;
pub(super) use camera::LensCameraArguments;
use conditions::StopArguments;
use convert::ConvertArguments;
use depth_of_field::DepthOfFieldArguments;
use optimize::OptimizeArguments;
use petzval_report::lens_drawing::draw;
use report::ReportArguments;
use summary::{Summary, summary};
use tolerance::ToleranceArguments;
use trace::TraceArguments;

/// Arguments of `petzval lens`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(super) struct LensArguments {
    #[command(subcommand)]
    command: Option<LensCommand>,
    /// Lens file
    #[arg(required = true)]
    lens: Option<PathBuf>,
    #[command(flatten)]
    file: LensFileArguments,
    /// Show the distance in focus on a film at this distance behind the rear vertex, such as 36.8mm
    /// (a number alone is in mm)
    #[arg(long, value_name = "36.8mm", value_parser = length, allow_hyphen_values = true)]
    film_distance: Option<f64>,
    /// Show the film position that focuses at this distance from the film, such as 2m, 850mm or inf
    ///
    /// A number alone is in metres
    #[arg(
        long,
        value_name = "2m|850mm|inf",
        value_parser = focus_distance,
        allow_hyphen_values = true
    )]
    focus: Option<f64>,
    /// Print surfaces and first-order data as JSON, with every digit
    #[arg(long, conflicts_with_all = ["pictured", "psf", "film_distance", "focus"])]
    json: bool,
    /// Film position for --draw, --vignetting and --psf
    ///
    /// sharpest, where the rays of the whole aperture make the smallest spot, or pbrt, by the
    /// thick-lens formula of pbrt-v4
    #[arg(
        long,
        value_name = "sharpest|pbrt",
        value_parser = typed(settings::focus_model),
        default_value = "sharpest"
    )]
    focus_model: FocusModel,
    #[command(flatten)]
    stop: StopArguments,
    /// Coating of glass-air surfaces for which the lens file gives none: none, mgf2, broadband or
    /// perfect [default: mgf2 if the file names none]
    #[arg(long, value_name = "COATING", value_parser = typed(settings::coating))]
    coating: Option<Coating>,
    /// Draw the section of the lens, with rays, to this SVG file
    ///
    /// Focused by --film-distance or --focus, or at infinity
    #[arg(long, value_name = "FILE", group = "pictured")]
    draw: Option<PathBuf>,
    /// Print the share of the light that each surface blocks, from the middle of the film to its
    /// corner, and the relative illumination
    ///
    /// Focused at infinity by default
    #[arg(long, group = "pictured")]
    vignetting: bool,
    /// Draw the point spread of the lens's pupil in white light (diffraction without aberrations),
    /// over six decades of brightness, to this picture, and print its scale
    ///
    /// Focused at infinity by default
    #[arg(long, value_name = "FILE")]
    psf: Option<PathBuf>,
    /// Point of the film for --psf, mm from the axis
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = point,
        allow_hyphen_values = true,
        default_value = "0,0",
        requires = "psf"
    )]
    at: [f64; 2],
    /// Diagonal of the film for --draw and --vignetting, mm
    #[arg(
        long,
        value_name = "MM",
        value_parser = length,
        allow_hyphen_values = true,
        default_value = "43.27",
        requires = "pictured"
    )]
    film_diagonal: f64,
}

#[derive(Debug, Subcommand)]
enum LensCommand {
    /// Trace rays from a CSV file through a lens, for checks against other tools
    Trace(TraceArguments),
    /// Write a lens file in another format
    Convert(ConvertArguments),
    /// Analyse a lens by real rays: aberrations, spots, MTF, wavefronts, illumination, ghosts
    Report(ReportArguments),
    /// Describe a lens by the camera models of OpenCV, COLMAP, Kalibr and lensfun, with maps of
    /// distortion and illumination and point spreads
    Calibrate(CalibrateArguments),
    /// Print the nearest and the farthest sharp distance by f-number and distance in focus
    DepthOfField(DepthOfFieldArguments),
    /// Show the image quality of a lens as it is made: random errors of radii, thicknesses, glasses,
    /// tilts and decentres, and which of them cost most
    Tolerance(Box<ToleranceArguments>),
    /// Improve a lens by damped least squares over named variables
    Optimize(Box<OptimizeArguments>),
}

pub(super) fn run(arguments: &LensArguments) -> Result<Outcome, Failure> {
    match &arguments.command {
        Some(LensCommand::Trace(arguments)) => return trace::run(arguments),
        Some(LensCommand::Convert(arguments)) => return convert::run(arguments),
        Some(LensCommand::Report(arguments)) => return report::run(arguments),
        Some(LensCommand::Calibrate(arguments)) => return calibrate::run(arguments),
        Some(LensCommand::DepthOfField(arguments)) => return depth_of_field::run(arguments),
        Some(LensCommand::Tolerance(arguments)) => return tolerance::run(arguments),
        Some(LensCommand::Optimize(arguments)) => return optimize::run(arguments),
        None => {}
    }
    let file = arguments.lens.as_deref().ok_or("name a lens file")?;
    if let Some(drawing) = &arguments.draw {
        check_svg(drawing)?;
    }
    let context = ReadContext::default();
    let mut lens = arguments.file.options().read(file, &context)?;
    let outputs = arguments.file.outputs(&context.files());
    warn_of_notes(file, &lens);
    warn_indices(file, &lens, [lens.design.primary_wavelength(); 2]);
    let claim = |output: &Option<PathBuf>, option: &str| {
        output.as_ref().map(|output| claim_writable(&outputs, output, option)).transpose()
    };
    let (drawing, spread) = (claim(&arguments.draw, "--draw")?, claim(&arguments.psf, "--psf")?);
    match &arguments.coating {
        Some(coating) => lens.coat(coating),
        None => lens.assume_coating(),
    }
    arguments.stop.stop_down(&mut lens)?;
    if arguments.json {
        return super::print(&json::describe(&lens));
    }
    // All data are those of the lens with its groups where this focus has them.
    let by_groups = arguments.focus.and_then(|focus| {
        lens.focus_by_groups(focus, arguments.focus_model, arguments.film_diagonal)
    });
    let mut groups_film = None;
    if let Some(focused) = by_groups {
        let (moved, film) = focused?;
        (lens, groups_film) = (moved, Some(film));
    }
    let bar = StepBar::start("focus, f-number and T-stop");
    let Summary { mut text, film } = summary(&lens, arguments, groups_film)?;
    if let Some(drawing) = &drawing {
        bar.begin("rays of the drawing", 0);
        write_drawing(drawing, &lens, film, arguments.film_diagonal / 2.0)?;
    }
    if arguments.vignetting {
        let film = film.ok_or_else(|| no_film("--vignetting"))?;
        text = vignetting::table(&lens, film, arguments.film_diagonal, &bar)?;
    }
    if let Some(spread) = &spread {
        let film = film.ok_or_else(|| no_film("--psf"))?;
        bar.begin("point spread", 0);
        text += &psf::draw(spread, &lens, film, arguments.at)?;
    }
    drop(bar);
    super::print(&text)
}

/// Shows what the reader of a lens file assumed or left out.
fn warn_of_notes(file: &Path, lens: &Prescription) {
    message::file_warnings(file, &lens.design.notes);
}

/// Warns of glass whose data do not cover the wavelengths from `range[0]` to `range[1]` (nm).
fn warn_indices(file: &Path, lens: &Prescription, range: [f64; 2]) {
    message::file_warnings(file, lens.index_warnings(range));
}

fn no_film(option: &str) -> String {
    format!(
        "{option}: the lens forms no real image of distant objects; give the film's position with \
         --film-distance"
    )
}

/// Checks that a drawing has an SVG name.
fn check_svg(path: &Path) -> Result<(), Failure> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "svg" => Ok(()),
        _ => Err(format!(
            "--draw {}: drawings are SVG; name the file {}",
            path.display(),
            path.with_extension("svg").display()
        )
        .into()),
    }
}

fn write_drawing(
    file: &OutputFile,
    lens: &Prescription,
    film: Option<f64>,
    film_radius: f64,
) -> Result<(), Failure> {
    let text = draw(lens, film, film_radius);
    file.write(|file| file.write_all(text.as_bytes()))
        .map_err(|error| format!("cannot write the drawing {}: {error}", file.display()))?;
    if film.is_none() {
        say!("petzval: the lens forms no real image: {} has no film and no rays", file.display());
    }
    Ok(())
}
