//! Focus distances without a film position, and film points without light.

use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;
use petzval_lens::{Camera, FocusError, LensColumns, LensModel, Paraxial, PupilSampling, RealLens};

use super::corpus::corpus;
use crate::support::probe::lens_of_rows;
use crate::support::{LENSES, Random, lens, row};

#[test]
fn focus_reaches_from_infinity_to_the_nearest_distance_that_the_error_names() {
    for (name, _) in LENSES {
        let paraxial = Paraxial::new(&lens(name));
        let film = paraxial.film_for_focus(f64::INFINITY).expect("infinity is always in focus");
        assert_eq!(film, paraxial.back_focal_distance, "{name}");
        let Err(FocusError::TooNear { asked, nearest }) = paraxial.film_for_focus(1.0) else {
            panic!("{name}: focus at a millimetre has no error");
        };
        assert_eq!(asked, 1.0);
        assert!(nearest > 0.0 && nearest.is_finite(), "{name}: {nearest}");
        // The lens focuses at the distance that the error names, and not nearer.
        let film = paraxial.film_for_focus(nearest * (1.0 + 1e-9)).expect("the nearest");
        assert!(film > paraxial.back_focal_distance, "{name}");
        assert!(paraxial.film_for_focus(nearest * (1.0 - 1e-6)).is_err(), "{name}");
        for wrong in [0.0, -5.0, f64::NAN] {
            let film = paraxial.film_for_focus(wrong);
            assert!(film.is_err(), "{name}: focus at {wrong} gives {film:?}");
        }
    }
    let plate =
        lens_of_rows(vec![row(f64::INFINITY, 3.0, 1.5, 20.0), row(f64::INFINITY, 0.0, 1.0, 20.0)]);
    let diverging = lens_of_rows(vec![row(-20.0, 3.0, 1.5, 20.0), row(20.0, 0.0, 1.0, 20.0)]);
    for lens in [plate, diverging] {
        for focus in [1.0, 1e3, f64::INFINITY] {
            let found = Paraxial::new(&lens).film_for_focus(focus);
            assert!(matches!(found, Err(FocusError::NoImage { .. })), "{found:?}");
        }
    }
}

fn camera(lens: RealLens, size: f64) -> Camera {
    Camera {
        model: LensModel::Real(Box::new(lens)),
        film: [size, size],
        world_from_camera: glam::DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, 1e6],
    }
}

fn samples(half: f64, corner: bool, seed: u64) -> SampleBatch {
    let mut random = Random::new(seed);
    let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
    for i in 0..WAVE_SIZE {
        let mut place =
            || if corner { random.between(0.9, 1.0) * half } else { random.between(-half, half) };
        [samples.film[0][i], samples.film[1][i]] = [place() as f32, place() as f32];
        [samples.pupil[0][i], samples.pupil[1][i]] = [random.next() as f32, random.next() as f32];
    }
    samples
}

#[test]
fn corners_without_an_open_pupil_give_no_rays() {
    let (name, film) = LENSES[1];
    let size = 200.0;
    let prescription = lens(name);
    let lens =
        RealLens::new(prescription, film, size * 0.5f64.sqrt(), PupilSampling::Pupil, 1e-3, 0.0);
    assert!(!lens.pupil_bounds().any_light([90.0; 2], [100.0; 2]), "the corner is dark");
    assert!(lens.pupil_bounds().any_light([-1.0; 2], [1.0; 2]), "the middle is not");
    let camera = camera(lens, size);
    let mut stats = LensStats::default();
    let (mut columns, mut rays) = (Box::<LensColumns>::default(), Box::<RayBatch>::default());
    camera.generate_rays::<f32x8>(&samples(100.0, true, 1), &mut columns, &mut rays, &mut stats);
    assert_eq!((rays.len, stats.aimed), (0, 0), "rays from the dark corner");
    assert_eq!(stats.blocked().iter().sum::<u64>(), 0);
}

#[test]
fn a_camera_with_any_lens_of_the_corpus_gives_finite_rays_and_counts_all() {
    let mut columns = Box::<LensColumns>::default();
    let mut rays = Box::<RayBatch>::default();
    for case in corpus() {
        let half = case.from[0];
        let lens = RealLens::new(
            case.lens,
            case.film,
            half * 2f64.sqrt(),
            PupilSampling::Pupil,
            1e-3,
            0.0,
        );
        let camera = camera(lens, 2.0 * half);
        let mut stats = LensStats::default();
        let mut out = 0;
        for seed in 0..2 {
            camera.generate_rays::<f32x8>(
                &samples(half, false, seed),
                &mut columns,
                &mut rays,
                &mut stats,
            );
            out += rays.len as u64;
            for i in 0..rays.len {
                let ray = rays.ray(i);
                let numbers = [ray.origin, ray.direction, rays.throughput(i)].concat();
                assert!(numbers.iter().all(|v| v.is_finite()), "{}: {ray:?}", case.name);
                assert!(!ray.t_max.is_nan(), "{}: {ray:?}", case.name);
                let length2 = ray.direction.iter().map(|v| v * v).sum::<f32>();
                assert!((length2 - 1.0).abs() < 1e-5, "{}: {ray:?}", case.name);
                assert!(rays.throughput(i)[0] >= 0.0, "{}", case.name);
            }
        }
        assert_eq!(out + stats.blocked().iter().sum::<u64>(), stats.aimed, "{}", case.name);
    }
}
