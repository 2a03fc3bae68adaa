//! Colours of all pixels from a mosaic of filters: Menon, Andriani & Calvagno, "Demosaicing with directional filtering
//! and a posteriori decision" (IEEE Transactions on Image Processing 16, 2007).
//!
//! Green is interpolated along rows and along columns. Each pixel keeps the direction along which the differences of
//! colours vary less. Red and blue follow from their differences to green. No kept crate has a method of this quality
//! under our licences.

use rayon::prelude::*;

use super::DevelopError;

/// Least width and height of a mosaic (pixels).
const LEAST: usize = 4;
/// Steps along the row and along the column.
const DIRECTIONS: [[isize; 2]; 2] = [[1, 0], [0, 1]];

/// Values of the pixels of a mosaic, which its borders mirror.
#[derive(Clone, Copy)]
struct Plane<'a, T> {
    size: [usize; 2],
    values: &'a [T],
}

impl<T: Copy> Plane<'_, T> {
    /// Returns the value at a column and a row, up to two pixels beyond the border. The mirrored pixel has the same
    /// filter.
    #[inline(always)]
    fn at(&self, x: isize, y: isize) -> T {
        let [width, height] = self.size;
        self.values[mirrored(y, height) * width + mirrored(x, width)]
    }
}

#[inline(always)]
fn mirrored(i: isize, n: usize) -> usize {
    let last = n as isize - 1;
    let i = i.abs();
    (if i > last { 2 * last - i } else { i }) as usize
}

/// Computes a value for each pixel.
fn map_pixels<T: Copy + Default + Send>(
    [width, height]: [usize; 2],
    of: impl Fn(isize, isize) -> T + Sync,
) -> Vec<T> {
    let mut values = vec![T::default(); width * height];
    values.par_chunks_exact_mut(width).enumerate().for_each(|(y, row)| {
        for (x, value) in row.iter_mut().enumerate() {
            *value = of(x as isize, y as isize);
        }
    });
    values
}

/// Checks that the colours of a mosaic can be interpolated. The filters are those of the first two by two pixels, in
/// reading order: 0 red, 1 green, 2 blue.
///
/// # Errors
/// Returns an error if the mosaic is smaller than four by four pixels, or green is not on a diagonal.
pub(super) fn check([width, height]: [usize; 2], filters: [u8; 4]) -> Result<(), DevelopError> {
    if width.min(height) < LEAST {
        return Err(DevelopError::Small { width, height });
    }
    match filters {
        [1, 0, 2, 1] | [1, 2, 0, 1] | [0, 1, 1, 2] | [2, 1, 1, 0] => Ok(()),
        _ => Err(DevelopError::Filters { filters }),
    }
}

/// Returns linear colours of all pixels of a mosaic that [`check`] accepts.
pub(super) fn demosaic(size: [usize; 2], mosaic: &[f32], filters: [u8; 4]) -> Vec<[f32; 3]> {
    let filter = |x: isize, y: isize| usize::from(filters[((y & 1) * 2 + (x & 1)) as usize]);
    let mosaic = Plane { size, values: mosaic };

    // Differences of the other colour to green, as interpolated along the row and along the column.
    let [across, down] = DIRECTIONS.map(|[dx, dy]| {
        map_pixels(size, |x, y| {
            if filter(x, y) == 1 {
                return 0.0;
            }
            let at = |n: isize| mosaic.at(x + n * dx, y + n * dy);
            let green = (at(-1) + at(1)) / 2.0 + (2.0 * at(0) - at(-2) - at(2)) / 4.0;
            at(0) - green
        })
    });
    let [across, down] = [&across, &down].map(|values| Plane { size, values: &values[..] });
    let is_across = map_pixels(size, |x, y| {
        // Pixels behind green filters need no direction.
        filter(x, y) == 1
            || variation(across, [x, y], DIRECTIONS[0]) <= variation(down, [x, y], DIRECTIONS[1])
    });
    let green = map_pixels(size, |x, y| {
        let i = y as usize * size[0] + x as usize;
        mosaic.values[i] - if is_across[i] { across.values[i] } else { down.values[i] }
    });
    let green = Plane { size, values: &green };

    let mean_difference = |x: isize, y: isize, [dx, dy]: [isize; 2]| {
        let difference = |x, y| mosaic.at(x, y) - green.at(x, y);
        (difference(x - dx, y - dy) + difference(x + dx, y + dy)) / 2.0
    };
    // At a green filter, one colour is beside it and the other above and below.
    let at_green = |x: isize, y: isize| {
        let mut colours = [green.at(x, y); 3];
        for [dx, dy] in DIRECTIONS {
            colours[filter(x + dx, y + dy)] += mean_difference(x, y, [dx, dy]);
        }
        colours
    };
    // The refinement of the paper's section III is left out: it does not pay (python/benches/demosaic.py).
    map_pixels(size, |x, y| {
        let filtered = filter(x, y);
        if filtered == 1 {
            return at_green(x, y);
        }
        let [dx, dy] = DIRECTIONS[usize::from(!is_across[y as usize * size[0] + x as usize])];
        let other = 2 - filtered;
        let difference = |x: isize, y: isize| {
            let [x, y] = [mirrored(x, size[0]) as isize, mirrored(y, size[1]) as isize];
            let colours = at_green(x, y);
            colours[other] - colours[filtered]
        };
        let mean = (difference(x - dx, y - dy) + difference(x + dx, y + dy)) / 2.0;
        let value = mosaic.at(x, y);
        let mut colours = [green.at(x, y); 3];
        (colours[filtered], colours[other]) = (value, value + mean);
        colours
    })
}

/// Returns how much the differences of colours vary along a direction, within five by five pixels.
#[inline(always)]
fn variation(difference: Plane<'_, f32>, [x, y]: [isize; 2], [dx, dy]: [isize; 2]) -> f32 {
    // From a pixel `along` the direction and `beside` it to the next of the same filter.
    let step = |along: isize, beside: isize| {
        let at = |along| difference.at(x + along * dx + beside * dy, y + along * dy + beside * dx);
        (at(along) - at(along + 2)).abs()
    };
    let of_line = |beside| step(-2, beside) + step(0, beside);
    3.0 * of_line(0) + of_line(-2) + of_line(2) + step(-1, -1) + step(-1, 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATTERNS: [[u8; 4]; 4] = [[0, 1, 1, 2], [2, 1, 1, 0], [1, 0, 2, 1], [1, 2, 0, 1]];

    fn mosaic_of(
        size: [usize; 2],
        filters: [u8; 4],
        of: impl Fn(f32, f32) -> [f32; 3],
    ) -> Vec<f32> {
        (0..size[0] * size[1])
            .map(|i| {
                let [x, y] = [i % size[0], i / size[0]];
                of(x as f32, y as f32)[usize::from(filters[(y & 1) * 2 + (x & 1)])]
            })
            .collect()
    }

    /// Returns the largest error of pixels that are this far from the border.
    fn largest_error(
        size: [usize; 2],
        border: usize,
        filters: [u8; 4],
        of: impl Fn(f32, f32) -> [f32; 3],
    ) -> f32 {
        let found = demosaic(size, &mosaic_of(size, filters, &of), filters);
        let inside = |i: usize| {
            let at = [i % size[0], i / size[0]];
            (0..2).all(|k| at[k] >= border && at[k] + border < size[k])
        };
        let error = |i: usize| {
            let expected = of((i % size[0]) as f32, (i / size[0]) as f32);
            (0..3).map(|c| (found[i][c] - expected[c]).abs()).fold(0.0, f32::max)
        };
        (0..found.len()).filter(|&i| inside(i)).map(error).fold(0.0, f32::max)
    }

    #[test]
    fn even_colours_and_ramps_are_exact_in_every_phase_and_size() {
        for filters in PATTERNS {
            for size in [[4, 4], [5, 4], [7, 9], [16, 11]] {
                let even = largest_error(size, 0, filters, |_, _| [0.7, 0.2, 0.4]);
                assert!(even < 1e-6, "{filters:?} {size:?}: {even}");
            }
            let ramp = |x: f32, y: f32| [0.3 + 0.01 * x - 0.02 * y, 0.2 + 0.01 * x, 0.5 - 0.02 * y];
            let off = largest_error([30, 21], 5, filters, ramp);
            assert!(off < 1e-5, "{filters:?}: {off}");
        }
    }

    #[test]
    fn fine_grey_lines_stay_grey() {
        // They are finer than a mosaic samples red and blue: only the choice of the direction saves them.
        for filters in PATTERNS {
            let rows = |_: f32, y: f32| [if y % 3.0 == 0.0 { 0.8 } else { 0.1 }; 3];
            let off = largest_error([24, 24], 5, filters, rows);
            assert!(off < 1e-5, "rows, {filters:?}: {off}");
            let columns = |x: f32, y: f32| rows(y, x);
            let off = largest_error([24, 24], 5, filters, columns);
            assert!(off < 1e-5, "columns, {filters:?}: {off}");
        }
    }

    #[test]
    fn detail_of_all_colours_sharpens_green() {
        let wave = |x: f32, y: f32| [0.5 + 0.3 * (0.9 * x + 0.8 * y).sin(); 3];
        let off = largest_error([40, 40], 5, PATTERNS[0], wave);
        // Without the second difference of the other colour it is 0.091.
        assert!(off < 0.075, "{off}");
    }

    #[test]
    fn a_turned_mosaic_gives_the_turned_picture() {
        let size = [19, 17];
        let of = |x: f32, y: f32| {
            let wave = (0.9 * x + 0.4 * y).sin() * (0.3 * x - 0.7 * y).cos();
            [0.5 + 0.3 * wave, 0.5 + 0.4 * wave, 0.4 + 0.2 * (0.5 * x).sin()]
        };
        let found = demosaic(size, &mosaic_of(size, PATTERNS[0], of), PATTERNS[0]);
        let turned = [size[1], size[0]];
        let other = mosaic_of(turned, PATTERNS[0], |x, y| of(y, x));
        let other = demosaic(turned, &other, PATTERNS[0]);
        // Where both directions vary alike, rows are chosen: a few pixels may differ.
        let differs = |i: usize| {
            let (a, b) = (found[i], other[i % size[0] * turned[0] + i / size[0]]);
            (0..3).any(|c| (a[c] - b[c]).abs() > 1e-6)
        };
        let count = (0..found.len()).filter(|&i| differs(i)).count();
        assert!(count * 50 < found.len(), "{count} of {}", found.len());
    }

    #[test]
    fn small_and_other_mosaics_are_refused() {
        assert_eq!(check([3, 8], PATTERNS[0]), Err(DevelopError::Small { width: 3, height: 8 }));
        assert!(check([4, 4], [0, 1, 2, 1]).unwrap_err().to_string().contains("Bayer"));
        assert!(PATTERNS.iter().all(|&filters| check([4, 4], filters).is_ok()));
    }
}
