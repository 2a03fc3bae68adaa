//! Modulation transfer by frequency, field and focus.

use petzval_optics::{FieldRays, FrequencyAxis, TransferMethod};

use super::inputs::ReportInputs;
use super::section::{ReportSection, Table};
use super::spots::focus_step;
use crate::number::rounded;
use crate::plot::{Plot, Series, Style};

/// Steps of frequency.
const STEPS: u32 = 50;
/// Steps of focus to each side.
const FOCUS: i32 = 20;
/// Largest frequency that is shown, as a share of the diffraction limit on the axis.
const LIMIT_SHARE: f64 = 0.5;

const AXES: [(FrequencyAxis, &str, Style); 2] =
    [(FrequencyAxis::Y, "tangential", Style::Line), (FrequencyAxis::X, "sagittal", Style::Dashed)];

/// Frequencies of the curves (cycles / mm).
struct Frequencies {
    largest: f64,
    /// Frequencies of the curves over field and focus.
    few: [f64; 3],
}

fn frequencies(inputs: &ReportInputs) -> Frequencies {
    let primary = inputs.quality.conditions.primary;
    let grid = inputs.shown.first().and_then(|field| field.grids[primary].as_ref());
    let cut_off = grid.map_or(200.0, |grid| 1.0 / (grid.nm * 1e-6 * grid.working_f_number()));
    // A round number: 1, 2 or 5 times a power of ten; films and sensors end at about 200.
    let reach = (LIMIT_SHARE * cut_off).min(200.0);
    let power = 10f64.powf(reach.log10().floor());
    let round = [1.0, 2.0, 5.0].map(|digit| digit * power).into_iter().rfind(|f| *f <= reach);
    let largest = inputs.frequency.unwrap_or_else(|| round.unwrap_or(reach));
    Frequencies { largest, few: [0.1, 0.2, 0.4].map(|share| share * largest) }
}

pub(super) fn by_frequency(inputs: &ReportInputs) -> ReportSection {
    let frequencies = frequencies(inputs);
    let methods = [TransferMethod::Diffraction, TransferMethod::Geometric, TransferMethod::Limit];
    let steps: Vec<f64> =
        (0..=STEPS).map(|i| frequencies.largest * f64::from(i) / f64::from(STEPS)).collect();
    let curves: Vec<Vec<Vec<f64>>> = inputs
        .shown
        .iter()
        .map(|field| {
            let mut rows: Vec<Vec<f64>> = steps.iter().map(|f| vec![field.field, *f]).collect();
            for method in methods {
                for (axis, ..) in AXES {
                    let values = field.modulations(&steps, axis, method, 0.0);
                    for (row, value) in rows.iter_mut().zip(values) {
                        row.push(value.unwrap_or(f64::NAN));
                    }
                }
            }
            rows
        })
        .collect();
    let mut plots = Vec::new();
    for (title, column, name) in
        [("Diffraction MTF", 2, "diffraction"), ("Geometric MTF", 4, "geometric")]
    {
        let mut series = Vec::new();
        for (i, rows) in curves.iter().enumerate() {
            for (k, (_, label, style)) in AXES.iter().enumerate() {
                let label = &label[..1].to_uppercase();
                series.push(Series {
                    name: format!("{label} {}", inputs.field_name(inputs.shown[i].field)),
                    colour: inputs.field_colour(i),
                    style: *style,
                    points: rows.iter().map(|row| [row[1], row[column + k]]).collect(),
                });
            }
        }
        if let Some(rows) = curves.first() {
            series.push(Series {
                name: "limit".to_owned(),
                colour: 6,
                points: rows.iter().map(|row| [row[1], row[6]]).collect(),
                ..Series::default()
            });
        }
        plots.push(plot(name, title, "frequency (cycles/mm)".to_owned(), series));
    }
    let columns = [
        inputs.field_column(),
        "frequency_per_mm",
        "diffraction_tangential",
        "diffraction_sagittal",
        "geometric_tangential",
        "geometric_sagittal",
        "limit_tangential",
        "limit_sagittal",
    ];
    ReportSection {
        name: "mtf",
        title: "Modulation transfer",
        note: "In the light of all wavelengths by their weights. Tangential: frequency along y, \
               away from the axis. The limit is the same pupil with a perfect wavefront."
            .to_owned(),
        tables: vec![Table::new("", &columns, curves.into_iter().flatten().collect())],
        plots,
        ..ReportSection::default()
    }
}

fn plot(name: &str, title: &str, axis: String, series: Vec<Series>) -> Plot {
    Plot {
        name: name.to_owned(),
        title: title.to_owned(),
        axes: [axis, "modulation".to_owned()],
        series,
        ranges: [None, Some([0.0, 1.02])],
        ..Plot::default()
    }
}

pub(super) fn by_field(inputs: &ReportInputs) -> ReportSection {
    let few = frequencies(inputs).few;
    let rows: Vec<Vec<f64>> = inputs
        .quality
        .fields
        .iter()
        .map(|field| {
            let curves = AXES
                .map(|(axis, ..)| field.modulations(&few, axis, TransferMethod::Diffraction, 0.0));
            let values = (0..few.len()).flat_map(|i| curves.each_ref().map(|curve| curve[i]));
            let values = values.map(|value| value.unwrap_or(f64::NAN));
            std::iter::once(field.field).chain(values).collect()
        })
        .collect();
    let mut series = Vec::new();
    let mut columns = vec![inputs.field_column().to_owned()];
    for (i, frequency) in few.iter().enumerate() {
        for (k, (_, label, style)) in AXES.iter().enumerate() {
            columns.push(format!("{label}_{}_per_mm", rounded(*frequency)));
            series.push(Series {
                name: format!("{} {}/mm", &label[..1].to_uppercase(), rounded(*frequency)),
                colour: 2 * i,
                style: *style,
                points: rows.iter().map(|row| [row[0], row[1 + 2 * i + k]]).collect(),
            });
        }
    }
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    ReportSection {
        name: "mtf-field",
        title: "Modulation transfer over the field",
        note: "By diffraction, in the light of all wavelengths.".to_owned(),
        tables: vec![Table::new("", &columns, rows)],
        plots: vec![plot("", "MTF over the field", inputs.field_axis(), series)],
        ..ReportSection::default()
    }
}

pub(super) fn by_focus(inputs: &ReportInputs) -> ReportSection {
    let frequency = frequencies(inputs).few[1];
    // Far enough to see each field's best focus.
    let wanted = inputs
        .shown
        .iter()
        .filter_map(|field| field.spot().best_defocus())
        .map(f64::abs)
        .fold(2.0 * focus_step(inputs), f64::max);
    let step = 1.5 * wanted / f64::from(FOCUS);
    let row = |field: &FieldRays, i: i32| -> Vec<f64> {
        let defocus = f64::from(i) * step;
        let value = |axis| {
            let value = field.modulation(frequency, axis, TransferMethod::Diffraction, defocus);
            value.unwrap_or(f64::NAN)
        };
        vec![field.field, 1e3 * defocus, value(FrequencyAxis::Y), value(FrequencyAxis::X)]
    };
    let curves: Vec<Vec<Vec<f64>>> = inputs
        .shown
        .iter()
        .map(|field| (-FOCUS..=FOCUS).map(|i| row(field, i)).collect())
        .collect();
    let mut series = Vec::new();
    for (i, rows) in curves.iter().enumerate() {
        for (k, (_, label, style)) in AXES.iter().enumerate() {
            series.push(Series {
                name: format!(
                    "{} {}",
                    &label[..1].to_uppercase(),
                    inputs.field_name(inputs.shown[i].field)
                ),
                colour: inputs.field_colour(i),
                style: *style,
                points: rows.iter().map(|row| [row[1], row[2 + k]]).collect(),
            });
        }
    }
    let columns = [inputs.field_column(), "defocus_um", "tangential", "sagittal"];
    ReportSection {
        name: "mtf-focus",
        title: "Modulation transfer through focus",
        note: format!(
            "By diffraction, at {} cycles/mm; the film moves back by the defocus.",
            rounded(frequency)
        ),
        figures: vec![("frequency".to_owned(), frequency, "1/mm")],
        tables: vec![Table::new("", &columns, curves.into_iter().flatten().collect())],
        plots: vec![plot("", "MTF through focus", "defocus (µm)".to_owned(), series)],
        ..ReportSection::default()
    }
}
