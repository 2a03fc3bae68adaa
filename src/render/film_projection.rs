//! Projection of points in camera space onto the picture.

use glam::{DAffine3, DVec2, DVec3, Vec3};

use petzval_base::plane_newton::PlaneNewton;
use petzval_base::rays::{RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;
use petzval_lens::{Camera, LensColumns, LensModel, RealLens, SphericalMapping};

/// Nodes of the grid of central rays along each axis: an odd number, so that one lies in the middle.
const NODES: usize = 129;
/// Length of the grid, relative to the film.
const REACH: f64 = 1.02;
/// Largest angle of a direction that is searched for, relative to that of the corners.
const BEYOND: f64 = 1.5;
/// Search for the pixel of a direction: steps in pixels, values in radians.
const SEARCH: PlaneNewton = PlaneNewton { difference: 0.125, precision: 1e-8, acceptable: 1e-5 };

/// Map from points in camera space to their images in the picture. For a real lens it is measured by central rays, so it
/// includes distortion, fisheye and anamorphic projections, and the pose of the film.
#[derive(Clone, Debug)]
pub(crate) struct FilmProjection {
    model: Model,
    /// Width and height of the film, in the unit of the model.
    film: [f64; 2],
    resolution: [f64; 2],
}

#[derive(Clone, Debug)]
enum Model {
    /// Perspective: the middle of the picture in the plane z = 1.
    Plane([f64; 2]),
    /// Parallel rays: the middle of the picture in the plane z = 0.
    Parallel([f64; 2]),
    /// All directions.
    Sphere(SphericalMapping),
    /// Measured rays.
    Rays(CentralRays),
}

impl FilmProjection {
    pub fn of(camera: &Camera, resolution: [u32; 2]) -> Self {
        let model = match &camera.model {
            LensModel::Thin(lens) => Model::Plane(lens.middle),
            LensModel::Orthographic(parallel) => Model::Parallel(parallel.middle),
            LensModel::Spherical(mapping) => Model::Sphere(*mapping),
            LensModel::Real(lens) => Model::Rays(CentralRays::trace(camera, lens)),
        };
        Self { model, film: camera.film, resolution: resolution.map(f64::from) }
    }

    /// Returns the image of a point [pixels from the upper left corner, x to the right, y down], which may lie beyond the
    /// film; `None` for points behind the camera, and for directions far beyond those that a lens images. The search for a
    /// real lens is short from a pixel near by.
    pub fn pixel(&self, point: DVec3, near: Option<[f64; 2]>) -> Option<[f64; 2]> {
        // Coordinates on the upright film, x to the right and y up.
        let film = match &self.model {
            Model::Plane(_) | Model::Parallel(_) if point.z <= 0.0 => return None,
            Model::Plane([x, y]) => [point.x / point.z - x, point.y / point.z - y],
            Model::Parallel([x, y]) => [point.x - x, point.y - y],
            Model::Sphere(mapping) => {
                let at = mapping.point(point.as_vec3().normalize_or(Vec3::Z)).as_dvec2();
                [at.x - 0.5, 0.5 - at.y]
            }
            Model::Rays(rays) => {
                let share = |pixel: [f64; 2]| [0, 1].map(|i| pixel[i] / self.resolution[i]);
                let guess = rays.estimate(point)?;
                let start = near.unwrap_or([0, 1].map(|i| guess[i] * self.resolution[i]));
                return SEARCH.solve(start, |pixel| Some(rays.angles_off(point, share(pixel))));
            }
        };
        let share = [0.5 + film[0] / self.film[0], 0.5 - film[1] / self.film[1]];
        Some([0, 1].map(|i| share[i] * self.resolution[i]))
    }

    /// Returns whether all pixels see along the same direction.
    pub fn is_parallel(&self) -> bool {
        matches!(self.model, Model::Parallel(_))
    }

    /// Returns the displacement from an image of a point to another (pixels). A picture of all directions continues
    /// beyond its edges, and the shortest displacement counts.
    pub fn displacement(&self, from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
        let [width, height] = self.resolution;
        let [x, y] = to;
        let beyond: &[[f64; 2]] = match self.model {
            Model::Sphere(SphericalMapping::Equirectangular) => &[[x - width, y], [x + width, y]],
            // Each edge is folded about its middle (Clarberg 2008).
            Model::Sphere(SphericalMapping::EqualArea) => &[
                [-x, height - y],
                [2.0 * width - x, height - y],
                [width - x, -y],
                [width - x, 2.0 * height - y],
            ],
            _ => &[],
        };
        let to = |[x, y]: [f64; 2]| [x - from[0], y - from[1]];
        let length = |[x, y]: [f64; 2]| x.hypot(y);
        let shorter = |a, b: &[f64; 2]| if length(to(*b)) < length(a) { to(*b) } else { a };
        beyond.iter().fold(to([x, y]), shorter)
    }

    /// Returns whether a point of the picture is on the film.
    pub fn is_on_film(&self, pixel: [f64; 2]) -> bool {
        (0..2).all(|i| (0.0..=self.resolution[i]).contains(&pixel[i]))
    }
}

/// The central rays of points on a grid over the film.
#[derive(Clone, Debug)]
struct CentralRays {
    /// Middle of the entrance pupil.
    pupil: DVec3,
    /// Row after row of the picture.
    nodes: Vec<CentralRay>,
    /// Change of the angles by the share of the film in its middle.
    slope: DVec2,
    /// Largest angle of a direction that is searched for.
    widest: f64,
}

/// A central ray in coordinates that change smoothly over the film.
#[derive(Clone, Copy, Debug, Default)]
struct CentralRay {
    /// Angle from the axis (radians) along the projection of the direction on the film.
    angles: DVec2,
    /// Point nearest to the middle of the entrance pupil, relative to it.
    foot: DVec3,
}

impl CentralRays {
    fn trace(camera: &Camera, lens: &RealLens) -> Self {
        let pupil = lens.front_depth - lens.paraxial.entrance_pupil.position * lens.units_per_mm;
        let pupil = DVec3::Z * if pupil.is_finite() { pupil } else { lens.front_depth };
        let mut nodes = traced(camera, pupil);
        // Where the lens blocks the ray in the middle, first-order optics replace it.
        let focal_length = lens.paraxial.focal_length.abs();
        let paraxial = |[column, row]: [usize; 2]| {
            let [x, y] = [column, row].map(|place| share(place) - 0.5);
            let [x, y] = [x * camera.film[0], -y * camera.film[1]];
            CentralRay { angles: angles(DVec3::new(x, y, focal_length)), foot: DVec3::ZERO }
        };
        let middle = (NODES - 1) / 2;
        for ring in 0..=middle {
            for [column, row] in ring_places(middle, ring) {
                let place = row * NODES + column;
                if nodes[place].is_none() {
                    let continued = continued(&nodes, [column, row], ring);
                    nodes[place] = Some(continued.unwrap_or_else(|| paraxial([column, row])));
                }
            }
        }
        let nodes: Vec<_> = nodes.into_iter().map(Option::unwrap_or_default).collect();
        let step = REACH / (NODES - 1) as f64;
        let here = middle * NODES + middle;
        let slope = |next: usize| (nodes[here + next].angles - nodes[here].angles) / step;
        let slope = DVec2::new(slope(1).x, slope(NODES).y);
        let widest = nodes.iter().map(|ray| ray.angles.length()).fold(0.0, f64::max);
        Self { pupil, nodes, slope, widest: BEYOND * widest }
    }

    /// Returns the place on the film of a point by the magnification in the middle, in shares; `None` for directions far
    /// beyond those of the corners.
    fn estimate(&self, point: DVec3) -> Option<[f64; 2]> {
        let direction = angles(point - self.pupil);
        let inside = direction.length() <= self.widest;
        inside.then(|| (direction / self.slope + 0.5).to_array())
    }

    /// Returns the angles between the direction of a point and the ray of a place on the film, given as shares of its
    /// width and height from the upper left corner.
    fn angles_off(&self, point: DVec3, film: [f64; 2]) -> [f64; 2] {
        let at = film.map(|share| ((share - 0.5) / REACH + 0.5) * (NODES - 1) as f64);
        // The outermost cells continue beyond the grid.
        let low = at.map(|at| (at.floor().max(0.0) as usize).min(NODES - 2));
        let [u, v] = [0, 1].map(|i| at[i] - low[i] as f64);
        let first = low[1] * NODES + low[0];
        let [a, b, c, d] = [0, 1, NODES, NODES + 1].map(|step| self.nodes[first + step]);
        let ray = a.between(&b, u).between(&c.between(&d, u), v);
        (angles(point - self.pupil - ray.foot) - ray.angles).to_array()
    }
}

impl CentralRay {
    fn between(&self, other: &Self, share: f64) -> Self {
        Self {
            angles: self.angles.lerp(other.angles, share),
            foot: self.foot.lerp(other.foot, share),
        }
    }
}

/// Returns the place of a column or row of nodes, as a share of the film.
fn share(node: usize) -> f64 {
    (node as f64 / (NODES - 1) as f64 - 0.5) * REACH + 0.5
}

/// Returns the angle of a direction from the axis (radians) along its projection on the film.
fn angles(direction: DVec3) -> DVec2 {
    let across = direction.truncate();
    let length = across.length();
    if length > 0.0 { across * (length.atan2(direction.z) / length) } else { DVec2::ZERO }
}

/// Traces the central rays of all nodes, row after row. A node whose ray is blocked has none.
fn traced(camera: &Camera, pupil: DVec3) -> Vec<Option<CentralRay>> {
    let camera = Camera { world_from_camera: DAffine3::IDENTITY, ..camera.clone() };
    let mut nodes = vec![None; NODES * NODES];
    let mut samples = SampleBatch::default();
    let (mut columns, mut rays) = (LensColumns::default(), RayBatch::default());
    let mut stats = LensStats::default();
    let map = camera.film_map([1, 1]);
    for first in (0..nodes.len()).step_by(WAVE_SIZE) {
        samples.len = WAVE_SIZE.min(nodes.len() - first);
        for i in 0..samples.len {
            let place = first + i;
            let film = map.film_point([place % NODES, place / NODES].map(share));
            (samples.film[0][i], samples.film[1][i]) = (film[0] as f32, film[1] as f32);
            // A sample of the fan, not of the rear element, at its centre.
            (samples.pupil[0][i], samples.pupil[1][i]) = (0.5, 0.0);
        }
        camera.generate_rays::<f32>(&samples, &mut columns, &mut rays, &mut stats);
        for i in 0..rays.len {
            let ray = rays.ray(i);
            let [origin, direction] =
                [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
            let to = origin - pupil;
            let foot = to - direction * (to.dot(direction) / direction.length_squared());
            nodes[first + rays.slot[i] as usize] =
                Some(CentralRay { angles: angles(direction), foot });
        }
    }
    nodes
}

/// Returns the places of a square ring of nodes about the middle: column and row.
fn ring_places(middle: usize, ring: usize) -> impl Iterator<Item = [usize; 2]> {
    let (low, high) = (middle - ring, middle + ring);
    (low..=high).flat_map(move |row| {
        let step = if row == low || row == high || ring == 0 { 1 } else { 2 * ring };
        (low..=high).step_by(step).map(move |column| [column, row])
    })
}

/// Returns the ray of a node that continues those of the two rings within, along the line to the middle; `None` if
/// they are not known.
fn continued(nodes: &[Option<CentralRay>], place: [usize; 2], ring: usize) -> Option<CentralRay> {
    let middle = (NODES - 1) as f64 / 2.0;
    let within = |rings: usize| -> Option<CentralRay> {
        let scale = ring.checked_sub(rings)? as f64 / ring as f64;
        let at = place.map(|node| middle + (node as f64 - middle) * scale);
        let low = at.map(|at| at.floor().min((NODES - 2) as f64));
        let [u, v] = [0, 1].map(|i| at[i] - low[i]);
        let first = low[1] as usize * NODES + low[0] as usize;
        // A node with weight 0 may be on the ring itself, unknown.
        let blend = |a: Option<CentralRay>, b: Option<CentralRay>, share: f64| match share {
            0.0 => a,
            1.0 => b,
            _ => Some(a?.between(&b?, share)),
        };
        blend(
            blend(nodes[first], nodes[first + 1], u),
            blend(nodes[first + NODES], nodes[first + NODES + 1], u),
            v,
        )
    };
    let (near, far) = (within(1)?, within(2)?);
    Some(far.between(&near, 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_directions_are_near_on_pictures_of_all_directions() {
        for mapping in [SphericalMapping::EqualArea, SphericalMapping::Equirectangular] {
            let resolution = [400.0; 2];
            let projection =
                FilmProjection { model: Model::Sphere(mapping), film: [1.0; 2], resolution };
            let mut across = 0;
            // Meridians meet in the poles.
            let steepest = if mapping == SphericalMapping::EqualArea { 60.0 } else { 0.9 };
            for i in 0..40_000 {
                // A spiral over the sphere.
                let y = steepest * (1.0 - f64::from(i) / 20_000.0);
                let (sin, cos) = (f64::from(i) * 2.4).sin_cos();
                let direction = DVec3::new(cos, y, sin).normalize();
                let side = if i % 2 == 0 { 0.01 } else { -0.01 };
                let near = (direction + side * DVec3::new(sin, 0.7, -cos)).normalize();
                let [from, to] = [direction, near].map(|point| projection.pixel(point, None));
                let (from, to) = (from.expect("a pixel"), to.expect("a pixel"));
                let [x, y] = projection.displacement(from, to);
                assert!(x.hypot(y) < 4.0, "{mapping:?}: {direction}: {from:?} to {to:?}");
                across += u32::from((to[0] - from[0]).hypot(to[1] - from[1]) > 20.0);
            }
            assert!(across > 20, "{mapping:?}: {across} pairs on two sides of an edge");
        }
    }

    #[test]
    fn an_edge_of_an_equal_area_picture_continues_turned_about_its_middle() {
        let resolution = [400.0, 200.0];
        let model = Model::Sphere(SphericalMapping::EqualArea);
        let projection = FilmProjection { model, film: [1.0; 2], resolution };
        for (from, to, expected) in [
            ([100.0, 3.0], [301.0, 2.0], [-1.0, -5.0]),
            ([100.0, 197.0], [301.0, 198.0], [-1.0, 5.0]),
            ([3.0, 50.0], [2.0, 149.0], [-5.0, 1.0]),
            ([397.0, 50.0], [398.0, 149.0], [5.0, 1.0]),
        ] {
            assert_eq!(projection.displacement(from, to), expected);
        }
    }

    #[test]
    fn rings_cover_the_grid_once() {
        let middle = (NODES - 1) / 2;
        let mut seen = vec![0; NODES * NODES];
        let places = (0..=middle).flat_map(|ring| ring_places(middle, ring));
        places.for_each(|[column, row]| seen[row * NODES + column] += 1);
        assert!(seen.iter().all(|&n| n == 1));
    }

    #[test]
    fn blocked_rays_continue_those_within() {
        let linear = |[column, row]: [usize; 2]| CentralRay {
            angles: DVec2::new(column as f64, 2.0 * row as f64),
            foot: DVec3::new(0.0, column as f64 - row as f64, 1.0),
        };
        let place = |i: usize| [i % NODES, i / NODES];
        let mut nodes: Vec<_> = (0..NODES * NODES).map(|i| Some(linear(place(i)))).collect();
        let middle = (NODES - 1) / 2;
        for ring in 10..=middle {
            for [column, row] in ring_places(middle, ring) {
                nodes[row * NODES + column] = None;
                let found = continued(&nodes, [column, row], ring).expect("known rays within");
                assert!(found.angles.distance(linear([column, row]).angles) < 1e-9);
                assert!(found.foot.distance(linear([column, row]).foot) < 1e-9);
                nodes[row * NODES + column] = Some(found);
            }
        }
    }
}
