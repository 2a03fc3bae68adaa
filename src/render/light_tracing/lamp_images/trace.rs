//! Light paths of lamp images: from a lamp to the lens.

use super::lamp::Lamp;
use super::reach::EntryReach;
use super::{LampImageWeights, LampImages};
use crate::film::{Frame, Splat};
use crate::light_tracing::light_paths::{
    CameraPoses, LightPath, LightPathInput, LightPaths, PathCount, PathNumbers, add_splats,
};
use petzval_base::lanes::Real;
use petzval_base::rays::{Ray, WAVE_SIZE};
use petzval_base::sampler::pixel_key;
use petzval_lens::RealLens;
use petzval_scene::luminance;

/// Samples of the picture per light path. Lamps and suns are small, so that this is a dozen paths for each of
/// their pixels and each sample of them.
const SAMPLES_PER_PATH: u64 = 16;

/// Columns of one worker.
#[derive(Default)]
pub(crate) struct LampColumns {
    pub paths: Box<LightPaths>,
    /// Density of each path over etendue (mm^-2 sr^-1).
    pub densities: Vec<f64>,
    /// Luminance of each path's light.
    pub luminances: Vec<f64>,
}

impl LampImages {
    /// Returns the number of light paths per sample number.
    pub(crate) fn path_count(&self, frame: &Frame) -> PathCount {
        PathCount::new(frame.resolution, SAMPLES_PER_PATH)
    }

    /// Returns whether the light of any lamp can reach the rendered pixels.
    pub(crate) fn reaches_pixels(&self) -> bool {
        let is_outside = |lamp: &Lamp| lamp.reach.as_ref().is_some_and(EntryReach::is_empty);
        !self.lamps.iter().all(is_outside)
    }

    /// Traces a wave of a sample number and returns its splats.
    pub(crate) fn trace<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        columns: &mut LampColumns,
        [wave, sample]: [u32; 2],
    ) -> Vec<Splat> {
        let key = pixel_key(sample, u32::MAX - 2, input.seed);
        let count = self.path_count(input.frame);
        let light = input.wave_light(count.wave_number([wave, sample]));
        let input = &light.input;
        self.sample(input, lens, columns, key, wave);
        let LampColumns { paths, densities, .. } = columns;
        let weights = LampImageWeights::new(self, input.camera, input.frame, input.timing);
        let bands = light.bands(|band| lens.bands[band].response);
        let weight = |i: usize, hit: &_| f64::from(weights.light_weight(lens, densities[i], hit));
        let (lens, mut splats) = ((lens, &self.front), Vec::new());
        add_splats::<R>(input, lens, (count, light.set, &bands), paths, weight, &mut splats);
        splats
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
        let first = wave * WAVE_SIZE as u32;
        columns.paths.numbers.fill(key, first);
        for in_wave in 0..WAVE_SIZE {
            let i = first + in_wave as u32;
            let PathNumbers { choice: [choice, primitive], entry, light } =
                columns.paths.numbers.of_path(in_wave);
            // The paths of a wave share the lamps evenly, and those of a lamp follow each other: their
            // numbers are well distributed, and the densities of the lamp stay in the cache.
            let choice = (in_wave as f32 + choice) / WAVE_SIZE as f32;
            let choice = choice.min(1.0 - f32::EPSILON / 2.0);
            let lamp = &self.lamps[self.choice.sample(choice)];
            let entry = lamp.entry.sample(entry);
            if !lamp.is_traced(entry.uv) {
                continue;
            }
            let at_front = self.front.square.place(entry.uv.map(f64::from));
            let time = input.arrival_time(key, i);
            let pose = poses.at(time.scene);
            let from = pose.front_surface(lens, at_front);
            let primitive = lamp.primitives.sample(primitive);
            let Some(light) =
                input.scene.sample_emitter(lamp.light, primitive as u32, &from, light)
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
}
