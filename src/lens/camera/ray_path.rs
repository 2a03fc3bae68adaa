//! The path of one ray through a lens, surface by surface.

use glam::{DAffine3, DVec3};

use super::band::Band;
use super::{Camera, LensColumns, LensModel, RealLens};
use crate::prescription::Prescription;
use crate::pupil::aim::aim_one_f64;
use crate::trace::kernel::LensRay;
use crate::trace::surface::{Surface, SurfaceKind};
use crate::trace::{Blocked, trace_one, trace_one_lossy};
use petzval_base::lanes::Real;
use petzval_base::rays::SampleBatch;
use petzval_base::stats::LensStats;

/// A surface on the path of a ray. Lens frame: mm, the front vertex at z = 0, the film at +z.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceCrossing {
    /// Row of the prescription, from 0 at the scene side.
    pub row: usize,
    /// Kind of the surface.
    pub kind: &'static str,
    /// Intersection with the ray, also outside the clear aperture; `None` if there is none.
    pub point: Option<[f64; 3]>,
    /// Distance of the intersection from the surface's own axis, mm.
    pub height: Option<f64>,
    /// Clear semi-diameter, mm.
    pub semi_diameter: f64,
    /// Angle of incidence, degrees: between the ray and the normal, or the axis for stops, openings
    /// and idealized lenses.
    pub incidence: Option<f64>,
    /// Refractive indices before and behind.
    pub index: [f64; 2],
    /// Share of the light that passes; `None` if the ray ends.
    pub transmittance: Option<f64>,
}

/// The path of a ray from the film through a lens.
#[derive(Clone, Debug)]
pub struct RayPath {
    /// Film point, lens frame, mm.
    pub start: [f64; 3],
    /// Unit direction at the film, lens frame.
    pub direction: [f64; 3],
    /// Weight at the film: cosines over the square of a distance and a density
    /// ([`crate::RealLens`]).
    pub weight: f64,
    /// Whether it was retraced in f64 because f32 was not accurate enough.
    pub retraced: bool,
    /// The surfaces in the order in which the ray meets them.
    pub crossings: Vec<SurfaceCrossing>,
    /// The ray relative to the last vertex, +z in the direction of travel, as in
    /// [`crate::trace()`]; or where and why it ends.
    pub end: Result<LensRay<f64>, Blocked>,
}

impl Camera {
    /// Returns the path through the lens of the first sample of a batch; `None` without a real
    /// lens, or if the film point is dark. It is traced with the arithmetic of
    /// [`Camera::generate_rays`], so that the result has the same bits.
    pub fn ray_path(&self, samples: &SampleBatch) -> Option<RayPath> {
        let LensModel::Real(lens) = &self.model else { return None };
        let mut columns = LensColumns::default();
        let mut stats = LensStats::default();
        let fresnel = lens.fresnel;
        let plane = lens.launch::<f32>(samples, &mut columns, &mut stats);
        let LensColumns { batch, targets, exact, .. } = &mut columns;
        let again = aim_one_f64(samples, lens.pupil_bounds(), targets, &plane, 0);
        let [x, y, z] = [batch.x[0], batch.y[0], batch.z[0]];
        if x.is_nan() {
            return None;
        }
        let t = [batch.tx[0], batch.ty[0], batch.tz[0]];
        let launched = LensRay { p: [x, y, z], t, weight: batch.weight[0] };
        lens.trace_batch::<f32>(samples.band, batch, exact, fresnel, &mut stats, |_| again);
        let redone = stats.retraced > 0;
        let band = &lens.bands[samples.band];
        let mut recorder = PathRecorder::new(lens, fresnel);
        let end = match redone {
            true => recorder.trace::<f64>(again, &band.to_scene_f64, &band.to_scene_f64),
            false => recorder.trace::<f32>(launched, &band.to_scene, &band.to_scene_f64),
        };
        let weight = f64::from(launched.weight);
        Some(RayPath { weight, retraced: redone, ..recorder.path(again, end) })
    }
}

impl RealLens {
    /// Returns the path of a ray from a point of the film to a point in the plane of the rear vertex,
    /// in f64 and at the wavelength in the middle of the bands. The film point is relative to the
    /// middle of the film and in its plane, the other one to the axis (mm). The weight is 1.
    pub fn path_between(&self, film: [f64; 2], rear: [f64; 2]) -> RayPath {
        let start = self.film_pose.film_point(film);
        let way = [rear[0] - start[0], rear[1] - start[1], self.film_distance - start[2]];
        let Band { to_scene_f64: surfaces, film_index, .. } = &self.bands[self.bands.len() / 2];
        let direction = DVec3::from_array(way).normalize() * *film_index;
        let ray = LensRay { p: start, t: direction.to_array(), weight: 1.0 };
        let mut recorder = PathRecorder::new(self, self.fresnel);
        let end = recorder.trace::<f64>(ray, surfaces, surfaces);
        RayPath { retraced: true, ..recorder.path(ray, end) }
    }
}

/// Traces a ray and records the surfaces that it meets.
struct PathRecorder<'a> {
    lens: &'a RealLens,
    fresnel: bool,
    placed: Vec<DAffine3>,
    /// Directions of travel before each row and behind the last.
    travels: Vec<f64>,
    crossings: Vec<SurfaceCrossing>,
}

impl<'a> PathRecorder<'a> {
    fn new(lens: &'a RealLens, fresnel: bool) -> Self {
        let placed = lens.prescription.surface_transforms();
        let travels = lens.prescription.travels();
        Self { lens, fresnel, placed, travels, crossings: Vec::new() }
    }

    /// Returns the recorded path of a ray that leaves the film.
    fn path(self, launched: LensRay<f64>, end: Result<LensRay<f64>, Blocked>) -> RayPath {
        let ([x, y, z], [tx, ty, tz]) = (launched.p, launched.t);
        let lens = &self.lens.prescription;
        let axis = lens.film_axis();
        let travel = lens.travel_before(lens.rows.len());
        let start = DVec3::new(x, y, travel * (self.lens.film_distance - z));
        let direction = DVec3::new(tx, ty, -travel * tz);
        RayPath {
            start: axis.transform_point3(start).to_array(),
            direction: axis.transform_vector3(direction).normalize().to_array(),
            weight: launched.weight,
            retraced: false,
            crossings: self.crossings,
            end,
        }
    }

    /// Traces the ray; `exact` are the same surfaces in f64.
    fn trace<R: Real<Scalar = R>>(
        &mut self,
        mut ray: LensRay<R>,
        surfaces: &[Surface<R>],
        exact: &[Surface<f64>],
    ) -> Result<LensRay<f64>, Blocked> {
        for (surface, exact) in surfaces.iter().zip(exact) {
            let behind = match self.fresnel {
                true => trace_one_lossy(ray, std::slice::from_ref(surface)),
                false => trace_one(ray, std::slice::from_ref(surface)),
            };
            let behind_exactly = behind.as_ref().ok().map(to_f64_ray);
            self.record(&to_f64_ray(&ray), behind_exactly.as_ref(), exact);
            ray = behind?;
        }
        Ok(to_f64_ray(&ray))
    }

    /// Records the crossing of a surface; frame transforms are not recorded.
    fn record(
        &mut self,
        before: &LensRay<f64>,
        behind: Option<&LensRay<f64>>,
        surface: &Surface<f64>,
    ) {
        let Some(kind) = name(surface) else { return };
        // The normal is the direction in which a refraction changes the ray: without a rim, and
        // with a step of the index that causes no total reflection.
        let open = Surface {
            aperture2: f64::INFINITY,
            limit: 0.0,
            n2_step: 3.0 * surface.n2,
            mirror: false,
            ..surface.clone()
        };
        let probe = trace_one(*before, std::slice::from_ref(&open)).ok();
        // Behind a mirror, +z of the trace is the direction after the reflection.
        let place = |ray: &LensRay<f64>, row: usize| {
            let [x, y, z] = ray.p;
            [x, y, -self.travels[row] * z]
        };
        let p = behind.map(|ray| place(ray, surface.row));
        let p = p.or(probe.as_ref().map(|ray| place(ray, surface.row + 1)));
        let placed = &self.placed[surface.row];
        let step = if surface.mirror { 0.0 } else { surface.n2_step };
        let index = [surface.n2, surface.n2 + step].map(f64::sqrt);
        let angle = |probe: &LensRay<f64>| {
            let (from, to) = (DVec3::from_array(before.t), DVec3::from_array(probe.t));
            let normal = if has_normal(&surface.kind) { to - from } else { DVec3::Z };
            from.angle_between(normal).to_degrees()
        };
        self.crossings.push(SurfaceCrossing {
            row: surface.row,
            kind,
            point: p.map(|p| placed.transform_point3(p.into()).to_array()),
            height: p.map(|[x, y, _]| x.hypot(y)),
            semi_diameter: self.prescription().rows[surface.row].diameter / 2.0,
            incidence: probe.as_ref().map(angle),
            index,
            transmittance: behind.map(|ray| ray.weight / before.weight),
        });
    }

    fn prescription(&self) -> &Prescription {
        &self.lens.prescription
    }
}

fn to_f64_ray<R: Real<Scalar = R>>(ray: &LensRay<R>) -> LensRay<f64> {
    let LensRay { p, t, weight } = *ray;
    LensRay { p: p.map(R::to_f64), t: t.map(R::to_f64), weight: R::to_f64(weight) }
}

/// Returns the name of a kind of surface; `None` for frame transforms.
fn name(surface: &Surface<f64>) -> Option<&'static str> {
    Some(match &surface.kind {
        _ if surface.mirror => "mirror",
        SurfaceKind::Stop => "stop",
        SurfaceKind::Sphere if surface.curvature == 0.0 => "plane",
        SurfaceKind::Sphere => "sphere",
        SurfaceKind::Conic(_) => "conic",
        SurfaceKind::Cylinder(_) => "cylinder",
        SurfaceKind::Asphere(_) => "asphere",
        SurfaceKind::Biradial(surface) if surface.toroid => "toroid",
        SurfaceKind::Biradial(_) => "biconic",
        SurfaceKind::Ideal(_) => "ideal lens",
        SurfaceKind::Polynomial(_) => "polynomial",
        SurfaceKind::Iris(_) => "iris",
        SurfaceKind::Obstruction(_) => "obstruction",
        SurfaceKind::Clip(_) => "aperture",
        SurfaceKind::FrameTransform(_) => return None,
    })
}

/// Returns whether its kernel refracts at a normal.
fn has_normal(kind: &SurfaceKind<f64>) -> bool {
    matches!(
        kind,
        SurfaceKind::Sphere
            | SurfaceKind::Conic(_)
            | SurfaceKind::Cylinder(_)
            | SurfaceKind::Asphere(_)
            | SurfaceKind::Biradial(_)
    )
}
