//! Shapes with holes: whether a ray meets one at a point is decided by its alpha there.

use glam::DVec3;

use super::texture::{Texture, TexturePoint};
use super::{Geometry, Shape};
use crate::rays::Hit;

impl Shape {
    /// Whether a ray meets the shape at a hit: with the probability alpha, by a number that
    /// depends on the ray and the place alone (as pbrt-v4 does, by a hash of the ray). All in
    /// the space of the object.
    pub(super) fn holds(&self, origin: [f32; 3], direction: [f32; 3], hit: &Hit) -> bool {
        let Some(alpha) = &self.alpha else { return true };
        let (patch, point) = match &self.geometry {
            Geometry::Mesh(mesh) => (mesh.patch(hit), mesh.point(hit)),
            Geometry::Quadric(quadric) => {
                let [o, d] = [origin, direction].map(|v| DVec3::from_array(v.map(f64::from)));
                let near = o + d * f64::from(hit.t);
                (quadric.patch(near), quadric.point(near))
            }
        };
        let at = TexturePoint {
            uv: patch.uv,
            position: point.position,
            normal: point.normal,
            footprint: 0.0,
        };
        let alpha = alpha.number(&at);
        alpha >= 1.0 || alpha > 0.0 && share(origin, direction, hit) < alpha
    }

    /// The share of the light of a place that its alpha leaves. A shape that is not there at all
    /// shines as if it were.
    pub(super) fn shining(&self, at: &TexturePoint) -> f32 {
        match &self.alpha {
            None => 1.0,
            Some(Texture::Constant([alpha, ..])) if *alpha <= 0.0 => 1.0,
            Some(alpha) => alpha.number(at).clamp(0.0, 1.0),
        }
    }
}

/// A number in [0, 1) for a ray and a triangle, or a place on a quadric, which a ray meets twice.
fn share(origin: [f32; 3], direction: [f32; 3], hit: &Hit) -> f32 {
    let words = origin.iter().chain(&direction).map(|v| v.to_bits());
    // The finalizer of SplitMix64 (Steele, Lea & Flood 2014) over every word.
    let mut state = 0u64;
    for word in words.chain([hit.shape, hit.primitive, hit.t.to_bits()]) {
        state = (state ^ u64::from(word)).wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ state >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 31;
    }
    (state >> 40) as f32 / (1u32 << 24) as f32
}

#[cfg(test)]
mod tests {
    use crate::lanes::f32x8;
    use crate::rays::{HitBatch, NONE, Ray, RayBatch, WAVE};
    use crate::scene::{
        Geometry, Material, Mesh, SceneBuilder, ShapeSpec, Texture, TraversalStack,
    };

    /// Two squares one behind the other; the front one has holes.
    fn squares(alpha: f32) -> crate::scene::Scene {
        let mut builder = SceneBuilder::default();
        let material = builder.material(Material::diffuse([0.5; 3]));
        for z in [1.0, 2.0] {
            let positions = vec![[0.0, 0.0, z], [4.0, 0.0, z], [4.0, 4.0, z], [0.0, 4.0, z]];
            let triangles = vec![[0, 1, 2], [0, 2, 3]];
            let mesh = Mesh { positions, triangles, ..Mesh::default() };
            builder.shape(ShapeSpec::new(Geometry::Mesh(mesh), material));
        }
        builder.shapes[0].alpha = Some(Texture::Constant([alpha; 3]));
        builder.build()
    }

    #[test]
    fn a_surface_is_met_as_often_as_its_alpha_says() {
        let mut stack = TraversalStack::default();
        for alpha in [-1.0f32, 0.0, 0.3, 0.75, 1.0] {
            let scene = squares(alpha);
            let (mut met, mut rays, mut hits) = (0, 0, HitBatch::default());
            for row in 0..1000 {
                let mut wave = RayBatch::default();
                for i in 0..WAVE as u32 {
                    let [x, y] = [i as f32 / WAVE as f32, row as f32 / 1000.0].map(|v| 4.0 * v);
                    let origin = [0.001 + 0.99 * x, 0.002 + 0.99 * y, 0.0];
                    wave.push(Ray { origin, direction: [0.0, 0.0, 1.0], t_max: 1.5 }, [1.0; 3], i);
                }
                scene.intersect::<f32x8>(&wave, &mut hits, &mut stack);
                for i in 0..wave.len {
                    let solid = hits[i].shape != NONE;
                    met += usize::from(solid);
                    if i % 16 == 0 {
                        // Any hit, and the surface behind, agree.
                        let ray = wave.ray(i);
                        assert_eq!(scene.occluded::<f32x8>(&ray, &mut stack), solid);
                        let far = Ray { t_max: f32::INFINITY, ..ray };
                        let hit = scene.closest::<f32>(&far, &mut stack);
                        assert_eq!(hit.shape, u32::from(!solid));
                    }
                }
                rays += wave.len;
            }
            let (share, alpha) = (met as f64 / rays as f64, f64::from(alpha.clamp(0.0, 1.0)));
            // Five standard deviations of a million throws.
            let sigma = (alpha * (1.0 - alpha) / rays as f64).sqrt();
            assert!((share - alpha).abs() <= 5.0 * sigma, "{share} for an alpha of {alpha}");
        }
    }
}
