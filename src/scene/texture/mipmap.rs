//! Mipmap: an image at every scale, each half the size of the one before (Williams 1983).

use super::Wrap;
use petzval_image::{ImageSamples, Picture, Raster, Transfer};

/// Filter of a texture lookup.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureFilter {
    /// The nearest texel.
    Point,
    /// The four texels around the point, in the coarsest level that is not coarser than the
    /// footprint.
    #[default]
    Bilinear,
    /// The four texels around the point in each of the two levels next to the size of the
    /// footprint.
    Trilinear,
}

/// An image at every scale. Texels count from the upper left corner.
#[derive(Clone, Debug)]
pub struct MipMap {
    /// Linear value of each 8-bit code, for colours and alpha alike.
    light: Box<[f32; 256]>,
    channels: usize,
    pub(super) levels: Vec<MipLevel>,
}

#[derive(Clone, Debug)]
pub(super) struct MipLevel {
    pub(super) size: [usize; 2],
    texels: Texels,
}

#[derive(Clone, Debug)]
enum Texels {
    Bytes(Vec<u8>),
    Floats(Vec<f32>),
}

impl MipMap {
    /// Builds the mipmap of an image of at least one pixel. It averages linear values; the levels
    /// of an 8-bit image have 8 bits.
    pub fn new(raster: Raster) -> Self {
        let Raster { size, channels, samples } = raster;
        let (texels, transfer) = match samples {
            ImageSamples::Bytes(bytes, transfer) => (Texels::Bytes(bytes), Some(transfer)),
            ImageSamples::Floats(floats) => (Texels::Floats(floats), None),
        };
        let curve = transfer.unwrap_or_default();
        let light = Box::new(std::array::from_fn(|code| curve.decode(code as f32 / 255.0)));
        let mut mipmap = Self { light, channels, levels: vec![MipLevel { size, texels }] };
        let mut coarse: Option<(Vec<f32>, [usize; 2])> = None;
        loop {
            let fine = match &coarse {
                Some((_, size)) => *size,
                None => size,
            };
            if fine == [1, 1] {
                return mipmap;
            }
            let next = match &coarse {
                Some((floats, size)) => halve(*size, channels, |i| floats[i]),
                None => halve(size, channels, |i| mipmap.value(0, i)),
            };
            let size = fine.map(half);
            let texels = match transfer {
                Some(transfer) => Texels::Bytes(encode(&next, transfer)),
                None => Texels::Floats(next.clone()),
            };
            mipmap.levels.push(MipLevel { size, texels });
            coarse = Some((next, size));
        }
    }

    /// Returns the memory that the mipmap of an image takes besides the image, and that which its making
    /// takes for a time (bytes).
    pub fn more_bytes(size: [usize; 2], channels: usize, floats: bool) -> [u64; 2] {
        // A level has half of each side, and at least a pixel: in all, at most as much again as a line.
        let [width, height] = size.map(|n| n as u64);
        let pixels = width.saturating_mul(height);
        let coarse = pixels / 3 + width.max(height) + 1;
        let sample = if floats { size_of::<f32>() as u64 } else { 1 };
        let floats = 2 * (pixels / 3 + width.max(height)) * size_of::<f32>() as u64;
        [coarse * sample, floats].map(|bytes| bytes.saturating_mul(channels as u64))
    }

    /// Returns width and height (pixels).
    pub fn size(&self) -> [usize; 2] {
        self.levels[0].size
    }

    /// Returns the number of channels: 1 (luminance), 3 (RGB) or 4 (RGB and alpha).
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Returns the memory of all texels (bytes).
    pub fn bytes(&self) -> usize {
        let bytes = |level: &MipLevel| match &level.texels {
            Texels::Bytes(bytes) => bytes.len(),
            Texels::Floats(floats) => 4 * floats.len(),
        };
        self.levels.iter().map(bytes).sum()
    }

    fn value(&self, level: usize, i: usize) -> f32 {
        match &self.levels[level].texels {
            Texels::Bytes(bytes) => self.light[usize::from(bytes[i])],
            Texels::Floats(floats) => floats[i],
        }
    }

    /// Returns a texel of a level: red, green, blue and alpha.
    #[inline(always)]
    pub fn texel(&self, level: usize, x: i64, y: i64, wrap: Wrap) -> [f32; 4] {
        let [width, height] = self.levels[level].size;
        match wrap.resolve([x, y], [width as i64, height as i64]) {
            Some([x, y]) => self.texel_at(level, y as usize * width + x as usize),
            None => [0.0; 4],
        }
    }

    /// Returns the texels of a level, row by row, if they are bytes.
    #[inline(always)]
    pub(super) fn bytes_of(&self, level: usize) -> Option<&[u8]> {
        match &self.levels[level].texels {
            Texels::Bytes(bytes) => Some(bytes),
            Texels::Floats(_) => None,
        }
    }

    /// Returns the red, green, blue and alpha of a texel of bytes.
    #[inline(always)]
    pub(super) fn decode(&self, bytes: &[u8]) -> [f32; 4] {
        let light = |byte: &u8| self.light[usize::from(*byte)];
        match bytes {
            [r, g, b] => [light(r), light(g), light(b), 1.0],
            [r, g, b, alpha] => [light(r), light(g), light(b), light(alpha)],
            [grey, ..] => [light(grey), light(grey), light(grey), 1.0],
            [] => [0.0; 4],
        }
    }

    /// Returns a texel of a level by its index, row by row.
    #[inline(always)]
    pub(super) fn texel_at(&self, level: usize, index: usize) -> [f32; 4] {
        let first = index * self.channels;
        match &self.levels[level].texels {
            Texels::Bytes(bytes) => self.decode(&bytes[first..first + self.channels]),
            Texels::Floats(floats) => match floats[first..first + self.channels] {
                [r, g, b] => [r, g, b, 1.0],
                [r, g, b, alpha] => [r, g, b, alpha],
                [grey, ..] => [grey, grey, grey, 1.0],
                [] => [0.0; 4],
            },
        }
    }
}

impl From<&Picture> for MipMap {
    fn from(picture: &Picture) -> Self {
        let floats = picture.pixels.as_flattened().to_vec();
        Self::new(Raster { size: picture.size, channels: 3, samples: ImageSamples::Floats(floats) })
    }
}

fn half(n: usize) -> usize {
    (n / 2).max(1)
}

/// Returns the weights of the entries from 2 i on, in a row of `n`, that make entry `i` of the row
/// of half the length, and their number: two, or three if `n` is odd. The total weights of all
/// entries of the row are equal.
fn taps(n: usize, i: usize) -> ([f32; 3], usize) {
    let m = half(n);
    match (n, n % 2) {
        (1, _) => ([1.0, 0.0, 0.0], 1),
        (_, 0) => ([0.5, 0.5, 0.0], 2),
        _ => {
            let n = n as f32;
            ([(m - i) as f32 / n, m as f32 / n, (i + 1) as f32 / n], 3)
        }
    }
}

/// Returns the image of half the size. `value` returns a channel of the full image by its index.
fn halve(size: [usize; 2], channels: usize, value: impl Fn(usize) -> f32) -> Vec<f32> {
    let [width, height] = size;
    let mut coarse = Vec::with_capacity(half(width) * half(height) * channels);
    for y in 0..half(height) {
        let (rows, row_count) = taps(height, y);
        for x in 0..half(width) {
            let (columns, column_count) = taps(width, x);
            for channel in 0..channels {
                let mut sum = 0.0;
                for (j, row) in rows[..row_count].iter().enumerate() {
                    for (i, column) in columns[..column_count].iter().enumerate() {
                        let texel = (2 * y + j) * width + 2 * x + i;
                        sum += row * column * value(texel * channels + channel);
                    }
                }
                coarse.push(sum);
            }
        }
    }
    coarse
}

fn encode(light: &[f32], transfer: Transfer) -> Vec<u8> {
    light.iter().map(|&v| (255.0 * transfer.encode(v)).round() as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_image::srgb_decode;

    fn floats(size: [usize; 2], channels: usize) -> MipMap {
        let count = size[0] * size[1] * channels;
        let value = |i: usize| ((i * 2_654_435_761) % 1009) as f32 / 1009.0;
        let samples = ImageSamples::Floats((0..count).map(value).collect());
        MipMap::new(Raster { size, channels, samples })
    }

    fn mean(mipmap: &MipMap, level: usize) -> f64 {
        let [width, height] = mipmap.levels[level].size;
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x as i64, y as i64)));
        let sum: f64 =
            texels.map(|(x, y)| f64::from(mipmap.texel(level, x, y, Wrap::Clamp)[0])).sum();
        sum / (width * height) as f64
    }

    #[test]
    fn every_level_has_the_mean_of_the_image() {
        for size in [[8, 8], [7, 5], [1, 13], [33, 2], [1, 1]] {
            let mipmap = floats(size, 3);
            let whole = mean(&mipmap, 0);
            for level in 1..mipmap.levels.len() {
                let found = mean(&mipmap, level);
                assert!((found - whole).abs() < 1e-5, "{size:?}, level {level}: {found}, {whole}");
            }
            assert_eq!(mipmap.levels[mipmap.levels.len() - 1].size, [1, 1]);
        }
    }

    #[test]
    fn a_wide_footprint_returns_the_mean_and_a_point_the_texels() {
        let mipmap = floats([16, 8], 1);
        let whole = mean(&mipmap, 0) as f32;
        for filter in [TextureFilter::Point, TextureFilter::Bilinear, TextureFilter::Trilinear] {
            let wide = mipmap.sample([0.3, 0.7], 5.0, Wrap::Repeat, filter);
            assert!((wide[0] - whole).abs() < 1e-5);
        }
        let texel = |x, y| mipmap.texel(0, x, y, Wrap::Repeat)[0];
        let at = |x: f32, y: f32, filter| {
            mipmap.sample([x / 16.0, y / 8.0], 0.0, Wrap::Repeat, filter)[0]
        };
        for filter in [TextureFilter::Point, TextureFilter::Bilinear, TextureFilter::Trilinear] {
            assert!((at(3.5, 2.5, filter) - texel(3, 2)).abs() < 1e-6);
        }
        let blend =
            0.75 * 0.5 * (texel(3, 2) + texel(3, 3)) + 0.25 * 0.5 * (texel(4, 2) + texel(4, 3));
        assert!((at(3.75, 3.0, TextureFilter::Bilinear) - blend).abs() < 1e-6);
        assert!((at(3.75, 3.2, TextureFilter::Point) - texel(3, 3)).abs() < 1e-6);
    }

    #[test]
    fn the_level_follows_the_size_of_the_footprint() {
        let mipmap = floats([16, 16], 1);
        // A footprint of 4 texels: level 2, whose texels are 4 wide.
        let at = |reach: f32, filter| mipmap.sample([0.375, 0.625], reach, Wrap::Repeat, filter)[0];
        let texel = |level, x, y| mipmap.texel(level, x, y, Wrap::Repeat)[0];
        assert!((at(2.0 / 16.0, TextureFilter::Bilinear) - texel(2, 1, 2)).abs() < 1e-6);
        // The bilinear filter keeps a level up to the next; the trilinear filter blends them.
        let between = 2.0f32.powf(0.5) / 16.0;
        let fine = at(1.0 / 16.0, TextureFilter::Bilinear);
        assert_eq!(at(between, TextureFilter::Bilinear), fine);
        let blend = 0.5 * (fine + texel(2, 1, 2));
        assert!((at(between, TextureFilter::Trilinear) - blend).abs() < 1e-5);
    }

    #[test]
    fn bytes_are_decoded_and_averaged_as_linear_light() {
        let bytes = (0..=255).collect::<Vec<u8>>();
        let samples = ImageSamples::Bytes(bytes, Transfer::Srgb);
        let mipmap = MipMap::new(Raster { size: [256, 1], channels: 1, samples });
        for code in 0..256 {
            let exact = srgb_decode(code as f32 / 255.0);
            assert_eq!(mipmap.texel(0, code, 0, Wrap::Clamp)[0], exact);
        }
        // The mean of black and white is half the light, code 188, not half the code.
        let samples = ImageSamples::Bytes(vec![0, 255], Transfer::Srgb);
        let mipmap = MipMap::new(Raster { size: [2, 1], channels: 1, samples });
        let half = mipmap.sample([0.0; 2], 9.0, Wrap::Repeat, TextureFilter::Bilinear)[0];
        assert_eq!(half, srgb_decode(188.0 / 255.0));
        assert_eq!(mipmap.bytes(), 3);
    }

    #[test]
    fn alpha_is_decoded_like_the_colours() {
        let samples = ImageSamples::Bytes(vec![51, 51, 51, 51], Transfer::Srgb);
        let mipmap = MipMap::new(Raster { size: [1, 1], channels: 4, samples });
        let light = srgb_decode(0.2);
        assert_eq!(mipmap.texel(0, 0, 0, Wrap::Clamp), [light; 4]);
    }
}
