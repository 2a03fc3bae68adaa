//! Pupil sampler with tilted film and elements against brute force: irradiance of the film under a
//! uniform sky of radiance 1.

use petzval_base::sampler::pixel_key;
use petzval_lens::{Iris, LensModel, Pose, Prescription, RealLens, TiltDecenter, Vignetting};

use super::camera;
use crate::support::oracle::placement::{multiply, rotation};
use crate::support::oracle::{Oracle, V, dot};
use crate::support::sampling::{irradiance_and_share, transmitted_share};
use crate::support::{LENSES, in_parallel, lens};

/// Returns the position of a film point and the normal of the film, z towards the scene, by the
/// oracle's matrices.
fn film_point_and_normal(pose: &Pose, [x, y]: [f64; 2]) -> [V; 2] {
    let turn = rotation(pose);
    let [px, py, pz] = multiply(turn, [x, y, 0.0]);
    let [nx, ny, nz] = multiply(turn, [0.0, 0.0, -1.0]);
    let [dx, dy] = pose.decentre;
    [[px + dx, py + dy, -pz], [nx, ny, -nz]]
}

/// Returns the irradiance by a grid over the plane of the rear vertex.
fn irradiance_by_grid(lens: &Prescription, distance: f64, [p, n]: [V; 2], grid: i32) -> f64 {
    let oracle = Oracle::new(lens);
    // The projection of the rear element reaches no farther.
    let reach = 0.7 * lens.rear().diameter;
    let cell = 2.0 * reach / f64::from(grid);
    let mut sum = 0.0;
    for i in 0..grid * grid {
        let place = |k: i32| -reach + (f64::from(k) + 0.5) * cell;
        let d = [place(i % grid) - p[0], place(i / grid) - p[1], distance - p[2]];
        if let Ok(exit) = oracle.trace(distance, p, d).end {
            // Cosines at the film and at the plane, divided by the squared distance.
            let d2 = dot(d, d);
            sum += exit.weight * dot(n, d).max(0.0) * d[2] / (d2 * d2);
        }
    }
    sum * cell * cell
}

/// Tilts and decentres elements by about a degree and half a millimetre.
fn misaligned(mut lens: Prescription) -> Prescription {
    let last = lens.rows.len() - 1;
    let pose = |x, y, ax, ay| Pose { decentre: [x, y], tilt: [ax, ay] };
    lens.tilt_decenters = vec![
        TiltDecenter { rows: [0, 1], pose: pose(0.5, 0.0, 0.0, 1.0) },
        TiltDecenter { rows: [last - 1, last], pose: pose(0.0, -0.5, 1.0, 0.0) },
    ];
    lens
}

const VIEW: Pose = Pose { decentre: [6.0, -8.0], tilt: [6.0, -5.3] };

#[test]
fn tilted_film_and_elements_are_exposed_without_bias() {
    let mut cases = Vec::new();
    for (name, distance) in LENSES {
        let lens = lens(name);
        cases.push(match name {
            // It would light only a corner of a film shifted so far.
            "fisheye.10mm" => (misaligned(lens), distance, Pose::ALIGNED),
            "telephoto.250mm" => (lens, distance, VIEW),
            _ => (misaligned(lens), distance, VIEW),
        });
    }
    let mut shaped = lens("dgauss.50mm");
    let stop = shaped.stop();
    shaped.rows[stop].iris = Iris::Blades { count: 5, rotation: 20.0, curvature: 0.0 };
    shaped.rows[stop].pose = Pose { decentre: [0.0; 2], tilt: [5.0, 0.0] };
    cases.push((shaped, 36.77, Pose::ALIGNED));
    let broken = in_parallel(&cases, |(lens, distance, pose)| {
        let camera = camera(lens.clone(), *distance, *pose, [24.0, 18.0]);
        let ledgers = Vignetting::for_pose(lens, *distance, *pose, 1 << 16);
        let mut broken = Vec::new();
        let mut centre = 0.0;
        for point in [[0.0, 0.0], [-9.0, 4.0]] {
            let truth =
                irradiance_by_grid(lens, *distance, film_point_and_normal(pose, point), 200);
            let (ours, share) = irradiance_and_share(&camera, point, 60, pixel_key(3, 1, 4));
            centre = if point == [0.0; 2] { truth } else { centre };
            let ledger = ledgers.budget(point, petzval_lens::Normalization::Rear);
            let light = ledger.map_or(0.0, |ledger| ledger.irradiance);
            println!(
                "{} {pose} {point:?}: {ours:.6} {light:.6} {truth:.6}, {:.1} %",
                lens.name,
                100.0 * share
            );
            // The grid has thousands of cells in the pupil: an error of half a percent. The rays of the
            // light budget cover the whole rear element, so its error is larger.
            let off = [(ours - truth).abs() / centre, (light - truth).abs() / centre];
            if off[0] > 0.006 || off[1] > 0.015 {
                broken.push(format!("{} {pose} {point:?}: {ours} {light} {truth}", lens.name));
            }
        }
        broken
    });
    let broken = broken.concat();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn more_than_90_percent_of_aimed_rays_leave_a_misaligned_lens() {
    for (name, distance) in LENSES {
        let closed = |divisor: f64| {
            let mut lens = lens(name);
            lens.stop_down(lens.rows[lens.stop()].diameter / divisor);
            lens
        };
        let shift = Pose { tilt: [0.0; 2], ..VIEW };
        for (what, lens, pose) in [
            ("elements", misaligned(closed(1.0)), Pose::ALIGNED),
            ("film", closed(1.0), VIEW),
            ("shift", closed(4.0), shift),
            ("both, stopped down", misaligned(closed(4.0)), VIEW),
        ] {
            let share = transmitted_share(&camera(lens, distance, pose, [49.497; 2]), 60);
            println!("{name}, {what}: {:.2} %", 100.0 * share);
            // The standard error of 60,000 rays is 0.12 %.
            assert!(share > 0.9, "{name}, {what}: {share}");
        }
    }
}

#[test]
fn an_aligned_lens_uses_the_rings_of_the_pupil_table() {
    let LensModel::Real(lens) = camera(lens("wide.22mm"), 14.54, Pose::ALIGNED, [36.0, 24.0]).model
    else {
        panic!("a real lens")
    };
    let same: &RealLens = &lens;
    assert!(!same.is_misaligned() && same.is_round() && same.prescription.frame_transforms() == 0);
}
