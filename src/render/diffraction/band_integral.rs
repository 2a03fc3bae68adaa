//! Integrals of a point spread over bands of wavelengths.

use super::point_spread::{HALVINGS, RATIO};
use super::pupil_transform::PupilTransform;
use petzval_spectrum::LightBand;

/// Interpolation node of a table radius and a wavelength: the frequency before it, and the weights
/// of the integrals and values there.
struct FrequencyNode {
    before: usize,
    weights: [f64; 4],
}

/// Integrals over bands of wavelengths. At a radius r, the integral from wavelength a to b is the
/// integral over frequencies k = r / wavelength from r / b to r / a, over r (b - a).
pub(super) struct BandIntegrals {
    /// By radius, then by band limit.
    nodes: Vec<FrequencyNode>,
    /// Weight of the integral from 0 to each band limit, by channel.
    factors: Vec<[f64; 3]>,
    /// Factor of each radius.
    scales: Vec<f64>,
    step: f64,
}

impl BandIntegrals {
    pub fn new(
        bands: &[LightBand],
        wavelengths: &[f64],
        transform: &PupilTransform,
        [first, radii]: [f64; 2],
    ) -> Self {
        let step = transform.step() / f64::from(1 << HALVINGS);
        let count = bands.len() as f64;
        let response = |band: Option<&LightBand>| band.map_or([0.0; 3], |band| band.response);
        let factor = |i: usize| {
            let (above, below) = (response(bands.get(i)), response(bands.get(i.wrapping_sub(1))));
            [0, 1, 2].map(|c| (above[c] - below[c]) / count)
        };
        let width = wavelengths[1] - wavelengths[0];
        let (mut nodes, mut scales) = (Vec::new(), Vec::new());
        for radius in (0..radii as i32).map(|ring| first * RATIO.powi(ring)) {
            scales.push(1.0 / (radius * width * transform.pupil.area));
            for wavelength in wavelengths {
                let place = radius / wavelength / step;
                let (before, t) = (place as usize, place.fract());
                // Cubic Hermite interpolation of values and slopes.
                let (t2, t3) = (t * t, t * t * t);
                let far = 3.0 * t2 - 2.0 * t3;
                let slopes = [t - 2.0 * t2 + t3, t3 - t2].map(|slope| slope * step);
                nodes.push(FrequencyNode {
                    before,
                    weights: [1.0 - far, far, slopes[0], slopes[1]],
                });
            }
        }
        Self { nodes, factors: (0..wavelengths.len()).map(factor).collect(), scales, step }
    }

    /// Writes the densities along a direction, from the squared transform there.
    pub fn fill(&self, power: &[f64], row: &mut [[f32; 3]]) {
        // Trapezoidal rule with its first correction (Euler and Maclaurin).
        let mut sum = 0.0;
        let mut integral = Vec::with_capacity(power.len());
        for i in 0..power.len() - 1 {
            let slope = if i > 0 { power[i + 1] - power[i - 1] } else { 0.0 };
            integral.push([self.step * (sum - slope / 24.0), power[i]]);
            sum += (power[i] + power[i + 1]) / 2.0;
        }
        let nodes = self.nodes.chunks_exact(self.factors.len());
        for ((density, nodes), scale) in row.iter_mut().zip(nodes).zip(&self.scales) {
            let mut sum = [0.0; 3];
            for (FrequencyNode { before, weights }, factor) in nodes.iter().zip(&self.factors) {
                let [[near, near_slope], [far, far_slope]] =
                    [integral[*before], integral[before + 1]];
                let [a, b, c, d] = weights;
                let value = a * near + b * far + c * near_slope + d * far_slope;
                sum = [0, 1, 2].map(|c| sum[c] + factor[c] * value);
            }
            // The integral of a square is negative only by rounding.
            *density = sum.map(|sum| (sum * scale).max(0.0) as f32);
        }
    }
}
