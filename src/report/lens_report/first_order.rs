//! Prescription, first-order data and Seidel sums.

use petzval_lens::{Paraxial, Row};
use petzval_optics::{FieldRays, SeidelSums};

use super::inputs::ReportInputs;
use super::missing::Absence;
use super::section::{ReportFailure, ReportSection, Table, WAVELENGTH_COLUMN};
use crate::number::rounded;
use crate::plot::{Plot, Series, Style};

pub(super) fn prescription(inputs: &ReportInputs) -> ReportSection {
    let all = &inputs.lens.rows;
    let rows = all.iter().enumerate().map(|(i, row)| {
        vec![
            i as f64 + 1.0,
            row.radius,
            row.conic,
            row.thickness,
            row.index,
            row.glass.abbe_number().unwrap_or(f64::NAN),
            row.diameter / 2.0,
            f64::from(u8::from(row.stop)),
        ]
    });
    let columns = [
        "surface",
        "radius_mm",
        "conic",
        "thickness_mm",
        "index_behind",
        "abbe_number_behind",
        "semi_diameter_mm",
        "stop",
    ];
    let glass = |row: &Row| row.glass.name().unwrap_or_default().to_owned();
    let mut surfaces = Table::new("", &columns, rows.collect());
    surfaces.words = vec![("glass_behind", all.iter().map(glass).collect())];
    let terms = all.iter().enumerate().flat_map(|(i, row)| {
        row.asphere
            .iter()
            .map(move |(power, value)| vec![i as f64 + 1.0, f64::from(*power), *value])
    });
    let aspheres = Table::new("aspheres", &["surface", "power", "coefficient"], terms.collect());
    let tables = [surfaces, aspheres].into_iter().filter(|table| !table.rows.is_empty());
    ReportSection {
        name: "prescription",
        title: "Prescription",
        note: format!(
            "Indices at {} nm. Thicknesses are those to the next vertex. Coefficients a_p of \
             aspheres multiply r^p and are in mm^(1 - p).",
            rounded(inputs.quality.conditions.primary_line().nm)
        ),
        tables: tables.collect(),
        absences: vec![
            Absence::usual("radius_mm", "a plane has no finite radius"),
            Absence::usual("semi_diameter_mm", "the surface has no rim"),
            Absence::usual("abbe_number", "no dispersion in the F, d and C lines is known"),
        ],
        ..ReportSection::default()
    }
}

pub(super) fn first_order(inputs: &ReportInputs) -> Result<ReportSection, ReportFailure> {
    let conditions = &inputs.quality.conditions;
    let data = conditions.first_order(&inputs.lens)?;
    let primary = &data[conditions.primary];
    let mut figures = Vec::new();
    let mut add = |name: &str, value: f64, unit| figures.push((name.to_owned(), value, unit));
    add("wavelength", conditions.primary_line().nm, "nm");
    add("effective_focal_length", primary.focal_length, "mm");
    add("rear_focal_length", primary.rear_focal_length(), "mm");
    add("back_focal_distance", primary.back_focal_distance, "mm");
    add("front_focal_distance", -front_focus(primary), "mm");
    add("object_distance", conditions.object_distance, "mm");
    add("film_distance", conditions.film_distance, "mm");
    add("total_track", primary.length + primary.travel * conditions.film_distance, "mm");
    add("f_number", primary.f_number(), "");
    add("paraxial_working_f_number", paraxial_working(inputs, primary), "");
    let axis = inputs.quality.fields.first();
    let grid = axis.and_then(|field| field.grids[conditions.primary].as_ref());
    if let Some(grid) = grid {
        add("working_f_number", grid.working_f_number(), "");
        add("airy_radius", 1e3 * grid.airy_radius(), "um");
    }
    add("magnification", primary.magnification(conditions.object_distance), "");
    add("stop_semi_diameter", inputs.lens.rows[inputs.lens.stop()].diameter / 2.0, "mm");
    add("entrance_pupil_diameter", primary.entrance_pupil.diameter, "mm");
    add("entrance_pupil_position", primary.entrance_pupil.position, "mm");
    add("exit_pupil_diameter", primary.exit_pupil.diameter, "mm");
    let exit = primary.exit_pupil.position * primary.travel - conditions.film_distance;
    add("exit_pupil_position_from_film", exit, "mm");
    add("largest_image_height", inputs.quality.largest_image_height(), "mm");
    let rows = inputs
        .wavelengths()
        .map(|i| {
            let paraxial = &data[i];
            vec![
                inputs.nm(i),
                conditions.wavelengths[i].weight,
                paraxial.focal_length,
                paraxial.back_focal_distance,
                paraxial.image_distance(conditions.object_distance),
                1e3 * inputs.quality.paraxial_focus(i),
            ]
        })
        .collect();
    let columns = [
        WAVELENGTH_COLUMN,
        "weight",
        "effective_focal_length_mm",
        "back_focal_distance_mm",
        "image_distance_mm",
        "focus_behind_film_um",
    ];
    Ok(ReportSection {
        name: "first-order",
        title: "First-order data",
        note: "Positions are behind the rear vertex (film, back focal distance), behind the front \
               vertex (entrance pupil) or behind the film (exit pupil). The working f-number is \
               that of the real pupil on the axis."
            .to_owned(),
        figures,
        tables: vec![fields(inputs), Table::new("by-wavelength", &columns, rows).shown()],
        absences: vec![
            Absence::usual("object_distance", "the object is distant"),
            Absence::of_lens("", "the lens or its pupil is afocal"),
        ],
        ..ReportSection::default()
    })
}

/// Returns the angles and image heights of the shown fields.
fn fields(inputs: &ReportInputs) -> Table {
    let primary = inputs.quality.conditions.primary;
    let row = |field: &FieldRays| {
        let angle = field.chief(primary).map_or(f64::NAN, |chief| chief.angle().to_degrees());
        vec![field.field, angle, field.reference.point[1]]
    };
    let rows = inputs.shown.iter().map(row).collect();
    Table::new("fields", &[inputs.field_column(), "field_angle_deg", "image_height_mm"], rows)
        .shown()
}

/// Returns the distance of the front focal point before the front vertex.
fn front_focus(paraxial: &Paraxial) -> f64 {
    -paraxial.whole.d / paraxial.whole.c
}

/// Returns the f-number of the marginal ray of first-order optics for the object of the conditions.
fn paraxial_working(inputs: &ReportInputs, paraxial: &Paraxial) -> f64 {
    let object = inputs.quality.conditions.object_distance;
    if object.is_infinite() {
        return paraxial.f_number();
    }
    let slope =
        paraxial.entrance_pupil.diameter / 2.0 / (object + paraxial.entrance_pupil.position);
    let m = paraxial.whole;
    let nu = m.c * slope * object + m.d * slope;
    1.0 / (2.0 * nu.abs())
}

pub(super) fn seidel(inputs: &ReportInputs) -> Result<ReportSection, ReportFailure> {
    let quality = &inputs.quality;
    let seidel = quality.seidel(&inputs.lens)?;
    let columns = ["surface", "s1_mm", "s2_mm", "s3_mm", "s4_mm", "s5_mm", "cl_mm", "ct_mm"];
    let row = |surface: f64, sums: &SeidelSums| {
        let mut row = vec![surface];
        row.extend(sums.monochromatic);
        row.extend(sums.chromatic);
        row
    };
    let mut rows: Vec<Vec<f64>> =
        seidel.rows.iter().enumerate().map(|(i, sums)| row(i as f64 + 1.0, sums)).collect();
    rows.push(row(f64::NAN, &seidel.total));
    let waves = quality.conditions.primary_line().nm * 1e-6;
    let wave_columns = ["surface", "w040", "w131", "w222", "w220p", "w311", "w020", "w111"];
    let wave_row = |surface: f64, sums: &SeidelSums| {
        let mut row = vec![surface];
        row.extend(sums.wavefront().map(|w| w / waves));
        row
    };
    let mut wave_rows: Vec<Vec<f64>> =
        seidel.rows.iter().enumerate().map(|(i, sums)| wave_row(i as f64 + 1.0, sums)).collect();
    wave_rows.push(wave_row(f64::NAN, &seidel.total));
    let chromatic = seidel.rows.iter().flat_map(|sums| sums.chromatic).any(|sum| sum != 0.0);
    let names = ["S I", "S II", "S III", "S IV", "S V", "C L", "C T"];
    let names = &names[..if chromatic { 7 } else { 5 }];
    let sums = |sums: &SeidelSums| {
        let all = sums.monochromatic.into_iter().chain(sums.chromatic);
        all.map(|sum| 1e3 * sum).collect::<Vec<f64>>()
    };
    // A group of bars for each surface, and one for the sum behind a gap.
    let count = seidel.rows.len();
    let place = |i: usize| if i < count { i as f64 + 1.0 } else { i as f64 + 2.0 };
    let groups: Vec<(f64, Vec<f64>)> = seidel
        .rows
        .iter()
        .chain([&seidel.total])
        .enumerate()
        .map(|(i, group)| (place(i), sums(group)))
        .collect();
    let middle = (names.len() as f64 - 1.0) / 2.0;
    let series = names.iter().enumerate().map(|(k, name)| Series {
        name: (*name).to_owned(),
        colour: k,
        style: Style::Bars,
        points: groups
            .iter()
            .map(|(x, sums)| (x + (k as f64 - middle) * 0.12, sums[k]))
            .flat_map(|(x, sum)| [[x, 0.0], [x, sum]])
            .collect(),
    });
    let label = |i: usize| if i < count { (i + 1).to_string() } else { "sum".to_owned() };
    let ticks = (0..=count).map(|i| (place(i), label(i))).collect();
    Ok(ReportSection {
        name: "seidel",
        title: "Seidel sums by surface",
        note:
            "S I to S V: spherical aberration, coma, astigmatism, Petzval curvature, distortion; \
               C L and C T: axial and lateral colour between the shortest and the longest \
               wavelength. The last row and the last bars are the sum. For the edge of the field and \
               the full stop."
                .to_owned(),
        figures: vec![
            ("lagrange_invariant".to_owned(), seidel.invariant, "mm"),
            ("petzval_radius".to_owned(), seidel.petzval_radius, "mm"),
        ],
        tables: vec![
            Table::new("sums", &columns, rows).shown(),
            Table::new("waves", &wave_columns, wave_rows),
        ],
        plots: vec![Plot {
            name: "sums".to_owned(),
            title: "Seidel sums".to_owned(),
            axes: ["surface".to_owned(), "sum (µm)".to_owned()],
            series: series.collect(),
            ranges: [Some([0.3, count as f64 + 2.7]), None],
            broad: true,
            ticks,
            ..Plot::default()
        }],
        absences: vec![
            Absence::usual("surface", "the row without a number is the sum of all surfaces"),
            Absence::usual("petzval_radius", "the Petzval sum is zero"),
            Absence::of_lens("", "the lens or its pupil is afocal"),
        ],
        ..ReportSection::default()
    })
}
