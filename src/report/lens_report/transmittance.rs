//! Transmittance and T-number by field and wavelength.

use petzval_lens::{AxialLight, PupilSampling, RealLens, RealRayFocus};

use super::inputs::ReportInputs;
use super::missing::Absence;
use super::section::{ReportSection, Table, WAVELENGTH_COLUMN};
use crate::number::rounded;
use crate::plot::{Plot, Series};

pub(super) fn transmittance(inputs: &ReportInputs) -> ReportSection {
    let conditions = &inputs.quality.conditions;
    let fields: Vec<(f64, [f64; 2])> =
        inputs.quality.fields.iter().map(|field| (field.field, field.reference.point)).collect();
    let height = fields.iter().map(|(_, [x, y])| x.hypot(*y)).fold(1.0, f64::max);
    let film = conditions.film_distance;
    let lens = RealLens::new(inputs.lens.clone(), film, height, PupilSampling::Pupil, 1.0, 0.0);
    let f_number = RealRayFocus::new(&inputs.lens).f_number().unwrap_or(f64::NAN);
    let axial: Vec<Vec<f64>> = inputs
        .wavelengths()
        .map(|w| {
            let light = AxialLight::of(&lens, inputs.nm(w));
            let [share, t] =
                light.map_or([f64::NAN; 2], |light| [light.transmitted, light.t_number(f_number)]);
            vec![inputs.nm(w), share, t]
        })
        .collect();
    let shares: Vec<Vec<f64>> = fields
        .iter()
        .map(|(field, point)| {
            let share = |w| lens.transmittance_at(*point, inputs.nm(w)).unwrap_or(f64::NAN);
            std::iter::once(*field).chain(inputs.wavelengths().map(share)).collect()
        })
        .collect();
    let names: Vec<String> =
        inputs.wavelengths().map(|w| format!("share_{}nm", rounded(inputs.nm(w)))).collect();
    let mut columns = vec![inputs.field_column()];
    columns.extend(names.iter().map(String::as_str));
    let lines = inputs.wavelengths().map(|w| Series {
        name: inputs.wavelength_name(w),
        colour: inputs.wavelength_colour(w),
        points: shares.iter().map(|row| [row[0], 100.0 * row[1 + w]]).collect(),
        ..Series::default()
    });
    let series = lines.collect();
    let dark = "no light of this wavelength passes the lens there";
    ReportSection {
        name: "transmittance",
        title: "Transmittance",
        note:
            "Share of the light that surfaces do not reflect and glass does not absorb, as a mean \
               over the pupil, by the coatings of the lens and the internal transmittances of its \
               glass catalogue. Glass without them absorbs nothing."
                .to_owned(),
        tables: vec![
            Table::new("t_stop", &[WAVELENGTH_COLUMN, "axial_share", "t_number"], axial).shown(),
            Table::new("field", &columns, shares),
        ],
        plots: vec![Plot {
            title: "Transmittance".to_owned(),
            axes: [inputs.field_axis(), "light (%)".to_owned()],
            series,
            ..Plot::default()
        }],
        absences: vec![
            Absence::of_lens("share", dark),
            Absence::of_lens("axial_share", dark),
            Absence::of_lens("t_number", "the lens has no f-number, or no light passes it"),
        ],
        ..ReportSection::default()
    }
}
