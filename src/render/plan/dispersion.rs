//! Decision about dispersion, from the displacement of colours on the film.

use glam::{DAffine3, DVec3};

use super::{DecidedBy, Finding, OmissionError, PlanInput, cost, pixels_per_um};
use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_base::stats::LensStats;
use petzval_lens::{Camera, LensColumns, LensModel, RealLens, RealRayFocus, Row};
use petzval_spectrum::BAND_RANGE;

/// Number of film samples of the estimate.
const SAMPLES: usize = 512;

pub(super) fn find(input: &PlanInput, lens: &RealLens) -> Finding {
    let rows = &lens.prescription.rows;
    let glass = rows.iter().filter(|row| row.index != 1.0);
    let (known, all) = (glass.clone().filter(|row| row.glass.disperses()).count(), glass.count());
    if known == 0 {
        let reason = "the lens file does not say how its glass depends on the wavelength \
                      ('assume_vd' guesses)";
        return Finding::unavailable(DecidedBy::Lens, reason);
    }
    if let Err(error) = lens.prescription.check_wavelengths(BAND_RANGE) {
        let reason = format!("the lens is not for visible light: {error}");
        return Finding::unavailable(DecidedBy::Lens, &reason);
    }
    let um = displacement(input, lens);
    let pixels = um * pixels_per_um(input);
    let error = OmissionError::Blur { um, pixels };
    let part = match (input.assumed_dispersion, known < all) {
        (true, _) => " (Abbe numbers that the file does not give are guessed)".to_owned(),
        (_, true) => format!(" (of {known} of {all} media; of the others nothing is known)"),
        _ => String::new(),
    };
    Finding {
        by: if input.assumed_dispersion { DecidedBy::Flag } else { DecidedBy::Lens },
        reason: format!("colours land {um:.2} um apart, {pixels:.2} pixels{part}"),
        error: Some(error),
        possible: true,
        by_default: error.is_visible(input.threshold),
        cost: cost(input, SORTING + rows.iter().map(crossing).sum::<f64>()),
    }
}

/// Cost of sorting samples by band and of weighting the bands that share a ray [ns per film sample].
const SORTING: f64 = 20.0;

/// Returns the cost of three more crossings of a surface [ns per film sample]. Measured by `cargo bench
/// --bench effects -- dispersion` for spheres, and by renders through lenses/anamorphic.toml and
/// phone.toml (119 and 409 ns in total) for cylinders and aspheres.
fn crossing(row: &Row) -> f64 {
    match (row.asphere.is_empty() && row.across.is_none(), row.conic == 0.0 && row.axis.is_none()) {
        (true, true) => 6.0,
        (true, false) => 12.0,
        (false, _) => 44.0,
    }
}

/// Returns the root mean square displacement on the film (um) of light of all wavelengths from that of
/// the d line, over film, pupil and wavelengths weighted by luminance.
fn displacement(input: &PlanInput, lens: &RealLens) -> f64 {
    let object = RealRayFocus::new(&lens.prescription).object_distance(lens.film_distance);
    let object = object.filter(|object| object.is_finite()).unwrap_or(1e7).max(1.0);
    let focal = lens.paraxial.focal_length.abs();
    // From an angle at the front of the lens to micrometres on the film.
    let um_per_radian = 1e3 * focal * (object / (object - focal)).abs().min(1e3);
    let mut spread = lens.clone();
    spread.disperse(input.bands);
    spread.bands.insert(0, lens.bands[0].clone());
    let (unit, count) = (lens.units_per_mm, spread.bands.len());
    let camera = Camera {
        model: LensModel::Real(Box::new(spread)),
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
        ..input.camera.clone()
    };
    let mut samples = SampleBatch { len: SAMPLES.min(WAVE_SIZE), ..SampleBatch::default() };
    for i in 0..samples.len {
        let [film, pupil] = [Dimension::Film, Dimension::Pupil].map(|d| sample_2d(0, i as u32, d));
        for axis in 0..2 {
            samples.film[axis][i] = ((f64::from(film[axis]) - 0.5) * camera.film[axis]) as f32;
            samples.pupil[axis][i] = pupil[axis];
        }
    }
    let mut columns = LensColumns::default();
    let mut stats = LensStats::default();
    // The point of each sample in the plane in focus, for the d line.
    let mut first = vec![None; samples.len];
    let (mut sum, mut weights) = (0.0, 0.0);
    for band in 0..count {
        samples.band = band;
        let mut rays = RayBatch::default();
        camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        let LensModel::Real(spread) = &camera.model else { break };
        let [r, g, b] = spread.bands[band].response;
        let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        for i in 0..rays.len {
            let ray = rays.ray(i);
            let of = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
            let reach = object * unit;
            let point = of(ray.origin) + of(ray.direction) * reach;
            let slot = rays.slot[i] as usize;
            match (band, first[slot]) {
                (0, _) => first[slot] = Some(point),
                (_, Some(there)) => {
                    let angle = point.distance(there) / reach;
                    sum += luminance * angle * angle;
                    weights += luminance;
                }
                _ => {}
            }
        }
    }
    if weights > 0.0 { um_per_radian * (sum / weights).sqrt() } else { 0.0 }
}
