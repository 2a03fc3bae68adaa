//! Shares of the work that are done while others are not.

use std::io;
use std::sync::OnceLock;

use super::keeper::Received;
use super::{Job, Share};
use crate::aov::Features;
use crate::checkpoint::{Reader, Writer};

/// What the shares of the present step have received, as far as they are done. Workers enter
/// theirs while others read what is there.
#[derive(Default)]
pub(super) struct Ledger(Vec<OnceLock<Received>>);

impl Ledger {
    /// Makes room for so many shares; those that are entered stay.
    pub fn open(&mut self, shares: usize) {
        self.0.resize_with(shares, OnceLock::new);
    }

    /// Whether a share is done.
    pub fn has(&self, share: usize) -> bool {
        self.0[share].get().is_some()
    }

    /// Enters what a share has received.
    pub fn enter(&self, share: usize, received: Received) {
        self.0[share].get_or_init(|| received);
    }

    /// The shares that are done, by number.
    pub fn done(&self) -> impl Iterator<Item = (usize, &Received)> {
        self.0.iter().enumerate().filter_map(|(i, place)| Some((i, place.get()?)))
    }

    /// What all shares have received, in their order, if all are done; the ledger is empty then.
    pub fn settle(&mut self) -> Option<impl Iterator<Item = Received>> {
        let done = self.0.iter().all(|place| place.get().is_some());
        done.then(|| std::mem::take(&mut self.0).into_iter().filter_map(OnceLock::into_inner))
    }

    pub fn save(&self, to: &mut Writer) -> io::Result<()> {
        // Others may be entered meanwhile.
        let done: Vec<(usize, &Received)> = self.done().collect();
        to.u32(done.len() as u32)?;
        for (i, (sums, features)) in done {
            to.u32(i as u32)?;
            sums.save(to)?;
            features.iter().try_for_each(|features| features.save(to))?;
        }
        Ok(())
    }

    /// Reads what is done of these shares.
    pub fn receive(&mut self, from: &mut Reader, job: &Job, shares: &[Share]) -> io::Result<()> {
        self.open(shares.len());
        for _ in 0..from.below(shares.len() + 1, "shares")? {
            let i = from.below(shares.len(), "share")?;
            let mut sums = shares[i].sums(job);
            let mut features = Features::new(job, &shares[i].tile);
            sums.receive(from)?;
            features.iter_mut().try_for_each(|features| features.receive(from))?;
            self.0[i] = OnceLock::from((sums, features));
        }
        Ok(())
    }
}
