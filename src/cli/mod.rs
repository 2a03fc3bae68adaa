//! The `petzval` command: its subcommands, and how it ends.

/// Writes the line of an error to stderr, as a terminal may show it. A failure to write it must not end a
/// render.
macro_rules! say_error {
    ($($word:tt)*) => {{
        use std::io::Write as _;
        let line = format!($($word)*);
        let line = $crate::cli::option_names::with_option_names(&line);
        let _ = writeln!(std::io::stderr(), "{}", petzval_base::io::printable(&line));
    }};
}

/// Writes a line to stderr, unless --quiet is given.
macro_rules! say {
    ($($word:tt)*) => {{
        if !$crate::cli::screen::is_quiet() {
            say_error!($($word)*);
        }
    }};
}

mod accuracy;
mod arguments;
mod bench;
mod chart;
mod compare;
mod dataset;
mod denoise;
mod develop;
mod lens;
mod measure;
mod memory;
mod merge;
mod message;
mod option_names;
mod outputs;
mod plan;
mod progress;
mod render;
mod replay;
mod screen;
mod signals;
mod sweep;
mod view;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use accuracy::AccuracyArguments;
use bench::BenchArguments;
use chart::ChartArguments;
use compare::CompareArguments;
use dataset::DatasetArguments;
use develop::DevelopArguments;
use lens::LensArguments;
use measure::MeasureArguments;
use merge::MergeArguments;
use plan::PlanArguments;
use render::RenderArguments;
use replay::ReplayArguments;
use screen::MessageArguments;
use view::ViewArguments;

/// Photographs 3-D scenes through real, multi-element camera lenses.
#[derive(Debug, Parser)]
#[command(name = "petzval", version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    messages: MessageArguments,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene file to a picture. Ctrl-C and SIGTERM stop the render: its state is kept in
    /// a.exr.checkpoint for --resume, and the unfinished picture in a.partial.exr
    Render(Box<RenderArguments>),
    /// Add up the parts of a picture that were rendered with --shard or --samples. Run it where the
    /// scene's files have the same paths as for the parts
    Merge(MergeArguments),
    /// Show what the camera sees in the browser, refined while you look, with its focus, stop,
    /// shutter, lenses and viewpoint to change. Only this machine can reach the page
    View(Box<ViewArguments>),
    /// Show the prescription of a lens file and its first-order data
    Lens(LensArguments),
    /// Repeat one sample of a picture and print its whole path: surface by surface through the
    /// lens, hit by hit through the scene, to the value that the render adds to the pixel. Give the
    /// options of the render that affect light: scene, lens, focus, effects, seed, --crop
    Replay(Box<ReplayArguments>),
    /// Show which effects a picture needs, why, and their cost
    Plan(PlanArguments),
    /// Show what accuracy costs in time: a scene by a ladder of camera models, from the pinhole to
    /// every surface in f64, in a report with plot, pictures and advice
    Accuracy(AccuracyArguments),
    /// Photograph pairs of clean and degraded pictures of one view, with depth and camera data, to
    /// train on: each by a draw of scene, lens, focus, stop, light and viewpoint. The same command
    /// again continues
    Dataset(DatasetArguments),
    /// Develop a raw file (.dng) to a picture: levels, white balance, demosaicking, colours, tone
    Develop(DevelopArguments),
    /// Measure how far a picture is from a reference
    Compare(CompareArguments),
    /// Draw a test chart that fills the picture of a lens, as a scene: slanted edges, a grid of dots, white, dead leaves,
    /// colours
    Chart(ChartArguments),
    /// Measure a picture: the spatial frequency response of slanted edges (ISO 12233) and of texture, distortion, colours,
    /// and the noise of a sensor
    Measure(MeasureArguments),
    /// Measure the speed of this machine, in about 10 s
    Bench(BenchArguments),
}

/// Why a command failed, as a message for the user.
type Failure = Box<dyn std::error::Error>;

/// Exit code of a command that Ctrl-C or SIGTERM stopped: 128 + SIGINT. The handler cannot tell the
/// two signals apart.
const INTERRUPTED: u8 = 130;

/// How a command ended that did not fail.
enum Outcome {
    Done,
    /// The pictures differ by more than --fail-above allows.
    Different,
    Interrupted,
}

/// Runs the command that the arguments ask for.
pub fn run() -> ExitCode {
    // For the test of this message on a CPU that has AVX2.
    if std::env::var_os("PETZVAL_PRETEND_OLD_CPU").is_some() {
        crate::cpu::explain();
    }
    signals::install();
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return message::usage(&error),
    };
    arguments.messages.apply();
    if let Some(notice) = crate::cpu::portable_notice() {
        say!("petzval: {notice}");
    }
    let outcome = match arguments.command {
        Command::Render(arguments) => render::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Lens(arguments) => lens::run(&arguments),
        Command::Replay(arguments) => replay::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Accuracy(arguments) => accuracy::run(&arguments),
        Command::Dataset(arguments) => dataset::run(&arguments),
        Command::Develop(arguments) => develop::run(&arguments),
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Chart(arguments) => chart::run(&arguments),
        Command::Measure(arguments) => measure::run(&arguments),
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

/// Writes the result of a command to stdout, as a terminal may show it.
fn print(text: &str) -> Result<Outcome, Failure> {
    use std::io::Write as _;
    let text = option_names::with_option_names(text);
    let (text, mut stdout) = (petzval_base::io::printable(&text), std::io::stdout());
    // What is left in its buffer would be lost without an error.
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        // The reader has closed the pipe, as `head` does.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(Outcome::Done),
        other => Ok(other.map(|()| Outcome::Done)?),
    }
}
