//! Sampling density of the pupil sampler against histograms of the samples that it draws.

use crate::support::{Random, in_parallel, root};
use glam::DAffine3;
use petzval_base::rays::SampleBatch;
use petzval_lens::{
    Camera, FilmPlane, Iris, LensModel, Paraxial, Pose, Prescription, PupilBounds, PupilSampling,
    REAR_SHARE, RIM_SHARE, RealLens, SHELL_ENDS, VICINITY_SHARE,
};
use petzval_lens_formats::read;

/// Share of the samples that are not drawn from the fan.
const OUTSIDE_SHARE: f32 = REAR_SHARE + VICINITY_SHARE + RIM_SHARE;

/// Returns a lens of the repository, and the film distance at which it is focused at infinity.
fn focused(name: &str) -> (Prescription, f64) {
    let lens = read(&root().join("lenses").join(name)).expect("a lens of the repository");
    let film = Paraxial::new(&lens).film_for_focus(f64::INFINITY).expect("a lens that focuses");
    (lens, film)
}

fn through(lens: RealLens, half: f64) -> Camera {
    Camera {
        model: LensModel::Real(Box::new(lens)),
        film: [half * 2.0f64.sqrt(); 2],
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

fn camera(lens: Prescription, film: f64, half: f64) -> Camera {
    through(RealLens::new(lens, film, half, PupilSampling::Pupil, 1.0, 0.0), half)
}

/// Lenses whose sampling density is compared with histograms: with film distance, half diagonal and
/// a film point.
fn histogram_cases() -> Vec<(String, Prescription, f64, f64, [f64; 2])> {
    let case = |name: &str, half: f64, at: [f64; 2], change: &dyn Fn(&mut Prescription)| {
        let (mut lens, film) = focused(name);
        change(&mut lens);
        (format!("{name} {at:?}"), lens, film, half, at)
    };
    let obstructed = |lens: &mut Prescription| {
        let stop = lens.stop();
        lens.rows[stop].obstruction = lens.rows[stop].diameter * 0.4;
    };
    let bladed = |lens: &mut Prescription| {
        let stop = lens.stop();
        lens.rows[stop].iris = Iris::Blades { count: 5, rotation: 20.0, curvature: 0.0 };
    };
    vec![
        case("dgauss.50mm.dat", 35.0, [0.0, 0.0], &|_| ()),
        case("dgauss.50mm.dat", 35.0, [-12.0, 17.0], &|_| ()),
        case("dgauss.50mm.dat", 35.0, [3.0, -2.0], &obstructed),
        case("dgauss.50mm.dat", 35.0, [9.0, -14.0], &bladed),
        case("fisheye.10mm.dat", 35.0, [7.0, 9.0], &|_| ()),
        case("anamorphic.toml", 22.0, [10.0, -8.0], &|_| ()),
    ]
}

/// Returns a limit of chi-squared with a false alarm in one case of a million: Wilson & Hilferty
/// 1931, 4.753 standard deviations.
fn chi_squared_limit(cells: f64) -> f64 {
    cells * (1.0 - 2.0 / (9.0 * cells) + 4.753 * (2.0 / (9.0 * cells)).sqrt()).powi(3)
}

#[test]
fn the_sampling_density_is_that_of_drawn_samples() {
    /// Cells along each side of a histogram.
    const SIDE: usize = 12;
    /// Points along each side of a cell at which the density is summed.
    const FINE: usize = 60;
    const SAMPLES: u32 = 150_000;
    in_parallel(&histogram_cases(), |(name, lens, film, half, at)| {
        let camera = camera(lens.clone(), *film, *half);
        let LensModel::Real(real) = &camera.model else { unreachable!() };
        let rear = real.pupil_bounds().rear(at.map(|v| v as f32));
        let reach: f64 = f64::from(rear.half[0].max(rear.half[1]))
            + f64::from(rear.centre[0].hypot(rear.centre[1]));
        // Fans may be somewhat larger than the rear element.
        let reach = 1.1 * reach;
        let cell = 2.0 * reach / SIDE as f64;
        let mut random = Random::new(17);
        let mut counts = vec![0u32; SIDE * SIDE];
        let mut samples = SampleBatch { len: 1, ..SampleBatch::default() };
        for i in 0..SAMPLES {
            for axis in 0..2 {
                samples.film[axis][0] = at[axis] as f32;
                samples.pupil[axis][0] = random.next() as f32;
            }
            let path = camera.ray_path(&samples).expect("a lit film point");
            let [dx, dy, dz] = [path.direction[0], path.direction[1], -path.direction[2]];
            let point = [at[0] + dx / dz * film, at[1] + dy / dz * film];
            let [x, y] = point.map(|v| ((v + reach) / cell).floor());
            assert!(x.min(y) >= 0.0 && x.max(y) < SIDE as f64, "{name}: {point:?}");
            counts[y as usize * SIDE + x as usize] += 1;
            // The weight of light is the cosine at the film over the density.
            if i < 2000 && path.end.is_ok() {
                let density = real.sampling_density(*at, [dx, dy, dz]);
                let expected = dz / path.weight;
                // A sample at an edge may fall outside by rounding.
                let off = (density / expected - 1.0).abs();
                let close = (0..8).any(|k| {
                    let (sin, cos) = (f64::from(k) * 0.785).sin_cos();
                    let moved = [dx + 1e-5 * cos, dy + 1e-5 * sin, dz];
                    (real.sampling_density(*at, moved) / expected - 1.0).abs() < 1e-3
                });
                assert!(off < 1e-3 || close, "{name}: {density} {expected} at {point:?}");
            }
        }
        let (mut total, mut chi2, mut cells) = (0.0f64, 0.0f64, 0.0f64);
        // Cells of few samples count as one.
        let mut rest = (0.0f64, 0.0f64);
        for (k, &count) in counts.iter().enumerate() {
            let low = [k % SIDE, k / SIDE].map(|i| i as f64 * cell - reach);
            let mut mass = 0.0;
            for j in 0..FINE * FINE {
                let place = [j % FINE, j / FINE].map(|i| (i as f64 + random.next()) / FINE as f64);
                let d = [0, 1].map(|i| low[i] + cell * place[i] - at[i]);
                let d2 = d[0] * d[0] + d[1] * d[1] + film * film;
                let solid_angle = (cell / FINE as f64).powi(2) * film / (d2 * d2.sqrt());
                mass += real.sampling_density(*at, [d[0], d[1], *film]) * solid_angle;
            }
            total += mass;
            let expected = mass * f64::from(SAMPLES);
            let difference = f64::from(count) - expected;
            if expected < 20.0 {
                rest.0 += expected;
                rest.1 += f64::from(count);
            } else {
                chi2 += difference * difference / expected;
                cells += 1.0;
            }
        }
        chi2 += (rest.1 - rest.0) * (rest.1 - rest.0) / rest.0.max(1.0);
        cells += 1.0;
        println!("{name}: integral {total:.5}, chi-squared {chi2:.1} of {cells}");
        assert!((total - 1.0).abs() < 0.004, "{name}: the density sums to {total}");
        let limit = chi_squared_limit(cells);
        assert!(chi2 < limit, "{name}: chi-squared {chi2} of {cells} cells, limit {limit}");
    });
}

/// Returns the density of the samples that are not drawn from the fan, over the plane of the rear
/// vertex, mm^-2.
fn density_outside(bounds: &PupilBounds, at: [f64; 2], point: [f64; 2]) -> f64 {
    let [at, point] = [at, point].map(|at| at.map(|v| v as f32));
    let fan = f64::from(1.0 - OUTSIDE_SHARE) * f64::from(bounds.fan(at).density(point));
    f64::from(bounds.density(at, point)) - fan
}

#[test]
fn the_density_of_the_rim_is_that_of_drawn_samples() {
    /// Scales of the fan that bound the shells of a histogram.
    const SCALES: [f64; 7] = [1.0005, 1.004, 1.0077, 1.02, 1.0307, 1.06, 1.117];
    const SAMPLES: u32 = 60_000;
    let cases: Vec<_> = histogram_cases().into_iter().filter(|case| case.4[1] != 0.0).collect();
    in_parallel(&cases, |(name, lens, film, half, at)| {
        // Film points on the x axis see the pupil in the frame of the lens.
        let at = [at[0].hypot(at[1]), 0.0];
        let camera = camera(lens.clone(), *film, *half);
        let LensModel::Real(real) = &camera.model else { unreachable!() };
        let bounds = real.pupil_bounds();
        let fan = bounds.fan(at.map(|v| v as f32));
        let mut random = Random::new(29);
        let mut samples = SampleBatch { len: 1, ..SampleBatch::default() };
        let mut counts = [0u32; SCALES.len() - 1];
        for _ in 0..SAMPLES {
            for axis in 0..2 {
                samples.film[axis][0] = at[axis] as f32;
                samples.pupil[axis][0] = random.next() as f32;
            }
            samples.pupil[0][0] *= OUTSIDE_SHARE;
            let path = camera.ray_path(&samples).expect("a lit film point");
            let [dx, dy, dz] = [path.direction[0], path.direction[1], -path.direction[2]];
            let scale = fan.scale_to_enclose([at[0] + dx / dz * film, at[1] + dy / dz * film]);
            let shell = SCALES.iter().filter(|&&end| end <= scale).count();
            if (1..SCALES.len()).contains(&shell) {
                counts[shell - 1] += 1;
            }
        }
        let mut chi2 = 0.0;
        for (shell, &count) in counts.iter().enumerate() {
            const POINTS: usize = 20_000;
            let [inner, outer] = [shell, shell + 1].map(|i| SCALES[i] * SCALES[i]);
            let mut mass = 0.0;
            for i in 0..POINTS {
                let [a, b] = [i % 32, i % 32 + 1].map(|k| fan.corners[k].map(f64::from));
                let (along, scale) = (random.next(), random.between(inner, outer).sqrt());
                let corner = [0, 1].map(|axis| a[axis] + along * (b[axis] - a[axis]));
                let point = [0, 1].map(|i| f64::from(fan.centre[i]) + scale * corner[i]);
                // A sum over 32 triangles of the area of the shell.
                let area = (a[0] * b[1] - a[1] * b[0]) / 2.0 * (outer - inner) * 32.0;
                mass += density_outside(bounds, at, point) * area.max(0.0) / POINTS as f64;
            }
            let expected = mass / f64::from(OUTSIDE_SHARE) * f64::from(SAMPLES);
            chi2 += (f64::from(count) - expected).powi(2) / expected;
            let range = &SCALES[shell..shell + 2];
            println!("{name}: {count} samples at scales {range:?}, expected {expected:.1}");
        }
        let limit = chi_squared_limit(counts.len() as f64);
        assert!(
            chi2 < limit,
            "{name}: chi-squared {chi2} of {} shells, limit {limit}",
            counts.len()
        );
    });
}

#[test]
fn a_sample_outside_the_fan_weighs_at_most_the_stated_limit() {
    for (name, lens, film, half, at) in histogram_cases() {
        let camera = camera(lens, film, half);
        let LensModel::Real(real) = &camera.model else { unreachable!() };
        let bounds = real.pupil_bounds();
        let at = at.map(|v| v as f32);
        let fan = bounds.fan(at);
        let mut random = Random::new(31);
        for _ in 0..4000 {
            let k = (random.next() * 32.0) as usize;
            let [a, b] = [k, k + 1].map(|k| fan.corners[k].map(f64::from));
            let excess = 0.249 * (-8.0 * random.next()).exp();
            let (along, scale) = (random.next(), (1.0 + excess).sqrt());
            let point = [0, 1].map(|i| {
                (f64::from(fan.centre[i]) + scale * (a[i] + along * (b[i] - a[i]))) as f32
            });
            let inside = 2.0 / (32.0 * (a[0] * b[1] - a[1] * b[0]));
            let ratio = inside / f64::from(bounds.density(at, point));
            let end = SHELL_ENDS.iter().position(|&end| excess <= f64::from(end)).expect("a shell");
            let limit = [48.0, 144.0, 576.0][end];
            // Rounding to single precision moves a point by some 1e-6 of the fan.
            let next = SHELL_ENDS.iter().any(|&end| (excess / f64::from(end) - 1.0).abs() < 1e-4);
            assert!(
                ratio < 1.001 * limit || next,
                "{name}: {ratio} times at {excess}, limit {limit}"
            );
        }
    }
}

#[test]
fn nothing_is_drawn_backwards_or_beside_the_rear_element() {
    let (lens, film) = focused("dgauss.50mm.dat");
    let camera = camera(lens, film, 35.0);
    let LensModel::Real(real) = &camera.model else { unreachable!() };
    assert!(real.sampling_density([1.0, 2.0], [0.0, 0.0, 1.0]) > 0.0);
    assert_eq!(real.sampling_density([1.0, 2.0], [0.0, 0.0, -1.0]), 0.0);
    assert_eq!(real.sampling_density([1.0, 2.0], [5.0, 0.0, 1.0]), 0.0);
}

#[test]
fn the_sampling_density_follows_a_tilted_and_a_decentred_film() {
    let poses = [
        Pose { decentre: [3.0, -2.0], tilt: [0.0, 0.0] },
        Pose { decentre: [0.0, 0.0], tilt: [6.0, -4.0] },
        Pose { decentre: [2.0, 1.0], tilt: [-5.0, 3.0] },
    ];
    for pose in poses {
        let (lens, distance) = focused("dgauss.50mm.dat");
        let film = FilmPlane { pose, ..FilmPlane::aligned(distance, 20.0) };
        let lens = RealLens::with_film(lens, &film, PupilSampling::Pupil, 1.0, 0.0);
        let camera = through(lens, 20.0);
        let LensModel::Real(real) = &camera.model else { unreachable!() };
        let normal = pose.film_normal();
        let mut random = Random::new(23);
        let mut samples = SampleBatch { len: 1, ..SampleBatch::default() };
        let (mut seen, mut off) = (0, 0);
        for _ in 0..4000 {
            let at = [0, 1].map(|_| f64::from(random.between(-10.0, 10.0) as f32));
            for axis in 0..2 {
                samples.film[axis][0] = at[axis] as f32;
                samples.pupil[axis][0] = random.next() as f32;
            }
            let Some(path) = camera.ray_path(&samples).filter(|path| path.end.is_ok()) else {
                continue;
            };
            let d = [path.direction[0], path.direction[1], -path.direction[2]];
            let cos: f64 = (0..3).map(|i| normal[i] * d[i]).sum();
            let ratio = real.sampling_density(at, d) * path.weight / cos;
            seen += 1;
            off += u32::from((ratio - 1.0).abs() > 1e-3);
        }
        println!("{pose}: {off} of {seen} differ");
        // Samples on a side of a triangle may fall into the next by rounding.
        assert!(seen > 3000 && off < 10, "{pose}: {off} of {seen} samples differ");
    }
}

#[test]
fn the_vicinity_encloses_the_fans_with_a_margin() {
    let poses = [[0.0; 4], [0.0; 4], [0.0, 0.0, 4.0, -3.0], [0.2, -0.1, 0.0, 0.0]];
    let lenses = ["dgauss.50mm.dat", "fisheye.10mm.dat", "phone.toml", "anamorphic.toml"];
    for (name, radius) in lenses.into_iter().zip([20.0, 12.0, 3.0, 15.0]) {
        for (divisor, [x, y, tilt_x, tilt_y]) in [1.0, 16.0, 4.0, 2.0].into_iter().zip(poses) {
            let folder = root().join("lenses");
            let mut lens = read(&folder.join(name)).expect("a shipped lens");
            lens.stop_down(lens.rows[lens.stop()].diameter / divisor);
            let film = Paraxial::new(&lens).film_for_focus(f64::INFINITY).expect("a focus");
            let pose = Pose { decentre: [x, y], tilt: [tilt_x, tilt_y] };
            let film = FilmPlane { pose, ..FilmPlane::aligned(film, radius) };
            let bounds = PupilBounds::for_film(&lens, &film, PupilSampling::Pupil);
            let mut open = 0;
            for i in 0..400 {
                let place = [i % 20, i / 20].map(|k| (f64::from(k) + 0.3) / 10.0 - 1.0);
                let at = [0, 1].map(|axis| (place[axis] * film.half[axis]) as f32);
                let fan = bounds.fan(at);
                if !fan.is_open() {
                    continue;
                }
                open += 1;
                let vicinity = bounds.vicinity(at, &fan);
                for corner in fan.corners {
                    let point = [0, 1].map(|axis| fan.centre[axis] + 1.098 * corner[axis]);
                    assert!(vicinity.density(point) > 0.0, "{name}, {divisor}, {pose}: {at:?}");
                }
            }
            assert!(open > 100, "{name}: {open} of 400 film points are lit");
        }
    }
}
