//! Curves: Bezier and B-spline, quadratic and cubic.

use glam::{DAffine3, DVec3};

use super::SceneError;
use super::memory::{MeshSize, require_memory};
use super::params::Params;
use super::reader::SceneReader;
use petzval_scene::{
    CurveKind, CurveSegment, CurveSet, Geometry, Mesh, ShapeSpec, tessellate_curve,
};

#[derive(Clone, Copy, PartialEq)]
enum Basis {
    Bezier,
    BSpline,
}

/// Reads the kind and the segments of a curve.
fn segments(params: &Params) -> Result<(CurveKind, Vec<CurveSegment>), SceneError> {
    let Some(numbers) = params.numbers("P", &["point3"])? else {
        return Err(params.refuse("P", "a curve without \"point3 P\"", "expected control points"));
    };
    let points: Vec<DVec3> =
        numbers.as_chunks::<3>().0.iter().map(|p| DVec3::from_array(*p)).collect();
    let degree = params.float("degree", 3.0)?;
    if degree != 2.0 && degree != 3.0 {
        let found = format!("a curve of degree {degree}");
        return Err(params.refuse("degree", found, "expected 2 or 3"));
    }
    let degree = degree as usize;
    let basis = match params.text("basis")?.unwrap_or("bezier") {
        "bezier" => Basis::Bezier,
        "bspline" => Basis::BSpline,
        other => {
            let found = format!("the basis \"{other}\"");
            return Err(params.refuse("basis", found, "expected bezier or bspline"));
        }
    };
    let whole = basis == Basis::BSpline || (points.len() - 1).is_multiple_of(degree);
    if points.len() <= degree || !whole {
        let found = format!("{} points of a curve", points.len());
        let expected = match basis {
            Basis::BSpline => format!("expected {} or more", degree + 1),
            Basis::Bezier => format!("expected {}, and {degree} more for each segment", degree + 1),
        };
        return Err(params.refuse("P", found, expected));
    }
    let step = match basis {
        Basis::BSpline => 1,
        Basis::Bezier => degree,
    };
    let windows = points.windows(degree + 1).step_by(step);
    let controls: Vec<[DVec3; 4]> = windows.map(|window| control(window, basis)).collect();
    let (kind, facing) = facing(params, controls.len())?;
    let width = params.float("width", 1.0)?;
    let ends = [params.float("width0", width)?, params.float("width1", width)?];
    if ends.iter().any(|&width| width < 0.0) {
        let found = format!("a curve of widths {} and {}", ends[0], ends[1]);
        return Err(params.refuse("width", found, "expected 0 or more"));
    }
    let count = controls.len() as f64;
    let width = |i: usize| ends[0] + (ends[1] - ends[0]) * i as f64 / count;
    let segments = controls.into_iter().enumerate().map(|(i, control)| CurveSegment {
        control,
        width: [width(i), width(i + 1)],
        normals: facing.as_ref().map(|facing| [facing[i], facing[i + 1]]),
    });
    Ok((kind, segments.collect()))
}

/// Makes the mesh of a curve that emits light.
pub(super) fn mesh(params: &Params) -> Result<Mesh, SceneError> {
    let (_, mut segments) = segments(params)?;
    segments.retain(CurveSegment::is_finite);
    let what = format!("a curve of {} segments", segments.len());
    let mut size = MeshSize { vertices: 0, triangles: 0 };
    for segment in &segments {
        let [vertices, triangles] = segment.counts();
        size.vertices += vertices;
        size.triangles += triangles;
    }
    let _held = require_memory(params, &what, size)?;
    Ok(tessellate_curve(&segments))
}

/// The shape that collects consecutive curves, so that a million hairs are not a million shapes.
pub(super) struct OpenCurves {
    shape: u32,
    material: u32,
    object: Option<u32>,
}

impl SceneReader {
    /// Makes a curve, or returns `None` if none of its segments is finite.
    pub(super) fn curve_set(
        &mut self,
        params: &Params,
        ctm: &DAffine3,
        reverse_orientation: bool,
    ) -> Result<Option<CurveSet>, SceneError> {
        let (kind, segments) = segments(params)?;
        let flipped = reverse_orientation ^ (self.state.ctm[0].matrix3.determinant() < 0.0);
        let mut curves = CurveSet::new(kind, flipped);
        let dropped = segments.iter().filter(|segment| !curves.push(segment, ctm)).count();
        if dropped > 0 {
            let why = "have points or widths that are not finite numbers: they are left out";
            self.warnings.warn(&params.at, why, || {
                format!("{dropped} of the {} segments of a curve {why}", segments.len())
            });
        }
        Ok((dropped < segments.len()).then_some(curves))
    }

    /// Adds a shape without alpha. Curves join the last shape of curves, if that has the same
    /// material and is in the same object.
    pub(super) fn add_or_append(&mut self, mut spec: ShapeSpec) {
        let object = spec.object.or(self.open_object_index());
        let material = spec.material;
        let Geometry::Curves(mut curves) = spec.geometry else {
            self.add_shape(spec);
            return;
        };
        let open = self.open_curves.as_ref();
        if let Some(open) = open.filter(|open| (open.material, open.object) == (material, object)) {
            match self.builder.append_curves(open.shape, curves) {
                Ok(()) => return,
                Err(returned) => curves = returned,
            }
        }
        spec.geometry = Geometry::Curves(curves);
        let shape = self.add_shape(spec);
        self.open_curves = Some(OpenCurves { shape, material, object });
    }
}

/// Returns the kind of a curve, and the normals of a ribbon, one more than it has segments.
fn facing(params: &Params, segments: usize) -> Result<(CurveKind, Option<Vec<DVec3>>), SceneError> {
    match params.text("type")?.unwrap_or("flat") {
        "flat" => return Ok((CurveKind::Flat, None)),
        "cylinder" => return Ok((CurveKind::Cylinder, None)),
        "ribbon" => {}
        other => {
            let found = format!("the curve type \"{other}\"");
            return Err(params.refuse("type", found, "expected flat, cylinder or ribbon"));
        }
    }
    let normals = params.numbers("N", &["normal"])?.unwrap_or(&[]).as_chunks::<3>().0;
    let unit: Option<Vec<DVec3>> =
        normals.iter().map(|n| DVec3::from_array(*n).try_normalize()).collect();
    match unit {
        Some(unit) if unit.len() == segments + 1 => Ok((CurveKind::Ribbon, Some(unit))),
        _ => {
            let found = format!("{} normals of a ribbon", normals.len());
            let expected = format!("expected {} that are not zero", segments + 1);
            Err(params.refuse("N", found, expected))
        }
    }
}

/// Returns the cubic Bezier control points of one segment (Farin 2002, "Curves and surfaces for
/// CAGD", chapters 6 and 8).
fn control(points: &[DVec3], basis: Basis) -> [DVec3; 4] {
    let raised = |a: DVec3, b: DVec3, c: DVec3| [a, (a + 2.0 * b) / 3.0, (2.0 * b + c) / 3.0, c];
    match (points, basis) {
        (&[a, b, c], Basis::Bezier) => raised(a, b, c),
        (&[a, b, c], Basis::BSpline) => raised((a + b) / 2.0, b, (b + c) / 2.0),
        (&[a, b, c, d], Basis::BSpline) => [
            (a + 4.0 * b + c) / 6.0,
            (2.0 * b + c) / 3.0,
            (b + 2.0 * c) / 3.0,
            (b + 4.0 * c + d) / 6.0,
        ],
        (points, _) => [0, 1, 2, 3].map(|i| points.get(i).copied().unwrap_or_default()),
    }
}
