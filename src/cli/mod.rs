//! The command: what it understands, and how it answers.

/// A line for the user. Where nobody can hear it, the picture matters more than the words.
macro_rules! say {
    ($($word:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($word)*);
    }};
}

mod lens;
mod plan;
mod progress;
mod render;
mod trace;
mod vignetting;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};
use petzval::aov::Aov;
use petzval::image::Exposure;
use petzval::job::FocusOn;
use petzval::lens::Coating;
use petzval::plan::{Visible, Wanted};
use petzval::sensor::{Bayer, Settings};

/// Photographs 3-D scenes through real, multi-element camera lenses.
#[derive(Debug, Parser)]
#[command(name = "petzval", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene file to a picture
    Render(RenderArguments),
    /// Show what a lens file holds and where it focuses
    Lens(LensArguments),
    /// Show which effects a picture needs, why, and what they cost
    Plan(PlanArguments),
}

/// Which effects are simulated.
#[derive(Debug, clap::Args)]
struct EffectArguments {
    /// Effects to simulate: auto for what can be seen, all, none, or a list such as
    /// +dispersion,-iris
    #[arg(
        long,
        value_name = "auto|all|none|LIST",
        default_value = "auto",
        allow_hyphen_values = true
    )]
    effects: Wanted,
    /// From what on an effect counts as visible: displacement or blur, pixels
    #[arg(long, value_name = "PIXELS", default_value = "0.5px", allow_hyphen_values = true)]
    visible: Visible,
}

/// `petzval plan`
#[derive(Debug, clap::Args)]
struct PlanArguments {
    /// Scene file, pbrt-v4 or the pbrt-v2 of the 2016 course
    scene: PathBuf,
    /// For programs: one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    effects: EffectArguments,
    /// Another size of the picture, pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    resolution: Option<[u32; 2]>,
    /// Another lens file
    #[arg(long, value_name = "FILE")]
    lens: Option<PathBuf>,
    /// What is in focus, as for render
    #[arg(long, value_name = "M|inf|auto[@X,Y]", value_parser = focus, allow_hyphen_values = true)]
    focus: Option<FocusOn>,
    /// f-number, by a traced marginal ray: closes the stop of the lens
    #[arg(long, value_name = "N", value_parser = f_number, allow_hyphen_values = true)]
    fstop: Option<f64>,
}

/// `petzval render`
#[derive(Debug, clap::Args)]
struct RenderArguments {
    /// Scene file, pbrt-v4 or the pbrt-v2 of the 2016 course
    scene: PathBuf,
    /// Picture to write: .exr, .png, .jpg; the scene's own name if not given
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Samples a pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 30))]
    spp: Option<u32>,
    /// Seed of the random numbers
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Threads; one a core if not given. The picture is the same for any number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    threads: Option<u16>,
    /// Eight lanes or one. The picture is the same
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArgument,
    /// Render a part of the picture only; X1 and Y1 are not included
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = four)]
    crop: Option<[u32; 4]>,
    /// Another size of the picture, pixels
    #[arg(long, value_name = "WxH", value_parser = size)]
    resolution: Option<[u32; 2]>,
    /// Another lens file; the stop is opened as far as the scene says, the scene's film
    /// distance or focus stays
    #[arg(long, value_name = "FILE")]
    lens: Option<PathBuf>,
    /// What is in focus: metres from the film, or inf, or auto for what the middle of the picture
    /// sees, or auto@X,Y for what that pixel sees
    #[arg(long, value_name = "M|inf|auto[@X,Y]", value_parser = focus, allow_hyphen_values = true)]
    focus: Option<FocusOn>,
    /// f-number, by a traced marginal ray: closes the stop of the lens
    #[arg(long, value_name = "N", value_parser = f_number, allow_hyphen_values = true)]
    fstop: Option<f64>,
    #[command(flatten)]
    effects: EffectArguments,
    /// Let surfaces take what they reflect, and coat faces to air that the lens file says nothing
    /// of: none, mgf2, broadband or perfect
    #[arg(long, value_name = "COATING", value_parser = coating)]
    coating: Option<Coating>,
    /// Where film points aim: at the exit pupil, or at the rear element's disk as the course of
    /// 2016 did
    #[arg(long, value_enum, default_value_t)]
    pupil: PupilArgument,
    /// Write 16-bit floats (EXR)
    #[arg(long)]
    half: bool,
    /// Layers to add to the picture (EXR)
    #[arg(long, value_enum, value_name = "LAYER", value_delimiter = ',')]
    aov: Vec<AovArgument>,
    /// Brightness of PNG and JPEG in stops, or "auto"
    #[arg(long, value_name = "EV", default_value = "0", allow_hyphen_values = true)]
    exposure: Exposure,
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
    sensor: Option<Settings>,
    /// Write the mosaic of a sensor behind colour filters, one channel a pixel, in grey
    #[arg(long, value_name = "PATTERN", num_args = 0..=1, default_missing_value = "rggb")]
    bayer: Option<Bayer>,
}

impl RenderArguments {
    /// The sensor that is asked for: a mosaic needs one too.
    fn sensor(&self) -> Option<Settings> {
        match self.bayer {
            Some(_) => Some(Settings { bayer: self.bayer, ..self.sensor.unwrap_or_default() }),
            None => self.sensor,
        }
    }
}

/// `petzval lens`
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
struct LensArguments {
    #[command(subcommand)]
    command: Option<LensCommand>,
    /// Lens file
    #[arg(required = true)]
    lens: Option<PathBuf>,
    /// Say what is in focus on a film at this distance, mm, behind the rear vertex
    #[arg(long, value_name = "MM", value_parser = length, allow_hyphen_values = true)]
    film_distance: Option<f64>,
    /// Say where the film must stand to focus at this distance from it, mm (or inf)
    #[arg(long, value_name = "MM", value_parser = length_or_inf, allow_hyphen_values = true)]
    focus: Option<f64>,
    /// Close the stop to this diameter, mm
    #[arg(long, value_name = "MM", value_parser = length, allow_hyphen_values = true)]
    stop: Option<f64>,
    /// Coat faces to air that the lens file says nothing of: none, mgf2, broadband or perfect
    #[arg(long, value_name = "COATING", value_parser = coating, default_value = "none")]
    coating: Coating,
    /// Draw the section of the lens, with rays, to this SVG file; focused by --film-distance or
    /// --focus, or at infinity
    #[arg(long, value_name = "FILE", group = "pictured")]
    draw: Option<PathBuf>,
    /// Print which surface takes which share of the light, from the middle of the film to its
    /// corner, and the relative illumination; focused at infinity if nothing else is said
    #[arg(long, group = "pictured")]
    vignetting: bool,
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
}

/// `petzval lens trace`
#[derive(Debug, clap::Args)]
struct TraceArguments {
    /// Lens file
    lens: PathBuf,
    /// CSV of rays: x,y,z,dx,dy,dz[,wavelength_nm]; mm; the front vertex at z = 0, the film at +z;
    /// rays start on the film side and travel towards -z
    #[arg(long, value_name = "FILE")]
    rays: PathBuf,
    /// Arithmetic
    #[arg(long, value_enum, default_value_t)]
    precision: PrecisionArgument,
    /// Eight lanes or one. The answer is the same
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArgument,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum PrecisionArgument {
    #[default]
    F32,
    F64,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum BackendArgument {
    #[default]
    Simd,
    Scalar,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum PupilArgument {
    #[default]
    Exit,
    Rear,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum AovArgument {
    /// How far the surfaces are, and which share of a pixel they cover
    Depth,
    /// Where they are, world space
    Position,
    /// Their normals, world space
    Normal,
    /// The share of light that they send back
    Albedo,
    /// The number of the shape, and of the instance
    Object,
    /// The number of the material
    Material,
    /// The square of the pixel's standard error
    Variance,
    /// How many samples were taken, and came through the lens
    Samples,
    /// Diameter of the circle of confusion, um
    Coc,
    /// Which surface of the lens takes which share of the light
    Vignetting,
}

impl From<AovArgument> for Aov {
    fn from(argument: AovArgument) -> Self {
        match argument {
            AovArgument::Depth => Self::Depth,
            AovArgument::Position => Self::Position,
            AovArgument::Normal => Self::Normal,
            AovArgument::Albedo => Self::Albedo,
            AovArgument::Object => Self::Object,
            AovArgument::Material => Self::Material,
            AovArgument::Variance => Self::Variance,
            AovArgument::Samples => Self::Samples,
            AovArgument::Coc => Self::Coc,
            AovArgument::Vignetting => Self::Vignetting,
        }
    }
}

fn list<const N: usize>(text: &str, separator: char) -> Option<[u32; N]> {
    let numbers: Vec<u32> =
        text.split(separator).map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

fn four(text: &str) -> Result<[u32; 4], String> {
    list(text, ',').ok_or_else(|| "expected four whole numbers X0,Y0,X1,Y1".to_owned())
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let size =
        list(text, 'x').filter(|size: &[u32; 2]| size.iter().all(|n| (1..=65536).contains(n)));
    size.ok_or_else(|| "expected WxH in pixels, such as 1200x800, up to 65536".to_owned())
}

/// A number above 0, perhaps infinite.
fn above_zero(text: &str, expected: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&number: &f64| number > 0.0);
    number.ok_or_else(|| format!("expected {expected}"))
}

fn sensor(text: &str) -> Result<Settings, String> {
    text.parse().map_err(|problem| match text.contains('=') {
        true => problem,
        false => format!("{problem}; to give no value, put another option behind --sensor"),
    })
}

fn focus(text: &str) -> Result<FocusOn, String> {
    let expected = "a distance above 0, in m, or inf, auto, auto@X,Y";
    match text.strip_prefix("auto") {
        Some("") => Ok(FocusOn::Pixel(None)),
        Some(pixel) => match pixel.strip_prefix('@').and_then(|pixel| list(pixel, ',')) {
            Some(pixel) => Ok(FocusOn::Pixel(Some(pixel))),
            None => Err(format!("expected {expected}")),
        },
        None => above_zero(text, expected).map(FocusOn::Distance),
    }
}

fn f_number(text: &str) -> Result<f64, String> {
    above_zero(text, "an f-number such as 2.8").and_then(|number| match number.is_finite() {
        true => Ok(number),
        false => Err("expected an f-number such as 2.8".to_owned()),
    })
}

fn coating(text: &str) -> Result<Coating, String> {
    Coating::named(text).ok_or_else(|| format!("expected one of {}", Coating::NAMES.join(", ")))
}

fn length_or_inf(text: &str) -> Result<f64, String> {
    above_zero(text, "a length above 0, in mm")
}

fn length(text: &str) -> Result<f64, String> {
    length_or_inf(text).and_then(|length| match length.is_finite() {
        true => Ok(length),
        false => Err("expected a finite length, in mm".to_owned()),
    })
}

/// Writes an answer to where answers go.
fn print(text: &str) -> Result<Outcome, Failure> {
    use std::io::Write as _;
    match std::io::stdout().write_all(text.as_bytes()) {
        // Whoever reads has seen enough.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(Outcome::Done),
        other => Ok(other.map(|()| Outcome::Done)?),
    }
}

/// Why a command failed, in words for the user.
type Failure = Box<dyn std::error::Error>;

/// Exit code of a command stopped by Ctrl-C or SIGTERM, as shells know it.
const INTERRUPTED: u8 = 130;

/// How a command ended that did not fail.
enum Outcome {
    Done,
    Interrupted,
}

/// Runs the command that the arguments ask for.
pub fn run() -> ExitCode {
    // So that the answer to an old CPU can be seen on a new one.
    if std::env::var_os("PETZVAL_PRETEND_OLD_CPU").is_some() {
        crate::cpu::explain();
    }
    let outcome = match Arguments::parse().command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Lens(LensArguments { command: Some(LensCommand::Trace(arguments)), .. }) => {
            trace::run(&arguments)
        }
        Command::Lens(arguments) => lens::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(failure) => {
            say!("petzval: error: {failure}");
            ExitCode::from(2)
        }
    }
}
