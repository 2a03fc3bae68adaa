//! `petzval lens report`: every analysis of a lens, as JSON, CSV, SVG and one page.

mod curves;
mod fans;
mod files;
mod first_order;
mod heading;
mod inputs;
mod light;
mod missing;
mod page;
mod picture;
mod plot;
mod point;
mod section;
mod spots;
mod transfer;
mod wave;

use std::path::PathBuf;

use petzval_base::io::ReadContext;
use petzval_optics::{ImageQuality, ImagingGrid, in_parallel};

use super::conditions::{ConditionArguments, FieldShares, field_shares};
use crate::cli::arguments::lens_file::LensFileArguments;
use crate::cli::arguments::values::frequency;
use crate::cli::progress::StepBar;
use crate::cli::{Failure, Outcome};
use inputs::ReportInputs;
use section::ReportSection;

pub(super) use inputs::rounded;
pub(in crate::cli) use point::point_report;

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

/// Fields that are shown one by one without statements of the lens file, as shares of the largest.
const SHOWN: [f64; 5] = [0.0, 0.5, 0.7, 0.85, 1.0];
/// Most stated fields that are shown.
const MOST_SHOWN: usize = 12;

pub(super) fn run(arguments: &ReportArguments) -> Result<Outcome, Failure> {
    let context = ReadContext::default();
    let mut lens = arguments.file.options().read(&arguments.lens, &context)?;
    super::warn_of_notes(&arguments.lens, &lens);
    lens.assume_coating();
    let bar = StepBar::start("film, field and end of the light");
    let conditions = arguments.conditions.conditions(&arguments.lens, &mut lens)?;
    bar.begin("rays of the fields", 0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let grid = ImagingGrid {
        fields: usize::from(arguments.field_count),
        pupil: usize::from(arguments.pupil),
        threads,
    };
    let lens = lens.at_wavelength(conditions.primary_line().nm)?;
    let quality = ImageQuality::new(&lens, conditions, grid)?;
    let (mut shown, mut left_out) = (Vec::new(), quality.left_out.clone());
    for field in shown_fields(&quality, arguments.fields.as_ref()) {
        match quality.field(field, grid.pupil) {
            Some(rays) => shown.push(rays),
            None => left_out.push(field),
        }
    }
    left_out.sort_by(f64::total_cmp);
    left_out.dedup();
    let inputs = ReportInputs::new(lens, quality, (shown, left_out), arguments.frequency);
    let wanted =
        |name: &&str| arguments.json.as_deref().is_none_or(|asked| asked == ALL || asked == *name);
    let names: Vec<&str> = ANALYSES.into_iter().filter(wanted).collect();
    bar.begin("analyses", names.len());
    let sections = in_parallel(&names, threads, |name| -> Result<ReportSection, String> {
        let mut section = section(name, &inputs).map_err(|error| error.to_string())?;
        missing::state_missing(&mut section, &inputs);
        bar.advance();
        Ok(section)
    });
    let sections = sections.into_iter().collect::<Result<Vec<_>, String>>()?;
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
    let count =
        files::write(folder, &inputs, &sections, &arguments.file.outputs(&context.files()))?;
    drop(bar);
    let page = folder.join("index.html");
    super::super::print(&format!("wrote {count} files; the page is {}\n", page.display()))
}

/// Name of all analyses together.
const ALL: &str = "all";

/// Checks the name of an analysis.
fn analysis(name: &str) -> Result<String, String> {
    match name == ALL || ANALYSES.contains(&name) {
        true => Ok(name.to_owned()),
        false => Err(format!("expected {ALL} or one of {}", ANALYSES.join(", "))),
    }
}

/// Returns the fields that are shown one by one, in ascending order.
fn shown_fields(quality: &ImageQuality, asked: Option<&FieldShares>) -> Vec<f64> {
    let conditions = &quality.conditions;
    if let Some(FieldShares(shares)) = asked {
        let mut shares = shares.clone();
        shares.sort_by(f64::total_cmp);
        shares.dedup();
        return shares.iter().map(|share| share * conditions.largest_field).collect();
    }
    let mut fields = conditions.stated_fields.clone();
    fields.sort_by(f64::total_cmp);
    fields.dedup();
    if fields.is_empty() || fields.len() > MOST_SHOWN {
        fields = SHOWN.map(|share| share * conditions.largest_field).to_vec();
    }
    fields
}

/// Names of the analyses, in the order of the page.
const ANALYSES: [&str; 19] = [
    "prescription",
    "first-order",
    "seidel",
    "ray-fan",
    "opd-fan",
    "spot",
    "field-curvature",
    "distortion",
    "lateral-colour",
    "longitudinal",
    "relative-illumination",
    "vignetting",
    "mtf",
    "mtf-field",
    "mtf-focus",
    "wavefront",
    "psf",
    "encircled-energy",
    "ghosts",
];

fn section(name: &str, inputs: &ReportInputs) -> Result<ReportSection, Failure> {
    Ok(match name {
        "prescription" => first_order::prescription(inputs),
        "first-order" => first_order::first_order(inputs)?,
        "seidel" => first_order::seidel(inputs)?,
        "ray-fan" => fans::rays(inputs),
        "opd-fan" => fans::paths(inputs),
        "spot" => spots::spots(inputs),
        "field-curvature" => curves::curvature(inputs),
        "distortion" => curves::distortion(inputs),
        "lateral-colour" => curves::lateral_colour(inputs),
        "longitudinal" => curves::longitudinal(inputs),
        "relative-illumination" => light::relative_illumination(inputs),
        "vignetting" => light::vignetting(inputs),
        "mtf" => transfer::by_frequency(inputs),
        "mtf-field" => transfer::by_field(inputs),
        "mtf-focus" => transfer::by_focus(inputs),
        "wavefront" => wave::wavefronts(inputs)?,
        "psf" => wave::psf(inputs)?,
        "encircled-energy" => wave::encircled_energy(inputs),
        _ => light::ghosts(inputs),
    })
}
