//! Evaluation and sampling of the BSDFs of a wave, eight vertices of a kind at a time.

use std::ops::Range;

use super::bsdf::{
    Bsdf, BsdfKind, BsdfSample, CoatWalks, Measured, ShadingFrame, VertexParameters,
};
use super::random::RandomColumns;
use super::vertices::Vertices;
use petzval_base::lanes::vector::{renormalize, select};
use petzval_base::lanes::{Real, Word};
use petzval_base::rays::PathFlags;
use petzval_base::sampler::mis::power_heuristic_fused;
use petzval_scene::{MaterialModel, Scene, load_vector as load, store_vector as store};

/// Inputs of the evaluation of a wave.
#[derive(Clone, Copy)]
pub(super) struct Evaluation<'a> {
    /// The scene.
    pub(super) scene: &'a Scene,
    /// Random numbers of the vertices.
    pub(super) random: &'a RandomColumns,
    /// Whether diffuse surfaces take light from shadow rays only and end their paths.
    pub(super) skip_mis: bool,
}

/// Results of a packet: the contribution of the sampled light, and the next ray.
struct Scattered<R: Real> {
    contribution: [R; 3],
    next: [R; 3],
    throughput: [R; 3],
    pdf: R,
    specular: R::Mask,
    eta2: R,
}

/// A packet of vertices.
struct VertexPacket<R> {
    normal: [R; 3],
    tangent: [R; 3],
    wo: [R; 3],
    wi: [R; 3],
    light: [R; 3],
    light_pdf: R,
    throughput: [R; 3],
}

impl<R: Real<Scalar = f32>> VertexPacket<R> {
    /// Returns the contribution of the sampled light, given the BSDF's value towards it and the
    /// density with which the BSDF samples that direction.
    #[inline(always)]
    fn contribution(&self, (f, pdf): ([R; 3], R), skip_mis: bool) -> [R; 3] {
        let one = R::splat(1.0);
        let weight = if skip_mis { one } else { power_heuristic_fused(self.light_pdf, pdf) };
        let mut contribution = [one; 3];
        for channel in 0..3 {
            contribution[channel] =
                self.throughput[channel] * f[channel] * self.light[channel] * weight;
        }
        contribution
    }

    /// Returns the contribution of the sampled light as [`Self::contribution`] does, and evaluates
    /// the BSDF only if there is light.
    #[inline(always)]
    fn contribution_if_lit(&self, bsdf: &impl Bsdf<R>, wo: [R; 3], wi: [R; 3]) -> [R; 3] {
        let zero = R::splat(0.0);
        let [r, g, b] = self.light;
        let lit = !(r.equals(zero) & g.equals(zero) & b.equals(zero));
        if R::bits(lit) == 0 {
            return [zero; 3];
        }
        // No light comes from the direction 0, so that dark lanes need no walk.
        let found = bsdf.evaluate(wo, select(lit, wi, [zero; 3]));
        select(lit, self.contribution(found, false), [zero; 3])
    }

    /// Returns the packet's results, given a sample of the BSDF in the shading frame.
    #[inline(always)]
    fn scattered(
        &self,
        frame: &ShadingFrame<R>,
        contribution: [R; 3],
        sample: &BsdfSample<R>,
    ) -> Scattered<R> {
        let [tr, tg, tb] = self.throughput;
        let [wr, wg, wb] = sample.weight;
        Scattered {
            contribution,
            // The next direction is made of this one: rounding errors of its length must not add up.
            next: renormalize(frame.to_world(sample.wi)),
            throughput: [tr * wr, tg * wg, tb * wb],
            pdf: sample.pdf,
            specular: sample.singular,
            eta2: sample.eta2,
        }
    }
}

impl Vertices {
    /// Evaluates the BSDFs of all vertices towards their lights, and samples the next directions.
    pub(super) fn evaluate<R: Real<Scalar = f32>>(&mut self, inputs: &Evaluation) {
        for kind in BsdfKind::ALL {
            let range = self.ranges[kind as usize].clone();
            kind.stage::<R>().evaluate(self, range, inputs);
        }
    }

    fn packet<R: Real<Scalar = f32>>(&self, at: usize) -> VertexPacket<R> {
        VertexPacket {
            normal: load(&self.normal, at),
            tangent: load(&self.tangent, at),
            wo: load(&self.wo, at),
            wi: load(&self.lights.wi, at),
            light: load(&self.lights.radiance, at),
            light_pdf: R::load(&self.lights.density[at..]),
            throughput: load(&self.throughput, at),
        }
    }

    #[inline(always)]
    fn store_packet<R: Real<Scalar = f32>>(&mut self, at: usize, scattered: Scattered<R>) {
        store(&mut self.contribution, at, scattered.contribution);
        store(&mut self.next, at, scattered.next);
        store(&mut self.next_throughput, at, scattered.throughput);
        scattered.pdf.store(&mut self.next_pdf[at..]);
        let (specular, others) = (PathFlags::SPECULAR, PathFlags::SCATTERED);
        let flags = PathFlags::select::<R>(scattered.specular, specular, others);
        (flags | PathFlags::load(&self.flags[at..])).store(&mut self.next_flags[at..]);
        scattered.eta2.store(&mut self.next_eta2[at..]);
    }

    /// Evaluates the BSDFs of a range of vertices with these parameters. Walks towards lights are
    /// skipped for packets without light.
    #[inline(never)]
    pub(super) fn evaluate_packets<R: Real<Scalar = f32>, P: VertexParameters<R>>(
        &mut self,
        range: Range<usize>,
        inputs: &Evaluation,
    ) {
        let random = inputs.random;
        let skip_mis = P::DIFFUSE && inputs.skip_mis;
        for at in range.step_by(R::LANES) {
            let packet = self.packet::<R>(at);
            let seed = if P::WALKS { random.seeds::<R>(at) } else { R::Word::splat(0) };
            let walks = CoatWalks { seed, weights: self.coat_weights };
            let bsdf = P::from_columns(&self.parameters[..], at).bsdf(walks);
            let frame = ShadingFrame::about(packet.normal, packet.tangent);
            let (wo, wi) = (frame.to_local(packet.wo), frame.to_local(packet.wi));
            let contribution = match P::WALKS {
                true => packet.contribution_if_lit(&bsdf, wo, wi),
                false => packet.contribution(bsdf.evaluate(wo, wi), skip_mis),
            };
            if skip_mis {
                store(&mut self.contribution, at, contribution);
                store(&mut self.next_throughput, at, [R::splat(0.0); 3]);
                continue;
            }
            let sample = bsdf.sample(wo, random.bounce(at), R::load(&random.roulette[1][at..]));
            self.store_packet(at, packet.scattered(&frame, contribution, &sample));
        }
    }

    /// Evaluates measured surfaces, one at a time.
    pub(super) fn evaluate_measured(&mut self, inputs: &Evaluation) {
        let Evaluation { scene, random, .. } = *inputs;
        for run in 0..self.runs.len() {
            // Runs of media have no material.
            let material = scene.materials.get(self.runs[run].material as usize);
            let Some(material) = material else { continue };
            let MaterialModel::Measured(surface) = &material.model else { continue };
            let bsdf = Measured { surface, uplift: material.measured_uplift };
            for at in self.runs[run].range.clone() {
                let packet = self.packet::<f32>(at);
                let frame = ShadingFrame::about(packet.normal, packet.tangent);
                let (wo, wi) = (frame.to_local(packet.wo), frame.to_local(packet.wi));
                let contribution = packet.contribution(bsdf.evaluate(wo, wi), false);
                let sample = bsdf.sample(wo, random.bounce(at));
                self.store_packet(at, packet.scattered(&frame, contribution, &sample));
            }
        }
    }
}
