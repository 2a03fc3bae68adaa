//! Splats of direct light: a stage after all others.

use std::ops::Range;

use glam::{DVec3, Vec3};

use super::{DirectLight, path_count, stage};
use crate::film::FilmSums;
use crate::lanes::Real;
use crate::lens::{
    LensModel, LensRay, RealLens, retrace_in_f64, retrace_in_f64_lossy, trace, trace_lossy,
};
use crate::light_paths::{LightPath, LightPathInput, LightPaths, Splat, film_pixels};
use crate::rays::WAVE_SIZE;
use crate::sampler::mis::power_heuristic;
use crate::sampler::{Dimension, pixel_key, sample_2d};
use crate::scene::{SurfacePoint, gamma, luminance};
use crate::stats::Stats;

/// Columns of one worker.
#[derive(Default)]
pub(super) struct DirectColumns {
    pub paths: Box<LightPaths>,
    /// Density of each path over etendue (mm^-2 sr^-1).
    densities: Vec<f64>,
    blocked: Vec<u64>,
}

impl DirectLight {
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
        let stage = stage(input.frame, &input.response.filter);
        stage.run(input, samples, film, stats, |columns: &mut DirectColumns, [wave, sample]| {
            let key = pixel_key(sample, u32::MAX - 2, input.seed);
            self.sample(input, lens, columns, key, wave);
            self.trace::<R>(lens, columns);
            self.splats::<R>(input, lens, columns)
        });
    }

    /// Samples a wave of light paths. Returns the sum of the luminances of the lamps.
    pub(super) fn sample(
        &self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        columns: &mut DirectColumns,
        key: u32,
        wave: u32,
    ) -> f64 {
        let mut radiance = 0.0;
        let world = input.camera.world_from_camera;
        let camera = world.matrix3.inverse();
        columns.paths.clear();
        columns.densities.clear();
        for i in wave * WAVE_SIZE as u32..(wave + 1) * WAVE_SIZE as u32 {
            let [choice, primitive] = sample_2d(key, i, Dimension::LightChoice(0));
            let chosen = self.cumulative.partition_point(|&sum| sum <= choice);
            let lamp = &self.lamps[chosen.min(self.lamps.len() - 1)];
            let entry = lamp.entry.sample(sample_2d(key, i, Dimension::Pupil));
            let [x, y] = entry.uv.map(|u| (2.0 * f64::from(u) - 1.0) * self.half);
            let [right, up] = [x, y].map(|v| v * lens.units_per_mm);
            let place = world.transform_point3(DVec3::new(right, up, lens.front_depth));
            let normal = world.transform_vector3(DVec3::Z).normalize().as_vec3();
            let position = place.as_vec3();
            let error = position.abs() * gamma(4) + Vec3::splat(f32::MIN_POSITIVE);
            let from = SurfacePoint { position, error, normal, shading_normal: normal };
            let primitive = lamp.primitives.choose(primitive);
            let at = sample_2d(key, i, Dimension::Light(0));
            let Some(light) = input.scene.sample_emitter(lamp.light, primitive, &from, at) else {
                continue;
            };
            let towards = (camera * light.direction.as_dvec3()).normalize();
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
            let back = self.start / towards.z;
            let start = [x + towards.x * back, y + towards.y * back, 0.0];
            let flux = light.radiance.map(|l| (f64::from(l) / density) as f32);
            let path = LightPath { start, towards, origin: from.offset_origin(light.direction) };
            columns.paths.push(&path, &light, flux, entry.uv);
            columns.densities.push(density);
            radiance += f64::from(luminance(light.radiance));
        }
        radiance
    }

    /// Traces a wave from the scene to the film.
    pub(super) fn trace<R: Real<Scalar = f32>>(
        &self,
        lens: &RealLens,
        columns: &mut DirectColumns,
    ) {
        let DirectColumns { paths, blocked, .. } = columns;
        blocked.clear();
        blocked.resize(lens.prescription.rows.len(), 0);
        paths.trace_with::<R>(lens, |batch, starts| {
            let start = |i: usize| LensRay {
                p: [starts.x[i], starts.y[i], starts.z[i]].map(f64::from),
                t: [starts.tx[i], starts.ty[i], starts.tz[i]].map(f64::from),
                weight: 1.0,
            };
            match lens.fresnel {
                false => {
                    trace::<R>(batch, &self.surfaces, blocked);
                    retrace_in_f64::<R>(batch, &self.surfaces_f64, blocked, start);
                }
                true => {
                    trace_lossy::<R>(batch, &self.surfaces, blocked);
                    retrace_in_f64_lossy::<R>(batch, &self.surfaces_f64, blocked, start);
                }
            }
        });
    }

    /// Returns the splats of a traced wave.
    fn splats<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        columns: &mut DirectColumns,
    ) -> Vec<Splat> {
        let DirectColumns { paths, densities, .. } = columns;
        let margin = input.response.filter.margin();
        let frame = input.frame;
        let near = |at: [f64; 2]| {
            (0..2).all(|i| {
                at[i] > f64::from(frame.low[i]) - margin[i]
                    && at[i] < f64::from(frame.high[i]) + margin[i]
            })
        };
        let hits = paths.film_hits();
        let arrivals: Vec<(usize, [f64; 2])> = (0..paths.len())
            .filter(|&i| hits.x[i].is_finite())
            .map(|i| (i, film_pixels(input, [hits.x[i], hits.y[i]])))
            .filter(|(_, at)| near(*at))
            .collect();
        paths.connect::<R>(input, arrivals.iter().map(|(i, _)| *i as u32));
        let count = path_count(frame);
        let scale = count.splat_scale(input);
        let pitch = input.camera.pixel_pitch(frame.resolution);
        let normal = lens.film_pose.film_normal();
        let mut splats = Vec::new();
        for (i, at) in arrivals {
            let flux = paths.flux(i);
            if !(luminance(flux) > 0.0 && flux.iter().all(|c| c.is_finite())) {
                continue;
            }
            let hits = paths.film_hits();
            let film = [hits.x[i], hits.y[i]].map(f64::from);
            // From the film to the scene.
            let [x, y, z] = [-hits.tx[i], -hits.ty[i], hits.tz[i]].map(f64::from);
            let transmission = f64::from(hits.weight[i]);
            let cos =
                (normal[0] * x + normal[1] * y + normal[2] * z) / (x * x + y * y + z * z).sqrt();
            let camera =
                lens.sampling_density(film, [x, y, z]) / (transmission * cos * pitch[0] * pitch[1]);
            let weight = power_heuristic((densities[i] * count.paths()) as f32, camera as f32);
            let light = flux.map(|c| f64::from(c) * transmission * f64::from(weight) * scale);
            input.response.filter.pixels_at(at, |pixel, share| {
                let inside = (0..2).all(|k| {
                    pixel[k] >= i64::from(frame.low[k]) && pixel[k] < i64::from(frame.high[k])
                });
                if inside && share != 0.0 {
                    let light = light.map(|c| (c * share) as f32);
                    splats.push(Splat { pixel: pixel.map(|p| p as u32), light });
                }
            });
        }
        splats
    }
}
