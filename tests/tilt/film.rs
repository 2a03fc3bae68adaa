//! Film that is shifted and tilted, as in a view camera.

use petzval::lanes::{Real, f32x8};
use petzval::lens::{Camera, LensColumns, Model, Paraxial, Pose};
use petzval::rays::{RayBatch, SampleBatch, WAVE};
use petzval::stats::LensStats;

use super::camera;
use super::support::{LENSES, Random, lens};

fn stats() -> LensStats {
    LensStats { blocked: vec![0; 32], ..LensStats::default() }
}

fn exposed<R: Real<Scalar = f32>>(camera: &Camera, samples: &SampleBatch) -> RayBatch {
    let mut rays = RayBatch::default();
    camera.expose::<R>(samples, &mut LensColumns::default(), &mut rays, &mut stats());
    rays
}

/// Samples all over a film of this size.
fn samples(film: [f64; 2], seed: u64) -> SampleBatch {
    let mut samples = SampleBatch { len: WAVE, ..SampleBatch::default() };
    let mut random = Random::new(seed);
    for i in 0..WAVE {
        for axis in 0..2 {
            samples.film[axis][i] = (film[axis] * (random.next() - 0.5)) as f32;
            samples.pupil[axis][i] = random.next() as f32;
        }
    }
    samples
}

/// The depth before the front vertex, mm, at which rays come nearest to each other, and where they
/// do so across the axis: least squares over their slopes.
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
        let paraxial = Paraxial::of(&lens);
        let distance = paraxial.film_for_focus(object).expect("a distance that can be focused");
        // Planes of film, lens and focus meet in a line: tan' = tan / |m|, m = -x' / f (Newton).
        let magnification = (distance - paraxial.back_focal_distance) / paraxial.focal_length;
        for (tilt, axis, sign) in [([4.0, 0.0], 1, 1.0), ([0.0, -3.0], 0, 1.0)] {
            let pose = Pose::of_film([0.0; 2], tilt);
            let camera = camera(lens.clone(), distance, pose, [36.0, 24.0]);
            let seen = |place: f32| {
                let mut samples = samples([0.0; 2], 3);
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
        // As large as the circle that the small one lies in, so that both know the same pupils.
        let radius = small[0].hypot(small[1]) / 2.0 + shift[0].hypot(shift[1]);
        let side = 2.0 * radius / 2f64.sqrt();
        let whole = camera(lens(name), distance, Pose::SQUARE, [side, side]);
        let here = samples(small, 7);
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
            assert_eq!(one.carried(i), other.carried(i), "{name}");
        }
    }
}

#[test]
fn a_shift_shows_more_of_what_is_there_in_the_picture() {
    for (shift, axis) in [([5.0, 0.0], 0), ([0.0, 5.0], 1)] {
        let pose = Pose::of_film(shift, [0.0; 2]);
        let camera = camera(lens("dgauss.50mm"), 36.77, pose, [24.0, 24.0]);
        let mut rays = RayBatch::default();
        camera.principal([50, 50], [101, 101], &mut rays);
        let direction = rays.ray(0).direction;
        // 5 mm to the side at 50 mm and some.
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
        Pose::SQUARE,
    ];
    for ((name, distance), pose) in LENSES.into_iter().zip(poses) {
        let mut lens = lens(name);
        lens.rows[2].pose = Pose { decentre: [0.2, 0.1], tilt: [0.4, -0.3] };
        let camera = camera(lens, distance, pose, [18.0, 12.0]);
        let samples = samples(camera.film, 9);
        let (one, eight) = (exposed::<f32>(&camera, &samples), exposed::<f32x8>(&camera, &samples));
        assert_eq!(one.len, eight.len, "{name} {pose}");
        assert!(one.len > 100, "{name} {pose}: {}", one.len);
        for i in 0..one.len {
            assert_eq!(one.ray(i), eight.ray(i), "{name} {pose}");
            assert_eq!(one.carried(i), eight.carried(i), "{name} {pose}");
        }
    }
}

#[test]
fn the_plan_knows_how_far_light_is_moved() {
    let square = camera(lens("dgauss.50mm"), 36.77, Pose::SQUARE, [36.0, 24.0]);
    let Model::Real(real) = &square.model else { panic!("a real lens") };
    let displacement =
        |lens: &petzval::lens::Prescription, pose: Pose| real.displacement(lens, pose, square.film);
    let itself = &real.prescription;
    // Backwards by the same way, to rounding.
    assert!(displacement(itself, Pose::SQUARE) < 1e-6);
    let shifted = displacement(itself, Pose::of_film([0.3, -0.4], [0.0; 2]));
    assert!((shifted - 500.0).abs() < 1e-6, "{shifted}");
    // All of a lens to the side takes the picture of distant things along, and near ones by 1 - m.
    let mut decentred = itself.clone();
    let rows = [0, itself.rows.len() - 1];
    let pose = Pose { decentre: [0.1, 0.0], ..Pose::SQUARE };
    decentred.askew = vec![petzval::lens::Askew { rows, pose }];
    let moved = displacement(&decentred, Pose::SQUARE);
    assert!((50.0..200.0).contains(&moved), "{moved}");
}
