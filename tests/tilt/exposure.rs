//! The pupil sampler behind film and elements that stand askew, against brute force: what a uniform
//! sky of radiance 1 gives the film.

use petzval::lanes::f32x8;
use petzval::lens::{
    Askew, Camera, Iris, LensColumns, Model, Pose, Prescription, RealLens, Vignetting,
};
use petzval::rays::{RayBatch, SampleBatch, WAVE};
use petzval::sampler::{Dimension, pairs, pixel_key};
use petzval::stats::LensStats;

use super::camera;
use super::support::oracle::{Oracle, V, dot, times, turned};
use super::support::survival::survival;
use super::support::{LENSES, in_parallel, lens};

fn stats() -> LensStats {
    LensStats { blocked: vec![0; 32], ..LensStats::default() }
}

/// Where a film point stands and the film's normal, z to the scene: by the oracle's matrices.
fn stand(pose: &Pose, [x, y]: [f64; 2]) -> [V; 2] {
    let turn = turned(pose);
    let [px, py, pz] = times(turn, [x, y, 0.0]);
    let [nx, ny, nz] = times(turn, [0.0, 0.0, -1.0]);
    let [dx, dy] = pose.decentre;
    [[px + dx, py + dy, -pz], [nx, ny, -nz]]
}

/// Irradiance by a grid over the plane of the rear vertex.
fn brute(lens: &Prescription, distance: f64, [p, n]: [V; 2], grid: i32) -> f64 {
    let oracle = Oracle::new(lens);
    // The rear element as it is seen reaches no farther.
    let reach = 0.7 * lens.rear().diameter;
    let cell = 2.0 * reach / f64::from(grid);
    let mut sum = 0.0;
    for i in 0..grid * grid {
        let place = |k: i32| -reach + (f64::from(k) + 0.5) * cell;
        let d = [place(i % grid) - p[0], place(i / grid) - p[1], distance - p[2]];
        if let Ok(exit) = oracle.follow(distance, p, d).end {
            // Cosines at the film and at that plane, over the square of the distance.
            let d2 = dot(d, d);
            sum += exit.weight * dot(n, d).max(0.0) * d[2] / (d2 * d2);
        }
    }
    sum * cell * cell
}

/// The same by the sampler, with the share of its rays that leave the lens.
fn sampled(camera: &Camera, film: [f64; 2]) -> (f64, f64) {
    let mut samples = SampleBatch { len: WAVE, ..SampleBatch::default() };
    let (mut rays, mut columns) = (RayBatch::default(), LensColumns::default());
    let (mut sum, mut alive) = (0.0, 0);
    const WAVES: u32 = 60;
    for wave in 0..WAVES {
        for i in 0..WAVE {
            samples.key[i] = pixel_key(3, 1, 4);
            samples.sample[i] = wave * WAVE as u32 + i as u32;
            (samples.film[0][i], samples.film[1][i]) = (film[0] as f32, film[1] as f32);
        }
        let [u, v] = &mut samples.pupil;
        pairs(&samples.key[..], &samples.sample[..], Dimension::Pupil, &mut u[..], &mut v[..]);
        camera.expose::<f32x8>(&samples, &mut columns, &mut rays, &mut stats());
        sum += (0..rays.len).map(|i| f64::from(rays.carried[0][i])).sum::<f64>();
        alive += rays.len;
    }
    let total = f64::from(WAVES) * WAVE as f64;
    (sum / total, alive as f64 / total)
}

/// A lens with elements off by a degree and half a millimetre.
fn misaligned(mut lens: Prescription) -> Prescription {
    let last = lens.rows.len() - 1;
    let pose = |x, y, ax, ay| Pose { decentre: [x, y], tilt: [ax, ay] };
    lens.askew = vec![
        Askew { rows: [0, 1], pose: pose(0.5, 0.0, 0.0, 1.0) },
        Askew { rows: [last - 1, last], pose: pose(0.0, -0.5, 1.0, 0.0) },
    ];
    lens
}

const VIEW: Pose = Pose { decentre: [6.0, -8.0], tilt: [6.0, -5.3] };

#[test]
fn film_and_elements_askew_are_exposed_without_bias() {
    let mut cases = Vec::new();
    for (name, distance) in LENSES {
        let lens = lens(name);
        cases.push(match name {
            // Of a film shifted so far it would light a corner only.
            "fisheye.10mm" => (misaligned(lens), distance, Pose::SQUARE),
            "telephoto.250mm" => (lens, distance, VIEW),
            _ => (misaligned(lens), distance, VIEW),
        });
    }
    let mut shaped = lens("dgauss.50mm");
    let stop = shaped.stop();
    shaped.rows[stop].iris = Iris::Blades { count: 5, rotation: 20.0, curvature: 0.0 };
    shaped.rows[stop].pose = Pose { decentre: [0.0; 2], tilt: [5.0, 0.0] };
    cases.push((shaped, 36.77, Pose::SQUARE));
    let broken = in_parallel(&cases, |(lens, distance, pose)| {
        let camera = camera(lens.clone(), *distance, *pose, [24.0, 18.0]);
        let ledgers = Vignetting::posed(lens, *distance, *pose, 1 << 16);
        let mut broken = Vec::new();
        let mut centre = 0.0;
        for point in [[0.0, 0.0], [-9.0, 4.0]] {
            let truth = brute(lens, *distance, stand(pose, point), 200);
            let (ours, share) = sampled(&camera, point);
            centre = if point == [0.0; 2] { truth } else { centre };
            let ledger = ledgers.ledger(point, petzval::lens::Of::Rear);
            let light = ledger.map_or(0.0, |ledger| ledger.irradiance);
            println!(
                "{} {pose} {point:?}: {ours:.6} {light:.6} {truth:.6}, {:.1} %",
                lens.name,
                100.0 * share
            );
            // The grid of the truth has thousands of cells in the pupil: half a percent; the ledger's
            // rays are spread over all of the rear element.
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
fn nearly_every_aimed_ray_leaves_a_lens_that_stands_askew() {
    for (name, distance) in LENSES {
        let closed = |divisor: f64| {
            let mut lens = lens(name);
            lens.stop_down(lens.rows[lens.stop()].diameter / divisor);
            lens
        };
        let shift = Pose { tilt: [0.0; 2], ..VIEW };
        for (what, lens, pose) in [
            ("elements", misaligned(closed(1.0)), Pose::SQUARE),
            ("film", closed(1.0), VIEW),
            ("shift", closed(4.0), shift),
            ("both, stopped down", misaligned(closed(4.0)), VIEW),
        ] {
            let share = survival(&camera(lens, distance, pose, [49.497; 2]), 60);
            println!("{name}, {what}: {:.2} %", 100.0 * share);
            // 60,000 rays: a standard error of 0.12 %.
            assert!(share > 0.9, "{name}, {what}: {share}");
        }
    }
}

#[test]
fn what_stands_square_is_looked_up_by_rings_as_ever() {
    let Model::Real(lens) = camera(lens("wide.22mm"), 14.54, Pose::SQUARE, [36.0, 24.0]).model
    else {
        panic!("a real lens")
    };
    let same: &RealLens = &lens;
    assert!(!same.is_askew() && same.is_round() && same.prescription.turns() == 0);
}
