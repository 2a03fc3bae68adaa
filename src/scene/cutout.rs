//! Shapes with holes: whether a ray meets one at a point is decided by its alpha there.

use super::texture::TexturePoint;
use super::{Geometry, Shape};
use crate::rays::Hit;

impl Shape {
    /// Whether a ray meets the shape at a hit: with the probability alpha, by a number that
    /// depends on the ray and the triangle alone (as pbrt-v4 does, by a hash of the ray). All in
    /// the space of the object.
    pub(super) fn holds(&self, origin: [f32; 3], direction: [f32; 3], hit: &Hit) -> bool {
        let (Some(alpha), Geometry::Mesh(mesh)) = (&self.alpha, &self.geometry) else {
            return true;
        };
        let patch = mesh.patch(hit);
        let position = mesh.point(hit).position;
        let [alpha, ..] = alpha.at(&TexturePoint { uv: patch.uv, position, footprint: 0.0 });
        alpha >= 1.0 || alpha > 0.0 && share(origin, direction, hit) < alpha
    }
}

/// A number in [0, 1) for a ray and a triangle.
fn share(origin: [f32; 3], direction: [f32; 3], hit: &Hit) -> f32 {
    let words = origin.iter().chain(&direction).map(|v| v.to_bits());
    // The finalizer of SplitMix64 (Steele, Lea & Flood 2014) over every word.
    let mut state = 0u64;
    for word in words.chain([hit.shape, hit.primitive]) {
        state = (state ^ u64::from(word)).wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ state >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 31;
    }
    (state >> 40) as f32 / (1u32 << 24) as f32
}
