//! Naive path tracer. It tests every shape and samples directions without regard to lights. Only
//! point-like lights, which no ray can hit, get shadow rays. It uses neither multiple importance
//! sampling nor Russian roulette.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::material::{Colour, NaiveMaterial, by};
use crate::support::Random;
use crate::world::{FIELD, Form, PointLike, Shape, World};

/// Hit of a ray on a shape.
struct Hit<'a> {
    shape: &'a Shape,
    t: f64,
    uv: DVec2,
    normal: DVec3,
}

/// Smallest distance of a hit from the ray's origin.
const MIN_DISTANCE: f64 = 1e-9;

/// Returns the hits of a ray on a shape, the nearest first: distance, texture coordinates, normal.
fn intersections(form: &Form, origin: DVec3, direction: DVec3) -> [Option<(f64, DVec2, DVec3)>; 2] {
    match *form {
        Form::Quad(c, u, v) => {
            let [c, u, v] = [c, u, v].map(DVec3::from);
            let normal = u.cross(v);
            let t = (c - origin).dot(normal) / direction.dot(normal);
            let p = origin + direction * t - c;
            let area = normal.length_squared();
            let at = DVec2::new(p.cross(v).dot(normal) / area, u.cross(p).dot(normal) / area);
            let inside = at.min_element() >= 0.0 && at.max_element() <= 1.0;
            [(t > MIN_DISTANCE && inside).then(|| (t, at, normal.normalize())), None]
        }
        Form::Ball(centre, radius) => {
            let centre = DVec3::from(centre);
            let away = origin - centre;
            let half = away.dot(direction);
            let root2 = half * half - away.length_squared() + radius * radius;
            [-1.0, 1.0].map(|sign| {
                let t = -half + sign * root2.sqrt();
                let normal = (away + direction * t) / radius;
                (t > MIN_DISTANCE).then_some((t, DVec2::ZERO, normal))
            })
        }
    }
}

/// Returns whether the checkerboard has its first value here.
fn is_first_square(uv: DVec2) -> bool {
    let square = (uv * 4.0).floor();
    (square.x + square.y).rem_euclid(2.0) == 0.0
}

impl World {
    fn nearest(&self, origin: DVec3, direction: DVec3, random: &mut Random) -> Option<Hit<'_>> {
        let mut nearest: Option<Hit> = None;
        for shape in &self.shapes {
            for (t, uv, normal) in
                intersections(&shape.form, origin, direction).into_iter().flatten()
            {
                if nearest.as_ref().is_some_and(|hit| hit.t <= t) {
                    continue;
                }
                let alpha = shape.alpha[usize::from(!is_first_square(uv))];
                if alpha >= 1.0 || random.next() < alpha {
                    let normal = if shape.reversed { -normal } else { normal };
                    nearest = Some(Hit { shape, t, uv, normal });
                }
            }
        }
        nearest
    }

    fn sky(&self, d: DVec3) -> Colour {
        let Some(sky) = self.sky else { return [0.0; 3] };
        let Some(picture) = &self.picture else { return sky };
        // Clarberg 2008: the centre of the square is +z, its corners are -z.
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

    /// Returns the radiance that arrives at a point against the direction `along`.
    pub fn radiance(&self, from: DVec3, along: DVec3, depth: u32, random: &mut Random) -> Colour {
        let (mut origin, mut direction) = (from, along);
        let (mut sum, mut left) = ([0.0; 3], [1.0; 3]);
        let add = |sum: &mut Colour, left: Colour, light: Colour| {
            *sum = [0, 1, 2].map(|c| sum[c] + left[c] * light[c]);
        };
        for vertex in 0..=depth {
            let Some(hit) = self.nearest(origin, direction, random) else {
                add(&mut sum, left, self.sky(direction));
                break;
            };
            if hit.shape.two_sided || hit.normal.dot(direction) < 0.0 {
                add(&mut sum, left, hit.shape.emits);
            }
            if vertex == depth {
                break;
            }
            let point = origin + direction * hit.t;
            let (normal, material) = hit.surface(random);
            let (x, y) = normal.any_orthonormal_pair();
            let local = |w: DVec3| DVec3::new(w.dot(x), w.dot(y), w.dot(normal));
            let wo = local(-direction);
            for source in &self.lights {
                let (towards, distance, light) = source.at(point);
                let value = material.value(wo, local(towards), random);
                let blocked = self.nearest(point, towards, random).is_some_and(|m| m.t < distance);
                if !blocked {
                    add(&mut sum, [0, 1, 2].map(|c| left[c] * value[c]), light);
                }
            }
            let Some((wi, weight)) = material.sample(wo, random) else { break };
            left = [0, 1, 2].map(|c| left[c] * weight[c]);
            if left == [0.0; 3] {
                break;
            }
            (origin, direction) = (point, (x * wi.x + y * wi.y + normal * wi.z).normalize());
        }
        sum
    }

    /// Returns the radiance along a random camera ray in a cell of a grid of `of` x `of` cells.
    pub fn sample(&self, cell: [u32; 2], of: u32, depth: u32, random: &mut Random) -> Colour {
        let half = (FIELD.to_radians() / 2.0).tan();
        let [x, y] =
            cell.map(|c| half * ((f64::from(c) + random.next()) * 2.0 / f64::from(of) - 1.0));
        self.radiance(DVec3::ZERO, DVec3::new(x, y, 1.0).normalize(), depth, random)
    }
}

impl Hit<'_> {
    /// Returns the shading normal, and the material, the chosen one of a mixture.
    fn surface(&self, random: &mut Random) -> (DVec3, NaiveMaterial) {
        let (mut normal, mut material) = (self.normal, &self.shape.material);
        loop {
            match material {
                NaiveMaterial::Mix(amount, both) => {
                    material = &both[usize::from(random.next() < *amount)]
                }
                NaiveMaterial::Bumped([a, b], under) => {
                    let Form::Quad(_, u, v) = self.shape.form else {
                        panic!("only quads have bump maps")
                    };
                    let [u, v] = [u, v].map(DVec3::from);
                    let bent = (u + self.normal * *a).cross(v + self.normal * *b).normalize();
                    normal = bent * bent.dot(self.normal).signum();
                    material = under;
                }
                NaiveMaterial::Checkerboard(one, other) => {
                    return (
                        normal,
                        NaiveMaterial::Diffuse(if is_first_square(self.uv) {
                            *one
                        } else {
                            *other
                        }),
                    );
                }
                _ => return (normal, material.clone()),
            }
        }
    }
}

impl PointLike {
    /// Returns the direction to the light, its distance, and the irradiance across the beam.
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
