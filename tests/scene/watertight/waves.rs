//! Waves of coherent rays, whose packets test leaves in step, have the hits of their single rays.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3};
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{Column, Hit, HitBatch, NO_INDEX, RayBatch, WAVE_SIZE};
use petzval_scene::{
    Geometry, Material, Mesh, Quadric, QuadricForm, Scene, SceneBuilder, ShapeSpec, Texture,
    TraversalStack,
};

use super::{ray, torus};
use crate::support::Random;

const FORMS: [QuadricForm; 6] = [
    QuadricForm::Sphere { radius: 0.3, z: [-0.3, 0.3] },
    QuadricForm::Sphere { radius: 0.3, z: [-0.1, 0.2] },
    QuadricForm::Cylinder { radius: 0.2, z: [-0.2, 0.4] },
    QuadricForm::Disk { radius: 0.4, inner: 0.1, height: 0.1 },
    QuadricForm::Cone { radius: 0.2, height: 0.5 },
    QuadricForm::Cone { radius: 0.3, height: -0.4 },
];

fn turned(angle: f64, shift: DVec3) -> DAffine3 {
    let turn = DAffine3::from_rotation_x(angle) * DAffine3::from_rotation_y(2.0 * angle);
    DAffine3::from_translation(shift) * turn * DAffine3::from_scale(DVec3::new(1.0, 0.8, 1.3))
}

/// Returns two large triangles under rows of quadrics: shapes, instances, partial ones and one with an
/// alpha. With `apart`, each object holds a second shape out of sight, so that no instance is taken for
/// its quadric.
fn rows_of_quadrics(apart: bool) -> Scene {
    let mut builder = SceneBuilder::default();
    let material = builder.add_material(Material::diffuse([0.5; 3]));
    let ground = Mesh {
        positions: vec![[-9.0, -0.5, -9.0], [9.0, -0.5, -9.0], [9.0, -0.5, 9.0], [-9.0, -0.5, 9.0]],
        triangles: vec![[0, 1, 2], [2, 3, 0]],
        ..Mesh::default()
    };
    builder.add_shape(ShapeSpec::new(Geometry::Mesh(ground), material));
    builder.add_shape(ShapeSpec::new(Geometry::Mesh(torus(20, 10)), material));
    for (i, form) in FORMS.into_iter().enumerate() {
        let across = i as f64 - 2.5;
        for (row, phi_max) in [TAU, 4.0].into_iter().enumerate() {
            let depth = 0.7 * row as f64;
            let place = turned(0.3 * across, DVec3::new(across * 0.7, 0.0, depth));
            let quadric = Geometry::Quadric(Quadric::new(form, phi_max, place, false).unwrap());
            let alpha = (row == 1 && i % 2 == 0).then_some(Texture::Constant([0.6; 3]));
            let spec = ShapeSpec { alpha, ..ShapeSpec::new(quadric, material) };
            builder.add_shape(spec.clone());
            let object = builder.add_object();
            let inside = |spec| ShapeSpec { object: Some(object), ..spec };
            builder.add_shape(inside(spec));
            if apart {
                let far = DAffine3::from_translation(DVec3::splat(-900.0));
                let far = Geometry::Quadric(Quadric::new(form, 1e-3, far, false).unwrap());
                builder.add_shape(inside(ShapeSpec::new(far, material)));
            } else {
                // The shapes of both scenes have the same indices.
                let far = Geometry::Quadric(Quadric::new(form, 1e-3, place, false).unwrap());
                builder.add_object();
                let alpha = Some(Texture::Constant([0.0; 3]));
                builder.add_shape(ShapeSpec { alpha, ..ShapeSpec::new(far, material) });
            }
            for copy in 0..3 {
                let shift = DVec3::new(0.1, 0.7 * f64::from(copy), -1.4 + 0.1 * across);
                builder.add_instance(object, turned(0.2 * f64::from(copy), shift));
            }
        }
    }
    builder.build().unwrap()
}

/// Returns waves of rays from one point through a small window each, as a camera or a light has them,
/// and of rays from points of the ground.
fn coherent_waves() -> Vec<RayBatch> {
    let mut random = Random::new(31);
    let mut waves = Vec::new();
    for wave in 0..40 {
        let mut point = |r: f64| DVec3::from_array([(); 3].map(|()| random.between(-r, r)));
        let (eye, window) = (point(3.0), point(1.0));
        let mut rays = RayBatch::default();
        for i in 0..WAVE_SIZE as u32 - 5 {
            let mut eye = if wave % 4 == 0 { point(3.0) } else { eye };
            if wave % 2 == 0 {
                eye.y = -0.5;
            }
            let mut ray = ray(eye, window + point(0.4));
            if i % 5 == 0 {
                ray.t_max = 3.0;
            }
            rays.push(ray, [1.0, 2.0, 3.0], i);
        }
        waves.push(rays);
    }
    waves
}

fn bits(hit: &Hit) -> [u32; 6] {
    let [t, u, v] = [hit.t, hit.u, hit.v].map(f32::to_bits);
    [t, u, v, hit.shape, hit.primitive, hit.instance]
}

/// Checks the hits of waves against those of single rays.
fn check<R: Real<Scalar = f32>>(scene: &Scene) {
    let mut stack = TraversalStack::default();
    let (mut hits, mut on_quadrics, mut on_instances) = (HitBatch::default(), 0, 0);
    for wave in coherent_waves() {
        scene.intersect::<R>(&wave, &mut hits, &mut stack);
        let mut radiance: [Column<f32>; 3] = Default::default();
        scene.occlude::<R>(&wave, &mut stack, &mut radiance);
        for i in 0..wave.len {
            let single = scene.closest::<f32x8>(&wave.ray(i), &mut stack);
            assert_eq!(bits(&hits[i]), bits(&single), "{:?}", wave.ray(i));
            let free = radiance[1][i] != 0.0;
            assert_eq!(free, single.shape == NO_INDEX, "{:?}", wave.ray(i));
            on_quadrics += usize::from(single.shape > 1 && !free);
            on_instances += usize::from(single.instance != NO_INDEX);
        }
    }
    assert!(on_quadrics > 5_000, "{on_quadrics} hits on quadrics");
    assert!(on_instances > 2_000, "{on_instances} hits on instances");
}

#[test]
fn coherent_waves_have_the_hits_of_their_single_rays() {
    let scene = rows_of_quadrics(false);
    check::<f32x8>(&scene);
    check::<f32>(&scene);
}

#[test]
fn instances_of_one_quadric_have_the_hits_of_other_instances() {
    // One scene tests the quadric of an instance in f64; the other transforms its rays in f32.
    let (direct, nested) = (rows_of_quadrics(false), rows_of_quadrics(true));
    let (mut stack, mut differ, mut rays) = (TraversalStack::default(), 0, 0);
    let mut largest = 0.0f32;
    for wave in coherent_waves() {
        for i in 0..wave.len {
            let ray = wave.ray(i);
            let one = direct.closest::<f32x8>(&ray, &mut stack);
            let other = nested.closest::<f32x8>(&ray, &mut stack);
            rays += 1;
            if [one.shape, one.instance] != [other.shape, other.instance] {
                // At silhouettes and at the edges of partial shapes.
                differ += 1;
            } else if one.shape != NO_INDEX {
                let point = direct.surface(&ray, &one).1;
                let at = glam::Vec3::from(ray.origin) + one.t * glam::Vec3::from(ray.direction);
                largest = largest.max((point.position - at).length());
            }
        }
    }
    assert!(differ * 2000 < rays, "{differ} of {rays} rays have other hits");
    // Rounding of numbers up to 6, a few times.
    assert!(largest < 4e-6, "a hit is {largest} from the surface point");
}

/// Checks shadow rays that end on a surface, as those to a point of a light do.
fn check_ends<R: Real<Scalar = f32>>(scene: &Scene) {
    let mut stack = TraversalStack::default();
    let mut ends = 0;
    for wave in coherent_waves() {
        let mut shadows = RayBatch::default();
        for i in 0..wave.len {
            let mut ray = wave.ray(i);
            ray.t_max = scene.closest::<R>(&ray, &mut stack).t;
            shadows.push(ray, [1.0; 3], i as u32);
        }
        let mut radiance: [Column<f32>; 3] = Default::default();
        scene.occlude::<R>(&shadows, &mut stack, &mut radiance);
        for i in 0..shadows.len {
            let ray = shadows.ray(i);
            let alone = scene.occluded::<R>(&ray, &mut stack);
            assert_eq!(radiance[0][i] == 0.0, alone, "{ray:?}");
            ends += usize::from(ray.t_max.is_finite());
        }
    }
    assert!(ends > 5_000, "{ends} rays end on a surface");
}

#[test]
fn coherent_shadow_rays_that_end_on_a_surface_are_blocked_like_single_rays() {
    let scene = rows_of_quadrics(false);
    check_ends::<f32x8>(&scene);
    check_ends::<f32>(&scene);
}
