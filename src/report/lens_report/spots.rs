//! Spot diagrams, and their sizes by field, wavelength and focus.

use petzval_optics::SpotDiagram;

use super::inputs::ReportInputs;
use super::missing::Absence;
use super::section::{ReportSection, Table, WAVELENGTH_COLUMN};
use crate::number::rounded;
use crate::plot::{Plot, Series, Style};

/// Steps of focus to each side, of the depth of focus 2 lambda N^2.
const FOCUS_STEPS: i32 = 5;
/// Points of the circle of an Airy disc.
const CIRCLE: usize = 72;

pub(super) fn spots(inputs: &ReportInputs) -> ReportSection {
    let diagrams: Vec<SpotDiagram> = inputs.shown.iter().map(|field| field.spot()).collect();
    let mut sizes = Vec::new();
    let mut through_focus = Vec::new();
    let step = focus_step(inputs);
    for (field, spot) in inputs.shown.iter().zip(&diagrams) {
        let wavelengths = inputs.wavelengths().map(Some);
        for wavelength in std::iter::once(None).chain(wavelengths) {
            let Some(size) = spot.size(0.0, wavelength) else { continue };
            sizes.push(vec![
                field.field,
                wavelength.map_or(f64::NAN, |w| inputs.nm(w)),
                1e3 * size.rms,
                1e3 * size.rms_across[0],
                1e3 * size.rms_across[1],
                1e3 * size.largest,
                1e3 * size.centroid[0],
                1e3 * size.centroid[1],
            ]);
        }
        for i in -FOCUS_STEPS..=FOCUS_STEPS {
            let defocus = f64::from(i) * step;
            let size = spot.size(defocus, None);
            let rms = size.map_or(f64::NAN, |size| 1e3 * size.rms);
            through_focus.push(vec![field.field, 1e3 * defocus, rms]);
        }
    }
    let rays = inputs.shown.iter().zip(&diagrams).flat_map(|(field, spot)| {
        let row = |ray: &petzval_optics::SpotRay| {
            let [x, y] = ray.point.map(|mm| 1e3 * mm);
            vec![field.field, inputs.nm(ray.wavelength), x, y, ray.light]
        };
        spot.rays.iter().map(row).collect::<Vec<_>>()
    });
    let field = inputs.field_column();
    let tables = vec![
        Table::new(
            "size",
            &[
                field,
                WAVELENGTH_COLUMN,
                "rms_radius_um",
                "rms_x_um",
                "rms_y_um",
                "largest_radius_um",
                "centroid_x_um",
                "centroid_y_um",
            ],
            sizes,
        )
        .shown(),
        Table::new("through-focus", &[field, "defocus_um", "rms_radius_um"], through_focus),
        Table::new("rays", &[field, WAVELENGTH_COLUMN, "x_um", "y_um", "light"], rays.collect()),
    ];
    let airy = inputs
        .shown
        .first()
        .and_then(|field| field.grids[inputs.quality.conditions.primary].as_ref());
    let figures = airy
        .map(|grid| ("airy_radius_on_axis".to_owned(), 1e3 * grid.airy_radius(), "um"))
        .into_iter()
        .collect();
    ReportSection {
        name: "spot",
        title: "Spot diagrams",
        note:
            "Around the chief ray at the primary wavelength, all at the same scale; the circle is \
               the Airy disc of that wavelength. RMS and GEO are the root mean square and the \
               largest distance of rays from their centroid. Rays carry the light that enters the lens. A size without a wavelength \
               is that of all, by their weights."
                .to_owned(),
        figures,
        tables,
        plots: plots(inputs, &diagrams),
        absences: vec![Absence::usual(
            WAVELENGTH_COLUMN,
            "a row without one is that of all wavelengths",
        )],
        ..ReportSection::default()
    }
}

/// Returns the spots, all at the scale of the largest.
fn plots(inputs: &ReportInputs, diagrams: &[SpotDiagram]) -> Vec<Plot> {
    let rays = diagrams.iter().flat_map(|spot| &spot.rays);
    let reach = rays.flat_map(|ray| ray.point).fold(0.0, |most: f64, mm| most.max(1e3 * mm.abs()));
    let airy = inputs.shown.iter().filter_map(|field| {
        field.grids[inputs.quality.conditions.primary].as_ref().map(|grid| 1e3 * grid.airy_radius())
    });
    let reach = 1.05 * airy.fold(reach, f64::max).max(1e-6);
    inputs
        .shown
        .iter()
        .zip(diagrams)
        .map(|(field, spot)| {
            let mut series: Vec<Series> = inputs
                .wavelengths()
                .map(|wavelength| Series {
                    name: inputs.wavelength_name(wavelength),
                    colour: inputs.wavelength_colour(wavelength),
                    style: Style::Dots,
                    points: spot
                        .rays
                        .iter()
                        .filter(|ray| ray.wavelength == wavelength)
                        .map(|ray| ray.point.map(|mm| 1e3 * mm))
                        .collect(),
                })
                .collect();
            if let Some(grid) = &field.grids[inputs.quality.conditions.primary] {
                let radius = 1e3 * grid.airy_radius();
                let point = |i: usize| {
                    let (sin, cos) = (std::f64::consts::TAU * i as f64 / CIRCLE as f64).sin_cos();
                    [radius * cos, radius * sin]
                };
                series.push(Series {
                    name: "Airy disc".to_owned(),
                    colour: 6,
                    style: Style::Outline,
                    points: (0..CIRCLE).map(point).collect(),
                });
            }
            let at = inputs.field_name(field.field);
            let caption = spot.size(0.0, None).map(|size| {
                let [rms, largest] = [size.rms, size.largest].map(|mm| rounded(1e3 * mm));
                format!("RMS {rms} µm, GEO {largest} µm")
            });
            Plot {
                name: at.replace(' ', ""),
                title: inputs.field_title(field.field),
                axes: ["x (µm)".to_owned(), "y (µm)".to_owned()],
                series,
                square: true,
                ranges: [Some([-reach, reach]); 2],
                captions: caption.into_iter().collect(),
                ..Plot::default()
            }
        })
        .collect()
}

/// Returns the step of focus (mm): a depth of focus, 2 lambda N^2.
pub(super) fn focus_step(inputs: &ReportInputs) -> f64 {
    let primary = inputs.quality.conditions.primary;
    let grid = inputs.shown.first().and_then(|field| field.grids[primary].as_ref());
    grid.map_or(0.05, |grid| 2.0 * grid.nm * 1e-6 * grid.working_f_number().powi(2))
}
