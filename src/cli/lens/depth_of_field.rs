//! `petzval lens depth-of-field`: near and far limits of sharpness by f-number and distance.

use std::fmt::Write as _;
use std::path::PathBuf;

use petzval_base::io::{Outputs, ReadContext};
use petzval_lens::{FocusModel, Prescription, PupilSampling, RealLens};
use petzval_render::aov::CircleOfConfusion;
use petzval_render::prepare::settings;
use serde_json::{Value, json};

use crate::cli::arguments::lens_file::LensFileArguments;
use crate::cli::arguments::values::{focus_distance, sensor_size, typed};
use crate::cli::outputs::write_text;
use crate::cli::{Failure, Outcome};

/// Arguments of `petzval lens depth-of-field`.
#[derive(Debug, clap::Args)]
pub(super) struct DepthOfFieldArguments {
    /// Lens file of any format that petzval reads
    lens: PathBuf,
    /// Size of the film or sensor, such as 36x24 (mm), or a name such as 35mm or nikon-d850
    #[arg(long, value_name = "WxH|NAME", value_parser = sensor_size, default_value = "35mm")]
    film_size: [f64; 2],
    /// f-numbers
    #[arg(
        long,
        value_name = "N,...",
        value_delimiter = ',',
        value_parser = typed(settings::f_number),
        default_value = "2,2.8,4,5.6,8,11,16"
    )]
    fstop: Vec<f64>,
    /// Distances in focus from the film, such as 0.5,1,2 or 850mm,inf; numbers alone are in metres
    #[arg(
        long,
        value_name = "2m,...",
        value_delimiter = ',',
        value_parser = focus_distance,
        default_value = "0.5,1,2,3,5,10,inf"
    )]
    focus: Vec<f64>,
    /// Diameter on the film of the circle of confusion that counts as sharp (um)
    ///
    /// By default a 1500th of the diagonal: 28.8 um for 35mm
    #[arg(long, value_name = "UM", value_parser = blur)]
    blur: Option<f64>,
    #[command(flatten)]
    file: LensFileArguments,
    /// Write the table to this file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Parses a diameter (um).
fn blur(text: &str) -> Result<f64, String> {
    let text = text.trim().trim_end_matches("um");
    let diameter = text.trim().parse().ok().filter(|um: &f64| (0.01..=1e5).contains(um));
    diameter.ok_or_else(|| "expected a diameter from 0.01 to 100000 um".to_owned())
}

/// Limits about one distance in focus, from the film (mm).
struct Limits {
    focus: f64,
    /// The nearest and the farthest distance; `None` if the lens cannot focus there.
    ends: Option<[f64; 2]>,
}

/// Limits of one f-number.
struct Row {
    f_number: f64,
    /// Distance at which infinity is just sharp, from the film (mm).
    hyperfocal: f64,
    limits: Vec<Limits>,
}

pub(super) fn run(arguments: &DepthOfFieldArguments) -> Result<Outcome, Failure> {
    let context = ReadContext::default();
    let lens = arguments.file.options().read(&arguments.lens, &context)?;
    super::warn_of_notes(&arguments.lens, &lens);
    let diagonal = arguments.film_size[0].hypot(arguments.film_size[1]);
    let circle =
        arguments.blur.map_or_else(|| CircleOfConfusion::sharp_diameter(diagonal), |um| 1e-3 * um);
    let rows = arguments.fstop.iter().map(|&f_number| row(&lens, f_number, arguments, circle));
    let rows = rows.collect::<Result<Vec<Row>, Failure>>()?;
    if let Some(csv) = &arguments.csv {
        write_text(&Outputs::beside(&context.files()), csv, "--csv", &table(&rows))?;
    }
    crate::cli::print(&match arguments.json {
        true => format!("{:#}\n", json_of(&rows, circle)),
        false => text_of(&rows, circle),
    })
}

/// Returns the limits at an f-number.
fn row(
    lens: &Prescription,
    f_number: f64,
    arguments: &DepthOfFieldArguments,
    circle: f64,
) -> Result<Row, Failure> {
    let diagonal = arguments.film_size[0].hypot(arguments.film_size[1]);
    let mut lens = lens.clone();
    let diameter = lens
        .f_number_diameter(f_number)
        .map_err(|error| format!("--fstop {f_number}: {} {error}", lens.name))?;
    lens.stop_down(diameter);
    let at = |focus: f64| -> Result<(CircleOfConfusion, f64), Failure> {
        let model = FocusModel::Sharpest;
        let focused = match lens.focus_by_groups(focus, model, diagonal) {
            Some(focused) => focused,
            None => model.film(&lens, focus, diagonal).map(|film| (lens.clone(), film)),
        };
        let (lens, film) =
            focused.map_err(|error| format!("{}: {error}", arguments.lens.display()))?;
        let position = lens.film_position(film);
        let lens = RealLens::new(lens, film, diagonal / 2.0, PupilSampling::Axis, 1.0, 0.0);
        Ok((CircleOfConfusion::of_lens(&lens), position))
    };
    let (distant, film) = at(f64::INFINITY)?;
    let limits = arguments.focus.iter().map(|&focus| {
        // A lens that cannot focus so near has no limits there.
        let ends = at(focus).ok().and_then(|(blur, film)| {
            let ends = blur.depth_of_field(focus - film, circle)?;
            Some(ends.map(|end| end + film))
        });
        Limits { focus, ends }
    });
    let hyperfocal = distant.hyperfocal(circle) + film;
    Ok(Row { f_number, hyperfocal, limits: limits.collect() })
}

/// Returns a distance (mm) in metres.
fn metres(mm: f64) -> String {
    match mm.is_finite() {
        true => format!("{:.3}", 1e-3 * mm),
        false => "inf".to_owned(),
    }
}

fn table(rows: &[Row]) -> String {
    let mut text = "f-number,hyperfocal_m,focus_m,near_m,far_m\n".to_owned();
    for row in rows {
        for Limits { focus, ends } in &row.limits {
            let ends = ends.map_or([String::new(), String::new()], |ends| ends.map(metres));
            let _ = writeln!(
                text,
                "{},{},{},{},{}",
                row.f_number,
                metres(row.hyperfocal),
                metres(*focus),
                ends[0],
                ends[1]
            );
        }
    }
    text
}

fn text_of(rows: &[Row], circle: f64) -> String {
    let mut text = format!(
        "nearest and farthest sharp distance from the film (m), for circles of confusion of {:.1} um on the axis\n\n\
         {:>8}  {:>10}",
        1e3 * circle,
        "f-number",
        "hyperfocal"
    );
    for limits in rows.first().map_or(&[][..], |row| &row.limits) {
        let _ = write!(text, "  {:>16}", format!("{} m", metres(limits.focus)));
    }
    text.push('\n');
    for row in rows {
        let _ = write!(text, "{:>8}  {:>10}", row.f_number, metres(row.hyperfocal));
        for Limits { ends, .. } in &row.limits {
            let cell = match ends.map(|ends| ends.map(metres)) {
                Some([near, far]) => format!("{near} {far:>8}"),
                None => "too near".to_owned(),
            };
            let _ = write!(text, "  {cell:>16}");
        }
        text.push('\n');
    }
    text
}

fn json_of(rows: &[Row], circle: f64) -> Value {
    let metres = |mm: f64| mm.is_finite().then_some(1e-3 * mm);
    let limits = |limits: &Limits| {
        json!({
            "focus_m": metres(limits.focus),
            "near_m": limits.ends.map(|ends| metres(ends[0])),
            "far_m": limits.ends.and_then(|ends| metres(ends[1])),
            "focuses": limits.ends.is_some(),
        })
    };
    let row = |row: &Row| {
        json!({
            "f_number": row.f_number,
            "hyperfocal_m": metres(row.hyperfocal),
            "limits": row.limits.iter().map(limits).collect::<Vec<Value>>(),
        })
    };
    json!({ "blur_um": 1e3 * circle, "rows": rows.iter().map(row).collect::<Vec<Value>>() })
}
