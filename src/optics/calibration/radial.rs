//! Polynomials of the radius for programs of photographers: distortion, lateral colour and light
//! falloff, in the definitions of lensfun.

use super::Calibration;
use super::channel::ChannelFields;
use petzval_base::least_squares::least_squares;

/// Radii of a fit.
const RADII: usize = 200;
/// Tangent beyond which the reference of distortion is the angle and not its tangent.
const WIDE: f64 = 2.2;
/// Steps of Newton's method.
const STEPS: usize = 60;

/// A polynomial for the distortion of a round lens: r_d(r_u), with both radii over half the shorter
/// side of the film.
#[derive(Clone, Debug, PartialEq)]
pub struct RadialDistortion {
    /// Name of the model: poly3, poly5 or ptlens.
    pub model: &'static str,
    /// Names and values of its terms.
    pub terms: Vec<(&'static str, f64)>,
    /// Focal length near the axis (mm).
    pub real_focal: f64,
    /// Largest error (pixels).
    pub error: f64,
}

/// Lateral colour of a channel: r = r_green (v + c r_green + b r_green^2), radii over half the
/// shorter side of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralColour {
    /// The terms v, c and b.
    pub terms: [f64; 3],
    /// Largest distance from the green image over the picture (pixels).
    pub largest: f64,
    /// Largest error of the polynomial (pixels).
    pub error: f64,
}

/// Light falloff of a round lens: 1 + k1 r^2 + k2 r^4 + k3 r^6 of the light on the axis, with the
/// radius over half the diagonal of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Falloff {
    /// The terms k1, k2 and k3.
    pub terms: [f64; 3],
    /// Largest error, as a share of the light on the axis.
    pub error: f64,
}

/// A radius on the film (mm), and the reference of its distortion per focal length.
type Sample = [f64; 2];

impl Calibration {
    /// Returns whether the field is too wide for a rectilinear reference; that of distortion is then
    /// the equidistant fisheye.
    pub fn is_fisheye(&self) -> bool {
        self.largest_angle.tan() > WIDE || self.largest_angle >= std::f64::consts::FRAC_PI_2
    }

    /// Returns fits of the models poly3, poly5 and ptlens; none if the lens is not round about the
    /// middle of the picture.
    pub fn radial_distortions(&self) -> Vec<RadialDistortion> {
        if !self.is_concentric() {
            return Vec::new();
        }
        let fisheye = self.is_fisheye();
        let samples: Vec<Sample> = self
            .radii()
            .filter_map(|r| {
                let angle = self.field_angle(r)?;
                Some([r, if fisheye { angle } else { angle.tan() }])
            })
            .collect();
        let models = [("poly3", vec![3]), ("poly5", vec![3, 5]), ("ptlens", vec![2, 3, 4])];
        models
            .into_iter()
            .filter_map(|(model, powers)| self.distortion(model, &powers, &samples))
            .collect()
    }

    /// Fits r = A t + sum of B_p t^p and brings it into the form of a model.
    fn distortion(
        &self,
        model: &'static str,
        powers: &[i32],
        samples: &[Sample],
    ) -> Option<RadialDistortion> {
        let all = [1].iter().chain(powers);
        let columns =
            all.clone().map(|&p| samples.iter().map(|[_, t]| t.powi(p)).collect()).collect();
        let side = samples.iter().map(|[r, _]| *r).collect();
        let fit = least_squares(columns, vec![side]).pop()?;
        let value = |t: f64| all.clone().zip(&fit).map(|(&p, k)| k * t.powi(p)).sum::<f64>();
        let off = samples.iter().map(|[r, t]| (value(*t) - r).abs()).fold(0.0, f64::max);
        let (real_focal, half) = (fit[0], self.half_shorter_side());
        // The scale at which both radii are equal at half the shorter side, except for poly5.
        let mut focal = real_focal;
        if model != "poly5" {
            let at = |focal: f64| {
                let terms = powers.iter().zip(&fit[1..]);
                let (mut sum, mut slope) = (fit[0] / focal - 1.0, -fit[0] / (focal * focal));
                for (&p, k) in terms {
                    let term = k * half.powi(p - 1) / focal.powi(p);
                    (sum, slope) = (sum + term, slope - f64::from(p) * term / focal);
                }
                [sum, slope]
            };
            for _ in 0..STEPS {
                let [sum, slope] = at(focal);
                focal -= sum / slope;
            }
        }
        let term = |i: usize| fit[1 + i] * half.powi(powers[i] - 1) / focal.powi(powers[i]);
        let terms = match model {
            "ptlens" => vec![("a", term(2)), ("b", term(1)), ("c", term(0))],
            "poly5" => vec![("k1", term(0)), ("k2", term(1))],
            _ => vec![("k1", term(0))],
        };
        let finite = terms.iter().all(|(_, value)| value.is_finite()) && focal > 0.0;
        finite.then(|| RadialDistortion {
            model,
            terms,
            real_focal,
            error: off / self.pixels.pitch,
        })
    }

    /// Returns the lateral colour of red and of blue relative to green; `None` if the lens is not
    /// round about the middle of the picture.
    pub fn lateral_colour(&self, channels: &ChannelFields) -> Option<[LateralColour; 2]> {
        if !self.is_concentric() {
            return None;
        }
        let ChannelFields(fields) = channels;
        let angle = |channel: usize, r: f64| {
            let ray = fields[channel].ray([-r, 0.0])?;
            let seen = ray.seen_from(self.centre.point, self.focus);
            Some(seen.x.atan2(seen.z))
        };
        // The radius at which a channel shows the angle that green shows at another radius.
        let shown = |channel: usize, green: f64| {
            let wanted = angle(1, green)?;
            let (mut r, step) = (green, 1e-3 * self.half_shorter_side());
            for _ in 0..4 {
                let here = angle(channel, r)?;
                let slope = (here - angle(channel, r - step)?) / step;
                r += (wanted - here) / slope;
            }
            Some(r)
        };
        let half = self.half_shorter_side();
        let fit = |channel: usize| {
            let samples: Vec<[f64; 2]> = self
                .radii()
                .filter(|r| *r > 0.02 * half)
                .filter_map(|r| Some([r / half, shown(channel, r)? / half]))
                .collect();
            let columns =
                (1..4).map(|p| samples.iter().map(|[r, _]| r.powi(p)).collect()).collect();
            let side = samples.iter().map(|[_, r]| *r).collect();
            let fit = least_squares(columns, vec![side]).pop()?;
            let to_pixels = half / self.pixels.pitch;
            let error = |[r, found]: &[f64; 2]| {
                (0..3).map(|i| fit[i] * r.powi(i as i32 + 1)).sum::<f64>() - found
            };
            let most = |of: &dyn Fn(&[f64; 2]) -> f64| {
                to_pixels * samples.iter().map(|s| of(s).abs()).fold(0.0, f64::max)
            };
            Some(LateralColour {
                terms: [fit[0], fit[1], fit[2]],
                largest: most(&|[r, found]| found - r),
                error: most(&error),
            })
        };
        Some([fit(0)?, fit(2)?])
    }

    /// Returns the light falloff; `None` if the lens is not round about the middle of the picture.
    pub fn falloff(&self) -> Option<Falloff> {
        if !self.is_concentric() {
            return None;
        }
        let corner = self.pixels.half_diagonal();
        let samples: Vec<[f64; 2]> = self
            .radii()
            .map(|r| [r / corner, self.relative_illumination(self.across(r))])
            .collect();
        let columns = [2, 4, 6].map(|p| samples.iter().map(|[r, _]| r.powi(p)).collect()).to_vec();
        let side = samples.iter().map(|[_, light]| light - 1.0).collect();
        let fit = least_squares(columns, vec![side]).pop()?;
        let off = |[r, light]: &[f64; 2]| {
            (0..3).map(|i| fit[i] * r.powi(2 * i as i32 + 2)).sum::<f64>() + 1.0 - light
        };
        let error = samples.iter().map(|sample| off(sample).abs()).fold(0.0, f64::max);
        Some(Falloff { terms: [fit[0], fit[1], fit[2]], error })
    }

    pub(super) fn is_concentric(&self) -> bool {
        let axis = self.pixels.centre();
        let centred = |fit: &super::FittedModel| fit.matrix.centre == axis;
        self.round && self.suggested().is_some_and(centred)
    }

    /// Returns radii from the axis to the corner of the film (mm).
    pub(super) fn radii(&self) -> impl Iterator<Item = f64> + use<> {
        let corner = self.pixels.half_diagonal();
        (0..=RADII).map(move |i| corner * i as f64 / RADII as f64)
    }

    /// Returns the point of the picture to the right of the middle by a radius (mm).
    pub(super) fn across(&self, r: f64) -> [f64; 2] {
        self.pixels.pixel([-r, 0.0])
    }

    fn field_angle(&self, r: f64) -> Option<f64> {
        let seen = self.seen(self.across(r))?;
        Some(seen.x.atan2(seen.z))
    }

    /// Returns half the shorter side of the film (mm).
    pub(super) fn half_shorter_side(&self) -> f64 {
        let [width, height] = self.pixels.film_size();
        width.min(height) / 2.0
    }
}
