//! Intersection of rays with moving shapes.

use glam::{DAffine3, DVec3, Vec3};
use petzval_base::lanes::f32x8;
use petzval_base::rays::{Column, Hit, HitBatch, NO_INDEX, Ray, RayBatch, WAVE_SIZE};
use petzval_scene::TraversalStack;
use petzval_scene::motion::Motion;
use petzval_scene::{
    Geometry, Material, Mesh, Quadric, QuadricForm, Scene, SceneBuilder, ShapeSpec,
};

use crate::support::Random;

fn vector(random: &mut Random, size: f64) -> DVec3 {
    DVec3::from([0; 3].map(|_| random.between(-size, size)))
}

fn transform(random: &mut Random) -> DAffine3 {
    let axis = vector(random, 1.0).normalize();
    DAffine3::from_translation(vector(random, 4.0))
        * DAffine3::from_axis_angle(axis, random.between(-3.0, 3.0))
        * DAffine3::from_scale(DVec3::splat(1.2) + vector(random, 0.8))
}

fn motion(random: &mut Random) -> Motion {
    Motion::between([transform(random), transform(random)]).expect("two transforms of full rank")
}

/// Returns a thin blade, which a bounding box that is slightly too small would cut, and a ball.
fn shapes() -> [Geometry; 2] {
    let blade = Mesh {
        positions: vec![[-1.0, -0.02, 0.0], [1.0, -0.02, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let form = QuadricForm::Sphere { radius: 0.3, z: [-0.3, 0.3] };
    let place = DAffine3::from_translation(DVec3::new(0.8, 0.0, 0.5));
    let ball = Quadric::new(form, std::f64::consts::TAU, place, false).expect("a ball");
    [Geometry::Mesh(blade), Geometry::Quadric(ball)]
}

/// Returns a scene of moving shapes in front of a wall.
fn scene(motions: &[Motion]) -> Scene {
    let mut builder = SceneBuilder::default();
    let material = builder.add_material(Material::diffuse([0.5; 3]));
    for motion in motions {
        let object = builder.add_object();
        for shape in shapes() {
            builder
                .add_shape(ShapeSpec { object: Some(object), ..ShapeSpec::new(shape, material) });
        }
        builder.add_animated_instance(object, motion.clone());
    }
    let wall = Mesh {
        positions: vec![[-9.0, -9.0, 3.0], [9.0, -9.0, 3.0], [0.0, 9.0, 3.0]],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    builder.add_shape(ShapeSpec::new(Geometry::Mesh(wall), material));
    builder.build().unwrap()
}

fn ray(random: &mut Random, towards: DVec3) -> Ray {
    let origin = vector(random, 12.0);
    let direction = (towards + vector(random, 0.3) - origin).normalize();
    Ray {
        origin: origin.as_vec3().to_array(),
        direction: direction.as_vec3().to_array(),
        t_max: f32::INFINITY,
    }
}

#[test]
fn hits_at_a_time_equal_those_of_a_still_scene() {
    let mut random = Random::new(3);
    let (mut stack, mut moving_hits, mut rays) = (TraversalStack::default(), 0, 0);
    for round in 0..60 {
        let mut motions: Vec<Motion> = (0..5).map(|_| motion(&mut random)).collect();
        motions[4] = motion(&mut random).compose(&motions[4]);
        let from = random.between(-0.5, 0.9);
        let range = [from, random.between(from, 1.5)];
        let mut moving = scene(&motions);
        moving.set_time_range(range);
        for moment in 0..8 {
            // Includes the ends of the exposure.
            let time = match moment {
                0 | 1 => range[moment],
                _ => random.between(range[0], range[1]),
            } as f32;
            let time = time.clamp(range[0] as f32, range[1] as f32);
            let at = f64::from(time);
            let poses: Vec<DAffine3> = motions.iter().map(|motion| motion.at(at)).collect();
            let still = scene(&poses.iter().map(|pose| Motion::still(*pose)).collect::<Vec<_>>());
            let (mut wave, mut hits) = (RayBatch::default(), HitBatch::default());
            let mut times = Column::default();
            times.fill(time);
            for slot in 0..200 {
                let target = poses[slot as usize % 5].transform_point3(vector(&mut random, 1.0));
                wave.push(ray(&mut random, target), [1.0; 3], slot);
            }
            moving.intersect::<f32x8>(&wave, &mut hits, &mut stack);
            moving.intersect_animated::<f32x8>(&wave, &times, &mut hits, &mut stack);
            for i in 0..wave.len {
                let ray = wave.ray(i);
                let expected = still.closest::<f32>(&ray, &mut stack);
                let met = Hit { time: 0.0, ..hits[i] };
                assert_eq!(met, expected, "round {round}, time {time} of {range:?}");
                assert_eq!(moving.closest_at::<f32>(&ray, time, &mut stack), hits[i]);
                rays += 1;
                if expected.shape == NO_INDEX || expected.instance == NO_INDEX {
                    continue;
                }
                moving_hits += 1;
                let (there, then) =
                    (still.surface(&ray, &expected).1, moving.surface(&ray, &hits[i]).1);
                assert_eq!([there.position, there.normal], [then.position, then.normal]);
                assert_eq!(
                    still.surface_derivatives(&ray, &expected),
                    moving.surface_derivatives(&ray, &hits[i])
                );
            }
        }
    }
    assert!(moving_hits > rays / 10, "{moving_hits} of {rays} rays hit a moving shape");
}

#[test]
fn shadow_rays_are_blocked_by_shapes_at_their_time() {
    let mut random = Random::new(8);
    let mut stack = TraversalStack::default();
    let motions: Vec<Motion> = (0..8).map(|_| motion(&mut random)).collect();
    let moving = scene(&motions);
    let (mut stopped, mut all) = (0, 0);
    for _ in 0..20 {
        let (mut wave, mut times) = (RayBatch::default(), Column::default());
        for slot in 0..WAVE_SIZE as u32 {
            times[slot as usize] = random.next() as f32;
            let (origin, end) = (vector(&mut random, 5.0), vector(&mut random, 5.0));
            let [origin, direction] = [origin, end - origin].map(|v| v.as_vec3().to_array());
            // In front of the wall.
            let origin = [origin[0], origin[1], origin[2].min(2.0)];
            let t_max = ((2.9 - origin[2]) / direction[2].max(1e-3)).min(1.0);
            wave.push(Ray { origin, direction, t_max }, [1.0, 2.0, 3.0], slot);
        }
        let before = wave.clone();
        moving.occlude_animated::<f32x8>(&mut wave, &times, &mut stack);
        let mut left = 0;
        for i in 0..before.len {
            let ray = before.ray(i);
            let free = moving.closest_at::<f32>(&ray, times[i], &mut stack).shape == NO_INDEX;
            all += 1;
            if !free {
                stopped += 1;
                continue;
            }
            assert_eq!((wave.slot[left], wave.ray(left)), (i as u32, ray), "the order of rays");
            assert_eq!(wave.throughput(left), [1.0, 2.0, 3.0]);
            left += 1;
        }
        assert_eq!(left, wave.len);
    }
    assert!(stopped > all / 50, "{stopped} of {all}");
}

#[test]
fn a_frozen_scene_has_the_hits_of_a_still_scene() {
    let mut random = Random::new(21);
    let mut stack = TraversalStack::default();
    let motions: Vec<Motion> = (0..5).map(|_| motion(&mut random)).collect();
    let mut frozen = scene(&motions);
    frozen.freeze(0.25);
    let still: Vec<Motion> = motions.iter().map(|motion| Motion::still(motion.at(0.25))).collect();
    let still = scene(&still);
    assert!(frozen.animated_instances().is_empty());
    let mut met = 0;
    for i in 0..20_000 {
        let target = motions[i % 5].at(0.25).transform_point3(DVec3::ZERO);
        let ray = ray(&mut random, target);
        let hit = still.closest::<f32x8>(&ray, &mut stack);
        assert_eq!(frozen.closest::<f32x8>(&ray, &mut stack), hit);
        met += usize::from(hit.instance != NO_INDEX);
    }
    assert!(met > 2000, "{met}");
}

#[test]
fn a_motion_through_a_singular_transform_gives_finite_hits() {
    // At half time the shape has no volume; then it is mirrored.
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let motion = Motion::between([DAffine3::IDENTITY, mirror]).expect("of full rank at its ends");
    let moving = scene(&[motion]);
    let ray = Ray { origin: [0.0, 0.0, -5.0], direction: Vec3::Z.to_array(), t_max: 9.0 };
    let mut stack = TraversalStack::default();
    for time in [0.0f32, 0.25, 0.499, 0.5, 0.501, 1.0] {
        let hit = moving.closest_at::<f32x8>(&ray, time, &mut stack);
        assert!(hit.shape == NO_INDEX || hit.t > 0.0);
    }
}
