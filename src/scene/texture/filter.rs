//! Filtered texture look-ups, lane by lane.

use super::{MipMap, TextureFilter, Wrap};
use petzval_base::lanes::Real;

/// Corners of the square of texels around a point.
const CORNERS: usize = 4;

/// Level of every lane.
type Levels = [usize; 8];

impl MipMap {
    /// Returns red, green, blue and alpha at a point: (0, 0) is the upper left corner of the image
    /// and (1, 1) the lower right. `radius` is that of the footprint, in the same units; 0 is a
    /// point.
    #[inline(always)]
    pub fn sample<R: Real<Scalar = f32>>(
        &self,
        st: [R; 2],
        radius: R,
        wrap: Wrap,
        filter: TextureFilter,
    ) -> [R; 4] {
        let coarsest = self.levels.len() - 1;
        let side = self.size().into_iter().max().unwrap_or(1) as f32;
        // Texels of the finest level that the footprint covers.
        let mut texels = [1.0; 8];
        (radius * R::splat(2.0 * side)).max(R::splat(1.0)).store(&mut texels);
        let (mut finer, mut weights) = ([0; 8], [0.0; 8]);
        for lane in 0..R::LANES {
            // The logarithm to base 2 of a number of at least 1, rounded down; NaN was replaced.
            finer[lane] = ((texels[lane].to_bits() >> 23) as usize).saturating_sub(127);
            if filter == TextureFilter::Trilinear && finer[lane] < coarsest {
                weights[lane] = (texels[lane].log2() - finer[lane] as f32).clamp(0.0, 1.0);
            }
            finer[lane] = finer[lane].min(coarsest);
        }
        match filter {
            TextureFilter::Point => self.nearest(&finer, st, wrap),
            TextureFilter::Bilinear => self.bilinear(&finer, st, wrap),
            TextureFilter::Trilinear => {
                let fine = self.bilinear(&finer, st, wrap);
                let weight = R::load(&weights);
                if R::bits(weight.equals(R::splat(0.0))) == (1 << R::LANES) - 1 {
                    return fine;
                }
                for level in &mut finer {
                    *level = (*level + 1).min(coarsest);
                }
                let coarse = self.bilinear(&finer, st, wrap);
                let mut blend = fine;
                for channel in 0..4 {
                    blend[channel] = fine[channel] + weight * (coarse[channel] - fine[channel]);
                }
                blend
            }
        }
    }

    /// Returns the nearest texels.
    fn nearest<R: Real<Scalar = f32>>(&self, levels: &Levels, st: [R; 2], wrap: Wrap) -> [R; 4] {
        let half = R::splat(0.5);
        let [x, y] = self.texel_coordinates(levels, st, wrap);
        let (x, y) = ((x + half).floor(), (y + half).floor());
        let mut texels = [[0.0; 8]; 4];
        let (mut xs, mut ys) = ([0.0; 8], [0.0; 8]);
        x.store(&mut xs);
        y.store(&mut ys);
        for lane in 0..R::LANES {
            let wrap = self.wrap_at(levels[lane], wrap);
            let texel = self.texel(levels[lane], xs[lane] as i64, ys[lane] as i64, wrap);
            for channel in 0..4 {
                texels[channel][lane] = texel[channel];
            }
        }
        [R::load(&texels[0]), R::load(&texels[1]), R::load(&texels[2]), R::load(&texels[3])]
    }

    /// Interpolates between the four texels around every point.
    #[inline(never)]
    fn bilinear<R: Real<Scalar = f32>>(&self, levels: &Levels, st: [R; 2], wrap: Wrap) -> [R; 4] {
        let [x, y] = self.texel_coordinates(levels, st, wrap);
        let (left, top) = (x.floor(), y.floor());
        let mut texels = [[[0.0; 8]; 4]; CORNERS];
        let (mut xs, mut ys) = ([0.0; 8], [0.0; 8]);
        left.store(&mut xs);
        top.store(&mut ys);
        let at = |lane: usize| [xs[lane] as i64, ys[lane] as i64];
        // All lanes read before one decodes, so that they wait for memory together.
        let mut rows = [None; 8];
        for lane in 0..R::LANES {
            rows[lane] = self.byte_rows(levels[lane], at(lane));
        }
        for lane in 0..R::LANES {
            let corners = match rows[lane] {
                Some(rows) => self.decode_rows(rows),
                None => self.corners(levels[lane], at(lane), wrap),
            };
            for corner in 0..CORNERS {
                for channel in 0..4 {
                    texels[corner][channel][lane] = corners[corner][channel];
                }
            }
        }
        let one = R::splat(1.0);
        let (fx, fy) = (x - left, y - top);
        let (gx, gy) = (one - fx, one - fy);
        let weights = [gx * gy, fx * gy, gx * fy, fx * fy];
        let mut sum = [R::splat(0.0); 4];
        for corner in 0..CORNERS {
            for channel in 0..4 {
                let texel = R::load(&texels[corner][channel]);
                sum[channel] = texel.mul_add(weights[corner], sum[channel]);
            }
        }
        sum
    }

    /// Returns the eight bytes from the texel at (x, y) on, and those from (x, y + 1) on, which hold two
    /// texels each; `None` if these texels are not all inside the image, or close to its end, or not
    /// bytes.
    #[inline(always)]
    fn byte_rows(&self, level: usize, at: [i64; 2]) -> Option<[[u8; 8]; 2]> {
        let width = self.levels[level].size[0];
        let (first, bytes) = (self.first_inside(level, at)?, self.bytes_of(level)?);
        let row = |first: usize| bytes.get(first * self.channels()..)?.first_chunk().copied();
        Some([row(first)?, row(first + width)?])
    }

    /// Returns the texels of [`Self::byte_rows`], in the order of [`Self::corners`].
    #[inline(always)]
    fn decode_rows(&self, [upper, lower]: [[u8; 8]; 2]) -> [[f32; 4]; CORNERS] {
        let pair = |row: [u8; 8]| {
            let [a, b, c, d, e, f, g, h] = row;
            match self.channels() {
                1 => [self.decode(&[a]), self.decode(&[b])],
                3 => [self.decode(&[a, b, c]), self.decode(&[d, e, f])],
                _ => [self.decode(&[a, b, c, d]), self.decode(&[e, f, g, h])],
            }
        };
        let ([a, b], [c, d]) = (pair(upper), pair(lower));
        [a, b, c, d]
    }

    /// Returns the index of a texel if it, its right and its lower neighbour are inside the image.
    #[inline(always)]
    fn first_inside(&self, level: usize, [x, y]: [i64; 2]) -> Option<usize> {
        let [width, height] = self.levels[level].size;
        let inside = x >= 0 && y >= 0 && x < width as i64 - 1 && y < height as i64 - 1;
        inside.then(|| y as usize * width + x as usize)
    }

    /// Returns the texels at (x, y), (x + 1, y), (x, y + 1) and (x + 1, y + 1).
    #[inline(always)]
    fn corners(&self, level: usize, [x, y]: [i64; 2], wrap: Wrap) -> [[f32; 4]; CORNERS] {
        if let Some(first) = self.first_inside(level, [x, y]) {
            let width = self.levels[level].size[0];
            return [
                self.texel_at(level, first),
                self.texel_at(level, first + 1),
                self.texel_at(level, first + width),
                self.texel_at(level, first + width + 1),
            ];
        }
        let wrap = self.wrap_at(level, wrap);
        let (right, below) = (x.saturating_add(1), y.saturating_add(1));
        [
            self.texel(level, x, y, wrap),
            self.texel(level, right, y, wrap),
            self.texel(level, x, below, wrap),
            self.texel(level, right, below, wrap),
        ]
    }

    /// Returns the wrap mode of a level. The single texel of the coarsest one covers everything.
    #[inline(always)]
    fn wrap_at(&self, level: usize, wrap: Wrap) -> Wrap {
        if level > 0 && level + 1 == self.levels.len() { Wrap::Clamp } else { wrap }
    }

    /// Converts image coordinates, 0 to 1, to texel coordinates of each lane's level, which are
    /// integers at the centres of texels. Whole repeats are removed first, so that distant repeats
    /// keep their precision.
    #[inline(always)]
    fn texel_coordinates<R: Real<Scalar = f32>>(
        &self,
        levels: &Levels,
        [s, t]: [R; 2],
        wrap: Wrap,
    ) -> [R; 2] {
        let (mut widths, mut heights) = ([1.0; 8], [1.0; 8]);
        for lane in 0..R::LANES {
            let [width, height] = self.levels[levels[lane]].size;
            (widths[lane], heights[lane]) = (width as f32, height as f32);
        }
        let (s, t) = match wrap {
            Wrap::Repeat => (s - s.floor(), t - t.floor()),
            _ => (s, t),
        };
        let half = R::splat(0.5);
        [s * R::load(&widths) - half, t * R::load(&heights) - half]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::mipmap::MipLevel;
    use crate::texture::texel;
    use petzval_base::lanes::f32x8;
    use petzval_image::{ImageSamples, Raster, Transfer};

    #[test]
    fn bytes_are_interpolated_between_the_texels_around_a_point() {
        for (size, channels) in [([16, 9], 3), ([7, 32], 4), ([5, 3], 1), ([3, 2], 3), ([1, 1], 3)]
        {
            let count = size[0] * size[1] * channels;
            let bytes = (0..count).map(|i| ((i * 2_654_435_761) >> 7) as u8).collect();
            let samples = ImageSamples::Bytes(bytes, Transfer::Srgb);
            let mipmap = MipMap::new(Raster { size, channels, samples });
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Black, Wrap::OctahedralSphere] {
                for k in 0..400 {
                    let [s, t] = [k % 23, k / 23].map(|i| i as f32 * 0.0713 - 0.2);
                    let found = mipmap.sample([s, t], 0.0, wrap, TextureFilter::Bilinear);
                    let point = texel::texel_coordinates([s, t].into(), size, wrap);
                    let wrap = mipmap.wrap_at(0, wrap);
                    let expected = texel::bilinear(point, |x, y| mipmap.texel(0, x, y, wrap));
                    for channel in 0..4 {
                        let error = (found[channel] - expected[channel]).abs();
                        assert!(error < 1e-6, "{size:?} {channels} {wrap:?} {s} {t}: {found:?}");
                    }
                }
            }
            for (level, MipLevel { size: [width, height], .. }) in mipmap.levels.iter().enumerate()
            {
                for at in (0..width * height).map(|i| [(i % width) as i64, (i / width) as i64]) {
                    let Some(rows) = mipmap.byte_rows(level, at) else { continue };
                    let [x, y] = at;
                    let texels = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]]
                        .map(|[x, y]| mipmap.texel(level, x, y, Wrap::Clamp));
                    assert_eq!(mipmap.decode_rows(rows), texels, "level {level} {at:?}");
                }
            }
        }
    }

    #[test]
    fn eight_lookups_equal_single_ones() {
        let value = |i: usize| ((i * 2_654_435_761) % 1009) as f32 / 1009.0;
        for (size, channels) in [([16, 9], 3), ([7, 32], 4), ([1, 1], 1), ([64, 64], 1)] {
            let samples =
                ImageSamples::Floats((0..size[0] * size[1] * channels).map(value).collect());
            let mipmap = MipMap::new(Raster { size, channels, samples });
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Black, Wrap::OctahedralSphere] {
                for filter in
                    [TextureFilter::Point, TextureFilter::Bilinear, TextureFilter::Trilinear]
                {
                    let s = [0.1, -0.3, 0.999, 1.7, 0.5, 12.25, 0.03, -1e9];
                    let t = [0.9, 0.2, -2.4, 1.0, 0.5, 0.01, f32::INFINITY, 0.7];
                    let radius = [0.0, 0.01, 0.05, 0.1, 0.3, 1.0, 40.0, f32::NAN];
                    let st = [f32x8::new(s), f32x8::new(t)];
                    let found = mipmap.sample(st, f32x8::new(radius), wrap, filter);
                    for lane in 0..8 {
                        let one = mipmap.sample([s[lane], t[lane]], radius[lane], wrap, filter);
                        let bits = |v: f32| if v.is_nan() { u32::MAX } else { v.to_bits() };
                        let lane_of = found.map(|channel| bits(channel.to_array()[lane]));
                        assert_eq!(lane_of, one.map(bits), "{size:?} {wrap:?} {filter:?} {lane}");
                    }
                }
            }
        }
    }
}
