//! Russian roulette, and the shadow rays and next rays that leave the vertices of a wave.

use super::footprint::SpecularBounce;
use super::vertices::{Vertices, vector};
use super::{PathVertex, ShadeInputs};
use crate::rays::{Ray, RayBatch, RayDifferential};

/// Returns the largest channel of a throughput.
#[inline(always)]
pub(super) fn max_component(throughput: [f32; 3]) -> f32 {
    throughput.iter().fold(0.0, |a, &b| a.max(b))
}

impl Vertices {
    /// Returns the probability with which a path survives Russian roulette, or `None` if it
    /// survives in any case.
    ///
    /// The probability is the share of the camera ray's throughput that is left, without the factor
    /// of refraction on radiance. The camera ray's own throughput contains the exposure. It is
    /// divided out because the noise of a picture must not depend on the f-number or the ISO.
    #[inline(always)]
    pub(super) fn survival_probability(&self, vertex: &PathVertex, at: usize) -> Option<f32> {
        let scale = self.roulette_scale[at] * self.next_eta2[at];
        let left = max_component(vector(&self.next_throughput, at)) * scale;
        (vertex.depth >= 1 && left < 1.0).then_some(left)
    }

    /// Writes the shadow rays and the next rays of the paths.
    pub(super) fn spawn(
        &mut self,
        inputs: &ShadeInputs,
        shadows: &mut RayBatch,
        next: &mut RayBatch,
    ) {
        for at in self.indices() {
            let (point, slot) = (&self.points[at], self.slot[at]);
            let contribution = vector(&self.contribution, at);
            if contribution.iter().any(|&c| c > 0.0) {
                let (direction, t_max) = self.shadow[at];
                let origin = point.offset_origin(direction.into()).to_array();
                shadows.push(Ray { origin, direction, t_max }, contribution, slot);
            }
            let mut throughput = vector(&self.next_throughput, at);
            if throughput.iter().all(|&t| t <= 0.0) {
                continue;
            }
            if let Some(probability) = self.survival_probability(&inputs.vertex, at) {
                if self.roulette[at] >= probability {
                    continue;
                }
                throughput = throughput.map(|t| t / probability);
            }
            let direction = vector(&self.next, at);
            let origin = point.offset_origin(direction.into()).to_array();
            next.push(Ray { origin, direction, t_max: f32::INFINITY }, throughput, slot);
            let last = next.len - 1;
            next.pdf[last] = self.next_pdf[at];
            next.roulette_scale[last] = self.roulette_scale[at] * self.next_eta2[at];
            if inputs.scene.is_textured() {
                next.differential[last] = self.next_differential(inputs, at);
            }
        }
    }

    /// Returns the differential of a vertex's next ray; it is unknown after scattering.
    fn next_differential(&self, inputs: &ShadeInputs, at: usize) -> RayDifferential {
        if !self.next_pdf[at].is_infinite() {
            return RayDifferential::UNKNOWN;
        }
        let bounce = SpecularBounce {
            normal: vector(&self.normal, at).into(),
            next: vector(&self.next, at).into(),
            eta2: self.next_eta2[at],
        };
        inputs.differential_after_bounce(self.ray[at] as usize, self.points[at], &bounce)
    }
}
