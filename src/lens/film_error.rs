//! How far apart two cameras see the same things, on film.

use glam::{DAffine3, DVec3};

use super::camera::{Camera, LensColumns, Model, RealLens};
use super::paraxial::Paraxial;
use super::prescription::Axis;
use super::refract::LensRay;
use super::simulated::{PupilPoint, launched};
use super::thin::ThinLens;
use crate::lanes::f32x8;
use crate::rays::{LensBatch, Ray, RayBatch, SampleBatch, WAVE};
use crate::stats::LensStats;

/// Waves of rays that are compared.
const WAVES: usize = 16;
/// How far a film point is moved to see what that changes in the scene, in half diagonals.
const STEP: f64 = 4e-3;
/// What of the radius that light comes to is the corner of the picture.
const CORNER: f64 = 0.9;

/// Geometric error of one camera's rays against another's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmError {
    /// Root mean square over film and pupil, by the light of the reference, um on film.
    pub rms_um: f64,
    /// The same in the outermost tenth of the radius that light comes to; no number where the camera
    /// loses all of that.
    pub corner_um: f64,
    /// What 95 % of the light is below, um on film.
    pub p95_um: f64,
    /// The share of the reference's light whose rays this camera loses.
    pub lost: f64,
    /// All light on the film, of that of the reference.
    pub light: f64,
}

/// The error of a camera against a reference: the same rays from the film go out through both, to
/// the thing that the reference's ray meets.
///
/// `distance` answers how far that is along a ray of the reference, in world units; infinite where
/// it meets nothing. By how much the camera's ray passes beside that point, seen along the
/// reference's ray, counts as the way on the film by which the reference would see so far beside it.
/// Both cameras are of one film: made by [`Camera::simulated`] from the same. Of a reference without
/// a lens of glass there is no error to tell. The same every time; some 16,000 rays, on one thread.
pub fn film_error(
    camera: &Camera,
    reference: &Camera,
    mut distance: impl FnMut(&Ray) -> f64,
) -> FilmError {
    let Model::Real(lens) = &reference.model else {
        return FilmError { light: 1.0, ..FilmError::default() };
    };
    let mut probe = Probe::new(camera, reference, lens);
    let mut sums = Sums::default();
    for wave in 0..WAVES {
        probe.wave(wave, &mut distance, &mut sums);
    }
    sums.error()
}

/// A ray that was compared.
struct Compared {
    /// From the middle of the film, mm.
    radius: f64,
    /// Its square, mm^2.
    error2: f64,
    weight: f64,
}

#[derive(Default)]
struct Sums {
    compared: Vec<Compared>,
    /// Light of the reference's rays, and of those that the camera loses.
    light: f64,
    lost: f64,
    /// Light on the film: of the camera, and of the reference.
    exposure: [f64; 2],
    /// The farthest from the middle that light comes to, mm.
    end: f64,
}

impl Sums {
    fn error(mut self) -> FilmError {
        let rms = |inner: f64| {
            let outer = self.compared.iter().filter(|ray| ray.radius >= inner);
            let (sum, weight) = outer.fold((0.0, 0.0), |(sum, weight), ray| {
                (sum + ray.weight * ray.error2, weight + ray.weight)
            });
            1e3 * (sum / weight).sqrt()
        };
        let (rms_um, corner_um) = (rms(0.0), rms(CORNER * self.end));
        self.compared.sort_by(|a, b| a.error2.total_cmp(&b.error2));
        let mut left = 0.95 * self.compared.iter().map(|ray| ray.weight).sum::<f64>();
        let last = self.compared.iter().find(|ray| {
            left -= ray.weight;
            left <= 0.0
        });
        let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        FilmError {
            rms_um,
            corner_um,
            p95_um: last.map_or(f64::NAN, |ray| 1e3 * ray.error2.sqrt()),
            lost: share(self.lost, self.light),
            light: share(self.exposure[0], self.exposure[1]),
        }
    }
}

/// A line in the scene: mm from the front vertex of the reference, z to the scene.
#[derive(Clone, Copy)]
struct Line {
    start: DVec3,
    towards: DVec3,
}

impl Line {
    fn of(batch: &LensBatch<f32>, i: usize) -> Option<Self> {
        let [x, y, z] = [batch.x[i], batch.y[i], batch.z[i]].map(f64::from);
        let [tx, ty, tz] = [batch.tx[i], batch.ty[i], batch.tz[i]].map(f64::from);
        let line = Self { start: DVec3::new(x, y, z), towards: DVec3::new(tx, ty, tz).normalize() };
        (!x.is_nan()).then_some(line)
    }

    /// How far beside a point this passes, in the plane across the line to it: mm, or per mm for what
    /// is infinitely far. None where it goes the other way.
    fn beside(&self, line: &Self, distance: f64) -> Option<DVec3> {
        let along = self.towards.dot(line.towards);
        if along <= 0.0 {
            return None;
        }
        if distance.is_infinite() {
            return Some(self.towards / along - line.towards);
        }
        let point = line.start + distance * line.towards;
        let ahead = (point - self.start).dot(line.towards) / along;
        Some(self.start + ahead * self.towards - point)
    }
}

/// Waves through two cameras.
struct Probe<'a> {
    camera: &'a Camera,
    reference: &'a Camera,
    lens: &'a RealLens,
    /// Where the same rays pass the entrance pupil.
    pupil: PupilPoint,
    /// How far film points are moved, mm, and how far the stop's image moves meanwhile in the plane of
    /// the rear vertex, along x and y.
    step: f64,
    drift: [f64; 2],
    /// From the world to mm from the front vertex of the reference.
    from_world: DAffine3,
    samples: SampleBatch,
    columns: LensColumns,
    /// Rays of the reference: as they leave the film, and in the scene.
    fresh: LensBatch<f32>,
    out: LensBatch<f32>,
    rays: RayBatch,
    stats: LensStats,
}

impl<'a> Probe<'a> {
    fn new(camera: &'a Camera, reference: &'a Camera, lens: &'a RealLens) -> Self {
        let other = match &camera.model {
            Model::Real(other) => other.prescription.rows.len(),
            Model::Thin(_) => 0,
        };
        let rows = lens.prescription.rows.len().max(other);
        let front = DVec3::new(0.0, 0.0, lens.front);
        let drift = [Axis::X, Axis::Y].map(|axis| {
            let pupil = Paraxial::in_plane(&lens.prescription, axis).exit_pupil;
            1.0 / (1.0 - lens.film_distance / pupil.position)
        });
        let from_camera = DAffine3::from_scale(DVec3::splat(1.0 / lens.unit))
            * DAffine3::from_translation(-front);
        Self {
            camera,
            reference,
            lens,
            pupil: PupilPoint::new(lens),
            step: STEP * reference.half_diagonal(),
            drift,
            from_world: from_camera * reference.world_from_camera.inverse(),
            samples: SampleBatch { len: WAVE, ..SampleBatch::default() },
            columns: LensColumns::default(),
            fresh: LensBatch::default(),
            out: LensBatch::default(),
            rays: RayBatch::default(),
            stats: LensStats { blocked: vec![0; rows], ..LensStats::default() },
        }
    }

    fn wave(&mut self, wave: usize, distance: &mut impl FnMut(&Ray) -> f64, sums: &mut Sums) {
        self.samples.spread(self.reference.film.map(|side| side / 2.0), wave);
        self.samples.band = wave % self.lens.bands.len();
        let Self { lens, samples, columns, fresh, stats, .. } = self;
        let lens = *lens;
        lens.launch::<f32x8>(samples, columns, stats);
        fresh.clone_from(&columns.batch);
        let steps = [0, 1].map(|axis| self.stepped(axis));
        self.send(lens, |ray| ray);
        self.out.clone_from(&self.columns.batch);
        let band = &self.lens.bands[self.samples.band];
        self.reference.emerge::<f32x8>(self.lens, band, &self.out, &mut self.rays);
        let others = self.others();
        for k in 0..self.rays.len {
            let i = self.rays.slot[k] as usize;
            let Some(line) = Line::of(&self.out, i) else { continue };
            let weight = f64::from(self.out.weight[i]);
            let radius = self.samples.film[0][i].hypot(self.samples.film[1][i]).into();
            sums.light += weight;
            sums.end = sums.end.max(radius);
            let far = self.far(&self.rays.ray(k), &line, distance);
            let beside = others[i].and_then(|other| other.beside(&line, far));
            let Some(beside) = beside else {
                sums.lost += weight;
                continue;
            };
            let step = |axis: usize| Some(steps[axis][i]?.beside(&line, far)? / self.step);
            if let (Some(x), Some(y)) = (step(0), step(1))
                && let Some(error2) = on_film(beside, x, y)
            {
                sums.compared.push(Compared { radius, error2, weight });
            }
        }
        sums.exposure[0] += self.exposure();
        sums.exposure[1] += self.out.light() * self.reference.imaging_ratio;
    }

    /// Takes what was launched, each ray made another, through a lens; answers the rays that come out
    /// by sample.
    fn send(
        &mut self,
        lens: &RealLens,
        other: impl Fn(LensRay<f64>) -> LensRay<f64>,
    ) -> Vec<Option<Line>> {
        let Self { samples, columns: LensColumns { batch, exact, .. }, fresh, stats, .. } = self;
        let index = self.lens.prescription.rear().index;
        let start = |i| other(launched(fresh, index, i));
        batch.clone_from(fresh);
        for i in 0..batch.len {
            let ray = start(i);
            [batch.x[i], batch.y[i], batch.z[i]] = ray.p.map(|v| v as f32);
            [batch.tx[i], batch.ty[i], batch.tz[i]] = ray.t.map(|v| v as f32);
        }
        let band = samples.band.min(lens.bands.len() - 1);
        lens.pass::<f32x8>(band, batch, exact, lens.fresnel, stats, start);
        (0..WAVE).map(|i| Line::of(batch, i)).collect()
    }

    /// The reference's rays from film points moved along an axis, through the same point of the stop.
    fn stepped(&mut self, axis: usize) -> Vec<Option<Line>> {
        let from = self.lens.film_distance;
        let mut by = [[0.0; 2]; 2];
        by[0][axis] = self.step;
        by[1][axis] = self.step * self.drift[axis];
        self.send(self.lens, |ray| moved(ray, [from; 2], [1.0; 2], by))
    }

    /// What the camera makes of what the reference launched.
    fn others(&mut self) -> Vec<Option<Line>> {
        let scale = [0, 1].map(|axis| self.camera.film[axis] / self.reference.film[axis]);
        match &self.camera.model {
            Model::Real(lens) => {
                let distances = [self.lens.film_distance, lens.film_distance];
                let same = distances[0] == distances[1];
                let other = |ray| moved(ray, distances, scale, [[0.0; 2]; 2]);
                self.send(lens, |ray| if same { ray } else { other(ray) })
            }
            Model::Thin(lens) => (0..WAVE).map(|i| self.thin(*lens, i)).collect(),
        }
    }

    /// The ray of a thin lens for the same film point, through the same point of the pupil.
    fn thin(&self, lens: ThinLens, i: usize) -> Option<Line> {
        let from_camera = self.from_world * self.camera.world_from_camera;
        let centre = from_camera.transform_point3(DVec3::ZERO);
        let ray = launched(&self.fresh, self.lens.prescription.rear().index, i);
        let [x, y] = if lens.radius > 0.0 { self.pupil.of(ray, centre.z)? } else { [0.0; 2] };
        let seen = [0, 1].map(|axis| {
            let scale = self.camera.film[axis] / self.reference.film[axis];
            lens.middle[axis] - f64::from(self.samples.film[axis][i]) * scale
        });
        let start = DVec3::new(x, y, centre.z);
        let focus = DVec3::new(seen[0], seen[1], 1.0) * (lens.focus / self.lens.unit);
        Some(Line { start, towards: (centre + focus - start).normalize() })
    }

    /// How far a ray of the reference goes, mm.
    fn far(&self, ray: &Ray, line: &Line, distance: &mut impl FnMut(&Ray) -> f64) -> f64 {
        let far = distance(ray);
        if !far.is_finite() {
            return f64::INFINITY;
        }
        let [start, towards] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        let point = self.from_world.transform_point3(start + far * towards);
        let far = (point - line.start).dot(line.towards);
        if far > 0.0 { far } else { f64::INFINITY }
    }

    /// What the camera's own rays bring to the film.
    fn exposure(&mut self) -> f64 {
        let Self { camera, samples, columns, stats, .. } = self;
        let light = match &camera.model {
            Model::Thin(_) => WAVE as f64,
            Model::Real(lens) => {
                let band = samples.band;
                samples.band = band.min(lens.bands.len() - 1);
                lens.traced::<f32x8>(samples, columns, lens.fresnel, stats);
                samples.band = band;
                columns.batch.light()
            }
        };
        light * camera.imaging_ratio
    }
}

/// A ray from another film, so many times as large and at another distance behind the rear vertex:
/// from the same point moved by some mm to the same point of the plane of that vertex, moved too.
fn moved(
    LensRay { p, t, weight }: LensRay<f64>,
    [from, to]: [f64; 2],
    scale: [f64; 2],
    by: [[f64; 2]; 2],
) -> LensRay<f64> {
    let s = (from - p[2]) / t[2];
    let start = [0, 1].map(|i| p[i] * scale[i] + by[0][i]);
    let way = [0, 1].map(|i| p[i] + s * t[i] + by[1][i] - start[i]);
    let way = DVec3::new(way[0], way[1], to - p[2]);
    let t = way * (DVec3::from(t).length() / way.length());
    LensRay { p: [start[0], start[1], p[2]], t: t.to_array(), weight }
}

/// The square of the way on film, mm, that moves what is seen by `beside` where a mm along x and along
/// y move it so: by least squares.
fn on_film(beside: DVec3, x: DVec3, y: DVec3) -> Option<f64> {
    let (xx, xy, yy) = (x.dot(x), x.dot(y), y.dot(y));
    let (bx, by) = (beside.dot(x), beside.dot(y));
    let determinant = xx * yy - xy * xy;
    let [u, v] = [bx * yy - by * xy, by * xx - bx * xy].map(|v| v / determinant);
    let error2 = u * u + v * v;
    error2.is_finite().then_some(error2)
}
