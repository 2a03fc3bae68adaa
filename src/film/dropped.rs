//! Samples that are no numbers.

use std::io;

use super::Tile;
use crate::checkpoint::{Reader, Writer, wrong};

/// A sample of a picture: all its random choices follow from this.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SampleName {
    /// Row and column of its pixel in the whole picture, so that samples are in its order.
    row: u32,
    column: u32,
    /// Its number among those of the pixel.
    pub sample: u32,
    /// Of its random numbers. Where tiles take as many samples as they need, this is not the seed
    /// of the job.
    pub seed: u32,
}

impl SampleName {
    /// A sample of the pixel with these coordinates, x and y, in the whole picture.
    pub fn new([column, row]: [u32; 2], sample: u32, seed: u32) -> Self {
        Self { row, column, sample, seed }
    }

    /// Its pixel, x and y in the whole picture.
    pub fn pixel(&self) -> [u32; 2] {
        [self.column, self.row]
    }
}

/// Samples that were not finite and were left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    count: u64,
    first: Vec<SampleName>,
}

impl Dropped {
    /// So many are named.
    pub const NAMED: usize = 8;

    /// How many they are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The first of them, row by row of the picture: the same whoever counted them in which order.
    pub fn first(&self) -> &[SampleName] {
        &self.first
    }

    /// Counts one more.
    #[cold]
    #[inline(never)]
    pub fn note(&mut self, name: SampleName) {
        self.count += 1;
        self.enter(name);
    }

    /// Adds what was counted elsewhere.
    pub fn add(&mut self, other: &Self) {
        self.count = self.count.saturating_add(other.count);
        other.first.iter().for_each(|&name| self.enter(name));
    }

    fn enter(&mut self, name: SampleName) {
        let place = self.first.partition_point(|other| *other < name);
        if place < Self::NAMED {
            self.first.truncate(Self::NAMED - 1);
            self.first.insert(place, name);
        }
    }

    pub(super) fn save(&self, to: &mut Writer) -> io::Result<()> {
        to.u64(self.count)?;
        to.u32(self.first.len() as u32)?;
        let mut numbers =
            self.first.iter().flat_map(|name| [name.column, name.row, name.sample, name.seed]);
        numbers.try_for_each(|number| to.u32(number))
    }

    /// Adds what was saved of a tile.
    pub(super) fn receive(&mut self, from: &mut Reader, tile: &Tile) -> io::Result<()> {
        let mut saved = Self { count: from.count()?, first: Vec::new() };
        for _ in 0..from.below(Self::NAMED + 1, "names of samples")? {
            let [x, y, sample, seed] = [from.u32()?, from.u32()?, from.u32()?, from.u32()?];
            let inside = |p: u32, i: usize| p >= tile.low[i] && p - tile.low[i] < tile.size[i];
            if !(inside(x, 0) && inside(y, 1)) {
                return Err(wrong("it is damaged: it names a sample of another tile"));
            }
            saved.enter(SampleName::new([x, y], sample, seed));
        }
        if saved.first.len() as u64 > saved.count {
            return Err(wrong("it is damaged: it names more samples than it counts"));
        }
        self.add(&saved);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::hash;

    #[test]
    fn the_first_are_named_whoever_counts_them() {
        let all: Vec<SampleName> = (0..100)
            .map(|i| SampleName::new([hash(i) % 7, hash(i + 1) % 5], i, hash(i + 2) % 3))
            .collect();
        let counted = |parts: usize, backwards: bool| {
            let mut parts = vec![Dropped::default(); parts];
            let count = parts.len();
            all.iter().enumerate().for_each(|(i, &name)| parts[i % count].note(name));
            if backwards {
                parts.reverse();
            }
            let mut sum = Dropped::default();
            parts.iter().for_each(|part| sum.add(part));
            sum
        };
        let mut sorted = all.clone();
        sorted.sort_by_key(|name| ([name.pixel()[1], name.pixel()[0]], name.sample, name.seed));
        let whole = counted(1, false);
        assert_eq!((whole.count(), whole.first()), (100, &sorted[..Dropped::NAMED]));
        assert_eq!(whole, counted(3, false));
        assert_eq!(whole, counted(30, true));
    }
}
