//! Decentred and tilted surfaces, elements and lenses.

use petzval_lens::{
    LensRay, Paraxial, Pose, Prescription, Rows, Side, TiltDecenter, sequence, trace_one,
};
use petzval_lens_formats::read;

use crate::support::oracle::placement::{multiply, rotation, transpose};
use crate::support::oracle::{V, unit};
use crate::support::probe::{Bench, RIM_TOLERANCE, compare, random_rays, rays_at_borders};
use crate::support::{LENSES, Random, lens, root, row};

fn pose(x: f64, y: f64, ax: f64, ay: f64) -> Pose {
    Pose { decentre: [x, y], tilt: [ax, ay] }
}

/// Returns misaligned lenses with their film distances: the course's, and two with other kinds of
/// surfaces. Single surfaces, an element, and an element within a group are misaligned.
fn misaligned() -> Vec<(Prescription, f64)> {
    let toml = |name: &str| read(&root().join("lenses").join(name)).expect("a lens");
    let mut lenses: Vec<_> = LENSES.map(|(name, film)| (lens(name), film)).to_vec();
    lenses.push((toml("anamorphic.toml"), 42.4));
    lenses.push((toml("triplet.toml"), 42.0));
    for (lens, _) in &mut lenses {
        lens.rows[1].pose = pose(0.3, -0.2, 0.0, 0.7);
        let last = lens.rows.len() - 1;
        lens.rows[last].pose = pose(0.0, 0.4, -1.1, 0.4);
        lens.tilt_decenters = vec![
            TiltDecenter { rows: [2, 3], pose: pose(-0.5, 0.1, 1.3, 0.0) },
            TiltDecenter { rows: [1, last - 1], pose: pose(0.2, 0.3, -0.8, 1.0) },
        ];
    }
    lenses
}

#[test]
fn rays_through_misaligned_lenses_agree_with_the_oracle() {
    for (lens, film) in misaligned() {
        let bench = Bench::new(&lens, film);
        let reach = lens.rear().diameter / 2.0;
        let mut rays = random_rays(film, 10.0, reach, 2000, 5);
        rays.extend(rays_at_borders(&bench, film, [10.0, reach], 60, 6));
        let report = compare(&lens.name, &bench, &rays, RIM_TOLERANCE);
        println!("{}: {:?} {:?}", lens.name, report.retraced, report.double);
        // The bounds of aligned lenses.
        assert!(report.retraced.um < 1.0 && report.retraced.urad < 5.0, "{}", lens.name);
        assert!(report.double.um < 1e-6 && report.double.urad < 0.1, "{}", lens.name);
        assert_eq!(
            (report.retraced.disagreed, report.double.disagreed, report.other_ends),
            (0, 0, 0)
        );
        assert!(report.retraced.both > 100, "{}: {}", lens.name, report.retraced.both);
    }
}

/// Converts a point or a direction between z towards the scene and z towards the film.
fn flip_z([x, y, z]: V) -> V {
    [x, y, -z]
}

#[test]
fn tilting_the_whole_lens_equals_tilting_the_world_backwards() {
    for (name, film) in LENSES {
        let square = lens(name);
        let pose = pose(1.5, -0.7, 6.0, -4.0);
        let mut tilted = square.clone();
        tilted.tilt_decenters = vec![TiltDecenter { rows: [0, square.rows.len() - 1], pose }];
        let turn = rotation(&pose);
        let length = square.length();
        let [dx, dy] = pose.decentre;
        let mut random = Random::new(12);
        let mut out = 0;
        for _ in 0..4000 {
            // A ray from the film, relative to the front vertex, in the frame of the lens.
            let half = square.rear().diameter / 2.0;
            let p = [random.between(-5.0, 5.0), random.between(-5.0, 5.0), length + film];
            let aim = [random.between(-half, half), random.between(-half, half), length];
            let d = unit([0, 1, 2].map(|i| aim[i] - p[i]));
            let start =
                |p: V, d: V| LensRay::new(flip_z([p[0], p[1], p[2] - length - film]), flip_z(d));
            let itself = trace_one::<f64>(start(p, d), &sequence::<f64>(&square, Side::Film(film)));
            let [x, y, z] = multiply(turn, p);
            let seen = start([x + dx, y + dy, z], multiply(turn, d));
            let moved = trace_one::<f64>(seen, &sequence::<f64>(&tilted, Side::Film(film)));
            match (itself, moved) {
                (Ok(itself), Ok(moved)) => {
                    out += 1;
                    let [x, y, z] = flip_z(moved.p);
                    let p = flip_z(multiply(transpose(turn), [x - dx, y - dy, z]));
                    let t = flip_z(multiply(transpose(turn), flip_z(moved.t)));
                    for axis in 0..3 {
                        assert!((p[axis] - itself.p[axis]).abs() < 1e-9, "{name} {p:?} {itself:?}");
                        assert!(
                            (t[axis] - itself.t[axis]).abs() < 1e-10,
                            "{name} {t:?} {itself:?}"
                        );
                    }
                }
                (Err(itself), Err(moved)) => assert_eq!(itself, moved, "{name}"),
                other => panic!("{name}: {other:?}"),
            }
        }
        assert!(out > 100, "{name}: {out}");
    }
}

/// Returns the image on the film of the axis point `object` mm before the front vertex: the mean of
/// rays through a small aperture.
fn image(lens: &Prescription, object: f64, film: f64) -> [f64; 2] {
    let surfaces = sequence::<f64>(lens, Side::Scene(object));
    let mut landed = [0.0; 2];
    let points = [[0.1, 0.0], [-0.1, 0.0], [0.0, 0.1], [0.0, -0.1]];
    for [u, v] in points {
        let ray = LensRay::new([0.0; 3], unit([u, v, object]));
        let ray = trace_one::<f64>(ray, &surfaces).expect("a ray near the axis");
        let s = (film - ray.p[2]) / ray.t[2];
        for (axis, landed) in landed.iter_mut().enumerate() {
            *landed += (ray.p[axis] + s * ray.t[axis]) / points.len() as f64;
        }
    }
    landed
}

/// Returns two thin lenses of 80 and 60 mm focal length, 25 mm apart, with the stop at the second.
fn pair() -> Prescription {
    let thin = |focal: f64, behind: f64| {
        let radius = 2.0 * 0.5 * focal;
        [row(radius, 1e-3, 1.5, 20.0), row(-radius, behind, 1.0, 20.0)]
    };
    let mut rows = [thin(80.0, 25.0), thin(60.0, 0.0)].concat();
    rows.push(row(0.0, 0.0, 1.0, 20.0));
    Prescription::new("pair", rows).expect("one stop")
}

#[test]
fn a_decentred_element_moves_the_image_by_its_decentre_times_one_minus_its_magnification() {
    let object = 400.0;
    // The magnification of each lens is -s' / s.
    let first = 1.0 / (1.0 / 80.0 - 1.0 / object);
    let second = {
        let s = 25.0 - first;
        1.0 / (1.0 / 60.0 - 1.0 / s)
    };
    let (m1, m2) = (-first / object, -second / (25.0 - first));
    let film = second;
    for (rows, magnification) in [([0, 1], (1.0 - m1) * m2), ([2, 3], 1.0 - m2)] {
        let mut lens = pair();
        lens.tilt_decenters = vec![TiltDecenter { rows, pose: pose(0.5, -0.25, 0.0, 0.0) }];
        let [x, y] = image(&lens, object, film);
        let expected = [0.5 * magnification, -0.25 * magnification];
        println!("{rows:?}: {x:.5} {y:.5}, expected {expected:.5?}");
        assert!((x / expected[0] - 1.0).abs() < 0.01 && (y / expected[1] - 1.0).abs() < 0.01);
    }
}

#[test]
fn a_tilted_surface_is_a_wedge_that_bends_by_n_minus_one_times_its_angle() {
    // A plane window in front of the lenses; its rear face is tilted by one degree.
    let mut lens = pair();
    let window = [row(f64::INFINITY, 2.0, 1.5, 20.0), row(f64::INFINITY, 5.0, 1.0, 20.0)];
    lens.rows = Rows::new([&window, &lens.rows[..]].concat()).expect("one stop");
    let far = 1e7;
    let film = Paraxial::new(&lens).back_focal_distance;
    let focal = Paraxial::new(&lens).focal_length;
    for (tilt, axis, sign) in [([1.0, 0.0], 1, -1.0), ([0.0, 1.0], 0, 1.0)] {
        lens.rows[1].pose = Pose { tilt, ..Pose::ALIGNED };
        let landed = image(&lens, far, film)[axis];
        // Light bends towards the base: a top tilted to the film makes the wedge thick at the top.
        let expected = -sign * 0.5 * 1f64.to_radians() * focal;
        println!("{tilt:?}: {landed:.5}, expected {expected:.5}");
        assert!((landed / expected - 1.0).abs() < 0.01, "{tilt:?}: {landed} {expected}");
    }
}

#[test]
fn inner_bodies_move_with_their_group() {
    let mut lens = pair();
    let (inner, outer) = (pose(0.4, 0.0, 3.0, 0.0), pose(-1.0, 0.5, 0.0, 5.0));
    lens.tilt_decenters = vec![
        TiltDecenter { rows: [2, 3], pose: inner },
        TiltDecenter { rows: [0, 4], pose: outer },
    ];
    let placed = lens.surface_transforms();
    // Bodies rotate about their first vertex: the second lens is 25.001 mm behind the first.
    let before = [0.4, 0.0, 25.001];
    let [x, y, z] = multiply(rotation(&outer), before);
    let vertex = placed[2].translation;
    assert!(vertex.distance(glam::DVec3::new(x - 1.0, y + 0.5, z)) < 1e-12, "{vertex}");
    // Surfaces of one body share a frame: four changes of frame remain.
    assert_eq!(lens.frame_transforms(), 4);
    lens.tilt_decenters.pop();
    assert_eq!(lens.frame_transforms(), 2);
    assert_eq!(lens.centred().frame_transforms(), 0);
}
