//! Samples that were dropped because their light is not finite.

use std::io;

use super::Tile;
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter, invalid_data};

/// Identity of a sample of a picture. It determines all random numbers of the sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SampleId {
    /// Row of the pixel in the whole picture. It comes first, so that samples sort row by row.
    row: u32,
    column: u32,
    /// Index of the sample in its pixel.
    pub sample: u32,
    /// Seed of its random numbers. In an adaptive render it differs from the job's seed.
    pub seed: u32,
}

impl SampleId {
    /// A sample of the pixel (x, y) of the whole picture.
    pub fn new([column, row]: [u32; 2], sample: u32, seed: u32) -> Self {
        Self { row, column, sample, seed }
    }

    /// Returns the pixel (x, y) in the whole picture.
    pub fn pixel(&self) -> [u32; 2] {
        [self.column, self.row]
    }
}

/// Samples that were not finite and were left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DroppedSamples {
    count: u64,
    first: Vec<SampleId>,
}

impl DroppedSamples {
    /// Largest number of samples that are listed.
    pub const MAX_LISTED: usize = 8;

    /// Returns the number of dropped samples.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Returns the first of them, row by row of the picture, whatever the order in which they were
    /// recorded.
    pub fn first(&self) -> &[SampleId] {
        &self.first
    }

    /// Records a dropped sample.
    #[cold]
    #[inline(never)]
    pub fn record(&mut self, sample: SampleId) {
        self.count += 1;
        self.insert(sample);
    }

    /// Adds samples that were recorded elsewhere.
    pub fn add(&mut self, other: &Self) {
        self.count = self.count.saturating_add(other.count);
        other.first.iter().for_each(|&sample| self.insert(sample));
    }

    fn insert(&mut self, sample: SampleId) {
        let index = self.first.partition_point(|other| *other < sample);
        if index < Self::MAX_LISTED {
            self.first.truncate(Self::MAX_LISTED - 1);
            self.first.insert(index, sample);
        }
    }

    pub(super) fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.u64(self.count)?;
        to.u32(self.first.len() as u32)?;
        let mut numbers = self.first.iter().flat_map(|id| [id.column, id.row, id.sample, id.seed]);
        numbers.try_for_each(|number| to.u32(number))
    }

    /// Adds the saved samples of a tile.
    pub(super) fn receive(&mut self, from: &mut ChecksumReader, tile: &Tile) -> io::Result<()> {
        let mut saved = Self { count: from.count()?, first: Vec::new() };
        for _ in 0..from.below(Self::MAX_LISTED + 1, "names of samples")? {
            let [x, y, sample, seed] = [from.u32()?, from.u32()?, from.u32()?, from.u32()?];
            let inside = |p: u32, i: usize| p >= tile.low[i] && p - tile.low[i] < tile.size[i];
            if !(inside(x, 0) && inside(y, 1)) {
                return Err(invalid_data("it is damaged: it names a sample of another tile"));
            }
            saved.insert(SampleId::new([x, y], sample, seed));
        }
        if saved.first.len() as u64 > saved.count {
            return Err(invalid_data("it is damaged: it names more samples than it counts"));
        }
        self.add(&saved);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::sampler::hash;

    #[test]
    fn the_first_samples_are_listed_in_whatever_order_they_are_recorded() {
        let all: Vec<SampleId> = (0..100)
            .map(|i| SampleId::new([hash(i) % 7, hash(i + 1) % 5], i, hash(i + 2) % 3))
            .collect();
        let counted = |parts: usize, backwards: bool| {
            let mut parts = vec![DroppedSamples::default(); parts];
            let count = parts.len();
            all.iter().enumerate().for_each(|(i, &sample)| parts[i % count].record(sample));
            if backwards {
                parts.reverse();
            }
            let mut sum = DroppedSamples::default();
            parts.iter().for_each(|part| sum.add(part));
            sum
        };
        let mut sorted = all.clone();
        sorted.sort_by_key(|id| ([id.pixel()[1], id.pixel()[0]], id.sample, id.seed));
        let whole = counted(1, false);
        assert_eq!((whole.count(), whole.first()), (100, &sorted[..DroppedSamples::MAX_LISTED]));
        assert_eq!(whole, counted(3, false));
        assert_eq!(whole, counted(30, true));
    }
}
