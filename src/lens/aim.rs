//! From a point on the film to a ray into the lens: a stage.

use super::pupil::{Bound, PupilBound};
use crate::lanes::Real;
use crate::rays::{Column, LensBatch, SampleBatch};
use crate::sampler::disk;

/// The columns in which the stage looks up the bounds of every film point.
#[derive(Clone, Debug, Default)]
pub struct BoundColumns {
    pupil: [Column<f32>; 3],
    rear: [Column<f32>; 3],
}

impl BoundColumns {
    #[inline(always)]
    fn set(&mut self, i: usize, bound: &Bound) {
        for (columns, ellipse) in [(&mut self.pupil, bound.pupil), (&mut self.rear, bound.rear)] {
            columns[0][i] = ellipse.centre;
            columns[1][i] = ellipse.half[0];
            columns[2][i] = ellipse.half[1];
        }
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
    distance: f32,
    n: f32,
    bounds: &mut BoundColumns,
    weight: &mut Column<f32>,
    batch: &mut LensBatch<f32>,
) {
    let len = samples.len;
    for i in 0..len {
        let (x, y) = (samples.film[0][i], samples.film[1][i]);
        bounds.set(i, &bound.at((x * x + y * y).sqrt()));
    }
    for i in len..len.next_multiple_of(R::LANES) {
        bounds.set(i, &Bound::default());
    }

    let (zero, one) = (R::constant(0.0), R::constant(1.0));
    let share = R::splat(bound.rear_share);
    let pupil_share = one - share;
    // Without a share for the rear element no sample is below it, and the quotient is unused.
    let (per_share, per_pupil_share) = (one / share, one / pupil_share);
    let (z, z2) = (R::splat(distance), R::splat(distance * distance));
    let pi = R::constant(std::f64::consts::PI);
    let index = R::splat(n);

    let (x, y) = (samples.film[0].packets::<R>(len), samples.film[1].packets::<R>(len));
    let (u, v) = (samples.pupil[0].packets::<R>(len), samples.pupil[1].packets::<R>(len));
    let [pupil_c, pupil_a, pupil_b] = [0, 1, 2].map(|i| bounds.pupil[i].packets::<R>(len));
    let [rear_c, rear_a, rear_b] = [0, 1, 2].map(|i| bounds.rear[i].packets::<R>(len));
    let weight = weight.packets_mut::<R>(len);
    let (to_x, to_y) = (batch.x.packets_mut::<R>(len), batch.y.packets_mut::<R>(len));
    let to_z = batch.z.packets_mut::<R>(len);
    let (to_tx, to_ty) = (batch.tx.packets_mut::<R>(len), batch.ty.packets_mut::<R>(len));
    let to_tz = batch.tz.packets_mut::<R>(len);
    for i in 0..weight.len() {
        let to_rear = u[i].lt(share);
        let u0 = R::select(to_rear, u[i] * per_share, (u[i] - share) * per_pupil_share);
        let [disk_u, disk_v] = disk(u0, v[i]);
        let centre = R::select(to_rear, rear_c[i], pupil_c[i]);
        let pupil_u = R::select(to_rear, rear_a[i], pupil_a[i]).mul_add(disk_u, centre);
        let pupil_v = R::select(to_rear, rear_b[i], pupil_b[i]) * disk_v;

        let inside = |c: R, a: R, b: R| {
            let (x, y) = ((pupil_u - c) / a, pupil_v / b);
            // A sample of an ellipse is inside it even where rounding puts it on the edge.
            x.mul_add(x, y * y).le(R::constant(1.000_001))
        };
        let in_pupil = inside(pupil_c[i], pupil_a[i], pupil_b[i]);
        let in_rear = inside(rear_c[i], rear_a[i], rear_b[i]);
        let density = R::select(in_pupil, pupil_share / (pi * pupil_a[i] * pupil_b[i]), zero)
            + R::select(in_rear, share / (pi * rear_a[i] * rear_b[i]), zero);

        let r2 = x[i].mul_add(x[i], y[i] * y[i]);
        let on_axis = r2.le(zero);
        let per_r = one / r2.sqrt();
        let (cos, sin) =
            (R::select(on_axis, one, x[i] * per_r), R::select(on_axis, zero, y[i] * per_r));
        let dx = cos.mul_add(pupil_u, -(sin * pupil_v)) - x[i];
        let dy = sin.mul_add(pupil_u, cos * pupil_v) - y[i];
        let d2 = dx.mul_add(dx, dy.mul_add(dy, z2));
        let per_length = index / d2.sqrt();
        let cos2 = z2 / d2;
        let exposure = cos2 * cos2 / (z2 * density);
        // An ellipse of no width: no light comes here.
        let closed = pupil_a[i].le(zero);
        weight[i] = R::select(closed, zero, exposure);
        to_x[i] = R::select(closed, R::constant(f64::NAN), x[i]);
        to_y[i] = y[i];
        to_z[i] = zero;
        to_tx[i] = dx * per_length;
        to_ty[i] = dy * per_length;
        to_tz[i] = z * per_length;
    }
    batch.resize::<R>(len);
}
