//! The way of one ray through a lens, surface by surface.

use glam::{DAffine3, DVec3};

use super::aim::aimed;
use super::camera::{Camera, LensColumns, Model, RealLens};
use super::prescription::Prescription;
use super::refract::LensRay;
use super::surface::{Kind, Surface};
use super::trace::{Blocked, trace_one, trace_one_lossy};
use crate::lanes::Real;
use crate::plan::EFFECTS;
use crate::rays::SampleBatch;
use crate::stats::LensStats;

/// A surface that a ray comes to. Lens frame: mm, the front vertex at z = 0, the film at +z.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossing {
    /// Row of the prescription, from 0 at the scene side.
    pub row: usize,
    /// What kind of surface it is.
    pub kind: &'static str,
    /// Where the ray meets it, also outside the clear aperture; `None` where it does not.
    pub at: Option<[f64; 3]>,
    /// How far from the surface's own axis that is, mm.
    pub height: Option<f64>,
    /// Half the clear diameter, mm.
    pub clear: f64,
    /// Angle between the ray and the normal, degrees; of planes that bend nothing, and of what is
    /// no real surface, between the ray and the axis.
    pub incidence: Option<f64>,
    /// Refractive index before and behind.
    pub index: [f64; 2],
    /// The share of its light that goes on; `None` where the ray ends.
    pub passed: Option<f64>,
}

/// The way of a ray from the film through a lens.
#[derive(Clone, Debug)]
pub struct Passage {
    /// Where it leaves the film, lens frame, mm.
    pub start: [f64; 3],
    /// In which direction, lens frame, of unit length.
    pub towards: [f64; 3],
    /// What it counts on the film: cosines over the square of a distance and a density
    /// ([`super::RealLens`]).
    pub weight: f64,
    /// Whether f32 could not trace it exactly enough, and f64 did.
    pub redone: bool,
    /// The surfaces in the order in which it comes to them.
    pub crossings: Vec<Crossing>,
    /// The ray relative to the last vertex, +z along its way, as [`super::trace()`] has it; or
    /// where and why it ends.
    pub end: Result<LensRay<f64>, Blocked>,
}

impl Camera {
    /// The way through the lens of the first sample of a batch; `None` without a real lens, or where
    /// no light comes to the film point. It is traced in the arithmetic of [`Camera::expose`], so it
    /// ends with the same bits.
    pub fn passage(&self, samples: &SampleBatch) -> Option<Passage> {
        let Model::Real(lens) = &self.model else { return None };
        let mut columns = LensColumns::default();
        let blocked = vec![0; lens.prescription.rows.len()];
        let mut stats = LensStats { blocked, ..LensStats::default() };
        let fresnel = EFFECTS && lens.fresnel;
        let plane = lens.launch::<f32>(samples, &mut columns, &mut stats);
        let LensColumns { batch, targets, exact, .. } = &mut columns;
        let again = aimed(samples, lens.bound(), targets, &plane, 0);
        let [x, y, z] = [batch.x[0], batch.y[0], batch.z[0]];
        if x.is_nan() {
            return None;
        }
        let t = [batch.tx[0], batch.ty[0], batch.tz[0]];
        let launched = LensRay { p: [x, y, z], t, weight: batch.weight[0] };
        lens.pass::<f32>(samples.band, batch, exact, fresnel, &mut stats, |_| again);
        let redone = stats.redone > 0;
        let band = &lens.bands[samples.band];
        let mut way =
            Way { lens, fresnel, placed: lens.prescription.placements(), met: Vec::new() };
        let end = match redone {
            true => way.follow::<f64>(again, &band.exact, &band.exact),
            false => way.follow::<f32>(launched, &band.surfaces, &band.exact),
        };
        let middle = lens.prescription.length() + lens.film_distance;
        let [x, y, z] = again.p;
        Some(Passage {
            start: [x, y, middle - z],
            towards: outward(again.t),
            weight: f64::from(launched.weight),
            redone,
            crossings: way.met,
            end,
        })
    }
}

/// A direction of the trace, in the lens frame and of unit length.
fn outward([x, y, z]: [f64; 3]) -> [f64; 3] {
    DVec3::new(x, y, -z).normalize().to_array()
}

/// A ray on its way, and what it has met.
struct Way<'a> {
    lens: &'a RealLens,
    fresnel: bool,
    placed: Vec<DAffine3>,
    met: Vec<Crossing>,
}

impl Way<'_> {
    /// Follows the ray; `exact` are the same surfaces in f64.
    fn follow<R: Real<Scalar = R>>(
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
            let behind_exactly = behind.as_ref().ok().map(double);
            self.meet(&double(&ray), behind_exactly.as_ref(), exact);
            ray = behind?;
        }
        Ok(double(&ray))
    }

    /// Writes down what the ray meets at a surface, if it is one.
    fn meet(
        &mut self,
        before: &LensRay<f64>,
        behind: Option<&LensRay<f64>>,
        surface: &Surface<f64>,
    ) {
        let Some(kind) = name(&surface.kind, surface.curvature) else { return };
        // Wide open, and with a step of the index that reflects nothing and shows the normal.
        let open = Surface {
            aperture2: f64::INFINITY,
            limit: 0.0,
            n2_step: 3.0 * surface.n2,
            ..surface.clone()
        };
        let probe = trace_one(*before, std::slice::from_ref(&open)).ok();
        let p = behind.or(probe.as_ref()).map(|ray| ray.p);
        let placed = &self.placed[surface.row];
        let index = [surface.n2, surface.n2 + surface.n2_step].map(f64::sqrt);
        let angle = |probe: &LensRay<f64>| {
            let (from, to) = (DVec3::from_array(before.t), DVec3::from_array(probe.t));
            let normal = if bends(&surface.kind) { to - from } else { DVec3::Z };
            from.angle_between(normal).to_degrees()
        };
        self.met.push(Crossing {
            row: surface.row,
            kind,
            at: p.map(|[x, y, z]| placed.transform_point3(DVec3::new(x, y, -z)).to_array()),
            height: p.map(|[x, y, _]| x.hypot(y)),
            clear: self.prescription().rows[surface.row].diameter / 2.0,
            incidence: probe.as_ref().map(angle),
            index,
            passed: behind.map(|ray| ray.weight / before.weight),
        });
    }

    fn prescription(&self) -> &Prescription {
        &self.lens.prescription
    }
}

fn double<R: Real<Scalar = R>>(ray: &LensRay<R>) -> LensRay<f64> {
    let LensRay { p, t, weight } = *ray;
    LensRay { p: p.map(R::to_f64), t: t.map(R::to_f64), weight: R::to_f64(weight) }
}

/// What a kind of surface is called; a turn between two frames is none.
fn name(kind: &Kind<f64>, curvature: f64) -> Option<&'static str> {
    Some(match kind {
        Kind::Stop => "stop",
        Kind::Sphere if curvature == 0.0 => "plane",
        Kind::Sphere => "sphere",
        Kind::Conic(_) => "conic",
        Kind::Cylinder(_) => "cylinder",
        Kind::Asphere(_) => "asphere",
        Kind::Ideal(_) => "ideal lens",
        Kind::Polynomial(_) => "polynomial",
        Kind::Iris(_) => "iris",
        Kind::Obstruction(_) => "obstruction",
        Kind::Turn(_) => return None,
    })
}

/// Whether its kernel bends rays by a normal.
fn bends(kind: &Kind<f64>) -> bool {
    matches!(kind, Kind::Sphere | Kind::Conic(_) | Kind::Cylinder(_) | Kind::Asphere(_))
}
