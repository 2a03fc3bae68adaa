//! A real lens as two polynomials: from the film to its stop, and from there to the scene.
//!
//! Two of low degree make one of high degree, and the opening of the stop stays what it is between
//! them. They are fitted by least squares to rays that are traced in f64 from all over the film
//! through what of the pupil is open; the second to rays as the first leaves them, so that it makes up
//! for what it can. What passes is told by the bound of the pupil, by the opening of the stop, and by
//! the rim of the first surface: the polynomials know nothing of other rims.

mod fit;

use std::sync::Arc;

use crate::lanes::{Real, f32x8};
use crate::lens::band::Band;
use crate::lens::camera::{LensColumns, RealLens};
use crate::lens::polynomial::Polynomial;
use crate::lens::prescription::Prescription;
use crate::lens::refract::LensRay;
use crate::lens::simulated::double::launched;
use crate::lens::surface::{From, Kind, Surface, sequence};
use crate::lens::trace::trace_one;
use crate::rays::{SampleBatch, WAVE};
use crate::stats::LensStats;

/// Waves of rays to which the polynomials are fitted.
const WAVES: usize = 6;
/// Fewer rays than this say nothing of a lens.
const FEWEST: usize = 256;

/// The surfaces of a lens in light of one kind as polynomials, in place of a band of it. None where
/// next to no light comes to the film.
pub(super) fn fitted(lens: &RealLens, plain: &Prescription, response: [f64; 3]) -> Option<Band> {
    let surfaces = sequence::<f64>(plain, From::Film(lens.film_distance));
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
    if starts.len() < FEWEST {
        return None;
    }
    let round = plain.rows.iter().all(|row| row.axis.is_none()) && !plain.is_askew();
    let index = plain.index_before(plain.stop());
    let to_stop = Part { advance: lens.film_distance, round, index };
    let to_scene = Part { advance: 0.0, round, index: 1.0 };
    let first = to_stop.fit(&starts, &stops);
    let at_stop = [to_stop.surface::<f64>(&surfaces[stop], &first)];
    // One that the stop now cuts off would say nothing.
    let between = |(&start, &real)| trace_one::<f64>(start, &at_stop).unwrap_or(real);
    let between: Vec<LensRay<f64>> = starts.iter().zip(&stops).map(between).collect();
    let second = to_scene.fit(&between, &ends);
    let parts = [(&to_stop, &first), (&to_scene, &second)];
    Some(Band {
        response,
        surfaces: chain::<f32>(plain, lens, parts),
        exact: chain::<f64>(plain, lens, parts),
        ..Band::whole(plain, lens.film_distance)
    })
}

/// A part of the lens.
struct Part {
    /// From where rays come to the plane in which they are told, mm.
    advance: f64,
    round: bool,
    /// The refractive index behind.
    index: f64,
}

/// Polynomials in place of the surfaces of a lens, with the opening of the stop between them.
fn chain<R: Real>(
    plain: &Prescription,
    lens: &RealLens,
    [first, second]: [(&Part, &Polynomial<f64>); 2],
) -> Vec<Surface<R::Scalar>> {
    let real = sequence::<R>(plain, From::Film(lens.film_distance));
    let opens = |surface: &&Surface<R::Scalar>| {
        surface.stop && matches!(surface.kind, Kind::Iris(_) | Kind::Obstruction(_))
    };
    let stop = real.iter().find(|surface| surface.stop);
    let glass =
        |surface: &&Surface<R::Scalar>| surface.row == 0 && !matches!(surface.kind, Kind::Turn(_));
    let front = real.iter().find(glass);
    let mut chain = Vec::new();
    chain.extend(stop.map(|surface| first.0.surface::<R>(surface, first.1)));
    chain.extend(real.iter().filter(opens).cloned());
    chain.extend(front.map(|surface| second.0.surface::<R>(surface, second.1)));
    if let Some(front) = chain.last_mut().filter(|_| plain.is_askew()) {
        // Its rim is not about the axis.
        front.aperture2 = R::scalar(f64::INFINITY);
    }
    chain
}

/// Rays of the lens as they leave the film.
fn launch(lens: &RealLens) -> Vec<LensRay<f64>> {
    let mut samples = SampleBatch { len: WAVE, ..SampleBatch::default() };
    let mut columns = LensColumns::default();
    let mut rays = Vec::with_capacity(WAVES * WAVE);
    let index = lens.prescription.rear().index;
    for wave in 0..WAVES {
        samples.spread(lens.film.half, wave);
        lens.launch::<f32x8>(&samples, &mut columns, &mut LensStats::default());
        let batch = &columns.batch;
        let living = (0..batch.len).filter(|&i| !batch.x[i].is_nan());
        rays.extend(living.map(|i| launched(batch, index, i)));
    }
    rays
}

impl Part {
    /// A surface that does what a polynomial says, with the rim of another.
    fn surface<R: Real>(
        &self,
        rim: &Surface<R::Scalar>,
        fit: &Polynomial<f64>,
    ) -> Surface<R::Scalar> {
        let polynomial = Polynomial {
            round: fit.round,
            scale: fit.scale.map(R::scalar),
            rows: fit.rows.iter().map(|&v| R::scalar(v)).collect(),
            index: R::scalar(fit.index),
        };
        Surface {
            kind: Kind::Polynomial(Arc::new(polynomial)),
            advance: R::scalar(self.advance),
            ..rim.clone()
        }
    }
}
