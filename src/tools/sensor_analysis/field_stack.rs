//! Statistics of pictures of a uniform field.

use super::high_pass::{Filtered, REACH, high_pass, remaining_variance};

/// Least width and height of a field (pixels): some rows and columns are left by the filter.
pub const MIN_FIELD: usize = 2 * REACH + 22;

/// Pictures of a uniform field with the same exposure, added up one after another.
#[derive(Clone, Debug)]
pub struct FieldStack {
    size: [usize; 2],
    /// The first code: others are added up relative to it, so that squares lose no digits.
    origin: f64,
    /// For each pixel, the sums over the pictures of its code and of the square.
    pixels: Vec<[f64; 2]>,
    /// The same of the mean of each row.
    rows: Vec<[f64; 2]>,
    /// The same of the mean of each column.
    columns: Vec<[f64; 2]>,
    /// The same of the mean of the picture.
    all: [f64; 2],
    pictures: usize,
}

/// Variances of the readings of a field by source (square of codes).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Variances {
    /// Variance that each photosite has for itself.
    pub pixel: f64,
    /// Variance that all photosites of a row share.
    pub row: f64,
    /// Variance that all photosites of a column share.
    pub column: f64,
}

/// Mean and variances of a stack of pictures, in codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldStatistics {
    /// Number of pictures.
    pub pictures: usize,
    /// Mean of all pixels.
    pub mean: f64,
    /// Temporal variance: what differs from picture to picture, but for their means.
    pub temporal: Variances,
    /// Spatial variance: what is the same in all pictures and does not vary slowly, as the light may. Without any, its
    /// estimate can be negative.
    pub spatial: Variances,
}

impl Variances {
    /// Returns the variance of all together.
    pub fn total(self) -> f64 {
        self.pixel + self.row + self.column
    }

    /// Returns the three from the variances of pixels, of means of rows, of means of columns and of the mean of all.
    /// Means hold a share of what they average, and what all pixels have in common is in each of the four.
    fn of([pixels, rows, columns, all]: [f64; 4], [width, height]: [f64; 2]) -> Self {
        let [of_rows, of_columns] = [1.0 - 1.0 / height, 1.0 - 1.0 / width];
        let pixel = (pixels - rows - columns + all) / (of_rows * of_columns);
        let row = (pixels - columns) / of_rows - pixel;
        let column = (pixels - rows) / of_columns - pixel;
        Self { pixel, row, column }
    }

    /// Returns the variances without a share of others.
    pub(super) fn without(self, other: Self, share: f64) -> Self {
        Self {
            pixel: self.pixel - share * other.pixel,
            row: self.row - share * other.row,
            column: self.column - share * other.column,
        }
    }
}

impl FieldStack {
    /// Begins a stack of pictures of this width and height (pixels).
    ///
    /// # Panics
    /// Panics if one of them is less than [`MIN_FIELD`].
    pub fn new(size: [usize; 2]) -> Self {
        assert!(
            size.iter().all(|&side| side >= MIN_FIELD),
            "{size:?}: a field of {MIN_FIELD} pixels"
        );
        Self {
            size,
            origin: 0.0,
            pixels: vec![[0.0; 2]; size[0] * size[1]],
            rows: vec![[0.0; 2]; size[1]],
            columns: vec![[0.0; 2]; size[0]],
            all: [0.0; 2],
            pictures: 0,
        }
    }

    /// Adds a picture: codes by row, from the first pixel.
    pub fn add(&mut self, codes: impl IntoIterator<Item = f64>) {
        let [width, height] = self.size;
        let mut columns = vec![0.0; width];
        let mut all = 0.0;
        let mut codes = codes.into_iter().peekable();
        if self.pictures == 0 {
            self.origin = codes.peek().copied().unwrap_or(0.0);
        }
        let mut codes = codes.map(|code| code - self.origin);
        for (row, pixels) in self.rows.iter_mut().zip(self.pixels.chunks_exact_mut(width)) {
            let mut sum = 0.0;
            // The codes come last: at the end of a row, none of them is lost.
            for ((pixel, column), code) in pixels.iter_mut().zip(&mut columns).zip(codes.by_ref()) {
                add(pixel, code);
                sum += code;
                *column += code;
            }
            add(row, sum / width as f64);
            all += sum;
        }
        for (column, sum) in self.columns.iter_mut().zip(columns) {
            add(column, sum / height as f64);
        }
        add(&mut self.all, all / (width * height) as f64);
        self.pictures += 1;
    }

    /// Returns the statistics of the pictures.
    ///
    /// # Panics
    /// Panics with fewer than two pictures.
    pub fn statistics(&self) -> FieldStatistics {
        let Self { pixels, rows, columns, all, pictures, origin, .. } = self;
        assert!(*pictures >= 2, "{pictures} pictures; noise shows between two");
        let (n, size) = (*pictures as f64, self.size.map(|side| side as f64));
        // Variance from picture to picture, unbiased, and its mean.
        let between = |[sum, squares]: &[f64; 2]| (squares - sum * sum / n) / (n - 1.0);
        let temporal =
            |sums: &[[f64; 2]]| sums.iter().map(between).sum::<f64>() / sums.len() as f64;
        let temporal = Variances::of(
            [temporal(pixels), temporal(rows), temporal(columns), between(all)],
            size,
        );
        let averages: Vec<f64> = pixels.iter().map(|[sum, _]| sum / n).collect();
        let spatial = patterns(&high_pass(&averages, self.size)).without(temporal, 1.0 / n);
        FieldStatistics { pictures: *pictures, mean: origin + all[0] / n, temporal, spatial }
    }
}

/// Returns the variances over a field, with what the filter takes from independent values.
fn patterns(Filtered { size: [width, height], values }: &Filtered) -> Variances {
    let mut rows = vec![0.0; *height];
    let mut columns = vec![0.0; *width];
    for (row, values) in rows.iter_mut().zip(values.chunks_exact(*width)) {
        for (column, value) in columns.iter_mut().zip(values) {
            *row += value / *width as f64;
            *column += value / *height as f64;
        }
    }
    let mean = rows.iter().sum::<f64>() / rows.len() as f64;
    let variance = |values: &[f64]| {
        values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64
    };
    let found = [variance(values), variance(&rows), variance(&columns), 0.0];
    let Variances { pixel, row, column } = Variances::of(found, [width, height].map(|&n| n as f64));
    let [of_field, of_line] = remaining_variance();
    Variances { pixel: pixel / of_field, row: row / of_line, column: column / of_line }
}

fn add([sum, squares]: &mut [f64; 2], value: f64) {
    *sum += value;
    *squares += value * value;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns codes of a position in a picture; no two are the same.
    fn code(x: usize, y: usize, picture: usize) -> f64 {
        let mix = (x * 7919 + y * 104_729 + picture * 1_299_709) % 10_007;
        mix as f64 / 10.0
    }

    #[test]
    fn statistics_are_those_of_their_definition() {
        let ([width, height], n) = ([50, 60], 5);
        let mut stack = FieldStack::new([width, height]);
        for picture in 0..n {
            stack.add((0..width * height).map(|i| code(i % width, i / width, picture)));
        }
        let found = stack.statistics();
        let at = |i: usize, picture| code(i % width, i / width, picture);
        let pixels = width * height;
        let means: Vec<f64> =
            (0..n).map(|k| (0..pixels).map(|i| at(i, k)).sum::<f64>() / pixels as f64).collect();
        let mean = means.iter().sum::<f64>() / n as f64;
        assert!((found.mean - mean).abs() < 1e-9, "{} {mean}", found.mean);
        // Deviations of a pixel from its own mean, without those of whole pictures.
        let mut temporal = 0.0;
        for i in 0..pixels {
            let own = (0..n).map(|k| at(i, k)).sum::<f64>() / n as f64;
            temporal += (0..n).map(|k| (at(i, k) - own - (means[k] - mean)).powi(2)).sum::<f64>();
        }
        temporal /= (pixels * (n - 1)) as f64;
        // The estimate is of the whole field; parts of rows and columns take a little of it.
        let total = found.temporal.total();
        assert!((total / temporal - 1.0).abs() < 1e-3, "{total} {temporal}");
    }

    #[test]
    fn rows_and_columns_are_told_from_pixels() {
        // Offsets of rows from a known set: their variance is 1.25 (rows 0 to 3, again and again).
        let size = [60, 64];
        let mut stack = FieldStack::new(size);
        for picture in 0..4 {
            // New in each picture by column: -1, 1, -1, 1 from picture to picture, alternating columns.
            let sign = |x: usize| if (x + picture).is_multiple_of(2) { 1.0 } else { -1.0 };
            stack.add((0..60 * 64).map(|i| 100.0 + (i / 60 % 4) as f64 + sign(i % 60)));
        }
        let found = stack.statistics();
        let Variances { pixel, row, column } = found.temporal;
        assert!(
            (column - 4.0 / 3.0).abs() < 0.05 && pixel.abs() < 1e-9 && row.abs() < 1e-9,
            "{found:?}"
        );
        let Variances { pixel, row, column } = found.spatial;
        let [_, of_line] = remaining_variance();
        // The filter takes nothing of so short a period.
        assert!((row - 1.25 / of_line).abs() < 0.05 && pixel.abs() < 1e-9, "{found:?}");
        assert!((column + 1.0 / 3.0).abs() < 0.05, "{found:?}");
        // The same by column, in all pictures.
        let mut stack = FieldStack::new(size);
        for _ in 0..2 {
            stack.add((0..60 * 64).map(|i| 100.0 + (i % 60 % 4) as f64));
        }
        let Variances { pixel, row, column } = stack.statistics().spatial;
        assert!((column - 1.25 / of_line).abs() < 0.05, "{column}");
        assert!(pixel.abs() < 1e-9 && row.abs() < 1e-9, "{pixel} {row}");
    }
}
