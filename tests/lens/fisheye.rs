//! A fisheye of 220 degrees: light that comes from behind the lens.

use std::fmt::Write as _;

use crate::support::{Random, folder, petzval, picture, root, write};
use glam::DAffine3;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{RayBatch, ReprojectionBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;
use petzval_lens::{
    Camera, FilmPlane, LensColumns, LensModel, Normalization, Pose, Prescription, PupilSampling,
    RealLens, RealRayFocus, Vignetting,
};
use petzval_lens_formats::read;
use petzval_render::Backend;
use petzval_render::plan::EffectSelection;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;
use petzval_spectrum::bands;

/// Radius, thickness, index and Abbe number of US 3,524,697 (Isshiki & Matsuki 1970), example 1,
/// scene side first, for f = 10; a radius of 0 is a plane, and the tenth row is the stop, whose place
/// is that of the patent's figure 1.
const PATENT: [[f64; 4]; 18] = [
    [88.722, 4.5, 1.61272, 58.6],
    [30.356, 24.5, 1.0, 0.0],
    [89.627, 3.9, 1.62041, 60.3],
    [14.301, 15.5, 1.0, 0.0],
    [-66.282, 1.3, 1.48848, 70.3],
    [17.127, 5.8, 1.7847, 26.0],
    [59.586, 3.2, 1.0, 0.0],
    [0.0, 1.9, 1.51743, 64.2],
    [0.0, 1.0, 1.0, 0.0],
    [0.0, 5.4, 1.0, 0.0],
    [-3220.849, 5.6, 1.78477, 26.0],
    [14.816, 11.3, 1.74372, 45.0],
    [-56.365, 0.2, 1.0, 0.0],
    [-305.981, 4.8, 1.76764, 46.5],
    [-28.988, 17.2, 1.0, 0.0],
    [64.417, 2.6, 1.78485, 26.0],
    [22.224, 17.4, 1.6223, 53.1],
    [-69.508, 17.8, 1.0, 0.0],
];
const STOP: usize = 9;
const SCALE: f64 = 0.6;

/// Returns the lens as a Zemax file that states a field (degrees) and no diameters.
fn zemax(field: f64) -> String {
    let mut text = format!(
        "MODE SEQ\nNAME fisheye\nUNIT MM X W X CM MR CPMM\nFNUM 5.6 0\nFTYP 0 0 3 1 0 0 0\n\
         XFLN 0 0 0\nYFLN 0 {} {field}\nWAVM 1 0.5875618 1\nPWAV 1\n\
         SURF 0\n  TYPE STANDARD\n  CURV 0\n  DISZ INFINITY\n",
        field / 2.0
    );
    for (i, [radius, thickness, index, abbe]) in PATENT.into_iter().enumerate() {
        let curvature = if radius == 0.0 { 0.0 } else { 1.0 / (SCALE * radius) };
        let stop = if i == STOP { "  STOP\n" } else { "" };
        let _ = write!(
            text,
            "SURF {}\n{stop}  TYPE STANDARD\n  CURV {curvature:.15}\n  DISZ {}\n",
            i + 1,
            SCALE * thickness
        );
        if index != 1.0 {
            let _ = writeln!(text, "  GLAS ___BLANK 1 0 {index} {abbe} 0 0 0 0 0 0");
        }
    }
    let _ = write!(text, "SURF {}\n  TYPE STANDARD\n  CURV 0\n  DISZ 0\n", PATENT.len() + 1);
    text
}

fn fisheye(field: f64) -> Prescription {
    read(&write(&folder(), "fisheye.zmx", zemax(field))).expect("a lens")
}

fn film(lens: &Prescription) -> f64 {
    RealRayFocus::new(lens).film_distance(f64::INFINITY).expect("a place for the film")
}

#[test]
fn unknown_diameters_are_those_of_a_field_beyond_90_degrees() {
    for field in [75.0, 95.0, 110.0] {
        let lens = fisheye(field);
        assert!(lens.design.notes.iter().all(|note| !note.contains("narrower")), "{field}");
        let vignetting = Vignetting::new(&lens, film(&lens), 1 << 12);
        // The height of a field angle, by bisection: the lens is equidistant to some percent.
        let height = |angle: f64| {
            let (mut low, mut high) = (0.0, 0.12 * angle);
            for _ in 0..40 {
                let middle = (low + high) / 2.0;
                match vignetting.field_angle(middle) {
                    Some(found) if found < angle => low = middle,
                    _ => high = middle,
                }
            }
            low
        };
        let pass = |angle: f64| {
            let budget = vignetting.budget([height(angle), 0.0], Normalization::Stop);
            budget.map_or(0.0, |budget| budget.pass)
        };
        let equidistant = height(field) / (6.0 * field.to_radians());
        assert!((0.88..1.06).contains(&equidistant), "{equidistant} at {field} degrees");
        assert!(pass(field - 0.5) > 0.999, "{} at {field} degrees", pass(field - 0.5));
        assert!(pass(field + 12.0) < 0.5, "{} beyond {field} degrees", pass(field + 12.0));
    }
}

#[test]
fn a_field_that_no_ray_reaches_is_a_note() {
    let notes = fisheye(145.0).design.notes;
    assert!(notes.iter().any(|note| note.contains("of 145.0 degrees")), "{notes:?}");
}

fn camera(lens: Prescription) -> Camera {
    let half = [8.0; 2];
    let distance = film(&lens);
    let plane = FilmPlane { distance, pose: Pose::ALIGNED, radius: 11.3, half };
    let mut lens = RealLens::with_film(lens, &plane, PupilSampling::Pupil, 1.0, 0.0);
    lens.disperse(&bands());
    lens.bound_all_bands();
    Camera {
        model: LensModel::Real(Box::new(lens)),
        film: half.map(|half| 2.0 * half),
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

#[test]
fn rays_from_behind_the_lens_are_shared_by_the_bands() {
    let camera = camera(fisheye(110.0));
    let mut random = Random::new(5);
    let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
    for i in 0..WAVE_SIZE {
        // 8.9 to 10.6 mm from the axis: from 90 degrees to 110.
        let (r, turn) = (random.between(8.9, 10.6), random.between(0.0, 6.2));
        [samples.film[0][i], samples.film[1][i]] =
            [r * turn.cos(), r * turn.sin()].map(|v| v as f32);
        [samples.pupil[0][i], samples.pupil[1][i]] =
            [random.next(), random.next()].map(|v| v as f32);
    }
    for band in [0, 15, 31] {
        samples.band = band;
        let (mut columns, mut rays) = (LensColumns::default(), RayBatch::default());
        let mut stats = LensStats::default();
        camera.generate_rays::<f32x8>(&samples, &mut columns, &mut rays, &mut stats);
        let mut back = ReprojectionBatch::default();
        camera.reproject::<f32x8>(band, &mut columns, &mut back);
        let (mut behind, mut lost) = (0, 0);
        for (k, &slot) in rays.slot[..rays.len].iter().enumerate() {
            if rays.direction[2][k] >= 0.0 {
                continue;
            }
            behind += 1;
            let i = slot as usize;
            if back.transmission[i] == 0.0 {
                lost += 1;
                continue;
            }
            for axis in 0..2 {
                let off = (back.film[axis][i] - samples.film[axis][i]).abs();
                assert!(off < 3e-4, "band {band}, sample {i} returns {off} mm off");
            }
        }
        assert!(behind > WAVE_SIZE / 3, "{behind} rays come from behind");
        assert!(lost <= behind / 100, "{lost} of {behind} do not return");
    }
}

#[test]
fn lens_trace_writes_rays_that_leave_backwards() {
    let folder = folder();
    let (lens, rays) = ("fisheye.zmx", "rays.csv");
    write(&folder, lens, zemax(110.0));
    let prescription = fisheye(110.0);
    let (film, length) = (film(&prescription), prescription.length());
    let vignetting = Vignetting::new(&prescription, film, 1 << 10);
    let mut csv = String::new();
    for i in 0..400 {
        // Through all of the rear element, from 10 mm beside the axis.
        let aim = -12.0 + 24.0 * f64::from(i) / 400.0;
        let _ = writeln!(csv, "10,0,{},{},0,{}", length + film, aim - 10.0, -film);
    }
    write(&folder, rays, csv);
    for precision in ["f32", "f64"] {
        let arguments = ["lens", "trace", lens, "--rays", rays, "--precision", precision];
        let (code, out, err) = petzval(folder.path(), &arguments);
        assert_eq!(code, 0, "{err}");
        let mut passed = 0;
        let expected = vignetting.field_angle(10.0).expect("light").to_radians();
        for line in out.lines().filter(|line| !line.starts_with("blocked")) {
            let ray: Vec<f64> = line.split(',').map(|v| v.parse().expect(line)).collect();
            // Backwards, from a point of the front sphere.
            let angle = (-ray[3]).atan2(-ray[5]);
            assert!(ray[5] > 0.0 && (angle - expected).abs() < 0.15, "{line}");
            let radius = SCALE * PATENT[0][0];
            let off = ray[0].hypot(ray[1]).hypot(ray[2] - radius) - radius;
            assert!(ray[2] > 0.0 && off.abs() < 1e-4, "{line}");
            passed += 1;
        }
        assert!(passed > 3, "{out}");
    }
}

#[test]
fn the_scene_shows_the_ground_behind_the_camera() {
    let description = pbrt::read(&root().join("scenes/zenith.pbrt")).expect("a scene");
    let changes = Changes {
        resolution: Some([120; 2]),
        samples: Some(32),
        effects: EffectSelection::None,
        ..Changes::default()
    };
    let job = prepare(description, &changes).expect("a job").job;
    let picture = picture(&job, Backend::Simd, 1);
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let vignetting = lens.vignetting(1 << 10);
    // Along the rows and columns through the middle, between posts.
    let (mut sky, mut ground) = (0, 0);
    for i in 0..60 {
        let height = (f64::from(i) + 0.5) / 120.0 * job.camera.film[0];
        let Some(angle) = vignetting.field_angle(height) else { continue };
        for [x, y] in [[60 + i, 60], [59 - i, 60], [60, 60 + i], [60, 59 - i]] {
            let [red, _, blue] = picture.pixels[(y * 120 + x) as usize].map(f64::from);
            match angle {
                0.0..85.0 => {
                    assert!(blue > 2.0 * red && red > 0.0, "{angle}: no sky, {red} {blue}");
                    sky += 1;
                }
                // The ground ends 3 degrees below the horizon, and its edge is blurred.
                98.0..106.0 => {
                    assert!(blue < 1.4 * red && blue > 0.0, "{angle}: no ground, {red} {blue}");
                    ground += 1;
                }
                _ => {}
            }
        }
    }
    assert!(sky > 100 && ground > 10, "{sky} pixels of sky, {ground} of the ground");
}
