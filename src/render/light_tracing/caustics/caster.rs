//! Caster: a surface that may reflect or refract like a mirror or clear glass.

use glam::Vec3;

use petzval_base::distribution::DiscreteDistribution;
use petzval_base::rays::Hit;
use petzval_scene::{Geometry, MaterialModel, PlacedShape, Scene, SurfacePoint};

/// Most triangles of a caster: numbers in [0, 1) choose one of them.
const MOST_TRIANGLES: usize = 1 << 18;

/// A shape of the scene on which light paths start.
#[derive(Clone, Debug)]
pub(super) struct Caster {
    /// The shape.
    pub placed: PlacedShape,
    /// Probability that a light path starts here.
    pub share: f64,
    /// Choice of its triangle, by area; of one for a quadric.
    primitives: DiscreteDistribution,
    /// Its area (units of its object squared).
    pub area: f64,
}

/// A point of a caster.
pub(super) struct CasterPoint {
    pub point: SurfacePoint,
    pub primitive: u32,
    /// Density over the area of all casters (world units^-2).
    pub density: f64,
}

impl Caster {
    /// Samples a point at a time.
    pub fn sample(
        &self,
        scene: &Scene,
        time: f32,
        primitive: f32,
        [u, v]: [f32; 2],
    ) -> Option<CasterPoint> {
        let chosen = self.primitives.sample(primitive);
        let probability = self.share * f64::from(self.primitives.probability(chosen));
        let primitive = chosen as u32;
        let (point, density) = match &scene.shapes[self.placed.shape as usize].geometry {
            Geometry::Quadric(quadric) => quadric.sample([u, v]),
            Geometry::Mesh(mesh) => {
                // Uniform over the triangle (Turk 1990).
                let root = u.sqrt();
                let hit = Hit { u: root * (1.0 - v), v: root * v, primitive, ..Hit::MISS };
                (mesh.point(&hit), 1.0 / mesh.area(primitive))
            }
            Geometry::Patches(_) | Geometry::Curves(_) => return None,
        };
        let (point, scale) = match scene.placed_pose(&self.placed, time) {
            None => (point, 1.0),
            Some(pose) => (pose.place_point(&point), pose.area_scale(point.normal)),
        };
        let density = probability * f64::from(density / scale);
        (density > 0.0 && density.is_finite() && point.normal != Vec3::ZERO)
            .then_some(CasterPoint { point, primitive, density })
    }
}

/// Returns the casters of a scene, or why light paths cannot find all caustics.
pub(super) fn casters(scene: &Scene) -> Result<Vec<Caster>, &'static str> {
    let mut casters = Vec::new();
    let specular: Vec<bool> =
        (0..scene.materials.len() as u32).map(|i| may_be_specular(scene, i)).collect();
    for placed in scene.placed_shapes() {
        let shape = &scene.shapes[placed.shape as usize];
        match scene.materials[shape.material as usize].model {
            MaterialModel::Interface => return Err("a surface lets light straight through"),
            MaterialModel::Subsurface { .. } => return Err("light scatters below a surface"),
            _ if !specular[shape.material as usize] => continue,
            _ => (),
        }
        let areas: Vec<f64> = match &shape.geometry {
            Geometry::Mesh(mesh) if mesh.triangles.len() > MOST_TRIANGLES => {
                return Err("a mirror or glass has too many triangles");
            }
            Geometry::Mesh(mesh) => {
                (0..mesh.triangles.len() as u32).map(|i| f64::from(mesh.area(i))).collect()
            }
            Geometry::Quadric(quadric) => vec![quadric.area()],
            Geometry::Patches(_) | Geometry::Curves(_) => {
                return Err("a mirror or glass is a patch or a curve");
            }
        };
        if let Some(primitives) = DiscreteDistribution::new(&areas) {
            let area = areas.iter().sum();
            casters.push(Caster { placed, share: 0.0, primitives, area });
        }
    }
    if casters.is_empty() { Err("nothing reflects or refracts") } else { Ok(casters) }
}

/// Returns whether a material may reflect or refract a ray into one direction.
fn may_be_specular(scene: &Scene, material: u32) -> bool {
    match &scene.materials[material as usize].model {
        MaterialModel::Mix { materials, .. } => {
            materials.iter().any(|&part| may_be_specular(scene, part))
        }
        model => model.may_be_specular(),
    }
}
