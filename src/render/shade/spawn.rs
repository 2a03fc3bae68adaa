//! Russian roulette, and the shadow rays and next rays that leave the vertices of a wave.

use super::bsdf::BsdfKind;
use super::neighbour_ray::SpecularBounce;
use super::random::RandomColumns;
use super::vertices::{Vertices, vector};
use super::{PathVertex, ShadeInputs};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::scale;
use petzval_base::rays::{Hit, PathFlags, Ray, RayBatch, RayDifferential, SpawnedRays};
use petzval_scene::{LobeColumns, load_vector};

/// Smallest share of the first throughput with which a path survives Russian roulette in any case.
///
/// A dim path can still find a bright surface. Values of 1/2, 1/4 and 1/8 multiply relative variance times
/// CPU time by 0.81, 0.77 and 0.79 in the atelier and by 0.86, 0.81 and 0.85 at night, compared with a
/// value of 1 (300 x 200 pixels, 96 samples).
const SURE_SURVIVAL: f32 = 0.25;

/// Returns the probability with which a path survives Russian roulette, or more than 1: the share of its
/// first throughput that is left, over [`SURE_SURVIVAL`]. `scale` is 1 over that first throughput, without
/// the factor of refraction on radiance.
#[inline(always)]
fn survival<R: Real<Scalar = f32>>(brightest: R, scale: R) -> R {
    brightest * scale / R::splat(SURE_SURVIVAL)
}

/// Returns the largest channel of a throughput.
#[inline(always)]
pub(super) fn max_component(throughput: [f32; 3]) -> f32 {
    throughput.iter().fold(0.0, |a, &b| a.max(b))
}

impl Vertices {
    /// Returns the probability with which a path survives Russian roulette, or `None` if it
    /// survives in any case.
    ///
    /// The throughput of the camera ray contains the exposure. It is divided out because the noise of
    /// a picture must not depend on the f-number or the ISO.
    #[inline(always)]
    pub(super) fn survival_probability(&self, vertex: &PathVertex, at: usize) -> Option<f32> {
        let scale = self.roulette_scale[at] * self.next_eta2[at];
        let survival = survival(max_component(vector(&self.next_throughput, at)), scale);
        (vertex.depth >= 1 && survival < 1.0).then_some(survival)
    }

    /// Writes the shadow rays and the next rays of the paths.
    pub(super) fn spawn<R: Real<Scalar = f32>>(
        &self,
        inputs: &ShadeInputs,
        random: &RandomColumns,
        shadows: &mut RayBatch,
        next: &mut RayBatch,
    ) {
        self.pass_through(inputs, next);
        for (range, _) in self.shaded_ranges() {
            for at in range.clone().step_by(R::LANES) {
                let lanes = (1 << R::LANES.min(range.end - at)) - 1;
                self.spawn_shadows::<R>(inputs, at, lanes, shadows);
                self.spawn_next::<R>(inputs, random, at, lanes, next);
            }
        }
    }

    /// Flags the paths that scatter at a surface which receives caustics: the first of the path.
    #[inline(never)]
    pub(super) fn flag_receivers(&mut self) {
        for (range, kind) in self.shaded_ranges() {
            let stage = kind.stage::<f32>();
            for at in range {
                let specular = self.next_flags[at].contains(PathFlags::SPECULAR);
                if !specular && stage.receives_caustics(&self.parameters, at) {
                    self.next_flags[at] = self.next_flags[at] | PathFlags::FROM_RECEIVER;
                }
            }
        }
    }

    /// Writes the shadow rays of a packet. `lanes` are its vertices, as bits.
    #[inline(always)]
    fn spawn_shadows<R: Real<Scalar = f32>>(
        &self,
        inputs: &ShadeInputs,
        at: usize,
        lanes: u32,
        shadows: &mut RayBatch,
    ) {
        let contribution = load_vector::<R>(&self.contribution, at);
        let lanes = lanes & R::bits(R::splat(0.0).lt(max_channel(contribution)));
        if lanes == 0 {
            return;
        }
        let direction = load_vector(&self.lights.shadow, at);
        let origin = self.surfaces.points::<R>(at).offset_origin(direction);
        let rays = SpawnedRays {
            origin,
            direction,
            t_max: R::load(&self.lights.shadow_end[at..]),
            throughput: contribution,
        };
        let first = shadows.len;
        shadows.append(lanes, &rays, &self.slot[at..]);
        if inputs.scene.has_media() {
            self.set_media::<R>(inputs, at, lanes, first, shadows);
        }
    }

    /// Writes the next rays of a packet. `lanes` are its vertices, as bits.
    #[inline(always)]
    fn spawn_next<R: Real<Scalar = f32>>(
        &self,
        inputs: &ShadeInputs,
        random: &RandomColumns,
        at: usize,
        lanes: u32,
        next: &mut RayBatch,
    ) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let mut throughput = load_vector::<R>(&self.next_throughput, at);
        let brightest = max_channel(throughput);
        let mut alive = zero.lt(brightest);
        if lanes & R::bits(alive) == 0 {
            return;
        }
        let roulette_scale = R::load(&self.roulette_scale[at..]) * R::load(&self.next_eta2[at..]);
        if inputs.vertex.depth >= 1 {
            let survival = survival(brightest, roulette_scale);
            let certain = one.le(survival);
            alive = alive & (certain | R::load(&random.roulette[0][at..]).lt(survival));
            throughput = scale(throughput, one / R::select(certain, one, survival));
        }
        let lanes = lanes & R::bits(alive);
        let direction = load_vector(&self.next, at);
        let rays = SpawnedRays {
            origin: self.surfaces.points::<R>(at).offset_origin(direction),
            direction,
            t_max: R::splat(f32::INFINITY),
            throughput,
        };
        let first = next.len;
        next.append(lanes, &rays, &self.slot[at..]);
        next.pdf.pack(first, lanes, R::load(&self.next_pdf[at..]));
        next.flags.pack_flags::<R>(first, lanes, PathFlags::load(&self.next_flags[at..]));
        next.roulette_scale.pack(first, lanes, roulette_scale);
        for axis in 0..3 {
            next.facing[axis].pack(first, lanes, R::load(&self.facing[axis][at..]));
        }
        if let Some(LobeColumns { wo, alpha2, share }) = self.lobes.columns(&self.wo) {
            for axis in 0..3 {
                next.wo[axis].pack(first, lanes, R::load(&wo[axis][at..]));
            }
            next.gloss[0].pack(first, lanes, R::load(&alpha2[at..]));
            next.gloss[1].pack(first, lanes, R::load(&share[at..]));
        }
        if inputs.scene.has_media() {
            self.set_media::<R>(inputs, at, lanes, first, next);
        }
        if inputs.scene.is_textured() {
            for (to, lane) in (first..).zip((0..R::LANES).filter(|lane| lanes >> lane & 1 == 1)) {
                next.differential[to] = self.next_differential(inputs, at + lane);
            }
        }
    }

    /// Sets the media of rays that leave the vertices of a packet: of the lanes of a set, given as
    /// bits, from the ray `first` on.
    #[inline(never)]
    fn set_media<R: Real<Scalar = f32>>(
        &self,
        inputs: &ShadeInputs,
        at: usize,
        lanes: u32,
        first: usize,
        rays: &mut RayBatch,
    ) {
        for (to, lane) in (first..).zip((0..R::LANES).filter(|lane| lanes >> lane & 1 == 1)) {
            rays.medium[to] = self.medium_towards(inputs, at + lane, rays.ray(to).direction);
        }
    }

    /// Returns the medium of a ray that leaves a vertex in a direction.
    fn medium_towards(&self, inputs: &ShadeInputs, at: usize, direction: [f32; 3]) -> u32 {
        let i = self.order[at] as usize;
        let (hit, current) = (&inputs.hits[i], inputs.rays.medium[i]);
        if hit.shape == Hit::IN_MEDIUM {
            return current;
        }
        let normal = self.surfaces.points::<f32>(at).normal.into();
        inputs.scene.medium_beyond(hit, current, normal, direction.into())
    }

    /// Continues rays straight on through surfaces that do not scatter.
    fn pass_through(&self, inputs: &ShadeInputs, next: &mut RayBatch) {
        let rays = inputs.rays;
        for at in self.ranges[BsdfKind::Interface as usize].clone() {
            let i = self.order[at] as usize;
            let (ray, point) = (rays.ray(i), self.surfaces.points::<f32>(at));
            let origin = point.offset_origin(ray.direction);
            let ray = Ray { origin, direction: ray.direction, t_max: f32::INFINITY };
            next.push(ray, rays.throughput(i), rays.slot[i]);
            let last = next.len - 1;
            // Behind an interface, a path no longer counts as one that may end a caustic.
            next.flags[last] = PathFlags::SPECULAR | inputs.flags(i) & PathFlags::SCATTERED;
            next.roulette_scale[last] = inputs.roulette_scale(i);
            next.set_facing(last, [0.0; 3]);
            next.gloss[1][last] = 0.0;
            if inputs.scene.has_media() {
                next.medium[last] = self.medium_towards(inputs, at, ray.direction);
            }
            if inputs.scene.is_textured() {
                let (normal, next_direction) = (point.normal.into(), ray.direction.into());
                let straight = SpecularBounce { normal, next: next_direction, eta2: 1.0 };
                next.differential[last] = inputs.differential_after_bounce(i, &straight);
            }
        }
    }

    /// Returns the differential of a vertex's next ray; it is unknown after scattering.
    fn next_differential(&self, inputs: &ShadeInputs, at: usize) -> RayDifferential {
        if !self.next_flags[at].contains(PathFlags::SPECULAR) {
            return RayDifferential::UNKNOWN;
        }
        let bounce = SpecularBounce {
            normal: vector(&self.normal, at).into(),
            next: vector(&self.next, at).into(),
            eta2: self.next_eta2[at],
        };
        inputs.differential_after_bounce(self.order[at] as usize, &bounce)
    }
}

/// Returns the largest channel; NaN counts as 0.
#[inline(always)]
fn max_channel<R: Real<Scalar = f32>>(colour: [R; 3]) -> R {
    let zero = R::splat(0.0);
    colour[0].max(colour[1].max(colour[2].max(zero)))
}
