//! Scene builder: collects shapes, materials and lights, and builds the hierarchies over them.

use std::sync::Arc;

use glam::DAffine3;

use super::animated::AnimatedInstances;
use super::capacity::SceneTooLarge;
use super::spectral::in_rgb;
use super::tangents::drop_unused_tangents;
use super::world::{build_object, build_world};
use super::{
    AnimatedInstance, AreaLight, Bvh, CurveSet, Emission, Geometry, Instance, InstancePose, Light,
    Lights, Material, MaterialModel, Medium, MediumInterface, Scene, SceneNames, Shape, Sky,
    Texture, VACUUM,
};
use crate::motion::Motion;
use petzval_base::rays::NO_INDEX;

/// A shape to be added to a scene.
#[derive(Clone, Debug)]
pub struct ShapeSpec {
    /// Geometry, in the space of the object that it belongs to.
    pub geometry: Geometry,
    /// Index of the material.
    pub material: u32,
    /// Emission; `None` if the shape is not a light.
    pub emission: Option<Emission>,
    /// Probability that a ray hits the shape; `None` is 1.
    pub alpha: Option<Texture>,
    /// The media on its sides; `None` if it does not separate media.
    pub interface: Option<MediumInterface>,
    /// Index of the object that it belongs to; `None` is the world.
    pub object: Option<u32>,
    /// Name, if the scene file gives one.
    pub name: Option<String>,
    /// Name of the asset that the shape is a copy of, from [`SceneBuilder::unique_name`]. By default it is the object, or the
    /// shape itself outside objects.
    pub asset: Option<String>,
}

impl ShapeSpec {
    /// Returns an opaque shape in the world that emits nothing.
    pub fn new(geometry: Geometry, material: u32) -> Self {
        Self {
            geometry,
            material,
            emission: None,
            alpha: None,
            interface: None,
            object: None,
            name: None,
            asset: None,
        }
    }
}

/// Collects the parts of a scene. Indices are those that its methods return.
#[derive(Clone, Debug, Default)]
pub struct SceneBuilder {
    pub(super) shapes: Vec<Shape>,
    materials: Vec<Material>,
    lights: Vec<Light>,
    media: Vec<Medium>,
    /// Index of the medium around the camera; `None` is vacuum.
    camera_medium: Option<u32>,
    /// Whether the media below surfaces are left out.
    without_media: bool,
    /// Indices of the shapes of each object.
    pub(super) objects: Vec<Vec<u32>>,
    /// Object, and its transform to world space.
    pub(super) instances: Vec<(u32, DAffine3)>,
    pub(super) animated: Vec<AnimatedInstance>,
    /// Indices of the shapes outside objects.
    pub(super) world: Vec<u32>,
    names: SceneNames,
}

impl SceneBuilder {
    /// Adds a material and returns its index.
    pub fn add_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        (self.materials.len() - 1) as u32
    }

    /// Replaces a material.
    pub fn replace_material(&mut self, index: u32, material: Material) {
        self.materials[index as usize] = material;
    }

    /// Adds a light that is not a shape.
    pub fn add_light(&mut self, light: Light) {
        self.lights.push(light);
    }

    /// Adds a medium and returns its index.
    pub fn add_medium(&mut self, medium: Medium) -> u32 {
        self.media.push(medium);
        (self.media.len() - 1) as u32
    }

    /// Replaces a medium.
    pub fn replace_medium(&mut self, index: u32, medium: Medium) {
        self.media[index as usize] = medium;
    }

    /// Removes all media: surfaces separate nothing. Returns whether there were any.
    pub fn remove_media(&mut self) -> bool {
        let subsurface =
            |material: &Material| matches!(material.model, MaterialModel::Subsurface { .. });
        let any = !self.media.is_empty() || self.materials.iter().any(subsurface);
        self.media.clear();
        self.without_media = true;
        self.camera_medium = None;
        self.shapes.iter_mut().for_each(|shape| shape.interface = None);
        any
    }

    /// Sets the medium around the camera.
    pub fn set_camera_medium(&mut self, medium: u32) {
        self.camera_medium = Some(medium);
    }

    /// Adds an empty object and returns its index.
    pub fn add_object(&mut self) -> u32 {
        self.objects.push(Vec::new());
        (self.objects.len() - 1) as u32
    }

    /// Names an object.
    pub fn name_object(&mut self, index: u32, name: &str) {
        self.names.set_object(index, name);
    }

    /// Returns a name for an asset that no other one has from here.
    pub fn unique_name(&mut self, name: &str) -> String {
        self.names.unique(name).to_string()
    }

    /// Names a material.
    pub fn name_material(&mut self, index: u32, name: &str) {
        self.names.set_material(index, name);
    }

    /// Adds a copy of an object to the world.
    pub fn add_instance(&mut self, object: u32, world_from_object: DAffine3) {
        self.instances.push((object, world_from_object));
    }

    /// Adds a moving copy of an object to the world.
    pub fn add_animated_instance(&mut self, object: u32, motion: Motion) {
        match motion.as_still() {
            Some(world_from_object) => self.add_instance(object, world_from_object),
            None => self.animated.push(AnimatedInstance { object, motion }),
        }
    }

    /// Adds a shape to the world or to an object, and returns its index. Shapes of objects emit
    /// nothing. Patches and curves that emit light become triangles.
    pub fn add_shape(&mut self, spec: ShapeSpec) -> u32 {
        let ShapeSpec { mut geometry, material, emission, alpha, interface, object, name, asset } =
            spec;
        let shape = self.shapes.len() as u32;
        if let Some(name) = name {
            self.names.set_shape(shape, &name, object.is_some());
        }
        if let Some(asset) = asset {
            self.names.set_asset(shape, &asset);
        }
        let mut light = NO_INDEX;
        if let (Some(emission), None) = (emission, object) {
            geometry = geometry.into_emitter();
            light = self.lights.len() as u32;
            self.lights.push(Light::Area(AreaLight::new(shape, emission, &geometry)));
        }
        let alpha = alpha.filter(|alpha| !is_opaque(alpha));
        self.shapes.push(Shape { geometry, material, light, alpha, interface });
        match object {
            Some(object) => self.objects[object as usize].push(shape),
            None => self.world.push(shape),
        }
        shape
    }

    /// Appends curves to a shape of curves. Returns them if the shape is none, or if their normals
    /// differ in kind or side.
    pub fn append_curves(&mut self, shape: u32, curves: CurveSet) -> Result<(), CurveSet> {
        match &mut self.shapes[shape as usize].geometry {
            Geometry::Curves(all) => all.append(curves),
            Geometry::Mesh(_) | Geometry::Patches(_) | Geometry::Quadric(_) => Err(curves),
        }
    }

    /// Sets the alpha of a shape.
    pub fn set_alpha(&mut self, shape: u32, alpha: Option<Texture>) {
        self.shapes[shape as usize].alpha = alpha.filter(|alpha| !is_opaque(alpha));
    }

    /// Makes all surfaces white and diffuse, and one white sky the only light, without media: the
    /// direct light is then the ambient occlusion.
    pub fn whiten(&mut self) {
        self.remove_media();
        for material in &mut self.materials {
            if !matches!(material.model, MaterialModel::Interface) {
                *material = Material::diffuse([1.0; 3]);
            }
        }
        self.shapes.iter_mut().for_each(|shape| shape.light = NO_INDEX);
        self.lights = vec![Light::Infinite(Sky::uniform([1.0; 3]))];
    }

    /// Removes the emission of a shape whose material is an interface, as pbrt-v4 does. Returns
    /// whether it did.
    pub fn remove_interface_emission(&mut self, shape: u32) -> bool {
        let shape = &mut self.shapes[shape as usize];
        let model = &self.materials[shape.material as usize].model;
        let Some(Light::Area(light)) = self.lights.get_mut(shape.light as usize) else {
            return false;
        };
        let dark = matches!(model, MaterialModel::Interface);
        if dark {
            light.emission.radiance = [0.0; 3].into();
            shape.light = NO_INDEX;
        }
        dark
    }

    /// Lets a shape whose material is an interface emit, as pbrt-v3 does: the shape emits, and rays
    /// pass through it.
    pub fn keep_interface_emission(&mut self, shape: u32) {
        let Shape { material, light, .. } = self.shapes[shape as usize];
        let is_interface = |m: &Material| matches!(m.model, MaterialModel::Interface);
        if light != NO_INDEX && is_interface(&self.materials[material as usize]) {
            // A pane without refraction transmits all.
            let model = MaterialModel::thin_sheet(1.0, Texture::Constant([1.0; 3]));
            self.shapes[shape as usize].material = self.add_material(Material::new(model));
        }
    }

    /// Builds the hierarchies.
    ///
    /// # Errors
    /// Returns an error if the world or an object holds more primitives than a hierarchy can index.
    pub fn build(mut self) -> Result<Scene, SceneTooLarge> {
        self.check_size(Bvh::MAX_PRIMITIVES)?;
        self.add_interiors();
        for shape in &mut self.shapes {
            if let Geometry::Curves(curves) = &mut shape.geometry {
                curves.finish();
            }
        }
        let tangents = drop_unused_tangents(&mut self.shapes, &self.materials);
        let Self { shapes, materials, .. } = &self;
        // Shapes that neither block nor emit light nor separate media are left out.
        let visible = |shape: &u32| {
            let shape = &shapes[*shape as usize];
            let model = &materials[shape.material as usize].model;
            let dark = matches!(model, MaterialModel::Interface)
                && shape.light == NO_INDEX
                && shape.interface.is_none();
            !shape.is_invisible() && !dark
        };
        let visible = |all: &[u32]| all.iter().copied().filter(visible).collect::<Vec<u32>>();
        let object_shapes: Vec<Vec<u32>> = self.objects.iter().map(|all| visible(all)).collect();
        let objects: Vec<Bvh> =
            object_shapes.iter().map(|included| build_object(shapes, included)).collect();
        let mut instances = Vec::new();
        for (object, world_from_object) in &self.instances {
            let is_empty = objects[*object as usize].bounds.is_none();
            if !is_empty && world_from_object.inverse().is_finite() {
                let pose = InstancePose::new(world_from_object);
                instances.push(Instance { object: *object, pose });
            }
        }
        let static_shapes = visible(&self.world);
        let world = build_world(shapes, &static_shapes, &objects, &instances);
        let movers = AnimatedInstances::new(self.animated, &objects, [0.0, 1.0]);
        let lights = Lights::new(self.lights, &self.shapes);
        let textured = self.materials.iter().any(Material::is_textured);
        let solid = self.materials.iter().any(Material::has_solid_texture);
        let derivatives = self.materials.iter().map(Material::needs_derivatives).collect();
        let vertex_colours = self.materials.iter().map(Material::has_vertex_colours).collect();
        let object_stack_size = objects.iter().map(|bvh| bvh.stack_size).max().unwrap_or(0);
        let Self { shapes, materials, mut media, camera_medium, .. } = self;
        let (materials, spectral_materials) = in_rgb(materials.into());
        if camera_medium.is_none() && shapes.iter().all(|shape| shape.interface.is_none()) {
            media.clear();
        }
        Ok(Scene {
            shapes: shapes.into(),
            materials,
            spectral_materials,
            lights: Arc::new(lights),
            media: media.into(),
            camera_medium: camera_medium.unwrap_or(VACUUM),
            instances: instances.into(),
            objects: objects.into(),
            object_stack_size,
            object_shapes: object_shapes.into(),
            static_shapes: static_shapes.into(),
            world: Arc::new(world),
            animated: movers,
            textured,
            solid,
            tangents,
            derivatives,
            vertex_colours,
            names: Arc::new(self.names),
            frozen: Arc::default(),
        })
    }

    /// Adds the media below surfaces, one for each material, as the inside of their shapes.
    fn add_interiors(&mut self) {
        for (material, Material { model, .. }) in (0..).zip(&self.materials) {
            let MaterialModel::Subsurface { interior, .. } = model else { continue };
            if self.without_media {
                continue;
            }
            let inside = self.media.len() as u32;
            self.media.push(Medium::below(interior));
            for shape in self.shapes.iter_mut().filter(|shape| shape.material == material) {
                let outside = shape.interface.map_or(VACUUM, |sides| sides.outside);
                shape.interface = Some(MediumInterface { inside, outside });
            }
        }
    }
}

/// Returns whether every ray hits a shape with this alpha.
fn is_opaque(alpha: &Texture) -> bool {
    matches!(alpha, Texture::Constant([a, ..]) if *a >= 1.0)
}
