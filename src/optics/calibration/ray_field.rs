//! Ray field: one ray in the scene for every point of the film, interpolated between traced ones.

use glam::{DVec2, DVec3};

use super::bundle::{BundleTracer, centroid, to_camera};
use super::pixel_grid::SightLine;
use petzval_lens::{ChiefRayFinder, RealLens};

/// Intervals of the radius of a round lens.
const RINGS: usize = 64;
/// Points of the grid over any other film, along its longer side.
const COLUMNS: usize = 25;
/// Rays of each bundle of a round lens, and of any other, which needs more bundles.
const RAYS: [usize; 2] = [1008, 504];
/// Irradiance below which a film point counts as dark, relative to the centre.
const DARK: f64 = 1e-3;

/// The ray that stands for all light of a film point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum FieldRay {
    /// The centroid of all rays that pass the lens, weighted by light: pictures show points of the
    /// scene there.
    #[default]
    Centroid,
    /// The ray through the centre of the stop. It differs from the centroid by coma and vignetting.
    Chief,
}

impl FieldRay {
    /// Returns its name, for files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Centroid => "centroid",
            Self::Chief => "chief",
        }
    }
}

/// A ray at a film point: the direction in azimuthal equidistant coordinates (radians), and the foot
/// of the perpendicular from the reference point (mm), which are smooth everywhere.
#[derive(Clone, Copy, Debug)]
struct Node {
    direction: DVec2,
    foot: DVec3,
    irradiance: f64,
}

/// The rays of all points of a film.
#[derive(Clone, Debug)]
pub struct RayField {
    /// The reference point for the feet of the rays: the paraxial entrance pupil.
    reference: DVec3,
    nodes: Nodes,
}

#[derive(Clone, Debug)]
enum Nodes {
    /// Rays by radius. The film points of the picture are off by `decentre` from the axis (mm).
    Round { step: f64, rings: Vec<Node>, decentre: [f64; 2] },
    /// Rays on a grid over the film: its first point, its steps (mm), and its number of columns.
    Grid { low: [f64; 2], step: [f64; 2], columns: usize, nodes: Vec<Option<Node>> },
}

/// Band of a field.
#[derive(Clone, Copy, Debug)]
pub(super) enum FieldBand<'a> {
    /// One band of the lens.
    One(usize),
    /// All bands of the lens with these weights: the mean of their rays.
    Mean(&'a [f64]),
}

impl RayField {
    /// Traces a field over a film (mm). A lens that is round gets its rays by radius, and then the
    /// lens must stand on an aligned film that reaches as far as the decentred one.
    pub(super) fn trace(
        lens: &RealLens,
        ray: FieldRay,
        band: FieldBand<'_>,
        film: [f64; 2],
        round: Option<[f64; 2]>,
    ) -> Self {
        let depth = lens.prescription.film_position(lens.film_distance);
        let pupil = lens.paraxial.entrance_pupil.position;
        let before = if pupil.is_finite() { depth - pupil } else { depth };
        let reference = DVec3::new(0.0, 0.0, before);
        let mut tracer = FieldTracer {
            bundles: BundleTracer::new(lens, RAYS[usize::from(round.is_none())]),
            chief: (ray == FieldRay::Chief).then(|| ChiefRayFinder::new(&lens.prescription)),
            lens,
            reference,
        };
        let nodes = match round {
            Some(decentre) => {
                let reach = [0, 1].map(|i| film[i] / 2.0 + decentre[i].abs());
                let step = 1.02 * reach[0].hypot(reach[1]) / RINGS as f64;
                let ring = |i: usize| {
                    let mut node = tracer.node([-step * i as f64, 0.0], band)?;
                    // Symmetry: the ray stays in its plane, and that of the centre on the axis.
                    (node.direction.y, node.foot.y) = (0.0, 0.0);
                    if i == 0 {
                        (node.direction, node.foot) = (DVec2::ZERO, DVec3::ZERO);
                    }
                    Some(node)
                };
                let mut rings: Vec<Node> = (0..=RINGS).map_while(ring).collect();
                let centre = rings.first().map_or(0.0, |node| node.irradiance);
                rings.truncate(rings.partition_point(|node| node.irradiance > DARK * centre));
                Nodes::Round { step, rings, decentre }
            }
            None => {
                let longer = film[0].max(film[1]);
                let count =
                    film.map(|size| (COLUMNS as f64 * size / longer).ceil().max(8.0) as usize);
                let step = [0, 1].map(|i| 1.02 * film[i] / (count[i] - 1) as f64);
                let low = film.map(|size| -0.51 * size);
                let place = |i: usize| {
                    let at = [i % count[0], i / count[0]];
                    [0, 1].map(|axis| low[axis] + step[axis] * at[axis] as f64)
                };
                let mut nodes: Vec<Option<Node>> =
                    (0..count[0] * count[1]).map(|i| tracer.node(place(i), band)).collect();
                let most = nodes.iter().flatten().map(|node| node.irradiance).fold(0.0, f64::max);
                for node in &mut nodes {
                    *node = node.filter(|node| node.irradiance > DARK * most);
                }
                Nodes::Grid { low, step, columns: count[0], nodes }
            }
        };
        Self { reference, nodes }
    }

    /// Returns the ray of a film point (mm); `None` if it is dark.
    pub fn ray(&self, film: [f64; 2]) -> Option<SightLine> {
        let (node, turn) = self.node(film)?;
        let (angle, foot) = (node.direction.length(), node.foot);
        let scale = if angle > 1e-9 { angle.sin() / angle } else { 1.0 };
        let [x, y] = turn.rotate(node.direction * scale).to_array();
        let offset = turn.rotate(foot.truncate());
        Some(SightLine {
            point: self.reference + offset.extend(foot.z),
            direction: DVec3::new(x, y, angle.cos()),
        })
    }

    /// Returns the irradiance of a film point (mm) under a scene of radiance 1; 0 if it is dark.
    pub fn irradiance(&self, film: [f64; 2]) -> f64 {
        self.node(film).map_or(0.0, |(node, _)| node.irradiance.max(0.0))
    }

    /// Returns the interpolated node of a film point, and the rotation from its frame to the
    /// camera's as a complex number.
    fn node(&self, film: [f64; 2]) -> Option<(Node, DVec2)> {
        match &self.nodes {
            Nodes::Round { step, rings, decentre } => {
                // To the direction of the picture: right and down.
                let place = DVec2::new(-(film[0] + decentre[0]), film[1] + decentre[1]);
                let radius = place.length();
                let turn = if radius > 0.0 { place / radius } else { DVec2::X };
                Some((ring_node(rings, radius / step)?, turn))
            }
            Nodes::Grid { low, step, columns, nodes } => {
                let at = [0, 1].map(|i| (film[i] - low[i]) / step[i]);
                Some((grid_node(nodes, *columns, at)?, DVec2::X))
            }
        }
    }
}

/// Returns the weights of four neighbours at 0, 1, 2 and 3 (Lagrange).
fn cubic(t: f64) -> [f64; 4] {
    let (a, b, c, d) = (t, t - 1.0, t - 2.0, t - 3.0);
    [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0]
}

fn mix<'a>(nodes: impl Iterator<Item = (Node, f64)> + 'a) -> Node {
    let zero = Node { direction: DVec2::ZERO, foot: DVec3::ZERO, irradiance: 0.0 };
    nodes.fold(zero, |sum, (node, weight)| Node {
        direction: sum.direction + weight * node.direction,
        foot: sum.foot + weight * node.foot,
        irradiance: sum.irradiance + weight * node.irradiance,
    })
}

/// Interpolates between rings; across the centre, the lens is its own mirror image.
fn ring_node(rings: &[Node], position: f64) -> Option<Node> {
    if rings.len() < 4 || position > (rings.len() - 1) as f64 {
        return None;
    }
    let first = (position as i64 - 1).min(rings.len() as i64 - 4);
    let at = |i: i64| match i < 0 {
        false => rings[i as usize],
        true => {
            let node = rings[-i as usize];
            let foot = DVec3::new(-node.foot.x, -node.foot.y, node.foot.z);
            Node { direction: -node.direction, foot, ..node }
        }
    };
    let weights = cubic(position - first as f64);
    Some(mix((0..4).map(|k| (at(first + k), weights[k as usize]))))
}

/// Interpolates between points of a grid: by cubics, or linearly next to dark points.
fn grid_node(nodes: &[Option<Node>], columns: usize, at: [f64; 2]) -> Option<Node> {
    let count = [columns, nodes.len() / columns];
    if (0..2).any(|i| !(at[i] >= 0.0 && at[i] <= (count[i] - 1) as f64)) {
        return None;
    }
    let node = |x: usize, y: usize| nodes[y * columns + x];
    let first = [0, 1].map(|i| (at[i] as usize).saturating_sub(1).min(count[i] - 4));
    let weights = [0, 1].map(|i| cubic(at[i] - first[i] as f64));
    let wide: Option<Vec<(Node, f64)>> = (0..16)
        .map(|k| {
            let (x, y) = (k % 4, k / 4);
            Some((node(first[0] + x, first[1] + y)?, weights[0][x] * weights[1][y]))
        })
        .collect();
    if let Some(wide) = wide {
        return Some(mix(wide.into_iter()));
    }
    let first = [0, 1].map(|i| (at[i] as usize).min(count[i] - 2));
    let share = [0, 1].map(|i| at[i] - first[i] as f64);
    let near: Option<Vec<(Node, f64)>> = (0..4)
        .map(|k| {
            let corner = [k % 2, k / 2];
            let weight = |i: usize| if corner[i] == 1 { share[i] } else { 1.0 - share[i] };
            Some((node(first[0] + corner[0], first[1] + corner[1])?, weight(0) * weight(1)))
        })
        .collect();
    near.map(|near| mix(near.into_iter()))
}

/// Traces the nodes of a field.
struct FieldTracer<'a> {
    bundles: BundleTracer<'a>,
    chief: Option<ChiefRayFinder>,
    lens: &'a RealLens,
    reference: DVec3,
}

impl FieldTracer<'_> {
    fn node(&mut self, film: [f64; 2], band: FieldBand<'_>) -> Option<Node> {
        match band {
            FieldBand::One(band) => {
                let (mut ray, irradiance) = centroid(&self.bundles.rays(film, band))?;
                if let Some(chief) = &self.chief {
                    let RealLens { film_distance, film_pose, prescription, .. } = self.lens;
                    let found = chief.of_film_point(film_pose.film_point(film), *film_distance)?;
                    let depth = prescription.film_position(*film_distance);
                    ray = to_camera(found.scene.p, found.scene.t, depth);
                }
                Some(self.describe(&ray, irradiance))
            }
            FieldBand::Mean(weights) => {
                let lit = weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0);
                let (mut parts, mut all) = (Vec::new(), 0.0);
                for (band, weight) in lit {
                    let (ray, irradiance) = centroid(&self.bundles.rays(film, band))?;
                    parts.push((self.describe(&ray, irradiance), weight * irradiance));
                    all += weight * irradiance;
                }
                Some(mix(parts.into_iter().map(|(node, weight)| (node, weight / all))))
            }
        }
    }

    fn describe(&self, ray: &SightLine, irradiance: f64) -> Node {
        let SightLine { point, direction } = *ray;
        let across = direction.truncate();
        let angle = ray.angle();
        let length = across.length();
        let scale = if length > 1e-12 { angle / length } else { 1.0 };
        let off = point - self.reference;
        Node { direction: across * scale, foot: off - off.dot(direction) * direction, irradiance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_interpolated_exactly() {
        let value = |t: f64| 1.0 - 2.0 * t + 0.5 * t * t - 0.1 * t.powi(3);
        let weights = cubic(1.3);
        let found: f64 = (0..4).map(|k| weights[k] * value(k as f64)).sum();
        assert!((found - value(1.3)).abs() < 1e-12);
    }
}
