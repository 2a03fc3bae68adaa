//! Position of a slanted edge in a region of a picture.

use petzval_base::least_squares::least_squares;

/// Least width and height of a region (pixels).
pub(super) const MIN_SIDE: usize = 20;
/// Least distance from the edge to the sides of its region (pixels).
pub(super) const MIN_MARGIN: f64 = 5.0;
/// Least contrast: the difference of the two levels over their sum.
const MIN_CONTRAST: f64 = 0.02;
/// Least way of the edge across columns (pixels), which spreads samples evenly over parts of a pixel.
const MIN_SHIFT: f64 = 1.0;
/// Largest slope of an edge: beyond it, the other axis measures it.
const MAX_SLOPE: f64 = 1.0;
/// Coefficients of the polynomial of the edge: distortion bends it.
const COEFFICIENTS: usize = 4;
/// Half width of the window about the edge when its position is refined, as a share of the region's width.
const WINDOW: f64 = 0.25;

/// Why a region has no measurable edge.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EdgeError {
    /// The region is too small.
    #[error("the region has {width} x {height} pixels; expected at least {MIN_SIDE} x {MIN_SIDE}")]
    Small {
        /// Width (pixels).
        width: usize,
        /// Height (pixels).
        height: usize,
    },
    /// A value is not finite.
    #[error("pixel {x},{y} of the region is not finite")]
    NotFinite {
        /// Column in the region.
        x: usize,
        /// Row in the region.
        y: usize,
    },
    /// Both sides are equally bright.
    #[error(
        "the region has no edge: its sides differ by {:.1} % of their sum; expected a bright and a dark side",
        100.0 * contrast
    )]
    Flat {
        /// The difference of the two levels over their sum.
        contrast: f64,
    },
    /// The edge does not cross the region.
    #[error(
        "the edge comes within {margin:.1} pixels of the sides of the region that it should cross from end to \
         end; expected {MIN_MARGIN} or more: choose a wider region, or a shorter one"
    )]
    Leaves {
        /// Least distance from the edge to a side (pixels); negative outside.
        margin: f64,
    },
    /// The edge is parallel to the pixels.
    #[error(
        "the edge crosses {shift:.2} pixels over the region; expected {MIN_SHIFT} or more: slant the chart by about \
         5 degrees, or choose a longer region"
    )]
    Straight {
        /// Pixels that the edge crosses.
        shift: f64,
    },
    /// The edge is steeper than 45 degrees, or is none.
    #[error(
        "the edge has a slope of {slope:.2} pixels a row; expected a single edge of at most {MAX_SLOPE}"
    )]
    Steep {
        /// Largest slope (pixels a row).
        slope: f64,
    },
    /// No pixels lie at some distances from the edge.
    #[error(
        "with a slope of {slope:.2} pixels a row the edge leaves gaps between the distances of pixels from it; slant \
         the chart by about 5 degrees"
    )]
    Gaps {
        /// Largest slope (pixels a row).
        slope: f64,
    },
    /// The region holds more than one edge.
    #[error(
        "the values rise by {rise:.4} at the edge, and from side to side by {sides:.4}; expected a single edge: choose a \
         smaller region"
    )]
    Several {
        /// Rise at the edge.
        rise: f64,
        /// Rise from side to side.
        sides: f64,
    },
    /// The edge is too wide for its region, or there is more than one.
    #[error(
        "the edge rises over {rise:.1} of the {width:.1} pixels that are measured across it; expected a sharper or single \
         edge: choose a wider region around one edge"
    )]
    Wide {
        /// Distance in which it rises from 10 to 90 % (pixels).
        rise: f64,
        /// Width of what is measured (pixels).
        width: f64,
    },
}

/// A region whose edge runs roughly along its columns.
pub(super) struct Region<'a> {
    pub width: usize,
    pub height: usize,
    /// Values, row after row.
    pub values: &'a [f64],
}

/// A polynomial: the column of the edge by row.
pub(super) struct EdgeCurve {
    coefficients: Vec<f64>,
    height: f64,
}

impl EdgeCurve {
    /// Returns the column (pixels, 0 in the middle of the first) and the slope (pixels a row) in the middle of a
    /// row.
    pub fn at(&self, row: usize) -> [f64; 2] {
        let t = position(row, self.height);
        let (mut value, mut slope) = (0.0, 0.0);
        for coefficient in self.coefficients.iter().rev() {
            slope = slope * t + value;
            value = value * t + coefficient;
        }
        [value, slope * 2.0 / self.height]
    }
}

/// Returns the place of a row: -1 to 1 from end to end.
fn position(row: usize, height: f64) -> f64 {
    (row as f64 + 0.5) * 2.0 / height - 1.0
}

impl Region<'_> {
    fn row(&self, y: usize) -> &[f64] {
        &self.values[y * self.width..][..self.width]
    }

    /// Returns the mean of each outer fifth: the levels of the left and the right side.
    pub fn levels(&self) -> [f64; 2] {
        let fifth = (self.width / 5).max(1);
        let mean = |from: usize| {
            let sum: f64 = (0..self.height).flat_map(|y| &self.row(y)[from..from + fifth]).sum();
            sum / (fifth * self.height) as f64
        };
        [mean(0), mean(self.width - fifth)]
    }

    /// Finds the edge: centroids of the derivative of each row, first about the middle of the region and then
    /// about the edge, and a polynomial through them (ISO 12233:2023, annex D).
    ///
    /// # Errors
    /// Returns an error if there is no edge that crosses the region from end to end at a slant.
    pub fn edge(&self) -> Result<EdgeCurve, EdgeError> {
        let [left, right] = self.levels();
        let contrast = (right - left).abs() / (right + left).abs().max(f64::MIN_POSITIVE);
        if contrast < MIN_CONTRAST {
            return Err(EdgeError::Flat { contrast });
        }
        let middle = (self.width as f64 - 1.0) / 2.0;
        let mut curve = self.curve(|_| middle, self.width as f64 / 2.0);
        for _ in 0..3 {
            curve = self.curve(|y| curve.at(y)[0], (WINDOW * self.width as f64).max(8.0));
        }
        let rows = || (0..self.height).map(|y| curve.at(y));
        let slope = rows().map(|[_, slope]| slope.abs()).fold(0.0, f64::max);
        let ends = rows().map(|[x, _]| x);
        let (low, high) = (ends.clone().fold(f64::MAX, f64::min), ends.fold(f64::MIN, f64::max));
        let margin = low.min(self.width as f64 - 1.0 - high);
        if slope > MAX_SLOPE {
            return Err(EdgeError::Steep { slope });
        }
        if margin < MIN_MARGIN {
            return Err(EdgeError::Leaves { margin });
        }
        match high - low >= MIN_SHIFT {
            true => Ok(curve),
            false => Err(EdgeError::Straight { shift: high - low }),
        }
    }

    /// Fits a polynomial to the centroids of the rows' derivatives within a window (pixels) about a column.
    fn curve(&self, about: impl Fn(usize) -> f64, half_width: f64) -> EdgeCurve {
        let height = self.height as f64;
        let (mut columns, mut side) = (vec![Vec::new(); COEFFICIENTS], Vec::new());
        for y in 0..self.height {
            let (row, centre) = (self.row(y), about(y));
            let [mut weight, mut moment] = [0.0; 2];
            for x in 0..self.width - 1 {
                let at = x as f64 + 0.5;
                let off = (at - centre) / half_width;
                if off.abs() < 1.0 {
                    // Hann's window.
                    let step =
                        (row[x + 1] - row[x]) * (0.5 + 0.5 * (std::f64::consts::PI * off).cos());
                    weight += step;
                    moment += step * at;
                }
            }
            let centroid = moment / weight;
            // A row without an edge says nothing.
            if centroid.is_finite() && (0.0..self.width as f64).contains(&centroid) {
                let t = position(y, height);
                (0..COEFFICIENTS).for_each(|k| columns[k].push(t.powi(k as i32)));
                side.push(centroid);
            }
        }
        let coefficients = least_squares(columns, vec![side]).pop().unwrap_or_default();
        EdgeCurve { coefficients, height }
    }
}
