//! The rows of a lens: at least one, and exactly one of them the stop.

use std::fmt;
use std::ops::{Deref, DerefMut};

use super::error::LensError;
use super::row::Row;

/// The rows of a lens, scene side first. There is at least one row, and exactly one is the stop.
///
/// Rows can be changed through the slice, but their number and the place of the stop are fixed.
#[derive(Clone, PartialEq)]
pub struct Rows {
    rows: Vec<Row>,
    stop: usize,
}

impl Rows {
    /// Checks the rows of a lens.
    ///
    /// # Errors
    /// Returns an error if there is no row, or if not exactly one row is the stop.
    pub fn new(rows: Vec<Row>) -> Result<Self, LensError> {
        if rows.is_empty() {
            return Err(LensError::NoSurface);
        }
        let count = rows.iter().filter(|row| row.stop).count();
        match rows.iter().position(|row| row.stop) {
            Some(stop) if count == 1 => Ok(Self { rows, stop }),
            _ => Err(LensError::StopCount(count)),
        }
    }

    /// Joins the rows before the stop, the stop and the rows behind it.
    pub(crate) fn around_stop(before: Option<Row>, stop: Row, behind: Option<Row>) -> Self {
        let place = usize::from(before.is_some());
        let others = |row: Row| Row { stop: false, ..row };
        let rows = before.map(others).into_iter().chain([Row { stop: true, ..stop }]);
        Self { rows: rows.chain(behind.map(others)).collect(), stop: place }
    }

    /// Replaces every row by a function of its index; the stop stays where it is.
    pub(crate) fn map(&self, row: impl Fn(usize) -> Row) -> Self {
        let stop = self.stop;
        let rows = (0..self.rows.len()).map(|i| Row { stop: i == stop, ..row(i) }).collect();
        Self { rows, stop }
    }

    /// Returns the index of the stop.
    pub fn stop(&self) -> usize {
        self.stop
    }
}

impl Deref for Rows {
    type Target = [Row];
    fn deref(&self) -> &[Row] {
        &self.rows
    }
}

impl DerefMut for Rows {
    fn deref_mut(&mut self) -> &mut [Row] {
        &mut self.rows
    }
}

impl<'a> IntoIterator for &'a Rows {
    type Item = &'a Row;
    type IntoIter = std::slice::Iter<'a, Row>;
    fn into_iter(self) -> Self::IntoIter {
        self.rows.iter()
    }
}

impl<'a> IntoIterator for &'a mut Rows {
    type Item = &'a mut Row;
    type IntoIter = std::slice::IterMut<'a, Row>;
    fn into_iter(self) -> Self::IntoIter {
        self.rows.iter_mut()
    }
}

impl fmt::Debug for Rows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.rows.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lens_has_a_row_and_exactly_one_stop() {
        let row = |stop: bool| Row { stop, ..Row::default() };
        assert!(matches!(Rows::new(Vec::new()), Err(LensError::NoSurface)));
        assert!(matches!(Rows::new(vec![row(false)]), Err(LensError::StopCount(0))));
        assert!(matches!(Rows::new(vec![row(true); 2]), Err(LensError::StopCount(2))));
        let rows = Rows::new(vec![row(false), row(true)]).expect("one stop");
        assert_eq!((rows.len(), rows.stop()), (2, 1));
    }
}
