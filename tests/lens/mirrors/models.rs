//! Models of lower fidelity, T-stop and replay of lenses with mirrors.

use super::*;
use petzval_base::rays::SampleBatch;
use petzval_lens::{Camera, Fidelity, FilmPlane, LensModel, Pose, PupilSampling, RealLens};
use petzval_optics::film_error;

fn camera(lens: &Prescription, distance: f64, half: f64) -> Camera {
    let film = FilmPlane { distance, pose: Pose::ALIGNED, radius: 1.5 * half, half: [half, half] };
    let lens = RealLens::with_film(lens.clone(), &film, PupilSampling::Pupil, 1.0, 0.0);
    Camera {
        model: LensModel::Real(Box::new(lens)),
        film: [2.0 * half; 2],
        world_from_camera: DAffine3::IDENTITY,
        imaging_ratio: 1.0,
        depth: [0.0, f64::INFINITY],
    }
}

#[test]
fn simpler_models_of_mirror_lenses_agree_near_the_axis() {
    for (lens, _, half) in systems() {
        // A tilted mirror has no model without tilts: the scene would stand beside the axis.
        if lens.is_misaligned() {
            continue;
        }
        // Aberrations vanish with the aperture.
        let mut slow = lens.clone();
        let stop = slow.rows[slow.stop()].diameter;
        slow.stop_down(0.2 * stop);
        slow.rows.iter_mut().for_each(|row| row.obstruction *= 0.1);
        let film = RealRayFocus::new(&slow).film_distance(f64::INFINITY).expect("an image");
        let camera = camera(&slow, film, 0.1 * half);
        let exact = camera.with_fidelity(Fidelity::Double);
        for fidelity in Fidelity::ALL {
            let error = film_error(&camera.with_fidelity(fidelity), &exact, |_| 1e5);
            println!("{} {fidelity}: {error:.3?}", lens.name);
            assert!(error.rms_um.is_finite(), "{} {fidelity}: {error:?}", lens.name);
            if fidelity > Fidelity::Pinhole {
                assert!(error.rms_um < 2.0, "{} {fidelity}: {error:?}", lens.name);
            }
            assert!((0.9..1.1).contains(&error.light), "{} {fidelity}: {error:?}", lens.name);
        }
    }
}

#[test]
fn the_t_stop_contains_the_central_obstruction() {
    let lens = cassegrain();
    let film = Paraxial::new(&lens).back_focal_distance;
    let Camera { model: LensModel::Real(real), .. } = camera(&lens, film, 5.0) else {
        panic!("a real lens")
    };
    let share = real.unobstructed_share([0.0; 2]).expect("light");
    assert!((share - 0.91).abs() < 4e-3, "{share} for 1 - (60 / 200)^2");
    let folder = folder();
    let file = write(&folder, "lens.toml", CASSEGRAIN);
    let report = super::command::command(&["lens", file.to_str().expect("a name")]);
    let line = report.lines().find(|line| line.starts_with("T-stop")).expect("a T-stop");
    let stop: f64 = line.split_whitespace().nth(1).and_then(|v| v.parse().ok()).expect(line);
    // f/8 before losses; bare mirrors reflect everything.
    assert!((stop / (8.0 / 0.91f64.sqrt()) - 1.0).abs() < 5e-3, "{line}");
    assert!(line.contains("% obstructed"), "{line}");
}

#[test]
fn replayed_paths_meet_the_mirrors_and_obey_the_law_of_reflection() {
    for (lens, film, half) in systems() {
        let camera = camera(&lens, film, half);
        let placed = lens.surface_transforms();
        let mut random = Random::new(11);
        let (mut mirrors, mut passed) = (0, 0);
        for _ in 0..200 {
            let mut samples = SampleBatch { len: 1, ..SampleBatch::default() };
            for axis in 0..2 {
                samples.film[axis][0] = random.between(-half, half) as f32;
                samples.pupil[axis][0] = random.next() as f32;
            }
            let Some(path) = camera.ray_path(&samples) else { continue };
            let mut at = DVec3::from_array(path.start);
            let mut along = DVec3::from_array(path.direction);
            for (k, crossing) in path.crossings.iter().enumerate() {
                let Some(point) = crossing.point.map(DVec3::from_array) else { break };
                let row = &lens.rows[crossing.row];
                // On the surface, in its own frame.
                let own = placed[crossing.row].inverse().transform_point3(point);
                let sag = row.sag_at(own.x, own.y);
                assert!((own.z - sag).abs() < 1e-4, "{}: {own} and {sag}", lens.name);
                // On a straight way from the surface before.
                let way = point - at;
                if crossing.kind != "obstruction" {
                    let off = way.normalize().angle_between(along);
                    assert!(off < 1e-4, "{} row {}: {off} rad", lens.name, crossing.row);
                }
                if crossing.transmittance.is_none() {
                    break;
                }
                at = point;
                let normal = row.gradient(own.x, own.y);
                let normal = placed[crossing.row]
                    .transform_vector3(DVec3::new(normal[0], normal[1], -1.0))
                    .normalize();
                if crossing.kind == "mirror" {
                    mirrors += 1;
                    let cosine = along.dot(normal);
                    let angle = cosine.abs().min(1.0).acos().to_degrees();
                    let found = crossing.incidence.expect("an angle");
                    assert!((angle - found).abs() < 0.01, "{}: {angle}, {found}", lens.name);
                    along -= 2.0 * cosine * normal;
                } else if let Some(next) = path.crossings[k + 1..].iter().find_map(|c| c.point) {
                    // Refraction has a test of its own; the next way tells the direction.
                    let next = DVec3::from_array(next) - at;
                    along = if next.length() > 0.0 { next.normalize() } else { along };
                }
            }
            passed += usize::from(path.end.is_ok());
        }
        assert!(mirrors > 100 && passed > 80, "{}: {mirrors}, {passed}", lens.name);
    }
}
