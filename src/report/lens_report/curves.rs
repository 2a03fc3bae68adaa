//! Curves over the field and the pupil: field curvature, distortion, lateral and longitudinal colour.

use petzval_optics::FieldCurvePoint;

use super::inputs::ReportInputs;
use super::missing::Absence;
use super::section::{ReportSection, Table, WAVELENGTH_COLUMN};
use crate::number::tidy;
use crate::plot::{Plot, Series, Style};

/// Steps from the axis to the edge of the field.
const STEPS: u32 = 50;
/// Zones of the pupil.
const ZONES: u32 = 20;
/// Lines of the distortion grid to each side of the axis.
const GRID: i32 = 5;
/// Largest displacement in the picture of the grid, in cells.
const MOST_DISPLACED: f64 = 0.75;
/// Exaggerations of the distortion.
const EXAGGERATIONS: [f64; 10] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];

/// Imagery next to the chief rays, by wavelength.
pub(super) struct FieldCurves(Vec<Vec<FieldCurvePoint>>);

impl FieldCurves {
    pub fn new(inputs: &ReportInputs) -> Self {
        Self(inputs.wavelengths().map(|w| inputs.quality.field_curve(w, STEPS)).collect())
    }

    fn primary(&self, inputs: &ReportInputs) -> &[FieldCurvePoint] {
        &self.0[inputs.quality.conditions.primary]
    }

    fn table(
        &self,
        inputs: &ReportInputs,
        names: &[&str],
        values: impl Fn(&FieldCurvePoint) -> Vec<f64>,
    ) -> Table {
        let mut columns = vec![WAVELENGTH_COLUMN, inputs.field_column(), "angle_deg"];
        columns.extend(names);
        let rows = self.0.iter().enumerate().flat_map(|(wavelength, curve)| {
            let nm = inputs.nm(wavelength);
            let row = |point: &FieldCurvePoint| {
                let mut row = vec![nm, point.field, point.angle];
                row.extend(values(point));
                row
            };
            curve.iter().map(row).collect::<Vec<_>>()
        });
        Table::new("", &columns, rows.collect())
    }
}

pub(super) fn curvature(inputs: &ReportInputs) -> ReportSection {
    let curves = inputs.field_curves();
    let table = curves
        .table(inputs, &["sagittal_focus_mm", "tangential_focus_mm"], |point| point.foci.to_vec());
    let mut series = Vec::new();
    for (wavelength, curve) in curves.0.iter().enumerate() {
        for (axis, name, style) in [(1, "T", Style::Line), (0, "S", Style::Dashed)] {
            series.push(Series {
                name: format!("{name} {}", inputs.wavelength_name(wavelength)),
                colour: inputs.wavelength_colour(wavelength),
                style,
                points: curve.iter().map(|p| [p.foci[axis], p.field]).collect(),
            });
        }
    }
    ReportSection {
        name: "field-curvature",
        title: "Field curvature and astigmatism",
        note: "Tangential (T) and sagittal (S) focus of rays next to the chief ray, behind the \
               film along the axis."
            .to_owned(),
        tables: vec![table],
        plots: vec![Plot {
            name: String::new(),
            title: "Field curvature".to_owned(),
            axes: ["focus behind the film (mm)".to_owned(), inputs.field_axis()],
            series,
            ..Plot::default()
        }],
        absences: vec![
            Absence::of_lens("sagittal", "rays next to the chief ray are parallel"),
            Absence::of_lens("tangential", "rays next to the chief ray are parallel"),
        ],
        ..ReportSection::default()
    }
}

pub(super) fn distortion(inputs: &ReportInputs) -> ReportSection {
    let curves = inputs.field_curves();
    let percent = |share: Option<f64>| share.map_or(f64::NAN, |share| 100.0 * share);
    let columns =
        ["height_mm", "linear_height_mm", "distortion_percent", "f_theta_distortion_percent"];
    let table = curves.table(inputs, &columns, |point| {
        vec![
            point.height,
            point.linear_height,
            percent(point.distortion()),
            percent(point.f_theta_distortion()),
        ]
    });
    let primary = curves.primary(inputs);
    let edge = primary.last();
    let mut figures = Vec::new();
    for (name, value) in [
        ("distortion_at_edge", edge.and_then(FieldCurvePoint::distortion)),
        ("f_theta_distortion_at_edge", edge.and_then(FieldCurvePoint::f_theta_distortion)),
    ] {
        figures.push((name.to_owned(), percent(value), "%"));
    }
    let line = |name: &str, colour: usize, of: &dyn Fn(&FieldCurvePoint) -> Option<f64>| Series {
        name: name.to_owned(),
        colour,
        points: primary.iter().map(|point| [percent(of(point)), point.field]).collect(),
        ..Series::default()
    };
    // A wide lens has no useful tangent.
    let wide = primary.iter().any(|point| point.angle.abs() > 70.0);
    let mut series = vec![line("f theta", 4, &FieldCurvePoint::f_theta_distortion)];
    if !wide {
        series.insert(0, line("f tan theta", 0, &FieldCurvePoint::distortion));
    }
    let mut plots = vec![Plot {
        name: "curve".to_owned(),
        title: "Distortion".to_owned(),
        axes: ["distortion (%)".to_owned(), inputs.field_axis()],
        series,
        ..Plot::default()
    }];
    let imaged: Vec<FieldCurvePoint> =
        primary.iter().filter(|point| point.height.is_finite()).copied().collect();
    if inputs.lens.is_round() && imaged.len() > 1 {
        plots.push(match wide {
            true => grid(&imaged, "f theta", |point| point.f_theta_height),
            false => grid(&imaged, "f tan theta", |point| point.linear_height),
        });
    }
    ReportSection {
        name: "distortion",
        title: "Distortion",
        note: "Excess of the chief ray's image height over an image that is linear in the \
               tangent of the field angle (or in the height of a near object), and over one \
               that is linear in the angle, both scaled at the axis. The grid shows the image of a \
               square grid beside that without distortion, exaggerated as its title says."
            .to_owned(),
        figures,
        tables: vec![table],
        plots,
        absences: vec![
            Absence::usual("distortion", "the axis and fields beyond 90 degrees have none"),
            Absence::usual("f_theta_distortion", "the axis has none"),
            Absence::of_lens("linear_height_mm", "no ray near the axis passes the stop's vertex"),
        ],
        ..ReportSection::default()
    }
}

/// Returns the picture of a square grid that reaches the edge of the field with its corners, beside
/// the grid without distortion. The distortion is exaggerated so that it can be seen.
fn grid(curve: &[FieldCurvePoint], name: &str, ideal: impl Fn(&FieldCurvePoint) -> f64) -> Plot {
    let ideal = |point: &FieldCurvePoint| ideal(point).abs();
    let reach = curve.last().map_or(0.0, &ideal);
    // Displacement by ideal height, between the traced fields.
    let displacement = |height: f64| -> f64 {
        let above = curve.partition_point(|p| ideal(p) < height).clamp(1, curve.len().max(2) - 1);
        let (a, b) = (&curve[above - 1], &curve[above.min(curve.len() - 1)]);
        let share = (height - ideal(a)) / (ideal(b) - ideal(a));
        let off = |point: &FieldCurvePoint| point.height.abs() - ideal(point);
        off(a) + share * (off(b) - off(a))
    };
    let corner = reach / std::f64::consts::SQRT_2;
    let most = curve.iter().map(|p| (p.height.abs() - ideal(p)).abs()).fold(0.0, f64::max);
    let room = MOST_DISPLACED * corner / f64::from(GRID);
    let factor = EXAGGERATIONS.into_iter().rfind(|factor| factor * most <= room).unwrap_or(1.0);
    let real = |[x, y]: [f64; 2]| {
        let r = x.hypot(y);
        let scale = if r > 0.0 { 1.0 + factor * displacement(r) / r } else { 1.0 };
        [x * scale, y * scale]
    };
    let mut series = Vec::new();
    for i in -GRID..=GRID {
        let fixed = corner * f64::from(i) / f64::from(GRID);
        for axis in 0..2 {
            let points: Vec<[f64; 2]> = (-20..=20)
                .map(|k| {
                    let along = corner * f64::from(k) / 20.0;
                    if axis == 0 { [fixed, along] } else { [along, fixed] }
                })
                .collect();
            series.push(Series {
                name: if i == -GRID && axis == 0 { name.to_owned() } else { String::new() },
                colour: 6,
                style: Style::Dashed,
                points: points.clone(),
            });
            series.push(Series {
                name: if i == -GRID && axis == 0 { "image".to_owned() } else { String::new() },
                colour: 4,
                points: points.into_iter().map(real).collect(),
                ..Series::default()
            });
        }
    }
    Plot {
        name: "grid".to_owned(),
        title: match factor > 1.0 {
            true => format!("Grid, distortion times {factor}"),
            false => "Distortion of a grid".to_owned(),
        },
        axes: ["x (mm)".to_owned(), "y (mm)".to_owned()],
        series,
        square: true,
        ..Plot::default()
    }
}

pub(super) fn lateral_colour(inputs: &ReportInputs) -> ReportSection {
    let shifts = inputs.quality.lateral_colour(STEPS);
    let rows = shifts
        .iter()
        .map(|(field, shifts)| {
            let mut row = vec![*field];
            row.extend(shifts.iter().map(|shift| shift.map_or(f64::NAN, |mm| 1e3 * mm)));
            row
        })
        .collect();
    let names: Vec<String> =
        inputs.wavelengths().map(|w| format!("shift_um_{}nm", tidy(inputs.nm(w)))).collect();
    let mut columns = vec![inputs.field_column()];
    columns.extend(names.iter().map(String::as_str));
    let series = inputs.wavelengths().map(|wavelength| Series {
        name: inputs.wavelength_name(wavelength),
        colour: inputs.wavelength_colour(wavelength),
        points: shifts
            .iter()
            .map(|(field, shifts)| [shifts[wavelength].map_or(f64::NAN, |mm| 1e3 * mm), *field])
            .collect(),
        ..Series::default()
    });
    let [short, long] = inputs.quality.conditions.spectral_ends();
    let edge = shifts.last().and_then(|(_, shifts)| Some(shifts[long]? - shifts[short]?));
    ReportSection {
        name: "lateral-colour",
        title: "Lateral colour",
        note: "Distance on the film of the chief ray of each wavelength from that of the primary \
               one."
            .to_owned(),
        figures: vec![(
            "longest_minus_shortest_at_edge".to_owned(),
            edge.map_or(f64::NAN, |mm| 1e3 * mm),
            "um",
        )],
        tables: vec![Table::new("", &columns, rows)],
        plots: vec![Plot {
            title: "Lateral colour".to_owned(),
            axes: ["shift (µm)".to_owned(), inputs.field_axis()],
            series: series.collect(),
            ..Plot::default()
        }],
        absences: vec![
            Absence::of_lens(
                "shift_um",
                "no ray of the object point passes the vertex of the stop at some wavelength",
            ),
            Absence::of_lens(
                "longest",
                "no ray of the object point passes the vertex of the stop at some wavelength",
            ),
        ],
        ..ReportSection::default()
    }
}

pub(super) fn longitudinal(inputs: &ReportInputs) -> ReportSection {
    let zones: Vec<_> =
        inputs.wavelengths().map(|w| inputs.quality.longitudinal_aberration(w, ZONES)).collect();
    let rows = zones.iter().enumerate().flat_map(|(wavelength, zones)| {
        let row = move |zone: &petzval_optics::ZoneFocus| vec![zone.zone, zone.focus];
        let nm = inputs.nm(wavelength);
        zones.iter().map(row).map(|row| [vec![nm], row].concat()).collect::<Vec<_>>()
    });
    let series = zones.iter().enumerate().map(|(wavelength, zones)| Series {
        name: inputs.wavelength_name(wavelength),
        colour: inputs.wavelength_colour(wavelength),
        points: zones.iter().map(|zone| [zone.focus, zone.zone]).collect(),
        ..Series::default()
    });
    ReportSection {
        name: "longitudinal",
        title: "Longitudinal aberration and colour",
        note: "Where rays of a zone of the stop cross the axis, behind the film; zone 0 is the \
               paraxial focus."
            .to_owned(),
        tables: vec![Table::new("", &[WAVELENGTH_COLUMN, "pupil", "focus_mm"], rows.collect())],
        plots: vec![Plot {
            title: "Longitudinal aberration".to_owned(),
            axes: ["focus behind the film (mm)".to_owned(), "height in the stop".to_owned()],
            series: series.collect(),
            ..Plot::default()
        }],
        absences: vec![Absence::of_lens("focus_mm", "rays of the zone are parallel to the axis")],
        ..ReportSection::default()
    }
}
