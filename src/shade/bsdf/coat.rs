//! Varnish: a layer over another surface.

use std::f32::consts::PI;

use super::dielectric::{Dielectric, Lobes, Transport};
use super::phase::{henyey_greenstein, sample_henyey_greenstein};
use super::stream::Stream;
use super::vector::{dot, largest, negate, scale};
use super::{Bsdf, Drawn};

/// A layer, clear or hazy, under a border to the outside.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// The border; its index is that of the layer over that of the outside.
    pub border: Dielectric<f32>,
    /// Thickness in mean free paths. A clear layer absorbs along it.
    pub thickness: f32,
    /// Single-scattering albedo by colour channel; 0 is clear.
    pub albedo: [f32; 3],
    /// Asymmetry of the scattering in it, -1 to 1.
    pub g: f32,
    /// Most events of a walk inside the layer.
    pub max_depth: u32,
    /// Walks of an evaluation.
    pub samples: u32,
    /// How a rough border's two techniques are weighed.
    pub weights: Weights,
}

/// How an evaluation weighs the two techniques that join a walk to the light through a rough
/// border: the border draws a direction for the light, or the walk draws its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Weights {
    /// As pbrt-v4 does: where the walk draws, the other density is that of the border drawing
    /// the light for the walk, not the walk for the light. The weights do not add up to 1: of
    /// what passes a rough border and scatters on a rough base, evaluations find several
    /// per cent too much, and more than draws do.
    #[default]
    Pbrt,
    /// As Veach 1995 asks: evaluations and draws have the same mean.
    Exact,
}

/// A base that only reflects under a layer, the same from both sides: pbrt-v4's `LayeredBxDF`.
///
/// What it scatters is known only as the mean over random walks between border and base
/// (Guo, Hasan & Zhao 2018, "Position-free Monte Carlo simulation for arbitrary layered
/// BSDFs"). The walks depend on the directions and on a seed; seeds of different samples of a
/// pixel should differ. Walks end after `max_depth` events, and what is beyond is lost.
#[derive(Clone, Copy, Debug)]
pub struct Coated<B> {
    layer: Layer,
    base: B,
    clear: bool,
}

/// Keeps the streams of one seed apart.
const VALUE: u32 = 0x5eed_0001;
const DENSITY: u32 = 0x5eed_0002;
const DRAW: u32 = 0x5eed_0003;

/// Where in the layer a walk is and what it has left.
struct Walk {
    /// Height over the base, mean free paths.
    z: f32,
    /// Where it goes.
    w: [f32; 3],
    throughput: [f32; 3],
}

impl Walk {
    /// Russian roulette; whether the walk goes on.
    fn survives(&mut self, depth: u32, random: &mut Stream) -> bool {
        let left = largest(self.throughput);
        if depth <= 3 || left >= 0.25 {
            return true;
        }
        let survives = random.number() < left;
        if survives {
            self.throughput = scale(self.throughput, 1.0 / left);
        }
        survives
    }

    /// Goes where a draw leads; whether it leads anywhere.
    fn follow(&mut self, drawn: &Drawn<f32>) -> bool {
        self.w = drawn.wi;
        for channel in 0..3 {
            self.throughput[channel] *= drawn.weight[channel];
        }
        leads(drawn)
    }
}

/// What a walk meets next.
enum Event {
    /// The haze, at a height.
    Haze(f32),
    /// The border or the base.
    Side,
    /// Nothing that its number format can tell from where it is.
    Nothing,
}

fn leads(drawn: &Drawn<f32>) -> bool {
    drawn.valid && largest(drawn.weight) > 0.0 && drawn.wi[2] != 0.0
}

/// The power heuristic (Veach 1995) for two densities.
fn heuristic(mine: f32, other: f32) -> f32 {
    // The ratio first: squares of densities could leave the range of f32.
    if mine > 0.0 { 1.0 / (1.0 + (other / mine) * (other / mine)) } else { 0.0 }
}

fn add(sum: &mut [f32; 3], beta: [f32; 3], value: [f32; 3], factor: f32) {
    for channel in 0..3 {
        sum[channel] += beta[channel] * value[channel] * factor;
    }
}

/// The share of light that passes a slab of the layer along a direction.
fn transmittance(height: f32, w: [f32; 3]) -> f32 {
    if height.abs() <= f32::MIN_POSITIVE { 1.0 } else { (-(height / w[2]).abs()).exp() }
}

impl<B: Bsdf<f32>> Coated<B> {
    /// A base under a layer; the base's light must not pass through it.
    pub fn new(layer: Layer, base: B) -> Self {
        let clear = largest(layer.albedo) <= 0.0;
        let thickness = layer.thickness.max(f32::MIN_POSITIVE);
        Self { layer: Layer { thickness, ..layer }, base, clear }
    }

    /// Whether only singular lobes scatter, so that [`Self::evaluate`] is always 0.
    pub fn singular(&self) -> bool {
        self.layer.border.singular() && self.base.singular() && self.clear
    }

    /// Estimates of f |cos wi| by colour channel and of the density of [`Self::draw`]. They do
    /// not depend on each other, so a multiple-importance weight made of the one times the
    /// other is unbiased.
    pub fn evaluate(&self, wo: [f32; 3], wi: [f32; 3], seed: u32) -> ([f32; 3], f32) {
        (self.value(wo, wi, seed), self.density(wo, wi, seed))
    }

    /// An estimate of f |cos wi| by colour channel: its mean over seeds is the value.
    pub fn value(&self, wo: [f32; 3], wi: [f32; 3], seed: u32) -> [f32; 3] {
        if wo[2] * wi[2] <= 0.0 || self.singular() {
            return [0.0; 3];
        }
        let (wo, wi) = if wo[2] < 0.0 { (negate(wo), negate(wi)) } else { (wo, wi) };
        let mut random = Stream::new(seed ^ VALUE, wo.into_iter().chain(wi));
        let mut sum = [0.0; 3];
        for _ in 0..self.layer.samples {
            add(&mut sum, [1.0; 3], self.walks(wo, wi, &mut random), 1.0);
        }
        let walks = self.layer.samples.max(1) as f32;
        let (reflected, _) = self.layer.border.scatter(wo, wi, Lobes::REFLECTION);
        sum.map(|s| s / walks + reflected)
    }

    /// One walk: what goes into the layer along `wo` and comes out along `wi`. At each event it
    /// is joined to the light by two techniques: through a direction drawn at the border for
    /// `wi` beforehand, and, where that is rough, by the walk's own next direction.
    fn walks(&self, wo: [f32; 3], wi: [f32; 3], random: &mut Stream) -> [f32; 3] {
        let Layer { border, thickness, albedo, g, .. } = self.layer;
        let into = self.enter(wo, Transport::Radiance, random);
        let light = self.enter(wi, Transport::Importance, random);
        let mut sum = [0.0; 3];
        if !leads(&into) || !leads(&light) {
            return sum;
        }
        let from = negate(light.wi);
        // The draw's weight holds the cosine inside; the result holds that outside.
        let through = light.weight[0] * (wi[2] / light.wi[2]).abs();
        let rough = !border.singular();
        let mut walk = Walk { z: thickness, w: into.wi, throughput: into.weight };
        for depth in 0..self.layer.max_depth {
            if !walk.survives(depth, random) {
                break;
            }
            let back = negate(walk.w);
            match self.advance(&mut walk, random) {
                Event::Nothing => continue,
                Event::Haze(z) => {
                    let phase = henyey_greenstein(dot(back, from), g);
                    let weight = if rough { heuristic(light.density, phase) } else { 1.0 };
                    let passes = transmittance(thickness - z, light.wi) * through;
                    add(&mut sum, walk.throughput, albedo, phase * weight * passes);

                    walk.w = sample_henyey_greenstein(back, g, random.pair());
                    walk.throughput = [0, 1, 2].map(|c| walk.throughput[c] * albedo[c]);
                    walk.z = z;
                    if rough && walk.w[2] > 0.0 {
                        let phase = henyey_greenstein(dot(back, walk.w), g);
                        let (out, density) = self.exit(walk.w, wi);
                        let weight = heuristic(phase, density);
                        let passes = transmittance(thickness - z, walk.w);
                        add(&mut sum, walk.throughput, [out; 3], weight * passes);
                    }
                }
                Event::Side if walk.z > 0.0 => {
                    let (lobes, transport) = (Lobes::REFLECTION, Transport::Radiance);
                    let (u, choice) = (random.pair(), random.number());
                    if !walk.follow(&border.draw_of(back, u, choice, lobes, transport)) {
                        break;
                    }
                }
                Event::Side => {
                    let base_rough = !self.base.singular();
                    if base_rough {
                        let (value, density) = self.base.evaluate(back, from);
                        let weight = if rough { heuristic(light.density, density) } else { 1.0 };
                        let passes = transmittance(thickness, light.wi) * through;
                        add(&mut sum, walk.throughput, value, weight * passes);
                    }
                    let drawn = self.base.draw(back, random.pair(), random.number());
                    if !walk.follow(&drawn) {
                        break;
                    }
                    if rough {
                        let (out, density) = self.exit(walk.w, wi);
                        let weight =
                            if base_rough { heuristic(drawn.density, density) } else { 1.0 };
                        let passes = transmittance(thickness, walk.w);
                        add(&mut sum, walk.throughput, [out; 3], weight * passes);
                    }
                }
            }
        }
        sum
    }

    /// Draws a direction through the border into the layer.
    fn enter(&self, w: [f32; 3], transport: Transport, random: &mut Stream) -> Drawn<f32> {
        let (u, choice) = (random.pair(), random.number());
        self.layer.border.draw_of(w, u, choice, Lobes::TRANSMISSION, transport)
    }

    /// f |cos wi| of light that leaves the layer from below along `wi` when a walk goes along
    /// `w`, and the density of the other technique, for its weight.
    fn exit(&self, w: [f32; 3], wi: [f32; 3]) -> (f32, f32) {
        let (border, back) = (&self.layer.border, negate(w));
        let (value, density) = border.scatter(back, wi, Lobes::TRANSMISSION);
        match self.layer.weights {
            Weights::Pbrt => (value, density),
            Weights::Exact => (value, border.scatter(wi, back, Lobes::TRANSMISSION).1),
        }
    }

    /// Goes on to the next event of a walk; at a side, the walk is there.
    fn advance(&self, walk: &mut Walk, random: &mut Stream) -> Event {
        let Layer { thickness, .. } = self.layer;
        if self.clear {
            walk.z = if walk.z == thickness { 0.0 } else { thickness };
            let passes = transmittance(thickness, walk.w);
            walk.throughput = scale(walk.throughput, passes);
            return Event::Side;
        }
        let z = walk.z - (1.0 - random.number()).ln() * walk.w[2];
        if z == walk.z {
            return Event::Nothing;
        }
        if 0.0 < z && z < thickness {
            return Event::Haze(z);
        }
        walk.z = z.clamp(0.0, thickness);
        Event::Side
    }

    /// An estimate of the density of [`Self::draw`], for multiple importance sampling: the
    /// first reflections, and a tenth of all draws as if they went anywhere. As in pbrt-v4 its
    /// integral is only near 1.
    pub fn density(&self, wo: [f32; 3], wi: [f32; 3], seed: u32) -> f32 {
        if wo[2] == 0.0 || self.singular() {
            return 0.0;
        }
        let anywhere = 0.1 / (4.0 * PI);
        if wo[2] * wi[2] <= 0.0 {
            return anywhere;
        }
        let (wo, wi) = if wo[2] < 0.0 { (negate(wo), negate(wi)) } else { (wo, wi) };
        let mut random = Stream::new(seed ^ DENSITY, wo.into_iter().chain(wi));
        let mut sum = 0.0;
        for _ in 0..self.layer.samples {
            sum += self.transmitted_density(wo, wi, &mut random);
        }
        let walks = self.layer.samples.max(1) as f32;
        let (_, reflected) = self.layer.border.scatter(wo, wi, Lobes::REFLECTION);
        anywhere + 0.9 * (reflected + sum / walks)
    }

    /// The density of what goes in, meets the base once and comes out, estimated.
    fn transmitted_density(&self, wo: [f32; 3], wi: [f32; 3], random: &mut Stream) -> f32 {
        let border = &self.layer.border;
        let into = self.enter(wo, Transport::Radiance, random);
        let light = self.enter(wi, Transport::Importance, random);
        if !into.valid || !light.valid {
            return 0.0;
        }
        let (back, from) = (negate(into.wi), negate(light.wi));
        if border.singular() {
            return self.base.evaluate(back, from).1;
        }
        let drawn = self.base.draw(back, random.pair(), random.number());
        if !leads(&drawn) {
            return 0.0;
        }
        let (_, out) = border.scatter(negate(drawn.wi), wi, Lobes::BOTH);
        if self.base.singular() {
            return out;
        }
        let (_, reflected) = self.base.evaluate(back, from);
        reflected * heuristic(light.density, reflected) + out * heuristic(drawn.density, out)
    }

    /// Draws a direction by following a path through the layer until it leaves. The weight's
    /// mean, given the direction, is the value over the true density; `density` is the
    /// estimate of [`Self::density`], for multiple importance sampling.
    pub fn draw(&self, wo: [f32; 3], u: [f32; 2], choice: f32, seed: u32) -> Drawn<f32> {
        let below = wo[2] < 0.0;
        let upper = if below { negate(wo) } else { wo };
        let drawn = self.follow(upper, u, choice, seed);
        let wi = if below { negate(drawn.wi) } else { drawn.wi };
        let density = if drawn.valid && !drawn.singular { self.density(wo, wi, seed) } else { 0.0 };
        Drawn { wi, density, eta2: 1.0, ..drawn }.only(true)
    }

    /// [`Self::draw`] from above, without the density.
    fn follow(&self, wo: [f32; 3], u: [f32; 2], choice: f32, seed: u32) -> Drawn<f32> {
        let (both, radiance) = (Lobes::BOTH, Transport::Radiance);
        let Layer { border, g, albedo, .. } = self.layer;
        let first = border.draw_of(wo, u, choice, both, radiance);
        let nothing = first.only(false);
        if !leads(&first) {
            return nothing;
        }
        if first.wi[2] > 0.0 {
            return first;
        }
        let keys = wo.into_iter().chain(u).chain([choice]);
        let mut random = Stream::new(seed ^ DRAW, keys);
        let mut walk = Walk { z: self.layer.thickness, w: first.wi, throughput: first.weight };
        let mut singular = first.singular;
        for depth in 0..self.layer.max_depth {
            if !walk.survives(depth, &mut random) {
                return nothing;
            }
            let back = negate(walk.w);
            match self.advance(&mut walk, &mut random) {
                Event::Nothing => return nothing,
                Event::Haze(z) => {
                    walk.w = sample_henyey_greenstein(back, g, random.pair());
                    walk.throughput = [0, 1, 2].map(|c| walk.throughput[c] * albedo[c]);
                    walk.z = z;
                    singular = false;
                }
                Event::Side => {
                    let (u, choice) = (random.pair(), random.number());
                    let top = walk.z > 0.0;
                    let drawn = if top {
                        border.draw_of(back, u, choice, both, radiance)
                    } else {
                        self.base.draw(back, u, choice)
                    };
                    if !walk.follow(&drawn) {
                        return nothing;
                    }
                    singular &= drawn.singular;
                    if top && drawn.wi[2] > 0.0 {
                        return Drawn { singular, weight: walk.throughput, ..drawn };
                    }
                }
            }
        }
        nothing
    }
}
