//! Relative illumination, vignetting by surface and ghosts.

use petzval_lens::{Normalization, Vignetting};
use petzval_optics::MOST_GHOST_SURFACES;

use super::inputs::ReportInputs;
use super::missing::Absence;
use super::section::{ReportSection, Table};
use crate::plot::{Plot, Series, Style};

/// Rays per field for the shares that surfaces block.
const RAYS: u32 = 1 << 13;
/// Rays per field for the illumination.
const ILLUMINATION_RAYS: u32 = 1 << 16;
/// Ghosts in the table of the page.
const GHOSTS: usize = 200;

pub(super) fn relative_illumination(inputs: &ReportInputs) -> ReportSection {
    let conditions = &inputs.quality.conditions;
    let primary = conditions.primary;
    let film = Vignetting::new(&inputs.lens, conditions.film_distance, ILLUMINATION_RAYS);
    let fields: Vec<[f64; 5]> = inputs
        .quality
        .fields
        .iter()
        .map(|field| {
            let angle = field.chief(primary).map_or(f64::NAN, |chief| chief.angle().to_degrees());
            let Some(grid) = field.grids[primary].as_ref() else {
                return [field.field, angle, f64::NAN, f64::NAN, f64::NAN];
            };
            let budget = film.budget(field.reference.point, Normalization::Stop);
            let light = budget.map_or(f64::NAN, |budget| budget.irradiance);
            [field.field, angle, light, grid.area(), grid.working_f_number()]
        })
        .collect();
    let [light, area] = fields.first().map_or([f64::NAN; 2], |field| [field[2], field[3]]);
    let cosine = |angle: f64| match angle.abs() < 90.0 {
        true => angle.to_radians().cos().powi(4),
        false => f64::NAN,
    };
    let rows: Vec<Vec<f64>> = fields
        .iter()
        .map(|[field, angle, here, pupil, f]| {
            vec![*field, *angle, here / light, *f, pupil / area, cosine(*angle)]
        })
        .collect();
    let line = |name: &str, style: Style, column: usize| Series {
        name: name.to_owned(),
        style,
        points: rows.iter().map(|row| [row[0], 100.0 * row[column]]).collect(),
        ..Series::default()
    };
    let plot = Plot {
        title: "Relative illumination".to_owned(),
        axes: [inputs.field_axis(), "light (%)".to_owned()],
        series: vec![line("lens", Style::Line, 2), line("cos⁴", Style::Dashed, 5)],
        ranges: [None, Some([0.0, 104.0])],
        ..Plot::default()
    };
    let columns = [
        inputs.field_column(),
        "angle_deg",
        "relative_illumination",
        "effective_f_number",
        "pupil_area_ratio",
        "cos4",
    ];
    ReportSection {
        name: "relative-illumination",
        title: "Relative illumination",
        note: "Irradiance on the film by an even scene, relative to that on the axis, at the \
               primary wavelength; without losses in glass and at surfaces. The ratio of pupil \
               areas, in direction cosines, is that of the light of an object point: it differs \
               where the image is curved. The f-number is that of a round pupil of that area."
            .to_owned(),
        tables: vec![Table::new("", &columns, rows).shown()],
        plots: vec![plot],
        absences: vec![
            Absence::usual("cos4", "fields beyond 90 degrees have none"),
            Absence::of_lens(
                "relative_illumination",
                "too little light passes on the axis or at the field",
            ),
        ],
        ..ReportSection::default()
    }
}

pub(super) fn vignetting(inputs: &ReportInputs) -> ReportSection {
    let conditions = &inputs.quality.conditions;
    let vignetting = Vignetting::new(&inputs.lens, conditions.film_distance, RAYS);
    let budgets: Vec<_> = inputs
        .quality
        .fields
        .iter()
        .map(|field| {
            let [x, y] = field.reference.point;
            (field.field, vignetting.budget([x, y], Normalization::Stop))
        })
        .collect();
    let count = inputs.lens.rows.len();
    let share = |row: usize, budget: &Option<petzval_lens::LightBudget>| {
        budget.as_ref().map_or(f64::NAN, |budget| budget.rows[row].share())
    };
    let blocking: Vec<usize> = (0..count)
        .filter(|&row| budgets.iter().any(|(_, budget)| share(row, budget) > 0.0))
        .collect();
    let names: Vec<String> =
        blocking.iter().map(|row| format!("blocked_by_surface_{}", row + 1)).collect();
    let mut columns = vec![inputs.field_column(), "pass"];
    columns.extend(names.iter().map(String::as_str));
    let rows: Vec<Vec<f64>> = budgets
        .iter()
        .map(|(field, budget)| {
            let mut row = vec![*field, budget.as_ref().map_or(f64::NAN, |budget| budget.pass)];
            row.extend(blocking.iter().map(|&i| share(i, budget)));
            row
        })
        .collect();
    let mut series = vec![Series {
        name: "passes".to_owned(),
        points: rows.iter().map(|row| [row[0], 100.0 * row[1]]).collect(),
        ..Series::default()
    }];
    for (i, row) in blocking.iter().enumerate() {
        series.push(Series {
            name: format!("surface {}", row + 1),
            colour: 1 + i % 6,
            style: Style::Dashed,
            points: rows.iter().map(|row| [row[0], 100.0 * row[2 + i]]).collect(),
        });
    }
    ReportSection {
        name: "vignetting",
        title: "Vignetting by surface",
        note: "1 is the light that would pass the stop with all other rims open, from the film; \
               a ray counts at the first surface that blocks it on its way from the film."
            .to_owned(),
        tables: vec![Table::new("", &columns, rows)],
        plots: vec![Plot {
            title: "Vignetting".to_owned(),
            axes: [inputs.field_axis(), "light (%)".to_owned()],
            series,
            ranges: [None, Some([0.0, 104.0])],
            ..Plot::default()
        }],
        ..ReportSection::default()
    }
}

pub(super) fn ghosts(inputs: &ReportInputs) -> ReportSection {
    let ghosts = inputs.quality.ghost_foci(&inputs.lens);
    let note = match inputs.lens.has_mirrors() {
        true => "Not computed for a lens with mirrors.".to_owned(),
        false if ghosts.is_none() => format!(
            "Not computed for a lens of more than {MOST_GHOST_SURFACES} surfaces that reflect: it has \
             too many pairs of them."
        ),
        false => format!(
            "By first-order optics, for a point on the axis and the reflectances of {}. Light is \
             reflected at the first surface named, then at the second. The irradiance is the share \
             of the point's light per mm² of film; the focus is behind the film.",
            match inputs.lens.assumed_coating {
                true => "a layer of MgF2 on every surface to air, as the file names no coating",
                false => "the coatings in the lens file",
            }
        ),
    };
    let ghosts = ghosts.unwrap_or_default();
    let rows = ghosts
        .iter()
        .take(GHOSTS)
        .map(|ghost| {
            let [first, second] = ghost.rows.map(|row| row as f64 + 1.0);
            vec![first, second, ghost.irradiance(), ghost.share, ghost.radius, ghost.focus]
        })
        .collect();
    let columns = [
        "first_surface",
        "second_surface",
        "irradiance_per_mm2",
        "share",
        "radius_on_film_mm",
        "focus_behind_film_mm",
    ];
    let figures = vec![("pairs".to_owned(), ghosts.len() as f64, "")];
    ReportSection {
        name: "ghosts",
        title: "Ghosts by pair of surfaces",
        note,
        figures,
        tables: vec![Table::new("", &columns, rows).shown()],
        absences: vec![Absence::usual(
            "focus_behind_film_mm",
            "the ghost's light is parallel behind the lens",
        )],
        ..ReportSection::default()
    }
}
