//! Naive path tracer. It tests every shape and samples directions without regard to lights. Only
//! point-like lights, which no ray can hit, get shadow rays. It uses neither multiple importance
//! sampling nor Russian roulette.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::material::{Colour, NaiveMaterial, by, cosine, fresnel};
use super::matter::Matter;
use super::world::{FIELD, Form, PointLike, Shape, World};
use crate::support::Random;

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

/// Returns the share of diffuse light that enters a surface of relative index `eta`.
fn entering(eta: f64) -> f64 {
    const STEPS: u32 = 200;
    let cos = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
    let sum: f64 = (0..STEPS).map(|i| 2.0 * cos(i) * (1.0 - fresnel(cos(i), eta))).sum();
    sum / f64::from(STEPS)
}

/// Returns the direction of light behind a surface, whose normal it comes from.
fn refract(direction: DVec3, normal: DVec3, eta: f64) -> DVec3 {
    let cos = -normal.dot(direction);
    let inside = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
    (direction / eta + normal * (cos / eta - inside)).normalize()
}

/// Returns a direction of uniform density.
fn uniform_direction(random: &mut Random) -> DVec3 {
    let z = random.between(-1.0, 1.0);
    let (sin, cos) = (2.0 * PI * random.next()).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * cos, r * sin, z)
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

    /// Returns the radiance that arrives at a point against the direction `along`. In a world with
    /// media that are not grey, a path carries one channel.
    pub fn radiance(&self, from: DVec3, along: DVec3, depth: u32, random: &mut Random) -> Colour {
        let (mut origin, mut direction) = (from, along);
        let (mut sum, mut left) = ([0.0; 3], [1.0; 3]);
        let grey = self.media.iter().all(Matter::is_grey);
        let channel = if grey { 0 } else { (random.next() * 3.0) as usize };
        if !grey {
            left = [0, 1, 2].map(|c| if c == channel { 3.0 } else { 0.0 });
        }
        let mut medium = self.around;
        let add = |sum: &mut Colour, left: Colour, light: Colour| {
            *sum = [0, 1, 2].map(|c| sum[c] + left[c] * light[c]);
        };
        let mut vertex = 0;
        while vertex <= depth {
            let hit = self.nearest(origin, direction, random);
            let end = hit.as_ref().map_or(f64::INFINITY, |hit| hit.t);
            let matter = medium.map(|index| &self.media[index]);
            let collision = matter.and_then(|matter| {
                Some((matter, matter.collide(origin, direction, end, channel, random)?))
            });
            if let Some((matter, t)) = collision {
                if vertex == depth {
                    break;
                }
                let point = origin + direction * t;
                let [absorbed, scattered] = matter.shares();
                add(&mut sum, left, [0, 1, 2].map(|c| absorbed[c] * matter.emits[c]));
                left = [0, 1, 2].map(|c| left[c] * scattered[c]);
                for source in &self.lights {
                    let (towards, distance, light) = source.at(point);
                    let passes = self.passes(point, towards, distance, medium, channel, random);
                    if passes {
                        let value = matter.phase(direction.dot(towards));
                        add(&mut sum, by(left, value), light);
                    }
                }
                let next = uniform_direction(random);
                left = by(left, 4.0 * PI * matter.phase(direction.dot(next)));
                (origin, direction) = (point, next);
                vertex += 1;
                continue;
            }
            let Some(hit) = hit else {
                add(&mut sum, left, self.sky(direction));
                break;
            };
            if hit.shape.two_sided || hit.normal.dot(direction) < 0.0 {
                add(&mut sum, left, hit.shape.emits);
            }
            let point = origin + direction * hit.t;
            let (normal, material) = hit.surface(random);
            if let NaiveMaterial::Interface = material {
                (origin, medium) = (point, hit.beyond(medium, direction));
                continue;
            }
            if vertex == depth {
                break;
            }
            if let NaiveMaterial::Below(eta, matter) = &material
                && random.next() >= fresnel(normal.dot(-direction), *eta)
            {
                // The radiance of the path is that of the outside over eta^2, until it leaves.
                let bent = refract(direction, normal, *eta);
                let Some((end, outwards, kept)) = self.walk(matter, *eta, point, bent, random)
                else {
                    break;
                };
                left = [0, 1, 2].map(|c| left[c] * kept[c]);
                vertex += 1;
                if vertex == depth {
                    break;
                }
                let leaving = |cos: f64| (1.0 - fresnel(cos, *eta)) / entering(*eta);
                for source in &self.lights {
                    let (towards, distance, light) = source.at(end);
                    let cos = outwards.dot(towards);
                    if cos > 0.0 && self.passes(end, towards, distance, medium, channel, random) {
                        add(&mut sum, by(left, leaving(cos) * cos / PI), light);
                    }
                }
                let (x, y) = outwards.any_orthonormal_pair();
                let next = cosine(random);
                left = by(left, leaving(next.z));
                (origin, direction) = (end, x * next.x + y * next.y + outwards * next.z);
                vertex += 1;
                continue;
            }
            if let NaiveMaterial::Below(..) = material {
                (origin, direction) = (point, direction - normal * (2.0 * normal.dot(direction)));
                vertex += 1;
                continue;
            }
            let (x, y) = normal.any_orthonormal_pair();
            let local = |w: DVec3| DVec3::new(w.dot(x), w.dot(y), w.dot(normal));
            let wo = local(-direction);
            for source in &self.lights {
                let (towards, distance, light) = source.at(point);
                let value = material.value(wo, local(towards), random);
                let around = hit.beyond(medium, towards);
                if self.passes(point, towards, distance, around, channel, random) {
                    add(&mut sum, [0, 1, 2].map(|c| left[c] * value[c]), light);
                }
            }
            let Some((wi, weight)) = material.sample(wo, random) else { break };
            left = [0, 1, 2].map(|c| left[c] * weight[c]);
            if left == [0.0; 3] {
                break;
            }
            direction = (x * wi.x + y * wi.y + normal * wi.z).normalize();
            (origin, medium) = (point, hit.beyond(medium, direction));
            vertex += 1;
        }
        sum
    }

    /// Walks through a grey medium until light leaves. Returns the point, the normal there, and the
    /// share of light that is left.
    fn walk(
        &self,
        matter: &Matter,
        eta: f64,
        from: DVec3,
        along: DVec3,
        random: &mut Random,
    ) -> Option<(DVec3, DVec3, Colour)> {
        let (mut origin, mut direction, mut left) = (from, along, [1.0; 3]);
        let [_, scattered] = matter.shares();
        let reflected_inside = 1.0 - entering(eta) / (eta * eta);
        for _ in 0..10_000 {
            let hit = self.nearest(origin, direction, random)?;
            if let Some(t) = matter.collide(origin, direction, hit.t, 0, random) {
                left = [0, 1, 2].map(|c| left[c] * scattered[c]);
                // The product of weights of a long walk would have an infinite variance.
                let most = matter.phase(matter.g.signum());
                let next = loop {
                    let next = uniform_direction(random);
                    if random.next() * most < matter.phase(direction.dot(next)) {
                        break next;
                    }
                };
                (origin, direction) = (origin + direction * t, next);
                continue;
            }
            let (end, inwards) = (origin + direction * hit.t, -hit.normal);
            if random.next() >= reflected_inside {
                return Some((end, hit.normal, left));
            }
            let ((x, y), next) = (inwards.any_orthonormal_pair(), cosine(random));
            (origin, direction) = (end, x * next.x + y * next.y + inwards * next.z);
        }
        None
    }

    /// Returns whether light of a channel passes media and interfaces up to a distance.
    fn passes(
        &self,
        from: DVec3,
        along: DVec3,
        distance: f64,
        mut medium: Option<usize>,
        channel: usize,
        random: &mut Random,
    ) -> bool {
        let (mut origin, mut left) = (from, distance);
        loop {
            let hit = self.nearest(origin, along, random).filter(|hit| hit.t < left);
            let end = hit.as_ref().map_or(left, |hit| hit.t);
            if let Some(index) = medium
                && self.media[index].collide(origin, along, end, channel, random).is_some()
            {
                return false;
            }
            let Some(hit) = hit else { return true };
            if !matches!(hit.shape.material, NaiveMaterial::Interface) {
                return false;
            }
            medium = hit.beyond(medium, along);
            (origin, left) = (origin + along * hit.t, left - hit.t);
        }
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
    /// Returns the medium of light that leaves the surface in a direction.
    fn beyond(&self, current: Option<usize>, direction: DVec3) -> Option<usize> {
        let Some([inside, outside]) = self.shape.sides else { return current };
        if self.normal.dot(direction) > 0.0 { outside } else { inside }
    }

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
