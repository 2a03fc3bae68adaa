//! The pupil sampler against brute force: what a uniform sky of radiance 1 gives the film.

mod support;

use glam::DAffine3;
use petzval::lanes::f32x8;
use petzval::lens::{
    Aim, Camera, From, Iris, LensColumns, LensRay, Mask, Model, Prescription, PupilBound,
    REAR_SHARE, RealLens, read, sequence, trace_one,
};
use petzval::rays::{RayBatch, SampleBatch, WAVE};
use petzval::sampler::{Dimension, pairs, pixel_key};
use petzval::stats::LensStats;
use support::survival::survival;
use support::{LENSES, Random, lens, oracle};

/// Half the diagonal of the course's film, mm.
const HALF_DIAGONAL: f64 = 35.0;

fn camera(lens: Prescription, film: f64, aim: Aim) -> Camera {
    let lens = RealLens::new(lens, film, HALF_DIAGONAL, aim, 1.0, 0.0);
    Camera {
        model: Model::Real(Box::new(lens)),
        film: [49.497; 2],
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

/// Mean weight of the rays of one film point, and the share that leaves the lens.
fn sampled(camera: &Camera, r: f64, waves: u32) -> (f64, f64) {
    let mut samples = SampleBatch::default();
    let mut rays = RayBatch::default();
    let mut columns = LensColumns::default();
    let mut stats = LensStats { blocked: vec![0; 32], ..LensStats::default() };
    let (mut sum, mut alive) = (0.0, 0);
    for wave in 0..waves {
        samples.len = WAVE;
        for i in 0..WAVE {
            samples.key[i] = pixel_key(7, 7, 7);
            samples.sample[i] = wave * WAVE as u32 + i as u32;
            samples.film[0][i] = (r * 0.6) as f32;
            samples.film[1][i] = (r * -0.8) as f32;
        }
        let [u, v] = &mut samples.pupil;
        pairs(&samples.key[..], &samples.sample[..], Dimension::Pupil, &mut u[..], &mut v[..]);
        camera.expose::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        sum += (0..rays.len).map(|i| f64::from(rays.carried[0][i])).sum::<f64>();
        alive += rays.len;
    }
    let total = f64::from(waves) * WAVE as f64;
    (sum / total, alive as f64 / total)
}

/// The same by the oracle: cos^4 / Z^2 over a grid of the vertex plane.
fn brute(lens: &Prescription, film: f64, r: f64, reach: f64, grid: usize) -> f64 {
    let cell = 2.0 * reach / grid as f64;
    let mut sum = 0.0;
    for j in 0..grid {
        // The lens is symmetric about the plane of the film point: half the rows are enough.
        let v = (j as f64 + 0.5) * cell / 2.0;
        for i in 0..grid {
            let u = -reach + (i as f64 + 0.5) * cell;
            let d = [u - r, v, film];
            if oracle::trace(lens, film, [r, 0.0, 0.0], d).is_ok() {
                let d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                let cos2 = film * film / d2;
                sum += cos2 * cos2 / (film * film);
            }
        }
    }
    sum * cell * cell
}

#[test]
fn exposure_is_unbiased_from_the_centre_to_the_rim() {
    for (name, film) in LENSES {
        let lens = lens(name);
        let exact = camera(lens.clone(), film, Aim::Pupil);
        let mut centre = 0.0;
        for step in 0..=10 {
            let r = HALF_DIAGONAL * f64::from(step) / 10.0;
            // The rear element seen from the film never reaches farther than twice its width.
            let truth = brute(&lens, film, r, lens.rear().diameter, 700);
            let (ours, share) = sampled(&exact, r, 130);
            if step == 0 {
                centre = truth;
            }
            println!("{name} r {r:4.1}: {ours:.6} against {truth:.6}, {:.1}% alive", share * 100.0);
            let error = (ours - truth).abs() / centre;
            // Both sides integrate an area with a sharp edge: 1e-3 of the centre each at worst.
            assert!(error < 0.003, "{name} at {r} mm: {ours} against {truth}");
        }
    }
}

#[test]
fn a_small_stop_is_found_and_aimed_at() {
    for (name, film) in LENSES {
        let stopped = |divisor: f64| {
            let mut lens = lens(name);
            let stop = lens.stop();
            let opening = lens.rows[stop].diameter / divisor;
            lens.stop_down(opening);
            let (ours, share) = sampled(&camera(lens.clone(), film, Aim::Pupil), 2.0, 100);
            println!("{name} stop / {divisor}: {ours:e}, {:.1}% alive", share * 100.0);
            assert!(share > 0.85, "{name} / {divisor}: only {share} of the rays leave the lens");
            (lens, ours)
        };
        for divisor in [2.0, 8.0] {
            let (lens, ours) = stopped(divisor);
            let truth = brute(&lens, film, 2.0, lens.rear().diameter * 0.6, 3000);
            // The grid has some ten thousand cells in the smallest pupil: 1 % at its edge.
            assert!((ours / truth - 1.0).abs() < 0.01, "{name} / {divisor}: {ours} and {truth}");
        }
        // Smaller stops have no aberrations left: light follows their area.
        let (eighth, tiny) = (stopped(8.0).1, stopped(256.0).1);
        assert!((tiny * 1024.0 / eighth - 1.0).abs() < 0.02, "{name}: {tiny} and {eighth}");
    }
}

#[test]
fn the_rear_disk_is_the_courses_convention() {
    // Share of rays aimed at the disk that leave the lens, whole film: published with the
    // course's scenes.
    let shares = [0.284, 0.103, 0.288, 0.029];
    for ((name, film), published) in LENSES.into_iter().zip(shares) {
        let camera = camera(lens(name), film, Aim::RearDisk);
        let (mut alive, mut area) = (0.0, 0.0);
        // Rings of the square film, weighted by how much of each lies on it.
        let half = 49.497 / 2.0;
        for i in 0..60 {
            let r = HALF_DIAGONAL * (f64::from(i) + 0.5) / 60.0;
            let inside =
                if r <= half { 1.0 } else { 1.0 - 4.0 / std::f64::consts::PI * (half / r).acos() };
            let (_, share) = sampled(&camera, r, 4);
            alive += share * r * inside;
            area += r * inside;
        }
        let share = alive / area;
        println!("{name}: {share:.4} against {published}");
        assert!((share - published).abs() < 0.003, "{name}: {share} against {published}");
    }
}

#[test]
fn the_corner_of_a_large_film_is_known_to_be_dark() {
    let lens = lens("wide.22mm");
    let bound = petzval::lens::PupilBound::new(&lens, 14.54, HALF_DIAGONAL, Aim::Pupil);
    assert!(bound.any_open([-1.0; 2], [1.0; 2]));
    assert!(!bound.any_open([24.0; 2], [24.7; 2]), "no light comes to the corner of this film");
    assert!(bound.fan([10.0, 0.0]).area() < bound.rear([10.0, 0.0]).area());
}

#[test]
fn whatever_could_hit_the_rear_element_is_inside_its_bound() {
    let concave = support::row(-40.0, 2.0, 1.0, 20.0);
    for (name, film) in LENSES {
        for turned in [false, true] {
            let mut lens = lens(name);
            if turned {
                // A rear surface that is hollow towards the film: its rim stands behind it.
                let last = lens.rows.len() - 1;
                lens.rows[last] =
                    petzval::lens::Row { radius: 30.0, diameter: 12.0, ..concave.clone() };
            }
            let bound = petzval::lens::PupilBound::new(&lens, film, HALF_DIAGONAL, Aim::Pupil);
            let mut random = support::Random::new(4);
            for _ in 0..20_000 {
                let r = random.between(0.0, HALF_DIAGONAL);
                let h = lens.rear().diameter / 2.0 * random.next().sqrt();
                let (sin, cos) = random.between(0.0, 6.29).sin_cos();
                // A point of the rear surface, and where its ray crosses the vertex plane.
                let scale = film / (film - lens.rear().sag(h));
                let [u, v] = [r + (h * cos - r) * scale, h * sin * scale];
                let rear = bound.rear([r as f32, 0.0]);
                let x = (u - f64::from(rear.centre[0])) / f64::from(rear.half[0]);
                let y = v / f64::from(rear.half[1]);
                assert!(x * x + y * y <= 1.0, "{name}, r {r}, h {h}: {}", x * x + y * y);
            }
        }
    }
}

#[test]
fn nearly_every_aimed_ray_leaves_the_lens_at_any_stop() {
    for (name, film) in LENSES {
        for divisor in [1.0, 2.0, 4.0, 8.0] {
            let mut lens = lens(name);
            lens.stop_down(lens.rows[lens.stop()].diameter / divisor);
            let share = survival(&camera(lens, film, Aim::Pupil), 300);
            println!("{name} stop / {divisor}: {:.2}%", 100.0 * share);
            // 300,000 rays: a standard error of 0.03 %.
            assert!(share > 0.97, "{name}, stop / {divisor}: {share}");
        }
    }
}

/// A point of the film of a lens that is not round: what the sky gives it, by the sampler and by
/// the oracle.
fn off_axis(lens: &Prescription, film: f64, [x, y]: [f64; 2]) -> (f64, f64, f64) {
    let camera = camera(lens.clone(), film, Aim::Pupil);
    let mut samples = SampleBatch { len: WAVE, ..SampleBatch::default() };
    let mut rays = RayBatch::default();
    let mut columns = LensColumns::default();
    let mut stats = LensStats { blocked: vec![0; 32], ..LensStats::default() };
    let (mut sum, mut alive) = (0.0, 0);
    const WAVES: u32 = 150;
    for wave in 0..WAVES {
        for i in 0..WAVE {
            samples.key[i] = pixel_key(1, 2, 3);
            samples.sample[i] = wave * WAVE as u32 + i as u32;
            (samples.film[0][i], samples.film[1][i]) = (x as f32, y as f32);
        }
        let [u, v] = &mut samples.pupil;
        pairs(&samples.key[..], &samples.sample[..], Dimension::Pupil, &mut u[..], &mut v[..]);
        camera.expose::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        sum += (0..rays.len).map(|i| f64::from(rays.carried[0][i])).sum::<f64>();
        alive += rays.len;
    }
    let total = f64::from(WAVES) * WAVE as f64;
    let reach = lens.rear().diameter;
    let grid = 400;
    let cell = 2.0 * reach / f64::from(grid);
    let oracle = oracle::Oracle::new(lens);
    let mut truth = 0.0;
    for i in 0..grid * grid {
        let place = |k: i32| -reach + (f64::from(k) + 0.5) * cell;
        let d = [place(i % grid) - x, place(i / grid) - y, film];
        if let Ok(exit) = oracle.follow(film, [x, y, 0.0], d).end {
            let d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            truth += exit.weight * (film * film / d2).powi(2) / (film * film);
        }
    }
    (sum / total, truth * cell * cell, alive as f64 / total)
}

#[test]
fn shaped_stops_and_cylinders_are_exposed_without_bias() {
    let blades = |count, rotation, curvature| Iris::Blades { count, rotation, curvature };
    let mut cases = Vec::new();
    for iris in
        [blades(5, 20.0, 0.0), blades(7, 0.0, 0.6), Iris::Mask(Mask::named("star").unwrap())]
    {
        let mut lens = lens("dgauss.50mm");
        let stop = lens.stop();
        lens.rows[stop].iris = iris;
        cases.push((lens, 36.77));
    }
    let anamorphic = read(&support::root().join("lenses/anamorphic.toml")).expect("a lens");
    cases.push((anamorphic, 42.4));
    for (lens, film) in cases {
        let mut centre = 0.0;
        for point in [[0.0, 0.0], [7.0, -3.0], [-12.0, -9.0], [2.0, 15.0]] {
            let (ours, truth, share) = off_axis(&lens, film, point);
            if point == [0.0; 2] {
                centre = truth;
            }
            let iris = &lens.rows[lens.stop()].iris;
            let shape =
                if let Iris::Mask(mask) = iris { mask.name.clone() } else { format!("{iris:?}") };
            println!(
                "{} {shape} {point:?}: {ours:.6} {truth:.6}, {:.1}%",
                lens.name,
                share * 100.0
            );
            // The grid of the truth has some ten thousand cells in the pupil: half a percent.
            assert!(
                (ours - truth).abs() < 0.006 * centre,
                "{} {point:?}: {ours} {truth}",
                lens.name
            );
            assert!(share > 0.4, "{} {shape} {point:?}: {share}", lens.name);
        }
    }
}

#[test]
fn hardly_any_light_lies_outside_the_fans() {
    for (name, film) in LENSES {
        for divisor in [1.0, 4.0] {
            let mut lens = lens(name);
            lens.stop_down(lens.rows[lens.stop()].diameter / divisor);
            let bound = PupilBound::new(&lens, film, HALF_DIAGONAL, Aim::Pupil);
            let surfaces = sequence::<f64>(&lens, From::Film(film));
            let mut random = Random::new(3);
            let (mut lit, mut outside) = (0u32, 0u32);
            for _ in 0..400_000 {
                let r = random.between(0.0, HALF_DIAGONAL);
                // Around the fan, half as wide again; little of the light can be farther out.
                let fan = bound.fan([r as f32, 0.0]).scaled(1.5);
                if !fan.open() {
                    continue;
                }
                let k = (random.next() * 32.0) as usize;
                let (t, s) = (random.next(), random.next().sqrt());
                let corner = |axis: usize| {
                    let [a, b] = [fan.corners[k][axis], fan.corners[k + 1][axis]].map(f64::from);
                    f64::from(fan.centre[axis]) + s * (a + t * (b - a))
                };
                let [u, v] = [corner(0), corner(1)];
                let d = [u - r, v, film];
                let length = d.iter().map(|v| v * v).sum::<f64>().sqrt();
                let ray = LensRay::new([r, 0.0, 0.0], d.map(|v| v / length));
                if trace_one::<f64>(ray, &surfaces).is_ok() {
                    lit += 1;
                    let inside = bound.fan([r as f32, 0.0]).density([u as f32, v as f32]) > 0.0;
                    outside += u32::from(!inside);
                }
            }
            println!("{name} stop / {divisor}: {outside} of {lit} outside");
            // What is outside is left to the share of the rear element, and makes a noise of its own.
            assert!(f64::from(outside) < 1e-4 * f64::from(lit), "{name}: {outside} of {lit}");
        }
    }
}

/// Weights of the rays that leave the lens from points all over the film: those of `waves` of
/// samples, or only those of the samples that go to the whole rear element.
fn weights(camera: &Camera, waves: u32, rear_only: bool) -> Vec<f64> {
    let mut samples = SampleBatch { len: WAVE, ..SampleBatch::default() };
    let mut rays = RayBatch::default();
    let mut columns = LensColumns::default();
    let mut stats = LensStats { blocked: vec![0; 32], ..LensStats::default() };
    let mut random = Random::new(5);
    // The first number of a pupil point chooses: the least go to the rear element.
    let share = if rear_only { f64::from(REAR_SHARE) } else { 1.0 };
    let mut weights = Vec::new();
    for _ in 0..waves {
        for i in 0..WAVE {
            for axis in 0..2 {
                samples.film[axis][i] = (camera.film[axis] * (random.next() - 0.5)) as f32;
            }
            samples.pupil[0][i] = (share * random.next()) as f32;
            samples.pupil[1][i] = random.next() as f32;
        }
        camera.expose::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        weights.extend(rays.carried[0][..rays.len].iter().map(|&weight| f64::from(weight)));
    }
    weights
}

#[test]
fn no_weight_stands_out() {
    // Samples that aim at the fan weigh what its area says. The samples of the whole rear element
    // weigh hundreds of times as much where the fan misses light: a firefly. These are as many of
    // them as 2.6e8 samples hold.
    const REAR_WAVES: u32 = 1000;
    let cases: Vec<_> = LENSES
        .into_iter()
        .flat_map(|lens| [1.0, 2.0, 4.0, 8.0, 16.0].map(|divisor| (lens, divisor)))
        .collect();
    let worst = support::in_parallel(&cases, |&((name, film), divisor)| {
        let mut lens = lens(name);
        lens.stop_down(lens.rows[lens.stop()].diameter / divisor);
        let camera = camera(lens, film, Aim::Pupil);
        let all = weights(&camera, 100, false);
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let rear = weights(&camera, REAR_WAVES, true);
        all.iter().chain(&rear).fold(0.0, |most: f64, &weight| most.max(weight)) / mean
    });
    for (((name, _), divisor), worst) in cases.iter().zip(&worst) {
        println!("{name} stop / {divisor}: at most {worst:.2} times the mean");
    }
    for (((name, _), divisor), worst) in cases.into_iter().zip(worst) {
        assert!(worst < 4.0, "{name} stop / {divisor}: a weight {worst} times the mean");
    }
}
