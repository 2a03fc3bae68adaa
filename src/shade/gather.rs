//! The scalar parts of shading: what a surface is, which light it looks at, and where its rays go.

use glam::Vec3;

use super::Vertex;
use super::dice::Dice;
use super::footprint::Bounce;
use super::kind::{
    KINDS, Kind, any_tangent, coated_conductor, coated_diffuse, numbers, resolve, turns,
};
use super::look::Look;
use super::vertices::{Vertices, set, vector};
use crate::rays::{Column, HitBatch, NONE, Ray, RayBatch, RayDifferential};
use crate::scene::{Scene, SurfacePoint};

/// The power heuristic's weight of a choice against another; densities may be infinite.
#[inline(always)]
fn heuristic(mine: f32, other: f32) -> f32 {
    // Of two choices that neither can make, this one was made.
    let ratio = if other > 0.0 { other / mine } else { 0.0 };
    1.0 / (1.0 + ratio * ratio)
}

/// The largest channel of a throughput.
#[inline(always)]
fn largest(throughput: [f32; 3]) -> f32 {
    throughput.iter().fold(0.0, |a, &b| a.max(b))
}

/// The surface at the hit of the i-th ray.
fn look<'a>(
    scene: &'a Scene,
    vertex: &'a Vertex,
    rays: &RayBatch,
    hits: &HitBatch,
    i: usize,
    point: SurfacePoint,
) -> Look<'a> {
    let look = Look::at(scene, &vertex.beam, rays.ray(i), hits[i], point);
    match vertex.depth > 0 && scene.is_textured() {
        true => look.seen_by(rays.differential[i]),
        false => look,
    }
}

/// The differential of the ray that the i-th ray becomes at a smooth surface.
fn differential(
    scene: &Scene,
    vertex: &Vertex,
    rays: &RayBatch,
    hits: &HitBatch,
    i: usize,
    point: SurfacePoint,
    bounce: &Bounce,
) -> RayDifferential {
    let known = vertex.depth == 0 || rays.differential[i] != RayDifferential::UNKNOWN;
    match known {
        true => look(scene, vertex, rays, hits, i, point).bounced(bounce),
        false => RayDifferential::UNKNOWN,
    }
}

impl Vertices {
    /// Sorts the hits of a wave by kind, and adds what they shine by themselves to `radiance`.
    pub(super) fn gather(
        &mut self,
        scene: &Scene,
        vertex: &Vertex,
        rays: &RayBatch,
        hits: &HitBatch,
        radiance: &mut [Column<f32>; 3],
        next: &mut RayBatch,
    ) {
        self.sort(scene, vertex, rays, hits);
        let emit = |i: usize, light: [f32; 3], other: f32, radiance: &mut [Column<f32>; 3]| {
            // Nothing but the lens could have chosen the direction of a camera ray.
            let mine = if vertex.depth == 0 { f32::INFINITY } else { rays.density[i] };
            let (weight, slot) = (heuristic(mine, other), rays.slot[i] as usize);
            let throughput = rays.carried(i);
            for channel in 0..3 {
                radiance[channel][slot] += throughput[channel] * light[channel] * weight;
            }
        };
        let mut places = self.ranges.clone().map(|range| range.start);
        self.coated_diffuse.clear();
        self.coated_conductor.clear();
        for i in 0..rays.len {
            let ray = rays.ray(i);
            let direction = Vec3::from(ray.direction);
            let origin = Vec3::from(ray.origin);
            if hits[i].shape == NONE {
                for &sky in &scene.lights.skies {
                    let light = scene.sky_radiance(sky, direction);
                    emit(i, light, scene.sky_density(origin, sky, direction), radiance);
                }
                continue;
            }
            let (shape, point) = scene.surface(&ray, &hits[i]);
            if shape.light != NONE {
                let light = scene.emitted(&ray, &hits[i], point.normal, -direction);
                if light != [0.0; 3] {
                    let other = scene.emitter_density(origin, &hits[i], &point, direction);
                    emit(i, light, other, radiance);
                }
            }
            if vertex.ends(rays.density[i]) {
                continue;
            }
            let (kind, material) = self.kinds[i];
            let scale = match vertex.depth {
                0 => 1.0 / largest(rays.carried(i)).max(f32::MIN_POSITIVE),
                _ => rays.roulette_scale[i],
            };
            if kind == Kind::Interface {
                let origin = point.leave(direction).to_array();
                let ray = Ray { origin, direction: ray.direction, t_max: f32::INFINITY };
                next.push(ray, rays.carried(i), rays.slot[i]);
                let last = next.len - 1;
                (next.density[last], next.roulette_scale[last]) = (f32::INFINITY, scale);
                if scene.is_textured() {
                    let straight = Bounce { normal: point.normal, next: direction, eta2: 1.0 };
                    next.differential[last] =
                        differential(scene, vertex, rays, hits, i, point, &straight);
                }
                continue;
            }
            let place = &mut places[kind as usize];
            let at = *place;
            *place += 1;
            let material = &scene.materials[material as usize];
            let bends = material.bump.is_some() || material.normal_map.is_some();
            let look = look(scene, vertex, rays, hits, i, point);
            let (normal, tangent) = match bends || turns(material) {
                true => look.bent(material),
                false => (point.shading, any_tangent(point.shading)),
            };
            match kind {
                Kind::CoatedDiffuse => self.coated_diffuse.extend(coated_diffuse(material, &look)),
                Kind::CoatedConductor => {
                    self.coated_conductor.extend(coated_conductor(material, &look));
                }
                _ => {
                    for (column, number) in self.numbers.iter_mut().zip(numbers(material, &look)) {
                        column[at] = number;
                    }
                }
            }
            self.ray[at] = i as u32;
            self.slot[at] = rays.slot[i];
            self.points[at] = point;
            self.roulette_scale[at] = scale;
            set(&mut self.normal, at, normal.to_array());
            set(&mut self.tangent, at, tangent.to_array());
            set(&mut self.wo, at, (-direction).to_array());
            set(&mut self.throughput, at, rays.carried(i));
        }
    }

    /// Finds out of what kind every hit is, and where each kind will stand.
    fn sort(&mut self, scene: &Scene, vertex: &Vertex, rays: &RayBatch, hits: &HitBatch) {
        self.kinds.clear();
        let mut counts = [0; KINDS + 1];
        for i in 0..rays.len {
            let hit = hits[i];
            if hit.shape == NONE || vertex.ends(rays.density[i]) {
                self.kinds.push((Kind::Interface, NONE));
                continue;
            }
            let material = scene.shapes[hit.shape as usize].material;
            let (material, kind) = resolve(scene, material, || {
                look(scene, vertex, rays, hits, i, scene.surface(&rays.ray(i), &hit).1)
            });
            self.kinds.push((kind, material));
            counts[kind as usize] += 1;
        }
        let mut start = 0;
        for (range, count) in self.ranges.iter_mut().zip(counts) {
            *range = start..start + count;
            start = range.end.next_multiple_of(8);
        }
        let room = start.max(self.points.len());
        self.ray.resize(room, 0);
        self.slot.resize(room, 0);
        self.points.resize(room, Default::default());
        self.shadow.resize(room, Default::default());
        self.roulette.resize(room, 0.0);
        self.seeds.resize(room, 0);
    }

    /// Chooses a light for every vertex, but for those that only mirror or refract.
    pub(super) fn light(&mut self, scene: &Scene, dice: &Dice) {
        for kind in Kind::ALL {
            for at in self.ranges[kind as usize].clone() {
                let throw = dice.at(self.ray[at] as usize);
                let [u, v] = throw.bounce;
                set(&mut self.dice, at, [u, v, throw.roulette[1]]);
                self.roulette[at] = throw.roulette[0];
                self.seeds[at] = throw.seed;
                let singular = kind.singular([self.numbers[0][at], self.numbers[1][at]]);
                let sample = (!singular)
                    .then(|| scene.sample_light(&self.points[at], throw.choice, throw.light))
                    .flatten();
                let Some(sample) = sample.filter(|sample| sample.density > 0.0) else {
                    set(&mut self.light, at, [0.0; 3]);
                    set(&mut self.wi, at, vector(&self.normal, at));
                    self.light_density[at] = 1.0;
                    continue;
                };
                set(&mut self.wi, at, sample.direction.normalize_or_zero().to_array());
                set(&mut self.light, at, sample.radiance.map(|l| l / sample.density));
                // Where no other ray runs into the light, its own weight is 1.
                self.light_density[at] =
                    if sample.singular { f32::INFINITY } else { sample.density };
                self.shadow[at] = (sample.direction.to_array(), sample.t_max);
            }
        }
    }

    /// The chance that a path survives Russian roulette, where it is less than 1.
    ///
    /// It is the share of the camera ray's throughput that is left, apart from what refraction takes
    /// from radiance. The camera ray's own throughput holds the exposure: it says nothing about the
    /// path, and the noise of a picture must not depend on the f-number or the ISO.
    #[inline(always)]
    pub(super) fn chance(&self, vertex: &Vertex, at: usize) -> Option<f32> {
        let scale = self.roulette_scale[at] * self.next_eta2[at];
        let left = largest(vector(&self.next_throughput, at)) * scale;
        (vertex.depth >= 1 && left < 1.0).then_some(left)
    }

    /// Sends out the shadow rays and the next rays of paths.
    pub(super) fn leave(
        &mut self,
        scene: &Scene,
        vertex: &Vertex,
        rays: &RayBatch,
        hits: &HitBatch,
        shadows: &mut RayBatch,
        next: &mut RayBatch,
    ) {
        for at in self.places() {
            let (point, slot) = (&self.points[at], self.slot[at]);
            let brings = vector(&self.brings, at);
            if brings.iter().any(|&b| b > 0.0) {
                let (direction, t_max) = self.shadow[at];
                let origin = point.leave(direction.into()).to_array();
                shadows.push(Ray { origin, direction, t_max }, brings, slot);
            }
            let mut throughput = vector(&self.next_throughput, at);
            if throughput.iter().all(|&t| t <= 0.0) {
                continue;
            }
            if let Some(chance) = self.chance(vertex, at) {
                if self.roulette[at] >= chance {
                    continue;
                }
                throughput = throughput.map(|t| t / chance);
            }
            let direction = vector(&self.next, at);
            let origin = point.leave(direction.into()).to_array();
            next.push(Ray { origin, direction, t_max: f32::INFINITY }, throughput, slot);
            let last = next.len - 1;
            next.density[last] = self.next_density[at];
            next.roulette_scale[last] = self.roulette_scale[at] * self.next_eta2[at];
            if scene.is_textured() {
                next.differential[last] = match self.next_density[at].is_infinite() {
                    true => {
                        let normal = vector(&self.normal, at).into();
                        let eta2 = self.next_eta2[at];
                        let bounce = Bounce { normal, next: direction.into(), eta2 };
                        let i = self.ray[at] as usize;
                        differential(scene, vertex, rays, hits, i, self.points[at], &bounce)
                    }
                    false => RayDifferential::UNKNOWN,
                };
            }
        }
    }
}
