//! The naive path tracer: every shape is tried, directions are drawn without regard to lights,
//! only lamps, which no ray can meet, are looked at; no weights, no roulette.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::matter::{Colour, Matter, by};
use crate::support::Random;
use crate::world::{FIELD, Form, Lamp, Shape, World};

/// Where a ray met a shape.
struct Met<'a> {
    shape: &'a Shape,
    t: f64,
    uv: DVec2,
    normal: DVec3,
}

/// Rays begin this far from where they began.
const AWAY: f64 = 1e-9;

/// Distances from a ray's origin to a shape, near first, with texture coordinates and normal.
fn meetings(form: &Form, origin: DVec3, direction: DVec3) -> [Option<(f64, DVec2, DVec3)>; 2] {
    match *form {
        Form::Quad(c, u, v) => {
            let [c, u, v] = [c, u, v].map(DVec3::from);
            let normal = u.cross(v);
            let t = (c - origin).dot(normal) / direction.dot(normal);
            let p = origin + direction * t - c;
            let area = normal.length_squared();
            let at = DVec2::new(p.cross(v).dot(normal) / area, u.cross(p).dot(normal) / area);
            let inside = at.min_element() >= 0.0 && at.max_element() <= 1.0;
            [(t > AWAY && inside).then(|| (t, at, normal.normalize())), None]
        }
        Form::Ball(centre, radius) => {
            let centre = DVec3::from(centre);
            let away = origin - centre;
            let half = away.dot(direction);
            let root2 = half * half - away.length_squared() + radius * radius;
            [-1.0, 1.0].map(|sign| {
                let t = -half + sign * root2.sqrt();
                let normal = (away + direction * t) / radius;
                (t > AWAY).then_some((t, DVec2::ZERO, normal))
            })
        }
    }
}

/// The first of a board's two values where a square of 1/4 is even.
fn even(uv: DVec2) -> bool {
    let square = (uv * 4.0).floor();
    (square.x + square.y).rem_euclid(2.0) == 0.0
}

impl World {
    fn nearest(&self, origin: DVec3, direction: DVec3, random: &mut Random) -> Option<Met<'_>> {
        let mut nearest: Option<Met> = None;
        for shape in &self.shapes {
            for (t, uv, normal) in meetings(&shape.form, origin, direction).into_iter().flatten() {
                if nearest.as_ref().is_some_and(|met| met.t <= t) {
                    continue;
                }
                let alpha = shape.alpha[usize::from(!even(uv))];
                if alpha >= 1.0 || random.next() < alpha {
                    let normal = if shape.reversed { -normal } else { normal };
                    nearest = Some(Met { shape, t, uv, normal });
                }
            }
        }
        nearest
    }

    fn sky(&self, d: DVec3) -> Colour {
        let Some(sky) = self.sky else { return [0.0; 3] };
        let Some(picture) = &self.picture else { return sky };
        // Clarberg 2008: the square's middle is +z, its corners are -z.
        let r = (1.0 - d.z.abs()).max(0.0).sqrt();
        let turn = d.y.abs().atan2(d.x.abs()) / (PI / 2.0);
        let (mut u, mut v) = (r - turn * r, turn * r);
        if d.z < 0.0 {
            (u, v) = (1.0 - v, 1.0 - u);
        }
        let place = |c: f64, sign: f64| {
            let n = picture.len() as f64;
            ((c.copysign(sign) + 1.0) / 2.0 * n).clamp(0.0, n - 1.0) as usize
        };
        let pixel = picture[place(v, d.y)][place(u, d.x)];
        [0, 1, 2].map(|c| pixel[c] * sky[c])
    }

    /// The radiance that arrives at a point from a direction.
    pub fn arrives(&self, from: DVec3, along: DVec3, depth: u32, random: &mut Random) -> Colour {
        let (mut origin, mut direction) = (from, along);
        let (mut sum, mut left) = ([0.0; 3], [1.0; 3]);
        let add = |sum: &mut Colour, left: Colour, light: Colour| {
            *sum = [0, 1, 2].map(|c| sum[c] + left[c] * light[c]);
        };
        for vertex in 0..=depth {
            let Some(met) = self.nearest(origin, direction, random) else {
                add(&mut sum, left, self.sky(direction));
                break;
            };
            if met.shape.two_sided || met.normal.dot(direction) < 0.0 {
                add(&mut sum, left, met.shape.emits);
            }
            if vertex == depth {
                break;
            }
            let point = origin + direction * met.t;
            let (normal, matter) = met.surface(random);
            let (x, y) = normal.any_orthonormal_pair();
            let local = |w: DVec3| DVec3::new(w.dot(x), w.dot(y), w.dot(normal));
            let wo = local(-direction);
            for lamp in &self.lamps {
                let (towards, distance, light) = lamp.at(point);
                let value = matter.value(wo, local(towards), random);
                let blocked = self.nearest(point, towards, random).is_some_and(|m| m.t < distance);
                if !blocked {
                    add(&mut sum, [0, 1, 2].map(|c| left[c] * value[c]), light);
                }
            }
            let Some((wi, weight)) = matter.draw(wo, random) else { break };
            left = [0, 1, 2].map(|c| left[c] * weight[c]);
            if left == [0.0; 3] {
                break;
            }
            (origin, direction) = (point, (x * wi.x + y * wi.y + normal * wi.z).normalize());
        }
        sum
    }

    /// What a ray of the camera brings from somewhere in a cell of this many by as many.
    pub fn sample(&self, cell: [u32; 2], of: u32, depth: u32, random: &mut Random) -> Colour {
        let half = (FIELD.to_radians() / 2.0).tan();
        let [x, y] =
            cell.map(|c| half * ((f64::from(c) + random.next()) * 2.0 / f64::from(of) - 1.0));
        self.arrives(DVec3::ZERO, DVec3::new(x, y, 1.0).normalize(), depth, random)
    }
}

impl Met<'_> {
    /// The shading normal, and the material once dice are thrown.
    fn surface(&self, random: &mut Random) -> (DVec3, Matter) {
        let (mut normal, mut matter) = (self.normal, &self.shape.matter);
        loop {
            match matter {
                Matter::Mix(amount, both) => matter = &both[usize::from(random.next() < *amount)],
                Matter::Bent([a, b], under) => {
                    let Form::Quad(_, u, v) = self.shape.form else { panic!("bent balls") };
                    let [u, v] = [u, v].map(DVec3::from);
                    let bent = (u + self.normal * *a).cross(v + self.normal * *b).normalize();
                    normal = bent * bent.dot(self.normal).signum();
                    matter = under;
                }
                Matter::Board(one, other) => {
                    return (normal, Matter::Diffuse(if even(self.uv) { *one } else { *other }));
                }
                _ => return (normal, matter.clone()),
            }
        }
    }
}

impl Lamp {
    /// Direction to it, distance, and irradiance across the beam.
    fn at(&self, point: DVec3) -> (DVec3, f64, Colour) {
        match *self {
            Self::Point { from, intensity } => {
                let away = DVec3::from(from) - point;
                let d2 = away.length_squared();
                (away.normalize(), d2.sqrt(), by(intensity, 1.0 / d2))
            }
            Self::Spot { from, to, cone, fade, intensity } => {
                let away = DVec3::from(from) - point;
                let axis = (DVec3::from(to) - DVec3::from(from)).normalize();
                let cos = axis.dot(-away.normalize());
                let (end, start) = (cone.to_radians().cos(), (cone - fade).to_radians().cos());
                let t = ((cos - end) / (start - end)).clamp(0.0, 1.0);
                let d2 = away.length_squared();
                (away.normalize(), d2.sqrt(), by(intensity, t * t * (3.0 - 2.0 * t) / d2))
            }
            Self::Distant { from, irradiance } => {
                (DVec3::from(from).normalize(), f64::INFINITY, irradiance)
            }
        }
    }
}
