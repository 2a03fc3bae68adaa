//! Tree of nodes: the place of every mesh, light and camera in the world.

use std::collections::HashMap;

use glam::{DAffine3, DMat4, DVec3};

use super::SceneParts;
use super::cameras::read_camera;
use super::instances::{copies, quaternion};
use super::lights::read_light;
use super::materials::{ShapeMaterial, Variant};
use super::meshes::{PrimitiveMesh, SidedMesh, is_coloured, read_mesh, split_by_side};
use super::schema::Node;
use crate::pbrt::{INSTANCE_BYTES, SceneError};
use petzval_base::io::HeldMemory;
use petzval_scene::{Bvh, Geometry, ShapeSpec};

/// A copy of a mesh in the world.
struct Placement {
    mesh: usize,
    world_from_mesh: DAffine3,
    /// The element of the node.
    node: usize,
}

/// Memory of a placement: in the list of all, which grows by doubling, and in that of its mesh (bytes).
const PLACEMENT_BYTES: u64 = (2 * (size_of::<Placement>() + size_of::<&Placement>())) as u64;

impl SceneParts<'_> {
    /// Walks the tree of nodes and adds what they hold.
    pub fn place_nodes(&mut self) -> Result<(), SceneError> {
        let document = self.document;
        let root = &document.root;
        let mut visited = vec![false; root.nodes.len()];
        let mut placements = Vec::new();
        let refused = |refusal: String| document.too_large("nodes", &refusal);
        let mut held = document.context.hold(0).map_err(refused)?;
        let mut todo: Vec<(usize, DAffine3, String)> = Vec::new();
        let scene = match (root.scene, &root.scenes[..]) {
            (Some(scene), all) => {
                Some((document.entry(all, scene.value(), "scenes", "scene")?, scene.value()))
            }
            (None, [first, ..]) => Some((first, 0)),
            (None, []) => None,
        };
        let Some((scene, number)) = scene else {
            let expected = "expected one that names the nodes to show";
            return Err(document.error("scenes", "the document has no scene", expected));
        };
        for (i, node) in scene.nodes.iter().enumerate().rev() {
            let named_at = format!("scenes/{number}/nodes/{i}");
            todo.push((node.value(), DAffine3::IDENTITY, named_at));
        }
        while let Some((index, world_from_parent, named_at)) = todo.pop() {
            let node = document.entry(&root.nodes, index, "nodes", &named_at)?;
            if std::mem::replace(&mut visited[index], true) {
                let found = format!("nodes[{index}] has two parents");
                return Err(document.error(&named_at, found, "expected a tree of nodes"));
            }
            let element = format!("nodes/{index}");
            let world_from_node = world_from_parent * self.local(node, &element)?;
            if !world_from_node.is_finite() {
                let expected = "expected finite transforms";
                return Err(document.error(&element, "a transform beyond all numbers", expected));
            }
            self.place(index, node, &element, &world_from_node, &mut placements, &mut held)?;
            let children = node.children.as_deref().unwrap_or_default();
            for (i, child) in children.iter().enumerate().rev() {
                todo.push((child.value(), world_from_node, format!("{element}/children/{i}")));
            }
        }
        self.add_meshes(&placements)
    }

    /// Returns the transform of a node to its parent.
    fn local(&self, node: &Node, element: &str) -> Result<DAffine3, SceneError> {
        if let Some(matrix) = node.matrix {
            let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
            if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
                let element = format!("{element}/matrix");
                let expected = "expected 0 0 0 1 as its last row";
                return Err(self.document.error(&element, "a matrix that is not affine", expected));
            }
            return Ok(DAffine3::from_mat4(matrix));
        }
        let vector = |v: Option<[f32; 3]>, default: DVec3| {
            v.map_or(default, |v| DVec3::from_array(v.map(f64::from)))
        };
        Ok(DAffine3::from_scale_rotation_translation(
            vector(node.scale, DVec3::ONE),
            quaternion(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0])),
            vector(node.translation, DVec3::ZERO),
        ))
    }

    /// Adds the light and the camera of a node, and notes the places of its mesh.
    fn place(
        &mut self,
        index: usize,
        node: &Node,
        element: &str,
        world_from_node: &DAffine3,
        placements: &mut Vec<Placement>,
        held: &mut HeldMemory,
    ) -> Result<(), SceneError> {
        let document = self.document;
        if let Some(mesh) = node.mesh {
            document.entry(
                &document.root.meshes,
                mesh.value(),
                "meshes",
                &format!("{element}/mesh"),
            )?;
            if node.weights.is_some() {
                document.warn(element, "morph targets are not read: the mesh has its first form");
            }
            let refused = |refusal: String| document.too_large(element, &refusal);
            let mut poses = document.context.hold(0).map_err(refused)?;
            let copies = copies(document, node, element, &mut poses)?;
            held.add(PLACEMENT_BYTES * copies.len() as u64).map_err(refused)?;
            for world_from_copy in copies {
                let world_from_mesh = *world_from_node * world_from_copy;
                placements.push(Placement { mesh: mesh.value(), world_from_mesh, node: index });
            }
        }
        let light = node.extensions.as_ref().and_then(|all| all.light.as_ref());
        if let Some(light) = light {
            let named_at = format!("{element}/extensions/KHR_lights_punctual/light");
            let light = read_light(document, light.light.value(), world_from_node, &named_at)?;
            self.builder.add_light(light);
            self.lights += 1;
        }
        if let Some(camera) = node.camera {
            let named_at = format!("{element}/camera");
            let camera = read_camera(document, camera.value(), world_from_node, &named_at)?;
            match &self.camera {
                None => self.camera = Some(camera),
                Some(_) => document.warn(&named_at, "only the first camera photographs"),
            }
        }
        Ok(())
    }

    /// Adds the meshes: those that stand in one place to the world, the others to objects. Meshes
    /// that emit light are copied, since objects emit none.
    fn add_meshes(&mut self, placements: &[Placement]) -> Result<(), SceneError> {
        let mut places: HashMap<usize, Vec<&Placement>> = HashMap::new();
        let mut order = Vec::new();
        for placement in placements {
            let determinant = placement.world_from_mesh.matrix3.determinant();
            if determinant == 0.0 || !placement.world_from_mesh.inverse().is_finite() {
                let element = format!("nodes/{}", placement.node);
                self.document.warn(&element, "a node that is flat or a point is left out");
                continue;
            }
            places.entry(placement.mesh).or_insert_with(|| {
                order.push(placement.mesh);
                Vec::new()
            });
            if let Some(all) = places.get_mut(&placement.mesh) {
                all.push(placement);
            }
        }
        for mesh in order {
            self.add_mesh(mesh, &places[&mesh])?;
        }
        Ok(())
    }

    fn add_mesh(&mut self, index: usize, places: &[&Placement]) -> Result<(), SceneError> {
        let document = self.document;
        let mesh = &document.root.meshes[index];
        let asset = mesh.name.as_ref().map(|name| self.builder.unique_name(name));
        let (mesh_name, mut object) = (mesh.name.clone(), None);
        for (i, primitive) in mesh.primitives.iter().enumerate() {
            let element = format!("meshes/{index}/primitives/{i}");
            let material = primitive.material.map(|material| material.value());
            let named_at = format!("{element}/material");
            let coloured = is_coloured(primitive);
            let variant = |mirrored: bool| Variant { mirrored, coloured };
            let surface = self.materials.surface(
                document,
                &mut self.builder,
                material,
                variant(false),
                &named_at,
            )?;
            let Some(PrimitiveMesh { mesh: geometry, sides }) =
                read_mesh(document, primitive, &element, surface.uv_set)?
            else {
                continue;
            };
            let parts = match surface.normal_map {
                true => split_by_side(geometry, sides.as_deref()),
                false => vec![SidedMesh { mesh: geometry, mirrored: false }],
            };
            for SidedMesh { mesh, mirrored } in parts {
                let reflected = |place: &&&Placement| {
                    surface.normal_map && place.world_from_mesh.matrix3.determinant() < 0.0
                };
                // A reflection turns the side of a normal map.
                let own: Vec<&Placement> = match (places, surface.emission.is_some()) {
                    (_, true) | ([_], _) => places.to_vec(),
                    _ => places.iter().filter(reflected).copied().collect(),
                };
                let more = own.len().saturating_sub(1) as u64;
                let tree = Bvh::BYTES_PER_PRIMITIVE + Bvh::BUILD_BYTES_PER_PRIMITIVE;
                let bytes = mesh.bytes()
                    + mesh.triangles.len() as u64 * tree
                    + 2 * size_of::<ShapeSpec>() as u64;
                document
                    .context
                    .claim(more.saturating_mul(bytes))
                    .map_err(|refusal| document.too_large(&element, &refusal))?;
                for place in &own {
                    let side = mirrored != reflected(&place);
                    let surface = self.materials.surface(
                        document,
                        &mut self.builder,
                        material,
                        variant(side),
                        &named_at,
                    )?;
                    let mut mesh = mesh.clone();
                    mesh.transform(&place.world_from_mesh, false);
                    let node = &document.root.nodes[place.node];
                    let name = node.name.clone().or_else(|| mesh_name.clone());
                    self.add_shape(Geometry::Mesh(mesh), surface, None, [name, asset.clone()]);
                }
                if own.len() == places.len() {
                    continue;
                }
                let surface = self.materials.surface(
                    document,
                    &mut self.builder,
                    material,
                    variant(mirrored),
                    &named_at,
                )?;
                let shared = surface.normal_map;
                let id = match (object, shared) {
                    (Some(id), false) => id,
                    _ => {
                        document
                            .context
                            .claim(INSTANCE_BYTES * places.len() as u64)
                            .map_err(|refusal| document.too_large(&element, &refusal))?;
                        let id = self.builder.add_object();
                        for place in places.iter().filter(|place| !(shared && reflected(place))) {
                            self.builder.add_instance(id, place.world_from_mesh);
                        }
                        if !shared {
                            object = Some(id);
                        }
                        id
                    }
                };
                self.add_shape(
                    Geometry::Mesh(mesh),
                    surface,
                    Some(id),
                    [mesh_name.clone(), asset.clone()],
                );
            }
        }
        Ok(())
    }

    fn add_shape(
        &mut self,
        geometry: Geometry,
        surface: ShapeMaterial,
        object: Option<u32>,
        [name, asset]: [Option<String>; 2],
    ) {
        let ShapeMaterial { material, emission, alpha, interface, .. } = surface;
        self.lights += usize::from(emission.is_some());
        let spec =
            ShapeSpec { geometry, material, emission, alpha, interface, object, name, asset };
        self.builder.add_shape(spec);
    }
}
