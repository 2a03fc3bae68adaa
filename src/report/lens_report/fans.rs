//! Ray fans and fans of optical path difference.

use petzval_optics::{AberrationFan, AberrationPoint};

use super::inputs::ReportInputs;
use super::section::{ReportSection, Table, WAVELENGTH_COLUMN};
use crate::plot::{Plot, Series};

/// Rays to each side of the chief ray.
const RAYS: u32 = 20;

/// Fans of the shown fields: by field, tangential and sagittal, by wavelength.
pub(super) struct Fans(Vec<[Vec<AberrationFan>; 2]>);

/// Axes across the pupil, tangential first, with their names.
const AXES: [(usize, &str); 2] = [(1, "tangential"), (0, "sagittal")];

impl Fans {
    pub fn new(inputs: &ReportInputs) -> Self {
        let fans = inputs.shown.iter();
        Self(
            fans.map(|field| AXES.map(|(axis, _)| inputs.quality.fans(field, axis, RAYS)))
                .collect(),
        )
    }

    fn section(
        &self,
        inputs: &ReportInputs,
        names: &[&str],
        values: impl Fn(&AberrationPoint) -> Vec<f64>,
        shown: impl Fn(&AberrationPoint, usize) -> f64,
        unit: &str,
    ) -> ReportSection {
        let mut columns = vec![inputs.field_column(), WAVELENGTH_COLUMN, "pupil", "passes"];
        columns.extend(names);
        let mut tables = Vec::new();
        for (k, (_, name)) in AXES.iter().enumerate() {
            let mut rows = Vec::new();
            for (field, fans) in inputs.shown.iter().zip(&self.0) {
                for fan in &fans[k] {
                    rows.extend(fan.points.iter().map(|point| {
                        let mut row = vec![field.field, fan.nm, point.stop];
                        row.push(f64::from(u8::from(point.passes)));
                        row.extend(values(point));
                        row
                    }));
                }
            }
            tables.push(Table::new(*name, &columns, rows));
        }
        // All plots have the same scale, so that fields can be compared.
        let passing = self.0.iter().flatten().flatten().flat_map(|fan| &fan.points);
        let reach = passing
            .filter(|point| point.passes)
            .flat_map(|point| [shown(point, 0).abs(), shown(point, 1).abs()])
            .fold(1e-6, f64::max);
        let mut plots = Vec::new();
        for (field, fans) in inputs.shown.iter().zip(&self.0) {
            for (k, (axis, name)) in AXES.iter().enumerate() {
                let series = fans[k].iter().enumerate().map(|(i, fan)| Series {
                    name: inputs.wavelength_name(i),
                    colour: inputs.wavelength_colour(i),
                    points: fan
                        .points
                        .iter()
                        .map(|point| {
                            let y = if point.passes { shown(point, *axis) } else { f64::NAN };
                            [point.stop, y]
                        })
                        .collect(),
                    ..Series::default()
                });
                let at = inputs.field_name(field.field);
                plots.push(Plot {
                    name: format!("{name}-{}", at.replace(' ', "")),
                    title: format!("{}, {name}", inputs.field_title(field.field)),
                    axes: ["height in the stop".to_owned(), unit.to_owned()],
                    series: series.collect(),
                    ranges: [Some([-1.0, 1.0]), Some([-1.08 * reach, 1.08 * reach])],
                    ..Plot::default()
                });
            }
        }
        ReportSection { tables, plots, ..ReportSection::default() }
    }
}

pub(super) fn rays(inputs: &ReportInputs) -> ReportSection {
    let mut section = inputs.fans().section(
        inputs,
        &["aberration_x_um", "aberration_y_um"],
        |point| point.aberration.map(|mm| 1e3 * mm).to_vec(),
        |point, axis| 1e3 * point.aberration[axis],
        "aberration (µm)",
    );
    section.name = "ray-fan";
    section.title = "Ray fans";
    section.note = "Distance on the film from the chief ray at the primary wavelength, against \
                    the height in the stop relative to its radius. Tangential: y against y; \
                    sagittal: x against x. Rays that a rim blocks are left out of the plots."
        .to_owned();
    section
}

pub(super) fn paths(inputs: &ReportInputs) -> ReportSection {
    let mut section = inputs.fans().section(
        inputs,
        &["path_difference_waves"],
        |point| vec![point.waves],
        |point, _| point.waves,
        "path difference (waves)",
    );
    section.name = "opd-fan";
    section.title = "Fans of optical path difference";
    section.note = "In wavelengths of the light itself, to the sphere through the paraxial exit \
                    pupil around the point of the primary wavelength's chief ray on the film; \
                    positive where the path is shorter than the chief ray's."
        .to_owned();
    section
}
