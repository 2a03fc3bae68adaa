//! A height field, and waves of the rays that a picture of it needs.

use glam::Vec3;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{NO_INDEX, Ray, RayBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_scene::{
    Geometry, Material, Mesh, Scene, SceneBuilder, ShapeSpec, TraversalStack, cosine_hemisphere,
};

/// Returns hills of `side` by `side` quads, two triangles each.
pub fn hills(side: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=side {
        for i in 0..=side {
            let (x, z) =
                (i as f32 / side as f32 * 20.0 - 10.0, j as f32 / side as f32 * 20.0 - 10.0);
            let y = (x * 1.3).sin() * (z * 0.9).cos() + 0.2 * (x * 9.0).cos() * (z * 7.0).sin();
            mesh.positions.push([x, y, z]);
        }
    }
    for j in 0..side {
        for i in 0..side {
            let a = j * (side + 1) + i;
            mesh.triangles.extend([[a, a + 1, a + side + 2], [a, a + side + 2, a + side + 1]]);
        }
    }
    mesh
}

/// Samples per pixel, one after another as the film stage takes them.
const SAMPLES: u32 = 16;

/// Returns waves of camera rays (neighbouring pixels, an aperture of 0.1 focused at 8), of diffuse
/// bounces from their hits, and of shadow rays from these hits to a small light.
///
/// # Panics
/// If a camera ray misses the hills.
pub fn waves(scene: &Scene) -> [Vec<RayBatch>; 3] {
    let mut stack = TraversalStack::default();
    let mut all = [const { Vec::new() }; 3];
    for wave in 0..16u32 {
        let [mut camera, mut diffuse, mut shadow] = [(); 3].map(|()| RayBatch::default());
        for i in 0..WAVE_SIZE as u32 {
            // Blocks of 8 by 8 pixels, spread over a picture of 512 by 512.
            let (pixel, key) = (i / SAMPLES, wave * 64 + i / SAMPLES);
            let [u, v] = sample_2d(key, i, Dimension::Film);
            let [a, b] = sample_2d(key, i, Dimension::Pupil);
            let x = (wave % 4 * 128 + pixel % 8) as f32 + u;
            let y = (wave / 4 * 128 + pixel / 8) as f32 + v;
            let lens = Vec3::new(0.1 * (a - 0.5), 0.1 * (b - 0.5), 0.0);
            let focus = 8.0 * Vec3::new(x / 512.0 - 0.5, -0.25 - y / 1024.0, 1.0);
            let direction = (focus - lens).normalize();
            let ray = Ray {
                origin: (Vec3::new(0.0, 4.0, -9.5) + lens).to_array(),
                direction: direction.to_array(),
                t_max: f32::INFINITY,
            };
            camera.push(ray, [1.0; 3], i);
            let hit = scene.closest::<f32x8>(&ray, &mut stack);
            assert_ne!(hit.shape, NO_INDEX, "camera rays of the bench hit the hills");
            let (_, mut point) = scene.surface(&ray, &hit);
            if point.normal.dot(direction) > 0.0 {
                point.normal = -point.normal;
            }
            let (bounce, _) =
                cosine_hemisphere(point.normal, sample_2d(key, i, Dimension::Bounce(0)));
            let leave = |towards: Vec3, t_max: f32| Ray {
                origin: point.offset_origin(towards).to_array(),
                direction: towards.to_array(),
                t_max,
            };
            diffuse.push(leave(bounce, f32::INFINITY), [1.0; 3], i);
            let [u, v] = sample_2d(key, i, Dimension::Light(0));
            let to_light = Vec3::new(6.0 + u, 3.0, 5.0 + v) - point.position;
            shadow.push(leave(to_light, 1.0), [1.0; 3], i);
        }
        for (waves, wave) in all.iter_mut().zip([camera, diffuse, shadow]) {
            waves.push(wave);
        }
    }
    all
}

/// Builds a scene of this mesh alone, diffuse grey.
pub fn built(mesh: Mesh) -> Scene {
    let mut builder = SceneBuilder::default();
    let material = builder.add_material(Material::diffuse([0.5; 3]));
    builder.add_shape(ShapeSpec::new(Geometry::Mesh(mesh), material));
    builder.build().expect("the hills fit into a hierarchy")
}
