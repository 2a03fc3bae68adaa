//! The Shape directive: quadrics, and the dispatch to meshes and curves.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

use super::attributes::Target;
use super::directive_kinds::{Directive, Ignored, SILENT, Selected, known};
use super::forward_references::Deferred;
use super::graphics_state::GraphicsState;
use super::meshes::{self, MeshKind};
use super::moving_shapes::ShapeSpace;
use super::params::Params;
use super::reader::SceneReader;
use super::repeated_meshes::{
    CopyLook, MeshSource, ShapeMeshes, ShapeText, file_stem, geometries, ply_source,
};
use super::{SceneError, curves};
use petzval_scene::{Geometry, Mesh, PatchMesh, Quadric, QuadricForm, ShapeSpec};

/// The kinds of shapes.
#[derive(Clone, Copy)]
enum ShapeKind {
    Mesh(MeshKind),
    Ply,
    Curve,
    Quadric(QuadricKind),
}

#[derive(Clone, Copy)]
enum QuadricKind {
    Sphere,
    Cylinder,
    Disk,
    Cone,
}

const UNDISPLACED: &str = "the surface is not displaced; write it as a plymesh";
const SHADOW_ALPHA: Ignored = ("shadowalpha", "alpha alone decides");
const PLY_IGNORES: &[Ignored] = &[
    ("emissionfilename", "the light is of one colour"),
    SHADOW_ALPHA,
    ("discarddegenerateUVs", SILENT),
];
const MESH_IGNORES: &[Ignored] = &[
    ("S", "tangents follow the texture coordinates"),
    ("faceIndices", SILENT),
    ("emissionfilename", "the light is of one colour"),
    SHADOW_ALPHA,
    ("discarddegenerateUVs", SILENT),
    ("displacement", UNDISPLACED),
    ("edgelength", UNDISPLACED),
    ("displacement.edgelength", UNDISPLACED),
];

static SHAPE: Directive<ShapeKind> = Directive {
    name: "Shape",
    target: Some(Target::Shape),
    shared: &["alpha"],
    kinds: &[
        known(
            "trianglemesh",
            ShapeKind::Mesh(MeshKind::Triangles),
            &["P", "indices", "N", "S", "uv", "st"],
            MESH_IGNORES,
        ),
        known(
            "plymesh",
            ShapeKind::Ply,
            &["filename", "displacement", "edgelength", "displacement.edgelength"],
            PLY_IGNORES,
        ),
        known(
            "sphere",
            ShapeKind::Quadric(QuadricKind::Sphere),
            &["radius", "zmin", "zmax", "phimax"],
            &[SHADOW_ALPHA],
        ),
        known(
            "disk",
            ShapeKind::Quadric(QuadricKind::Disk),
            &["height", "radius", "innerradius", "phimax"],
            &[SHADOW_ALPHA],
        ),
        known(
            "cone",
            ShapeKind::Quadric(QuadricKind::Cone),
            &["height", "radius", "phimax"],
            &[SHADOW_ALPHA],
        ),
        known(
            "cylinder",
            ShapeKind::Quadric(QuadricKind::Cylinder),
            &["radius", "zmin", "zmax", "phimax"],
            &[SHADOW_ALPHA],
        ),
        known(
            "paraboloid",
            ShapeKind::Mesh(MeshKind::Paraboloid),
            &["radius", "zmin", "zmax", "phimax"],
            &[SHADOW_ALPHA],
        ),
        known(
            "hyperboloid",
            ShapeKind::Mesh(MeshKind::Hyperboloid),
            &["p1", "p2", "phimax"],
            &[SHADOW_ALPHA],
        ),
        known(
            "bilinearmesh",
            ShapeKind::Mesh(MeshKind::BilinearPatches),
            &["P", "indices", "N", "uv"],
            MESH_IGNORES,
        ),
        known(
            "loopsubdiv",
            ShapeKind::Mesh(MeshKind::LoopSubdivision),
            &["P", "indices", "levels", "nlevels"],
            &[SHADOW_ALPHA, ("scheme", SILENT)],
        ),
        known(
            "curve",
            ShapeKind::Curve,
            &["P", "N", "basis", "degree", "type", "width", "width0", "width1"],
            &[SHADOW_ALPHA, ("splitdepth", SILENT)],
        ),
        known(
            "nurbs",
            ShapeKind::Mesh(MeshKind::Nurbs),
            &[
                "nu", "uorder", "uknots", "u0", "u1", "nv", "vorder", "vknots", "v0", "v1", "P",
                "Pw",
            ],
            &[SHADOW_ALPHA],
        ),
        known(
            "heightfield",
            ShapeKind::Mesh(MeshKind::HeightField),
            &["nu", "nv", "Pz"],
            &[SHADOW_ALPHA],
        ),
    ],
};

impl SceneReader {
    pub(super) fn shape(&mut self) -> Result<(), SceneError> {
        self.require_in_world("Shape")?;
        let name = self.string()?;
        let is_own = |param: &str| SHAPE.knows_param(&name, param);
        let (mut params, text) = self.shape_params(is_own)?;
        let material = self.overridden_material(&mut params, is_own)?;
        let Selected { name, kind: Some(kind), mut params } =
            self.check_kind(&SHAPE, &name, params)?
        else {
            return Ok(());
        };
        let Some(ShapeSpace { object, transform: ctm }) =
            self.shape_space(name, matches!(kind, ShapeKind::Curve))
        else {
            return Ok(());
        };
        let GraphicsState { reverse_orientation, area_light, .. } = self.state.clone();
        let file_name = match kind {
            ShapeKind::Ply => params.text("filename")?.and_then(|file| file_stem(Path::new(file))),
            _ => None,
        };
        let geometries = match kind {
            ShapeKind::Quadric(kind) => {
                let quadric = quadric(kind, &params, &ctm, reverse_orientation)?;
                if quadric.is_none() {
                    let feature = format!("a {name} that its transform flattens");
                    self.warnings.unsupported(&params.at, &feature, "it is left out");
                }
                quadric.into_iter().map(Geometry::Quadric).collect()
            }
            ShapeKind::Curve if area_light.is_none() => {
                let curves = self.curve_set(&params, &ctm, reverse_orientation)?;
                curves.into_iter().map(Geometry::Curves).collect()
            }
            ShapeKind::Curve => {
                let (mut mesh, mut patches) = (curves::mesh(&params)?, PatchMesh::default());
                transform(&params, &mut mesh, &mut patches, &ctm, reverse_orientation)?;
                vec![Geometry::Mesh(mesh)]
            }
            ShapeKind::Mesh(_) | ShapeKind::Ply => {
                let source = match kind {
                    ShapeKind::Ply => ply_source(&params),
                    _ => text.as_ref().map(|text| MeshSource::Text(text.place())),
                };
                let meshes = self.shape_meshes(name, kind, &params, source.as_ref(), text)?;
                let in_world = object.or(self.open_object_index()).is_none();
                let plain = area_light.is_none() && params.find("alpha").is_none();
                if let (Some(source), true) = (&source, in_world && plain) {
                    let interface = self.shape_interface();
                    let look = CopyLook { material, interface, reverse_orientation };
                    if self.add_as_instance(name, source, &meshes, look, &ctm)? {
                        return Ok(());
                    }
                }
                let (mut triangles, mut patches) = Arc::unwrap_or_clone(meshes);
                transform(&params, &mut triangles, &mut patches, &ctm, reverse_orientation)?;
                geometries(triangles, patches)
            }
        };
        let mut shapes = Vec::new();
        for mut geometry in geometries {
            if area_light.is_some() {
                geometry = geometry.into_emitter();
            }
            self.claim_shape(name, object.or(self.open_object_index()), &geometry)?;
            let spec = ShapeSpec {
                emission: area_light.clone(),
                interface: self.shape_interface(),
                object,
                name: file_name.clone(),
                ..ShapeSpec::new(geometry, material)
            };
            match params.find("alpha") {
                None => self.add_or_append(spec),
                Some(_) => shapes.push(self.add_shape(spec)),
            }
        }
        // Only alpha is deferred, without the large arrays of a mesh.
        params.all.retain(|param| param.name == "alpha");
        match params.all.is_empty() {
            true => Ok(()),
            false => self.define_or_defer(Deferred::Alpha { shapes, params }),
        }
    }

    /// Reads the meshes of a shape, or returns them if they are known.
    fn shape_meshes(
        &mut self,
        name: &str,
        kind: ShapeKind,
        params: &Params,
        source: Option<&MeshSource>,
        text: Option<Arc<ShapeText>>,
    ) -> Result<Arc<ShapeMeshes>, SceneError> {
        if let Some(known) = source.and_then(|source| self.known_meshes(source)) {
            return Ok(known);
        }
        let meshes = Arc::new(match kind {
            ShapeKind::Mesh(kind) => self.mesh_shape(name, kind, params)?,
            _ => self.ply_shape(name, params)?,
        });
        if let Some(source) = source {
            self.keep_meshes(source, text, &meshes);
        }
        Ok(meshes)
    }

    /// Makes the triangles and patches of a mesh, without those that are not finite.
    fn mesh_shape(
        &mut self,
        name: &str,
        kind: MeshKind,
        params: &Params,
    ) -> Result<(Mesh, PatchMesh), SceneError> {
        let (mut triangles, mut patches) = meshes::make(kind, params, &mut self.warnings)?;
        self.drop_non_finite(name, params, &mut triangles, &mut patches);
        Ok((triangles, patches))
    }

    /// Drops triangles and patches with vertices that are not finite, with a warning.
    pub(super) fn drop_non_finite(
        &mut self,
        name: &str,
        params: &Params,
        triangles: &mut Mesh,
        patches: &mut PatchMesh,
    ) {
        let all = triangles.triangles.len() + patches.patches.len();
        let dropped = triangles.drop_non_finite() + patches.drop_non_finite();
        if dropped > 0 {
            let why = "have vertices that are not finite numbers: they are left out";
            self.warnings.warn(&params.at, why, || {
                format!("{dropped} of the {all} triangles of a {name} {why}")
            });
        }
    }

    pub(super) fn add_shape(&mut self, spec: ShapeSpec) -> u32 {
        let object = spec.object.or(self.open_object_index());
        if object.is_some() && spec.emission.is_some() {
            self.warn_unsupported("an area light inside an object", "the shape emits no light");
        }
        let emits = spec.emission.is_some();
        let shape = self.builder.add_shape(ShapeSpec { object, ..spec });
        if emits {
            self.emitters.push((shape, self.at.clone()));
        }
        shape
    }
}

/// Transforms triangles and patches to the space of their object or the world.
fn transform(
    params: &Params,
    triangles: &mut Mesh,
    patches: &mut PatchMesh,
    ctm: &DAffine3,
    reverse_orientation: bool,
) -> Result<(), SceneError> {
    triangles.transform(ctm, reverse_orientation);
    patches.transform(ctm, reverse_orientation);
    let mut positions = triangles.positions.iter().chain(&patches.vertices.positions);
    if positions.all(|p| p.iter().all(|v| v.is_finite())) {
        return Ok(());
    }
    let found = "a mesh that its transform moves out of the range of f32";
    Err(SceneError::at(params.at.clone(), found, "check the transform"))
}

/// Makes a quadric. Returns `None` if its transform flattens it.
fn quadric(
    kind: QuadricKind,
    params: &Params,
    ctm: &DAffine3,
    reverse_orientation: bool,
) -> Result<Option<Quadric>, SceneError> {
    let phi_max = params.positive("phimax", 360.0)?.min(360.0).to_radians();
    let phi_max = if phi_max > TAU - 1e-9 { TAU } else { phi_max };
    Ok(Quadric::new(form(kind, params)?, phi_max, *ctm, reverse_orientation))
}

fn form(kind: QuadricKind, params: &Params) -> Result<QuadricForm, SceneError> {
    let radius = params.positive("radius", 1.0)?;
    let heights = |[low, high]: [f64; 2]| -> Result<[f64; 2], SceneError> {
        let z = [params.float("zmin", low)?, params.float("zmax", high)?];
        Ok([z[0].min(z[1]), z[0].max(z[1])])
    };
    let flat = |found: &str| params.refuse("zmin", found, "expected zmin below zmax");
    Ok(match kind {
        QuadricKind::Sphere => {
            let z = heights([-radius, radius])?.map(|z| z.clamp(-radius, radius));
            if z[0] == z[1] {
                return Err(flat("a sphere of height 0"));
            }
            QuadricForm::Sphere { radius, z }
        }
        QuadricKind::Cylinder => {
            let z = heights([-1.0, 1.0])?;
            if z[0] == z[1] {
                return Err(flat("a cylinder of height 0"));
            }
            QuadricForm::Cylinder { radius, z }
        }
        QuadricKind::Disk => {
            let inner = params.float("innerradius", 0.0)?;
            if !(0.0..radius).contains(&inner) {
                let found = format!("an inner radius of {inner}");
                return Err(params.refuse("innerradius", found, "expected 0 to below the radius"));
            }
            QuadricForm::Disk { radius, inner, height: params.float("height", 0.0)? }
        }
        QuadricKind::Cone => {
            let height = params.float("height", 1.0)?;
            if height == 0.0 {
                return Err(params.refuse("height", "a cone of height 0", "use a disk"));
            }
            QuadricForm::Cone { radius, height }
        }
    })
}
