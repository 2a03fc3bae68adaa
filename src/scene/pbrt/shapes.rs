//! The Shape directive: quadrics, and the dispatch to meshes.

use std::f64::consts::TAU;

use glam::DAffine3;

use super::attributes::Target;
use super::directive_kinds::{Directive, Ignored, SILENT, Selected, known, similar, unsupported};
use super::forward_references::Deferred;
use super::graphics_state::GraphicsState;
use super::meshes::{self, MeshKind};
use super::moving_shapes::ShapeSpace;
use super::params::Params;
use super::reader::SceneReader;
use super::{SceneError, WarningLog};
use crate::scene::{Geometry, Mesh, Quadric, QuadricForm, ShapeSpec};

/// The kinds of shapes.
#[derive(Clone, Copy)]
enum ShapeKind {
    Mesh(MeshKind),
    Quadric(QuadricKind),
}

#[derive(Clone, Copy)]
enum QuadricKind {
    Sphere,
    Cylinder,
    Disk,
    Cone,
}

const UNSUPPORTED: &str = "the shape is left out";
const UNDISPLACED: &str = "the surface is not displaced";
const SHADOW_ALPHA: Ignored = ("shadowalpha", "alpha alone decides");
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
            &["P", "indices", "N", "uv", "st"],
            MESH_IGNORES,
        ),
        known("plymesh", ShapeKind::Mesh(MeshKind::Ply), &["filename"], MESH_IGNORES),
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
        unsupported("paraboloid", UNSUPPORTED),
        unsupported("hyperboloid", UNSUPPORTED),
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
        similar(
            "curve",
            ShapeKind::Mesh(MeshKind::Curve),
            &["P", "N", "basis", "degree", "type", "width", "width0", "width1"],
            &[SHADOW_ALPHA, ("splitdepth", SILENT)],
            "it is a tube of six sides, or a strip",
        ),
        unsupported("nurbs", UNSUPPORTED),
        unsupported("heightfield", UNSUPPORTED),
    ],
};

/// Limit of the triangles of all tessellated bilinear patches of a scene, if there are fewer
/// patches than that. Each mesh may take half of what is left; beyond that, its tolerance grows.
const MAX_PATCH_TRIANGLES: u64 = 1 << 21;

impl SceneReader {
    pub(super) fn shape(&mut self) -> Result<(), SceneError> {
        self.require_in_world("Shape")?;
        let Selected { name, kind: Some(kind), mut params } = self.select(&SHAPE)? else {
            return Ok(());
        };
        let Some(ShapeSpace { object, transform: ctm }) = self.shape_space(name) else {
            return Ok(());
        };
        let GraphicsState { reverse_orientation, material, area_light, .. } = self.state.clone();
        let geometries = match kind {
            ShapeKind::Quadric(kind) => {
                let quadric = quadric(kind, &params, &ctm, reverse_orientation)?;
                if quadric.is_none() {
                    let feature = format!("a {name} that its transform flattens");
                    self.warnings.unsupported(&params.at, &feature, "it is left out");
                }
                quadric.into_iter().map(Geometry::Quadric).collect()
            }
            ShapeKind::Mesh(kind) => {
                let left = MAX_PATCH_TRIANGLES.saturating_sub(self.patch_triangles);
                let warnings = &mut self.warnings;
                let mut meshes = meshes::make(kind, &params, left / 2, warnings)?;
                drop_non_finite(name, &params, &mut meshes, warnings);
                transform(&params, &mut meshes, &ctm, reverse_orientation)?;
                meshes.into_iter().map(Geometry::Mesh).collect::<Vec<Geometry>>()
            }
        };
        let mut shapes = Vec::new();
        for geometry in geometries {
            if let Geometry::Mesh(mesh) = &geometry {
                self.patch_triangles += mesh.patch_starts.len() as u64;
            }
            self.claim_shape(name, object.or(self.open_object_index()), &geometry)?;
            shapes.push(self.add_shape(ShapeSpec {
                emission: area_light.clone(),
                object,
                ..ShapeSpec::new(geometry, material)
            }));
        }
        // Only alpha is deferred, without the large arrays of a mesh.
        params.all.retain(|param| param.name == "alpha");
        match params.all.is_empty() {
            true => Ok(()),
            false => self.define_or_defer(Deferred::Alpha { shapes, params }),
        }
    }

    fn add_shape(&mut self, spec: ShapeSpec) -> u32 {
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

/// Drops triangles with vertices that are not finite, with a warning.
fn drop_non_finite(name: &str, params: &Params, meshes: &mut [Mesh], warnings: &mut WarningLog) {
    let all: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let dropped: usize = meshes.iter_mut().map(Mesh::drop_non_finite).sum();
    if dropped > 0 {
        let found = format!("{dropped} of the {all} triangles of a {name}");
        let why = "have vertices that are not finite numbers: they are left out";
        warnings.warn(&params.at, format!("{found} {why}"));
    }
}

/// Transforms meshes to the space of their object or the world, and drops those without triangles.
fn transform(
    params: &Params,
    meshes: &mut Vec<Mesh>,
    ctm: &DAffine3,
    reverse_orientation: bool,
) -> Result<(), SceneError> {
    for mesh in meshes.iter_mut() {
        mesh.transform(ctm, reverse_orientation);
        if !mesh.positions.iter().flatten().all(|v| v.is_finite()) {
            let found = "a mesh that its transform moves out of the range of f32";
            return Err(SceneError::at(params.at.clone(), found, "check the transform"));
        }
    }
    meshes.retain(|mesh| !mesh.triangles.is_empty());
    Ok(())
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
