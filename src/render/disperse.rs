//! Dispersion stage of a wave: reprojects its rays in the bands that share them.

use crate::film::HeroWeights;
use crate::job::Job;
use petzval_base::lanes::Real;
use petzval_base::rays::{RayBatch, ReprojectionBatch, SampleBatch};
use petzval_lens::{LensColumns, LensModel};
use petzval_spectrum::bands_of_ray;

/// Columns of the dispersion stage.
#[derive(Clone, Debug, Default)]
pub struct DisperseColumns {
    reprojection: ReprojectionBatch,
    hero_weights: HeroWeights,
}

/// Weights the rays that [`Camera::generate_rays`](petzval_lens::Camera::generate_rays) has just made by
/// all bands that share them ([`HeroWeights`]). Rays of a lens without dispersion, or with too few bands
/// to share rays, stay as they are.
pub fn disperse<R: Real<Scalar = f32>>(
    job: &Job,
    samples: &SampleBatch,
    lens: &mut LensColumns,
    columns: &mut DisperseColumns,
    rays: &mut RayBatch,
) {
    let Job { camera, frame, response, .. } = job;
    let LensModel::Real(model) = &camera.model else { return };
    let Some([hero, others @ ..]) = bands_of_ray(samples.band, model.bands.len()) else { return };
    let DisperseColumns { reprojection, hero_weights } = columns;
    lens.passed(samples.len, &mut reprojection.transmission);
    hero_weights.start(
        &response.filter,
        samples,
        &reprojection.transmission,
        model.bands[hero].response,
    );
    for band in others {
        camera.reproject::<R>(band, lens, reprojection);
        let band_response = model.bands[band].response;
        hero_weights.add_band(
            &response.filter,
            (frame, camera.film),
            samples,
            reprojection,
            band_response,
        );
    }
    hero_weights.apply(&response.filter, samples, lens.exposure(), camera.imaging_ratio, rays);
}
