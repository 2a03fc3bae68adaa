//! Lanes: BSDFs give the same results bit for bit in one lane and in eight, and all are finite.

use petzval_base::lanes::{Real, Word, f32x8};
use petzval_render::shade::bsdf::{
    Bsdf, BsdfSample, CoatLayer, Coated, Conductor, Dielectric, Diffuse, MisWeights,
};

use super::scene::{ETA, K, Kind, REFLECTANCE, Random, splat};

/// Directions that break kernels.
const NASTY: [[f32; 3]; 16] = [
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
    [1.0, 0.0, 0.0],
    [0.0, -1.0, 0.0],
    [1.0, 0.0, -0.0],
    [1.0, 0.0, 1e-20],
    [1.0, 0.0, 1e-45],
    [-1.0, 0.0, 1e-7],
    [0.0, 1.0, -1e-4],
    [0.8, 0.0, 0.6],
    [-0.8, 0.0, 0.6],
    [-0.8, 0.0, -0.6],
    [0.48, 0.64, 0.6],
    [0.36, -0.48, -0.8],
    [-0.36, 0.48, 0.8],
    [1e-20, 1e-20, 1.0],
];

const NUMBERS: [f32; 5] = [0.0, 0.25, 0.5, 0.75, 1.0 - f32::EPSILON / 2.0];

const ALPHAS: [[f32; 2]; 8] = [
    [0.0, 0.0],
    [1e-4, 1e-4],
    [0.0, 1e-3],
    [1e-3, 1e-3],
    [0.05, 1e-4],
    [0.3, 0.3],
    [1.0, 0.2],
    [1.0, 1.0],
];

fn kinds() -> Vec<Kind> {
    let mut kinds = vec![Kind::Diffuse, Kind::DiffuseTransmission];
    kinds.extend([1.5, 0.7, 1.0, 0.0, 1e19, 3e19].map(|eta| Kind::Thin(eta, REFLECTANCE)));
    for alpha in ALPHAS {
        kinds.extend([Kind::Conductor(alpha), Kind::Mirror(alpha)]);
        kinds.extend([1.5, 0.7, 1.0, 1.000_000_1, 0.0].map(|eta| Kind::Dielectric(alpha, eta)));
    }
    for alpha in ALPHAS {
        kinds.extend([0.0, 1.0, 1.5].map(|eta| Kind::Plastic(REFLECTANCE, alpha[0], eta)));
        kinds.push(Kind::Plastic([0.0; 3], alpha[0], 1.5));
        kinds.push(Kind::Coated(REFLECTANCE, alpha[0], 0.3, alpha[1], 0.8));
        kinds.push(Kind::Specular(alpha[0], 0.3, 0.4, [3.0, 0.5, 0.0]));
        kinds.push(Kind::Specular(alpha[0], 0.0, 0.0, [1.0; 3]));
        kinds.push(Kind::Tinted(alpha[0], 1.5, REFLECTANCE));
        kinds.push(Kind::Coated([0.0; 3], alpha[1], 1.0, alpha[0], 1.0));
    }
    kinds.extend(super::hair::extremes().map(Kind::Hair));
    kinds
}

fn bits<R: Real<Scalar = f32>>(values: impl IntoIterator<Item = R>) -> Vec<[u32; 8]> {
    let lanes = |value: R| {
        let mut to = [0.0; 8];
        value.store(&mut to);
        to.map(f32::to_bits)
    };
    values.into_iter().map(lanes).collect()
}

#[test]
fn evaluations_of_eight_lanes_equal_those_of_one() {
    for kind in kinds() {
        let (one, eight) = (kind.build::<f32>(), kind.build::<f32x8>());
        for wo in NASTY {
            // Eight partners at a time, so that lanes of every outcome share a packet.
            for partners in NASTY.chunks(8) {
                let mut wi = [[0.0; 8]; 3];
                for (lane, w) in partners.iter().enumerate() {
                    for axis in 0..3 {
                        wi[axis][lane] = w[axis];
                    }
                }
                let (value, pdf) = eight.evaluate(splat(wo), wi.map(|a| f32x8::load(&a)));
                let packet = bits(value.into_iter().chain([pdf]));
                for (lane, &w) in partners.iter().enumerate() {
                    let (value, pdf) = one.evaluate(wo, w);
                    for (k, number) in value.into_iter().chain([pdf]).enumerate() {
                        assert_eq!(number.to_bits(), packet[k][lane], "{kind:?} {wo:?} {w:?}");
                        assert!((0.0..f32::INFINITY).contains(&number), "{kind:?} {wo:?} {w:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn samples_of_eight_lanes_equal_those_of_one() {
    for kind in kinds() {
        let (one, eight) = (kind.build::<f32>(), kind.build::<f32x8>());
        for wo in NASTY {
            for (u, v) in NUMBERS.into_iter().flat_map(|u| NUMBERS.map(|v| (u, v))) {
                let choices = [0.0, 0.01, 0.2, 0.4, 0.6, 0.8, 0.95, NUMBERS[4]];
                let draw = eight.sample(splat(wo), splat([u, v]), f32x8::load(&choices));
                let all = draw.wi.into_iter().chain(draw.weight);
                let packet = bits(all.chain([draw.pdf, draw.eta2]));
                let valid = f32x8::bits(draw.valid);
                for (lane, choice) in choices.into_iter().enumerate() {
                    let draw = one.sample(wo, [u, v], choice);
                    let name = format!("{kind:?} {wo:?} {u} {v} {choice}");
                    assert_eq!(draw.valid, valid >> lane & 1 == 1, "{name}");
                    let all = draw.wi.into_iter().chain(draw.weight);
                    for (k, number) in all.chain([draw.pdf, draw.eta2]).enumerate() {
                        assert_eq!(number.to_bits(), packet[k][lane], "{name}");
                        assert!(number.is_finite(), "{name}: {draw:?}");
                    }
                    let unit: f32 = draw.wi.iter().map(|x| x * x).sum();
                    assert!((unit - 1.0).abs() < 1e-5, "{name}: {draw:?}");
                    assert!(draw.weight.iter().all(|&w| w >= 0.0) && draw.pdf >= 0.0);
                    let round = matches!(kind, Kind::Hair(_));
                    assert!(!draw.valid || round || wo[2] != 0.0, "{name}");
                }
            }
        }
    }
}

#[test]
fn smooth_and_rough_lanes_can_share_a_packet() {
    let alphas = [0.0, 0.3, 5e-4, 0.1, 0.0, 1.0, 1e-3, 9e-4];
    let packed = [f32x8::load(&alphas); 2];
    let metals = Conductor::new(packed, splat(ETA), splat(K));
    let glasses = Dielectric::new(packed, f32x8::splat(1.5));
    let (wo, wi) = ([0.6, 0.0, 0.8], [-0.48, 0.36, 0.8]);
    let u = [0.3, 0.6];
    for glass in [false, true] {
        let packet: &dyn Bsdf<f32x8> = if glass { &glasses } else { &metals };
        let kind = |alpha| {
            if glass { Kind::Dielectric(alpha, 1.5) } else { Kind::Conductor(alpha) }
        };
        let (value, pdf) = packet.evaluate(splat(wo), splat(wi));
        let draw = packet.sample(splat(wo), splat(u), f32x8::splat(0.9));
        let (singular, smooth) = (f32x8::bits(draw.singular), f32x8::bits(packet.singular()));
        assert_eq!((singular, smooth), (0b1001_0101, 0b1001_0101));
        for (lane, alpha) in alphas.into_iter().enumerate() {
            let one = kind([alpha; 2]).build::<f32>();
            let (lone, lone_pdf) = one.evaluate(wo, wi);
            assert_eq!(lone, value.map(|v| v.to_array()[lane]));
            assert_eq!(lone_pdf, pdf.to_array()[lane]);
            assert_eq!(one.sample(wo, u, 0.9).wi, draw.wi.map(|v| v.to_array()[lane]));
            assert_eq!(one.sample(wo, u, 0.9).pdf > 0.0, singular >> lane & 1 == 0);
        }
    }
}

/// Interfaces, media, lengths of walks and bases that break walks in step. A mixture takes each
/// column in another order.
const COATS: [[f32; 8]; 10] = [
    [0.0, 0.3, 0.0, 0.1, 0.0, 1.0, 5e-4, 0.4],
    [1.5, 1.5, 1.3, 1.0, 1.5, 2.0, 1.5, 0.0],
    [0.01, 0.3, 0.0, 1e-30, 0.7, 0.5, 1e9, 0.1],
    [0.0, 0.0, 0.5, 0.9, 1.0, 0.0, 0.9, 0.2],
    [0.0, 0.0, 0.5, -0.7, 0.9, 0.0, 1.0, 0.0],
    [10.0, 10.0, 60.0, 0.0, 200.0, 5.0, 30.0, 1.0],
    [1.0, 3.0, 1.0, 2.0, 1.0, 0.0, 2.0, 4.0],
    [0.0, 0.3, 0.2, 1.0, 0.0, 0.4, 0.01, 0.0],
    [0.8, 1.0, 0.5, 0.0, 0.3, 0.9, 0.2, 1.0],
    [0.1, 1.0, 0.7, 0.0, 0.4, 0.9, 0.3, 1.0],
];

/// Loads a mixture of coats from a lane on.
fn coats<R: Real<Scalar = f32>>(
    mixture: usize,
    lane: usize,
) -> (Coated<R, Diffuse<R>>, Coated<R, Conductor<R>>) {
    let column = |k: usize| {
        let mut lanes = [0.0; 16];
        for i in 0..8 {
            lanes[i] = COATS[k][(i + mixture * (k + 1)) % 8];
        }
        R::load(&lanes[lane..])
    };
    let layer = CoatLayer {
        interface: Dielectric::new([column(0); 2], column(1)),
        thickness: column(2),
        albedo: [column(3), column(3) * column(9), column(3)],
        g: column(4),
        max_depth: column(5),
        samples: column(6),
        weights: if mixture.is_multiple_of(2) { MisWeights::Pbrt } else { MisWeights::Exact },
    };
    let diffuse = Diffuse { reflectance: [column(8), column(9), column(8)] };
    let metal = Conductor::new([column(7); 2], splat(ETA), splat(K));
    (Coated::new(layer, diffuse), Coated::new(layer, metal))
}

/// Directions, random numbers and seeds of eight walks.
struct Walks {
    wo: [[f32; 8]; 3],
    wi: [[f32; 8]; 3],
    u: [[f32; 8]; 3],
    seeds: [u32; 8],
}

impl Walks {
    /// Half of the directions are ordinary, half nasty.
    fn random(random: &mut Random) -> Self {
        let mut walks =
            Self { wo: [[0.0; 8]; 3], wi: [[0.0; 8]; 3], u: [[0.0; 8]; 3], seeds: [0; 8] };
        for lane in 0..8 {
            let mut directions = [random.direction(), random.direction()];
            for direction in &mut directions {
                if random.bits().is_multiple_of(4) {
                    *direction = NASTY[random.bits() as usize % NASTY.len()];
                }
            }
            let side = if random.bits().is_multiple_of(2) { 1.0 } else { -1.0 };
            for axis in 0..3 {
                walks.wo[axis][lane] = directions[0][axis] * side;
                walks.wi[axis][lane] = directions[1][axis] * side;
                walks.u[axis][lane] = random.number();
            }
            walks.seeds[lane] = random.bits();
        }
        walks
    }

    /// Returns the bits of values, densities and samples of a coat, by quantity and lane.
    fn results<R: Real<Scalar = f32>, B: Bsdf<R>>(
        &self,
        coated: &Coated<R, B>,
        lane: usize,
    ) -> Vec<[u32; 8]> {
        let load = |v: &[[f32; 8]; 3]| {
            [R::load(&v[0][lane..]), R::load(&v[1][lane..]), R::load(&v[2][lane..])]
        };
        let (wo, wi, [u, v, choice]) = (load(&self.wo), load(&self.wi), load(&self.u));
        let seed = R::Word::load(&self.seeds[lane..]);
        let (value, pdf) = coated.evaluate(wo, wi, seed);
        let BsdfSample { wi, weight, pdf: drawn, singular, valid, eta2 } =
            coated.sample(wo, [u, v], choice, seed);
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let masks = [singular, valid, coated.is_singular()];
        let masks = masks.map(|mask| R::select(mask, one, zero));
        let vectors = value.into_iter().chain(wi).chain(weight).chain(masks);
        bits(vectors.chain([pdf, drawn, eta2]))
    }
}

#[test]
fn walks_of_eight_coats_equal_those_of_one() {
    let mut random = Random::new(16);
    let mut lit = 0;
    for mixture in 0..40 {
        let (diffuse, metal) = coats::<f32x8>(mixture, 0);
        for _ in 0..60 {
            let walks = Walks::random(&mut random);
            let packets = [walks.results(&diffuse, 0), walks.results(&metal, 0)];
            for lane in 0..8 {
                let (diffuse, metal) = coats::<f32>(mixture, lane);
                let ones = [walks.results(&diffuse, lane), walks.results(&metal, lane)];
                for (one, packet) in ones.into_iter().flatten().zip(packets.iter().flatten()) {
                    assert_eq!(one[0], packet[lane], "mixture {mixture}, lane {lane}");
                    assert!(f32::from_bits(one[0]).is_finite());
                    lit += usize::from(one[0] != 0);
                }
            }
        }
    }
    assert!(lit > 200_000, "{lit}");
}

#[test]
fn a_lane_does_not_notice_its_neighbours() {
    let mut random = Random::new(17);
    for mixture in 0..8 {
        let (coated, _) = coats::<f32x8>(mixture, 0);
        for kept in 0..8 {
            let walks = Walks::random(&mut random);
            let mut others = Walks::random(&mut random);
            for axis in 0..3 {
                others.wo[axis][kept] = walks.wo[axis][kept];
                others.wi[axis][kept] = walks.wi[axis][kept];
                others.u[axis][kept] = walks.u[axis][kept];
            }
            others.seeds[kept] = walks.seeds[kept];
            let (a, b) = (walks.results(&coated, 0), others.results(&coated, 0));
            assert!(a.iter().zip(&b).all(|(a, b)| a[kept] == b[kept]), "{mixture} {kept}");
        }
    }
}
