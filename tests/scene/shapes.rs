//! Shapes against their definitions: areas, tangents and subdivision limits.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2, Vec3};
use petzval_base::rays::Hit;
use petzval_scene::{
    CurveSegment, Mesh, Quadric, QuadricForm, SubdivisionError, split_patches, subdivide,
    tessellate_curve,
};

const SPHERE: QuadricForm = QuadricForm::Sphere { radius: 2.0, z: [-1.5, 1.0] };
const CYLINDER: QuadricForm = QuadricForm::Cylinder { radius: 0.7, z: [-0.5, 1.2] };
const DISK: QuadricForm = QuadricForm::Disk { radius: 1.5, inner: 0.4, height: 0.3 };
const CONE: QuadricForm = QuadricForm::Cone { radius: 0.8, height: 1.7 };
const FORMS: [QuadricForm; 4] = [SPHERE, CYLINDER, DISK, CONE];

/// Returns the point at (u, v) by the definition of pbrt's manual.
fn point_at(form: QuadricForm, phi_max: f64, u: f64, v: f64) -> DVec3 {
    let (sin, cos) = (u * phi_max).sin_cos();
    let around = |r: f64, z: f64| DVec3::new(r * cos, r * sin, z);
    match form {
        QuadricForm::Sphere { radius, z } => {
            let [low, high] = z.map(|z| (z / radius).acos());
            let theta = low + v * (high - low);
            around(radius * theta.sin(), radius * theta.cos())
        }
        QuadricForm::Cylinder { radius, z } => around(radius, z[0] + v * (z[1] - z[0])),
        QuadricForm::Disk { radius, inner, height } => {
            around((1.0 - v) * radius + v * inner, height)
        }
        QuadricForm::Cone { radius, height } => around((1.0 - v) * radius, v * height),
    }
}

/// Returns transforms of a rotation, a non-uniform scale and a shear. The second one also mirrors.
fn places() -> [DAffine3; 2] {
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.3, 1.0, 0.0), DVec3::new(-0.2, 0.4, 1.0));
    let place = DAffine3::from_translation(DVec3::new(3.0, -1.0, 2.0))
        * DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.1)
        * DAffine3::from_scale(DVec3::new(0.7, 1.3, 2.1))
        * DAffine3::from_mat3(shear);
    [place, place * DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0))]
}

#[test]
fn tangents_equal_finite_differences() {
    const STEP: f64 = 1e-4;
    for (form, phi_max) in FORMS.into_iter().flat_map(|form| [(form, TAU), (form, 4.0)]) {
        for (place, reversed) in places().into_iter().flat_map(|p| [(p, false), (p, true)]) {
            let quadric = Quadric::new(form, phi_max, place, reversed).unwrap();
            for (u, v) in [(0.1, 0.2), (0.35, 0.9), (0.6, 0.5), (0.9, 0.05)] {
                let point = |u, v| place.transform_point3(point_at(form, phi_max, u, v));
                let normal = |u, v| quadric.point(point(u, v)).normal.as_dvec3();
                let patch = quadric.derivatives(point(u, v));
                assert!(patch.uv.as_dvec2().distance(DVec2::new(u, v)) < 1e-6, "{form:?}");
                let slope = |f: &dyn Fn(f64, f64) -> DVec3| {
                    let (du, dv) =
                        (f(u + STEP, v) - f(u - STEP, v), f(u, v + STEP) - f(u, v - STEP));
                    [du, dv].map(|d| d / (2.0 * STEP))
                };
                // Points are in f64; normals are rounded to f32 before the difference.
                for (found, exact) in patch.dp.into_iter().zip(slope(&point)) {
                    assert!(
                        found.as_dvec3().distance(exact) < 1e-5 * (1.0 + exact.length()),
                        "{form:?}"
                    );
                }
                for (found, exact) in patch.dn.into_iter().zip(slope(&normal)) {
                    assert!(found.as_dvec3().distance(exact) < 5e-3, "{form:?}: {found} {exact}");
                }
                // pbrt's orientation is dp/du x dp/dv, reversed by a mirror and by ReverseOrientation.
                let outside = patch.dp[0].cross(patch.dp[1]).as_dvec3();
                let turned = (place.matrix3.determinant() < 0.0) ^ reversed;
                assert_eq!(outside.dot(normal(u, v)) < 0.0, turned, "{form:?}");
            }
        }
    }
}

#[test]
fn tangents_are_finite_at_poles() {
    for (form, pole) in [
        (QuadricForm::Sphere { radius: 2.0, z: [-2.0, 2.0] }, DVec3::Z * 2.0),
        (QuadricForm::Disk { radius: 1.0, inner: 0.0, height: 0.5 }, DVec3::Z * 0.5),
        (CONE, DVec3::Z * 1.7),
    ] {
        let patch = Quadric::new(form, TAU, DAffine3::IDENTITY, false).unwrap().derivatives(pole);
        let normal = patch.dp[0].cross(patch.dp[1]);
        assert!(normal.is_finite() && normal.length() > 0.0, "{form:?}: {patch:?}");
        assert!(patch.dn.iter().all(|d| d.is_finite()), "{form:?}");
    }
}

#[test]
fn areas_are_those_of_the_textbook() {
    let whole = [
        (SPHERE, TAU * 2.0 * 2.5),
        (CYLINDER, TAU * 0.7 * 1.7),
        (DISK, PI * (1.5 * 1.5 - 0.4 * 0.4)),
        (CONE, PI * 0.8 * 0.8f64.hypot(1.7)),
    ];
    for (form, area) in whole {
        for (phi_max, share) in [(TAU, 1.0), (PI / 2.0, 0.25)] {
            // Twice the size gives four times the area.
            let twice = DAffine3::from_scale(DVec3::splat(2.0));
            let found = Quadric::new(form, phi_max, twice, false).unwrap().area();
            let expected = 4.0 * area * share;
            assert!((found / expected - 1.0).abs() < 1e-6, "{form:?}: {found}, not {expected}");
        }
    }
    // A cylinder scaled by half along y: Ramanujan's formula for the circumference of an ellipse.
    let pressed = DAffine3::from_scale(DVec3::new(1.0, 0.5, 1.0));
    let found = Quadric::new(CYLINDER, TAU, pressed, false).unwrap().area();
    let (a, b): (f64, f64) = (0.7, 0.35);
    let around = PI * (3.0 * (a + b) - ((3.0 * a + b) * (a + 3.0 * b)).sqrt());
    assert!((found / (around * 1.7) - 1.0).abs() < 1e-3, "{found}");
}

#[test]
fn rays_hit_a_partial_cylinder_from_both_sides_and_pass_its_gaps() {
    let place = places()[0];
    let quadric = Quadric::new(CYLINDER, 4.0, place, false).unwrap();
    for i in 1..2000 {
        let share = |k: f64| (f64::from(i) * k).fract();
        let (u, v) = (share(0.754_877_666), share(0.569_840_291));
        let inside = DVec3::Z * 0.35;
        for (eye, phi_max) in [(inside, 4.0), (inside, TAU)] {
            let target = point_at(CYLINDER, phi_max, u, v);
            let [eye, target] = [eye, target].map(|p| place.transform_point3(p));
            let t = quadric.intersect(eye, target - eye, f64::INFINITY);
            match u * phi_max <= 4.0 {
                true => assert!((t.unwrap() - 1.0).abs() < 1e-12, "{u} {v}: {t:?}"),
                false => assert_eq!(t, None, "{u} {v}"),
            }
        }
        // From outside along the normal.
        let target = point_at(CYLINDER, 4.0, u, v);
        let eye = target + DVec3::new(target.x, target.y, 0.0) * 5.0;
        let [eye, target] = [eye, target].map(|p| place.transform_point3(p));
        let t = quadric.intersect(eye, target - eye, f64::INFINITY);
        assert!((t.unwrap() - 1.0).abs() < 1e-12);
    }
    let above = place.transform_point3(DVec3::new(3.0, 0.0, 1.3));
    let across = place.transform_vector3(DVec3::NEG_X);
    assert_eq!(quadric.intersect(above, across, f64::INFINITY), None);
}

fn tetrahedron() -> Mesh {
    Mesh {
        positions: vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]],
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
        ..Mesh::default()
    }
}

fn square() -> Mesh {
    Mesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn close(found: [f32; 3], expected: [f32; 3]) {
    let distance = Vec3::from(found).distance(Vec3::from(expected));
    assert!(distance < 1e-6, "{found:?} instead of {expected:?}");
}

#[test]
fn a_subdivided_tetrahedron_shrinks_to_a_fifth_at_any_level() {
    // The limit of a vertex with three neighbours is 2/5 of it plus 1/5 of each of them, whose sum is
    // the negative of the vertex here.
    for levels in 0..5 {
        let mesh = subdivide(&tetrahedron(), levels).unwrap();
        assert_eq!(mesh.triangles.len(), 4 << (2 * levels));
        // By Euler's formula a sphere has two more vertices than half its faces.
        assert_eq!(mesh.positions.len(), mesh.triangles.len() / 2 + 2);
        for (i, v) in tetrahedron().positions.iter().enumerate() {
            close(mesh.positions[i], v.map(|x| x / 5.0));
            // pbrt's normals point opposite to the winding of the faces, which is outwards here.
            close(mesh.normals[i], v.map(|x| -x / 3f32.sqrt()));
        }
    }
}

#[test]
fn the_boundary_of_an_open_mesh_follows_the_boundary_rule() {
    // The limit on a boundary is 3/5 of the vertex plus 1/5 of its two neighbours there. One level first
    // moves the corner (0, 0) to (1/8, 1/8) and its neighbours to (1/2, 0) and (0, 1/2).
    for (levels, near) in [(0, 0.2), (1, 0.6 / 8.0 + 0.1)] {
        let mesh = subdivide(&square(), levels).unwrap();
        let far = 1.0 - near;
        let corners = [[near, near, 0.0], [far, near, 0.0], [far, far, 0.0], [near, far, 0.0]];
        for (found, expected) in mesh.positions.iter().zip(corners) {
            close(*found, expected);
        }
        mesh.normals.iter().for_each(|n| close(*n, [0.0, 0.0, -1.0]));
    }
    // One level, then the limit: the middle of the side from (0, 0) to (1, 0) moves to (1/2, 0), and its
    // neighbours along the side to (1/8, 1/8) and (7/8, 1/8).
    let mesh = subdivide(&square(), 1).unwrap();
    assert!(
        mesh.positions.iter().any(|p| Vec3::from(*p).distance(Vec3::new(0.5, 0.05, 0.0)) < 1e-6)
    );
    // The middle of the diagonal, 3/8 of its ends plus 1/8 of the other corners, stays at (1/2, 1/2).
    assert!(
        mesh.positions.iter().any(|p| Vec3::from(*p).distance(Vec3::new(0.5, 0.5, 0.0)) < 1e-6)
    );
}

#[test]
fn a_subdivided_plane_stays_a_plane() {
    // With six neighbours at each vertex linear functions are preserved.
    let side = 7;
    let point = |i: u32| {
        let (x, y) = ((i % side) as f32, (i / side) as f32);
        [x + 0.5 * y, y, 0.25 * x - 0.5 * y]
    };
    let cell = |i: u32| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]];
    let inside = |i: &u32| i % side < side - 1 && i / side < side - 1;
    let mesh = Mesh {
        positions: (0..side * side).map(point).collect(),
        triangles: (0..side * side).filter(inside).flat_map(cell).collect(),
        ..Mesh::default()
    };
    let smooth = subdivide(&mesh, 2).unwrap();
    let up = Vec3::new(1.0, 0.0, 0.25).cross(Vec3::new(0.5, 1.0, -0.5)).normalize();
    for i in 0..side * side {
        let [x, y] = [i % side, i / side];
        if (2..side - 2).contains(&x) && (2..side - 2).contains(&y) {
            close(smooth.positions[i as usize], mesh.positions[i as usize]);
        }
    }
    smooth.normals.iter().for_each(|n| close(*n, (-up).to_array()));
}

#[test]
fn meshes_that_are_no_surface_are_refused() {
    let of = |triangles: &[[u32; 3]]| {
        let mesh =
            Mesh { positions: vec![[0.0; 3]; 7], triangles: triangles.to_vec(), ..Mesh::default() };
        subdivide(&mesh, 2).map(|_| ())
    };
    assert_eq!(of(&[[0, 1, 2], [0, 1, 3]]), Err(SubdivisionError::NonManifoldEdge(0, 1)));
    assert_eq!(of(&[[0, 1, 2], [0, 3, 4]]), Err(SubdivisionError::NonManifoldVertex(0)));
    assert_eq!(of(&[[0, 1, 1]]), Err(SubdivisionError::DegenerateTriangle(0)));
    assert_eq!(of(&[[0, 1, 2], [2, 1, 3]]), Ok(()));
}

#[test]
fn a_flat_patch_gives_two_triangles_and_an_emitting_twisted_one_many() {
    let mut mesh = Mesh {
        positions: vec![
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [2.0, 1.0, 0.0],
            [2.0, 1.0, 1.0],
        ],
        ..Mesh::default()
    };
    let curved = split_patches(&mut mesh, &[[0, 1, 2, 3], [0, 1, 2, 4]]).tessellate(1 << 20);
    assert_eq!(mesh.triangles.len(), 2);
    for i in 0..2 {
        let [a, b, c] = mesh.corners(i);
        assert!((b - a).cross(c - a).z > 0.0);
    }
    assert!(curved.triangles.len() > 100);
    // p = (2 u, v, u v), so z = x y / 2 and the normal is parallel to (-v, -2 u, 2).
    let diagonal = 6f32.sqrt();
    for i in 0..curved.triangles.len() as u32 {
        let [a, b, c] = curved.corners(i);
        for p in [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0] {
            assert!((p.z - p.x * p.y / 2.0).abs() < 1e-4 * diagonal, "{p}");
        }
        assert!((b - a).cross(c - a).z > 0.0);
    }
    for ((p, n), uv) in curved.positions.iter().zip(&curved.normals).zip(&curved.uvs) {
        let [u, v] = *uv;
        close(*p, [2.0 * u, v, u * v]);
        close(*n, Vec3::new(-v, -2.0 * u, 2.0).normalize().to_array());
    }
    // The number of triangles of many twisted patches is limited.
    let many = vec![[0, 1, 2, 4]; 600_000];
    let count = split_patches(&mut mesh, &many).tessellate(1 << 20).triangles.len();
    assert!((1_200_000..=1 << 22).contains(&count), "{count}");
}

#[test]
fn a_flat_patch_interpolates_twisted_texture_coordinates_and_normals_as_a_patch() {
    let square = Mesh {
        positions: [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [2.0, 1.0]]
            .map(|[x, y]| [x, y, 0.0])
            .into(),
        ..Mesh::default()
    };
    let mut twisted = square.clone();
    twisted.uvs = vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let curved = split_patches(&mut twisted, &[[0, 1, 2, 3]]);
    assert!(twisted.triangles.is_empty());
    for (u, v) in [(0.25, 0.5), (0.5, 0.5), (0.9, 0.2)] {
        let hit = Hit { u, v, ..Hit::MISS };
        let found = curved.derivatives(&Hit { primitive: 0, ..hit }).uv;
        let expected = Vec2::new(u + v - 2.0 * u * v, v);
        assert!((found - expected).length() < 1e-6, "{found} {expected}");
    }
    // An emitter keeps them, too.
    let emitter = curved.tessellate(1 << 20);
    for (p, uv) in emitter.positions.iter().zip(&emitter.uvs) {
        let [u, v] = [p[0] / 2.0, p[1]];
        assert!((uv[0] - (u + v - 2.0 * u * v)).abs() < 1e-5 && (uv[1] - v).abs() < 1e-5);
    }
    let mut bulged = square.clone();
    let up = Vec3::Z.to_array();
    bulged.normals = vec![up, up, up, Vec3::new(1.0, 1.0, 1.0).normalize().to_array()];
    assert_eq!(split_patches(&mut bulged, &[[0, 1, 2, 3]]).patches.len(), 1);
    // Straight ones are two triangles, however large they are.
    let mut straight = square;
    straight.uvs = straight.positions.iter().map(|p| [p[0] * 1000.0 + 7000.0, p[1]]).collect();
    straight.normals = vec![up; 4];
    assert!(split_patches(&mut straight, &[[0, 1, 2, 3]]).patches.is_empty());
}

fn area(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len() as u32).map(|i| f64::from(mesh.area(i))).sum()
}

/// Asserts that the winding of each triangle agrees with its normals.
fn assert_winding(mesh: &Mesh) {
    for (i, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(i as u32);
        let normal = corners.map(|v| Vec3::from(mesh.normals[v as usize])).iter().sum::<Vec3>();
        assert!((b - a).cross(c - a).dot(normal) > 0.0, "{i}");
    }
}

#[test]
fn a_straight_curve_has_the_area_of_its_cylinder_or_ribbon() {
    let control = [0.0, 1.0, 2.0, 3.0].map(|x| DVec3::new(x, 2.0 * x, -x));
    let length = 3.0 * 6f64.sqrt();
    let tube = CurveSegment { control, width: [0.2, 0.2], normals: None };
    assert!((area(&tessellate_curve(&[tube])) / (PI * 0.2 * length) - 1.0).abs() < 1e-5);
    assert_winding(&tessellate_curve(&[tube]));
    let up = DVec3::new(1.0, 0.0, 1.0).normalize();
    let ribbon = CurveSegment { control, width: [0.1, 0.5], normals: Some([up, up]) };
    let mesh = tessellate_curve(&[ribbon]);
    assert!((area(&mesh) / (0.3 * length) - 1.0).abs() < 1e-5);
    mesh.normals.iter().for_each(|n| close(*n, up.as_vec3().to_array()));
    assert_winding(&mesh);
}

#[test]
fn a_bent_curve_is_accurate_to_a_twentieth_of_its_width() {
    // A quarter of a circle of radius 1, to 3e-4 (Goldapp 1991).
    let k = 0.552_285;
    let control = [[1.0, 0.0], [1.0, k], [k, 1.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let mesh = tessellate_curve(&[CurveSegment { control, width: [0.02, 0.02], normals: None }]);
    assert!(mesh.triangles.len() <= 16 * 12);
    assert_winding(&mesh);
    for i in 0..mesh.triangles.len() as u32 {
        let middle = mesh.corners(i).iter().sum::<Vec3>() / 3.0;
        let from_axis = (middle.truncate().length() - 1.0).hypot(middle.z);
        assert!((0.007..0.0125).contains(&from_axis), "{from_axis}");
    }
}
