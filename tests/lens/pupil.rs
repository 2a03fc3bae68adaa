//! Pupil sampler against brute force: irradiance of the film under a uniform sky of radiance 1.

use crate::support::reference::{reference, within};
use crate::support::sampling::{irradiance_and_share, transmitted_share};
use crate::support::{LENSES, Random, lens, oracle};
use glam::DAffine3;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::sampler::pixel_key;
use petzval_base::stats::LensStats;
use petzval_lens::{
    ApertureMask, Camera, Iris, LensColumns, LensModel, LensRay, Prescription, PupilBounds,
    PupilSampling, REAR_SHARE, RealLens, Side, sequence, trace_one,
};
use petzval_lens_formats::read;

/// Half the diagonal of the film of the course's scenes, mm.
const HALF_DIAGONAL: f64 = 35.0;

fn camera(lens: Prescription, film: f64, aim: PupilSampling) -> Camera {
    let lens = RealLens::new(lens, film, HALF_DIAGONAL, aim, 1.0, 0.0);
    Camera {
        model: LensModel::Real(Box::new(lens)),
        film: [49.497; 2],
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

/// Returns the irradiance of a film point `r` mm from the axis, and the share of rays that leave the lens.
fn sampled(camera: &Camera, r: f64, waves: u32) -> (f64, f64) {
    irradiance_and_share(camera, [r * 0.6, r * -0.8], waves, pixel_key(7, 7, 7))
}

/// Returns the irradiance by the oracle, which `tests/references/pupil.csv` keeps.
fn irradiance_by_grid(lens: &Prescription, film: f64, r: f64, reach: f64, grid: usize) -> f64 {
    let rows: Vec<_> =
        lens.rows.iter().map(|row| (row.radius, row.thickness, row.index, row.diameter)).collect();
    let label = format!("{} at {r:4.1} mm, stop {:.3} mm", lens.name, rows[lens.stop()].3);
    let numbers = reference("pupil", &label, (rows, film, r, reach, grid), within(1e-4), || {
        vec![naive_irradiance(lens, film, r, reach, grid)]
    });
    numbers[0]
}

/// Returns the irradiance by the oracle: cos^4 / Z^2 over a grid of the plane of the rear vertex.
fn naive_irradiance(lens: &Prescription, film: f64, r: f64, reach: f64, grid: usize) -> f64 {
    let cell = 2.0 * reach / grid as f64;
    let mut sum = 0.0;
    for j in 0..grid {
        // The lens is symmetric about the plane of the film point: half of the grid suffices.
        let v = (j as f64 + 0.5) * cell / 2.0;
        for i in 0..grid {
            let u = -reach + (i as f64 + 0.5) * cell;
            let d = [u - r, v, film];
            if oracle::trace_spheres(lens, film, [r, 0.0, 0.0], d).is_ok() {
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
        let exact = camera(lens.clone(), film, PupilSampling::Pupil);
        let mut centre = 0.0;
        for step in 0..=10 {
            let r = HALF_DIAGONAL * f64::from(step) / 10.0;
            // The projection of the rear element onto its vertex plane is less than twice as wide.
            let truth = irradiance_by_grid(&lens, film, r, lens.rear().diameter, 700);
            let (ours, share) = sampled(&exact, r, 130);
            if step == 0 {
                centre = truth;
            }
            println!("{name} r {r:4.1}: {ours:.6} against {truth:.6}, {:.1}% alive", share * 100.0);
            let error = (ours - truth).abs() / centre;
            // Both integrate over an area with a sharp edge: an error of 1e-3 of the centre each at worst.
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
            let (ours, share) =
                sampled(&camera(lens.clone(), film, PupilSampling::Pupil), 2.0, 100);
            println!("{name} stop / {divisor}: {ours:e}, {:.1}% alive", share * 100.0);
            assert!(share > 0.85, "{name} / {divisor}: only {share} of the rays leave the lens");
            (lens, ours)
        };
        for divisor in [2.0, 8.0] {
            let (lens, ours) = stopped(divisor);
            let truth = irradiance_by_grid(&lens, film, 2.0, lens.rear().diameter * 0.6, 3000);
            // The grid has some ten thousand cells in the smallest pupil: an error of 1 %.
            assert!((ours / truth - 1.0).abs() < 0.01, "{name} / {divisor}: {ours} and {truth}");
        }
        // At smaller stops aberrations vanish and the light is proportional to the area.
        let (eighth, tiny) = (stopped(8.0).1, stopped(256.0).1);
        assert!((tiny * 1024.0 / eighth - 1.0).abs() < 0.02, "{name}: {tiny} and {eighth}");
    }
}

#[test]
fn aiming_at_the_rear_disk_loses_the_shares_that_the_course_published() {
    // Shares of rays aimed at the disk that leave the lens, published with the course's scenes.
    let shares = [0.284, 0.103, 0.288, 0.029];
    for ((name, film), published) in LENSES.into_iter().zip(shares) {
        let camera = camera(lens(name), film, PupilSampling::RearDisk);
        let (mut alive, mut area) = (0.0, 0.0);
        // Rings of the square film, weighted by their area on it.
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
fn the_corner_of_a_large_film_has_no_open_pupil() {
    let lens = lens("wide.22mm");
    let bound = petzval_lens::PupilBounds::new(&lens, 14.54, HALF_DIAGONAL, PupilSampling::Pupil);
    assert!(bound.any_light([-1.0; 2], [1.0; 2]));
    assert!(!bound.any_light([24.0; 2], [24.7; 2]), "light reaches the corner of this film");
    assert!(bound.fan([10.0, 0.0]).area() < bound.rear([10.0, 0.0]).area());
}

#[test]
fn the_bound_holds_every_ray_to_the_rear_element() {
    let concave = crate::support::row(-40.0, 2.0, 1.0, 20.0);
    for (name, film) in LENSES {
        for turned in [false, true] {
            let mut lens = lens(name);
            if turned {
                // A rear surface that is concave to the film, so that its rim lies behind the vertex.
                let last = lens.rows.len() - 1;
                lens.rows[last] =
                    petzval_lens::Row { radius: 30.0, diameter: 12.0, ..concave.clone() };
            }
            let bound =
                petzval_lens::PupilBounds::new(&lens, film, HALF_DIAGONAL, PupilSampling::Pupil);
            let mut random = crate::support::Random::new(4);
            for _ in 0..20_000 {
                let r = random.between(0.0, HALF_DIAGONAL);
                let h = lens.rear().diameter / 2.0 * random.next().sqrt();
                let (sin, cos) = random.between(0.0, 6.29).sin_cos();
                // The ray to a point of the rear surface crosses the vertex plane here.
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
fn more_than_97_percent_of_aimed_rays_leave_the_lens_at_any_stop() {
    for (name, film) in LENSES {
        for divisor in [1.0, 2.0, 4.0, 8.0] {
            let mut lens = lens(name);
            lens.stop_down(lens.rows[lens.stop()].diameter / divisor);
            let share = transmitted_share(&camera(lens, film, PupilSampling::Pupil), 300);
            println!("{name} stop / {divisor}: {:.2}%", 100.0 * share);
            // The standard error of 300,000 rays is 0.03 %.
            assert!(share > 0.97, "{name}, stop / {divisor}: {share}");
        }
    }
}

/// Returns the irradiance of a film point behind a lens that is not round, by the sampler and by the
/// oracle, and the share of rays that leave the lens.
fn irradiance_at(lens: &Prescription, film: f64, [x, y]: [f64; 2]) -> (f64, f64, f64) {
    let camera = camera(lens.clone(), film, PupilSampling::Pupil);
    let (sampled, share) = irradiance_and_share(&camera, [x, y], 150, pixel_key(1, 2, 3));
    let reach = lens.rear().diameter;
    let grid = 400;
    let label = format!("{} {}, at {x} {y} mm", lens.name, shape(lens));
    let rows: Vec<_> = lens
        .rows
        .iter()
        .map(|row| (row.radius, row.thickness, row.index, row.diameter, row.conic))
        .collect();
    let subject = (rows, shape(lens), film, [x, y], reach, grid);
    let truth = reference("pupil", &label, subject, within(1e-4), || {
        vec![irradiance_by_oracle(lens, film, [x, y], reach, grid)]
    });
    (sampled, truth[0], share)
}

/// Returns the shape of the stop of a lens.
fn shape(lens: &Prescription) -> String {
    match &lens.rows[lens.stop()].iris {
        Iris::Mask(mask) => mask.name.clone(),
        iris => format!("{iris:?}"),
    }
}

/// Returns the irradiance of a film point by rays of the oracle through a grid behind the lens.
fn irradiance_by_oracle(
    lens: &Prescription,
    film: f64,
    [x, y]: [f64; 2],
    reach: f64,
    grid: i32,
) -> f64 {
    let cell = 2.0 * reach / f64::from(grid);
    let oracle = oracle::Oracle::new(lens);
    let mut truth = 0.0;
    for i in 0..grid * grid {
        let place = |k: i32| -reach + (f64::from(k) + 0.5) * cell;
        let d = [place(i % grid) - x, place(i / grid) - y, film];
        if let Ok(exit) = oracle.trace(film, [x, y, 0.0], d).end {
            let d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            truth += exit.weight * (film * film / d2).powi(2) / (film * film);
        }
    }
    truth * cell * cell
}

#[test]
fn shaped_stops_and_cylinders_are_exposed_without_bias() {
    let blades = |count, rotation, curvature| Iris::Blades { count, rotation, curvature };
    let mut cases = Vec::new();
    for iris in [
        blades(5, 20.0, 0.0),
        blades(7, 0.0, 0.6),
        Iris::Mask(ApertureMask::named("star").unwrap()),
    ] {
        let mut lens = lens("dgauss.50mm");
        let stop = lens.stop();
        lens.rows[stop].iris = iris;
        cases.push((lens, 36.77));
    }
    let anamorphic = read(&crate::support::root().join("lenses/anamorphic.toml")).expect("a lens");
    cases.push((anamorphic, 42.4));
    for (lens, film) in cases {
        let mut centre = 0.0;
        for point in [[0.0, 0.0], [7.0, -3.0], [-12.0, -9.0], [2.0, 15.0]] {
            let (ours, truth, share) = irradiance_at(&lens, film, point);
            if point == [0.0; 2] {
                centre = truth;
            }
            let shape = shape(&lens);
            println!(
                "{} {shape} {point:?}: {ours:.6} {truth:.6}, {:.1}%",
                lens.name,
                share * 100.0
            );
            // The grid has some ten thousand cells in the pupil: an error of half a percent.
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
fn less_than_1e_4_of_the_light_lies_outside_the_fans() {
    for (name, film) in LENSES {
        for divisor in [1.0, 4.0] {
            let mut lens = lens(name);
            lens.stop_down(lens.rows[lens.stop()].diameter / divisor);
            let bound = PupilBounds::new(&lens, film, HALF_DIAGONAL, PupilSampling::Pupil);
            let surfaces = sequence::<f64>(&lens, Side::Film(film));
            let mut random = Random::new(3);
            let (mut lit, mut outside) = (0u32, 0u32);
            for _ in 0..400_000 {
                let r = random.between(0.0, HALF_DIAGONAL);
                // Rays are sampled around the fan, half as wide again: little of the light is farther out.
                let fan = bound.fan([r as f32, 0.0]).scaled(1.5);
                if !fan.is_open() {
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
            // Light outside the fan is sampled by the rays to the whole rear element, with more noise.
            assert!(f64::from(outside) < 1e-4 * f64::from(lit), "{name}: {outside} of {lit}");
        }
    }
}

/// Returns the weights of the rays that leave the lens from random points of the film. With `rear_only`
/// all samples go to the whole rear element.
fn weights(camera: &Camera, waves: u32, rear_only: bool) -> Vec<f64> {
    let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
    let mut rays = RayBatch::default();
    let mut columns = LensColumns::default();
    let mut stats = LensStats::default();
    let mut random = Random::new(5);
    // The first coordinate of a pupil sample decides: the smallest go to the rear element.
    let share = if rear_only { f64::from(REAR_SHARE) } else { 1.0 };
    let mut weights = Vec::new();
    for _ in 0..waves {
        for i in 0..WAVE_SIZE {
            for axis in 0..2 {
                samples.film[axis][i] = (camera.film[axis] * (random.next() - 0.5)) as f32;
            }
            samples.pupil[0][i] = (share * random.next()) as f32;
            samples.pupil[1][i] = random.next() as f32;
        }
        camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        weights.extend(rays.throughput[0][..rays.len].iter().map(|&weight| f64::from(weight)));
    }
    weights
}

#[test]
fn no_ray_weighs_more_than_four_times_the_mean() {
    // The weight of samples aimed at the fan is its area. Samples of the whole rear element weigh
    // hundreds of times as much where the fan misses light, which makes fireflies. This many of them
    // occur in 2e9 samples.
    const REAR_WAVES: u32 = 1000;
    let cases: Vec<_> = LENSES
        .into_iter()
        .flat_map(|lens| [1.0, 2.0, 4.0, 8.0, 16.0].map(|divisor| (lens, divisor)))
        .collect();
    let worst = crate::support::in_parallel(&cases, |&((name, film), divisor)| {
        let mut lens = lens(name);
        lens.stop_down(lens.rows[lens.stop()].diameter / divisor);
        let camera = camera(lens, film, PupilSampling::Pupil);
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
