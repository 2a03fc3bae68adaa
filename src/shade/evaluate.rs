//! Evaluation and sampling of the BSDFs of a wave, eight vertices of a kind at a time.

use super::bsdf::{
    Bsdf, BsdfSample, Coated, Conductor, Dielectric, Diffuse, DiffuseTransmission, ShadingFrame,
    ThinDielectric,
};
use super::bsdf_kind::BsdfKind;
use super::bsdf_parameters::{FromParameters, PARAMETER_COUNT};
use super::mis::power_heuristic_fused;
use super::vertices::{VectorColumns, Vertices, set, vector};
use crate::lanes::Real;

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
            next: frame.to_world(sample.wi),
            throughput: [tr * wr, tg * wg, tb * wb],
            pdf: R::select(sample.singular, R::constant(f64::INFINITY), sample.pdf),
            eta2: sample.eta2,
        }
    }
}

#[inline(always)]
fn load<R: Real<Scalar = f32>>(columns: &VectorColumns, at: usize) -> [R; 3] {
    [R::load(&columns[0][at..]), R::load(&columns[1][at..]), R::load(&columns[2][at..])]
}

#[inline(always)]
fn store<R: Real<Scalar = f32>>(columns: &mut VectorColumns, at: usize, from: [R; 3]) {
    for axis in 0..3 {
        from[axis].store(&mut columns[axis][at..]);
    }
}

impl Vertices {
    /// Evaluates the BSDFs of all vertices towards their lights, and samples the next directions.
    /// With `skip_mis`, diffuse surfaces take light from shadow rays only and end their paths.
    pub(super) fn evaluate<R: Real<Scalar = f32>>(&mut self, skip_mis: bool) {
        for kind in BsdfKind::ALL {
            match kind {
                BsdfKind::Diffuse => self.evaluate_packets::<R, Diffuse<R>>(kind, skip_mis),
                BsdfKind::DiffuseTransmission => {
                    self.evaluate_packets::<R, DiffuseTransmission<R>>(kind, skip_mis);
                }
                BsdfKind::Conductor => self.evaluate_packets::<R, Conductor<R>>(kind, false),
                BsdfKind::Dielectric => self.evaluate_packets::<R, Dielectric<R>>(kind, false),
                BsdfKind::ThinDielectric => {
                    self.evaluate_packets::<R, ThinDielectric<R>>(kind, false);
                }
                BsdfKind::CoatedDiffuse => {
                    let coated = std::mem::take(&mut self.coated_diffuse);
                    self.evaluate_coated(kind, &coated);
                    self.coated_diffuse = coated;
                }
                BsdfKind::CoatedConductor => {
                    let coated = std::mem::take(&mut self.coated_conductor);
                    self.evaluate_coated(kind, &coated);
                    self.coated_conductor = coated;
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
            wi: load(&self.wi, at),
            light: load(&self.light, at),
            light_pdf: R::load(&self.light_pdf[at..]),
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

    #[inline(never)]
    fn evaluate_packets<R: Real<Scalar = f32>, B: FromParameters<R>>(
        &mut self,
        kind: BsdfKind,
        skip_mis: bool,
    ) {
        for at in self.ranges[kind as usize].clone().step_by(R::LANES) {
            let packet = self.packet::<R>(at);
            let mut parameters = [R::splat(0.0); PARAMETER_COUNT];
            for (parameter, column) in parameters.iter_mut().zip(&self.parameters) {
                *parameter = R::load(&column[at..]);
            }
            let bsdf = B::from_parameters(parameters);
            let frame = ShadingFrame::about(packet.normal, packet.tangent);
            let (wo, wi) = (frame.to_local(packet.wo), frame.to_local(packet.wi));
            let contribution = packet.contribution(bsdf.evaluate(wo, wi), skip_mis);
            if skip_mis {
                store(&mut self.contribution, at, contribution);
                store(&mut self.next_throughput, at, [R::splat(0.0); 3]);
                continue;
            }
            let [u, v, lobe] = load(&self.bsdf_random, at);
            let sample = bsdf.sample(wo, [u, v], lobe);
            self.store_packet(at, packet.scattered(&frame, contribution, &sample));
        }
    }

    /// Evaluates coated surfaces one at a time, as each is a random walk.
    fn evaluate_coated<B: Bsdf<f32>>(&mut self, kind: BsdfKind, coated: &[Coated<B>]) {
        for (at, bsdf) in self.ranges[kind as usize].clone().zip(coated) {
            let packet = self.packet::<f32>(at);
            let frame = ShadingFrame::about(packet.normal, packet.tangent);
            let (wo, wi) = (frame.to_local(packet.wo), frame.to_local(packet.wi));
            let seed = self.seeds[at];
            let contribution = match vector(&self.light, at) == [0.0; 3] {
                true => [0.0; 3],
                false => packet.contribution(bsdf.evaluate(wo, wi, seed), false),
            };
            let [u, v, lobe] = vector(&self.bsdf_random, at);
            let sample = bsdf.sample(wo, [u, v], lobe, seed);
            let scattered = packet.scattered(&frame, contribution, &sample);
            self.store_packet(at, scattered);
            set(&mut self.contribution, at, contribution);
        }
    }
}
