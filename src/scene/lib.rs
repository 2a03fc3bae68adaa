//! Scenes: shapes, materials, lights, and the intersection stages.
//!
//! Coordinates are in world space, in the units of the scene file. A scene comes from a file, by the
//! readers of the crate `petzval-scene-formats`, or from a [`SceneBuilder`].

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod filter;
pub mod motion;
pub mod shutter;

mod alpha;
mod animated;
mod builder;
mod bvh;
mod capacity;
mod dispersion;
pub mod geometry;
mod hair;
mod intersect;
mod light;
mod material;
mod material_colours;
mod measured;
pub mod medium;
mod names;
mod path_limits;
mod spectral;
mod spectral_error;
mod surfaces;
mod tangents;
mod texture;
mod transform;
mod world;

pub use animated::AnimatedInstance;
pub use builder::{SceneBuilder, ShapeSpec};
pub use bvh::{Bvh, TraversalStack};
pub use capacity::SceneTooLarge;
pub use dispersion::Dispersion;
pub use geometry::{
    CubicPoints, CurveCrossing, CurveKind, CurvePiece, CurveRay, CurveSegment, CurveSet, Geometry,
    Mesh, PatchMesh, PieceBounds, Quadric, QuadricForm, RayPoint, Sphere, SubdivisionError,
    SurfaceDerivatives, SurfaceDerivativesPacket, SurfacePacket, SurfacePoint, gamma,
    split_patches, subdivide, tessellate_curve,
};
pub use hair::{HairColour, HairFibre};
pub use light::{
    AreaLight, Emission, GlossyLobe, IntensityDistribution, Light, LightColumns, LightInputs,
    LightSample, LightSamples, Lights, LobeColumns, NoRectangle, PointLight, Portal, Reception,
    Sky, SkyImage, SkyLayout, SkySampling, cosine_hemisphere, luminance, uplifted,
};
pub use material::{
    DielectricCoat, Material, MaterialModel, Metal, MetallicRoughnessSurface, Roughness,
};
pub use measured::{MeasuredSample, MeasuredSurface};
pub use medium::{
    Blackbodies, BrickGrid, CloudPattern, Coefficients, DensityField, DiffuseBoundary, Field,
    FieldEmission, Homogeneous, MajorantGrid, MeasuredMedium, Medium, MediumColours, MediumColumns,
    MediumInterface, MediumModel, PlacedGrid, ScalarGrid, Subsurface, Surroundings, VACUUM,
    VaryingMedium, VoxelGrid, Voxels, henyey_greenstein, sample_henyey_greenstein_cosine,
};
pub use names::SceneNames;
pub use path_limits::PathLimits;
pub use spectral::SpectralScene;
pub use spectral_error::{RgbError, RgbErrors};
pub use surfaces::{SurfaceColumns, SurfaceInputs, VectorColumns, load_vector, store_vector};
pub use texture::{
    CheckerPattern, DotPattern, ImageMap, ImageTexture, Mapping, MipMap, Octaves, PendingImage,
    SolidPattern, SolidTexture, Texture, TextureFilter, TexturePoint, Wrap,
};

use std::sync::{Arc, Mutex};

use glam::{Affine3A, DAffine3, DVec3, Vec3};

use animated::{AnimatedInstances, FrozenScene};
use petzval_base::rays::{Hit, NO_INDEX, Ray};
pub use transform::look_at_rotation;
use transform::{to_f32, to_f64};

/// Geometry with its material.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Geometry, in the space of the object that it belongs to.
    pub geometry: Geometry,
    /// Index of the material.
    pub material: u32,
    /// Index of its area light, or [`NO_INDEX`].
    pub light: u32,
    /// Probability that a ray hits it; `None` is 1 everywhere, and values below 0 count as 0.
    pub alpha: Option<Texture>,
    /// The media on its sides; `None` if the surface does not separate media.
    pub interface: Option<MediumInterface>,
}

impl Shape {
    /// Returns whether the shape has no alpha texture.
    pub fn is_opaque(&self) -> bool {
        self.alpha.is_none()
    }

    fn quadric(&self) -> Option<&Quadric> {
        match &self.geometry {
            Geometry::Quadric(quadric) => Some(quadric),
            Geometry::Mesh(_) | Geometry::Patches(_) | Geometry::Curves(_) => None,
        }
    }
}

/// A static copy of an object in the world.
#[derive(Clone, Copy, Debug)]
pub struct Instance {
    /// Index of the object.
    pub object: u32,
    /// Transforms to and from world space.
    pub pose: InstancePose,
}

/// Transforms between the space of an object and world space.
#[derive(Clone, Copy, Debug)]
pub struct InstancePose {
    /// Object space to world space.
    pub world_from_object: Affine3A,
    /// World space to object space.
    pub object_from_world: Affine3A,
}

impl InstancePose {
    fn new(world_from_object: &DAffine3) -> Self {
        Self {
            world_from_object: to_f32(world_from_object),
            object_from_world: to_f32(&world_from_object.inverse()),
        }
    }
}

/// A shape where it stands in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PlacedShape {
    /// Index of the shape.
    pub shape: u32,
    /// Index of the instance, or [`NO_INDEX`]. Moving instances follow static ones.
    pub instance: u32,
}

/// Shapes, materials and lights, with the hierarchies for intersection. Clones share all large
/// data: meshes, textures and hierarchies.
#[derive(Clone, Debug)]
pub struct Scene {
    /// All shapes, including those of objects.
    pub shapes: Arc<[Shape]>,
    /// Materials of the shapes.
    pub materials: Arc<[Material]>,
    /// The materials with the spectra of their colours, if any has one.
    spectral_materials: Option<Arc<[Material]>>,
    /// Lights, including the area lights of shapes.
    pub lights: Arc<Lights>,
    /// Participating media.
    pub media: Arc<[Medium]>,
    /// Index of the medium around the camera, or [`VACUUM`].
    pub camera_medium: u32,
    /// Names of shapes, objects and materials.
    pub names: Arc<SceneNames>,
    instances: Arc<[Instance]>,
    /// One hierarchy for each object.
    objects: Arc<[Bvh]>,
    /// Stack slots for the deepest of them.
    object_stack_size: usize,
    /// Indices of the shapes of each object.
    object_shapes: Arc<[Vec<u32>]>,
    /// Indices of the shapes in `world`, outside objects.
    static_shapes: Arc<[u32]>,
    /// Hierarchy over the static shapes and instances.
    world: Arc<Bvh>,
    animated: AnimatedInstances,
    textured: bool,
    solid: bool,
    /// Whether a mesh has tangents of its own.
    tangents: bool,
    /// Whether a material needs texture coordinates and surface derivatives, by material.
    derivatives: Arc<[bool]>,
    /// Whether a texture of a material has the colours of vertices, by material.
    vertex_colours: Arc<[bool]>,
    /// Result of the last [`Self::freeze`], which clones usually repeat for the same time.
    frozen: Arc<Mutex<Option<FrozenScene>>>,
}

impl Scene {
    /// Returns every shape of the world, and every copy in a static or moving instance.
    pub fn placed_shapes(&self) -> impl Iterator<Item = PlacedShape> {
        let own = self.static_shapes.iter();
        let own = own.map(|&shape| PlacedShape { shape, instance: NO_INDEX });
        let still = self.instances.iter().map(|instance| instance.object);
        let moving = self.animated.all.iter().map(|instance| instance.object);
        let copies = (0..).zip(still.chain(moving)).flat_map(|(instance, object)| {
            self.object_shapes[object as usize]
                .iter()
                .map(move |&shape| PlacedShape { shape, instance })
        });
        own.chain(copies)
    }

    /// Returns the pose of a shape at a time, if it is that of an instance.
    pub fn placed_pose(&self, placed: &PlacedShape, time: f32) -> Option<InstancePose> {
        (placed.instance != NO_INDEX).then(|| self.pose(placed.instance, time))
    }

    /// Returns the shape that was hit, and the point of its surface in world space.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> (&Shape, SurfacePoint) {
        let shape = &self.shapes[hit.shape as usize];
        let pose = (hit.instance != NO_INDEX).then(|| self.pose(hit.instance, hit.time));
        let point = shape.geometry.point(hit, || object_point(ray, hit, &pose));
        match pose {
            None => (shape, point),
            Some(pose) => (shape, pose.place_point(&point)),
        }
    }

    /// Returns the texture coordinates at a hit, and the derivatives of the surface with respect to
    /// them, in world space.
    pub fn surface_derivatives(&self, ray: &Ray, hit: &Hit) -> SurfaceDerivatives {
        let shape = &self.shapes[hit.shape as usize];
        let pose = (hit.instance != NO_INDEX).then(|| self.pose(hit.instance, hit.time));
        let derivatives = shape.geometry.derivatives(hit, || object_point(ray, hit, &pose));
        let Some(pose) = pose else { return derivatives };
        let inside = shape.geometry.point(hit, || object_point(ray, hit, &Some(pose)));
        pose.place_derivatives(&derivatives, inside.shading_normal)
    }

    /// Returns whether a material filters textures over the footprint of a pixel.
    pub fn is_textured(&self) -> bool {
        self.textured
    }

    /// Returns whether a material has a solid texture.
    pub fn has_solid_texture(&self) -> bool {
        self.solid
    }

    /// Returns whether a material needs texture coordinates and surface derivatives.
    pub fn needs_derivatives(&self, material: u32) -> bool {
        self.derivatives[material as usize]
    }

    /// Returns whether a texture of a material has the colours of vertices.
    pub fn has_vertex_colours(&self, material: u32) -> bool {
        self.vertex_colours[material as usize]
    }

    /// Returns the memory of the hierarchies and instances (bytes), without that of the shapes.
    pub fn bytes(&self) -> usize {
        let instances = size_of_val(&self.instances[..]) + self.animated.bytes();
        self.objects.iter().map(Bvh::bytes).sum::<usize>() + self.world.bytes() + instances
    }

    /// Returns the lowest and highest corner of the world and of all that moves through it, or
    /// `None` if the scene is empty.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        match (self.world.bounds, self.animated.bounds()) {
            (Some([low, high]), Some([least, most])) => Some([low.min(least), high.max(most)]),
            (one, other) => one.or(other),
        }
    }
}

/// Returns the point of a hit and the ray's direction in object space. `pose` is that of the
/// instance, if it is one.
fn object_point(ray: &Ray, hit: &Hit, pose: &Option<InstancePose>) -> RayPoint {
    let double = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let direction = double(ray.direction);
    let position = double(ray.origin) + direction * f64::from(hit.t);
    match pose {
        None => RayPoint { position, direction },
        Some(InstancePose { object_from_world, .. }) => {
            let matrix = to_f64(object_from_world);
            RayPoint {
                position: matrix.transform_point3(position),
                direction: matrix.transform_vector3(direction),
            }
        }
    }
}
