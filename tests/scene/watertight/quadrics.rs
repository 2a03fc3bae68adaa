//! Quadrics: hits by their formulas, and samples on their surfaces.

use std::f64::consts::TAU;

use glam::{DAffine3, DVec3};
use petzval_scene::{Quadric, QuadricForm};

use crate::support::Random;

#[test]
fn hits_of_quadrics_agree_with_their_formulas() {
    let place = DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0));
    let sphere =
        Quadric::new(QuadricForm::Sphere { radius: 2.0, z: [-2.0, 2.0] }, TAU, place, false)
            .unwrap();
    let hit = |q: &Quadric, o: [f64; 3], d: [f64; 3]| {
        q.intersect(DVec3::from_array(o), DVec3::from_array(d), f64::INFINITY)
    };
    assert_eq!(hit(&sphere, [1.0, 2.0, -7.0], [0.0, 0.0, 1.0]), Some(8.0));
    assert_eq!(hit(&sphere, [1.0, 2.0, 3.0], [0.0, 0.0, 1.0]), Some(2.0));
    assert_eq!(hit(&sphere, [1.0, 4.1, -7.0], [0.0, 0.0, 1.0]), None);
    let disk = QuadricForm::Disk { radius: 2.0, inner: 1.0, height: 0.5 };
    let disk = Quadric::new(disk, TAU, place, false).unwrap();
    assert_eq!(hit(&disk, [2.5, 2.0, 0.0], [0.0, 0.0, 1.0]), Some(3.5));
    assert_eq!(hit(&disk, [1.5, 2.0, 0.0], [0.0, 0.0, 1.0]), None);
    let cone =
        Quadric::new(QuadricForm::Cone { radius: 1.0, height: 2.0 }, TAU, place, false).unwrap();
    // The radius is half at half the height.
    let t = hit(&cone, [-9.0, 2.0, 4.0], [1.0, 0.0, 0.0]).unwrap();
    assert!((t - 9.5).abs() < 1e-12, "{t}");
    assert_eq!(hit(&cone, [-9.0, 2.0, 5.1], [1.0, 0.0, 0.0]), None);
    // A half cone without the side of negative y.
    let half =
        Quadric::new(QuadricForm::Cone { radius: 1.0, height: 2.0 }, TAU / 2.0, place, false)
            .unwrap();
    assert!(hit(&half, [1.0, -9.0, 4.0], [0.0, 1.0, 0.0]).unwrap() > 11.0);
}

#[test]
fn samples_of_quadrics_lie_on_them_and_are_uniform_by_area() {
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.5, 0.5, 2.0),
        glam::DQuat::from_rotation_x(0.7),
        DVec3::new(1.0, 2.0, 3.0),
    );
    for form in [
        QuadricForm::Sphere { radius: 1.2, z: [-1.2, 1.2] },
        QuadricForm::Sphere { radius: 1.2, z: [-0.3, 0.9] },
        QuadricForm::Disk { radius: 1.1, inner: 0.0, height: 0.2 },
        QuadricForm::Disk { radius: 1.1, inner: 0.4, height: 0.2 },
        QuadricForm::Cone { radius: 0.7, height: 1.3 },
    ] {
        for phi_max in [TAU, 2.0] {
            let shape = Quadric::new(form, phi_max, place, false).unwrap();
            let mut random = Random::new(17);
            let (mut area, mut far) = (0.0, 0.0f64);
            let n = 40_000;
            for _ in 0..n {
                let (point, density) = shape.sample([random.next() as f32, random.next() as f32]);
                area += 1.0 / f64::from(density) / f64::from(n);
                let back = shape.point(point.position.as_dvec3());
                far = far.max(f64::from(back.position.distance(point.position)));
                assert!(back.normal.dot(point.normal) > 0.999, "{form:?}");
                // A ray along the normal hits the shape at the sample.
                let above = (point.position + point.normal).as_dvec3();
                let t = shape.intersect(above, -point.normal.as_dvec3(), 2.0);
                let met = t.is_some_and(|t| t < 1.0 + 1e-4);
                // By rounding a sample may lie just beyond the edge of a partial shape.
                assert!(met || has_edges(form, phi_max), "{form:?} {phi_max}: {t:?}");
            }
            assert!(far < 1e-5, "{form:?}: a sample is {far} away from its shape");
            let expected = shape.area();
            assert!((area / expected - 1.0).abs() < 0.02, "{form:?}: {area} and {expected}");
        }
    }
}

/// Returns whether a form has open edges.
fn has_edges(form: QuadricForm, phi_max: f64) -> bool {
    phi_max < TAU || !matches!(form, QuadricForm::Sphere { radius, z } if z == [-radius, radius])
}
