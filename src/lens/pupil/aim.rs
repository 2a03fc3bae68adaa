//! Aim stage: rays from film points to sampled pupil points.
//!
//! Whether the film is tilted is a const parameter of the loop, so that untilted film pays nothing
//! for it.

use super::PupilBounds;
use super::sample::Lookup;
use super::target::{PupilTargets, UNUSED_LANE};
use crate::prescription::pose::Pose;
use crate::trace::kernel::LensRay;
use petzval_base::lanes::Real;
use petzval_base::rays::{Column, LensBatch, SampleBatch};

/// The sampled pupil points of a wave.
#[derive(Clone, Debug, Default)]
pub struct TargetColumns {
    targets: PupilTargets,
    lookup: Lookup,
    /// Film points in the frame of the lens [mm]: x, y, and z towards the scene from the plane of
    /// the untilted film. Unused if the film is neither tilted nor decentred.
    film_points: [Column<f32>; 3],
}

/// The film as rays start from it.
#[derive(Clone, Copy, Debug)]
pub struct LaunchPlane {
    /// Distance from the rear vertex to the film's centre along the axis, mm.
    pub distance: f32,
    /// Refractive index of the medium before it.
    pub index: f32,
    /// Tilt and decentre.
    pub pose: Pose,
}

/// The film and the medium before it, broadcast to all lanes.
#[derive(Clone, Copy)]
struct LaunchLanes<R> {
    distance: R,
    index: R,
    /// The square of the index: radiance in a medium over radiance in air.
    index2: R,
    /// Normal of the film, towards the scene.
    normal: [R; 3],
    /// Sample density of a triangle times twice its area.
    triangle: R,
}

/// One packet of samples.
struct PupilSample<R> {
    film: [R; 3],
    /// Second random number of the pupil point.
    v: R,
    /// Position along the outer side of its triangle, 0 to 1.
    along: R,
    /// The lanes of its [`PupilTarget`](super::target::PupilTarget).
    target: [R; 8],
}

impl<R: Real<Scalar = f32>> LaunchLanes<R> {
    fn new(bound: &PupilBounds, plane: &LaunchPlane) -> Self {
        let [_, _, z] = pose_axes(&plane.pose);
        Self {
            distance: R::splat(plane.distance),
            index: R::splat(plane.index),
            index2: R::splat(plane.index * plane.index),
            normal: [-z[0], -z[1], z[2]].map(R::splat),
            triangle: R::splat(bound.triangle_density()),
        }
    }

    /// Returns the ray of a sample with its weight, and whether its film point is dark.
    #[inline(always)]
    fn launch<const TILTED: bool>(&self, sample: &PupilSample<R>) -> (LensRay<R>, R::Mask) {
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let [x, y, z] = sample.film;
        let [centre_u, centre_v, corner_u, corner_v, side_u, side_v, base, has_no_triangle] =
            sample.target;
        let area2 = corner_u * side_v - corner_v * side_u;
        let closed = base.le(zero) | (area2.le(zero) & has_no_triangle.le(zero));
        let radial = sample.v.sqrt();
        let u = radial.mul_add(sample.along.mul_add(side_u, corner_u), centre_u);
        let v = radial.mul_add(sample.along.mul_add(side_v, corner_v), centre_v);
        let (dx, dy, dz) = match TILTED {
            true => (u - x, v - y, self.distance - z),
            false => {
                let r2 = x.mul_add(x, y * y);
                let on_axis = r2.le(zero);
                let per_r = one / r2.sqrt();
                let cos = R::select(on_axis, one, x * per_r);
                let sin = R::select(on_axis, zero, y * per_r);
                let dx = cos.mul_add(u, -(sin * v)) - x;
                let dy = sin.mul_add(u, cos * v) - y;
                (dx, dy, self.distance)
            }
        };
        let z2 = dz * dz;
        let d2 = dx.mul_add(dx, dy.mul_add(dy, z2));
        let per_d = one / d2.sqrt();
        let per_length = self.index * per_d;
        let cos = dz * per_d;
        let cos2 = cos * cos;
        // cos^4 / (Z^2 pdf) with pdf = triangle / area2 + base; the first term only if the sample
        // has a triangle.
        let drawn = zero.lt(area2);
        let area2 = R::select(drawn, area2, one);
        let pdf_area2 = base.mul_add(area2, R::select(drawn, self.triangle, zero));
        let geometry = match TILTED {
            // The cosine at the film's normal; no light enters through its back.
            true => {
                let [nx, ny, nz] = self.normal;
                let along = nx.mul_add(dx, ny.mul_add(dy, nz * dz)) * per_d;
                cos2 * cos * along.max(zero)
            }
            false => cos2 * cos2,
        };
        let exposure = geometry * (self.index2 * area2) / (z2 * pdf_area2);
        let ray = LensRay {
            p: [R::select(closed, R::constant(f64::NAN), x), y, if TILTED { z } else { zero }],
            t: [dx * per_length, dy * per_length, dz * per_length],
            weight: R::select(closed, zero, exposure),
        };
        (ray, closed)
    }
}

/// Returns the axes of a tilted film in the frame of the lens, in single precision.
fn pose_axes(pose: &Pose) -> [[f32; 3]; 3] {
    pose.transform().matrix3.to_cols_array_2d().map(|column| column.map(|v| v as f32))
}

/// Transforms film points to the frame of the lens.
fn transform_film_points<R: Real<Scalar = f32>>(
    samples: &SampleBatch,
    pose: &Pose,
    film_points: &mut [Column<f32>; 3],
) {
    let len = samples.len;
    let [x, y, _] = pose_axes(pose).map(|column| column.map(R::splat));
    let middle = pose.decentre.map(R::constant);
    let own = [samples.film[0].packets::<R>(len), samples.film[1].packets::<R>(len)];
    let [to_x, to_y, to_z] = film_points.each_mut().map(|column| column.packets_mut::<R>(len));
    for i in 0..to_x.len() {
        let (u, v) = (own[0][i], own[1][i]);
        to_x[i] = x[0].mul_add(u, y[0].mul_add(v, middle[0]));
        to_y[i] = x[1].mul_add(u, y[1].mul_add(v, middle[1]));
        // z of the pose points towards the film.
        to_z[i] = -x[2].mul_add(u, y[2] * v);
    }
}

/// Aims every sample at a pupil point and computes its weight: a stage.
///
/// Rays start on the film. Their weight is n^2 cos theta cos theta' / (d^2 pdf): theta is the angle at
/// the film's normal, theta' that at the axis, d the distance to the point in the plane of the rear
/// vertex, and pdf the density there, mm^-2. A film in a medium of index n receives n^2 times the
/// radiance of the scene (Nicodemus 1963). Rays from dark film points have weight 0. For untilted
/// film in air the weight is cos^4 / (Z^2 pdf) (Kolb, Mitchell & Hanrahan 1995, eq. 3).
pub fn aim<R: Real<Scalar = f32>>(
    samples: &SampleBatch,
    bound: &PupilBounds,
    plane: &LaunchPlane,
    targets: &mut TargetColumns,
    batch: &mut LensBatch<f32>,
) {
    if plane.is_aligned(bound) {
        aim_all::<R, false, false>(samples, bound, plane, targets, batch);
        return;
    }
    transform_film_points::<R>(samples, &plane.pose, &mut targets.film_points);
    match plane.is_untilted(bound) {
        true => aim_all::<R, false, true>(samples, bound, plane, targets, batch),
        false => aim_all::<R, true, true>(samples, bound, plane, targets, batch),
    }
}

impl LaunchPlane {
    /// Returns whether the film is neither tilted nor decentred, and pupil points are in the frame
    /// of the film point.
    fn is_aligned(&self, bound: &PupilBounds) -> bool {
        self.pose.is_aligned() && !bound.uses_lens_frame()
    }

    /// Returns whether the film is at most decentred, and pupil points are in the frame of the film
    /// point.
    fn is_untilted(&self, bound: &PupilBounds) -> bool {
        self.pose.is_untilted() && !bound.uses_lens_frame()
    }
}

#[inline(never)]
fn aim_all<R: Real<Scalar = f32>, const TILTED: bool, const TRANSFORMED: bool>(
    samples: &SampleBatch,
    bound: &PupilBounds,
    plane: &LaunchPlane,
    targets: &mut TargetColumns,
    batch: &mut LensBatch<f32>,
) {
    let len = samples.len;
    let pupil = [&samples.pupil[0][..len], &samples.pupil[1][..len]];
    let TargetColumns { targets, lookup, film_points } = targets;
    let [film_x, film_y] = match TRANSFORMED {
        true => [&film_points[0], &film_points[1]],
        false => [&samples.film[0], &samples.film[1]],
    };
    // Grids cover the film itself; rings are centred on the axis.
    let known = match TILTED {
        true => [&samples.film[0][..len], &samples.film[1][..len]],
        false => [&film_x[..len], &film_y[..len]],
    };
    bound.targets(known, pupil, lookup, targets);
    // The lanes behind the last sample must not count as dark film points.
    targets[len..len.next_multiple_of(R::LANES)].fill(UNUSED_LANE);

    let stage = LaunchLanes::<R>::new(bound, plane);
    let (x, y) = (film_x.packets::<R>(len), film_y.packets::<R>(len));
    let z = film_points[2].packets::<R>(len);
    let v = samples.pupil[1].packets::<R>(len);
    let along = lookup.along.packets::<R>(len);
    let weight = batch.weight.packets_mut::<R>(len);
    let (to_x, to_y) = (batch.x.packets_mut::<R>(len), batch.y.packets_mut::<R>(len));
    let to_z = batch.z.packets_mut::<R>(len);
    let (to_tx, to_ty) = (batch.tx.packets_mut::<R>(len), batch.ty.packets_mut::<R>(len));
    let to_tz = batch.tz.packets_mut::<R>(len);
    let mut dark = 0;
    for i in 0..weight.len() {
        let (ray, closed) = stage.launch::<TILTED>(&PupilSample {
            film: [x[i], y[i], if TILTED { z[i] } else { R::constant(0.0) }],
            v: v[i],
            along: along[i],
            target: R::transpose(&targets[i * R::LANES..(i + 1) * R::LANES]),
        });
        [to_x[i], to_y[i], to_z[i]] = ray.p;
        [to_tx[i], to_ty[i], to_tz[i]] = ray.t;
        weight[i] = ray.weight;
        dark += R::bits(closed).count_ones() as usize;
    }
    batch.resize::<R>(len);
    batch.live = len - dark;
}

/// Returns the i-th ray as [`aim`] computed it, in f64: its direction has the length of the index.
pub fn aim_one_f64(
    samples: &SampleBatch,
    bound: &PupilBounds,
    columns: &TargetColumns,
    plane: &LaunchPlane,
    i: usize,
) -> LensRay<f64> {
    let film = LaunchLanes::<f32>::new(bound, plane);
    let [x, y] = [samples.film[0][i], samples.film[1][i]];
    let film_point = columns.film_points.each_ref().map(|column| column[i]);
    let sample = |film: [f32; 3]| PupilSample {
        film,
        v: samples.pupil[1][i],
        along: columns.lookup.along[i],
        target: columns.targets[i],
    };
    let (ray, _) = match (plane.is_aligned(bound), plane.is_untilted(bound)) {
        (true, _) => film.launch::<false>(&sample([x, y, 0.0])),
        (false, true) => film.launch::<false>(&sample([film_point[0], film_point[1], 0.0])),
        (false, false) => film.launch::<true>(&sample(film_point)),
    };
    let [x, y, z] = ray.t.map(f64::from);
    let scale = f64::from(plane.index) / (x * x + y * y + z * z).sqrt();
    LensRay {
        p: ray.p.map(f64::from),
        t: [x * scale, y * scale, z * scale],
        weight: f64::from(ray.weight),
    }
}
