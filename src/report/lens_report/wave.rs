//! Wavefronts with Zernike coefficients, point images and encircled energy.

use petzval_optics::{FieldRays, PointImage};

use super::inputs::ReportInputs;
use super::missing::Absence;
use super::picture::{self, PictureScale, SectionPicture};
use super::section::{ReportFailure, ReportSection, Table, WAVELENGTH_COLUMN};
use crate::plot::{Plot, Series};

/// Zernike terms.
const TERMS: usize = 37;
/// Samples along each side of a point image.
const SIDE: usize = 96;
/// Radii of the encircled energy.
const RADII: usize = 100;
/// Finest grid over a pupil for a point image, cells along each side.
const FINEST: usize = 256;

pub(super) fn wavefronts(inputs: &ReportInputs) -> Result<ReportSection, ReportFailure> {
    let mut figures = Vec::new();
    let mut pictures = Vec::new();
    let (mut coefficients, mut sizes, mut map) = (Vec::new(), Vec::new(), Vec::new());
    for field in &inputs.shown {
        for (wavelength, grid) in field.grids.iter().enumerate() {
            let Some(grid) = grid else { continue };
            let fit = grid.zernike(TERMS);
            let at = [field.field, inputs.nm(wavelength)];
            sizes.push(vec![
                at[0],
                at[1],
                fit.rms_without_tilt,
                fit.rms,
                fit.peak_to_valley,
                (-(std::f64::consts::TAU * fit.rms_without_tilt).powi(2)).exp(),
                fit.residual,
            ]);
            for (i, coefficient) in fit.coefficients.iter().enumerate() {
                coefficients.push(vec![at[0], at[1], i as f64 + 1.0, *coefficient]);
            }
            if wavelength == inputs.quality.conditions.primary {
                let waves = grid.nm * 1e-6;
                let row = |cell: &petzval_optics::PupilCell| {
                    vec![
                        field.field,
                        cell.stop[0],
                        cell.stop[1],
                        -cell.path_difference / waves,
                        cell.share,
                    ]
                };
                map.extend(grid.open().map(|(_, cell)| row(cell)));
                let name = format!("rms_at_{}", inputs.field_name(field.field).replace(' ', ""));
                figures.push((name, fit.rms_without_tilt, "waves"));
                let reach = reach(grid.open().map(|(_, cell)| cell.path_difference / waves));
                let at = inputs.field_name(field.field);
                pictures.push(SectionPicture {
                    name: at.replace(' ', ""),
                    caption: inputs.field_title(field.field),
                    png: picture::wavefront(grid, reach)?,
                    scale: PictureScale::Waves(reach),
                });
            }
        }
    }
    let field = inputs.field_column();
    Ok(ReportSection {
        name: "wavefront",
        title: "Wavefronts and Zernike coefficients",
        note: "Path differences to the reference sphere of the primary wavelength's chief ray, in \
               wavelengths of the light itself, positive where the path is shorter. Coefficients \
               in Noll's order and normalization over the unit circle of the stop, fitted to the \
               rays that pass. Maps are red where light is ahead and grey outside the pupil; the colours end where \
               99 % of the pupil does."
            .to_owned(),
        figures,
        tables: vec![
            Table::new(
                "size",
                &[
                    field,
                    WAVELENGTH_COLUMN,
                    "rms_waves",
                    "rms_with_tilt_waves",
                    "peak_to_valley_waves",
                    "strehl_marechal",
                    "fit_residual_waves",
                ],
                sizes,
            )
            .shown(),
            Table::new("zernike", &[field, WAVELENGTH_COLUMN, "noll", "waves"], coefficients),
            Table::new("map", &[field, "pupil_x", "pupil_y", "waves", "share"], map),
        ],
        pictures,
        absences: vec![Absence::of_lens("rms_at", "too few rays of the field pass the lens")],
        ..ReportSection::default()
    })
}

/// Returns the path difference of the strongest colours (waves): that which 99 % of the cells do not
/// exceed. Few rays at a rim would hide all others.
fn reach(waves: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = waves.map(f64::abs).filter(|size| size.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() * 99 / 100).map_or(1e-6, |size| size.max(1e-6))
}

/// Images of points of the shown fields.
pub(super) struct PointImages(Vec<Option<PointImage>>);

impl PointImages {
    pub fn new(inputs: &ReportInputs) -> Self {
        Self(inputs.shown.iter().map(|field| point_image(inputs, field)).collect())
    }
}

pub(super) fn psf(inputs: &ReportInputs) -> Result<ReportSection, ReportFailure> {
    let mut rows = Vec::new();
    let mut summary = Vec::new();
    let mut pictures = Vec::new();
    for (field, image) in inputs.shown.iter().zip(&inputs.point_images().0) {
        let Some(image) = image else { continue };
        let inside: f64 = image.values.iter().sum();
        let width = 1e3 * image.pitch * image.side as f64;
        summary.push(vec![field.field, image.strehl, width, inside]);
        let at = inputs.field_name(field.field);
        pictures.push(SectionPicture {
            name: at.replace(' ', ""),
            caption: inputs.field_title(field.field),
            png: picture::point_image(image)?,
            scale: PictureScale::Decades { width },
        });
        let middle = (image.side as f64 - 1.0) / 2.0;
        for (i, value) in image.values.iter().enumerate() {
            let place = |k: usize, axis: usize| {
                1e3 * (image.centre[axis] + (k as f64 - middle) * image.pitch)
            };
            rows.push(vec![
                field.field,
                place(i % image.side, 0),
                place(i / image.side, 1),
                *value,
            ]);
        }
    }
    let column = inputs.field_column();
    Ok(ReportSection {
        name: "psf",
        title: "Point spread by diffraction",
        note: "Sum of the plane waves of the real pupil with their traced phases, in the light \
               of all wavelengths. Positions are relative to the primary wavelength's chief \
               ray; values are shares of the light per sample. Images wider than the grid \
               over the pupil resolves hold less than all light."
            .to_owned(),
        tables: vec![
            Table::new("size", &[column, "strehl", "width_um", "light_inside"], summary).shown(),
            Table::new("image", &[column, "x_um", "y_um", "light"], rows),
        ],
        pictures,
        ..ReportSection::default()
    })
}

pub(super) fn encircled_energy(inputs: &ReportInputs) -> ReportSection {
    let mut rows = Vec::new();
    let mut series = Vec::new();
    for (i, (field, image)) in inputs.shown.iter().zip(&inputs.point_images().0).enumerate() {
        let Some(image) = image else { continue };
        let curve: Vec<[f64; 2]> = std::iter::once([0.0; 2])
            .chain(image.encircled_energy(RADII).into_iter().map(|(r, e)| [1e3 * r, e]))
            .collect();
        rows.extend(curve.iter().map(|[r, e]| vec![field.field, *r, *e]));
        series.push(Series {
            name: inputs.field_name(field.field),
            colour: inputs.field_colour(i),
            points: curve,
            ..Series::default()
        });
    }
    ReportSection {
        name: "encircled-energy",
        title: "Encircled energy by diffraction",
        note: "Share of the light within a circle around the centroid.".to_owned(),
        tables: vec![Table::new("", &[inputs.field_column(), "radius_um", "share"], rows)],
        plots: vec![Plot {
            title: "Encircled energy".to_owned(),
            axes: ["radius (µm)".to_owned(), "share of the light".to_owned()],
            series,
            ranges: [None, Some([0.0, 1.02])],
            ..Plot::default()
        }],
        ..ReportSection::default()
    }
}

/// Computes the image of a field, with a finer grid over the pupil if the spot is large.
fn point_image(inputs: &ReportInputs, field: &FieldRays) -> Option<PointImage> {
    let spot = field.spot().size(0.0, None)?;
    let primary = inputs.quality.conditions.primary;
    let airy = field.grids[primary].as_ref()?.airy_radius();
    let wanted = (4.0 * spot.rms).max(2.2 * spot.largest.min(3.0 * spot.rms)).max(12.0 * airy);
    let side = field.grids[primary].as_ref()?.side;
    // The image repeats after the resolved width; half of it stays free.
    let needed = (side as f64 * 1.5 * wanted / field.resolved_width()).ceil() as usize;
    if needed <= side {
        return field.point_image(SIDE, wanted);
    }
    let finer = inputs.quality.trace_field(field.field, needed.min(FINEST))?;
    finer.point_image(SIDE, wanted.min(finer.resolved_width()))
}
