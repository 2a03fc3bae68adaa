//! Opcodes that correct a lens in a picture with all channels: `FixVignetteRadial` and `WarpRectilinear` (Adobe, Digital
//! Negative Specification 1.7.1.0, 2023, chapter 7).

use rayon::prelude::*;

use crate::lens_correction::{FIX_VIGNETTE_RADIAL, WARP_RECTILINEAR};

/// Largest gain, and largest term of a polynomial.
const MAX_GAIN: f64 = 1e4;
const MAX_TERM: f64 = 1e6;

/// A correction of a lens.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LensOpcode {
    /// `FixVignetteRadial`.
    Gain(RadialGain),
    /// `WarpRectilinear`.
    Warp(Warp),
}

impl LensOpcode {
    /// Reads the parameters of an opcode; `None` if it is another or malformed.
    pub fn parse(id: u32, parameters: &[u8]) -> Option<Self> {
        match id {
            FIX_VIGNETTE_RADIAL => RadialGain::parse(parameters).map(Self::Gain),
            WARP_RECTILINEAR => Warp::parse(parameters).map(Self::Warp),
            _ => None,
        }
    }

    /// Returns the identifier.
    pub fn id(&self) -> u32 {
        match self {
            Self::Gain(_) => FIX_VIGNETTE_RADIAL,
            Self::Warp(_) => WARP_RECTILINEAR,
        }
    }

    /// Corrects a picture of this size.
    pub fn apply(&self, size: [usize; 2], pixels: &mut Vec<[f32; 3]>) {
        match self {
            Self::Gain(gain) => gain.apply(size, pixels),
            Self::Warp(warp) => *pixels = warp.apply(size, pixels),
        }
    }
}

/// Gain by the distance from a centre.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RadialGain {
    terms: [f64; 5],
    /// Column and row relative to width and height.
    centre: [f64; 2],
}

/// Displacement by the distance from a centre, for each channel or for all.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Warp {
    /// Radial and tangential terms.
    planes: Vec<[f64; 6]>,
    centre: [f64; 2],
}

/// Reads numbers; `None` if one is beyond [`MAX_TERM`] or not a number.
fn doubles(bytes: &[u8]) -> Option<Vec<f64>> {
    let (chunks, rest) = bytes.as_chunks::<8>();
    let numbers: Vec<f64> = chunks.iter().map(|chunk| f64::from_be_bytes(*chunk)).collect();
    (rest.is_empty() && numbers.iter().all(|n| n.abs() <= MAX_TERM)).then_some(numbers)
}

/// Returns the centre (pixels) and the distance to the farthest corner.
fn centre_and_reach(size: [usize; 2], centre: [f64; 2]) -> ([f64; 2], f64) {
    let size = size.map(|n| n as f64);
    let reach = [0, 1].map(|i| size[i] * centre[i].max(1.0 - centre[i]));
    ([0, 1].map(|i| size[i] * centre[i] - 0.5), reach[0].hypot(reach[1]))
}

impl RadialGain {
    /// Reads the parameters; `None` if they are malformed.
    fn parse(bytes: &[u8]) -> Option<Self> {
        let [terms @ .., x, y] = <[f64; 7]>::try_from(doubles(bytes)?).ok()?;
        let centre = [x, y];
        centre.iter().all(|at| (0.0..=1.0).contains(at)).then_some(Self { terms, centre })
    }

    /// Multiplies a picture of this size.
    fn apply(&self, size: [usize; 2], pixels: &mut [[f32; 3]]) {
        let ([x0, y0], reach) = centre_and_reach(size, self.centre);
        pixels.par_chunks_exact_mut(size[0]).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let [dx, dy] = [x as f64 - x0, y as f64 - y0];
                let square = (dx * dx + dy * dy) / (reach * reach);
                let sum = self.terms.iter().rev().fold(0.0, |sum, term| square * (sum + term));
                let gain = (1.0 + sum).clamp(0.0, MAX_GAIN) as f32;
                *pixel = pixel.map(|value| value * gain);
            }
        });
    }
}

impl Warp {
    /// Reads the parameters; `None` if they are malformed or not for three channels.
    fn parse(bytes: &[u8]) -> Option<Self> {
        let (count, numbers) = bytes.split_first_chunk::<4>()?;
        let count = u32::from_be_bytes(*count) as usize;
        let numbers = doubles(numbers)?;
        if ![1, 3].contains(&count) || numbers.len() != 6 * count + 2 {
            return None;
        }
        let (planes, centre) = numbers.split_at(6 * count);
        let centre = [centre[0], centre[1]];
        let planes = planes.as_chunks::<6>().0.to_vec();
        centre.iter().all(|at| (0.0..=1.0).contains(at)).then_some(Self { planes, centre })
    }

    /// Returns the place in the photograph that a place relative to the centre shows in the corrected picture, both over
    /// the reach.
    fn source(terms: &[f64; 6], [x, y]: [f64; 2]) -> [f64; 2] {
        let [k0, k1, k2, k3, t0, t1] = terms;
        let square = x * x + y * y;
        let radial = k0 + square * (k1 + square * (k2 + square * k3));
        [
            radial * x + t0 * 2.0 * x * y + t1 * (square + 2.0 * x * x),
            radial * y + t1 * 2.0 * x * y + t0 * (square + 2.0 * y * y),
        ]
    }

    /// Returns the corrected picture. Places beyond the border show the border.
    fn apply(&self, size: [usize; 2], pixels: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let (centre, reach) = centre_and_reach(size, self.centre);
        let mut corrected = vec![[0.0; 3]; pixels.len()];
        corrected.par_chunks_exact_mut(size[0]).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let at = [(x as f64 - centre[0]) / reach, (y as f64 - centre[1]) / reach];
                let source = |terms| {
                    let [x, y] = Self::source(terms, at);
                    [centre[0] + reach * x, centre[1] + reach * y]
                };
                *pixel = match &self.planes[..] {
                    [red, green, blue] => {
                        let [red] = cubic(size, pixels, source(red), [0]);
                        let [green] = cubic(size, pixels, source(green), [1]);
                        let [blue] = cubic(size, pixels, source(blue), [2]);
                        [red, green, blue]
                    }
                    all => cubic(size, pixels, source(&all[0]), [0, 1, 2]),
                };
            }
        });
        corrected
    }
}

/// Returns channels of a picture between its pixels by cubic convolution (Keys 1981).
fn cubic<const N: usize>(
    size: [usize; 2],
    pixels: &[[f32; 3]],
    at: [f64; 2],
    channels: [usize; N],
) -> [f32; N] {
    let last = size.map(|n| n as f64 - 1.0);
    let at = [0, 1].map(|i| at[i].clamp(0.0, last[i]));
    let first = at.map(|at| at.floor());
    let weights = [0, 1].map(|i| {
        let t = (at[i] - first[i]) as f32;
        [
            t * (-0.5 + t * (1.0 - 0.5 * t)),
            1.0 + t * t * (-2.5 + 1.5 * t),
            t * (0.5 + t * (2.0 - 1.5 * t)),
            t * t * (-0.5 + 0.5 * t),
        ]
    });
    let mut sum = [0.0; N];
    let place =
        |axis: usize, i: usize| (first[axis] as usize + i).saturating_sub(1).min(size[axis] - 1);
    for (j, down) in weights[1].into_iter().enumerate() {
        let row = place(1, j) * size[0];
        for (i, across) in weights[0].into_iter().enumerate() {
            let pixel = pixels[row + place(0, i)];
            for (sum, channel) in sum.iter_mut().zip(channels) {
                *sum += down * across * pixel[channel];
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use crate::PictureWindow;
    use crate::develop::Opcodes;
    use crate::lens_correction::LensCorrection;

    const CORRECTION: LensCorrection = LensCorrection {
        warp: [[1.01, -0.08, 0.02, 0.0], [1.0, -0.08, 0.02, 0.0], [0.99, -0.08, 0.02, 0.0]],
        gain: [0.5, 0.2, 0.1, 0.05, 0.01],
    };

    fn parsed(size: [usize; 2], origin: [u32; 2], frame: [u32; 2]) -> Opcodes {
        let list = CORRECTION.opcodes(size, PictureWindow { origin, frame }).unwrap();
        Opcodes::parse(&list).unwrap()
    }

    #[test]
    fn gains_are_those_of_the_radius_in_the_frame() {
        let frame = [60, 40];
        for (origin, size) in [([0, 0], [60, 40]), ([10, 4], [40, 30])] {
            let opcodes = parsed(size, origin, frame);
            assert_eq!((opcodes.lens.len(), opcodes.left_out.len()), (2, 0));
            let mut pixels = vec![[0.5; 3]; size[0] * size[1]];
            opcodes.lens[0].apply(size, &mut pixels);
            for (i, pixel) in pixels.iter().enumerate() {
                let x = (i % size[0]) as f64 + f64::from(origin[0]) + 0.5 - 30.0;
                let y = (i / size[0]) as f64 + f64::from(origin[1]) + 0.5 - 20.0;
                let square = (x * x + y * y) / (30.0 * 30.0 + 20.0 * 20.0);
                let gain = (1..).zip(CORRECTION.gain).map(|(p, k)| k * square.powi(p)).sum::<f64>();
                let expected = 0.5 * (1.0 + gain);
                assert!((f64::from(pixel[1]) - expected).abs() < 1e-5, "{i}: {pixel:?}");
            }
        }
        assert_eq!(CORRECTION.opcodes([20, 40], PictureWindow { origin: [0, 0], frame }), None);
    }

    #[test]
    fn warps_move_smooth_pictures_by_their_polynomial() {
        let (frame, size) = ([90, 60], [90, 60]);
        let opcodes = parsed(size, [0, 0], frame);
        // Values are a smooth function of the place, which differs by channel.
        let value =
            |c: usize, [x, y]: [f64; 2]| ((0.07 + 0.01 * c as f64) * x + 0.05 * y).sin() + 0.02 * y;
        let place = |i: usize| [(i % 90) as f64, (i / 90) as f64];
        let pixels: Vec<[f32; 3]> =
            (0..5400).map(|i| [0, 1, 2].map(|c| value(c, place(i)) as f32)).collect();
        let mut corrected = pixels;
        opcodes.lens[1].apply(size, &mut corrected);
        let half = 45.0_f64.hypot(30.0);
        for (i, pixel) in corrected.iter().enumerate() {
            let [x, y] = [place(i)[0] - 44.5, place(i)[1] - 29.5];
            for c in 0..3 {
                let square = (x * x + y * y) / (half * half);
                let factor: f64 =
                    (0..).zip(CORRECTION.warp[c]).map(|(p, k)| k * square.powi(p)).sum();
                let at = [44.5 + factor * x, 29.5 + factor * y];
                let inside = at[0] > 1.0 && at[0] < 88.0 && at[1] > 1.0 && at[1] < 58.0;
                let off = f64::from(pixel[c]) - value(c, at);
                assert!(!inside || off.abs() < 2e-4, "{i}, {c}: off by {off}");
            }
        }
    }

    #[test]
    fn opcodes_apply_in_the_order_of_their_list() {
        let window = PictureWindow { origin: [0, 0], frame: [90, 60] };
        let list = CORRECTION.opcodes([90, 60], window).unwrap();
        // The count, the gain of 16 + 56 bytes, and the warp.
        let (count, opcodes) = list.split_at(4);
        let (gain, warp) = opcodes.split_at(72);
        let turned = [count, warp, gain].concat();
        let [first, second] = [&list, &turned].map(|list| {
            let mut pixels = vec![[0.5; 3]; 90 * 60];
            for opcode in Opcodes::parse(list).unwrap().lens {
                opcode.apply([90, 60], &mut pixels);
            }
            pixels
        });
        // A gain before the warp is that of the radius in the photograph, which is smaller in the corner.
        assert!(first[0][1] < 0.98 * second[0][1], "{:?} and {:?}", first[0], second[0]);
    }

    #[test]
    fn hostile_terms_leave_no_pixel_that_is_not_a_number() {
        let window = PictureWindow { origin: [0, 0], frame: [60, 40] };
        let list = CORRECTION.opcodes([60, 40], window).unwrap();
        for value in [1.7e308, -1.7e308, 1e6, -1e6, f64::INFINITY] {
            for (first, other) in [(20, 28), (92 + 4, 92 + 12), (92 + 4 + 32, 92 + 4 + 40)] {
                let mut hostile = list.clone();
                hostile[first..first + 8].copy_from_slice(&value.to_be_bytes());
                hostile[other..other + 8].copy_from_slice(&(-value).to_be_bytes());
                let opcodes = Opcodes::parse(&hostile).unwrap();
                let bounded = value.abs() <= 1e6;
                assert_eq!(opcodes.left_out.is_empty(), bounded, "{value}, {first}");
                let mut pixels = vec![[0.5; 3]; 60 * 40];
                opcodes.lens.iter().for_each(|opcode| opcode.apply([60, 40], &mut pixels));
                assert!(pixels.iter().flatten().all(|value| value.is_finite()), "{value}, {first}");
            }
        }
        // More corrections than a lens has.
        let warp = &list[4 + 72..];
        let many = [&64_u32.to_be_bytes()[..], &warp.repeat(64)].concat();
        let opcodes = Opcodes::parse(&many).unwrap();
        assert_eq!((opcodes.lens.len(), opcodes.left_out.len()), (8, 56));
    }

    #[test]
    fn malformed_parameters_are_left_out() {
        let list = CORRECTION
            .opcodes([60, 40], PictureWindow { origin: [0, 0], frame: [60, 40] })
            .unwrap();
        // The parameters of the gain begin at byte 20, those of the warp at 92.
        for (byte, value, left_out) in [(20, 0x7f, 3), (92 + 3, 2, 1), (92 + 3, 1, 1)] {
            let mut broken = list.clone();
            broken[byte] = value;
            if byte == 20 {
                broken[byte..byte + 8].copy_from_slice(&f64::NAN.to_be_bytes());
            }
            assert_eq!(Opcodes::parse(&broken).unwrap().left_out, [left_out]);
        }
    }
}
