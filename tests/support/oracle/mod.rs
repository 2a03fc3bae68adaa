//! Oracle: an independent textbook ray tracer in f64, from the film through a lens.
//!
//! It shares no code with the program, so that one mistake cannot hide in both. [`trace_spheres`] is
//! fast and handles spheres only, by their centres and the quadratic formula. [`Oracle::trace`]
//! handles every surface: it evaluates the height of a point above the surface and brackets the
//! change of its sign. Tilted surfaces are rotated by 3 x 3 matrices. Both refract in vector form
//! (Heckbert, in Glassner 1989, "An Introduction to Ray Tracing", p. 291). z runs from the film
//! (z = 0) to the scene. Lengths are in mm.

mod iris;
pub mod placement;
mod sag;

use petzval_lens::{BlockReason, Blocked, Prescription};

use super::Random;
use iris::margin_and_transmission;
use placement::Placement;
use sag::Sag;

/// A vector.
pub type V = [f64; 3];

pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn unit(d: V) -> V {
    let length = dot(d, d).sqrt();
    d.map(|v| v / length)
}

fn along(a: V, t: f64, d: V) -> V {
    [a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2]]
}

/// Traces a ray through a lens of spheres and planes. Returns the exit point relative to the front
/// vertex and the unit direction, or the row, from 0, at which the ray ends.
pub fn trace_spheres(
    lens: &Prescription,
    film: f64,
    start: V,
    towards: V,
) -> Result<[V; 2], usize> {
    trace_spheres_visiting(lens, film, start, towards, |_, _, _| {})
}

/// Does as [`trace_spheres`], and calls `visit` with the row, the cosine of incidence and the point at each
/// surface.
pub fn trace_spheres_visiting(
    lens: &Prescription,
    film: f64,
    start: V,
    towards: V,
    mut visit: impl FnMut(usize, f64, V),
) -> Result<[V; 2], usize> {
    let mut p = start;
    let mut d = unit(towards);
    let mut vertex = film;
    for (i, row) in lens.rows.iter().enumerate().rev() {
        let half = row.diameter / 2.0;
        if row.radius.is_infinite() {
            let t = (vertex - p[2]) / d[2];
            if t <= 0.0 {
                return Err(i);
            }
            p = along(p, t, d);
            if p[0] * p[0] + p[1] * p[1] > half * half {
                return Err(i);
            }
            visit(i, d[2], p);
            d = refract(d, [0.0, 0.0, -1.0], row.index, lens.index_before(i)).ok_or(i)?;
        } else {
            // The centre lies towards the film where the radius is positive.
            let centre = [0.0, 0.0, vertex - row.radius];
            let o = [p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]];
            let b = dot(o, d);
            let disc = b * b - dot(o, o) + row.radius * row.radius;
            if disc < 0.0 {
                return Err(i);
            }
            // The sheet at the vertex: the far one where the centre is on this side.
            let t = if row.radius > 0.0 { -b + disc.sqrt() } else { -b - disc.sqrt() };
            p = along(p, t, d);
            let n = [p[0] / row.radius, p[1] / row.radius, (p[2] - centre[2]) / row.radius];
            let past_equator = n[2] <= 0.0;
            if p[0] * p[0] + p[1] * p[1] > half * half || past_equator {
                return Err(i);
            }
            let n = n.map(|v| -v);
            visit(i, -dot(d, n), p);
            d = refract(d, n, row.index, lens.index_before(i)).ok_or(i)?;
        }
        if i > 0 {
            vertex += lens.rows[i - 1].thickness;
        }
    }
    Ok([[p[0], p[1], p[2] - vertex], d])
}

/// Refracts a unit direction (Heckbert). The normal points against the ray. Returns `None` at total
/// internal reflection.
fn refract(d: V, n: V, n1: f64, n2: f64) -> Option<V> {
    let ratio = n1 / n2;
    let c1 = -dot(d, n);
    let c2 = 1.0 - ratio * ratio * (1.0 - c1 * c1);
    if c2 < 0.0 {
        return None;
    }
    let k = ratio * c1 - c2.sqrt();
    Some([ratio * d[0] + k * n[0], ratio * d[1] + k * n[1], ratio * d[2] + k * n[2]])
}

/// A ray that leaves the lens.
#[derive(Clone, Copy, Debug)]
pub struct Exit {
    /// Point relative to the front vertex, mm.
    pub p: V,
    /// Unit direction.
    pub d: V,
    /// Transmitted part of a weight of 1.
    pub weight: f64,
}

/// Result of tracing a ray, and its distances from another result.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    pub end: Result<Exit, Blocked>,
    /// Distance of the path from the nearest edge that clips, mm.
    pub rim: f64,
    /// The smallest cosine of incidence and refraction on the path: 0 at tangency and at total
    /// internal reflection.
    pub cosine: f64,
}

/// A lens with its sags and placements.
pub struct Oracle<'a> {
    lens: &'a Prescription,
    sags: Vec<Sag>,
    placements: Vec<Placement>,
}

impl<'a> Oracle<'a> {
    pub fn new(lens: &'a Prescription) -> Self {
        let sags = lens.rows.iter().map(Sag::of).collect();
        let placements = (0..lens.rows.len()).map(|row| Placement::of(lens, row)).collect();
        Self { lens, sags, placements }
    }

    /// Traces a ray from the film, which is `film` mm behind the rear vertex.
    pub fn trace(&self, film: f64, start: V, towards: V) -> Outcome {
        self.trace_perturbed(film, start, towards, |v| v)
    }

    /// Traces a ray, and changes each of its numbers at random by a relative error of up to `size` at
    /// each surface, as roundings do.
    pub fn trace_with_errors(
        &self,
        film: f64,
        start: V,
        towards: V,
        size: f64,
        random: &mut Random,
    ) -> Outcome {
        self.trace_perturbed(film, start, towards, |v| v * (1.0 + size * random.between(-1.0, 1.0)))
    }

    fn trace_perturbed(
        &self,
        film: f64,
        start: V,
        towards: V,
        mut perturb: impl FnMut(f64) -> f64,
    ) -> Outcome {
        let mut p = start;
        let mut d = unit(towards);
        let mut advance = film;
        let (mut rim, mut cosine, mut weight) = (f64::INFINITY, 1.0f64, 1.0);
        for (i, row) in self.lens.rows.iter().enumerate().rev() {
            let (sag, placement) = (&self.sags[i], &self.placements[i]);
            let mut step = || -> Result<(), BlockReason> {
                p[2] -= advance;
                [p, d] = placement.enter(p, d);
                p = p.map(&mut perturb);
                if d[2] <= 0.0 {
                    return Err(BlockReason::Miss);
                }
                let Some(met) = sag.intersect(p, d) else {
                    // Rounding decides whether a ray misses a sphere close to its equator.
                    rim = rim.min(sag.distance_from_equator(p, d));
                    return Err(BlockReason::Miss);
                };
                p = met;
                let h = p[0].hypot(p[1]);
                rim = rim.min((h - sag.half).abs());
                let clip = if row.stop { BlockReason::Stop } else { BlockReason::Clip };
                if h > sag.half {
                    return Err(clip);
                }
                let n = unit(sag.normal([p[0], p[1]])).map(|v| -v);
                cosine = cosine.min(-dot(n, d));
                let before = self.lens.index_before(i);
                let refracted = refract(d, n, row.index, before);
                let past = 1.0 - (row.index / before).powi(2) * (1.0 - dot(n, d).powi(2));
                cosine = cosine.min(past.abs().sqrt());
                d = unit(refracted.ok_or(BlockReason::Tir)?.map(&mut perturb));
                let (inside, share) = margin_and_transmission(&row.iris, sag.half, [p[0], p[1]]);
                rim = rim.min(inside.abs());
                weight *= share;
                if share == 0.0 {
                    return Err(clip);
                }
                if row.obstruction > 0.0 {
                    rim = rim.min((h - row.obstruction / 2.0).abs());
                    if h < row.obstruction / 2.0 {
                        return Err(clip);
                    }
                }
                [p, d] = placement.leave(p, d);
                Ok(())
            };
            if let Err(reason) = step() {
                return Outcome { end: Err(Blocked { row: i, reason }), rim, cosine };
            }
            advance = if i > 0 { self.lens.rows[i - 1].thickness } else { 0.0 };
        }
        Outcome { end: Ok(Exit { p, d, weight }), rim, cosine }
    }
}
