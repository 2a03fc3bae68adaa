//! Comparison of two cameras ray by ray.

use glam::{DAffine3, DVec3};

use petzval_base::lanes::f32x8;
use petzval_base::rays::{LensBatch, Ray, RayBatch, SampleBatch, WAVE_SIZE};
use petzval_base::stats::LensStats;
use petzval_lens::LensRay;
use petzval_lens::Paraxial;
use petzval_lens::ThinLens;
use petzval_lens::TransverseAxis;
use petzval_lens::{Camera, LensColumns, LensModel, RealLens};
use petzval_lens::{PupilPoint, launched};

use super::scene_line::{SceneLine, squared_film_displacement};
use super::{RayError, Sums};

/// Displacement of a film point for the finite difference of its ray, in half diagonals.
const STEP: f64 = 4e-3;

/// Traces waves of rays through two cameras.
pub(super) struct RayComparison<'a> {
    camera: &'a Camera,
    reference: &'a Camera,
    lens: &'a RealLens,
    /// The same rays' points of the entrance pupil.
    pupil: PupilPoint,
    /// Displacement of film points, mm, and the ratio by which the stop's image in the plane of the
    /// rear vertex follows it, along x and y.
    step: f64,
    drift: [f64; 2],
    /// World space to mm from the front vertex of the reference.
    from_world: DAffine3,
    samples: SampleBatch,
    columns: LensColumns,
    /// Rays of the reference: at the film, and in the scene.
    fresh: LensBatch<f32>,
    out: LensBatch<f32>,
    rays: RayBatch,
    stats: LensStats,
}

impl<'a> RayComparison<'a> {
    pub fn new(camera: &'a Camera, reference: &'a Camera, lens: &'a RealLens) -> Self {
        let front = DVec3::new(0.0, 0.0, lens.front_depth);
        let drift = [TransverseAxis::X, TransverseAxis::Y].map(|axis| {
            let pupil = Paraxial::in_plane(&lens.prescription, axis).exit_pupil;
            1.0 / (1.0 - lens.film_distance / pupil.position)
        });
        let from_camera = DAffine3::from_scale(DVec3::splat(1.0 / lens.units_per_mm))
            * DAffine3::from_translation(-front);
        Self {
            camera,
            reference,
            lens,
            pupil: PupilPoint::new(lens),
            step: STEP * reference.half_diagonal(),
            drift,
            from_world: from_camera * reference.world_from_camera.inverse(),
            samples: SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() },
            columns: LensColumns::default(),
            fresh: LensBatch::default(),
            out: LensBatch::default(),
            rays: RayBatch::default(),
            stats: LensStats::default(),
        }
    }

    /// Compares the rays of a wave.
    pub fn compare_wave(
        &mut self,
        wave: usize,
        distance: &mut impl FnMut(&Ray) -> f64,
        sums: &mut Sums,
    ) {
        self.samples.fill_evenly(self.reference.film.map(|side| side / 2.0), wave);
        self.samples.band = wave % self.lens.bands.len();
        let Self { lens, samples, columns, fresh, stats, .. } = self;
        let lens = *lens;
        lens.launch::<f32x8>(samples, columns, stats);
        fresh.clone_from(&columns.batch);
        let steps = [0, 1].map(|axis| self.stepped(axis));
        self.send(lens, |ray| ray);
        self.out.clone_from(&self.columns.batch);
        let band = &self.lens.bands[self.samples.band];
        self.reference.write_world_rays::<f32x8>(self.lens, band, &self.out, &mut self.rays);
        let others = self.others();
        for k in 0..self.rays.len {
            let i = self.rays.slot[k] as usize;
            let Some(line) = SceneLine::of_ray(&self.out, i) else { continue };
            let weight = f64::from(self.out.weight[i]);
            let radius = self.samples.film[0][i].hypot(self.samples.film[1][i]).into();
            sums.light += weight;
            sums.end = sums.end.max(radius);
            let far = self.far(&self.rays.ray(k), &line, distance);
            let offset = others[i].and_then(|other| other.offset_from(&line, far));
            let Some(offset) = offset else {
                sums.lost += weight;
                continue;
            };
            let step = |axis: usize| Some(steps[axis][i]?.offset_from(&line, far)? / self.step);
            if let (Some(x), Some(y)) = (step(0), step(1))
                && let Some(error2) = squared_film_displacement(offset, x, y)
            {
                sums.compared.push(RayError { radius, error2, weight });
            }
        }
        sums.exposure[0] += self.exposure();
        sums.exposure[1] += self.out.total_weight() * self.reference.imaging_ratio;
    }

    /// Traces the launched rays, each transformed by `other`, through a lens; returns the emerging
    /// rays by sample.
    fn send(
        &mut self,
        lens: &RealLens,
        other: impl Fn(LensRay<f64>) -> LensRay<f64>,
    ) -> Vec<Option<SceneLine>> {
        let Self { samples, columns: LensColumns { batch, exact, .. }, fresh, stats, .. } = self;
        let band = samples.band.min(lens.bands.len() - 1);
        let index = lens.bands[band].film_index;
        let start = |i| other(launched(fresh, index, i));
        batch.clone_from(fresh);
        for i in 0..batch.len {
            let ray = start(i);
            [batch.x[i], batch.y[i], batch.z[i]] = ray.p.map(|v| v as f32);
            [batch.tx[i], batch.ty[i], batch.tz[i]] = ray.t.map(|v| v as f32);
        }
        lens.trace_batch::<f32x8>(band, batch, exact, lens.fresnel, stats, start);
        (0..WAVE_SIZE).map(|i| SceneLine::of_ray(batch, i)).collect()
    }

    /// Returns the reference's rays from film points displaced along an axis, through the same
    /// point of the stop.
    fn stepped(&mut self, axis: usize) -> Vec<Option<SceneLine>> {
        let from = self.lens.film_distance;
        let mut by = [[0.0; 2]; 2];
        by[0][axis] = self.step;
        by[1][axis] = self.step * self.drift[axis];
        self.send(self.lens, |ray| moved(ray, [from; 2], [1.0; 2], by))
    }

    /// Returns the camera's rays for those that the reference launched.
    fn others(&mut self) -> Vec<Option<SceneLine>> {
        let scale = [0, 1].map(|axis| self.camera.film[axis] / self.reference.film[axis]);
        match &self.camera.model {
            LensModel::Real(lens) => {
                let distances = [self.lens.film_distance, lens.film_distance];
                let same = distances[0] == distances[1];
                let other = |ray| moved(ray, distances, scale, [[0.0; 2]; 2]);
                self.send(lens, |ray| if same { ray } else { other(ray) })
            }
            LensModel::Thin(lens) => (0..WAVE_SIZE).map(|i| self.thin(*lens, i)).collect(),
            // No model of a lens has the projection of these.
            LensModel::Orthographic(_) | LensModel::Spherical(_) => vec![None; WAVE_SIZE],
        }
    }

    /// Returns the ray of a thin lens for the same film point and the same point of the pupil.
    fn thin(&self, lens: ThinLens, i: usize) -> Option<SceneLine> {
        let from_camera = self.from_world * self.camera.world_from_camera;
        let centre = from_camera.transform_point3(DVec3::ZERO);
        // The lens of the pupil point is that of the primary wavelength.
        let ray = launched(&self.fresh, self.lens.prescription.rear().index, i);
        let [x, y] = if lens.radius > 0.0 { self.pupil.trace(ray, centre.z)? } else { [0.0; 2] };
        let seen = [0, 1].map(|axis| {
            let scale = self.camera.film[axis] / self.reference.film[axis];
            lens.middle[axis] - f64::from(self.samples.film[axis][i]) * scale
        });
        let start = DVec3::new(x, y, centre.z);
        let focus = DVec3::new(seen[0], seen[1], 1.0) * (lens.focus / self.lens.units_per_mm);
        Some(SceneLine { start, direction: (centre + focus - start).normalize() })
    }

    /// Returns the distance at which a ray of the reference meets an object, mm.
    fn far(&self, ray: &Ray, line: &SceneLine, distance: &mut impl FnMut(&Ray) -> f64) -> f64 {
        let far = distance(ray);
        if !far.is_finite() {
            return f64::INFINITY;
        }
        let [start, towards] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
        let point = self.from_world.transform_point3(start + far * towards);
        let far = (point - line.start).dot(line.direction);
        if far > 0.0 { far } else { f64::INFINITY }
    }

    /// Returns the light on the film from the camera's own rays.
    fn exposure(&mut self) -> f64 {
        let Self { camera, samples, columns, stats, .. } = self;
        let light = match &camera.model {
            LensModel::Real(lens) => {
                let band = samples.band;
                samples.band = band.min(lens.bands.len() - 1);
                lens.trace_samples::<f32x8>(samples, columns, lens.fresnel, stats);
                samples.band = band;
                columns.batch.total_weight()
            }
            _ => WAVE_SIZE as f64,
        };
        light * camera.imaging_ratio
    }
}

/// Maps a ray to another film, scaled by `scale` and moved from one distance behind the rear vertex
/// to another. The ray goes from the same film point displaced by `by[0]` mm to the same point of
/// the plane of the rear vertex displaced by `by[1]` mm.
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

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_lens::PupilSampling;
    use petzval_spectrum::LightBand;

    /// A film in flint: rays of every band start with the index of the flint at their wavelength, as
    /// those of a picture do.
    #[test]
    fn compared_rays_of_a_film_in_glass_are_those_of_the_picture() {
        let text = "[[surface]]\nstop = true\ndiameter = 12\nthickness = 5
            [[surface]]\nradius = 60\nthickness = 6\ndiameter = 24\nglass = \"SF5\"
            [[surface]]\nradius = -120\nthickness = 40\ndiameter = 24
            [[surface]]\ndiameter = 24\nglass = \"SF5\"\n";
        let lens = petzval_lens_formats::parse_toml("glass.toml".as_ref(), text).expect("a lens");
        let mut lens = RealLens::new(lens, 60.0, 10.0, PupilSampling::Pupil, 1.0, 0.0);
        let bands = [420.0, 680.0].map(|wavelength| LightBand { wavelength, response: [1.0; 3] });
        lens.disperse(&bands);
        let camera = Camera {
            model: LensModel::Real(Box::new(lens.clone())),
            film: [16.0, 12.0],
            world_from_camera: DAffine3::IDENTITY,
            imaging_ratio: 1.0,
            depth: [0.0, f64::INFINITY],
        };
        let mut comparison = RayComparison::new(&camera, &camera, &lens);
        for band in 0..bands.len() {
            let mut sums = Sums::default();
            comparison.compare_wave(band, &mut |_| f64::INFINITY, &mut sums);
            let (mut columns, mut stats) = (LensColumns::default(), LensStats::default());
            lens.trace_samples::<f32x8>(&comparison.samples, &mut columns, false, &mut stats);
            let (picture, compared) = (&columns.batch, &comparison.out);
            let living: Vec<usize> = (0..picture.len).filter(|&i| !picture.x[i].is_nan()).collect();
            assert!(living.len() > 500, "{} rays", living.len());
            for i in living {
                let off = (picture.tx[i] - compared.tx[i]).abs();
                assert!(off < 1e-5, "band {band}, ray {i}: {off}");
            }
        }
    }
}
