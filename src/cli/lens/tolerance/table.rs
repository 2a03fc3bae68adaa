//! Results of an analysis, as text.

use std::fmt::Write as _;

use petzval_lens::FieldKind;
use petzval_optics::{DeviationShape, LensFigures, RadiusLimit, Refocus, ToleranceLimits};

use super::ToleranceArguments;
use super::sample::{SHARES, ToleranceSample};

/// Tolerances that are listed.
const LISTED: usize = 12;

pub(super) fn describe(
    name: &str,
    sample: &ToleranceSample,
    arguments: &ToleranceArguments,
) -> String {
    let analysis = &sample.analysis;
    let mut text = format!("{name}\n");
    let shape = match arguments.distribution {
        DeviationShape::Normal => "normal, cut off at two standard deviations",
        DeviationShape::Uniform => "uniform",
        DeviationShape::Extremes => "one limit or the other",
    };
    let film = match arguments.refocus {
        Refocus::Off => "stays",
        Refocus::Axis => "moves to the best focus of the axis",
        Refocus::Fields => "moves to the best focus of all fields",
    };
    let _ = writeln!(text, "{:<14}{} of seed {}", "trials", sample.trials.len(), arguments.seed);
    let _ = writeln!(text, "{:<14}{}", "tolerances", limits(&arguments.limits()));
    let _ = writeln!(text, "{:<14}{shape}", "errors");
    let _ = writeln!(text, "{:<14}{film}", "film");
    let wavelengths = analysis.conditions().wavelengths.len();
    let _ = writeln!(
        text,
        "{:<14}{} over {} fields and {wavelengths} wavelengths\n",
        "rays",
        analysis.rays(),
        analysis.fields().len()
    );
    let mut head = String::new();
    let _ = write!(head, "{:>12}", "nominal");
    if !sample.trials.is_empty() {
        SHARES.iter().for_each(|share| {
            let _ = write!(head, "{:>9.0} %", 100.0 * share);
        });
        let _ = write!(head, "{:>11}", "worst");
    }
    let names = field_names(sample);
    let mut block = |title: &str, larger: bool, digits: usize, rows: &[(String, Figure)]| {
        let _ = writeln!(text, "{title:<24}{head}");
        for (name, figure) in rows {
            let _ = write!(text, "{name:<24}{:>12.digits$}", figure(&analysis.nominal));
            if !sample.trials.is_empty() {
                sample.distribution(larger, figure).iter().for_each(|value| {
                    let _ = write!(text, "{value:>11.digits$}");
                });
            }
            text.push('\n');
        }
        text.push('\n');
    };
    let mut spots: Vec<(String, Figure)> = Vec::new();
    let mut modulations: Vec<(String, Figure)> = Vec::new();
    for (i, name) in names.iter().enumerate() {
        spots.push((name.clone(), Box::new(move |figures| 1e3 * figures.spots[i])));
        for (axis, letter) in ["x", "y"].into_iter().enumerate() {
            let figure = move |figures: &LensFigures| figures.modulations[i][axis];
            modulations.push((format!("{name}, {letter}"), Box::new(figure)));
        }
    }
    spots.push(("all fields".to_owned(), Box::new(|figures| 1e3 * figures.spot())));
    modulations.push(("lowest".to_owned(), Box::new(LensFigures::modulation)));
    block("RMS spot radius, um", false, 2, &spots);
    let title = format!("MTF, {} cycles/mm", arguments.frequency);
    block(&title, true, 3, &modulations);
    if arguments.refocus != Refocus::Off {
        let defocus: Figure = Box::new(|figures| 1e3 * figures.defocus.abs());
        block("movement of the film, um", false, 1, &[("size".to_owned(), defocus)]);
    }
    offenders(sample, &mut text);
    text
}

/// A figure of a lens.
type Figure = Box<dyn Fn(&LensFigures) -> f64>;

/// Lists the tolerances that cost most.
fn offenders(sample: &ToleranceSample, text: &mut String) {
    if sample.effects.is_empty() {
        text.push_str("no quantity has a tolerance\n");
        return;
    }
    let nominal = &sample.analysis.nominal;
    let _ = writeln!(
        text,
        "{:<24}{:>14}{:>14}{:>14}{:>14}{:>14}",
        "worst tolerances, alone", "limit", "spot -, um", "spot +, um", "MTF change", "correlation"
    );
    for effect in sample.effects.iter().take(LISTED) {
        let parameter = &sample.analysis.parameters[effect.parameter];
        let limit = format!("{} {}", parameter.limit, parameter.kind.unit());
        let change = |i: usize| 1e3 * (effect.at_limits[i].spot() - nominal.spot());
        let _ = write!(text, "{:<24}{:>14}", parameter.to_string(), limit.trim_end());
        let _ = write!(text, "{:>+14.3}{:>+14.3}", change(0), change(1));
        let _ = write!(text, "{:>+14.4}", effect.worst_modulation() - nominal.modulation());
        let _ = match sample.trials.len() {
            0..=2 => writeln!(text, "{:>14}", "-"),
            _ => writeln!(text, "{:>+14.3}", effect.correlation()),
        };
    }
    let rest = sample.effects.len().saturating_sub(LISTED);
    if rest > 0 {
        let _ = writeln!(text, "and {rest} others (--json lists all)");
    }
}

/// Describes limits in one line.
pub(super) fn limits(limits: &ToleranceLimits) -> String {
    let radius = match limits.radius {
        RadiusLimit::Percent(limit) => (limit, "%"),
        RadiusLimit::Fringes(limit) => (limit, "fringes"),
    };
    let all = [
        ("radius", radius),
        ("thickness", (limits.thickness, "mm")),
        ("index", (limits.index, "")),
        ("Abbe number", (limits.abbe, "%")),
        ("tilt", (limits.tilt, "arcmin")),
        ("decentre", (limits.decentre, "mm")),
        ("wedge", (limits.wedge, "arcmin")),
    ];
    let used = all.iter().filter(|(_, (limit, _))| *limit > 0.0);
    let parts: Vec<String> = used
        .map(|(name, (limit, unit))| format!("{name} {limit} {unit}").trim_end().to_owned())
        .collect();
    if parts.is_empty() { "none".to_owned() } else { parts.join(", ") }
}

/// Returns the names of the fields.
pub(super) fn field_names(sample: &ToleranceSample) -> Vec<String> {
    let unit = match sample.analysis.conditions().field_kind {
        FieldKind::Angle => "deg",
        FieldKind::ObjectHeight | FieldKind::ImageHeight => "mm",
    };
    let name = |field: &f64| match *field {
        0.0 => "axis".to_owned(),
        field => format!("field {field:+.2} {unit}"),
    };
    sample.analysis.fields().iter().map(name).collect()
}
