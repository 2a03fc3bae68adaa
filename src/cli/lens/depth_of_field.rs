//! `petzval lens depth-of-field`: near and far limits of sharpness by f-number and distance.

use std::fmt::Write as _;
use std::path::PathBuf;

use petzval_base::io::{Outputs, ReadContext};
use petzval_lens::{
    FocusError, FocusModel, Paraxial, Prescription, PupilSampling, RealLens, RealRayFocus,
    TransverseAxis,
};
use petzval_render::aov::CircleOfConfusion;
use petzval_render::prepare::settings::{self, number_with_unit};
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
    /// f-numbers, by default whole stops from 1.4 to 22 to which the lens opens
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = typed(settings::f_number))]
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
    let diameter = number_with_unit(text, &[("um", 1.0), ("mm", 1e3)], 1.0);
    let known = diameter.filter(|um| (0.01..=1e5).contains(um));
    known.ok_or_else(|| "expected a diameter from 0.01 to 100000 um".to_owned())
}

/// Whole stops.
const STOPS: [f64; 9] = [1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0, 22.0];

/// Limits about one distance in focus, from the film (mm).
struct Limits {
    focus: f64,
    /// The nearest and the farthest distance, if the lens can focus there.
    ends: Ends,
}

/// Ends of sharpness, from the film (mm).
#[derive(Clone, Copy)]
enum Ends {
    Between([f64; 2]),
    /// The lens cannot focus so near.
    TooNear,
    /// The circle of confusion is larger than the blur of any distance.
    All,
}

impl Ends {
    fn distances(self) -> Option<[f64; 2]> {
        match self {
            Self::Between(ends) => Some(ends),
            Self::TooNear | Self::All => None,
        }
    }
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
    let in_plane = |plane| Paraxial::in_plane(&lens, plane).focal_length;
    let [across, along] = [TransverseAxis::X, TransverseAxis::Y].map(in_plane);
    if (across / along - 1.0).abs() > 1e-6 {
        say!(
            "petzval: warning: {}: this lens is anamorphic; the limits are those along x",
            arguments.lens.display()
        );
    }
    let mut f_numbers = arguments.fstop.clone();
    if f_numbers.is_empty() {
        let opens = |f_number: &f64| lens.f_number_diameter(*f_number).is_ok();
        f_numbers = STOPS.into_iter().filter(opens).collect();
        if f_numbers.is_empty() {
            let widest = RealRayFocus::new(&lens).f_number();
            f_numbers.extend(widest.map(|f_number| (10.0 * f_number).ceil() / 10.0));
        }
    }
    let rows = f_numbers.iter().map(|&f_number| row(&lens, f_number, arguments, circle));
    let rows = rows.collect::<Result<Vec<Row>, Failure>>()?;
    if let Some(csv) = &arguments.csv {
        write_text(&Outputs::beside(&context.files()), csv, "--csv", &table(&rows))?;
    }
    crate::cli::print(&match arguments.json {
        true => format!("{:#}\n", json_of(&rows, circle)),
        false => text_of(&rows, arguments.film_size, circle),
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
    let at = |focus: f64| -> Result<(CircleOfConfusion, f64), FocusError> {
        let (lens, film) = lens.focused(focus, FocusModel::Sharpest, diagonal)?;
        let position = lens.film_position(film);
        let lens = RealLens::new(lens, film, diagonal / 2.0, PupilSampling::Axis, 1.0, 0.0);
        Ok((CircleOfConfusion::of_lens(&lens), position))
    };
    let named = |error: FocusError| format!("{}: {error}", arguments.lens.display());
    let (distant, film) = at(f64::INFINITY).map_err(named)?;
    let mut limits = Vec::new();
    for &focus in &arguments.focus {
        let ends = match at(focus) {
            Ok((blur, film)) => match blur.depth_of_field(focus - film, circle) {
                Some(ends) => Ends::Between(ends.map(|end| end + film)),
                None => Ends::All,
            },
            Err(FocusError::TooNear { .. }) => Ends::TooNear,
            Err(error) => return Err(named(error).into()),
        };
        limits.push(Limits { focus, ends });
    }
    let hyperfocal = distant.hyperfocal(circle) + film;
    Ok(Row { f_number, hyperfocal, limits })
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
            let ends = match ends {
                Ends::Between(ends) => ends.map(metres),
                Ends::TooNear => [String::new(), String::new()],
                Ends::All => ["0", "inf"].map(str::to_owned),
            };
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

fn text_of(rows: &[Row], [width, height]: [f64; 2], circle: f64) -> String {
    let mut text = format!(
        "nearest and farthest sharp distance from the film (m), for {width} x {height} mm and circles of confusion of \
         {:.1} um on the axis\n\n\
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
            let cell = match ends {
                Ends::Between(ends) => {
                    let [near, far] = ends.map(metres);
                    format!("{near} {far:>8}")
                }
                Ends::TooNear => "too near".to_owned(),
                Ends::All => "all".to_owned(),
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
            "near_m": limits.ends.distances().map(|ends| metres(ends[0])),
            "far_m": limits.ends.distances().and_then(|ends| metres(ends[1])),
            "focuses": !matches!(limits.ends, Ends::TooNear),
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
