//! Surfaces, elements and whole lenses that are decentred and tilted.

use petzval::lens::{
    Askew, From, LensRay, Paraxial, Pose, Prescription, read, sequence, trace_one,
};

use super::support::oracle::{V, times, transposed, turned, unit};
use super::support::probe::{Bench, RIMS, borders, compare, spread};
use super::support::{LENSES, Random, lens, root, row};

fn pose(x: f64, y: f64, ax: f64, ay: f64) -> Pose {
    Pose { decentre: [x, y], tilt: [ax, ay] }
}

/// The course's lenses and two more with other kinds of surfaces, misaligned: single surfaces, an
/// element, and the element in a group.
fn misaligned() -> Vec<(Prescription, f64)> {
    let toml = |name: &str| read(&root().join("lenses").join(name)).expect("a lens");
    let mut lenses: Vec<_> = LENSES.map(|(name, film)| (lens(name), film)).to_vec();
    lenses.push((toml("anamorphic.toml"), 42.4));
    lenses.push((toml("triplet.toml"), 42.0));
    for (lens, _) in &mut lenses {
        lens.rows[1].pose = pose(0.3, -0.2, 0.0, 0.7);
        let last = lens.rows.len() - 1;
        lens.rows[last].pose = pose(0.0, 0.4, -1.1, 0.4);
        lens.askew = vec![
            Askew { rows: [2, 3], pose: pose(-0.5, 0.1, 1.3, 0.0) },
            Askew { rows: [1, last - 1], pose: pose(0.2, 0.3, -0.8, 1.0) },
        ];
    }
    lenses
}

#[test]
fn rays_go_where_the_oracle_says_they_go() {
    for (lens, film) in misaligned() {
        let bench = Bench::new(&lens, film);
        let reach = lens.rear().diameter / 2.0;
        let mut rays = spread(film, 10.0, reach, 2000, 5);
        rays.extend(borders(&bench, film, [10.0, reach], 60, 6));
        let report = compare(&lens.name, &bench, &rays, RIMS);
        println!("{}: {:?} {:?}", lens.name, report.settled, report.double);
        // The promise of f32 for lenses whose parts stand square, and what f64 can do.
        assert!(report.settled.um < 1.0 && report.settled.urad < 5.0, "{}", lens.name);
        assert!(report.double.um < 1e-6 && report.double.urad < 0.1, "{}", lens.name);
        assert_eq!((report.settled.apart, report.double.apart, report.reasons), (0, 0, 0));
        assert!(report.settled.both > 100, "{}: {}", lens.name, report.settled.both);
    }
}

/// A point or a direction of a trace from the film, whose z runs to the scene, in lens space.
fn flipped([x, y, z]: V) -> V {
    [x, y, -z]
}

#[test]
fn a_lens_tilted_as_a_whole_sees_the_world_tilted_the_other_way() {
    for (name, film) in LENSES {
        let square = lens(name);
        let pose = pose(1.5, -0.7, 6.0, -4.0);
        let mut tilted = square.clone();
        tilted.askew = vec![Askew { rows: [0, square.rows.len() - 1], pose }];
        let turn = turned(&pose);
        let length = square.length();
        let [dx, dy] = pose.decentre;
        let mut random = Random::new(12);
        let mut out = 0;
        for _ in 0..4000 {
            // A ray relative to the front vertex, in the frame of the lens itself, from its film.
            let half = square.rear().diameter / 2.0;
            let p = [random.between(-5.0, 5.0), random.between(-5.0, 5.0), length + film];
            let aim = [random.between(-half, half), random.between(-half, half), length];
            let d = unit([0, 1, 2].map(|i| aim[i] - p[i]));
            let start =
                |p: V, d: V| LensRay::new(flipped([p[0], p[1], p[2] - length - film]), flipped(d));
            let itself = trace_one::<f64>(start(p, d), &sequence::<f64>(&square, From::Film(film)));
            let [x, y, z] = times(turn, p);
            let seen = start([x + dx, y + dy, z], times(turn, d));
            let moved = trace_one::<f64>(seen, &sequence::<f64>(&tilted, From::Film(film)));
            match (itself, moved) {
                (Ok(itself), Ok(moved)) => {
                    out += 1;
                    let [x, y, z] = flipped(moved.p);
                    let p = flipped(times(transposed(turn), [x - dx, y - dy, z]));
                    let t = flipped(times(transposed(turn), flipped(moved.t)));
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

/// Where rays from a point (0, y) of a plane before the front vertex land on a film, by their mean
/// through a small opening.
fn image(lens: &Prescription, object: f64, film: f64) -> [f64; 2] {
    let surfaces = sequence::<f64>(lens, From::Scene(object));
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

/// Two thin lenses, 80 and 60 mm of focal length, 25 mm apart, with the stop at the second.
fn pair() -> Prescription {
    let thin = |focal: f64, behind: f64| {
        let radius = 2.0 * 0.5 * focal;
        [row(radius, 1e-3, 1.5, 20.0), row(-radius, behind, 1.0, 20.0)]
    };
    let mut rows = [thin(80.0, 25.0), thin(60.0, 0.0)].concat();
    rows.push(row(0.0, 0.0, 1.0, 20.0));
    Prescription { name: "pair".into(), rows, ..Prescription::default() }
}

#[test]
fn a_decentred_element_moves_the_image_by_its_decentre_times_one_minus_its_magnification() {
    let object = 400.0;
    // Each magnifies its own object: -s' / s.
    let first = 1.0 / (1.0 / 80.0 - 1.0 / object);
    let second = {
        let s = 25.0 - first;
        1.0 / (1.0 / 60.0 - 1.0 / s)
    };
    let (m1, m2) = (-first / object, -second / (25.0 - first));
    let film = second;
    for (rows, magnification) in [([0, 1], (1.0 - m1) * m2), ([2, 3], 1.0 - m2)] {
        let mut lens = pair();
        lens.askew = vec![Askew { rows, pose: pose(0.5, -0.25, 0.0, 0.0) }];
        let [x, y] = image(&lens, object, film);
        let expected = [0.5 * magnification, -0.25 * magnification];
        println!("{rows:?}: {x:.5} {y:.5}, expected {expected:.5?}");
        assert!((x / expected[0] - 1.0).abs() < 0.01 && (y / expected[1] - 1.0).abs() < 0.01);
    }
}

#[test]
fn a_tilted_surface_is_a_wedge_that_bends_by_n_minus_one_times_its_angle() {
    // A plane window before a thin lens; its rear face is tilted by one degree.
    let mut lens = pair();
    lens.rows.insert(0, row(f64::INFINITY, 2.0, 1.5, 20.0));
    lens.rows.insert(1, row(f64::INFINITY, 5.0, 1.0, 20.0));
    let far = 1e7;
    let film = Paraxial::of(&lens).back_focal_distance;
    let focal = Paraxial::of(&lens).focal_length;
    for (tilt, axis, sign) in [([1.0, 0.0], 1, -1.0), ([0.0, 1.0], 0, 1.0)] {
        lens.rows[1].pose = Pose { tilt, ..Pose::SQUARE };
        let landed = image(&lens, far, film)[axis];
        // Light bends to the base: a top that leans to the film makes the wedge thick there.
        let expected = -sign * 0.5 * 1f64.to_radians() * focal;
        println!("{tilt:?}: {landed:.5}, expected {expected:.5}");
        assert!((landed / expected - 1.0).abs() < 0.01, "{tilt:?}: {landed} {expected}");
    }
}

#[test]
fn inner_bodies_move_with_those_that_hold_them() {
    let mut lens = pair();
    let (inner, outer) = (pose(0.4, 0.0, 3.0, 0.0), pose(-1.0, 0.5, 0.0, 5.0));
    lens.askew = vec![Askew { rows: [2, 3], pose: inner }, Askew { rows: [0, 4], pose: outer }];
    let placed = lens.placements();
    // About the first vertex of each: the second lens stands 25.001 mm behind the first.
    let before = [0.4, 0.0, 25.001];
    let [x, y, z] = times(turned(&outer), before);
    let vertex = placed[2].translation;
    assert!(vertex.distance(glam::DVec3::new(x - 1.0, y + 0.5, z)) < 1e-12, "{vertex}");
    // Surfaces of a body need no turn between them: in, to the inner one, out of it, out.
    assert_eq!(lens.turns(), 4);
    lens.askew.pop();
    assert_eq!(lens.turns(), 2);
    assert_eq!(lens.centred().turns(), 0);
}
