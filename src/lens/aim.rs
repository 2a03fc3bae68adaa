//! From a point on the film to a ray into the lens: a stage.
//!
//! Whether the film stands askew is a parameter of its loop; square film pays nothing for it.

use super::pose::Pose;
use super::pupil::{Lookup, PupilBound};
use super::refract::LensRay;
use super::target::{LIT, Targets};
use crate::lanes::Real;
use crate::plan::EFFECTS;
use crate::rays::{Column, LensBatch, SampleBatch};

/// Where every sample of a wave aims.
#[derive(Clone, Debug, Default)]
pub struct TargetColumns {
    targets: Targets,
    lookup: Lookup,
    /// Where film points stand, mm: x, y, and z towards the scene from the plane of the square
    /// film. Of no use where the film is square.
    places: [Column<f32>; 3],
}

/// A film behind a lens.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Rear vertex to the film's centre along the axis, mm.
    pub distance: f32,
    /// Index of the medium before it.
    pub index: f32,
    /// How it stands.
    pub pose: Pose,
}

/// The film and the medium before it, in every lane.
#[derive(Clone, Copy)]
struct Film<R> {
    distance: R,
    index: R,
    /// The film's own normal, towards the scene.
    normal: [R; 3],
    /// Density of the samples of a triangle times twice its area.
    triangle: R,
}

/// One packet of samples.
struct Sample<R> {
    film: [R; 3],
    /// The second random number of its pupil point.
    v: R,
    /// How far along the far side of its triangle.
    along: R,
    /// The lanes of its [`Target`](super::target::Target).
    target: [R; 8],
}

impl<R: Real<Scalar = f32>> Film<R> {
    fn new(bound: &PupilBound, plane: &Plane) -> Self {
        let [_, _, z] = turn(&plane.pose);
        Self {
            distance: R::splat(plane.distance),
            index: R::splat(plane.index),
            normal: [-z[0], -z[1], z[2]].map(R::splat),
            triangle: R::splat(bound.triangle_density()),
        }
    }

    /// The ray of a sample, with its weight, and whether its film point is dark.
    #[inline(always)]
    fn launch<const ASKEW: bool>(&self, sample: &Sample<R>) -> (LensRay<R>, R::Mask) {
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let [x, y, z] = sample.film;
        let [centre_u, centre_v, corner_u, corner_v, side_u, side_v, base, lone] = sample.target;
        let area2 = corner_u * side_v - corner_v * side_u;
        let closed = base.le(zero) | (area2.le(zero) & lone.le(zero));
        let radial = sample.v.sqrt();
        let u = radial.mul_add(sample.along.mul_add(side_u, corner_u), centre_u);
        let v = radial.mul_add(sample.along.mul_add(side_v, corner_v), centre_v);
        let (dx, dy, dz) = match ASKEW {
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
        // cos^4 / (Z^2 pdf) with pdf = triangle / area2 + base, of a triangle if there is one.
        let drawn = zero.lt(area2);
        let area2 = R::select(drawn, area2, one);
        let pdf_area2 = base.mul_add(area2, R::select(drawn, self.triangle, zero));
        let geometry = match ASKEW {
            // The cosine to the film's own normal; no light comes through its back.
            true => {
                let [nx, ny, nz] = self.normal;
                let along = nx.mul_add(dx, ny.mul_add(dy, nz * dz)) * per_d;
                cos2 * cos * along.max(zero)
            }
            false => cos2 * cos2,
        };
        let exposure = geometry * area2 / (z2 * pdf_area2);
        let ray = LensRay {
            p: [R::select(closed, R::constant(f64::NAN), x), y, if ASKEW { z } else { zero }],
            t: [dx * per_length, dy * per_length, dz * per_length],
            weight: R::select(closed, zero, exposure),
        };
        (ray, closed)
    }
}

/// The columns of a pose's turn, in single precision and the frame of the lens.
fn turn(pose: &Pose) -> [[f32; 3]; 3] {
    pose.motion().matrix3.to_cols_array_2d().map(|column| column.map(|v| v as f32))
}

/// Puts film points where they stand.
fn place<R: Real<Scalar = f32>>(samples: &SampleBatch, pose: &Pose, places: &mut [Column<f32>; 3]) {
    let len = samples.len;
    let [x, y, _] = turn(pose).map(|column| column.map(R::splat));
    let middle = pose.decentre.map(R::constant);
    let own = [samples.film[0].packets::<R>(len), samples.film[1].packets::<R>(len)];
    let [to_x, to_y, to_z] = places.each_mut().map(|column| column.packets_mut::<R>(len));
    for i in 0..to_x.len() {
        let (u, v) = (own[0][i], own[1][i]);
        to_x[i] = x[0].mul_add(u, y[0].mul_add(v, middle[0]));
        to_y[i] = x[1].mul_add(u, y[1].mul_add(v, middle[1]));
        // z of the lens counts towards the film.
        to_z[i] = -x[2].mul_add(u, y[2] * v);
    }
}

/// Aims every sample at a pupil point and weights it.
///
/// The rays start on the film. Their weight is cos cos' / (d^2 pdf), with theta at the film's
/// normal, theta' at the axis, d the distance to the plane of the rear vertex and the density in
/// mm^-2 of that plane; 0 where the film sees no light. Behind square film that is
/// cos^4 / (Z^2 pdf) (Kolb, Mitchell & Hanrahan 1995, eq. 3).
pub fn aim<R: Real<Scalar = f32>>(
    samples: &SampleBatch,
    bound: &PupilBound,
    plane: &Plane,
    targets: &mut TargetColumns,
    batch: &mut LensBatch<f32>,
) {
    if plane.is_square(bound) {
        aim_all::<R, false, false>(samples, bound, plane, targets, batch);
        return;
    }
    place::<R>(samples, &plane.pose, &mut targets.places);
    match plane.is_level(bound) {
        true => aim_all::<R, false, true>(samples, bound, plane, targets, batch),
        false => aim_all::<R, true, true>(samples, bound, plane, targets, batch),
    }
}

impl Plane {
    /// Whether film points are where samples say, and pupil points turned as they are.
    fn is_square(&self, bound: &PupilBound) -> bool {
        !EFFECTS || self.pose.is_square() && !bound.is_askew()
    }

    /// Whether the film is but shifted.
    fn is_level(&self, bound: &PupilBound) -> bool {
        !EFFECTS || self.pose.is_level() && !bound.is_askew()
    }
}

#[inline(never)]
fn aim_all<R: Real<Scalar = f32>, const ASKEW: bool, const PLACED: bool>(
    samples: &SampleBatch,
    bound: &PupilBound,
    plane: &Plane,
    targets: &mut TargetColumns,
    batch: &mut LensBatch<f32>,
) {
    let len = samples.len;
    let pupil = [&samples.pupil[0][..len], &samples.pupil[1][..len]];
    let TargetColumns { targets, lookup, places } = targets;
    let [film_x, film_y] = match PLACED {
        true => [&places[0], &places[1]],
        false => [&samples.film[0], &samples.film[1]],
    };
    // A grid is over the film itself, rings are about the axis.
    let known = match ASKEW {
        true => [&samples.film[0][..len], &samples.film[1][..len]],
        false => [&film_x[..len], &film_y[..len]],
    };
    bound.targets(known, pupil, lookup, targets);
    // The lanes behind the last sample are no dark film points.
    targets[len..len.next_multiple_of(R::LANES)].fill(LIT);

    let stage = Film::<R>::new(bound, plane);
    let (x, y) = (film_x.packets::<R>(len), film_y.packets::<R>(len));
    let z = places[2].packets::<R>(len);
    let v = samples.pupil[1].packets::<R>(len);
    let along = lookup.along.packets::<R>(len);
    let weight = batch.weight.packets_mut::<R>(len);
    let (to_x, to_y) = (batch.x.packets_mut::<R>(len), batch.y.packets_mut::<R>(len));
    let to_z = batch.z.packets_mut::<R>(len);
    let (to_tx, to_ty) = (batch.tx.packets_mut::<R>(len), batch.ty.packets_mut::<R>(len));
    let to_tz = batch.tz.packets_mut::<R>(len);
    let mut dark = 0;
    for i in 0..weight.len() {
        let (ray, closed) = stage.launch::<ASKEW>(&Sample {
            film: [x[i], y[i], if ASKEW { z[i] } else { R::constant(0.0) }],
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
    columns: &TargetColumns,
    plane: &Plane,
    i: usize,
) -> LensRay<f64> {
    let film = Film::<f32>::new(bound, plane);
    let [x, y] = [samples.film[0][i], samples.film[1][i]];
    let place = columns.places.each_ref().map(|column| column[i]);
    let sample = |film: [f32; 3]| Sample {
        film,
        v: samples.pupil[1][i],
        along: columns.lookup.along[i],
        target: columns.targets[i],
    };
    let (ray, _) = match (plane.is_square(bound), plane.is_level(bound)) {
        (true, _) => film.launch::<false>(&sample([x, y, 0.0])),
        (false, true) => film.launch::<false>(&sample([place[0], place[1], 0.0])),
        (false, false) => film.launch::<true>(&sample(place)),
    };
    let [x, y, z] = ray.t.map(f64::from);
    let scale = f64::from(plane.index) / (x * x + y * y + z * z).sqrt();
    LensRay {
        p: ray.p.map(f64::from),
        t: [x * scale, y * scale, z * scale],
        weight: f64::from(ray.weight),
    }
}
