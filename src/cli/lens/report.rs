//! `petzval lens report`: every analysis of a lens, as JSON, CSV, SVG and one page.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use petzval_base::io::{Outputs, ReadContext};
use petzval_optics::{ImagingGrid, in_parallel};
use petzval_report::lens_report::{ANALYSES, LensReport, PageText, ReportChoices, ReportFile};

use super::conditions::{ConditionArguments, FieldShares, field_shares};
use crate::cli::arguments::argv::{argv, shell_line};
use crate::cli::arguments::lens_file::LensFileArguments;
use crate::cli::arguments::values::frequency;
use crate::cli::option_names::with_option_names;
use crate::cli::outputs::CreatedFolders;
use crate::cli::progress::StepBar;
use crate::cli::{Failure, Outcome};

/// Arguments of `petzval lens report`.
#[derive(Debug, clap::Args)]
pub(super) struct ReportArguments {
    /// Lens file
    lens: PathBuf,
    #[command(flatten)]
    file: LensFileArguments,
    /// Folder for the page, index.html, and for JSON, CSV, SVG and PNG files
    #[arg(short, long, value_name = "FOLDER", required_unless_present = "json")]
    output: Option<PathBuf>,
    /// Print JSON instead of writing files: all analyses, or one by its name
    #[arg(
        long,
        value_name = "ANALYSIS",
        num_args = 0..=1,
        default_missing_value = ALL,
        value_parser = analysis,
        conflicts_with = "output"
    )]
    json: Option<String>,
    #[command(flatten)]
    conditions: ConditionArguments,
    /// Largest spatial frequency of the MTF, cycles/mm, instead of about half of the diffraction
    /// limit and 200 at most
    #[arg(long, value_name = "CYCLES/MM", value_parser = frequency)]
    frequency: Option<f64>,
    /// Fields that are shown one by one, as shares of the largest field angle or height
    /// [default: those of the lens file, or 0,0.5,0.7,0.85,1]
    #[arg(long, value_name = "SHARE,...", value_parser = field_shares)]
    fields: Option<FieldShares>,
    /// Number of fields from the axis to the edge, for curves over the field
    #[arg(
        long,
        value_name = "N",
        default_value_t = 21,
        value_parser = clap::value_parser!(u16).range(2..=1001)
    )]
    field_count: u16,
    /// Rays along each side of the grid over the pupil
    // --pupil is its older name, which petzval render has for where film points aim.
    #[arg(
        long = "pupil-grid",
        alias = "pupil",
        value_name = "N",
        default_value_t = 64,
        value_parser = clap::value_parser!(u16).range(8..=512)
    )]
    pupil: u16,
}

/// Name of all analyses together.
const ALL: &str = "all";

pub(super) fn run(arguments: &ReportArguments) -> Result<Outcome, Failure> {
    let context = ReadContext::default();
    let mut lens = arguments.file.options().read(&arguments.lens, &context)?;
    super::warn_of_notes(&arguments.lens, &lens);
    lens.assume_coating();
    let bar = StepBar::start("film, field and end of the light");
    let conditions = arguments.conditions.conditions(&arguments.lens, &mut lens)?;
    bar.begin("rays of the fields", 0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let choices = ReportChoices {
        grid: ImagingGrid {
            fields: usize::from(arguments.field_count),
            pupil: usize::from(arguments.pupil),
            threads,
        },
        fields: arguments.fields.as_ref().map(|FieldShares(shares)| shares.clone()),
        frequency: arguments.frequency,
    };
    let report = LensReport::new(&lens, conditions, &choices).map_err(failure)?;
    let wanted =
        |name: &&str| arguments.json.as_deref().is_none_or(|asked| asked == ALL || asked == *name);
    let names: Vec<&str> = ANALYSES.into_iter().filter(wanted).collect();
    bar.begin("analyses", names.len());
    let sections = in_parallel(&names, threads, |name| {
        let section = report.analyse(name);
        bar.advance();
        section
    });
    let sections = sections.into_iter().collect::<Result<Vec<_>, _>>().map_err(failure)?;
    bar.begin("files", 0);
    let Some(folder) = &arguments.output else {
        let values: Vec<_> = sections.iter().map(|section| section.json(true)).collect();
        let text = match values.as_slice() {
            [one] => format!("{one:#}\n"),
            _ => format!("{:#}\n", serde_json::Value::Array(values)),
        };
        drop(bar);
        return super::super::print(&text);
    };
    let text = PageText {
        notes: lens.design.notes.iter().map(|note| with_option_names(note).into_owned()).collect(),
        command: shell_line(&argv()),
    };
    let files = report.files(&sections, &text).map_err(failure)?;
    write(folder, &files, &arguments.file.outputs(&context.files()))?;
    drop(bar);
    let page = folder.join("index.html");
    super::super::print(&format!("wrote {} files; the page is {}\n", files.len(), page.display()))
}

/// Returns the failure of an analysis as one of the command.
fn failure(error: Box<dyn std::error::Error + Send + Sync>) -> Failure {
    error
}

/// Checks the name of an analysis.
fn analysis(name: &str) -> Result<String, String> {
    match name == ALL || ANALYSES.contains(&name) {
        true => Ok(name.to_owned()),
        false => Err(format!("expected {ALL} or one of {}", ANALYSES.join(", "))),
    }
}

/// Writes all files of a report to a folder, which is created.
///
/// # Errors
/// Returns an error if a file cannot be written, or, before any is, if one is an input.
fn write(folder: &Path, files: &[ReportFile], outputs: &Outputs) -> Result<(), Failure> {
    let claim = |file: &ReportFile| {
        let claimed = outputs.claim(folder.join(&file.name));
        claimed.map_err(|error| format!("{error}; name another folder with -o"))
    };
    let claimed = files.iter().map(claim).collect::<Result<Vec<_>, _>>()?;
    let mut folders = CreatedFolders::default();
    folders
        .create(folder)
        .map_err(|error| format!("cannot create the folder {}: {error}", folder.display()))?;
    for (output, file) in claimed.iter().zip(files) {
        output
            .write(|to| to.write_all(&file.bytes))
            .map_err(|error| format!("cannot write {}: {error}", output.display()))?;
    }
    Ok(())
}
