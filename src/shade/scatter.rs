//! The scattering functions of a wave, eight vertices of a kind at a time.

use super::bsdf::{
    Bsdf, Coated, Conductor, Dielectric, Diffuse, DiffuseTransmission, Drawn, Frame, ThinDielectric,
};
use super::kind::{FromNumbers, Kind};
use super::vertices::{Vectors, Vertices, set, vector};
use crate::lanes::Real;

/// What a vertex sends towards the film from its light, and where its path goes on.
struct Sent<R> {
    brings: [R; 3],
    next: [R; 3],
    throughput: [R; 3],
    density: R,
    eta2: R,
}

/// One packet of vertices.
struct Packet<R> {
    normal: [R; 3],
    tangent: [R; 3],
    wo: [R; 3],
    wi: [R; 3],
    light: [R; 3],
    light_density: R,
    throughput: [R; 3],
}

impl<R: Real<Scalar = f32>> Packet<R> {
    /// What the light brings: by `evaluate` a share of it is scattered to the film. `alone`
    /// says that no other ray looks for it.
    #[inline(always)]
    fn brings(&self, (f, density): ([R; 3], R), alone: bool) -> [R; 3] {
        let one = R::splat(1.0);
        let ratio = density / self.light_density;
        let weight = if alone { one } else { one / ratio.mul_add(ratio, one) };
        let mut brings = [one; 3];
        for channel in 0..3 {
            brings[channel] = self.throughput[channel] * f[channel] * self.light[channel] * weight;
        }
        brings
    }

    /// The packet's answer, from the drawn direction in the frame.
    #[inline(always)]
    fn sent(&self, frame: &Frame<R>, brings: [R; 3], drawn: &Drawn<R>) -> Sent<R> {
        let [tr, tg, tb] = self.throughput;
        let [wr, wg, wb] = drawn.weight;
        let only = R::constant(f64::INFINITY);
        Sent {
            brings,
            next: frame.world(drawn.wi),
            throughput: [tr * wr, tg * wg, tb * wb],
            density: R::select(drawn.singular, only, drawn.density),
            eta2: drawn.eta2,
        }
    }
}

#[inline(always)]
fn load<R: Real<Scalar = f32>>(columns: &Vectors, at: usize) -> [R; 3] {
    [R::load(&columns[0][at..]), R::load(&columns[1][at..]), R::load(&columns[2][at..])]
}

#[inline(always)]
fn store<R: Real<Scalar = f32>>(columns: &mut Vectors, at: usize, from: [R; 3]) {
    for axis in 0..3 {
        from[axis].store(&mut columns[axis][at..]);
    }
}

impl Vertices {
    /// Evaluates and draws for all vertices. `alone`: light comes by the shadow rays only, where
    /// a surface is diffuse.
    pub(super) fn scatter<R: Real<Scalar = f32>>(&mut self, alone: bool) {
        for kind in Kind::ALL {
            match kind {
                Kind::Diffuse => self.packets::<R, Diffuse<R>>(kind, alone),
                Kind::DiffuseTransmission => {
                    self.packets::<R, DiffuseTransmission<R>>(kind, alone);
                }
                Kind::Conductor => self.packets::<R, Conductor<R>>(kind, false),
                Kind::Dielectric => self.packets::<R, Dielectric<R>>(kind, false),
                Kind::ThinDielectric => self.packets::<R, ThinDielectric<R>>(kind, false),
                Kind::CoatedDiffuse => {
                    let coats = std::mem::take(&mut self.coated_diffuse);
                    self.walks(kind, &coats);
                    self.coated_diffuse = coats;
                }
                Kind::CoatedConductor => {
                    let coats = std::mem::take(&mut self.coated_conductor);
                    self.walks(kind, &coats);
                    self.coated_conductor = coats;
                }
                Kind::Interface => {}
            }
        }
    }

    fn packet<R: Real<Scalar = f32>>(&self, at: usize) -> Packet<R> {
        Packet {
            normal: load(&self.normal, at),
            tangent: load(&self.tangent, at),
            wo: load(&self.wo, at),
            wi: load(&self.wi, at),
            light: load(&self.light, at),
            light_density: R::load(&self.light_density[at..]),
            throughput: load(&self.throughput, at),
        }
    }

    #[inline(always)]
    fn put<R: Real<Scalar = f32>>(&mut self, at: usize, sent: Sent<R>) {
        store(&mut self.brings, at, sent.brings);
        store(&mut self.next, at, sent.next);
        store(&mut self.next_throughput, at, sent.throughput);
        sent.density.store(&mut self.next_density[at..]);
        sent.eta2.store(&mut self.next_eta2[at..]);
    }

    #[inline(never)]
    fn packets<R: Real<Scalar = f32>, B: FromNumbers<R>>(&mut self, kind: Kind, alone: bool) {
        for at in self.ranges[kind as usize].clone().step_by(R::LANES) {
            let packet = self.packet::<R>(at);
            let mut numbers = [R::splat(0.0); super::kind::NUMBERS];
            for (number, column) in numbers.iter_mut().zip(&self.numbers) {
                *number = R::load(&column[at..]);
            }
            let bsdf = B::from_numbers(numbers);
            let frame = Frame::about(packet.normal, packet.tangent);
            let (wo, wi) = (frame.local(packet.wo), frame.local(packet.wi));
            let brings = packet.brings(bsdf.evaluate(wo, wi), alone);
            if alone {
                store(&mut self.brings, at, brings);
                store(&mut self.next_throughput, at, [R::splat(0.0); 3]);
                continue;
            }
            let [u, v, lobe] = load(&self.dice, at);
            let drawn = bsdf.draw(wo, [u, v], lobe);
            self.put(at, packet.sent(&frame, brings, &drawn));
        }
    }

    /// Coats are walked through one by one.
    fn walks<B: Bsdf<f32>>(&mut self, kind: Kind, coats: &[Coated<B>]) {
        for (at, coat) in self.ranges[kind as usize].clone().zip(coats) {
            let packet = self.packet::<f32>(at);
            let frame = Frame::about(packet.normal, packet.tangent);
            let (wo, wi) = (frame.local(packet.wo), frame.local(packet.wi));
            let seed = self.seeds[at];
            let brings = match vector(&self.light, at) == [0.0; 3] {
                true => [0.0; 3],
                false => packet.brings(coat.evaluate(wo, wi, seed), false),
            };
            let [u, v, lobe] = vector(&self.dice, at);
            let drawn = coat.draw(wo, [u, v], lobe, seed);
            let sent = packet.sent(&frame, brings, &drawn);
            self.put(at, sent);
            set(&mut self.brings, at, brings);
        }
    }
}
