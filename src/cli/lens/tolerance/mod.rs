//! `petzval lens tolerance`: image quality of a lens as it is made, by random trials.

mod files;
mod json;
mod limits;
mod sample;
mod table;

use std::path::PathBuf;

use petzval_base::io::ReadContext;
use petzval_optics::{
    DeviationShape, RadiusLimit, Refocus, ToleranceAnalysis, ToleranceGrade, ToleranceLimits,
    ToleranceSettings,
};

use super::conditions::{FieldArguments, refocus};
use crate::cli::arguments::lens_file::LensFileArguments;
use crate::cli::arguments::values::frequency;
use crate::cli::outputs::claim_writable;
use crate::cli::progress::StepBar;
use crate::cli::{Failure, Outcome};
pub(super) use limits::check_toml;
use sample::{Criterion, ToleranceSample};

/// Arguments of `petzval lens tolerance`.
#[derive(Debug, clap::Args)]
pub(super) struct ToleranceArguments {
    /// Lens file
    lens: PathBuf,
    #[command(flatten)]
    file: LensFileArguments,
    #[command(flatten)]
    conditions: FieldArguments,
    /// Lenses to make; 0 prints the nominal lens alone
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1000,
        value_parser = clap::value_parser!(u32).range(0..=10_000_000)
    )]
    trials: u32,
    /// Seed: trial i is the same for the same seed
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Grade of all tolerances that are not given: none, commercial, precision or high
    #[arg(long, value_name = "GRADE", value_parser = limits::grade, default_value = "precision")]
    grade: ToleranceGrade,
    /// Tolerance of radii: percent (0.1%), fringes of the e line over the clear diameter (3fr) or off
    #[arg(long, value_name = "%|fr", value_parser = limits::radius)]
    radius: Option<RadiusLimit>,
    /// Tolerance of thicknesses and air gaps, mm (or off)
    #[arg(long, value_name = "MM", value_parser = limits::length)]
    thickness: Option<f64>,
    /// Tolerance of refractive indices, such as 5e-4 (or off)
    #[arg(long, value_name = "DN", value_parser = limits::index)]
    index: Option<f64>,
    /// Tolerance of Abbe numbers, percent: 0.5% (or off)
    #[arg(long, value_name = "%", value_parser = limits::percent)]
    abbe: Option<f64>,
    /// Tolerance of the tilt of elements about x and y: 1', 30" or 0.02deg (or off)
    #[arg(long, value_name = "ANGLE", value_parser = limits::angle)]
    tilt: Option<f64>,
    /// Tolerance of the decentre of elements along x and y, mm (or off)
    #[arg(long, value_name = "MM", value_parser = limits::length)]
    decentre: Option<f64>,
    /// Tolerance of the tilt of surfaces against the first of their element: 1', 30" or 0.02deg (or
    /// off)
    #[arg(long, value_name = "ANGLE", value_parser = limits::angle)]
    wedge: Option<f64>,
    /// Distribution of the errors
    ///
    /// normal (standard deviation of half the limit, cut off at the limit), uniform or extremes
    #[arg(long, value_name = "SHAPE", value_parser = limits::shape, default_value = "normal")]
    distribution: DeviationShape,
    /// Film of each lens: moved to the best focus of all fields or of the axis, or off: it stays
    #[arg(long, value_name = "fields|axis|off", value_parser = refocus, default_value = "fields")]
    refocus: Refocus,
    /// Spatial frequency of the MTF, cycles/mm
    #[arg(long, value_name = "CYCLES/MM", value_parser = frequency, default_value = "30")]
    frequency: f64,
    /// Hexapolar rings of rays over the stop: 12 are 469 rays
    #[arg(
        long,
        value_name = "N",
        default_value_t = 12,
        value_parser = clap::value_parser!(u32).range(2..=100)
    )]
    rings: u32,
    /// Figure that ranks the lenses: spot (all fields) or mtf (lowest of all fields)
    #[arg(long, value_name = "spot|mtf", value_parser = limits::criterion, default_value = "spot")]
    criterion: Criterion,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
    /// Write the figures and errors of each trial to this CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write a bad lens as this TOML lens file, for `petzval render --lens`
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Rank of that lens, 1 for the worst
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        requires = "output",
        value_parser = clap::value_parser!(u32).range(1..)
    )]
    worst: u32,
}

impl ToleranceArguments {
    fn limits(&self) -> ToleranceLimits {
        let grade = self.grade.limits();
        ToleranceLimits {
            radius: self.radius.unwrap_or(grade.radius),
            thickness: self.thickness.unwrap_or(grade.thickness),
            index: self.index.unwrap_or(grade.index),
            abbe: self.abbe.unwrap_or(grade.abbe),
            tilt: self.tilt.unwrap_or(grade.tilt),
            decentre: self.decentre.unwrap_or(grade.decentre),
            wedge: self.wedge.unwrap_or(grade.wedge),
        }
    }
}

pub(super) fn run(arguments: &ToleranceArguments) -> Result<Outcome, Failure> {
    if arguments.output.is_some() && arguments.worst > arguments.trials {
        let (worst, trials) = (arguments.worst, arguments.trials);
        return Err(format!("--worst {worst}: expected at most --trials, which is {trials}").into());
    }
    let context = ReadContext::default();
    let mut lens = arguments.file.options().read(&arguments.lens, &context)?;
    super::warn_of_notes(&arguments.lens, &lens);
    let outputs = arguments.file.outputs(&context.files());
    let claim = |output: &Option<PathBuf>, option: &str| {
        output.as_ref().map(|output| claim_writable(&outputs, output, option)).transpose()
    };
    let (csv, output) = (claim(&arguments.csv, "--csv")?, claim(&arguments.output, "--output")?);
    if let Some(output) = &arguments.output {
        check_toml(output)?;
    }
    let conditions = arguments.conditions.conditions(&arguments.lens, &mut lens)?;
    let settings = ToleranceSettings {
        limits: arguments.limits(),
        shape: arguments.distribution,
        refocus: arguments.refocus,
        shares: arguments.conditions.both_signs(),
        rings: arguments.rings,
        frequency: arguments.frequency,
        seed: arguments.seed,
        threads: arguments.conditions.threads(),
    };
    let bar = StepBar::start("tolerances");
    let analysis = ToleranceAnalysis::new(&lens, conditions, settings)
        .map_err(|error| format!("{}: {error}", arguments.lens.display()))?;
    let sample = ToleranceSample::new(analysis, u64::from(arguments.trials), arguments.criterion);
    drop(bar);
    if let Some(file) = &csv {
        files::write_csv(file, &sample)?;
    }
    if let Some(file) = &output {
        let source = arguments.lens.display().to_string();
        files::write_lens(file, &source, &sample, arguments)?;
    }
    match arguments.json {
        true => super::super::print(&json::describe(&sample, arguments)),
        false => super::super::print(&table::describe(&lens.name, &sample, arguments)),
    }
}
