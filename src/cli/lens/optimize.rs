//! `petzval lens optimize`: improves a lens by damped least squares.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use petzval_base::io::ReadContext;
use petzval_lens::Prescription;
use petzval_optics::{
    DesignGoal, DesignTarget, DesignVariable, OptimizedDesign, Refocus, StopReason, TargetKind,
    VariableKind, optimize_design,
};

use super::conditions::{FieldArguments, refocus};
use super::convert::save;
use super::tolerance::check_toml;
use crate::cli::arguments::lens_file::LensFileArguments;
use crate::cli::arguments::values::signed_length;
use crate::cli::outputs::claim_writable;
use crate::cli::progress::StepBar;
use crate::cli::{Failure, Outcome, signals};

/// Arguments of `petzval lens optimize`.
#[derive(Debug, clap::Args)]
pub(super) struct OptimizeArguments {
    /// Lens file
    lens: PathBuf,
    /// TOML lens file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    file: LensFileArguments,
    #[command(flatten)]
    conditions: FieldArguments,
    /// Variables: r3 (radius of surface 3), c3 (its curvature), t3 (thickness behind it), k3
    /// (conic), a3_6 (asphere coefficient of power 6), n3 (index behind it), film (its distance)
    #[arg(long, value_name = "NAME,...", required = true, value_delimiter = ',')]
    vary: Vec<String>,
    /// Target, may be repeated
    ///
    /// efl=MM, spot, distortion=PERCENT, bfd=MM or film=MM; :WEIGHT behind it for another weight
    /// than 1
    #[arg(long, value_name = "NAME=VALUE", required = true)]
    target: Vec<DesignTarget>,
    /// Bounds of a variable other than a radius, may be repeated: t3=1..8
    #[arg(long, value_name = "NAME=A..B", value_parser = bound, allow_hyphen_values = true)]
    bound: Vec<Bound>,
    /// Least thickness of elements and gaps at their rims, mm
    #[arg(long, value_name = "MM", default_value_t = 0.1, value_parser = edge)]
    min_edge: f64,
    /// Film of each lens that is tried
    ///
    /// Moved to the best focus of all fields or of the axis, or off: it stays [default: fields; off
    /// if film is a variable]
    #[arg(long, value_name = "fields|axis|off", value_parser = refocus)]
    refocus: Option<Refocus>,
    /// Hexapolar rings of rays over the stop: 5 are 91 rays
    #[arg(
        long,
        value_name = "N",
        default_value_t = 5,
        value_parser = clap::value_parser!(u32).range(2..=30)
    )]
    rings: u32,
    /// Most iterations
    #[arg(
        long,
        value_name = "N",
        default_value_t = 500,
        value_parser = clap::value_parser!(u32).range(1..=100_000)
    )]
    iterations: u32,
}

/// Bounds of a variable by its name.
#[derive(Clone, Debug)]
struct Bound {
    name: String,
    range: [f64; 2],
}

fn bound(text: &str) -> Result<Bound, String> {
    let parts = text.split_once('=').and_then(|(name, range)| {
        let (low, high) = range.split_once("..")?;
        let range = [low.parse().ok()?, high.parse().ok()?];
        (range[0] < range[1]).then(|| Bound { name: name.to_owned(), range })
    });
    parts.ok_or_else(|| "expected NAME=A..B with A below B, such as t3=1..8".to_owned())
}

/// Parses a length (mm) of any sign, with its unit or without.
fn edge(text: &str) -> Result<f64, String> {
    signed_length(text).ok_or_else(|| "expected a length such as 0.5 or 0.5mm".to_owned())
}

pub(super) fn run(arguments: &OptimizeArguments) -> Result<Outcome, Failure> {
    let context = ReadContext::default();
    let mut lens = arguments.file.options().read(&arguments.lens, &context)?;
    super::warn_of_notes(&arguments.lens, &lens);
    check_toml(&arguments.output)?;
    let outputs = arguments.file.outputs(&context.files());
    let output = claim_writable(&outputs, &arguments.output, "--output")?;
    let conditions = arguments.conditions.conditions(&arguments.lens, &mut lens)?;
    let variables = variables(arguments, &lens, conditions.film_distance)?;
    let varies_film = variables.iter().any(|variable| variable.kind == VariableKind::Film);
    let refocus = match (arguments.refocus, varies_film) {
        (None, true) => Refocus::Off,
        (Some(Refocus::Axis | Refocus::Fields), true) => {
            return Err(
                "--vary film: --refocus moves the film as well; leave one of them out".into()
            );
        }
        (chosen, _) => chosen.unwrap_or(Refocus::Fields),
    };
    let shares = match lens.is_round() {
        true => arguments.conditions.shares(),
        false => arguments.conditions.both_signs(),
    };
    let goal = DesignGoal {
        variables,
        targets: arguments.target.clone(),
        refocus,
        least_edge: arguments.min_edge,
        shares,
        rings: arguments.rings,
        iterations: arguments.iterations,
        threads: arguments.conditions.threads(),
    };
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&stop);
    // A second signal ends the command at once.
    signals::on_stop(move || !asked.swap(true, Ordering::Relaxed));
    let bar = StepBar::start("iterations");
    bar.begin("iterations", goal.iterations as usize);
    let design = optimize_design(&lens, &conditions, &goal, |_, _| {
        bar.advance();
        !stop.load(Ordering::Relaxed)
    })
    .map_err(|error| format!("{}: {error}", arguments.lens.display()))?;
    drop(bar);
    save(&output, &design.lens)?;
    let outcome = super::super::print(&describe(&goal, &design))?;
    match design.reason {
        StopReason::Interrupted => Ok(Outcome::Interrupted),
        _ => Ok(outcome),
    }
}

/// Finds the variables with their bounds.
fn variables(
    arguments: &OptimizeArguments,
    lens: &Prescription,
    film: f64,
) -> Result<Vec<DesignVariable>, Failure> {
    let mut variables: Vec<DesignVariable> = Vec::new();
    for name in &arguments.vary {
        let variable = DesignVariable::named(name.trim(), lens)?;
        let same = |other: &DesignVariable| {
            let curvature = |kind| match kind {
                VariableKind::Radius => VariableKind::Curvature,
                kind => kind,
            };
            other.row == variable.row && curvature(other.kind) == curvature(variable.kind)
        };
        if variables.iter().any(same) {
            return Err(format!("--vary {name}: the variable is there twice; name it once").into());
        }
        variables.push(variable);
    }
    for Bound { name, range } in &arguments.bound {
        let found = variables.iter_mut().find(|variable| variable.to_string() == *name);
        let Some(variable) = found else {
            return Err(format!("--bound {name}: no such variable; name it in --vary").into());
        };
        if variable.kind == VariableKind::Radius {
            let curvature = name.replacen('r', "c", 1);
            return Err(format!(
                "--bound {name}: a radius has no bounds, as it passes infinity; vary {curvature} and \
                 bound it, in 1/mm"
            )
            .into());
        }
        let value = variable.value(lens, film);
        if !(range[0]..=range[1]).contains(&value) {
            let [low, high] = range;
            return Err(format!(
                "--bound {name}={low}..{high}: the lens begins at {value}; give bounds around it"
            )
            .into());
        }
        variable.bounds = *range;
    }
    Ok(variables)
}

/// Describes what changed and why it stopped.
fn describe(goal: &DesignGoal, design: &OptimizedDesign) -> String {
    let OptimizedDesign { start, end, .. } = design;
    let mut text = format!("{:<16}{:>18}{:>18}{:>18}\n", "", "start", "end", "change");
    let mut line = |name: &str, [start, end]: [f64; 2], unit: &str| {
        let shown = |value: f64| match value.abs() {
            0.0 => "0".to_owned(),
            size if !(1e-3..1e7).contains(&size) => format!("{value:.6e}"),
            _ => format!("{value:.6}"),
        };
        let line = format!(
            "{name:<16}{:>18}{:>18}{:>18}  {unit}",
            shown(start),
            shown(end),
            shown(end - start)
        );
        let _ = writeln!(text, "{}", line.trim_end());
    };
    for (i, variable) in goal.variables.iter().enumerate() {
        let shown = [start, end].map(|state| variable.shown(state.variables[i]));
        let unit = match variable.kind {
            VariableKind::Radius | VariableKind::Thickness | VariableKind::Film => "mm",
            VariableKind::Curvature => "1/mm",
            VariableKind::Conic | VariableKind::Asphere(_) | VariableKind::Index => "",
        };
        line(&variable.to_string(), shown, unit);
    }
    for (i, target) in goal.targets.iter().enumerate() {
        let unit = match target.kind {
            TargetKind::Spot => "mm  (target 0)".to_owned(),
            kind => format!("{}  (target {})", kind.unit(), target.value),
        };
        line(&target.kind.to_string(), [start, end].map(|state| state.targets[i]), &unit);
    }
    line("film distance", [start, end].map(|state| state.film_distance), "mm");
    line("merit", [start.merit, end.merit], "mm  (root of the weighted sum of squares)");
    let _ = writeln!(text, "stopped after {} iterations: {}", design.iterations, design.reason);
    text
}
