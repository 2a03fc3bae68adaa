//! Stochastic alpha test: a ray hits a shape with the probability of its alpha at the point.

use glam::{DVec3, Vec2};

use super::texture::{Texture, TexturePoint};
use super::{RayPoint, Shape, SurfacePoint};
use petzval_base::rays::Hit;

impl Shape {
    /// Returns whether no ray hits the shape, because its alpha is 0 everywhere.
    pub(super) fn is_invisible(&self) -> bool {
        matches!(self.alpha, Some(Texture::Constant([alpha, ..])) if alpha <= 0.0)
    }

    /// Returns the alpha at a point of the shape, 0 to 1, object space.
    pub(super) fn alpha_at(
        &self,
        uv: Vec2,
        point: &SurfacePoint,
        vertex_colour: Option<[f32; 4]>,
    ) -> f32 {
        let Some(alpha) = &self.alpha else { return 1.0 };
        let at = TexturePoint {
            uv: uv.to_array(),
            position: point.position.to_array(),
            normal: point.normal.to_array(),
            footprint: 0.0,
            uv_steps: [[0.0; 2]; 2],
            position_steps: [[0.0; 3]; 2],
            vertex_colour,
        };
        alpha.scalar(&at).clamp(0.0, 1.0)
    }

    /// Returns whether a ray hits the shape: true with the probability alpha, by a hash of the ray
    /// and the primitive (pbrt-v4 hashes the ray only). Ray and hit are in object space.
    pub(super) fn passes_alpha_test(
        &self,
        origin: [f32; 3],
        direction: [f32; 3],
        hit: &Hit,
    ) -> bool {
        if self.is_opaque() {
            return true;
        }
        let near = || {
            let [o, d] = [origin, direction].map(|v| DVec3::from_array(v.map(f64::from)));
            RayPoint { position: o + d * f64::from(hit.t), direction: d }
        };
        let uv = self.geometry.derivatives(hit, near).uv;
        let point = self.geometry.point(hit, near);
        let alpha = self.alpha_at(uv, &point, self.geometry.vertex_colour(hit));
        alpha >= 1.0 || alpha > 0.0 && alpha_threshold(origin, direction, hit) < alpha
    }
}

/// Returns a random number in [0, 1) for a ray and a triangle, or a ray and a side of a quadric.
/// The numbers are independent: a quarter of the rays passes two sheets of alpha 0.5 one behind the
/// other. (pbrt-v4 uses one number for all triangles of a ray, so half of the rays pass.)
fn alpha_threshold(origin: [f32; 3], direction: [f32; 3], hit: &Hit) -> f32 {
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
    use glam::DAffine3;
    use petzval_base::lanes::f32x8;
    use petzval_base::rays::{HitBatch, NO_INDEX, Ray, RayBatch, WAVE_SIZE};

    use crate::{
        Geometry, Material, Mesh, Quadric, QuadricForm, SceneBuilder, ShapeSpec, Texture,
        TraversalStack,
    };

    /// Returns two squares one behind the other; the front one has an alpha.
    fn squares(alpha: f32) -> crate::Scene {
        let mut builder = SceneBuilder::default();
        let material = builder.add_material(Material::diffuse([0.5; 3]));
        for z in [1.0, 2.0] {
            let positions = vec![[0.0, 0.0, z], [4.0, 0.0, z], [4.0, 4.0, z], [0.0, 4.0, z]];
            let triangles = vec![[0, 1, 2], [0, 2, 3]];
            let mesh = Mesh { positions, triangles, ..Mesh::default() };
            builder.add_shape(ShapeSpec::new(Geometry::Mesh(mesh), material));
        }
        builder.shapes[0].alpha = Some(Texture::Constant([alpha; 3]));
        builder.build().unwrap()
    }

    #[test]
    fn both_sides_of_a_sphere_use_independent_random_numbers() {
        let mut builder = SceneBuilder::default();
        let material = builder.add_material(Material::diffuse([0.5; 3]));
        let form = QuadricForm::Sphere { radius: 1.0, z: [-1.0, 1.0] };
        let sphere = Quadric::new(form, std::f64::consts::TAU, DAffine3::IDENTITY, false).unwrap();
        builder.add_shape(ShapeSpec::new(Geometry::Quadric(sphere), material));
        builder.shapes[0].alpha = Some(Texture::Constant([0.5; 3]));
        let (scene, mut stack) = (builder.build().unwrap(), TraversalStack::default());
        let rays = 200_000;
        let passed = (0..rays).filter(|&i| {
            let [x, y] = [i % 500, i / 500].map(|i| i as f32 / 500.0 - 0.4);
            let ray =
                Ray { origin: [x, y, -3.0], direction: [0.0, 0.0, 1.0], t_max: f32::INFINITY };
            x * x + y * y < 0.9 && scene.closest::<f32x8>(&ray, &mut stack).shape == NO_INDEX
        });
        let passed = passed.count() as f64;
        let inside = (0..rays).filter(|&i| {
            let [x, y] = [i % 500, i / 500].map(|i| i as f32 / 500.0 - 0.4);
            x * x + y * y < 0.9
        });
        let rays = inside.count() as f64;
        // Five standard deviations.
        assert!((passed / rays - 0.25).abs() < 5.0 * (0.1875 / rays).sqrt(), "{passed} of {rays}");
    }

    #[test]
    fn the_share_of_rays_that_hit_equals_the_alpha() {
        let mut stack = TraversalStack::default();
        for alpha in [-1.0f32, 0.0, 0.3, 0.75, 1.0] {
            let scene = squares(alpha);
            let (mut hit_count, mut rays, mut hits) = (0, 0, HitBatch::default());
            for row in 0..1000 {
                let mut wave = RayBatch::default();
                for i in 0..WAVE_SIZE as u32 {
                    let [x, y] =
                        [i as f32 / WAVE_SIZE as f32, row as f32 / 1000.0].map(|v| 4.0 * v);
                    let origin = [0.001 + 0.99 * x, 0.002 + 0.99 * y, 0.0];
                    wave.push(Ray { origin, direction: [0.0, 0.0, 1.0], t_max: 1.5 }, [1.0; 3], i);
                }
                scene.intersect::<f32x8>(&wave, &mut hits, &mut stack);
                for i in 0..wave.len {
                    let solid = hits[i].shape != NO_INDEX;
                    hit_count += usize::from(solid);
                    if i % 16 == 0 {
                        // Occlusion and the nearest hit agree.
                        let ray = wave.ray(i);
                        assert_eq!(scene.occluded::<f32x8>(&ray, &mut stack), solid);
                        let far = Ray { t_max: f32::INFINITY, ..ray };
                        let hit = scene.closest::<f32>(&far, &mut stack);
                        assert_eq!(hit.shape, u32::from(!solid));
                    }
                }
                rays += wave.len;
            }
            let (fraction, alpha) =
                (hit_count as f64 / rays as f64, f64::from(alpha.clamp(0.0, 1.0)));
            // Five standard deviations of a million samples.
            let sigma = (alpha * (1.0 - alpha) / rays as f64).sqrt();
            assert!((fraction - alpha).abs() <= 5.0 * sigma, "{fraction} for an alpha of {alpha}");
        }
    }
}
