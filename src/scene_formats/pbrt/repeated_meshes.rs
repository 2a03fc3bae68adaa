//! Meshes that a scene repeats: they are read once, and many copies are instances of one object.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::attributes::Target;
use super::lexer::LexerPosition;
use super::params::{Param, Params, Values};
use super::reader::SceneReader;
use super::{SceneError, resolve};
use petzval_scene::{Geometry, MediumInterface, Mesh, PatchMesh, ShapeSpec};
use petzval_spectrum::ColourSpace;

/// Copies of a mesh before further ones are instances: the hierarchy of an object pays if many share it.
const MIN_COPIES: u32 = 8;
/// Fewest triangles and patches of a mesh whose copies become instances.
const MIN_PRIMITIVES: usize = 32;
/// Longest list of numbers that is kept with the other parameters of a shape.
const SHORT: usize = 16;

/// The triangles and the patches of a shape, in its own space.
pub(super) type ShapeMeshes = (Mesh, PatchMesh);

/// A place in the text of an included file that is kept: its address and an offset.
pub(super) type TextPlace = (usize, usize);

/// The source of a mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum MeshSource {
    /// A PLY file.
    Ply(PathBuf),
    /// A directive.
    Text(TextPlace),
}

/// A directive with a mesh in an included file.
pub(super) struct ShapeText {
    place: TextPlace,
    /// Its parameters without the long lists of the mesh.
    params: Params,
    end: LexerPosition,
}

impl MeshSource {
    /// Returns the name of its file without the extension.
    fn file_name(&self) -> Option<String> {
        match self {
            Self::Ply(path) => file_stem(path),
            Self::Text(_) => None,
        }
    }
}

/// Returns the name of a file without its extensions, as shapes of it are called.
pub(super) fn file_stem(path: &Path) -> Option<String> {
    let stem = path.file_name()?.to_string_lossy();
    let stem = stem.strip_suffix(".gz").unwrap_or(&stem);
    Some(stem.strip_suffix(".ply").unwrap_or(stem).to_owned())
}

impl ShapeText {
    /// Returns the place of its parameters.
    pub(super) fn place(&self) -> TextPlace {
        self.place
    }
}

/// The parts of a copy that its object contains besides the mesh.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct CopyLook {
    pub(super) material: u32,
    pub(super) interface: Option<MediumInterface>,
    pub(super) reverse_orientation: bool,
}

/// Copies of a mesh that look alike.
struct Copies {
    look: CopyLook,
    count: u32,
    /// The object of which further copies are instances.
    object: Option<u32>,
}

#[derive(Default)]
struct RepeatedMesh {
    reads: u32,
    meshes: Option<Arc<ShapeMeshes>>,
    copies: Vec<Copies>,
}

/// A material of an included file that needs nothing but its text.
pub(super) struct RepeatedMaterial {
    pub(super) index: u32,
    pub(super) space: ColourSpace,
}

/// The meshes and the materials of a scene by their sources.
#[derive(Default)]
pub(super) struct Repeated {
    meshes: HashMap<MeshSource, RepeatedMesh>,
    /// Directives whose meshes are known.
    texts: HashMap<TextPlace, Arc<ShapeText>>,
    pub(super) materials: HashMap<TextPlace, RepeatedMaterial>,
}

impl SceneReader {
    /// Returns the place of the next token, if its text is kept and `Attribute` adds nothing to a
    /// directive of this kind.
    pub(super) fn kept_place(&self, target: Target) -> Option<TextPlace> {
        let lexer = self.lexers.last().filter(|_| self.peeked.is_none())?;
        let text = self.included.kept(lexer)?;
        self.state.attributes[target as usize].is_empty().then_some((text, lexer.offset()))
    }

    /// Reads the parameters of a shape. If its mesh is known, skips the text, and returns them without
    /// the lists of the mesh. `is_own` tells the parameters of the shape.
    pub(super) fn shape_params(
        &mut self,
        is_own: impl Fn(&str) -> bool,
    ) -> Result<(Params, Option<Arc<ShapeText>>), SceneError> {
        let Some(place) = self.kept_place(Target::Shape) else { return Ok((self.params()?, None)) };
        if let (Some(text), Some(lexer)) = (self.repeated.texts.get(&place), self.lexers.last_mut())
        {
            lexer.seek(text.end);
            let params = Params { space: self.state.colour_space, ..text.params.clone() };
            return Ok((params, Some(text.clone())));
        }
        let depth = self.lexers.len();
        self.params_end = None;
        let params = self.params()?;
        let Some((_, end)) = self.params_end.filter(|(at, _)| *at == depth) else {
            return Ok((params, None));
        };
        let is_long = |param: &&Param| {
            let Values::Numbers(numbers) = &param.values else { return false };
            numbers.len() > SHORT && is_own(&param.name)
        };
        let all = params.all.iter().filter(|param| !is_long(param)).cloned().collect();
        let Params { at, folder, context, space, .. } = &params;
        let (at, folder, context) = (at.clone(), folder.clone(), context.clone());
        let short = Params { all, at, space: *space, folder, context };
        Ok((params, Some(Arc::new(ShapeText { place, params: short, end }))))
    }

    /// Returns the meshes of a source that are known.
    pub(super) fn known_meshes(&self, source: &MeshSource) -> Option<Arc<ShapeMeshes>> {
        self.repeated.meshes.get(source)?.meshes.clone()
    }

    /// Keeps the meshes of a source that is likely to be read again, if there is memory.
    pub(super) fn keep_meshes(
        &mut self,
        source: &MeshSource,
        text: Option<Arc<ShapeText>>,
        meshes: &Arc<ShapeMeshes>,
    ) {
        let known = self.repeated.meshes.entry(source.clone()).or_default();
        known.reads += 1;
        // A text is kept from its second inclusion on.
        let again = known.reads > 1 || matches!(source, MeshSource::Text(_));
        let bytes = meshes.0.bytes() + meshes.1.bytes();
        if again && self.context.claim(bytes).is_ok() {
            known.meshes = Some(meshes.clone());
            if let (MeshSource::Text(place), Some(text)) = (source, text) {
                self.repeated.texts.insert(*place, text);
            }
        }
    }

    /// Adds an instance in place of a further copy of a mesh, if there are many that look alike.
    /// Returns whether it did.
    pub(super) fn add_as_instance(
        &mut self,
        name: &str,
        source: &MeshSource,
        meshes: &ShapeMeshes,
        look: CopyLook,
        transform: &DAffine3,
    ) -> Result<bool, SceneError> {
        let Some(known) = self.repeated.meshes.get_mut(source) else { return Ok(false) };
        let found = known.copies.iter().position(|copies| copies.look == look);
        let number = found.unwrap_or_else(|| {
            known.copies.push(Copies { look, count: 0, object: None });
            known.copies.len() - 1
        });
        let copies = &mut known.copies[number];
        copies.count = copies.count.saturating_add(1);
        let primitives = meshes.0.triangles.len() + meshes.1.patches.len();
        if copies.count <= MIN_COPIES || primitives < MIN_PRIMITIVES || !keeps(transform, meshes) {
            return Ok(false);
        }
        let object = match copies.object {
            Some(object) => object,
            None => {
                let object = self.builder.add_object();
                copies.object = Some(object);
                let file = source.file_name();
                if let Some(file) = &file {
                    self.builder.name_object(object, file);
                }
                self.fill_object((name, file), object, meshes, look)?;
                object
            }
        };
        self.count_instances(1)?;
        self.builder.add_instance(object, *transform);
        Ok(true)
    }

    /// Adds the shapes of meshes to an object.
    fn fill_object(
        &mut self,
        (kind, name): (&str, Option<String>),
        object: u32,
        meshes: &ShapeMeshes,
        look: CopyLook,
    ) -> Result<(), SceneError> {
        let CopyLook { material, interface, reverse_orientation } = look;
        let (mut triangles, mut patches) = meshes.clone();
        triangles.transform(&DAffine3::IDENTITY, reverse_orientation);
        patches.transform(&DAffine3::IDENTITY, reverse_orientation);
        for geometry in geometries(triangles, patches) {
            self.claim_shape(kind, Some(object), &geometry)?;
            let spec = ShapeSpec::new(geometry, material);
            let name = name.clone();
            self.add_shape(ShapeSpec { interface, object: Some(object), name, ..spec });
        }
        Ok(())
    }
}

/// Returns the source of a PLY mesh that nothing displaces.
pub(super) fn ply_source(params: &Params) -> Option<MeshSource> {
    let name = params.text("filename").ok()??;
    let displaced = params.find("displacement").is_some();
    (!displaced).then(|| MeshSource::Ply(resolve(&params.folder, name)))
}

/// Returns the geometries of meshes that are not empty.
pub(super) fn geometries(triangles: Mesh, patches: PatchMesh) -> Vec<Geometry> {
    let mut geometries = Vec::new();
    if !triangles.triangles.is_empty() {
        geometries.push(Geometry::Mesh(triangles));
    }
    if !patches.patches.is_empty() {
        geometries.push(Geometry::Patches(patches));
    }
    geometries
}

/// Returns whether a transform keeps the volume of space, and the vertices within the range of f32.
fn keeps(transform: &DAffine3, (triangles, patches): &ShapeMeshes) -> bool {
    let positions = triangles.positions.iter().chain(&patches.vertices.positions);
    let largest = positions.flatten().fold(0.0f32, |largest, v| largest.max(v.abs()));
    let corner = DVec3::splat(f64::from(largest));
    let matrix = transform.matrix3.to_cols_array().map(f64::abs);
    let reach = glam::DMat3::from_cols_array(&matrix) * corner + transform.translation.abs();
    transform.inverse().is_finite() && reach.max_element() < f64::from(f32::MAX) / 16.0
}
