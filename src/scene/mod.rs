//! The scene: shapes, materials, lights, and the stages that find what rays meet.
//!
//! World space, in the units of the scene file. What a scene holds is data that the shading
//! stages read; it is made by the reader in [`pbrt`] or by hand with [`SceneBuilder`].

mod bilinear;
mod curve;
mod cutout;
mod intersect;
mod light;
mod material;
mod mesh;
pub mod pbrt;
pub mod ply;
mod point;
mod quadric;
mod subdivision;
mod texture;
mod traverse;
mod tree;

pub use bilinear::triangulate;
pub use curve::{CurveSegment, tessellate};
pub use light::{
    AreaLight, Ball, Beam, Emission, Lamp, Light, LightSample, Lights, Sky, SkyImage, SkyLayout,
    cosine_hemisphere, luminance,
};
pub use material::{Coat, Material, Metal, Roughness, Scatters};
pub use mesh::Mesh;
pub use point::{Patch, SurfacePoint, gamma};
pub use quadric::{Form, Quadric};
pub use subdivision::{Unsmooth, subdivide};
pub use texture::{
    Awaited, Board, Filter, ImageMap, ImageTexture, Mapping, Pyramid, Texture, TexturePoint, Wrap,
};
pub use traverse::TraversalStack;
pub use tree::Tree;

use glam::{Affine3A, DAffine3, DVec3, Vec3};

use crate::rays::{Hit, NONE, Ray};
use tree::{Part, Parts};

/// What a shape is made of.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Triangles.
    Mesh(Mesh),
    /// A sphere, cylinder, disk or cone.
    Quadric(Quadric),
}

/// A shape with what covers it.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its form.
    pub geometry: Geometry,
    /// Its material, by index.
    pub material: u32,
    /// The light that it is, by index, or [`NONE`].
    pub light: u32,
    /// The probability that a ray meets it, where it is not 1 everywhere; below 0 counts as 0.
    pub alpha: Option<Texture>,
}

impl Shape {
    /// Whether every ray meets it.
    pub fn opaque(&self) -> bool {
        self.alpha.is_none()
    }

    fn quadric(&self) -> Option<&Quadric> {
        match &self.geometry {
            Geometry::Quadric(quadric) => Some(quadric),
            Geometry::Mesh(_) => None,
        }
    }
}

/// One copy of an object in the world.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Which object.
    pub object: u32,
    /// Object space to world space.
    pub world_from_object: Affine3A,
    /// World space to object space.
    pub object_from_world: Affine3A,
}

/// Everything that can be seen.
#[derive(Clone, Debug)]
pub struct Scene {
    /// All shapes, those of objects among them.
    pub shapes: Vec<Shape>,
    /// What they are made of.
    pub materials: Vec<Material>,
    /// What shines.
    pub lights: Lights,
    instances: Vec<Instance>,
    objects: Vec<Tree>,
    world: Tree,
}

impl Scene {
    /// The surface at a hit.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> (&Shape, SurfacePoint) {
        let shape = &self.shapes[hit.shape as usize];
        let point = match &shape.geometry {
            Geometry::Mesh(mesh) => mesh.point(hit),
            Geometry::Quadric(quadric) => quadric.point(self.object_point(ray, hit)),
        };
        match hit.instance {
            NONE => (shape, point),
            i => (shape, point.transform(&self.instances[i as usize].world_from_object)),
        }
    }

    /// How the surface at a hit is laid out in texture coordinates, world space.
    pub fn patch(&self, ray: &Ray, hit: &Hit) -> Patch {
        let shape = &self.shapes[hit.shape as usize];
        let patch = match &shape.geometry {
            Geometry::Mesh(mesh) => mesh.patch(hit),
            Geometry::Quadric(quadric) => quadric.patch(self.object_point(ray, hit)),
        };
        match hit.instance {
            NONE => patch,
            i => patch.transform(&self.instances[i as usize].world_from_object),
        }
    }

    /// Where a ray hit, in the space of the object that it hit.
    fn object_point(&self, ray: &Ray, hit: &Hit) -> DVec3 {
        let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let world = double(ray.origin) + double(ray.direction) * f64::from(hit.t);
        match hit.instance {
            NONE => world,
            i => {
                let matrix = &self.instances[i as usize].object_from_world;
                matrix.transform_point3(world.as_vec3()).as_dvec3()
            }
        }
    }

    /// The memory that the trees take, in bytes; see [`Tree`]. Vertices and indices are the
    /// shapes' own.
    pub fn bytes(&self) -> usize {
        let instances = size_of_val(&self.instances[..]);
        self.objects.iter().map(Tree::bytes).sum::<usize>() + self.world.bytes() + instances
    }

    /// Lowest and highest corner of the world, or `None` where it is empty.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        self.world.bounds
    }
}

/// A shape to be added to a scene.
#[derive(Clone, Debug)]
pub struct ShapeSpec {
    /// Its form.
    pub geometry: Geometry,
    /// Its material, by index.
    pub material: u32,
    /// What it emits.
    pub emission: Option<Emission>,
    /// The probability that a ray meets it; `None` is 1.
    pub alpha: Option<Texture>,
    /// The object that it belongs to; `None` is the world itself.
    pub object: Option<u32>,
}

impl ShapeSpec {
    /// An opaque shape in the world that does not shine.
    pub fn new(geometry: Geometry, material: u32) -> Self {
        Self { geometry, material, emission: None, alpha: None, object: None }
    }
}

/// Collects a scene and then builds its trees.
#[derive(Clone, Debug, Default)]
pub struct SceneBuilder {
    shapes: Vec<Shape>,
    materials: Vec<Material>,
    lights: Vec<Light>,
    objects: Vec<Vec<u32>>,
    instances: Vec<(u32, DAffine3)>,
    world: Vec<u32>,
}

impl SceneBuilder {
    /// Adds a material; answers its index.
    pub fn material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        (self.materials.len() - 1) as u32
    }

    /// Puts another material in the place of one that was added.
    pub fn change_material(&mut self, index: u32, material: Material) {
        self.materials[index as usize] = material;
    }

    /// Whether a material lets everything pass as if it were not there.
    pub fn is_interface(&self, material: u32) -> bool {
        matches!(self.materials[material as usize].scatters, Scatters::Interface)
    }

    /// Adds a light that is no shape.
    pub fn light(&mut self, light: Light) {
        self.lights.push(light);
    }

    /// Adds an empty object; answers its index.
    pub fn object(&mut self) -> u32 {
        self.objects.push(Vec::new());
        (self.objects.len() - 1) as u32
    }

    /// Adds a copy of an object to the world.
    pub fn instance(&mut self, object: u32, world_from_object: DAffine3) {
        self.instances.push((object, world_from_object));
    }

    /// Adds a shape to the world, or to an object. One in the world may shine.
    pub fn shape(&mut self, spec: ShapeSpec) {
        let ShapeSpec { geometry, material, emission, alpha, object } = spec;
        let shape = self.shapes.len() as u32;
        let mut light = NONE;
        if let (Some(emission), None) = (emission, object) {
            light = self.lights.len() as u32;
            self.lights.push(Light::Area(AreaLight::new(shape, emission, &geometry)));
        }
        let whole = |alpha: &Texture| matches!(alpha, Texture::Constant([a, ..]) if *a >= 1.0);
        let alpha = alpha.filter(|alpha| !whole(alpha));
        self.shapes.push(Shape { geometry, material, light, alpha });
        match object {
            Some(object) => self.objects[object as usize].push(shape),
            None => self.world.push(shape),
        }
    }

    /// Builds the trees.
    pub fn build(self) -> Scene {
        let Self { shapes, materials, .. } = &self;
        // What neither stops light nor shines is not there at all.
        let there = |shape: &u32| {
            let Shape { material, alpha, light, .. } = &shapes[*shape as usize];
            let interface = matches!(materials[*material as usize].scatters, Scatters::Interface);
            let hole = matches!(alpha, Some(Texture::Constant([alpha, ..])) if *alpha <= 0.0);
            !hole && (!interface || *light != NONE)
        };
        let there = |of: &[u32]| of.iter().copied().filter(there).collect::<Vec<u32>>();
        let objects: Vec<Tree> =
            self.objects.iter().map(|of| tree(shapes, &there(of), Parts::default())).collect();
        let mut instances = Vec::new();
        let mut parts = Parts::default();
        for (object, world_from_object) in &self.instances {
            let inverse = world_from_object.inverse();
            let Some([low, high]) = objects[*object as usize].bounds else { continue };
            if !inverse.is_finite() {
                continue;
            }
            let bounds = moved_box([low.as_dvec3(), high.as_dvec3()], world_from_object);
            parts.push(Part::Instance(instances.len() as u32, bounds));
            instances.push(Instance {
                object: *object,
                world_from_object: single(world_from_object),
                object_from_world: single(&inverse),
            });
        }
        let world = tree(shapes, &there(&self.world), parts);
        let lights = Lights::new(self.lights, &self.shapes);
        Scene { shapes: self.shapes, materials: self.materials, lights, instances, objects, world }
    }
}

/// The tree of some of the shapes, and of more.
fn tree<'a>(shapes: &'a [Shape], of: &[u32], mut parts: Parts<'a>) -> Tree {
    for &shape in of {
        let Shape { geometry, alpha, .. } = &shapes[shape as usize];
        parts.push(match geometry {
            Geometry::Mesh(mesh) => Part::Mesh { shape, mesh, cutout: alpha.is_some() },
            Geometry::Quadric(quadric) => Part::Quadric(shape, rounded_out(quadric.bounds())),
        });
    }
    Tree::new(&parts)
}

fn single(matrix: &DAffine3) -> Affine3A {
    Affine3A::from_cols_array(&matrix.to_cols_array().map(|v| v as f32))
}

/// A box in f32 around a box in f64.
fn rounded_out([low, high]: [DVec3; 2]) -> [Vec3; 2] {
    let outward = |v: DVec3, away: f64| {
        let slack = v.abs().max_element() * f64::from(f32::EPSILON) * away;
        (v + slack).as_vec3()
    };
    [outward(low, -1.0), outward(high, 1.0)]
}

/// A box around a box that was moved, with room for rays that were moved in f32.
fn moved_box([low, high]: [DVec3; 2], matrix: &DAffine3) -> [Vec3; 2] {
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in 0..8 {
        let pick = |bit: usize, axis: usize| {
            if corner >> bit & 1 == 0 { low[axis] } else { high[axis] }
        };
        let p = matrix.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)));
        (least, most) = (least.min(p), most.max(p));
    }
    rounded_out([least, most])
}
