//! Dispersion stage of a wave: reprojects its rays in the bands that share them.

use crate::film::HeroWeights;
use crate::job::Job;
use petzval_base::lanes::Real;
use petzval_base::rays::{RayBatch, ReprojectionBatch, SampleBatch};
use petzval_lens::{LensColumns, LensModel};
use petzval_spectrum::{WAVELENGTH_SETS, WAVELENGTHS_PER_PATH, bands_of_ray};

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
    let mut others = bands_of_ray(samples.band, model.bands.len());
    let Some(hero) = others.next() else { return };
    let response_to = |band: usize| match job.spectral {
        None => model.bands[band].response,
        // Each wavelength has a channel of its own.
        Some(_) => channel_of(band),
    };
    let DisperseColumns { reprojection, hero_weights } = columns;
    lens.passed(samples.len, &mut reprojection.transmission);
    hero_weights.start(&response.filter, samples, &reprojection.transmission, response_to(hero));
    for band in others {
        camera.reproject::<R>(band, lens, reprojection);
        let band_response = response_to(band);
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

/// Returns the weights of a band in the channels of the paths of its set, if it is one of the
/// [`petzval_spectrum::WAVELENGTHS`]. Their mean over the bands of the set is 1.
fn channel_of(band: usize) -> [f64; WAVELENGTHS_PER_PATH] {
    let mut weights = [0.0; WAVELENGTHS_PER_PATH];
    weights[band / WAVELENGTH_SETS] = WAVELENGTHS_PER_PATH as f64;
    weights
}
