//! Correction of a lens, as opcodes of raw files (Adobe, Digital Negative Specification 1.7.1.0, 2023, chapter 7).

use crate::PictureWindow;

/// Falloff and distortion of a round lens about the middle of a frame, with radii over half of the frame's diagonal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LensCorrection {
    /// By channel, the factors k of the radius in the photograph, r (k0 + k1 r^2 + k2 r^4 + k3 r^6), of the radius r in the
    /// picture of a pinhole.
    pub warp: [[f64; 4]; 3],
    /// Factors k of the gain 1 + k0 r^2 + k1 r^4 + k2 r^6 + k3 r^8 + k4 r^10 that undoes the falloff.
    pub gain: [f64; 5],
}

/// Identifiers of the opcodes.
pub(crate) const WARP_RECTILINEAR: u32 = 1;
pub(crate) const FIX_VIGNETTE_RADIAL: u32 = 3;
/// Version of the specification that has them, 1.3.
const VERSION: u32 = 0x0103_0000;
/// Readers that do not know an opcode may leave it out.
const OPTIONAL: u32 = 1;

impl LensCorrection {
    /// Returns whether a picture of this size holds the middle of its frame, about which opcodes correct.
    pub fn is_for(size: [u32; 2], window: PictureWindow) -> bool {
        middle(size.map(f64::from), window).is_some()
    }

    /// Returns the list of opcodes of a picture of this size, a part of its frame: first the gain, then the warp. Returns
    /// `None` if the middle of the frame is outside the picture: opcodes need a centre within it.
    pub(crate) fn opcodes(&self, size: [usize; 2], window: PictureWindow) -> Option<Vec<u8>> {
        let size = size.map(|n| n as f64);
        let middle = middle(size, window)?;
        // Opcodes have radii over the distance from the middle to the farthest corner.
        let reach = [0, 1].map(|i| size[i] * middle[i].max(1.0 - middle[i]));
        let half = f64::from(window.frame[0]).hypot(f64::from(window.frame[1])) / 2.0;
        let square = (reach[0].hypot(reach[1]) / half).powi(2);
        let scaled = |k: f64, power: i32| k * square.powi(power);
        let mut vignette: Vec<f64> = (1..).zip(self.gain).map(|(i, k)| scaled(k, i)).collect();
        vignette.extend(middle);
        let mut warp = 3_u32.to_be_bytes().to_vec();
        for plane in self.warp {
            let radial = (0..).zip(plane).map(|(i, k)| scaled(k, i));
            // The last two are of a lens that is decentred.
            warp.extend(radial.chain([0.0; 2]).flat_map(f64::to_be_bytes));
        }
        warp.extend(middle.into_iter().flat_map(f64::to_be_bytes));
        let vignette: Vec<u8> = vignette.into_iter().flat_map(f64::to_be_bytes).collect();
        let mut list = 2_u32.to_be_bytes().to_vec();
        for (id, parameters) in [(FIX_VIGNETTE_RADIAL, vignette), (WARP_RECTILINEAR, warp)] {
            let head = [id, VERSION, OPTIONAL, parameters.len() as u32];
            list.extend(head.into_iter().flat_map(u32::to_be_bytes));
            list.extend(parameters);
        }
        Some(list)
    }
}

/// Returns the middle of the frame relative to a picture of this size; `None` if it is outside.
fn middle(size: [f64; 2], PictureWindow { origin, frame }: PictureWindow) -> Option<[f64; 2]> {
    let middle = [0, 1].map(|i| (f64::from(frame[i]) / 2.0 - f64::from(origin[i])) / size[i]);
    middle.iter().all(|at| (0.0..=1.0).contains(at)).then_some(middle)
}
