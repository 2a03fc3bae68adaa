//! Evaluation and sampling of the BSDFs of a wave, eight vertices of a kind at a time.

use super::bsdf::{
    BsdfSample, Conductor, Diffuse, DiffuseTransmission, Hair, Measured, MediumScattering,
    MetallicRoughness, ShadingFrame, SubsurfaceExit, ThinDielectric, TintedDielectric,
};
use super::bsdf_kind::BsdfKind;
use super::bsdf_parameters::{FromParameters, PARAMETER_COUNT, coated};
use super::random::RandomColumns;
use super::vertices::Vertices;
use crate::lanes::Real;
use crate::lanes::vector::{renormalize, select};
use crate::sampler::mis::power_heuristic_fused;
use crate::scene::{MaterialModel, Scene, load_vector as load, store_vector as store};

/// Results of a packet: the contribution of the sampled light, and the next ray.
struct Scattered<R> {
    contribution: [R; 3],
    next: [R; 3],
    throughput: [R; 3],
    pdf: R,
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
            pdf: R::select(sample.singular, R::constant(f64::INFINITY), sample.pdf),
            eta2: sample.eta2,
        }
    }
}

impl Vertices {
    /// Evaluates the BSDFs of all vertices towards their lights, and samples the next directions.
    /// With `skip_mis`, diffuse surfaces take light from shadow rays only and end their paths.
    pub(super) fn evaluate<R: Real<Scalar = f32>>(
        &mut self,
        scene: &Scene,
        random: &RandomColumns,
        skip_mis: bool,
    ) {
        for kind in BsdfKind::ALL {
            match kind {
                BsdfKind::Diffuse => self.evaluate_packets::<R, Diffuse<R>>(kind, random, skip_mis),
                BsdfKind::DiffuseTransmission => {
                    self.evaluate_packets::<R, DiffuseTransmission<R>>(kind, random, skip_mis);
                }
                BsdfKind::Conductor => {
                    self.evaluate_packets::<R, Conductor<R>>(kind, random, false)
                }
                BsdfKind::Dielectric => {
                    self.evaluate_packets::<R, TintedDielectric<R>>(kind, random, false)
                }
                BsdfKind::ThinDielectric => {
                    self.evaluate_packets::<R, ThinDielectric<R>>(kind, random, false);
                }
                BsdfKind::CoatedDiffuse => self.evaluate_coated::<R, Diffuse<R>>(kind, random),
                BsdfKind::CoatedConductor => self.evaluate_coated::<R, Conductor<R>>(kind, random),
                BsdfKind::MetallicRoughness => {
                    self.evaluate_packets::<R, MetallicRoughness<R>>(kind, random, false)
                }
                BsdfKind::Measured => self.evaluate_measured(scene, random),
                BsdfKind::Hair => self.evaluate_packets::<R, Hair<R>>(kind, random, false),
                BsdfKind::SubsurfaceExit => {
                    self.evaluate_packets::<R, SubsurfaceExit<R>>(kind, random, false);
                }
                BsdfKind::Medium => {
                    self.evaluate_packets::<R, MediumScattering<R>>(kind, random, false)
                }
                BsdfKind::Interface => {}
            }
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
        scattered.eta2.store(&mut self.next_eta2[at..]);
    }

    /// Returns the parameters of a packet of a kind.
    #[inline(always)]
    pub(super) fn packet_parameters<R: Real<Scalar = f32>>(
        &self,
        kind: BsdfKind,
        at: usize,
    ) -> [R; PARAMETER_COUNT] {
        let mut parameters = [R::splat(0.0); PARAMETER_COUNT];
        let count = kind.parameter_count();
        for (parameter, column) in parameters.iter_mut().zip(&self.parameters[..count]) {
            *parameter = R::load(&column[at..]);
        }
        parameters
    }

    #[inline(never)]
    fn evaluate_packets<R: Real<Scalar = f32>, B: FromParameters<R>>(
        &mut self,
        kind: BsdfKind,
        random: &RandomColumns,
        skip_mis: bool,
    ) {
        for at in self.ranges[kind as usize].clone().step_by(R::LANES) {
            let packet = self.packet::<R>(at);
            let bsdf = B::from_parameters(self.packet_parameters(kind, at));
            let frame = ShadingFrame::about(packet.normal, packet.tangent);
            let (wo, wi) = (frame.to_local(packet.wo), frame.to_local(packet.wi));
            let contribution = packet.contribution(bsdf.evaluate(wo, wi), skip_mis);
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
    fn evaluate_measured(&mut self, scene: &Scene, random: &RandomColumns) {
        for run in 0..self.runs.len() {
            // Runs of media have no material.
            let material = scene.materials.get(self.runs[run].material as usize);
            let Some(MaterialModel::Measured(surface)) = material.map(|material| &material.model)
            else {
                continue;
            };
            let bsdf = Measured { surface };
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

    /// Evaluates coated surfaces. The walks of packets without light are skipped.
    #[inline(never)]
    fn evaluate_coated<R: Real<Scalar = f32>, B: FromParameters<R>>(
        &mut self,
        kind: BsdfKind,
        random: &RandomColumns,
    ) {
        let zero = R::splat(0.0);
        for at in self.ranges[kind as usize].clone().step_by(R::LANES) {
            let packet = self.packet::<R>(at);
            let bsdf = coated::<R, B>(self.packet_parameters(kind, at), self.coat_weights);
            let frame = ShadingFrame::about(packet.normal, packet.tangent);
            let (wo, wi) = (frame.to_local(packet.wo), frame.to_local(packet.wi));
            let seed = random.seeds::<R>(at);
            let [r, g, b] = packet.light;
            let lit = !(r.equals(zero) & g.equals(zero) & b.equals(zero));
            let mut contribution = [zero; 3];
            if R::bits(lit) != 0 {
                // No light comes from the direction 0, so that dark lanes need no walk.
                let found = bsdf.evaluate(wo, select(lit, wi, [zero; 3]), seed);
                contribution = select(lit, packet.contribution(found, false), contribution);
            }
            let lobe = R::load(&random.roulette[1][at..]);
            let sample = bsdf.sample(wo, random.bounce(at), lobe, seed);
            self.store_packet(at, packet.scattered(&frame, contribution, &sample));
        }
    }
}
