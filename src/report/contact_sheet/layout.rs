//! Places of the pictures on a contact sheet.

/// Type size [px].
pub(super) const TYPE: f64 = 15.0;
/// Distance between pictures, and margin of the sheet [px].
pub(super) const GAP: usize = 14;
/// Candidates for the longer side of a picture, the largest first [px].
const SIDES: [f64; 6] = [360.0, 300.0, 250.0, 200.0, 160.0, 120.0];
/// Least shorter side of a picture, and least width for the text above or below it [px].
const MIN_WIDTHS: [usize; 2] = [24, 110];
/// Largest side of the sheet [px].
const MAX_SIDE: usize = 3200;
/// Preferred width over height of a sheet whose pictures flow in rows.
const ASPECT: f64 = 1.5;

/// A grid of places [px].
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    /// Width and height of the sheet.
    pub sheet: [usize; 2],
    /// Width and height of a picture's place.
    pub cell: [usize; 2],
    /// Rows and columns.
    pub grid: [usize; 2],
    /// Upper left corner of the first place.
    origin: [usize; 2],
    /// Distance from each place to the next.
    pitch: [usize; 2],
    /// Rows and columns of all pictures, shown or not; one row if pictures flow.
    wanted: [usize; 2],
}

impl Layout {
    /// Lays out pictures of this size, with `counts` values of each option. With two options, text
    /// of width `edge` stands at the left.
    pub fn new(counts: &[usize], size: [f64; 2], edge: f64) -> Self {
        let table = counts.len() == 2;
        let wanted = match *counts {
            [rows, columns] => [rows, columns],
            _ => [1, counts.iter().product()],
        };
        let line = (1.2 * TYPE) as usize;
        let above = 2 * GAP + 2 * line + if table { line } else { 0 };
        let origin = [GAP + if table { edge.ceil() as usize + GAP } else { 0 }, above];
        let beneath = if table { 0 } else { line * counts.len() };
        let sized = |side: f64| {
            let scale = side / size[0].max(size[1]);
            let cell = size.map(|n| ((n * scale) as usize).max(MIN_WIDTHS[0]));
            let pitch = [cell[0].max(MIN_WIDTHS[1]) + GAP, cell[1] + beneath + GAP];
            let room =
                [0, 1].map(|i| (MAX_SIDE.saturating_sub(origin[i] + 2 * line) / pitch[i]).max(1));
            let grid = match table {
                true => wanted,
                false => flow(wanted[1], pitch),
            };
            let fits = grid[0] <= room[1] && grid[1] <= room[0];
            let grid = match table || fits {
                true => [grid[0].min(room[1]), grid[1].min(room[0])],
                false => [room[1], room[0]],
            };
            let extent = [grid[1] * pitch[0], grid[0] * pitch[1]];
            let sheet = [origin[0] + extent[0], origin[1] + extent[1] + line];
            (fits, Self { sheet, cell, grid, origin, pitch, wanted })
        };
        let mut all = SIDES.iter().map(|&side| sized(side));
        let smallest = sized(SIDES[SIDES.len() - 1]).1;
        all.find(|(fits, _)| *fits).map_or(smallest, |(_, layout)| layout)
    }

    /// Returns the place of a picture, if it has one.
    pub fn place(&self, number: usize) -> Option<usize> {
        let [rows, columns] = self.grid;
        if self.wanted[0] == 1 && rows > 1 {
            return (number < rows * columns).then_some(number);
        }
        let [row, column] = [number / self.wanted[1], number % self.wanted[1]];
        (row < rows && column < columns).then_some(row * columns + column)
    }

    /// Returns the pictures that have places, in the order of the places.
    pub fn numbers(&self) -> impl Iterator<Item = usize> + '_ {
        let all = self.wanted[0] * self.wanted[1];
        (0..all).filter(|&number| self.place(number).is_some())
    }

    /// Returns the upper left corner of a place.
    pub fn corner(&self, place: usize) -> [usize; 2] {
        let [row, column] = [place / self.grid[1], place % self.grid[1]];
        [self.origin[0] + column * self.pitch[0], self.origin[1] + row * self.pitch[1]]
    }
}

/// Returns rows and columns for this many places: near the preferred aspect, with the fewest places
/// left empty.
fn flow(count: usize, pitch: [usize; 2]) -> [usize; 2] {
    let [width, height] = pitch.map(|n| n as f64);
    let ideal = (count as f64 * ASPECT * height / width).sqrt().ceil().max(1.0) as usize;
    let columns = (ideal..ideal + 1 + ideal.div_ceil(3)).map(|columns| columns.min(count));
    let left = |&columns: &usize| count.div_ceil(columns) * columns - count;
    let columns = columns.min_by_key(left).unwrap_or(1);
    [count.div_ceil(columns), columns]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_and_columns_are_those_of_two_options() {
        let layout = Layout::new(&[3, 4], [600.0, 400.0], 50.0);
        assert_eq!((layout.grid, layout.cell), ([3, 4], [360, 240]));
        assert_eq!(layout.place(5), Some(5));
        let [first, below] = [layout.corner(1), layout.corner(5)];
        assert!(first[0] == below[0] && first[1] + 240 < below[1], "{first:?} {below:?}");
    }

    #[test]
    fn flowing_pictures_fill_their_rows() {
        for (count, grid) in [(1, [1, 1]), (2, [1, 2]), (8, [2, 4]), (12, [3, 4]), (7, [2, 4])] {
            assert_eq!(Layout::new(&[count], [600.0, 400.0], 0.0).grid, grid, "{count}");
        }
    }

    #[test]
    fn a_sheet_is_bounded_and_its_places_lie_in_it() {
        for counts in
            [vec![100_000], vec![10, 10_000], vec![10_000, 10], vec![9, 9, 9, 9], vec![1, 1]]
        {
            for size in [[600.0, 400.0], [1.0, 65536.0], [65536.0, 1.0]] {
                let layout = Layout::new(&counts, size, 100.0);
                assert!(layout.sheet.iter().all(|&n| n <= MAX_SIDE), "{counts:?}: {layout:?}");
                let places: Vec<usize> = layout.numbers().filter_map(|n| layout.place(n)).collect();
                assert!(places.windows(2).all(|pair| pair[0] < pair[1]), "{counts:?}");
                for place in places {
                    let corner = layout.corner(place);
                    assert!((0..2).all(|i| corner[i] + layout.cell[i] <= layout.sheet[i]));
                }
            }
        }
    }
}
