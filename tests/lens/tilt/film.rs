//! Shifted and tilted film, as in a view camera.

use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{RayBatch, SampleBatch};
use petzval_base::stats::LensStats;
use petzval_lens::{Camera, LensColumns, LensModel, Paraxial, Pose};

use super::camera;
use crate::support::sampling::random_samples;
use crate::support::{LENSES, Random, lens};

fn exposed<R: Real<Scalar = f32>>(camera: &Camera, samples: &SampleBatch) -> RayBatch {
    let mut rays = RayBatch::default();
    camera.generate_rays::<R>(
        samples,
        &mut LensColumns::default(),
        &mut rays,
        &mut LensStats::default(),
    );
    rays
}

/// Returns the point, mm, where the rays come closest to each other: least squares over their slopes.
fn focus(rays: &RayBatch) -> [f64; 3] {
    let count = rays.len as f64;
    let slope = |i: usize, axis: usize| {
        f64::from(rays.direction[axis][i]) / f64::from(rays.direction[2][i])
    };
    let at = |i: usize, axis: usize| {
        f64::from(rays.origin[axis][i]) - f64::from(rays.origin[2][i]) * slope(i, axis)
    };
    let mean = |of: &dyn Fn(usize, usize) -> f64, axis: usize| {
        (0..rays.len).map(|i| of(i, axis)).sum::<f64>() / count
    };
    let (mut across, mut spread) = (0.0, 0.0);
    for axis in 0..2 {
        let (middle, drift) = (mean(&at, axis), mean(&slope, axis));
        for i in 0..rays.len {
            across += (at(i, axis) - middle) * (slope(i, axis) - drift);
            spread += (slope(i, axis) - drift).powi(2);
        }
    }
    let depth = -across / spread;
    let place = |axis: usize| mean(&at, axis) + depth * mean(&slope, axis);
    [place(0), place(1), depth]
}

#[test]
fn tilted_film_focuses_a_tilted_plane_as_scheimpflug_says() {
    for (name, object) in [("dgauss.50mm", 1000.0), ("telephoto.250mm", 4000.0)] {
        let mut lens = lens(name);
        let stop = lens.stop();
        lens.stop_down(lens.rows[stop].diameter / 4.0);
        let paraxial = Paraxial::new(&lens);
        let distance = paraxial.film_for_focus(object).expect("a distance that can be focused");
        // The planes of film, lens and focus meet in a line: tan' = tan / |m|, with m = -x' / f (Newton).
        let magnification = (distance - paraxial.back_focal_distance) / paraxial.focal_length;
        for (tilt, axis, sign) in [([4.0, 0.0], 1, 1.0), ([0.0, -3.0], 0, 1.0)] {
            let pose = Pose::of_film([0.0; 2], tilt);
            let camera = camera(lens.clone(), distance, pose, [36.0, 24.0]);
            let seen = |place: f32| {
                let mut samples = random_samples([0.0; 2], &mut Random::new(3));
                samples.film[axis].fill(place);
                focus(&exposed::<f32x8>(&camera, &samples))
            };
            let (one, other) = (seen(2.0), seen(-2.0));
            let slope = (one[2] - other[2]) / (one[axis] - other[axis]);
            let angle: f64 = tilt.iter().sum();
            let expected = sign * angle.to_radians().tan().abs() / magnification;
            println!("{name} {tilt:?}: {slope:.4}, expected {expected:.4}");
            assert!((slope / expected - 1.0).abs() < 0.01, "{name}: {slope} {expected}");
        }
    }
}

#[test]
fn shifted_film_is_a_piece_of_larger_film() {
    for (name, distance) in LENSES {
        let (small, shift) = ([12.0, 9.0], [4.0, -3.0]);
        let shifted = camera(lens(name), distance, Pose::of_film(shift, [0.0; 2]), small);
        // A square in the circle around the shifted film, so that both have the same pupil table.
        let radius = small[0].hypot(small[1]) / 2.0 + shift[0].hypot(shift[1]);
        let side = 2.0 * radius / 2f64.sqrt();
        let whole = camera(lens(name), distance, Pose::ALIGNED, [side, side]);
        let here = random_samples(small, &mut Random::new(7));
        let mut there = here.clone();
        for axis in 0..2 {
            // The picture is upside down on the film.
            there.film[axis].iter_mut().for_each(|v| *v -= shift[axis] as f32);
        }
        let (one, other) = (exposed::<f32x8>(&shifted, &here), exposed::<f32x8>(&whole, &there));
        assert_eq!(one.len, other.len, "{name}");
        assert!(one.len > 900, "{name}: {}", one.len);
        for i in 0..one.len {
            assert_eq!(one.ray(i), other.ray(i), "{name}");
            assert_eq!(one.throughput(i), other.throughput(i), "{name}");
        }
    }
}

#[test]
fn a_shift_moves_the_view_towards_that_side() {
    for (shift, axis) in [([5.0, 0.0], 0), ([0.0, 5.0], 1)] {
        let pose = Pose::of_film(shift, [0.0; 2]);
        let camera = camera(lens("dgauss.50mm"), 36.77, pose, [24.0, 24.0]);
        let mut rays = RayBatch::default();
        camera.central_ray([50, 50], [101, 101], &mut rays);
        let direction = rays.ray(0).direction;
        // A shift of 5 mm at a distance of some 50 mm.
        assert!((0.07..0.12).contains(&direction[axis]), "{shift:?}: {direction:?}");
        assert!(direction[1 - axis].abs() < 1e-3, "{shift:?}: {direction:?}");
    }
}

#[test]
fn one_lane_and_eight_are_the_same_bit_for_bit() {
    let poses = [
        Pose::of_film([10.0, -4.0], [0.0; 2]),
        Pose::of_film([0.0; 2], [8.0, -3.0]),
        Pose::of_film([3.0, 5.0], [-20.0, 11.0]),
        Pose::ALIGNED,
    ];
    for ((name, distance), pose) in LENSES.into_iter().zip(poses) {
        let mut lens = lens(name);
        lens.rows[2].pose = Pose { decentre: [0.2, 0.1], tilt: [0.4, -0.3] };
        let camera = camera(lens, distance, pose, [18.0, 12.0]);
        let samples = random_samples(camera.film, &mut Random::new(9));
        let (one, eight) = (exposed::<f32>(&camera, &samples), exposed::<f32x8>(&camera, &samples));
        assert_eq!(one.len, eight.len, "{name} {pose}");
        assert!(one.len > 100, "{name} {pose}: {}", one.len);
        for i in 0..one.len {
            assert_eq!(one.ray(i), eight.ray(i), "{name} {pose}");
            assert_eq!(one.throughput(i), eight.throughput(i), "{name} {pose}");
        }
    }
}

#[test]
fn the_estimated_displacement_equals_the_shift() {
    let square = camera(lens("dgauss.50mm"), 36.77, Pose::ALIGNED, [36.0, 24.0]);
    let LensModel::Real(real) = &square.model else { panic!("a real lens") };
    let displacement =
        |lens: &petzval_lens::Prescription, pose: Pose| real.displacement(lens, pose, square.film);
    let itself = &real.prescription;
    // The lens against itself, to rounding.
    assert!(displacement(itself, Pose::ALIGNED) < 1e-6);
    let shifted = displacement(itself, Pose::of_film([0.3, -0.4], [0.0; 2]));
    assert!((shifted - 500.0).abs() < 1e-6, "{shifted}");
    // A decentred lens moves the image of distant objects with it, that of near ones by 1 - m.
    let mut decentred = itself.clone();
    let rows = [0, itself.rows.len() - 1];
    let pose = Pose { decentre: [0.1, 0.0], ..Pose::ALIGNED };
    decentred.tilt_decenters = vec![petzval_lens::TiltDecenter { rows, pose }];
    let moved = displacement(&decentred, Pose::ALIGNED);
    assert!((50.0..200.0).contains(&moved), "{moved}");
}
