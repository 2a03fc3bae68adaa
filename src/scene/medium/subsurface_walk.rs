//! Random walk through the medium below a surface.

use glam::Vec3;

use super::medium_pass::MediumPass;
use super::phase_function::sample_henyey_greenstein_cosine;
use super::subsurface::DiffuseBoundary;
use crate::cosine_hemisphere;
use petzval_base::lanes::math::sin_cos_turns;
use petzval_base::lanes::vector::max_component;
use petzval_base::rays::{Hit, PathFlags, RayDifferential};
use petzval_base::sampler::RandomStream;

impl<const SHADOW: bool> MediumPass<'_, SHADOW> {
    /// Turns a ray that walks through the medium where it scatters, or where the boundary reflects
    /// it. `before` is its throughput at the start of the way, of which Russian roulette keeps the
    /// size.
    pub(super) fn walk(&mut self, i: usize, g: f32, boundary: &DiffuseBoundary, before: f32) {
        let (hit, ray) = (self.hits[i], self.rays.ray(i));
        let random = RandomStream::<f32>::new(self.seed(i), []).substream(1);
        let (u, roulette) = (random.pair(0), random.number(2));
        let direction = Vec3::from(ray.direction);
        let (origin, direction) = if hit == Hit::ABSORBED {
            return;
        } else if hit.shape == Hit::IN_MEDIUM {
            let throughput = self.rays.throughput(i);
            let left = max_component::<f32>(throughput) / before;
            if roulette >= left {
                self.hits[i] = Hit::ABSORBED;
                return;
            }
            for channel in 0..3 {
                self.rays.throughput[channel][i] = throughput[channel] / left.min(1.0);
            }
            let next = deflected(direction, g, u);
            (Vec3::from(ray.origin) + hit.t * direction, next)
        } else if self.scene.is_boundary_of(&hit, self.medium)
            && roulette < boundary.internal_reflectance
        {
            let (_, point) = self.scene.surface(&ray, &hit);
            let inwards =
                if point.normal.dot(direction) > 0.0 { -point.normal } else { point.normal };
            let (next, _) = cosine_hemisphere(inwards, u);
            (point.offset_origin(next), next)
        } else {
            return;
        };
        for axis in 0..3 {
            self.rays.origin[axis][i] = origin[axis];
            self.rays.direction[axis][i] = direction[axis];
        }
        // No other technique finds the light that such a ray may hit.
        self.rays.flags[i] = PathFlags::SPECULAR | PathFlags::SCATTERED;
        self.rays.differential[i] = RayDifferential::UNKNOWN;
        self.hits[i] = Hit { t: 0.0, shape: Hit::IN_MEDIUM, primitive: self.medium, ..Hit::MISS };
    }
}

/// Returns the direction of travel after scattering.
fn deflected(along: Vec3, g: f32, u: [f32; 2]) -> Vec3 {
    let cos = -sample_henyey_greenstein_cosine(g, u[0]);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let [y, x] = sin_cos_turns(u[1]);
    let (tangent, bitangent) = along.any_orthonormal_pair();
    (tangent * (sin * x) + bitangent * (sin * y) + along * cos).normalize()
}
