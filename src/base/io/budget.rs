//! Memory that readers claim before they allocate it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use super::{ByteSize, machine};

/// Bytes that readers may claim in all, and bytes that they have claimed.
#[derive(Debug)]
pub(super) struct MemoryBudget {
    limit: u64,
    claimed: AtomicU64,
    stopped: AtomicBool,
    /// The budget that this one is a part of. Its claims return there when it is dropped.
    whole: Option<Arc<MemoryBudget>>,
}

impl Default for MemoryBudget {
    fn default() -> Self {
        static LIMIT: OnceLock<Option<u64>> = OnceLock::new();
        Self::new(LIMIT.get_or_init(machine::limit).unwrap_or(u64::MAX))
    }
}

impl Drop for MemoryBudget {
    fn drop(&mut self) {
        if let Some(whole) = &self.whole {
            whole.release(*self.claimed.get_mut());
        }
    }
}

impl MemoryBudget {
    /// Returns a budget of so many bytes.
    pub(super) fn new(limit: u64) -> Self {
        let (claimed, stopped) = (AtomicU64::new(0), AtomicBool::new(false));
        // No allocation is larger.
        Self { limit: limit.min(isize::MAX as u64), claimed, stopped, whole: None }
    }

    /// Returns a budget for data that is dropped after use: what is left of another one.
    pub(super) fn part_of(whole: Arc<Self>) -> Self {
        let mut part = Self::new(u64::MAX);
        part.whole = Some(whole);
        part
    }

    /// Refuses all claims from now on.
    pub(super) fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Returns the budgets that hold a claim: this one, and that which it is a part of.
    fn chain(&self) -> impl Iterator<Item = &Self> {
        std::iter::successors(Some(self), |budget| budget.whole.as_deref())
    }

    /// Claims bytes, or returns an error if they are more than is left.
    pub(super) fn claim(&self, bytes: u64) -> Result<(), String> {
        if self.chain().any(|budget| budget.stopped.load(Ordering::Relaxed)) {
            return Err("reading was stopped".to_owned());
        }
        match &self.whole {
            Some(whole) => {
                whole.claim(bytes)?;
                self.claimed.fetch_add(bytes, Ordering::Relaxed);
                Ok(())
            }
            None => self.add(bytes),
        }
    }

    fn add(&self, bytes: u64) -> Result<(), String> {
        let add = |claimed: u64| claimed.checked_add(bytes).filter(|sum| *sum <= self.limit);
        let added = self.claimed.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add);
        added.map(|_| ()).map_err(|claimed| {
            let before = match claimed {
                0 => String::new(),
                _ => format!(" beside the {} read before", ByteSize(claimed)),
            };
            let limit = ByteSize(self.limit);
            format!("it takes {} of memory{before}, and there are {limit}", ByteSize(bytes))
        })
    }

    fn release(&self, bytes: u64) {
        for budget in self.chain() {
            budget.claimed.fetch_sub(bytes, Ordering::Relaxed);
        }
    }

    /// Returns the bytes that are not claimed.
    pub(super) fn left(&self) -> u64 {
        let left =
            |budget: &Self| budget.limit.saturating_sub(budget.claimed.load(Ordering::Relaxed));
        self.chain().map(left).min().unwrap_or(0)
    }
}

/// Bytes that are claimed for a time. They return to the budget when this is dropped.
#[derive(Debug)]
#[must_use]
pub struct HeldMemory {
    budget: Arc<MemoryBudget>,
    bytes: u64,
}

impl HeldMemory {
    pub(super) fn claim(budget: &Arc<MemoryBudget>, bytes: u64) -> Result<Self, String> {
        budget.claim(bytes)?;
        Ok(Self { budget: Arc::clone(budget), bytes })
    }

    /// Claims more bytes for the same time.
    pub fn add(&mut self, bytes: u64) -> Result<(), String> {
        self.budget.claim(bytes)?;
        self.bytes += bytes;
        Ok(())
    }

    /// Joins memory of the same budget that is held for the same time.
    pub fn with(mut self, mut other: Self) -> Self {
        self.bytes += std::mem::take(&mut other.bytes);
        self
    }

    /// Changes the number of bytes.
    pub fn resize(&mut self, bytes: u64) -> Result<(), String> {
        match bytes.checked_sub(self.bytes) {
            Some(more) => self.add(more),
            None => {
                self.budget.release(self.bytes - bytes);
                self.bytes = bytes;
                Ok(())
            }
        }
    }

    /// Turns so many of the bytes into a claim that lasts, and returns the others.
    pub fn keep(mut self, bytes: u64) -> Result<(), String> {
        self.resize(bytes)?;
        self.bytes = 0;
        Ok(())
    }
}

impl Drop for HeldMemory {
    fn drop(&mut self) {
        self.budget.release(self.bytes);
    }
}
