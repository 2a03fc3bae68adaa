//! Shapes of pbrt-v2 and v3 that become meshes: paraboloids, hyperboloids, NURBS and height fields.

use std::f64::consts::TAU;

use glam::{DVec3, DVec4};

use super::SceneError;
use super::memory::{MeshSize, require_memory};
use super::params::Params;
use petzval_scene::Mesh;

/// Cells around a whole turn: the distance from a circle is 8e-5 of its radius.
const CELLS_AROUND: f64 = 256.0;
/// Cells along the profile of a surface of revolution.
const CELLS_ALONG: u32 = 64;
/// Cells of a NURBS surface for each span of its knots, and for all of them.
const CELLS_A_SPAN: usize = 12;
const NURBS_CELLS: [usize; 2] = [32, 1024];
/// Highest order of a NURBS surface.
const MAX_ORDER: u32 = 32;
/// Most control points or heights on a side.
const MAX_SIDE: u32 = 1 << 15;

/// A point of a surface: position, derivatives by u and v, and texture coordinates.
struct GridPoint {
    position: DVec3,
    derivatives: [DVec3; 2],
    uv: [f64; 2],
}

/// Returns the mesh of a grid of cells. `at` returns the point of two fractions from 0 to 1.
fn grid(
    params: &Params,
    cells: [u32; 2],
    at: impl Fn([f64; 2]) -> GridPoint,
) -> Result<Mesh, SceneError> {
    let [columns, rows] = cells;
    let triangles = 2 * u64::from(columns) * u64::from(rows);
    let size = MeshSize { vertices: triangles, triangles };
    let _held = require_memory(params, &format!("{triangles} triangles"), size)?;
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let fraction = |i: u32, n: u32| f64::from(i) / f64::from(n);
            let point = at([fraction(column, columns), fraction(row, rows)]);
            let [du, dv] = point.derivatives;
            mesh.positions.push(point.position.as_vec3().to_array());
            mesh.normals.push(du.cross(dv).normalize_or_zero().as_vec3().to_array());
            mesh.uvs.push(point.uv.map(|v| v as f32));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let a = row * (columns + 1) + column;
            let c = a + columns + 1;
            mesh.triangles.extend([[a, a + 1, c + 1], [a, c + 1, c]]);
        }
    }
    Ok(mesh)
}

/// Returns the angle to which a surface of revolution extends (rad), and its cells.
fn turn(params: &Params) -> Result<(f64, [u32; 2]), SceneError> {
    let angle = params.positive("phimax", 360.0)?.min(360.0).to_radians();
    Ok((angle, [(CELLS_AROUND * angle / TAU).ceil().max(1.0) as u32, CELLS_ALONG]))
}

/// Makes a paraboloid about z with its apex at the origin.
pub(super) fn paraboloid(params: &Params) -> Result<Mesh, SceneError> {
    let radius = params.positive("radius", 1.0)?;
    let z = [params.float("zmin", 0.0)?, params.float("zmax", 1.0)?];
    let [low, high] = [z[0].min(z[1]).max(0.0), z[0].max(z[1])];
    if low >= high {
        let found = format!("a paraboloid from z = {} to {}", z[0], z[1]);
        return Err(params.refuse("zmax", found, "expected zmin below zmax, and zmax above 0"));
    }
    let (angle, cells) = turn(params)?;
    grid(params, cells, |[u, along]| {
        // Equal steps of the distance from the axis, relative to the rim.
        let inner = (low / high).sqrt();
        let r = inner + along * (1.0 - inner);
        let z = high * r * r;
        let (sin, cos) = (u * angle).sin_cos();
        let away = DVec3::new(cos, sin, 0.0);
        let around = DVec3::new(-sin, cos, 0.0);
        // The direction of the derivative along the profile, which is never 0.
        let profile = away * radius + DVec3::Z * (2.0 * high * r);
        GridPoint {
            position: away * (radius * r) + DVec3::Z * z,
            derivatives: [around, profile],
            uv: [u, (z - low) / (high - low)],
        }
    })
}

/// Makes the surface of revolution of a line about z.
pub(super) fn hyperboloid(params: &Params) -> Result<Mesh, SceneError> {
    let point = |name: &str, default: [f64; 3]| -> Result<DVec3, SceneError> {
        Ok(DVec3::from_array(params.triple(name)?.unwrap_or(default)))
    };
    let (p1, p2) = (point("p1", [0.0; 3])?, point("p2", [1.0; 3])?);
    let (angle, cells) = turn(params)?;
    grid(params, cells, |[u, v]| {
        let (sin, cos) = (u * angle).sin_cos();
        let turned = |p: DVec3| DVec3::new(p.x * cos - p.y * sin, p.x * sin + p.y * cos, p.z);
        let position = turned(p1.lerp(p2, v));
        // On the axis, the direction around it is that of a point close by.
        let beside = turned(p1.lerp(p2, v.clamp(1e-6, 1.0 - 1e-6)));
        let around = DVec3::new(-beside.y, beside.x, 0.0);
        GridPoint { position, derivatives: [around, turned(p2 - p1)], uv: [u, v] }
    })
}

/// Returns the numbers of control points or heights along u and v, and those of a parameter with
/// `each` numbers a point.
fn lattice<'a>(
    params: &'a Params,
    values: &str,
    kinds: &[&'static str],
    each: usize,
) -> Result<([usize; 2], &'a [f64]), SceneError> {
    let count = |name: &str| -> Result<usize, SceneError> {
        let Some(count) = params.count(name, MAX_SIDE)? else {
            let found = format!("a lattice without \"integer {name}\"");
            return Err(params.refuse(name, found, "expected its number of points on a side"));
        };
        Ok(count as usize)
    };
    let sides = [count("nu")?, count("nv")?];
    let numbers = params.numbers(values, kinds)?.unwrap_or(&[]);
    if numbers.len() != each * sides[0] * sides[1] {
        let found = format!("{} numbers in \"{values}\"", numbers.len());
        let expected = format!("expected {each} for each of {} x {} points", sides[0], sides[1]);
        return Err(params.refuse(values, found, expected));
    }
    Ok((sides, numbers))
}

/// Makes a height field over the unit square.
pub(super) fn height_field(params: &Params) -> Result<Mesh, SceneError> {
    let ([nu, nv], heights) = lattice(params, "Pz", &["float"], 1)?;
    if nu < 2 || nv < 2 {
        let found = format!("a height field of {nu} x {nv} points");
        return Err(params.refuse("nu", found, "expected 2 or more on each side"));
    }
    let mut mesh = grid(params, [nu as u32 - 1, nv as u32 - 1], |[u, v]| GridPoint {
        position: DVec3::new(u, v, 0.0),
        derivatives: [DVec3::X, DVec3::Y],
        uv: [u, v],
    })?;
    mesh.normals.clear();
    mesh.positions.iter_mut().zip(heights).for_each(|(p, &height)| p[2] = height as f32);
    Ok(mesh)
}

/// The order and the knots of a NURBS surface along one parameter, and its limits.
struct Knots<'a> {
    order: usize,
    knots: &'a [f64],
    limits: [f64; 2],
}

impl<'a> Knots<'a> {
    /// Reads the parameters whose names begin with `axis`, for so many control points.
    fn read(params: &'a Params, axis: &str, points: usize) -> Result<Self, SceneError> {
        let name = format!("{axis}order");
        let Some(order) = params.count(&name, MAX_ORDER)?.map(|order| order as usize) else {
            let found = format!("a nurbs without \"integer {name}\"");
            return Err(params.refuse(&name, found, "expected the degree plus 1"));
        };
        let name = format!("{axis}knots");
        let knots = params.numbers(&name, &["float"])?.unwrap_or(&[]);
        let ascend = knots.windows(2).all(|pair| pair[0] <= pair[1]);
        if order < 2 || points < order || knots.len() != points + order || !ascend {
            let found = format!("{} knots of order {order} for {points} points", knots.len());
            let expected = format!(
                "expected {} that never descend, and an order of 2 to the points",
                points + order
            );
            return Err(params.refuse(&name, found, expected));
        }
        let valid = [knots[order - 1], knots[points]];
        let limits = [
            params.float(&format!("{axis}0"), valid[0])?,
            params.float(&format!("{axis}1"), valid[1])?,
        ];
        if !(valid[0] <= limits[0] && limits[0] < limits[1] && limits[1] <= valid[1]) {
            let found = format!("a nurbs from {axis} = {} to {}", limits[0], limits[1]);
            let expected = format!("expected limits from {} to {}", valid[0], valid[1]);
            return Err(params.refuse(&name, found, expected));
        }
        Ok(Self { order, knots, limits })
    }

    fn at(&self, fraction: f64) -> f64 {
        let [low, high] = self.limits;
        low + fraction * (high - low)
    }

    fn cells(&self) -> u32 {
        let [least, most] = NURBS_CELLS;
        let spans = self.knots.len() - 2 * self.order + 1;
        spans.saturating_mul(CELLS_A_SPAN).clamp(least, most) as u32
    }

    /// Returns the point of a B-spline and its derivative (de Boor 1972). `control` returns a control
    /// point.
    fn evaluate(&self, t: f64, control: impl Fn(usize) -> DVec4) -> [DVec4; 2] {
        let (degree, last) = (self.order - 1, self.knots.len() - self.order - 1);
        let above = self.knots.partition_point(|&knot| knot <= t);
        let mut span = above.saturating_sub(1).clamp(degree, last);
        // The end belongs to the last span that is not empty.
        while span > degree && self.knots[span] >= self.knots[span + 1] {
            span -= 1;
        }
        let mut points: Vec<DVec4> = (0..=degree).map(|j| control(j + span - degree)).collect();
        let mut slope = DVec4::ZERO;
        for level in 1..=degree {
            if level == degree {
                let width = self.knots[span + 1] - self.knots[span];
                slope = (points[degree] - points[degree - 1]) * (degree as f64 / width);
            }
            for j in (level..=degree).rev() {
                let low = self.knots[j + span - degree];
                let width = self.knots[j + 1 + span - level] - low;
                let share = if width > 0.0 { (t - low) / width } else { 0.0 };
                points[j] = points[j - 1].lerp(points[j], share);
            }
        }
        [points[degree], slope]
    }
}

/// Makes a NURBS surface. Its texture coordinates are its parameters.
pub(super) fn nurbs(params: &Params) -> Result<Mesh, SceneError> {
    let is_rational = params.find("Pw").is_some();
    let (values, kinds, each): (_, &[&str], _) = match is_rational {
        true => ("Pw", &["float"], 4),
        false => ("P", &["point3"], 3),
    };
    let ([nu, nv], numbers) = lattice(params, values, kinds, each)?;
    let (u_knots, v_knots) = (Knots::read(params, "u", nu)?, Knots::read(params, "v", nv)?);
    let weights = numbers.as_chunks::<4>().0.iter().map(|point| point[3]);
    if is_rational && !weights.into_iter().all(|weight| weight > 0.0) {
        return Err(params.refuse("Pw", "a weight that is not positive", "expected more than 0"));
    }
    let control = |i: usize, j: usize| match numbers[each * (j * nu + i)..][..each] {
        [x, y, z, w] => DVec4::new(x, y, z, w),
        [x, y, z] => DVec4::new(x, y, z, 1.0),
        _ => DVec4::ZERO,
    };
    grid(params, [u_knots.cells(), v_knots.cells()], |[u, v]| {
        let (u, v) = (u_knots.at(u), v_knots.at(v));
        let along_u = |j: usize| u_knots.evaluate(u, |i| control(i, j));
        let [point, by_v] = v_knots.evaluate(v, |j| along_u(j)[0]);
        let [by_u, _] = v_knots.evaluate(v, |j| along_u(j)[1]);
        let position = point.truncate() / point.w;
        let slope = |by: DVec4| (by.truncate() - position * by.w) / point.w;
        GridPoint { position, derivatives: [slope(by_u), slope(by_v)], uv: [u, v] }
    })
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use petzval_scene::Geometry;

    fn mesh(shape: &str) -> Mesh {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.pbrt");
        std::fs::write(&path, format!("WorldBegin\nShape {shape}")).expect("a file");
        let description = crate::pbrt::read(&path).expect(shape);
        assert!(description.warnings.is_empty(), "{:#?}", description.warnings);
        match &description.scene.shapes[0].geometry {
            Geometry::Mesh(mesh) => mesh.clone(),
            _ => panic!("{shape}"),
        }
    }

    fn area(mesh: &Mesh) -> f64 {
        (0..mesh.triangles.len() as u32).map(|i| f64::from(mesh.area(i))).sum()
    }

    /// Asserts that the normals are those of the triangles.
    fn assert_normals(mesh: &Mesh) {
        for (i, corners) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.corners(i as u32);
            let Some(flat) = (b - a).cross(c - a).try_normalize() else { continue };
            for &corner in corners {
                let normal = Vec3::from(mesh.normals[corner as usize]);
                assert!(normal.dot(flat) > 0.99, "{i}: {normal} {flat}");
            }
        }
    }

    #[test]
    fn a_paraboloid_has_its_area_and_faces_outwards() {
        let bowl = mesh("\"paraboloid\" \"float radius\" 2 \"float zmax\" 3");
        // pi r / (6 h^2) ((r^2 + 4 h^2)^(3/2) - r^3)
        let exact = std::f64::consts::PI * 2.0 / 54.0 * (40f64.powf(1.5) - 8.0);
        assert!((area(&bowl) / exact - 1.0).abs() < 2e-4, "{} {exact}", area(&bowl));
        assert_normals(&bowl);
        let part = mesh("\"paraboloid\" \"float zmin\" 0.25 \"float phimax\" 90");
        for (p, uv) in part.positions.iter().zip(&part.uvs) {
            let [x, y, z] = *p;
            assert!((x * x + y * y - z).abs() < 1e-5 && x > -1e-6 && y > -1e-6);
            assert!((uv[1] - (z - 0.25) / 0.75).abs() < 1e-5);
        }
        assert_normals(&part);
    }

    #[test]
    fn a_hyperboloid_is_swept_by_its_line() {
        let cone = mesh("\"hyperboloid\" \"point3 p1\" [0 0 0] \"point3 p2\" [1 0 1]");
        let exact = std::f64::consts::PI * 2f64.sqrt();
        assert!((area(&cone) / exact - 1.0).abs() < 2e-4, "{}", area(&cone));
        assert_normals(&cone);
        let waist = mesh("\"hyperboloid\" \"point3 p1\" [1 -1 -1] \"point3 p2\" [1 1 1]");
        for [x, y, z] in &waist.positions {
            assert!((x * x + y * y - z * z - 1.0).abs() < 1e-5);
        }
        assert_normals(&waist);
    }

    #[test]
    fn a_height_field_has_its_heights() {
        let field =
            mesh("\"heightfield\" \"integer nu\" 3 \"integer nv\" 2 \"float Pz\" [0 1 2 3 4 5]");
        assert_eq!(field.positions[4], [0.5, 1.0, 4.0]);
        assert_eq!(field.uvs[4], [0.5, 1.0]);
        assert_eq!(field.triangles[0], [0, 1, 4]);
        assert_eq!(field.triangles.len(), 4);
    }

    #[test]
    fn a_rational_surface_is_a_cylinder() {
        let h = 0.5f64.sqrt();
        // A quarter of a circle in u, a line in v.
        let points = format!(
            "1 0 0 1  {h} {h} 0 {h}  0 1 0 1  1 0 2 1  {h} {h} {h2} {h}  0 1 2 1",
            h2 = 2.0 * h
        );
        let cylinder = mesh(&format!(
            "\"nurbs\" \"integer nu\" 3 \"integer uorder\" 3 \"float uknots\" [0 0 0 1 1 1] \
             \"integer nv\" 2 \"integer vorder\" 2 \"float vknots\" [0 0 1 1] \"float Pw\" [{points}]"
        ));
        for ([x, y, _], n) in cylinder.positions.iter().zip(&cylinder.normals) {
            assert!((x.hypot(*y) - 1.0).abs() < 1e-6);
            assert!((Vec3::from(*n) - Vec3::new(*x, *y, 0.0)).length() < 1e-5, "{n:?}");
        }
        assert!((area(&cylinder) - std::f64::consts::PI).abs() < 1e-3);
    }

    #[test]
    fn wrong_lattices_are_errors_with_their_place() {
        let nurbs = "Shape \"nurbs\" \"integer nu\" 2 \"integer nv\" 2 \"integer uorder\" 2 \
            \"integer vorder\" 2 \"float vknots\" [0 0 1 1] \"point3 P\" [0 0 0 1 0 0 0 1 0 1 1 0]";
        for shape in [
            "Shape \"heightfield\" \"integer nu\" 3 \"integer nv\" 2 \"float Pz\" [0 1 2]"
                .to_owned(),
            "Shape \"heightfield\" \"integer nu\" 1 \"integer nv\" 1 \"float Pz\" [0]".to_owned(),
            "Shape \"heightfield\" \"float Pz\" [0]".to_owned(),
            "Shape \"paraboloid\" \"float zmax\" -1".to_owned(),
            format!("{nurbs} \"float uknots\" [0 0 1]"),
            format!("{nurbs} \"float uknots\" [0 1 0 1]"),
            format!("{nurbs} \"float uknots\" [1 1 1 1]"),
            format!("{nurbs} \"float uknots\" [0 0 1 1] \"float u1\" 2"),
        ] {
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join("a.pbrt");
            std::fs::write(&path, format!("WorldBegin\n{shape}")).expect("a file");
            let message = crate::pbrt::read(&path).map(|_| ()).expect_err(&shape).to_string();
            assert!(message.contains("a.pbrt:2:") && message.contains("expected"), "{message}");
        }
    }
}
