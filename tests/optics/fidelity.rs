//! Camera models of increasing fidelity: each within its limits, and against each other.

use std::collections::HashMap;

use crate::support::oracle::{dot, unit};
use crate::support::{LENSES, Random, lens, oracle, root};
use glam::{DAffine3, DQuat, DVec3};
use petzval_base::lanes::{Real, f32x8};
use petzval_base::rays::{RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;
use petzval_lens::{
    Camera, Coating, Fidelity, FilmPlane, LensColumns, LensModel, LensRay, Paraxial, Pose,
    Prescription, PupilSampling, RayTransferMatrix, RealLens, RealRayFocus, Side, sequence,
    trace_one,
};
use petzval_lens_formats::{parse_toml, read};
use petzval_optics::film_error;
use petzval_spectrum::LightBand;

/// Distance in focus, from the film, mm.
const FOCUS: f64 = 5000.0;

/// Returns a camera in a world of millimetres with the front vertex at the origin, and a film of this
/// width and height.
fn camera(prescription: Prescription, film: [f64; 2], pose: Pose) -> Camera {
    let distance =
        RealRayFocus::new(&prescription).film_distance(FOCUS).expect("a place for the film");
    let half = film.map(|side| side / 2.0);
    let plane = FilmPlane { distance, pose, radius: half[0].hypot(half[1]), half };
    let lens = RealLens::with_film(prescription, &plane, PupilSampling::Pupil, 1.0, 0.0);
    Camera {
        model: LensModel::Real(Box::new(lens)),
        film,
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

fn square(name: &str) -> Camera {
    camera(lens(name), [36.0, 24.0], Pose::ALIGNED)
}

/// Returns the camera with its stop and a film of 36 by 24 mm scaled by `part`.
fn scaled_stop_and_film(name: &str, part: f64) -> Camera {
    let mut prescription = lens(name);
    let stop = prescription.rows[prescription.stop()].diameter;
    prescription.stop_down(part * stop);
    camera(prescription, [36.0 * part, 24.0 * part], Pose::ALIGNED)
}

fn real(camera: &Camera) -> &RealLens {
    match &camera.model {
        LensModel::Real(lens) => lens,
        _ => panic!("a lens of glass"),
    }
}

/// Returns samples at film points that `place` gives, relative to the size of the film, from its centre.
fn samples(camera: &Camera, seed: u64, place: impl Fn(&mut Random) -> [f64; 2]) -> SampleBatch {
    let mut random = Random::new(seed);
    let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
    for i in 0..WAVE_SIZE {
        let place = place(&mut random);
        for axis in 0..2 {
            samples.film[axis][i] = (place[axis] * camera.film[axis]) as f32;
            samples.pupil[axis][i] = random.next() as f32;
        }
    }
    samples
}

fn everywhere(random: &mut Random) -> [f64; 2] {
    [random.between(-0.5, 0.5), random.between(-0.5, 0.5)]
}

fn exposed(camera: &Camera, samples: &SampleBatch) -> RayBatch {
    let mut rays = RayBatch::default();
    let mut stats = LensStats::default();
    camera.generate_rays::<f32x8>(samples, &mut LensColumns::default(), &mut rays, &mut stats);
    rays
}

/// Returns origin and direction of the k-th ray.
fn line(rays: &RayBatch, k: usize) -> [[f64; 3]; 2] {
    let ray = rays.ray(k);
    [ray.origin, ray.direction].map(|v| v.map(f64::from))
}

/// Returns the coordinate at which light along the line of a ray meets the film, mm, by the matrix of the
/// lens. The film lies `film` mm behind the rear vertex.
fn landing(paraxial: &Paraxial, film: f64, [p, d]: [[f64; 3]; 2], axis: usize) -> f64 {
    let RayTransferMatrix { a, b, c, d: e } = paraxial.whole;
    // The light travels against the direction of the ray.
    let slope = -d[axis] / d[2];
    let height = p[axis] + p[2] * slope;
    a * height + b * slope + film / paraxial.film_index * (c * height + e * slope)
}

#[test]
fn the_model_of_single_precision_is_the_camera_itself() {
    for (name, _) in LENSES {
        let camera = square(name);
        let samples = samples(&camera, 1, everywhere);
        let bits = |camera: &Camera| {
            let rays = exposed(camera, &samples);
            let of = |k| [line(&rays, k), [rays.throughput(k).map(f64::from); 2]];
            (0..rays.len).map(|k| of(k).map(|v| v.map(|v| v.map(f64::to_bits)))).collect::<Vec<_>>()
        };
        assert_eq!(bits(&camera), bits(&camera.with_fidelity(Fidelity::Single)), "{name}");
    }
}

/// Returns the root mean square angle, urad, between the rays of a camera and those of the oracle from the
/// same film point. The direction at the film comes from tracing back.
fn deviation_from_oracle(camera: &Camera, prescription: &Prescription, seed: u64) -> f64 {
    let film = real(camera).film_distance;
    let start = 2.0 * prescription.rows[0].diameter;
    let back = sequence::<f64>(prescription, Side::Scene(start));
    let samples = samples(camera, seed, everywhere);
    let rays = exposed(camera, &samples);
    let (mut sum, mut count) = (0.0, 0.0);
    for k in 0..rays.len {
        let [p, d] = line(&rays, k);
        let d = unit(d);
        let s = (start - p[2]) / d[2];
        let from = [p[0] + s * d[0], p[1] + s * d[1], 0.0];
        let Ok(LensRay { t, .. }) =
            trace_one::<f64>(LensRay::new(from, [-d[0], -d[1], d[2]]), &back)
        else {
            continue;
        };
        let i = rays.slot[k] as usize;
        let at = [samples.film[0][i].into(), samples.film[1][i].into(), 0.0];
        if let Ok([_, exact]) = oracle::trace_spheres(prescription, film, at, [-t[0], -t[1], t[2]])
        {
            let off = [0, 1, 2].map(|i| d[i] - exact[i]);
            (sum, count) = (sum + dot(off, off), count + 1.0);
        }
    }
    assert!(count > 700.0, "{count} rays");
    1e6 * (sum / count).sqrt()
}

#[test]
fn the_model_of_double_precision_equals_the_oracle_up_to_rounding() {
    for name in ["dgauss.50mm", "telephoto.250mm", "wide.22mm"] {
        let camera = camera(lens(name), [16.0, 12.0], Pose::ALIGNED);
        let [single, double] = [Fidelity::Single, Fidelity::Double]
            .map(|fidelity| deviation_from_oracle(&camera.with_fidelity(fidelity), &lens(name), 5));
        println!("{name}: f32 {single:.4} urad, f64 {double:.4} urad");
        // The direction in the world is rounded to f32, and so is the result of tracing back.
        assert!(double < 0.02 && single < 1.0, "{name}: {double} and {single} urad");
        assert!(double < 0.2 * single, "{name}: {double} and {single} urad");
    }
}

#[test]
fn single_and_double_precision_agree_to_a_tenth_of_a_micrometre() {
    for (name, _) in LENSES {
        let camera = square(name);
        let error = film_error(&camera, &camera.with_fidelity(Fidelity::Double), |_| FOCUS);
        assert!(error.rms_um > 1e-4 && error.rms_um < 0.1, "{name}: {error:?}");
        assert!(error.lost < 1e-5 && (error.light - 1.0).abs() < 1e-5, "{name}: {error:?}");
    }
}

#[test]
fn rays_of_ideal_lenses_agree_with_the_matrix() {
    for (name, _) in LENSES {
        for fidelity in [Fidelity::Thick, Fidelity::Paraxial] {
            let camera = square(name).with_fidelity(fidelity);
            let (paraxial, film) = (Paraxial::new(&lens(name)), real(&camera).film_distance);
            let samples = samples(&camera, 2, everywhere);
            let rays = exposed(&camera, &samples);
            assert!(rays.len > 200, "{name} {fidelity}: {}", rays.len);
            for k in 0..rays.len {
                for axis in 0..2 {
                    let wanted = f64::from(samples.film[axis][rays.slot[k] as usize]);
                    let found = landing(&paraxial, film, line(&rays, k), axis);
                    let off = (found - wanted).abs();
                    assert!(off < 2e-4, "{name} {fidelity}: {found} instead of {wanted} mm");
                }
            }
        }
    }
}

#[test]
fn the_thick_lens_equals_the_paraxial_lens_away_from_rims() {
    for (name, _) in LENSES {
        let camera = scaled_stop_and_film(name, 0.1);
        let [thick, paraxial] =
            [Fidelity::Thick, Fidelity::Paraxial].map(|f| camera.with_fidelity(f));
        for distance in [FOCUS, 700.0, f64::INFINITY] {
            let error = film_error(&thick, &paraxial, |_| distance);
            assert!(error.rms_um < 0.02 && error.lost < 1e-3, "{name}: {error:?}");
            assert!((error.light - 1.0).abs() < 2e-3, "{name}: {error:?}");
        }
        // A thin lens has the same perspective and depth of field.
        let error = film_error(&camera.with_fidelity(Fidelity::Thin), &paraxial, |_| 700.0);
        assert!(error.rms_um < 0.02, "{name}: {error:?}");
        let error = film_error(&camera.with_fidelity(Fidelity::Pinhole), &paraxial, |_| 700.0);
        assert!(error.rms_um > 1.0, "{name}: {error:?}");
    }
}

#[test]
fn the_error_of_ideal_lenses_is_of_third_order_near_the_axis() {
    for (name, _) in LENSES {
        for fidelity in [Fidelity::Thin, Fidelity::Thick, Fidelity::Paraxial] {
            let [whole, half] = [0.2, 0.1].map(|part| {
                let camera = scaled_stop_and_film(name, part);
                let model = camera.with_fidelity(fidelity);
                film_error(&model, &camera.with_fidelity(Fidelity::Double), |_| FOCUS).rms_um
            });
            println!("{name} {fidelity}: {whole:.4} um, and for half of everything {half:.4} um");
            assert!((6.5..9.0).contains(&(whole / half)), "{name} {fidelity}: {whole}, {half} um");
        }
    }
}

#[test]
fn the_polynomial_is_many_times_closer_to_the_real_lens_than_first_order_optics() {
    println!(
        "{:16} {:10} {:>10} {:>10} {:>7} {:>7}",
        "lens", "model", "rms um", "corner um", "lost", "light"
    );
    for ((name, _), [times, most]) in
        LENSES.into_iter().zip([[25.0, 4.0], [150.0, 5.0], [40.0, 1.0], [5.0, 16.0]])
    {
        let camera = square(name);
        let reference = camera.with_fidelity(Fidelity::Double);
        let of = |fidelity: Fidelity| {
            let error = film_error(&camera.with_fidelity(fidelity), &reference, |_| FOCUS);
            println!(
                "{name:16} {:10} {:10.4} {:10.4} {:7.4} {:7.4}",
                fidelity.name(),
                error.rms_um,
                error.corner_um,
                error.lost,
                error.light
            );
            error
        };
        let [.., paraxial, polynomial, single, double] = Fidelity::ALL.map(of);
        assert!(polynomial.rms_um < most, "{name}: {polynomial:?}");
        assert!(paraxial.rms_um > times * polynomial.rms_um, "{name}: {polynomial:?}");
        assert!(polynomial.lost < 2e-3, "{name}: {polynomial:?}");
        // The polynomial model knows rims only by the bound of the pupil.
        assert!((polynomial.light - 1.0).abs() < 0.03, "{name}: {polynomial:?}");
        assert!(single.rms_um < 0.1 && double.rms_um < 1e-9, "{name}: {single:?} {double:?}");
    }
}

/// Returns the mean weight of samples in the centre of the film.
fn brightness(camera: &Camera) -> f64 {
    let waves = 12;
    let light = (0..waves).map(|wave| {
        let rays = exposed(camera, &samples(camera, 100 + wave, |_| [0.0; 2]));
        (0..rays.len).map(|k| f64::from(rays.throughput(k)[1])).sum::<f64>()
    });
    light.sum::<f64>() / (waves as f64 * WAVE_SIZE as f64)
}

#[test]
fn the_centre_of_the_film_is_equally_bright_in_every_model() {
    for (name, _) in LENSES {
        let mut camera = square(name);
        camera.imaging_ratio = 3.0;
        let real = brightness(&camera);
        for fidelity in Fidelity::ALL {
            let found = brightness(&camera.with_fidelity(fidelity));
            assert!((found / real - 1.0).abs() < 0.01, "{name} {fidelity}: {found} and {real}");
        }
    }
}

/// Returns the mean of the points at which the rays of a film point meet a wall in front of the lens.
fn mean_hit(camera: &Camera, place: [f64; 2]) -> [f64; 2] {
    let rays = exposed(camera, &samples(camera, 3, |_| place));
    assert!(rays.len > WAVE_SIZE / 2, "{} rays", rays.len);
    let at = |k: usize, axis: usize| {
        let [p, d] = line(&rays, k);
        p[axis] + (3000.0 - p[2]) / d[2] * d[axis]
    };
    [0, 1].map(|axis| (0..rays.len).map(|k| at(k, axis)).sum::<f64>() / rays.len as f64)
}

#[test]
fn every_model_images_a_point_at_the_same_place() {
    for shift in [[0.0; 2], [4.0, -3.0]] {
        for (name, _) in LENSES {
            let camera = camera(lens(name), [12.0, 8.0], Pose::of_film(shift, [0.0; 2]));
            for place in [[0.3, 0.2], [-0.3, 0.2], [0.0, -0.3]] {
                let wanted = mean_hit(&camera, place);
                for fidelity in Fidelity::ALL {
                    let found = mean_hit(&camera.with_fidelity(fidelity), place);
                    let off = (found[0] - wanted[0]).hypot(found[1] - wanted[1]);
                    let far = wanted[0].hypot(wanted[1]);
                    // A fisheye compresses the field off the axis.
                    let most = if name.starts_with("fisheye") { 0.35 } else { 0.02 };
                    assert!(off < most * far, "{name} {fidelity}: {found:?}, not {wanted:?}");
                }
            }
        }
    }
}

#[test]
fn the_error_of_a_shifted_film_is_its_shift() {
    let camera = square("dgauss.50mm");
    let reference = camera.with_fidelity(Fidelity::Thick);
    let mut thin = camera.with_fidelity(Fidelity::Thin);
    let per_mm = thin.film[0] / camera.film[0];
    for (axis, distance) in [(0, FOCUS), (1, f64::INFINITY)] {
        if let LensModel::Thin(lens) = &mut thin.model {
            lens.middle[axis] += 0.3 * per_mm;
        }
        let error = film_error(&thin, &reference, |_| distance);
        let wanted = if axis == 0 { 300.0 } else { 300.0 * 2f64.sqrt() };
        let spread = [error.rms_um, error.p95_um, error.corner_um];
        for found in spread {
            assert!((found / wanted - 1.0).abs() < 0.02, "{error:?}");
        }
    }
}

#[test]
fn the_error_does_not_depend_on_position_and_scale_of_the_world() {
    let here = square("wide.22mm");
    let mut there = here.clone();
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 2.0);
    there.world_from_camera = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.1),
        turn,
        DVec3::new(3.0, 1.0, 2.0),
    );
    for fidelity in [Fidelity::Thin, Fidelity::Paraxial] {
        let of = |camera: &Camera, scale: f64| {
            let reference = camera.with_fidelity(Fidelity::Single);
            film_error(&camera.with_fidelity(fidelity), &reference, |_| 900.0 * scale)
        };
        let (one, other) = (of(&here, 1.0), of(&there, 0.1));
        assert!((one.rms_um / other.rms_um - 1.0).abs() < 1e-3, "{one:?} {other:?}");
        assert!((one.lost - other.lost).abs() < 1e-6, "{one:?} {other:?}");
    }
}

#[test]
fn every_kind_of_lens_has_all_models() {
    let read = |name: &str| read(&root().join("lenses").join(name)).expect("a lens");
    let mut unusual = vec![read("anamorphic.toml"), read("phone.toml"), read("triplet.toml")];
    let mut tilted = lens("dgauss.50mm");
    tilted.rows[2].pose = Pose { decentre: [0.3, 0.0], tilt: [1.0, -0.5] };
    unusual.push(tilted);
    let mut bladed = lens("dgauss.50mm");
    let stop = bladed.stop();
    bladed.rows[stop].iris =
        petzval_lens::Iris::Blades { count: 5, rotation: 10.0, curvature: 0.0 };
    unusual.push(bladed);
    for prescription in unusual {
        let name = prescription.name.clone();
        let side = 0.4 * Paraxial::new(&prescription).focal_length;
        // Finding the pupils of tilted film takes long.
        let tilts = if name.starts_with("Cooke") { 2 } else { 1 };
        for tilt in &[[0.0; 2], [4.0, -3.0]][..tilts] {
            let pose = Pose::of_film([0.02 * side, 0.0], *tilt);
            let camera = camera(prescription.clone(), [side, 0.7 * side], pose);
            let reference = camera.with_fidelity(Fidelity::Double);
            let mut last = f64::INFINITY;
            for fidelity in Fidelity::ALL {
                let model = camera.with_fidelity(fidelity);
                let error = film_error(&model, &reference, |_| FOCUS);
                println!("{name} {tilt:?} {fidelity}: {error:.3?}");
                assert!(error.rms_um.is_finite() && error.light.is_finite(), "{name}: {error:?}");
                assert!(error.light > 0.5 && error.light < 2.5, "{name} {fidelity}: {error:?}");
                match fidelity {
                    Fidelity::Polynomial => assert!(error.rms_um < 0.3 * last, "{name}: {error:?}"),
                    Fidelity::Single | Fidelity::Double => {
                        assert!(error.rms_um < 0.02 * last, "{name} {fidelity}: {error:?}");
                    }
                    _ => {}
                }
                last = error.rms_um;
            }
        }
    }
}

#[test]
fn eight_lanes_of_f64_trace_the_rays_of_one() {
    for fresnel in [false, true] {
        let mut prescription = lens("fisheye.10mm");
        prescription.coat(&Coating::Mgf2);
        let mut camera = camera(prescription, [36.0, 24.0], Pose::ALIGNED);
        let LensModel::Real(lens) = &mut camera.model else { panic!("a lens of glass") };
        (lens.trace_in_f64, lens.fresnel) = (true, fresnel);
        // A wave that does not fill its last packet.
        let mut samples = samples(&camera, 3, |random| [0, 1].map(|_| random.next() - 0.5));
        samples.len = WAVE_SIZE - 5;
        let one = traced::<f32>(&camera, &samples);
        let eight = traced::<f32x8>(&camera, &samples);
        assert!(one.len() > 500, "{} rays", one.len());
        assert_eq!(one, eight, "bit for bit");
    }
}

/// A film in glass: rays of every band start with the index of the glass at their wavelength, in f64 as in
/// f32.
#[test]
fn the_bands_of_a_film_in_glass_are_those_of_f32() {
    let text = "[[surface]]\nstop = true\ndiameter = 12\nthickness = 5
        [[surface]]\nradius = 60\nthickness = 6\ndiameter = 24\nglass = \"SF5\"
        [[surface]]\nradius = -120\nthickness = 40\ndiameter = 24
        [[surface]]\ndiameter = 24\nglass = \"SF5\"\n";
    let lens = parse_toml("glass.toml".as_ref(), text).expect("a lens");
    let mut lens = RealLens::new(lens, 60.0, 10.0, PupilSampling::Pupil, 1e-3, 0.0);
    let bands = [420.0, 680.0].map(|wavelength| LightBand { wavelength, response: [1.0; 3] });
    lens.disperse(&bands);
    let exact = RealLens { trace_in_f64: true, ..lens.clone() };
    let [single, exact] = [lens, exact].map(|lens| Camera {
        model: LensModel::Real(Box::new(lens)),
        film: [20.0; 2],
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    });
    for band in 0..bands.len() {
        let mut samples = samples(&single, 5, |_| [0.4, 0.0]);
        samples.band = band;
        let [single, exact] = [&single, &exact].map(|camera| traced::<f32x8>(camera, &samples));
        assert!(exact.len() > 500, "{} rays", exact.len());
        let exact: HashMap<u32, [f32; 3]> =
            exact.into_iter().map(|(slot, ray)| (slot, ray.map(f32::from_bits))).collect();
        let mut compared = 0;
        for (slot, ray) in single {
            let Some(exact) = exact.get(&slot) else { continue };
            let off = (0..3)
                .map(|axis| (f32::from_bits(ray[axis]) - exact[axis]).abs())
                .fold(0.0, f32::max);
            assert!(off < 1e-5, "band {band}, ray {slot}: {off}");
            compared += 1;
        }
        assert!(compared > 500, "{compared} rays");
    }
}

/// Returns the slots of the rays that leave the lens, with the bits of their directions.
fn traced<R: Real<Scalar = f32>>(camera: &Camera, samples: &SampleBatch) -> Vec<(u32, [u32; 3])> {
    let (mut columns, mut stats) = (LensColumns::default(), LensStats::default());
    let mut rays = RayBatch::default();
    camera.generate_rays::<R>(samples, &mut columns, &mut rays, &mut stats);
    (0..rays.len)
        .map(|i| (rays.slot[i], [0, 1, 2].map(|axis| rays.direction[axis][i].to_bits())))
        .collect()
}
