//! Gaussian deviations of photosites, rows and columns.

use super::photosite_rng::PhotositeRng;
use petzval_base::sampler::hash;

/// Separate the numbers of rows and of columns from those of photosites.
const ROWS: u32 = 0x7a3d_90b5;
const COLUMNS: u32 = 0xc41e_6b27;

/// Standard deviations of what is random by photosite, by row and by column.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Components {
    /// By photosite.
    pub pixel: f64,
    /// By row: the same for all photosites and channels of a row.
    pub row: f64,
    /// By column: the same for all photosites and channels of a column.
    pub column: f64,
}

impl Components {
    /// Returns the variance of the sum.
    pub fn variance(&self) -> f64 {
        self.pixel * self.pixel + self.line_variance()
    }

    /// Returns the variance of the parts of row and column.
    pub fn line_variance(&self) -> f64 {
        self.row * self.row + self.column * self.column
    }

    /// Returns the deviations times a factor.
    pub fn scaled(&self, factor: f64) -> Self {
        let Self { pixel, row, column } = self;
        Self { pixel: factor * pixel, row: factor * row, column: factor * column }
    }
}

/// Samples of [`Components`] over a picture. Those of rows and columns are drawn once.
pub(super) struct Deviations {
    pixel: f64,
    seed: u32,
    origin: [u32; 2],
    /// By row and by column from the origin on; empty if there are none.
    rows: Vec<f64>,
    columns: Vec<f64>,
}

impl Deviations {
    /// Samples deviations. `origin` is the position of the picture's first pixel in the frame.
    pub fn new(of: &Components, origin: [u32; 2], size: [usize; 2], seed: u32) -> Self {
        let lines = |deviation: f64, first: u32, count: usize, seed: u32| match deviation > 0.0 {
            true => (0..count as u32)
                .map(|i| deviation * PhotositeRng::new([first + i, 0], 0, seed).normal())
                .collect(),
            false => Vec::new(),
        };
        Self {
            pixel: of.pixel,
            seed,
            origin,
            rows: lines(of.row, origin[1], size[1], hash(seed ^ ROWS)),
            columns: lines(of.column, origin[0], size[0], hash(seed ^ COLUMNS)),
        }
    }

    /// Returns the deviation of a photosite.
    pub fn at(&self, pixel: [u32; 2], channel: u32) -> f64 {
        let own = match self.pixel > 0.0 {
            true => self.pixel * PhotositeRng::new(pixel, channel, self.seed).normal(),
            false => 0.0,
        };
        own + self.of_lines(pixel)
    }

    /// Returns the parts of the row and of the column of a photosite.
    pub fn of_lines(&self, [x, y]: [u32; 2]) -> f64 {
        let line = |lines: &[f64], at: u32, first: u32| {
            lines.get((at - first) as usize).copied().unwrap_or_default()
        };
        line(&self.rows, y, self.origin[1]) + line(&self.columns, x, self.origin[0])
    }
}
