//! Bands that share rays: the order of their stages.

use super::Job;
use crate::film::Colours;
use crate::lanes::Real;
use crate::lens::{LensColumns, Model};
use crate::rays::{LandingBatch, RayBatch, SampleBatch};
use crate::spectrum::sharing;

/// The columns of bands that share rays.
#[derive(Clone, Debug, Default)]
pub struct DisperseColumns {
    landing: LandingBatch,
    colours: Colours,
}

/// Colours the rays that [`Camera::expose`](crate::lens::Camera::expose) last made of a wave by all
/// the bands that share them ([`Colours`]); where the light is not taken apart, or not into bands that
/// can be shared out, they stay as they are.
pub fn disperse<R: Real<Scalar = f32>>(
    job: &Job,
    samples: &SampleBatch,
    lens: &mut LensColumns,
    columns: &mut DisperseColumns,
    rays: &mut RayBatch,
) {
    let Job { camera, frame, film, .. } = job;
    let Model::Real(model) = &camera.model else { return };
    let Some([hero, others @ ..]) = sharing(samples.band, model.bands.len()) else { return };
    let DisperseColumns { landing, colours } = columns;
    lens.passed(samples.len, &mut landing.share);
    colours.begin(&film.filter, samples, &landing.share, model.bands[hero].response);
    for band in others {
        camera.land::<R>(band, lens, landing);
        let response = model.bands[band].response;
        colours.add(&film.filter, (frame, camera.film), samples, landing, response);
    }
    colours.tint(&film.filter, samples, lens.exposure(), camera.imaging_ratio, rays);
}
