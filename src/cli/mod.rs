//! The command: what it understands, and how it answers.

/// A line for the user. Where nobody can hear it, the picture matters more than the words.
macro_rules! say {
    ($($word:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($word)*);
    }};
}

mod accuracy;
mod bench;
mod compare;
mod develop;
mod folders;
mod inputs;
mod kept;
mod layer;
mod lens;
mod memory;
mod merge;
mod message;
mod outputs;
mod picture;
mod plan;
mod progress;
mod psf;
mod render;
mod replay;
mod signals;
mod sweep;
mod trace;
mod values;
mod vignetting;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, Subcommand, ValueEnum};
use petzval::image::Exposure;
use petzval::lens::{Aim, Coating, FocusModel};
use petzval::memory::Size;
use petzval::metric::Metric;
use petzval::render::Backend;

use layer::AovArgument;
use picture::PictureArguments;
use replay::ReplayArguments;
use values::{
    Every, coating, every, focus_model, four, length, length_or_inf, limit, noise, point, range,
    shard, time,
};

/// Photographs 3-D scenes through real, multi-element camera lenses.
#[derive(Debug, Parser)]
#[command(name = "petzval", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene file to a picture. Ctrl-C and SIGTERM stop it: what is done of a.exr stands in
    /// a.exr.checkpoint then, for --resume, and what there is of the picture in a.partial.exr
    Render(Box<RenderArguments>),
    /// Add up the parts of a picture that were rendered with --shard or --samples. Run it where the
    /// files of the scene are found as the parts found them
    Merge(MergeArguments),
    /// Show what a lens file holds and where it focuses
    Lens(LensArguments),
    /// Take one sample of a picture once more, and print its whole way: surface by surface through
    /// the lens, hit by hit through the scene, to the value that the render adds to the pixel. Give
    /// the options of the render that decide about light: scene, lens, focus, effects, seed, --crop
    Replay(Box<ReplayArguments>),
    /// Show which effects a picture needs, why, and what they cost
    Plan(PlanArguments),
    /// Show what accuracy costs in time: a scene by a ladder of camera models, from the pinhole to
    /// every surface in f64, in a report with plot, pictures and advice
    Accuracy(AccuracyArguments),
    /// Say how far a picture is from a reference
    Compare(CompareArguments),
    /// Measure how fast this machine is, in some seconds
    Bench(BenchArguments),
}

/// `petzval plan`
#[derive(Debug, clap::Args)]
struct PlanArguments {
    #[command(flatten)]
    picture: PictureArguments,
    /// For programs: one JSON object
    #[arg(long)]
    json: bool,
}

/// `petzval render`
#[derive(Debug, clap::Args)]
struct RenderArguments {
    /// Picture to write: .exr, .png, .jpg; the scene's own name if not given
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArguments,
    /// End when the picture is this exact: the root mean square, over its pixels, of the standard
    /// error over the luminance and a tenth of the picture's mean. Tiles take as many samples as
    /// they need; --spp, if given, is the most in the mean. The picture is the same every time
    #[arg(long, value_name = "ERROR", value_parser = noise, allow_hyphen_values = true)]
    noise: Option<f64>,
    /// End after so much rendering, reading aside, with samples where they are needed; whichever of
    /// --noise, --time and --spp comes first. Every pixel takes 4 samples, however long that takes;
    /// the picture is not the same every time
    #[arg(long, value_name = "30s", value_parser = time, allow_hyphen_values = true)]
    time: Option<Duration>,
    /// How often to write what is done beside the picture, as FILE.checkpoint, which goes when the
    /// picture is finished. Off: never, not even when stopped
    #[arg(long, value_name = "60s|off", value_parser = every, default_value = "60s")]
    checkpoint: Every,
    /// Go on from that file; the picture is the same as without the interruption, bit for bit (but
    /// with --time). Where scene, lens, options or version have changed since, it is refused
    #[arg(long)]
    resume: bool,
    /// Render the I-th of N parts of the samples, I from 1, to PART.petzval for petzval merge
    #[arg(long, value_name = "I/N", value_parser = shard, conflicts_with = "samples")]
    shard: Option<[u32; 2]>,
    /// Render these samples of every pixel, from 0, B not included, to PART.petzval for petzval merge
    #[arg(long, value_name = "A..B", value_parser = range)]
    samples: Option<[u32; 2]>,
    /// Take a picture for each of these values of an option: fstop=2,4,8 or focus=0.5..5:8 (8 values,
    /// evenly) or fstop=2..16:4:log (by a factor); with ; between values that hold commas. Given again,
    /// for each with each. Scene and tree are loaded once. The name of the picture holds places to
    /// fill, such as out/{lens}_{fstop}_{focus}.exr; {{ is a brace. Folders in it are made
    #[arg(long, value_name = "NAME=VALUES", value_parser = sweep::axis)]
    sweep: Vec<sweep::Axis>,
    /// Contact sheet of a sweep: .png, .jpg; beside it, as .csv, the table of its pictures; sweep.png
    /// beside the pictures if not given
    #[arg(long, value_name = "FILE", requires = "sweep")]
    contact: Option<PathBuf>,
    /// Threads; one a core if not given. The picture is the same for any number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    threads: Option<u16>,
    /// The most memory to take, such as 8GiB or 500MB. Where the picture is expected to take more, or the scene declares
    /// more, it is refused at the start, and told what takes how much. If not given: what the machine
    /// has, or the group that limits the process (Linux)
    #[arg(long, value_name = "SIZE")]
    memory: Option<Size>,
    /// Eight lanes or one. The picture is the same
    #[arg(long, value_enum, default_value_t)]
    backend: BackendArgument,
    /// Render a part of the picture only; X1 and Y1 are not included
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = four)]
    crop: Option<[u32; 4]>,
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
}

/// `petzval accuracy`
#[derive(Debug, clap::Args)]
struct AccuracyArguments {
    /// Folder for the report: index.html, plot.svg, plot.png, accuracy.csv, accuracy.json
    #[arg(short, long, value_name = "FOLDER", default_value = "report")]
    output: PathBuf,
    /// How long it may take in all, whatever --spp says: that is the most samples a pixel. Reading
    /// the scene counts, but is not cut short
    #[arg(
        long,
        value_name = "60s",
        value_parser = accuracy::budget,
        allow_hyphen_values = true,
        default_value = "60s"
    )]
    budget: Duration,
    /// Render a part of the picture only; X1 and Y1 are not included
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = four)]
    crop: Option<[u32; 4]>,
    #[command(flatten)]
    picture: PictureArguments,
}

/// `petzval merge`
#[derive(Debug, clap::Args)]
struct MergeArguments {
    /// Parts, in any order: together all samples, each once
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Picture to write: .exr, .png, .jpg
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write 16-bit floats (EXR)
    #[arg(long)]
    half: bool,
    /// Brightness of PNG and JPEG in stops, or "auto"
    #[arg(long, value_name = "EV", default_value = "0", allow_hyphen_values = true)]
    exposure: Exposure,
    /// Threads; one a core if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    threads: Option<u16>,
    /// The most memory to take, as petzval render has it
    #[arg(long, value_name = "SIZE")]
    memory: Option<Size>,
}

/// `petzval bench`
#[derive(Debug, clap::Args)]
struct BenchArguments {
    /// For programs: a JSON list of name, value and unit
    #[arg(long)]
    json: bool,
}

/// `petzval compare`
#[derive(Debug, clap::Args)]
struct CompareArguments {
    /// Picture: .exr, .hdr, .pfm, .png, .jpg
    picture: PathBuf,
    /// What it should be
    reference: PathBuf,
    /// What to say, any of mse, relmse, mape, flip, psnr; all if not given
    #[arg(long, value_name = "METRIC", value_delimiter = ',')]
    metric: Vec<Metric>,
    /// Write where the first metric finds the pictures different
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// End with exit code 1 if the first metric is larger (psnr: smaller) than this
    #[arg(long, value_name = "X", value_parser = limit, allow_hyphen_values = true)]
    fail_above: Option<f64>,
    /// For programs: one JSON object
    #[arg(long)]
    json: bool,
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
    /// Where the film stands that --draw, --vignetting and --psf show: sharpest, where the rays of
    /// the whole opening make the smallest spot, or pbrt, where the thick-lens formula of pbrt-v4 puts
    /// it
    #[arg(long, value_name = "sharpest|pbrt", value_parser = focus_model, default_value = "sharpest")]
    focus_model: FocusModel,
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
    /// Draw how the lens's pupil spreads a point of white light (diffraction; aberrations aside), over
    /// six decades of brightness, to this picture, and print its scale; focused at infinity if
    /// nothing else is said
    #[arg(long, value_name = "FILE")]
    psf: Option<PathBuf>,
    /// The point of the film for --psf, mm from the axis
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

impl From<BackendArgument> for Backend {
    fn from(argument: BackendArgument) -> Self {
        match argument {
            BackendArgument::Simd => Self::Simd,
            BackendArgument::Scalar => Self::Scalar,
        }
    }
}

impl From<PupilArgument> for Aim {
    fn from(argument: PupilArgument) -> Self {
        match argument {
            PupilArgument::Exit => Self::Pupil,
            PupilArgument::Rear => Self::RearDisk,
        }
    }
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

/// Exit code of a command stopped by Ctrl-C, as shells know it, or by SIGTERM, which it cannot tell
/// from that.
const INTERRUPTED: u8 = 130;

/// How a command ended that did not fail.
enum Outcome {
    Done,
    /// Pictures are further apart than allowed.
    Different,
    Interrupted,
}

/// Runs the command that the arguments ask for.
pub fn run() -> ExitCode {
    // So that the answer to an old CPU can be seen on a new one.
    if std::env::var_os("PETZVAL_PRETEND_OLD_CPU").is_some() {
        crate::cpu::explain();
    }
    signals::install();
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return message::usage(&error),
    };
    let outcome = match arguments.command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::Lens(LensArguments { command: Some(LensCommand::Trace(arguments)), .. }) => {
            trace::run(&arguments)
        }
        Command::Lens(arguments) => lens::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Accuracy(arguments) => accuracy::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
    };
    match outcome {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::Different) => ExitCode::FAILURE,
        Ok(Outcome::Interrupted) => ExitCode::from(INTERRUPTED),
        Err(failure) => {
            message::error(&failure);
            ExitCode::from(2)
        }
    }
}
