//! A picture at every scale, each half the one before (Williams 1983).

use glam::Vec2;

use super::Wrap;
use super::bilinear::{bilinear, place};
use crate::image::{Picture, Raster, Samples, Transfer};

/// Which texels make a colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// The nearest one.
    Point,
    /// The four around the point, of the last picture that is not coarser than the sample.
    #[default]
    Bilinear,
    /// The four around the point in each of the two pictures beside the sample's size.
    Trilinear,
}

/// A picture at every scale. Texels count from the upper left.
#[derive(Clone, Debug)]
pub struct Pyramid {
    /// Of 8-bit signals, the light that each stands for; alpha has a table of its own.
    light: Box<[f32; 256]>,
    channels: usize,
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    size: [usize; 2],
    texels: Texels,
}

#[derive(Clone, Debug)]
enum Texels {
    Bytes(Vec<u8>),
    Floats(Vec<f32>),
}

impl Pyramid {
    /// Builds the pyramid of a picture of at least one pixel. Means are of light; 8-bit pictures
    /// are 8-bit at every scale.
    pub fn new(raster: Raster) -> Self {
        let Raster { size, channels, samples } = raster;
        let (texels, transfer) = match samples {
            Samples::Bytes(bytes, transfer) => (Texels::Bytes(bytes), Some(transfer)),
            Samples::Floats(floats) => (Texels::Floats(floats), None),
        };
        let curve = transfer.unwrap_or_default();
        let light = Box::new(std::array::from_fn(|code| curve.decode(code as f32 / 255.0)));
        let mut pyramid = Self { light, channels, levels: vec![Level { size, texels }] };
        let mut coarse: Option<(Vec<f32>, [usize; 2])> = None;
        loop {
            let fine = match &coarse {
                Some((_, size)) => *size,
                None => size,
            };
            if fine == [1, 1] {
                return pyramid;
            }
            let next = match &coarse {
                Some((floats, size)) => halve(*size, channels, |i| floats[i]),
                None => halve(size, channels, |i| pyramid.number(0, i)),
            };
            let size = fine.map(half);
            let texels = match transfer {
                Some(transfer) => Texels::Bytes(encoded(&next, transfer)),
                None => Texels::Floats(next.clone()),
            };
            pyramid.levels.push(Level { size, texels });
            coarse = Some((next, size));
        }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [usize; 2] {
        self.levels[0].size
    }

    /// 1 (luminance), 3 (RGB) or 4 (RGB and alpha).
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Bytes of all texels.
    pub fn bytes(&self) -> usize {
        let of = |level: &Level| match &level.texels {
            Texels::Bytes(bytes) => bytes.len(),
            Texels::Floats(floats) => 4 * floats.len(),
        };
        self.levels.iter().map(of).sum()
    }

    fn number(&self, level: usize, i: usize) -> f32 {
        match &self.levels[level].texels {
            Texels::Bytes(bytes) => self.light[usize::from(bytes[i])],
            Texels::Floats(floats) => floats[i],
        }
    }

    /// A texel: red, green, blue, alpha.
    pub fn texel(&self, level: usize, x: i64, y: i64, wrap: Wrap) -> [f32; 4] {
        let [width, height] = self.levels[level].size;
        let Some([x, y]) = wrap.place([x, y], [width as i64, height as i64]) else {
            return [0.0; 4];
        };
        let first = (y as usize * width + x as usize) * self.channels;
        let at = |channel: usize| self.number(level, first + channel);
        match self.channels {
            1 => [at(0), at(0), at(0), 1.0],
            3 => [at(0), at(1), at(2), 1.0],
            _ => [at(0), at(1), at(2), at(3)],
        }
    }

    /// Red, green, blue and alpha at a point, (0, 0) the upper left corner of the picture and
    /// (1, 1) the lower right, for a sample that reaches so far on each side; 0 is a point.
    pub fn look_up(&self, st: Vec2, reach: f32, wrap: Wrap, filter: Filter) -> [f32; 4] {
        let coarsest = self.levels.len() - 1;
        let side = self.size().into_iter().max().unwrap_or(1) as f32;
        let level = (2.0 * reach * side).log2().max(0.0);
        if level >= coarsest as f32 && coarsest > 0 {
            return self.texel(coarsest, 0, 0, Wrap::Clamp);
        }
        let below = level as usize;
        match filter {
            Filter::Point => {
                let [x, y] = place(st, self.levels[below].size, wrap);
                self.texel(below, (x + 0.5).floor() as i64, (y + 0.5).floor() as i64, wrap)
            }
            Filter::Bilinear => self.bilinear(below, st, wrap),
            Filter::Trilinear => {
                let share = level - below as f32;
                let fine = self.bilinear(below, st, wrap);
                if share == 0.0 {
                    return fine;
                }
                let coarse = self.bilinear(below + 1, st, wrap);
                [0, 1, 2, 3].map(|i| fine[i] + share * (coarse[i] - fine[i]))
            }
        }
    }

    fn bilinear(&self, level: usize, st: Vec2, wrap: Wrap) -> [f32; 4] {
        let at = place(st, self.levels[level].size, wrap);
        bilinear(at, |x, y| self.texel(level, x, y, wrap))
    }
}

impl From<&Picture> for Pyramid {
    fn from(picture: &Picture) -> Self {
        let floats = picture.pixels.as_flattened().to_vec();
        Self::new(Raster { size: picture.size, channels: 3, samples: Samples::Floats(floats) })
    }
}

fn half(n: usize) -> usize {
    (n / 2).max(1)
}

/// Which entries of a row of `n` make entry `i` of the row of half as many, and their weights: two,
/// or three where `n` is odd. All entries of the row weigh the same in the end.
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

/// The picture of half the size, from the numbers of one.
fn halve(size: [usize; 2], channels: usize, number: impl Fn(usize) -> f32) -> Vec<f32> {
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
                        sum += row * column * number(texel * channels + channel);
                    }
                }
                coarse.push(sum);
            }
        }
    }
    coarse
}

fn encoded(light: &[f32], transfer: Transfer) -> Vec<u8> {
    light.iter().map(|&v| (255.0 * transfer.encode(v)).round() as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::srgb_decode;

    fn floats(size: [usize; 2], channels: usize) -> Pyramid {
        let count = size[0] * size[1] * channels;
        let value = |i: usize| ((i * 2_654_435_761) % 1009) as f32 / 1009.0;
        let samples = Samples::Floats((0..count).map(value).collect());
        Pyramid::new(Raster { size, channels, samples })
    }

    fn mean(pyramid: &Pyramid, level: usize) -> f64 {
        let [width, height] = pyramid.levels[level].size;
        let all = (0..height).flat_map(|y| (0..width).map(move |x| (x as i64, y as i64)));
        let sum: f64 =
            all.map(|(x, y)| f64::from(pyramid.texel(level, x, y, Wrap::Clamp)[0])).sum();
        sum / (width * height) as f64
    }

    #[test]
    fn every_scale_has_the_mean_of_the_picture() {
        for size in [[8, 8], [7, 5], [1, 13], [33, 2], [1, 1]] {
            let pyramid = floats(size, 3);
            let whole = mean(&pyramid, 0);
            for level in 1..pyramid.levels.len() {
                let found = mean(&pyramid, level);
                assert!((found - whole).abs() < 1e-5, "{size:?}, level {level}: {found}, {whole}");
            }
            assert_eq!(pyramid.levels[pyramid.levels.len() - 1].size, [1, 1]);
        }
    }

    #[test]
    fn a_wide_sample_sees_the_mean_and_a_point_the_texels() {
        let pyramid = floats([16, 8], 1);
        let whole = mean(&pyramid, 0) as f32;
        for filter in [Filter::Point, Filter::Bilinear, Filter::Trilinear] {
            let wide = pyramid.look_up(Vec2::new(0.3, 0.7), 5.0, Wrap::Repeat, filter);
            assert!((wide[0] - whole).abs() < 1e-5);
        }
        let texel = |x, y| pyramid.texel(0, x, y, Wrap::Repeat)[0];
        let at = |x: f32, y: f32, filter| {
            pyramid.look_up(Vec2::new(x / 16.0, y / 8.0), 0.0, Wrap::Repeat, filter)[0]
        };
        for filter in [Filter::Point, Filter::Bilinear, Filter::Trilinear] {
            assert!((at(3.5, 2.5, filter) - texel(3, 2)).abs() < 1e-6);
        }
        let blend =
            0.75 * 0.5 * (texel(3, 2) + texel(3, 3)) + 0.25 * 0.5 * (texel(4, 2) + texel(4, 3));
        assert!((at(3.75, 3.0, Filter::Bilinear) - blend).abs() < 1e-6);
        assert!((at(3.75, 3.2, Filter::Point) - texel(3, 3)).abs() < 1e-6);
    }

    #[test]
    fn the_scale_follows_the_size_of_the_sample() {
        let pyramid = floats([16, 16], 1);
        // A sample of 4 texels: level 2, whose texels are 4 wide.
        let at = |reach: f32, filter| {
            pyramid.look_up(Vec2::new(0.375, 0.625), reach, Wrap::Repeat, filter)[0]
        };
        let texel = |level, x, y| pyramid.texel(level, x, y, Wrap::Repeat)[0];
        assert!((at(2.0 / 16.0, Filter::Bilinear) - texel(2, 1, 2)).abs() < 1e-6);
        // Bilinear stays at a level until the next, trilinear goes over.
        let between = 2.0f32.powf(0.5) / 16.0;
        let fine = at(1.0 / 16.0, Filter::Bilinear);
        assert_eq!(at(between, Filter::Bilinear), fine);
        let blend = 0.5 * (fine + texel(2, 1, 2));
        assert!((at(between, Filter::Trilinear) - blend).abs() < 1e-5);
    }

    #[test]
    fn bytes_are_decoded_by_the_curve_and_averaged_as_light() {
        let bytes = (0..=255).collect::<Vec<u8>>();
        let samples = Samples::Bytes(bytes, Transfer::Srgb);
        let pyramid = Pyramid::new(Raster { size: [256, 1], channels: 1, samples });
        for code in 0..256 {
            let exact = srgb_decode(code as f32 / 255.0);
            assert_eq!(pyramid.texel(0, code, 0, Wrap::Clamp)[0], exact);
        }
        // Black and white make half the light, code 188, not half the code.
        let samples = Samples::Bytes(vec![0, 255], Transfer::Srgb);
        let pyramid = Pyramid::new(Raster { size: [2, 1], channels: 1, samples });
        let half = pyramid.look_up(Vec2::ZERO, 9.0, Wrap::Repeat, Filter::Bilinear)[0];
        assert_eq!(half, srgb_decode(188.0 / 255.0));
        assert_eq!(pyramid.bytes(), 3);
    }

    #[test]
    fn alpha_is_coded_as_the_colours_are() {
        let samples = Samples::Bytes(vec![51, 51, 51, 51], Transfer::Srgb);
        let pyramid = Pyramid::new(Raster { size: [1, 1], channels: 4, samples });
        let light = srgb_decode(0.2);
        assert_eq!(pyramid.texel(0, 0, 0, Wrap::Clamp), [light; 4]);
    }
}
