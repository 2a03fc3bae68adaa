//! Shading: how light and colours of a white chart fall off from the middle of a picture.

use petzval_image::Picture;

use super::luminance;

/// Zones along the longer side of a picture.
const ZONES: usize = 15;
/// Least shorter side of a picture (pixels).
const LEAST: usize = 30;

/// Why the shading cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadingError {
    /// The picture is small.
    #[error("{width} x {height} pixels; expected at least {LEAST} x {LEAST}")]
    Small {
        /// Width (pixels).
        width: usize,
        /// Height (pixels).
        height: usize,
    },
    /// The middle has no light.
    #[error("its middle has no light in all channels; expected a picture of a white chart")]
    Dark,
    /// A zone is not finite.
    #[error("the zone around pixel {x:.0},{y:.0} is not finite")]
    NotFinite {
        /// Column.
        x: f64,
        /// Row.
        y: f64,
    },
}

/// A zone of a picture, relative to the one in the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingZone {
    /// Its middle (pixels, that of the first pixel at 0).
    pub middle: [f64; 2],
    /// Distance from the middle of the picture, relative to half of its diagonal.
    pub field: f64,
    /// Luminance.
    pub light: f64,
    /// Red over green, and blue over green; `None` without light.
    pub colour: Option<[f64; 2]>,
}

/// Shading of a picture of white.
#[derive(Clone, Debug, PartialEq)]
pub struct Shading {
    /// Columns and rows of zones, which are odd.
    pub size: [usize; 2],
    /// The zones, row after row.
    pub zones: Vec<ShadingZone>,
}

impl Shading {
    /// Measures a picture of a white chart: the mean of each zone.
    ///
    /// # Errors
    /// Returns an error if the picture is too small, its middle has no light, or a value is not finite.
    pub fn measure(picture: &Picture) -> Result<Self, ShadingError> {
        let [width, height] = picture.size;
        if width.min(height) < LEAST {
            return Err(ShadingError::Small { width, height });
        }
        let longest = width.max(height) as f64;
        // An odd number has a zone in the middle.
        let odd =
            |n: usize| (ZONES as f64 * n as f64 / longest / 2.0 - 0.5).round() as usize * 2 + 1;
        let size = [odd(width), odd(height)];
        let count = size[0] * size[1];
        let mut means = Vec::with_capacity(count);
        for i in 0..count {
            let place = [i % size[0], i / size[0]];
            // Rounded, so that zones on both sides of the middle have the same size.
            let bounds = |end: usize| {
                [0, 1].map(|a| (2 * (place[a] + end) * picture.size[a] + size[a]) / (2 * size[a]))
            };
            let (low, high) = (bounds(0), bounds(1));
            let mut sums = [0.0; 3];
            for row in low[1]..high[1] {
                for pixel in &picture.pixels[row * width..][low[0]..high[0]] {
                    sums = [0, 1, 2].map(|c| sums[c] + f64::from(pixel[c]));
                }
            }
            let middle = [0, 1].map(|a| (low[a] + high[a]) as f64 / 2.0 - 0.5);
            if !sums.iter().all(|sum| sum.is_finite()) {
                return Err(ShadingError::NotFinite { x: middle[0], y: middle[1] });
            }
            let pixels = ((high[0] - low[0]) * (high[1] - low[1])) as f64;
            means.push((middle, sums.map(|sum| sum / pixels)));
        }
        let (_, white) = means[count / 2];
        if !white.iter().all(|&mean| mean > 0.0) {
            return Err(ShadingError::Dark);
        }
        let half = picture.size.map(|n| n as f64 / 2.0);
        let zones = means.into_iter().map(|(middle, mean)| {
            let [x, y] = [0, 1].map(|a| middle[a] + 0.5 - half[a]);
            let [red, green, blue] = [0, 1, 2].map(|c| mean[c] / white[c]);
            ShadingZone {
                middle,
                field: x.hypot(y) / half[0].hypot(half[1]),
                light: luminance(mean) / luminance(white),
                colour: (green > 0.0).then(|| [red / green, blue / green]),
            }
        });
        Ok(Self { size, zones: zones.collect() })
    }

    /// Returns the zones in the corners: upper left, upper right, lower left, lower right.
    pub fn corners(&self) -> [&ShadingZone; 4] {
        let last = self.zones.len();
        [0, self.size[0] - 1, last - self.size[0], last - 1].map(|i| &self.zones[i])
    }

    /// Returns the least light relative to the most.
    pub fn uniformity(&self) -> f64 {
        let light = self.zones.iter().map(|zone| zone.light);
        light.clone().fold(f64::INFINITY, f64::min) / light.fold(0.0, f64::max)
    }

    /// Returns the largest distance of a ratio of colours from that of the middle.
    pub fn colour_shading(&self) -> f64 {
        let ratios = self.zones.iter().filter_map(|zone| zone.colour).flatten();
        ratios.map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Draws light that falls off with the square of the field by these shares at the corners.
    fn picture([width, height]: [usize; 2], corner: [f64; 3]) -> Picture {
        let pixel = |i: usize| {
            let x = (i % width) as f64 + 0.5 - width as f64 / 2.0;
            let y = (i / width) as f64 + 0.5 - height as f64 / 2.0;
            let square = (x * x + y * y) * 4.0 / (width * width + height * height) as f64;
            corner.map(|share| (0.8 * (1.0 - share * square)) as f32)
        };
        Picture { size: [width, height], pixels: (0..width * height).map(pixel).collect() }
    }

    #[test]
    fn falloff_and_colours_are_those_of_the_picture() {
        for size in [[300, 200], [199, 301], [64, 64]] {
            let found = Shading::measure(&picture(size, [0.5, 0.4, 0.2])).unwrap();
            assert!(found.size.iter().all(|n| n % 2 == 1) && found.size.contains(&15), "{size:?}");
            assert_eq!(found.zones.len(), found.size[0] * found.size[1]);
            let middle = found.zones[found.zones.len() / 2];
            assert_eq!((middle.light, middle.colour), (1.0, Some([1.0; 2])));
            for zone in &found.zones {
                // The mean of the square over a zone is a little more than that of its middle.
                let [r, g, b] = [0.5, 0.4, 0.2].map(|share| 1.0 - share * zone.field * zone.field);
                assert!((zone.light / luminance([r, g, b]) - 1.0).abs() < 5e-3, "{zone:?}");
                let colour = zone.colour.unwrap();
                assert!((colour[0] - r / g).abs() < 5e-3 && (colour[1] - b / g).abs() < 5e-3);
            }
            let corners = found.corners();
            assert!(
                corners.iter().all(|zone| zone.field > 0.9 && zone.field < 0.95),
                "{corners:?}"
            );
            let light: Vec<f64> = corners.iter().map(|zone| zone.light).collect();
            assert!(light.iter().all(|l| (l - light[0]).abs() < 2e-3), "{light:?}");
            assert!((found.uniformity() - light[0]).abs() < 2e-3);
            assert!((found.colour_shading() - (corners[0].colour.unwrap()[1] - 1.0)).abs() < 2e-3);
        }
    }

    #[test]
    fn pictures_without_white_are_refused() {
        let small = Shading::measure(&picture([300, 29], [0.1; 3]));
        assert_eq!(small, Err(ShadingError::Small { width: 300, height: 29 }));
        let mut dark = picture([300, 200], [0.1; 3]);
        dark.pixels[5][1] = f32::INFINITY;
        let spoiled = Shading::measure(&dark).unwrap_err();
        assert!(spoiled.to_string().ends_with("is not finite"), "{spoiled}");
        let black = Shading::measure(&Picture { size: [300, 200], pixels: vec![[0.0; 3]; 60_000] });
        assert_eq!(black, Err(ShadingError::Dark));
        // A corner beyond the image circle.
        let mut round = picture([300, 200], [0.1; 3]);
        for y in 0..20 {
            round.pixels[y * 300..][..20].fill([0.0; 3]);
        }
        let found = Shading::measure(&round).unwrap();
        assert_eq!((found.corners()[0].light, found.corners()[0].colour), (0.0, None));
        assert!(found.uniformity() == 0.0 && found.colour_shading() < 1e-3);
    }
}
