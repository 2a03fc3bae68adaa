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
mod moving;
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
pub use moving::Mover;
pub use point::{Patch, SurfacePoint, gamma};
pub use quadric::{Form, Quadric};
pub use subdivision::{Unsmooth, subdivide};
pub use texture::{
    Awaited, Board, Filter, ImageMap, ImageTexture, Mapping, Pyramid, Texture, TexturePoint, Wrap,
};
pub use traverse::TraversalStack;
pub use tree::Tree;

use std::sync::{Arc, Mutex};

use glam::{Affine3A, DAffine3, DVec3, Vec3};

use crate::motion::Motion;
use crate::rays::{Hit, NONE, Ray};
use moving::{Movers, Still};
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

impl Instance {
    fn new(object: u32, world_from_object: &DAffine3) -> Self {
        Self {
            object,
            world_from_object: single(world_from_object),
            object_from_world: single(&world_from_object.inverse()),
        }
    }
}

/// Everything that can be seen. Clones share all that is large: meshes, textures and trees.
#[derive(Clone, Debug)]
pub struct Scene {
    /// All shapes, those of objects among them.
    pub shapes: Arc<[Shape]>,
    /// What they are made of.
    pub materials: Arc<[Material]>,
    /// What shines.
    pub lights: Arc<Lights>,
    instances: Arc<[Instance]>,
    objects: Arc<[Tree]>,
    /// The shapes of the world's tree.
    standing: Arc<[u32]>,
    world: Arc<Tree>,
    movers: Movers,
    textured: bool,
    /// What was made of it last when everything stopped; clones ask for the same again.
    still: Arc<Mutex<Option<Still>>>,
}

impl Scene {
    /// The surface at a hit.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> (&Shape, SurfacePoint) {
        let shape = &self.shapes[hit.shape as usize];
        let there = (hit.instance != NONE).then(|| self.pose(hit.instance, hit.time));
        let point = match &shape.geometry {
            Geometry::Mesh(mesh) => mesh.point(hit),
            Geometry::Quadric(quadric) => quadric.point(object_point(ray, hit, &there)),
        };
        match there {
            None => (shape, point),
            Some([world_from_object, _]) => (shape, point.transform(&world_from_object)),
        }
    }

    /// How the surface at a hit is laid out in texture coordinates, world space.
    pub fn patch(&self, ray: &Ray, hit: &Hit) -> Patch {
        let shape = &self.shapes[hit.shape as usize];
        let there = (hit.instance != NONE).then(|| self.pose(hit.instance, hit.time));
        let patch = match &shape.geometry {
            Geometry::Mesh(mesh) => mesh.patch(hit),
            Geometry::Quadric(quadric) => quadric.patch(object_point(ray, hit, &there)),
        };
        let Some([world_from_object, _]) = there else { return patch };
        let inside = match &shape.geometry {
            Geometry::Mesh(mesh) => mesh.point(hit),
            Geometry::Quadric(quadric) => quadric.point(object_point(ray, hit, &there)),
        };
        patch.transform(&world_from_object, inside.shading)
    }

    /// Whether a material looks textures up over the footprint of a pixel.
    pub fn is_textured(&self) -> bool {
        self.textured
    }

    /// The memory that the trees take, in bytes; see [`Tree`]. Vertices and indices are the
    /// shapes' own.
    pub fn bytes(&self) -> usize {
        let instances = size_of_val(&self.instances[..]) + self.movers.bytes();
        self.objects.iter().map(Tree::bytes).sum::<usize>() + self.world.bytes() + instances
    }

    /// Lowest and highest corner of the world and of all that moves through it, or `None` where
    /// it is empty.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        match (self.world.bounds, self.movers.bounds()) {
            (Some([low, high]), Some([least, most])) => Some([low.min(least), high.max(most)]),
            (one, other) => one.or(other),
        }
    }

    /// Builds the tree of what stands still, these instances among it.
    fn grow(&self, instances: &[Instance]) -> Tree {
        let mut parts = Parts::default();
        for (number, instance) in instances.iter().enumerate() {
            let Some([low, high]) = self.objects[instance.object as usize].bounds else { continue };
            let matrix = double(&instance.world_from_object);
            let bounds = moved_box([low.as_dvec3(), high.as_dvec3()], &matrix);
            parts.push(Part::Instance(number as u32, bounds));
        }
        tree(&self.shapes, &self.standing, parts)
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
    movers: Vec<Mover>,
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

    /// Adds a copy of an object that moves.
    pub fn mover(&mut self, object: u32, motion: Motion) {
        match motion.as_still() {
            Some(world_from_object) => self.instance(object, world_from_object),
            None => self.movers.push(Mover { object, motion }),
        }
    }

    /// Adds a shape to the world, or to an object; answers its index. One in the world may shine.
    pub fn shape(&mut self, spec: ShapeSpec) -> u32 {
        let ShapeSpec { geometry, material, emission, alpha, object } = spec;
        let shape = self.shapes.len() as u32;
        let mut light = NONE;
        if let (Some(emission), None) = (emission, object) {
            light = self.lights.len() as u32;
            self.lights.push(Light::Area(AreaLight::new(shape, emission, &geometry)));
        }
        let alpha = alpha.filter(|alpha| !whole(alpha));
        self.shapes.push(Shape { geometry, material, light, alpha });
        match object {
            Some(object) => self.objects[object as usize].push(shape),
            None => self.world.push(shape),
        }
        shape
    }

    /// Gives a shape that was added another alpha.
    pub fn change_alpha(&mut self, shape: u32, alpha: Option<Texture>) {
        self.shapes[shape as usize].alpha = alpha.filter(|alpha| !whole(alpha));
    }

    /// Puts out a shape that shines but is made of nothing, as pbrt-v4 does; answers whether it
    /// was one.
    pub fn darken_interface(&mut self, shape: u32) -> bool {
        let shape = &mut self.shapes[shape as usize];
        let scatters = &self.materials[shape.material as usize].scatters;
        let Some(Light::Area(light)) = self.lights.get_mut(shape.light as usize) else {
            return false;
        };
        let dark = matches!(scatters, Scatters::Interface);
        if dark {
            light.emission.radiance = [0.0; 3];
            shape.light = NONE;
        }
        dark
    }

    /// Builds the trees.
    pub fn build(self) -> Scene {
        let Self { shapes, materials, .. } = &self;
        // What neither stops light nor shines is not there at all.
        let there = |shape: &u32| {
            let shape = &shapes[*shape as usize];
            let scatters = &materials[shape.material as usize].scatters;
            let dark = matches!(scatters, Scatters::Interface) && shape.light == NONE;
            !shape.unseen() && !dark
        };
        let there = |of: &[u32]| of.iter().copied().filter(there).collect::<Vec<u32>>();
        let objects: Vec<Tree> =
            self.objects.iter().map(|of| tree(shapes, &there(of), Parts::default())).collect();
        let mut instances = Vec::new();
        let mut parts = Parts::default();
        for (object, world_from_object) in &self.instances {
            let Some([low, high]) = objects[*object as usize].bounds else { continue };
            if !world_from_object.inverse().is_finite() {
                continue;
            }
            let bounds = moved_box([low.as_dvec3(), high.as_dvec3()], world_from_object);
            parts.push(Part::Instance(instances.len() as u32, bounds));
            instances.push(Instance::new(*object, world_from_object));
        }
        let standing = there(&self.world);
        let world = tree(shapes, &standing, parts);
        let movers = Movers::new(self.movers, &objects, [0.0, 1.0]);
        let lights = Lights::new(self.lights, &self.shapes);
        let textured = self.materials.iter().any(Material::is_textured);
        let Self { shapes, materials, .. } = self;
        Scene {
            shapes: shapes.into(),
            materials: materials.into(),
            lights: Arc::new(lights),
            instances: instances.into(),
            objects: objects.into(),
            standing: standing.into(),
            world: Arc::new(world),
            movers,
            textured,
            still: Arc::default(),
        }
    }
}

/// Whether an alpha lets no ray through.
fn whole(alpha: &Texture) -> bool {
    matches!(alpha, Texture::Constant([a, ..]) if *a >= 1.0)
}

/// Where a ray hit, in the space of the object that it hit, which stands at this pose if it is an
/// instance.
fn object_point(ray: &Ray, hit: &Hit, pose: &Option<[Affine3A; 2]>) -> DVec3 {
    let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let world = double(ray.origin) + double(ray.direction) * f64::from(hit.t);
    match pose {
        None => world,
        Some([_, object_from_world]) => {
            object_from_world.transform_point3(world.as_vec3()).as_dvec3()
        }
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

fn double(matrix: &Affine3A) -> DAffine3 {
    DAffine3::from_cols_array(&matrix.to_cols_array().map(f64::from))
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
