//! Results of completed work items, kept until all items of a round are complete.

use std::io;
use std::sync::OnceLock;

use crate::aov::TileFeatures;
use crate::job::Job;
use crate::wave::{TileResult, WorkItem};
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};

/// Results of the work items of a round, by number. Workers insert results while others are read.
#[derive(Default)]
pub(super) struct CompletedItems(Vec<OnceLock<TileResult>>);

impl CompletedItems {
    /// Makes room for so many items. Results that are there stay.
    pub fn resize(&mut self, items: usize) {
        self.0.resize_with(items, OnceLock::new);
    }

    pub fn contains(&self, item: usize) -> bool {
        self.0[item].get().is_some()
    }

    pub fn insert(&self, item: usize, result: TileResult) {
        self.0[item].get_or_init(|| result);
    }

    /// Returns the results that are there, with their numbers.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &TileResult)> {
        self.0.iter().enumerate().filter_map(|(i, result)| Some((i, result.get()?)))
    }

    /// Takes the results of all items, in order; `None` if one is missing.
    pub fn take_all(&mut self) -> Option<impl Iterator<Item = TileResult>> {
        let complete = self.0.iter().all(|result| result.get().is_some());
        complete.then(|| std::mem::take(&mut self.0).into_iter().filter_map(OnceLock::into_inner))
    }

    pub fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        // Workers may insert more results meanwhile, so the list is fixed before its length is written.
        let done: Vec<(usize, &TileResult)> = self.iter().collect();
        to.u32(done.len() as u32)?;
        for (i, TileResult { sums, features }) in done {
            to.u32(i as u32)?;
            sums.save(to)?;
            features.iter().try_for_each(|features| features.save(to))?;
        }
        Ok(())
    }

    /// Reads the saved results of these work items.
    pub fn load(
        &mut self,
        from: &mut ChecksumReader,
        job: &Job,
        items: &[WorkItem],
    ) -> io::Result<()> {
        self.resize(items.len());
        for _ in 0..from.below(items.len() + 1, "shares")? {
            let i = from.below(items.len(), "share")?;
            let mut sums = items[i].sums(job);
            let mut features = TileFeatures::new(&job.layer_request(), &items[i].tile);
            sums.receive(from)?;
            features.iter_mut().try_for_each(|features| features.receive(from))?;
            self.0[i] = OnceLock::from(TileResult { sums, features });
        }
        Ok(())
    }
}
