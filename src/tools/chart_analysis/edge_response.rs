//! Spatial frequency response of a slanted edge (e-SFR).

use std::f64::consts::{PI, TAU};

use petzval_base::sinc::sinc;
use petzval_image::Picture;

use super::edge::{EdgeError, MIN_SIDE, Region};

/// Bins of a pixel across the edge.
const BINS: f64 = 4.0;
/// Share of the window that falls to its ends.
const TAPER: f64 = 0.5;
/// Largest difference between the rise of the edge and that of its sides, relative to the latter.
const MAX_REST: f64 = 0.3;
/// Step and end of the search for a level (cycles/pixel).
const SEARCH_STEP: f64 = 0.002;
const SEARCH_END: f64 = 2.0;
/// Rounds in which the levels of bins are corrected by their neighbours.
const CORRECTIONS: usize = 3;

/// Direction of the frequencies that an edge measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeAxis {
    /// Along rows, by an edge that runs along columns.
    X,
    /// Along columns, by an edge that runs along rows.
    Y,
}

/// Spatial frequency response measured from one slanted edge.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeResponse {
    /// Direction of the frequencies.
    pub axis: EdgeAxis,
    /// Angle between the edge and the rows or columns that it runs along (degrees).
    pub angle: f64,
    /// Levels of the dark and the bright side.
    pub levels: [f64; 2],
    /// Edge spread: the mean level by distance from the edge, in bins of a quarter of a pixel.
    spread: Vec<f64>,
}

impl EdgeResponse {
    /// Measures the edge in a region of one channel of a picture, whose values are linear light.
    ///
    /// The method is that of ISO 12233:2023: the edge is fitted to centroids of rows, pixels are gathered in
    /// quarters of a pixel by their distance from it, and the response is the modulus of the Fourier transform of
    /// the derivative. Three things differ, for less bias: the uneven places of pixels in their bins are corrected, the window
    /// falls off only in the outer half of the line spread, and the response is corrected for the width of the
    /// bins as well as for the difference.
    ///
    /// # Errors
    /// Returns an error if the region has no edge that can be measured.
    pub fn measure(
        picture: &Picture,
        [low, high]: [[usize; 2]; 2],
        channel: impl Fn([f32; 3]) -> f64,
    ) -> Result<Self, EdgeError> {
        let [width, height] = [0, 1].map(|i| high[i].min(picture.size[i]).saturating_sub(low[i]));
        if width.min(height) < MIN_SIDE {
            return Err(EdgeError::Small { width, height });
        }
        let value = |x: usize, y: usize| {
            channel(picture.pixels[(low[1] + y) * picture.size[0] + low[0] + x])
        };
        let along_columns: Vec<f64> =
            (0..width * height).map(|i| value(i % width, i / width)).collect();
        if let Some(at) = along_columns.iter().position(|value| !value.is_finite()) {
            return Err(EdgeError::NotFinite { x: at % width, y: at / width });
        }
        let along_rows: Vec<f64> =
            (0..width * height).map(|i| value(i / height, i % height)).collect();
        let columns = Region { width, height, values: &along_columns };
        let rows = Region { width: height, height: width, values: &along_rows };
        // The levels of opposite sides differ most across the edge.
        let difference = |region: &Region<'_>| {
            let [one, other] = region.levels();
            (one - other).abs()
        };
        match difference(&columns) >= difference(&rows) {
            true => Self::of(&columns, EdgeAxis::X),
            false => Self::of(&rows, EdgeAxis::Y),
        }
    }

    /// Measures an edge that runs roughly along the columns of a region.
    fn of(region: &Region<'_>, axis: EdgeAxis) -> Result<Self, EdgeError> {
        let edge = region.edge()?;
        let Region { width, height, values } = *region;
        let curve: Vec<[f64; 2]> = (0..height).map(|y| edge.at(y)).collect();
        let margin =
            curve.iter().map(|[x, _]| x.min(width as f64 - 1.0 - x)).fold(f64::MAX, f64::min);
        let steepest = curve.iter().map(|[_, slope]| slope.abs()).fold(0.0, f64::max);
        // All rows reach these bins.
        let half = (BINS * margin / steepest.hypot(1.0)).floor() as usize;
        // Rows in which the edge crosses a whole number of pixels sample all parts of a pixel equally.
        let way = |[x, _]: &[f64; 2]| (x - curve[0][0]).abs();
        let crossed = curve.last().map_or(0.0, |[x, slope]| way(&[*x, 0.0]) + slope.abs());
        let rows = curve.iter().take_while(|place| way(place) < crossed.floor()).count();
        let mut bins = vec![Bin::default(); 2 * half];
        for ([x_edge, slope], row) in curve[..rows].iter().zip(values.chunks_exact(width)) {
            let cosine = 1.0 / slope.hypot(1.0);
            for (x, &value) in row.iter().enumerate() {
                let place = (x as f64 - x_edge) * cosine * BINS + half as f64;
                if (0.0..2.0 * half as f64).contains(&place) {
                    bins[place as usize].add(value, place.fract() - 0.5);
                }
            }
        }
        let spread = edge_spread(&bins).ok_or(EdgeError::Gaps { slope: steepest })?;
        let middle = edge.at(height / 2)[1];
        let [one, other] = region.levels();
        let levels = [one.min(other), one.max(other)];
        let edge = Self { axis, angle: middle.atan().to_degrees(), levels, spread };
        let rise: f64 = edge.line_spread().map(|(_, value)| value).sum();
        if (rise - (other - one)).abs() > MAX_REST * (other - one).abs() {
            return Err(EdgeError::Several { rise, sides: other - one });
        }
        let [rise, width] = [edge.rise(), edge.spread.len() as f64 / BINS];
        if rise > width / 2.0 {
            return Err(EdgeError::Wide { rise, width });
        }
        Ok(edge)
    }

    /// Returns the contrast of the edge (Michelson): the difference of its levels over their sum.
    pub fn contrast(&self) -> f64 {
        let [dark, bright] = self.levels;
        (bright - dark) / (bright + dark)
    }

    /// Returns the line spread times its window, and the distance of each value from the edge (pixels).
    fn line_spread(&self) -> impl Iterator<Item = (f64, f64)> {
        let half = self.spread.len() as f64 / 2.0;
        self.spread.windows(2).enumerate().map(move |(i, pair)| {
            let distance = (i as f64 + 1.0 - half) / BINS;
            // Tukey's window: 1 in the middle.
            let outer = ((distance.abs() * BINS / half - (1.0 - TAPER)) / TAPER).max(0.0);
            let window = 0.5 + 0.5 * (PI * outer).cos();
            (distance, (pair[1] - pair[0]) * window)
        })
    }

    /// Returns the response at a frequency across the edge (cycles/pixel), relative to that at 0.
    pub fn at(&self, frequency: f64) -> f64 {
        let (mut sum, mut whole) = ([0.0; 2], 0.0);
        for (distance, value) in self.line_spread() {
            let (sin, cos) = (TAU * frequency * distance).sin_cos();
            sum = [sum[0] + value * cos, sum[1] + value * sin];
            whole += value;
        }
        let narrow = sinc(frequency / BINS);
        sum[0].hypot(sum[1]) / whole.abs() / (narrow * narrow)
    }

    /// Returns the first frequency at which the response falls to a level (cycles/pixel): 0.5 gives MTF50. `None`
    /// if it does not fall so far below two cycles a pixel.
    pub fn frequency_of(&self, level: f64) -> Option<f64> {
        let mut before = [0.0, 1.0];
        let steps = (1..=(SEARCH_END / SEARCH_STEP) as u32).map(|i| SEARCH_STEP * f64::from(i));
        for frequency in steps {
            let response = self.at(frequency);
            if response <= level {
                let [f, r] = before;
                let share = if r > response { (r - level) / (r - response) } else { 1.0 };
                return Some(f + share * (frequency - f));
            }
            before = [frequency, response];
        }
        None
    }

    /// Returns the distance in which the edge rises from 10 to 90 % of its height (pixels).
    pub fn rise(&self) -> f64 {
        let end = self.spread.len() - 1;
        let flat = (end / 8).max(1);
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let [from, to] = [mean(&self.spread[..flat]), mean(&self.spread[end + 1 - flat..])];
        let share = |i: usize| (self.spread[i] - from) / (to - from);
        let crossing = |level: f64| {
            let after = (1..end).find(|&i| share(i) >= level).unwrap_or(end);
            let [low, high] = [share(after - 1), share(after)];
            after as f64 - 1.0 + if high > low { (level - low) / (high - low) } else { 0.0 }
        };
        (crossing(0.9) - crossing(0.1)) / BINS
    }
}

/// Pixels whose distances from the edge fall into one bin.
#[derive(Clone, Copy, Default)]
struct Bin {
    count: u32,
    /// Sum of the values.
    values: f64,
    /// Sums of the distances from the middle of the bin, relative to its width, and of their squares.
    offsets: [f64; 2],
}

impl Bin {
    fn add(&mut self, value: f64, offset: f64) {
        self.count += 1;
        self.values += value;
        self.offsets[0] += offset;
        self.offsets[1] += offset * offset;
    }

    /// Returns the mean of the values and those of the offsets; `None` without pixels.
    fn means(&self) -> Option<(f64, [f64; 2])> {
        let share = 1.0 / f64::from(self.count);
        (self.count > 0).then(|| (self.values * share, self.offsets.map(|sum| sum * share)))
    }
}

/// Returns the mean level over each bin; `None` if a bin is empty. The pixels of a bin are not spread evenly over it,
/// so that their mean is corrected by slope and curvature of the levels about it.
fn edge_spread(bins: &[Bin]) -> Option<Vec<f64>> {
    let means: Vec<(f64, [f64; 2])> = bins.iter().map(Bin::means).collect::<Option<_>>()?;
    let mut levels: Vec<f64> = means.iter().map(|&(value, _)| value).collect();
    for _ in 0..CORRECTIONS {
        let corrected = |(i, &(value, [first, second])): (usize, &(f64, [f64; 2]))| {
            let before = i.checked_sub(1).and_then(|before| levels.get(before));
            let (Some(before), Some(after)) = (before, levels.get(i + 1)) else { return value };
            let (slope, curvature) = ((after - before) / 2.0, after + before - 2.0 * levels[i]);
            value - slope * first - curvature / 2.0 * (second - 1.0 / 12.0)
        };
        levels = means.iter().enumerate().map(corrected).collect();
    }
    Some(levels)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the share of a pixel on the bright side of an edge through the middle of the picture that is blurred
    /// by a Gaussian (pixels) across it, by many points of the pixel.
    fn edge(size: [usize; 2], degrees: f64, sigma: f64, transposed: bool) -> Picture {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let points = 16;
        let mut pixels = Vec::new();
        for y in 0..size[1] {
            for x in 0..size[0] {
                let mut sum = 0.0;
                for i in 0..points * points {
                    let offset = |k: usize| (k as f64 + 0.5) / points as f64;
                    let at = [x as f64 + offset(i % points), y as f64 + offset(i / points)];
                    let from_middle = [0, 1].map(|k| at[k] - size[k] as f64 / 2.0);
                    let [u, v] =
                        if transposed { [from_middle[1], from_middle[0]] } else { from_middle };
                    sum += normal_share((u * cos + v * sin) / sigma);
                }
                pixels.push([0.1 + 0.8 * (sum / (points * points) as f64) as f32; 3]);
            }
        }
        Picture { size, pixels }
    }

    /// Returns the cumulative normal distribution by Simpson's rule.
    fn normal_share(z: f64) -> f64 {
        let (z, steps) = (z.clamp(-8.0, 8.0), 40);
        let h = z / f64::from(steps);
        let density = |x: f64| (-x * x / 2.0).exp() / TAU.sqrt();
        let weight = |i: i32| if i == 0 || i == steps { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
        0.5 + (0..=steps).map(|i| weight(i) * density(h * f64::from(i))).sum::<f64>() * h / 3.0
    }

    fn green(pixel: [f32; 3]) -> f64 {
        f64::from(pixel[1])
    }

    #[test]
    fn the_response_of_a_blurred_edge_is_that_of_its_blur_and_its_pixels() {
        for (degrees, sigma, transposed) in [
            (5.0, 0.7, false),
            (-5.0, 0.4, true),
            (9.0, 1.5, false),
            (3.0, 0.25, true),
            (15.0, 0.6, false),
            (1.5, 0.6, false),
            (14.036, 0.5, true),
            (22.0, 0.8, false),
            (30.0, 0.6, true),
            (41.0, 0.6, false),
        ] {
            let wide = 64 + (100.0 * f64::to_radians(degrees).tan().abs()) as usize;
            let size = if transposed { [100, wide] } else { [wide, 100] };
            let picture = edge(size, degrees, sigma, transposed);
            let found = EdgeResponse::measure(&picture, [[0, 0], size], green).unwrap();
            assert_eq!(found.axis, if transposed { EdgeAxis::Y } else { EdgeAxis::X });
            assert!((found.angle.abs() - degrees.abs()).abs() < 0.1, "{} {degrees}", found.angle);
            assert!((found.contrast() - 0.8).abs() < 1e-3, "{}", found.contrast());
            let (sin, cos) = degrees.to_radians().sin_cos();
            for i in 0..=10 {
                let f = 0.05 * f64::from(i);
                let pixel = sinc(f * cos) * sinc(f * sin);
                let expected = (-2.0 * (PI * sigma * f).powi(2)).exp() * pixel;
                let off = found.at(f) - expected;
                assert!(
                    off.abs() < 0.002,
                    "{degrees} {sigma} at {f}: {} not {expected}",
                    found.at(f)
                );
            }
            let half = found.frequency_of(0.5).unwrap();
            assert!((found.at(half) - 0.5).abs() < 1e-3);
            if sigma > 1.0 {
                // From -1.2816 to 1.2816 standard deviations, and a little of the pixel.
                let rise = 2.0 * 1.281_55 * (sigma * sigma + 1.0 / 12.0_f64).sqrt();
                assert!((found.rise() / rise - 1.0).abs() < 0.02, "{} {rise}", found.rise());
            }
        }
    }

    #[test]
    fn edges_that_would_be_measured_wrongly_are_refused() {
        let of = |picture: &Picture| {
            EdgeResponse::measure(picture, [[0, 0], picture.size], green).unwrap_err().to_string()
        };
        // Along a diagonal of pixels, all of them are at a few distances only.
        assert!(of(&edge([120, 60], 44.9, 0.8, false)).contains("slant the chart by about 5"));
        // Two steps: the sides are those of both.
        let wide = edge([140, 60], 5.0, 0.7, false);
        let pixel = |i: usize| {
            let level = |shift: usize| wide.pixels[i / 100 * 140 + i % 100 + shift][1];
            [(level(5) + level(35)) / 2.0; 3]
        };
        let two = Picture { size: [100, 60], pixels: (0..6000).map(pixel).collect() };
        assert!(of(&two).contains("sharper or single edge"), "{}", of(&two));
        // A second step outside what is measured.
        let pixel = |i: usize| {
            let level = |shift: usize| wide.pixels[i / 80 * 140 + i % 80 + shift][1];
            [level(30) + if i % 80 > 72 { 2.0 } else { 0.0 }; 3]
        };
        let beside = Picture { size: [80, 60], pixels: (0..4800).map(pixel).collect() };
        assert!(of(&beside).contains("from side to side"), "{}", of(&beside));
    }

    #[test]
    fn regions_without_a_measurable_edge_are_refused_with_a_reason() {
        let of = |picture: &Picture, region: [[usize; 2]; 2]| {
            EdgeResponse::measure(picture, region, green).unwrap_err().to_string()
        };
        let picture = edge([64, 64], 5.0, 0.5, false);
        assert!(of(&picture, [[0, 0], [64, 12]]).contains("64 x 12 pixels; expected at least"));
        assert!(of(&picture, [[60, 60], [900, 900]]).contains("4 x 4 pixels"));
        assert!(of(&picture, [[0, 0], [24, 64]]).contains("no edge"));
        let straight = edge([64, 64], 0.2, 0.5, false);
        assert!(of(&straight, [[0, 0], [64, 64]]).contains("crosses 0.2"));
        assert!(
            of(&picture, [[0, 0], [40, 64]]).contains("sides of the region"),
            "{}",
            of(&picture, [[0, 0], [40, 64]])
        );
        let mut broken = picture.clone();
        broken.pixels[3 * 64 + 2] = [f32::NAN; 3];
        assert!(of(&broken, [[1, 1], [64, 64]]).contains("pixel 1,2 of the region is not finite"));
        let flat = Picture { size: [40, 40], pixels: vec![[0.5; 3]; 1600] };
        assert!(of(&flat, [[0, 0], [40, 40]]).contains("differ by 0.0 %"));
        let black = Picture { size: [40, 40], pixels: vec![[0.0; 3]; 1600] };
        assert!(of(&black, [[0, 0], [40, 40]]).contains("no edge"));
    }
}
