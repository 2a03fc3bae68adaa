//! A real lens as two polynomials: from the film to its stop, and from there to the scene.
//!
//! Two polynomials of low degree make one of high degree, and the opening of the stop stays exact
//! between them. They are fitted by least squares to rays that are traced in f64 from the whole
//! film through the open pupil. The second is fitted to rays as the first leaves them, so that it
//! corrects errors of the first. Light is blocked by the bound of the pupil, the opening of the
//! stop and the rim of the first surface; the polynomials have no other rims.

mod fit;

use std::sync::Arc;

use crate::camera::band::Band;
use crate::camera::fidelity::double::launched;
use crate::camera::{LensColumns, RealLens};
use crate::prescription::Prescription;
use crate::trace::kernel::LensRay;
use crate::trace::polynomial::Polynomial;
use crate::trace::sequence::{Side, sequence};
use crate::trace::surface::{Surface, SurfaceKind};
use crate::trace::trace_one;
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{SampleBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;

/// Number of waves of rays for the fit.
const WAVES: usize = 6;
/// Smallest number of rays for a fit.
const MIN_RAYS: usize = 256;

/// Returns a band with the surfaces of a lens as polynomials; `None` if hardly any light reaches
/// the film. `plain` is the prescription at the wavelength of the fit.
pub(super) fn fitted(lens: &RealLens, plain: &Prescription, response: [f64; 3]) -> Option<Band> {
    let surfaces = sequence::<f64>(plain, Side::Film(lens.film_distance));
    let stop = surfaces.iter().position(|surface| surface.stop)?;
    let (before, behind) = surfaces.split_at(stop + 1);
    let (mut starts, mut stops, mut ends) = (Vec::new(), Vec::new(), Vec::new());
    for start in launch(lens) {
        if let Ok(at_stop) = trace_one::<f64>(start, before)
            && let Ok(end) = trace_one::<f64>(at_stop, behind)
        {
            starts.push(start);
            stops.push(at_stop);
            ends.push(end);
        }
    }
    if starts.len() < MIN_RAYS {
        return None;
    }
    let round = plain.rows.iter().all(|row| !row.is_anamorphic()) && !plain.is_misaligned();
    let index = plain.index_before(plain.stop());
    let to_stop = Part { advance: lens.film_distance, round, index };
    let to_scene = Part { advance: 0.0, round, index: 1.0 };
    let first = to_stop.fit(&starts, &stops);
    let at_stop = [to_stop.surface::<f64>(&surfaces[stop], &first)];
    // A ray that the stop now blocks keeps its real position.
    let between = |(&start, &real)| trace_one::<f64>(start, &at_stop).unwrap_or(real);
    let between: Vec<LensRay<f64>> = starts.iter().zip(&stops).map(between).collect();
    let second = to_scene.fit(&between, &ends);
    let parts = [(&to_stop, &first), (&to_scene, &second)];
    Some(Band {
        response,
        to_scene: chain::<f32>(plain, lens, parts),
        to_scene_f64: chain::<f64>(plain, lens, parts),
        ..Band::all_light(plain, lens.film_distance)
    })
}

/// A part of the lens.
struct Part {
    /// Distance from the start of the rays to the entry plane (mm).
    advance: f64,
    /// Whether the part is rotationally symmetric.
    round: bool,
    /// Refractive index behind the part.
    index: f64,
}

/// Returns the two polynomials as surfaces, with the opening of the stop between them.
fn chain<R: Real>(
    plain: &Prescription,
    lens: &RealLens,
    [first, second]: [(&Part, &Polynomial<f64>); 2],
) -> Vec<Surface<R::Scalar>> {
    let real = sequence::<R>(plain, Side::Film(lens.film_distance));
    let opens = |surface: &&Surface<R::Scalar>| {
        let shapes = |kind: &SurfaceKind<R::Scalar>| {
            use SurfaceKind::{Clip, Iris, Obstruction};
            matches!(kind, Iris(_) | Obstruction(_) | Clip(_))
        };
        surface.stop && shapes(&surface.kind)
    };
    let stop = real.iter().find(|surface| surface.stop);
    let glass = |surface: &&Surface<R::Scalar>| {
        surface.row == 0 && !matches!(surface.kind, SurfaceKind::FrameTransform(_))
    };
    let front = real.iter().find(glass);
    let mut chain = Vec::new();
    chain.extend(stop.map(|surface| first.0.surface::<R>(surface, first.1)));
    chain.extend(real.iter().filter(opens).cloned());
    chain.extend(front.map(|surface| second.0.surface::<R>(surface, second.1)));
    if let Some(front) = chain.last_mut().filter(|_| plain.is_misaligned()) {
        // The rim of a tilted or decentred lens is not centred on the axis.
        front.aperture2 = R::from_f64(f64::INFINITY);
    }
    chain
}

/// Returns rays of the lens as they leave the film.
fn launch(lens: &RealLens) -> Vec<LensRay<f64>> {
    let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
    let mut columns = LensColumns::default();
    let mut rays = Vec::with_capacity(WAVES * WAVE_SIZE);
    let index = lens.prescription.rear().index;
    for wave in 0..WAVES {
        samples.fill_evenly(lens.film.half, wave);
        lens.launch::<f32x8>(&samples, &mut columns, &mut LensStats::default());
        let batch = &columns.batch;
        let living = (0..batch.len).filter(|&i| !batch.x[i].is_nan());
        rays.extend(living.map(|i| launched(batch, index, i)));
    }
    rays
}

impl Part {
    /// Returns a surface with the polynomials of a fit and the rim of another surface.
    fn surface<R: Real>(
        &self,
        rim: &Surface<R::Scalar>,
        fit: &Polynomial<f64>,
    ) -> Surface<R::Scalar> {
        let polynomial = Polynomial {
            round: fit.round,
            scale: fit.scale.map(R::from_f64),
            rows: fit.rows.iter().map(|&v| R::from_f64(v)).collect(),
            index: R::from_f64(fit.index),
        };
        Surface {
            kind: SurfaceKind::Polynomial(Arc::new(polynomial)),
            advance: R::from_f64(self.advance),
            // The polynomial contains the reflection.
            mirror: false,
            absorption: None,
            ..rim.clone()
        }
    }
}
