//! Elliptical weighted average: an anisotropic filter of texture look-ups (Heckbert 1989).

use std::sync::LazyLock;

use glam::Vec2;

use super::{MipMap, TextureFilter, Wrap};
use petzval_base::lanes::Real;

/// Entries of the table of weights, as in pbrt-v4.
const WEIGHT_COUNT: usize = 128;

/// Weights by the squared radius, 0 to 1: a Gaussian that falls to 0 at the edge of the ellipse.
static WEIGHTS: LazyLock<[f32; WEIGHT_COUNT]> = LazyLock::new(|| {
    const SHARPNESS: f64 = 2.0;
    std::array::from_fn(|i| {
        let radius2 = i as f64 / (WEIGHT_COUNT - 1) as f64;
        ((-SHARPNESS * radius2).exp() - (-SHARPNESS).exp()) as f32
    })
});

/// Ellipse of texels of one level around a point: a s^2 + b s t + c t^2 < 1.
struct Ellipse {
    centre: Vec2,
    a: f32,
    b: f32,
    c: f32,
    /// Half the size of the box that bounds it.
    reach: Vec2,
}

impl MipMap {
    /// Returns red, green, blue and alpha, averaged over an ellipse around a point: (0, 0) is the
    /// upper left corner of the image and (1, 1) the lower right. The ellipse has the conjugate
    /// radii `steps`, in the same units. If their ratio exceeds `max_anisotropy`, at least 1, the
    /// shorter one is lengthened.
    #[inline(never)]
    pub fn sample_ellipse<R: Real<Scalar = f32>>(
        &self,
        st: [R; 2],
        steps: [[R; 2]; 2],
        wrap: Wrap,
        max_anisotropy: f32,
    ) -> [R; 4] {
        let [point, one, other] = [st, steps[0], steps[1]].map(|[x, y]| {
            let (mut xs, mut ys) = ([0.0; 8], [0.0; 8]);
            x.store(&mut xs);
            y.store(&mut ys);
            [xs, ys]
        });
        let mut texels = [[0.0; 8]; 4];
        for lane in 0..R::LANES {
            let [st, one, other] =
                [&point, &one, &other].map(|[xs, ys]| Vec2::new(xs[lane], ys[lane]));
            let texel = self.ellipse_mean(st, [one, other], wrap, max_anisotropy);
            for channel in 0..4 {
                texels[channel][lane] = texel[channel];
            }
        }
        [R::load(&texels[0]), R::load(&texels[1]), R::load(&texels[2]), R::load(&texels[3])]
    }

    /// Returns the mean over an ellipse in the two levels next to its shorter radius.
    fn ellipse_mean(
        &self,
        st: Vec2,
        [one, other]: [Vec2; 2],
        wrap: Wrap,
        max_anisotropy: f32,
    ) -> [f32; 4] {
        let swap = one.length_squared() < other.length_squared();
        let (long, mut short) = if swap { (other, one) } else { (one, other) };
        let (length, mut width) = (long.length(), short.length());
        if width == 0.0 {
            return self.sample(st.into(), 0.0, wrap, TextureFilter::Bilinear);
        }
        if width * max_anisotropy < length {
            let factor = length / (width * max_anisotropy);
            (short, width) = (short * factor, width * factor);
        }
        let coarsest = self.levels.len() - 1;
        let side = self.size().into_iter().max().unwrap_or(1) as f32;
        // NaN counts as 0, the finest level; infinity as the coarsest.
        let detail = (width * side).log2().max(0.0);
        let level = detail as usize;
        if level >= coarsest || !(long.is_finite() && short.is_finite()) {
            return self.texel(coarsest, 0, 0, Wrap::Clamp);
        }
        let finer = self.level_mean(level, st, [long, short], wrap);
        let coarser = if level + 1 == coarsest {
            self.texel(coarsest, 0, 0, Wrap::Clamp)
        } else {
            self.level_mean(level + 1, st, [long, short], wrap)
        };
        let weight = detail - level as f32;
        std::array::from_fn(|i| (1.0 - weight) * finer[i] + weight * coarser[i])
    }

    /// Returns the weighted mean of the texels of a level in an ellipse.
    fn level_mean(&self, level: usize, st: Vec2, radii: [Vec2; 2], wrap: Wrap) -> [f32; 4] {
        let size = self.levels[level].size;
        let scale = Vec2::new(size[0] as f32, size[1] as f32);
        // Distant repeats keep their precision.
        let st = if wrap == Wrap::Repeat { st - st.floor() } else { st };
        let ellipse = Ellipse::new(st * scale - 0.5, radii.map(|radius| radius * scale));
        let Ellipse { centre, a, b, c, reach } = ellipse;
        let (first, last) = ((centre - reach).ceil(), (centre + reach).floor());
        let (mut sum, mut total) = ([0.0; 4], 0.0);
        for y in first.y as i64..=last.y as i64 {
            let t = y as f32 - centre.y;
            for x in first.x as i64..=last.x as i64 {
                let s = x as f32 - centre.x;
                let radius2 = a * s * s + b * s * t + c * t * t;
                if radius2 < 1.0 {
                    let entry = (radius2 * WEIGHT_COUNT as f32) as usize;
                    let weight = WEIGHTS[entry.min(WEIGHT_COUNT - 1)];
                    let texel = self.texel(level, x, y, wrap);
                    for channel in 0..4 {
                        sum[channel] += weight * texel[channel];
                    }
                    total += weight;
                }
            }
        }
        sum.map(|channel| channel / total)
    }
}

impl Ellipse {
    /// The ellipse with these conjugate radii, widened by the extent of a texel.
    fn new(centre: Vec2, [one, other]: [Vec2; 2]) -> Self {
        let a = one.y * one.y + other.y * other.y + 1.0;
        let b = -2.0 * (one.x * one.y + other.x * other.y);
        let c = one.x * one.x + other.x * other.x + 1.0;
        // At least 1, but for rounding.
        let determinant = (a * c - 0.25 * b * b).max(1.0);
        let reach = Vec2::new(c.sqrt(), a.sqrt());
        Self { centre, a: a / determinant, b: b / determinant, c: c / determinant, reach }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::lanes::f32x8;
    use petzval_image::{ImageSamples, Raster};

    fn image(size: [usize; 2], value: impl Fn(usize, usize) -> f32) -> MipMap {
        let value = |i: usize| value(i % size[0], i / size[0]);
        let samples = ImageSamples::Floats((0..size[0] * size[1]).map(value).collect());
        MipMap::new(Raster { size, channels: 1, samples })
    }

    fn noise(x: usize, y: usize) -> f32 {
        ((x * 7919 + y * 104_729) * 2_654_435_761 % 1009) as f32 / 1009.0
    }

    #[test]
    fn an_ellipse_averages_along_its_longer_axis_only() {
        // Stripes of one texel along t. Averaged along them, they stay; across them, they vanish.
        let stripes = image([64, 64], |x, _| (x % 2) as f32);
        let st = [32.5 / 64.0, 0.5];
        let (thin, wide) = (0.25 / 64.0, 6.0 / 64.0);
        let along = [[thin, 0.0], [0.0, wide]];
        let across = [[wide, 0.0], [0.0, thin]];
        let at = |steps, anisotropy| {
            stripes.sample_ellipse::<f32>(st, steps, Wrap::Repeat, anisotropy)[0]
        };
        assert!(at(along, 32.0) < 0.3, "{}", at(along, 32.0));
        assert!((at(across, 32.0) - 0.5).abs() < 0.01, "{}", at(across, 32.0));
        // The order of the radii does not matter.
        assert_eq!(at(along, 32.0), at([along[1], along[0]], 32.0));
        // An anisotropy of 1 makes it a circle.
        assert!((at(along, 1.0) - 0.5).abs() < 0.01, "{}", at(along, 1.0));
    }

    #[test]
    fn a_slanted_ellipse_follows_the_diagonal() {
        let diagonal = image([64, 64], |x, y| if (x + y) % 4 < 2 { 1.0 } else { 0.0 });
        let st = [32.5 / 64.0, 32.5 / 64.0];
        let at = |steps| diagonal.sample_ellipse::<f32>(st, steps, Wrap::Repeat, 64.0)[0];
        let (long, short) = (8.0 / 64.0, 0.2 / 64.0);
        let along = at([[long, -long], [short, short]]);
        let across = at([[long, long], [short, -short]]);
        assert!(along > 0.7 && (across - 0.5).abs() < 0.02, "{along} {across}");
    }

    #[test]
    fn the_mean_of_a_texel_equals_that_of_the_definition() {
        let picture = image([32, 32], noise);
        // Radii of two and one texels: level 0 alone.
        let st = [0.4, 0.7];
        let found = picture.sample_ellipse::<f32>(
            st,
            [[2.0 / 32.0, 0.0], [0.0, 1.0 / 32.0]],
            Wrap::Repeat,
            8.0,
        )[0];
        let (mut sum, mut total) = (0.0, 0.0);
        for y in 0..32 {
            for x in 0..32 {
                let [s, t] = [x as f64 + 0.5 - 12.8, y as f64 + 0.5 - 22.4];
                let radius2 = s * s / 5.0 + t * t / 2.0;
                if radius2 < 1.0 {
                    let weight = (-2.0 * radius2).exp() - (-2f64).exp();
                    sum += weight * f64::from(picture.texel(0, x, y, Wrap::Clamp)[0]);
                    total += weight;
                }
            }
        }
        // The table of weights has steps of 1.6 %.
        assert!((f64::from(found) - sum / total).abs() < 0.01, "{found}, not {}", sum / total);
    }

    #[test]
    fn a_point_is_bilinear_and_a_wide_ellipse_is_the_mean() {
        let picture = image([32, 16], noise);
        let at = |steps| picture.sample_ellipse([0.3, 0.6], steps, Wrap::Repeat, 8.0)[0];
        let bilinear = picture.sample([0.3, 0.6], 0.0, Wrap::Repeat, TextureFilter::Bilinear)[0];
        assert_eq!(at([[0.0; 2]; 2]), bilinear);
        assert_eq!(at([[0.0; 2], [1.0, 0.0]]), bilinear);
        let mean = picture.texel(5, 0, 0, Wrap::Clamp)[0];
        for wide in [9.0, 1e30, f32::INFINITY] {
            assert_eq!(at([[wide, 0.0], [0.0, wide]]), mean);
        }
    }

    #[test]
    fn eight_ellipses_equal_single_ones() {
        for size in [[16, 9], [7, 32], [1, 1], [64, 64]] {
            let picture = image(size, noise);
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Black, Wrap::OctahedralSphere] {
                let s = [0.1, -0.3, 0.999, 1.7, 0.5, 12.25, 0.03, -1e9];
                let t = [0.9, 0.2, -2.4, 1.0, 0.5, 0.01, f32::INFINITY, 0.7];
                let a = [0.0, 0.01, 0.05, 0.1, 0.3, 1.0, 40.0, f32::NAN];
                let b = [0.3, 0.0, -0.02, 0.1, -7.0, 1e-30, 0.2, f32::MAX];
                let st = [s, t].map(f32x8::new);
                let steps = [[a, b].map(f32x8::new), [b, t].map(f32x8::new)];
                let found = picture.sample_ellipse(st, steps, wrap, 8.0);
                for lane in 0..8 {
                    let steps = [[a[lane], b[lane]], [b[lane], t[lane]]];
                    let one = picture.sample_ellipse([s[lane], t[lane]], steps, wrap, 8.0);
                    let bits = |v: f32| if v.is_nan() { u32::MAX } else { v.to_bits() };
                    let lane_of = found.map(|channel| bits(channel.to_array()[lane]));
                    assert_eq!(lane_of, one.map(bits), "{size:?} {wrap:?} {lane}");
                }
            }
        }
    }
}
