//! Splats of lamp images: a stage after all others.

use std::ops::Range;

use super::lamp::Lamp;
use super::reach::EntryReach;
use super::{LampImageWeights, LampImages, path_count};
use crate::film::FilmSums;
use crate::lanes::Real;
use crate::lens::{LensModel, RealLens};
use crate::light_tracing::light_paths::{
    CameraPoses, LightPath, LightPathInput, LightPaths, Splat, SplatStage, splats,
};
use crate::rays::{Ray, WAVE_SIZE};
use crate::sampler::{Dimension, pixel_key, sample_2d};
use crate::scene::luminance;
use crate::stats::Stats;

/// Columns of one worker.
#[derive(Default)]
pub(super) struct LampColumns {
    pub paths: Box<LightPaths>,
    /// Density of each path over etendue (mm^-2 sr^-1).
    pub densities: Vec<f64>,
    /// Luminance of each path's light.
    pub luminances: Vec<f64>,
}

impl LampImages {
    /// Traces the light paths of these sample numbers and adds their light to the film.
    ///
    /// The sum depends on seed and sample numbers only, and the sums of disjoint ranges add up.
    pub fn splat<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        samples: Range<u32>,
        film: &mut FilmSums,
        stats: &mut Stats,
    ) {
        let LensModel::Real(lens) = &input.camera.model else { return };
        let is_outside = |lamp: &Lamp| lamp.reach.as_ref().is_some_and(EntryReach::is_empty);
        if self.lamps.iter().all(is_outside) {
            return;
        }
        let stage = SplatStage::filtered(path_count(input.frame), &input.response.filter, lens);
        stage.run(input, samples, film, stats, |columns: &mut LampColumns, [wave, sample]| {
            let key = pixel_key(sample, u32::MAX - 2, input.seed);
            self.sample(input, lens, columns, key, wave);
            let number = stage.count.wave_number([wave, sample]);
            self.splats::<R>(input, lens, columns, &self.front.bands_of_wave(input.seed, number))
        });
    }

    /// Samples a wave of light paths.
    pub(super) fn sample(
        &self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        columns: &mut LampColumns,
        key: u32,
        wave: u32,
    ) {
        let poses = CameraPoses::new(input.camera, input.timing);
        columns.paths.clear();
        columns.densities.clear();
        columns.luminances.clear();
        for i in wave * WAVE_SIZE as u32..(wave + 1) * WAVE_SIZE as u32 {
            let [choice, primitive] = sample_2d(key, i, Dimension::LightChoice(0));
            let lamp = &self.lamps[self.choice.sample(choice)];
            let entry = lamp.entry.sample(sample_2d(key, i, Dimension::Pupil));
            if !lamp.is_traced(entry.uv) {
                continue;
            }
            let at_front = entry.uv.map(|u| (2.0 * f64::from(u) - 1.0) * self.front.half);
            let time = input.arrival_time(key, i);
            let pose = poses.at(time.scene);
            let from = pose.front_surface(lens, at_front);
            let primitive = lamp.primitives.sample(primitive);
            let at = sample_2d(key, i, Dimension::Light(0));
            let Some(light) = input.scene.sample_emitter(lamp.light, primitive as u32, &from, at)
            else {
                continue;
            };
            let towards = (pose.vector_to_camera * light.direction.as_dvec3()).normalize();
            let to_light = light.density * lamp.primitives.probability(primitive);
            if !(towards.z > 0.0 && to_light > 0.0) || light.singular {
                continue;
            }
            let density = self.density(
                f64::from(lamp.share),
                f64::from(entry.density),
                f64::from(to_light),
                towards.z,
            );
            let flux = light.radiance.map(|l| (f64::from(l) / density) as f32);
            let path = LightPath {
                start: self.front.start(at_front, towards),
                towards,
                shadow: Ray {
                    origin: from.offset_origin(light.direction).to_array(),
                    direction: light.direction.to_array(),
                    t_max: light.t_max,
                },
                time,
                sample: [key, i],
            };
            columns.paths.push(&path, flux, entry.uv);
            columns.densities.push(density);
            columns.luminances.push(f64::from(luminance(light.radiance)));
        }
    }

    /// Returns the splats of a wave in some bands.
    fn splats<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        columns: &mut LampColumns,
        bands: &[usize],
    ) -> Vec<Splat> {
        let LampColumns { paths, densities, .. } = columns;
        let weights = LampImageWeights::new(self, input.camera, input.frame, input.timing);
        let count = path_count(input.frame);
        splats::<R>(input, (lens, &self.front), (count, bands), paths, |i, hit| {
            f64::from(weights.light_weight(lens, densities[i], hit))
        })
    }
}
