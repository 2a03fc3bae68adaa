//! Triangulation of polygons in space.

use earcut::Earcut;
use glam::{DVec2, DVec3, Vec3};

use petzval_scene::Mesh;

/// Limit of the corners of a convex polygon that becomes a fan, as in most programs.
const MAX_FAN_CORNERS: usize = 16;
/// Cross product of the edges at a reflex corner relative to the area vector of the polygon. Below it,
/// the corner is straight to the rounding of its file.
const REFLEX: f64 = 1e-6;

/// A polygon of five or more corners, which takes the place of a fan in a mesh until all vertices are
/// read.
pub(super) struct Polygon {
    /// Index of the first triangle of the fan.
    start: usize,
    /// Number of triangles.
    count: usize,
}

impl Polygon {
    /// Adds a polygon to the triangles of a mesh, as a fan.
    pub(super) fn add_fan(corners: &[u32], triangles: &mut Vec<[u32; 3]>) -> Option<Self> {
        let [first, rest @ ..] = corners else { return None };
        let start = triangles.len();
        triangles.extend(rest.windows(2).map(|edge| [*first, edge[0], edge[1]]));
        let count = triangles.len() - start;
        (count > 2).then_some(Self { start, count })
    }
}

/// The corners of a polygon in the plane of its area vector.
struct Projection {
    points: Vec<[f64; 2]>,
    /// Index of the first reflex corner, and the number of reflex corners.
    reflex: (usize, usize),
}

impl Projection {
    /// Projects corners along their area vector (Newell's method). Returns `None` if they are not
    /// finite or have no area.
    fn new(positions: &[[f32; 3]], corners: &[u32]) -> Option<Self> {
        let at = |corner: u32| Vec3::from(positions[corner as usize]).as_dvec3();
        let origin = at(*corners.first()?);
        let next = |i: usize| if i + 1 < corners.len() { i + 1 } else { 0 };
        let edge = |i: usize| [at(corners[i]) - origin, at(corners[next(i)]) - origin];
        let area: DVec3 = (0..corners.len()).map(edge).map(|[p, q]| p.cross(q)).sum();
        let normal = area.try_normalize()?;
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        let points: Vec<DVec2> = corners
            .iter()
            .map(|&corner| at(corner) - origin)
            .map(|p| DVec2::new(p.dot(x), p.dot(y)))
            .collect();
        if !points.iter().all(|p| p.is_finite()) {
            return None;
        }
        let mut reflex = (0, 0);
        for i in 0..points.len() {
            let [before, here, after] = [i, next(i), next(next(i))].map(|i| points[i]);
            if (here - before).perp_dot(after - here) < -REFLEX * area.length() {
                reflex = if reflex.1 == 0 { (next(i), 1) } else { (reflex.0, reflex.1 + 1) };
            }
        }
        Some(Self { points: points.iter().map(DVec2::to_array).collect(), reflex })
    }
}

/// Returns the two triangles of a quad with one reflex corner, which a diagonal from that corner
/// splits, or `None` for all other quads. Corners run around the quad.
pub(super) fn split_concave_quad(positions: &[[f32; 3]], quad: [u32; 4]) -> Option<[[u32; 3]; 2]> {
    let (reflex, 1) = Projection::new(positions, &quad)?.reflex else { return None };
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| quad[(reflex + i) & 3]);
    Some([[a, b, c], [a, c, d]])
}

/// Replaces the fans of concave polygons by triangles that cover the polygons, and fans of many
/// corners by triangles that are not slivers. Triangles keep the direction of the polygon.
pub(super) fn triangulate(mesh: &mut Mesh, polygons: &[Polygon]) {
    let mut earcut = Earcut::new();
    let (mut corners, mut triangles, mut ears) = (Vec::new(), Vec::new(), Vec::new());
    let mut is_shorter = false;
    for polygon in polygons {
        let fan = &mut mesh.triangles[polygon.start..][..polygon.count];
        let [first, second, _] = fan[0];
        corners.clear();
        corners.extend([first, second]);
        corners.extend(fan.iter().map(|triangle| triangle[2]));
        triangles.clear();
        match Projection::new(&mesh.positions, &corners) {
            Some(Projection { points, reflex: (_, 1..) }) => {
                earcut.earcut_slice::<u32>(&points, &[], &mut ears);
                for ear in ears.as_chunks::<3>().0 {
                    let [a, b, c] = ear.map(|i| DVec2::from_array(points[i as usize]));
                    let [i, j, k] = ear.map(|i| corners[i as usize]);
                    let turns_left = (b - a).perp_dot(c - a) >= 0.0;
                    triangles.push(if turns_left { [i, j, k] } else { [i, k, j] });
                }
            }
            _ if corners.len() > MAX_FAN_CORNERS => bisect(&corners, &mut triangles),
            _ => continue,
        }
        // A polygon without an area stays a fan.
        if triangles.is_empty() || triangles.len() > fan.len() {
            continue;
        }
        is_shorter |= triangles.len() < fan.len();
        let (kept, rest) = fan.split_at_mut(triangles.len());
        kept.copy_from_slice(&triangles);
        rest.fill(NONE);
    }
    if is_shorter {
        mesh.triangles.retain(|triangle| *triangle != NONE);
    }
}

/// The place of a triangle that a polygon does not need.
const NONE: [u32; 3] = [u32::MAX; 3];

/// Bisects a convex polygon until triangles are left. A fan of many corners would consist of slivers
/// with overlapping bounds, which make the tree slow to build and to traverse.
fn bisect(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let mut todo = vec![corners];
    while let Some(part) = todo.pop() {
        let [first, .., last] = *part else { continue };
        let middle = part.len() / 2;
        if part.len() > 2 {
            triangles.push([first, part[middle], last]);
            todo.extend([&part[middle..], &part[..=middle]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the triangles of a polygon in the plane, and the sum of their areas in its direction.
    fn triangles(points: &[DVec2]) -> (Mesh, f64) {
        let positions = points.iter().map(|p| p.extend(0.0).as_vec3().to_array()).collect();
        let mut mesh = Mesh { positions, ..Mesh::default() };
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        let polygon = Polygon::add_fan(&corners, &mut mesh.triangles);
        triangulate(&mut mesh, &polygon.into_iter().collect::<Vec<_>>());
        let area = |&[a, b, c]: &[u32; 3]| {
            let at = |i: u32| points[i as usize];
            (at(b) - at(a)).perp_dot(at(c) - at(a)) / 2.0
        };
        let sum = mesh.triangles.iter().map(|t| area(t).abs()).sum::<f64>();
        let direction = mesh.triangles.iter().map(area).sum::<f64>().signum();
        (mesh, sum * direction)
    }

    fn area(points: &[DVec2]) -> f64 {
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|(p, q)| p.perp_dot(*q) / 2.0).sum()
    }

    /// Returns a comb of so many teeth: a concave polygon of four corners a tooth.
    fn comb(teeth: u32) -> Vec<DVec2> {
        let mut points: Vec<DVec2> = (0..teeth)
            .flat_map(|i| [[0.0, 1.0], [0.4, 1.0], [0.4, 0.1], [1.0, 0.1]].map(|p| (i, p)))
            .map(|(i, [x, y])| DVec2::new(f64::from(i) + x, y))
            .collect();
        points.extend([DVec2::new(f64::from(teeth), 0.0), DVec2::ZERO]);
        points.reverse();
        points
    }

    #[test]
    fn concave_polygons_have_their_area_whatever_the_first_corner_and_the_direction() {
        let arrow = [[-1.0, -1.0], [0.0, -0.5], [1.0, 0.0], [-1.0, 1.0], [-0.5, 0.0]];
        for mut points in [arrow.map(DVec2::from_array).to_vec(), comb(7)] {
            for _ in 0..2 {
                for _ in 0..points.len() {
                    points.rotate_left(1);
                    let (found, expected) = (triangles(&points).1, area(&points));
                    assert!((found - expected).abs() < 1e-5, "{found} of {expected}");
                }
                points.reverse();
            }
        }
    }

    #[test]
    fn a_concave_polygon_of_sixty_thousand_corners_takes_no_quadratic_time() {
        let points = comb(15_000);
        let clock = std::time::Instant::now();
        let (mesh, found) = triangles(&points);
        assert!((found / area(&points) - 1.0).abs() < 1e-5);
        assert_eq!(mesh.triangles.len(), points.len() - 2);
        assert!(clock.elapsed().as_secs() < 10, "{:?}", clock.elapsed());
    }

    #[test]
    fn a_convex_polygon_of_many_corners_becomes_triangles_of_its_own_area() {
        let at = |i: u32| DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 1000.0);
        let points: Vec<DVec2> = (0..1000).map(at).collect();
        let (mesh, found) = triangles(&points);
        assert_eq!(mesh.triangles.len(), 998);
        assert!((found - area(&points)).abs() < 1e-9);
        // Of a fan, each would be as long as the polygon.
        let short = mesh.triangles.iter().filter(|t| at(t[0]).distance(at(t[2])) < 0.1).count();
        assert!(short > 800, "{short}");
    }

    #[test]
    fn polygons_without_an_area_stay_fans() {
        for point in [DVec2::ZERO, DVec2::NAN, DVec2::INFINITY] {
            assert_eq!(triangles(&[point; 6]).0.triangles.len(), 4);
            assert_eq!(triangles(&[point; 20]).0.triangles.len(), 18);
        }
    }
}
