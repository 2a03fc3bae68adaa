//! Correction of a round lens by the polynomials of raw files (opcodes `WarpRectilinear` and `FixVignetteRadial` of DNG).

use super::Calibration;
use super::channel::ChannelFields;
use petzval_base::least_squares::least_squares;

/// Polynomials that correct distortion, lateral colour and falloff, with radii over half the diagonal of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawCorrection {
    /// For red, green and blue, the factors k of the radius in the photograph, r (k0 + k1 r^2 + k2 r^4 + k3 r^6), of the
    /// radius r in the picture of a pinhole.
    pub warp: [[f64; 4]; 3],
    /// Factors k of the gain 1 + k0 r^2 + ... + k4 r^10 that undoes the falloff.
    pub gain: [f64; 5],
    /// Largest error of the warp (pixels), and of the gain relative to it.
    pub error: [f64; 2],
}

impl Calibration {
    /// Fits the polynomials; `None` if the lens is not round about the middle of the picture, or if its field is too wide
    /// for a rectilinear picture. Without `channels`, red and blue are as green.
    pub fn raw_correction(&self, channels: Option<&ChannelFields>) -> Option<RawCorrection> {
        if !self.is_concentric() || self.is_fisheye() {
            return None;
        }
        let corner = self.pixels.half_diagonal();
        let (matrix, axis) = (self.pinhole_matrix()?, self.pixels.centre());
        let colours = channels.and_then(|channels| self.lateral_colour(channels));
        let half = self.half_shorter_side();
        // Radii without distortion, and in the photograph by channel.
        let mut samples: Vec<(f64, [f64; 3])> = Vec::new();
        for r in self.radii() {
            let Some([x, _]) = self.undistorted(&matrix, self.across(r)) else { continue };
            let straight = (x - axis[0]).abs() * self.pixels.pitch;
            let shifted = |channel: usize| {
                colours.map_or(r, |colours| {
                    let [v, c, b] = colours[channel].terms;
                    let green = r / half;
                    half * green * (v + green * (c + green * b))
                })
            };
            samples.push((straight / corner, [shifted(0), r, shifted(1)].map(|r| r / corner)));
        }
        // Errors of the polynomials of lateral colour add to those of the fit.
        let of_colours = colours.map_or([0.0; 3], |[red, blue]| [red.error, 0.0, blue.error]);
        let mut error = [0.0_f64; 2];
        let mut warp = [[0.0; 4]; 3];
        for (channel, terms) in warp.iter_mut().enumerate() {
            let columns =
                [1, 3, 5, 7].map(|p| samples.iter().map(|(r, _)| r.powi(p)).collect()).to_vec();
            let side = samples.iter().map(|(_, seen)| seen[channel]).collect();
            let fit = least_squares(columns, vec![side]).pop()?;
            *terms = [fit[0], fit[1], fit[2], fit[3]];
            for (r, seen) in &samples {
                let square = r * r;
                let found = r * terms.iter().rev().fold(0.0, |sum, k| sum * square + k);
                let off = (found - seen[channel]).abs() * corner / self.pixels.pitch;
                error[0] = error[0].max(off + of_colours[channel]);
            }
        }
        let light: Vec<[f64; 2]> = self
            .radii()
            .map(|r| [r / corner, self.relative_illumination(self.across(r))])
            .filter(|[_, light]| *light > 0.0)
            .collect();
        // Weights make errors of the gain relative.
        let columns = (1..6).map(|p| light.iter().map(|[r, e]| e * r.powi(2 * p)).collect());
        let side = light.iter().map(|[_, e]| 1.0 - e).collect();
        let fit = least_squares(columns.collect(), vec![side]).pop()?;
        let gain = [fit[0], fit[1], fit[2], fit[3], fit[4]];
        for [r, e] in &light {
            let square = r * r;
            let found = 1.0 + gain.iter().rev().fold(0.0, |sum, k| (sum + k) * square);
            error[1] = error[1].max((found * e - 1.0).abs());
        }
        let finite = warp.as_flattened().iter().chain(&gain).all(|k| k.is_finite());
        finite.then_some(RawCorrection { warp, gain, error })
    }
}
