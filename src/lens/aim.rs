//! From a point on the film to a ray into the lens: a stage.

use super::pupil::{LIT, Lookup, PupilBound, Targets};
use super::refract::LensRay;
use crate::lanes::Real;
use crate::rays::{LensBatch, SampleBatch};

/// Where every sample of a wave aims.
#[derive(Clone, Debug, Default)]
pub struct TargetColumns {
    targets: Targets,
    lookup: Lookup,
}

/// The film and the medium before it, in every lane.
#[derive(Clone, Copy)]
struct Film<R> {
    distance: R,
    index: R,
    /// Density of the samples of a triangle times twice its area.
    triangle: R,
}

/// One packet of samples.
struct Sample<R> {
    film: [R; 2],
    /// The second random number of its pupil point.
    v: R,
    /// How far along the far side of its triangle.
    along: R,
    /// The lanes of its [`Target`].
    target: [R; 8],
}

impl<R: Real<Scalar = f32>> Film<R> {
    fn new(bound: &PupilBound, [distance, index]: [f32; 2]) -> Self {
        Self {
            distance: R::splat(distance),
            index: R::splat(index),
            triangle: R::splat(bound.triangle_density()),
        }
    }

    /// The ray of a sample, with its weight, and whether its film point is dark.
    #[inline(always)]
    fn launch(&self, sample: &Sample<R>) -> (LensRay<R>, R::Mask) {
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let [x, y] = sample.film;
        let [centre_u, centre_v, corner_u, corner_v, side_u, side_v, base, lone] = sample.target;
        let area2 = corner_u * side_v - corner_v * side_u;
        let closed = base.le(zero) | (area2.le(zero) & lone.le(zero));
        let radial = sample.v.sqrt();
        let u = radial.mul_add(sample.along.mul_add(side_u, corner_u), centre_u);
        let v = radial.mul_add(sample.along.mul_add(side_v, corner_v), centre_v);
        let r2 = x.mul_add(x, y * y);
        let on_axis = r2.le(zero);
        let per_r = one / r2.sqrt();
        let (cos, sin) = (R::select(on_axis, one, x * per_r), R::select(on_axis, zero, y * per_r));
        let dx = cos.mul_add(u, -(sin * v)) - x;
        let dy = sin.mul_add(u, cos * v) - y;
        let z2 = self.distance * self.distance;
        let d2 = dx.mul_add(dx, dy.mul_add(dy, z2));
        let per_d = one / d2.sqrt();
        let per_length = self.index * per_d;
        let cos = self.distance * per_d;
        let cos2 = cos * cos;
        // cos^4 / (Z^2 pdf) with pdf = triangle / area2 + base, of a triangle if there is one.
        let drawn = zero.lt(area2);
        let area2 = R::select(drawn, area2, one);
        let pdf_area2 = base.mul_add(area2, R::select(drawn, self.triangle, zero));
        let exposure = cos2 * cos2 * area2 / (z2 * pdf_area2);
        let ray = LensRay {
            p: [R::select(closed, R::constant(f64::NAN), x), y, zero],
            t: [dx * per_length, dy * per_length, self.distance * per_length],
            weight: R::select(closed, zero, exposure),
        };
        (ray, closed)
    }
}

/// Aims every sample at a pupil point and weights it.
///
/// The rays start on the film, `distance` mm behind the rear vertex, in a medium of index
/// `n`. The weight is cos^4 / (Z^2 pdf), with theta at the film and the density in mm^-2 of
/// the rear vertex plane (Kolb, Mitchell & Hanrahan 1995, eq. 3); 0 where the film sees no light.
pub fn aim<R: Real<Scalar = f32>>(
    samples: &SampleBatch,
    bound: &PupilBound,
    [distance, n]: [f32; 2],
    targets: &mut TargetColumns,
    batch: &mut LensBatch<f32>,
) {
    let len = samples.len;
    let film = [&samples.film[0][..len], &samples.film[1][..len]];
    let pupil = [&samples.pupil[0][..len], &samples.pupil[1][..len]];
    let TargetColumns { targets, lookup } = targets;
    bound.targets(film, pupil, lookup, targets);
    // The lanes behind the last sample are no dark film points.
    targets[len..len.next_multiple_of(R::LANES)].fill(LIT);

    let stage = Film::<R>::new(bound, [distance, n]);
    let (x, y) = (samples.film[0].packets::<R>(len), samples.film[1].packets::<R>(len));
    let v = samples.pupil[1].packets::<R>(len);
    let along = lookup.along.packets::<R>(len);
    let weight = batch.weight.packets_mut::<R>(len);
    let (to_x, to_y) = (batch.x.packets_mut::<R>(len), batch.y.packets_mut::<R>(len));
    let to_z = batch.z.packets_mut::<R>(len);
    let (to_tx, to_ty) = (batch.tx.packets_mut::<R>(len), batch.ty.packets_mut::<R>(len));
    let to_tz = batch.tz.packets_mut::<R>(len);
    let mut dark = 0;
    for i in 0..weight.len() {
        let (ray, closed) = stage.launch(&Sample {
            film: [x[i], y[i]],
            v: v[i],
            along: along[i],
            target: R::columns(&targets[i * R::LANES..(i + 1) * R::LANES]),
        });
        [to_x[i], to_y[i], to_z[i]] = ray.p;
        [to_tx[i], to_ty[i], to_tz[i]] = ray.t;
        weight[i] = ray.weight;
        dark += R::bits(closed).count_ones() as usize;
    }
    batch.resize::<R>(len);
    batch.living = len - dark;
}

/// The i-th ray once more, as [`aim`] made it, its direction of the index's length in f64.
pub fn aimed(
    samples: &SampleBatch,
    bound: &PupilBound,
    targets: &TargetColumns,
    [distance, index]: [f32; 2],
    i: usize,
) -> LensRay<f64> {
    let (ray, _) = Film::<f32>::new(bound, [distance, index]).launch(&Sample {
        film: [samples.film[0][i], samples.film[1][i]],
        v: samples.pupil[1][i],
        along: targets.lookup.along[i],
        target: targets.targets[i],
    });
    let [x, y, z] = ray.t.map(f64::from);
    let scale = f64::from(index) / (x * x + y * y + z * z).sqrt();
    LensRay {
        p: ray.p.map(f64::from),
        t: [x * scale, y * scale, z * scale],
        weight: f64::from(ray.weight),
    }
}
