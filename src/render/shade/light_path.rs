//! Shading of light paths: surfaces on the way from a light to the lens.
//!
//! The same BSDFs scatter light and importance, with two corrections (Veach 1997, section 5.3). A
//! light path carries flux, which refraction leaves as it is: the caller multiplies by the squared
//! ratio of indices in [`RayBatch::roulette_scale`]. Where the shading normal is not that of the
//! surface, the flux takes the factor of [`Vertices::correct_for_flux`].

use glam::Vec3;

use super::bsdf::MisWeights;
use super::evaluate::Evaluation;
use super::vertices::{Vertices, vector};
use super::{ShadeColumns, ShadeInputs};
use petzval_base::lanes::Real;
use petzval_base::rays::{RayBatch, SampleBatch};

impl Vertices {
    /// Directs every vertex that receives caustics to the lens, as if the lens were a point light of
    /// radiance 1.
    fn aim(&mut self, target: &mut dyn FnMut(u32, Vec3) -> Option<Vec3>) {
        for (range, kind) in self.shaded_ranges() {
            let stage = kind.stage::<f32>();
            for at in range {
                let position = self.surfaces.points::<f32>(at).position;
                let towards = match stage.receives_caustics(&self.parameters, at) {
                    true => target(self.slot[at], position.into()),
                    false => None,
                };
                let Some((towards, unit)) = towards.and_then(|v| Some((v, v.try_normalize()?)))
                else {
                    self.lights.clear(at, self.surfaces.shading_normal(at));
                    continue;
                };
                for axis in 0..3 {
                    self.lights.wi[axis][at] = unit[axis];
                    self.lights.shadow[axis][at] = towards[axis];
                    self.lights.radiance[axis][at] = 1.0;
                }
                self.lights.density[at] = f32::INFINITY;
                self.lights.shadow_end[at] = 1.0;
            }
        }
    }

    /// Multiplies contributions and next throughputs by |n_s w_l| |n_g w| / (|n_g w_l| |n_s w|), with
    /// the shading normal n_s, the normal n_g of the surface, the direction w_l to the light and
    /// the direction w to the lens (Veach 1997, equation 5.19).
    fn correct_for_flux(&mut self) {
        for at in self.indices() {
            let surface: Vec3 = self.surfaces.points::<f32>(at).normal.into();
            let shading = Vec3::from(vector(&self.normal, at));
            let ratio = |w: [f32; 3]| {
                let w = Vec3::from(w);
                (surface.dot(w) / shading.dot(w)).abs()
            };
            let from_light = ratio(vector(&self.wo, at));
            let factor = |w: [f32; 3]| {
                let factor = ratio(w) / from_light;
                if factor.is_finite() { factor } else { 0.0 }
            };
            let (to_lens, onwards) =
                (factor(vector(&self.lights.wi, at)), factor(vector(&self.next, at)));
            for axis in 0..3 {
                self.contribution[axis][at] *= to_lens;
                self.next_throughput[axis][at] *= onwards;
            }
        }
    }
}

/// Shades the surfaces that light paths hit.
///
/// `target` returns the vector to the lens from a point of a path, given by its slot; `None` if the
/// vertex sends no light there. Writes to `shadows` one ray for each of these vectors, with the
/// throughput that arrives if nothing occludes it, and to `next` the next rays of the paths.
pub fn shade_light_paths<R: Real<Scalar = f32>>(
    inputs: &ShadeInputs,
    samples: &SampleBatch,
    columns: &mut ShadeColumns,
    target: &mut dyn FnMut(u32, Vec3) -> Option<Vec3>,
    (shadows, next): (&mut RayBatch, &mut RayBatch),
) {
    let ShadeColumns { random, vertices } = columns;
    shadows.len = 0;
    next.len = 0;
    if inputs.vertex.depth >= inputs.vertex.limits.max_depth {
        return;
    }
    vertices.sort(inputs);
    vertices.load_surfaces::<R>(inputs);
    vertices.load_paths(inputs);
    vertices.load_materials::<R>(inputs);
    random.fill(&inputs.vertex, vertices, 0, samples);
    vertices.aim(target);
    // Camera paths sample the same light: values must have the mean of samples.
    vertices.coat_weights = MisWeights::Exact;
    vertices.evaluate::<R>(&Evaluation { scene: inputs.scene, random, skip_mis: false });
    vertices.correct_for_flux();
    vertices.spawn::<R>(inputs, random, shadows, next);
}
