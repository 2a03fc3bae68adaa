//! What a picture takes of the memory, and what there is.

use std::cell::{Cell, OnceCell};

use petzval::image::Format;
use petzval::memory::{Estimate, Size, Work, budget, machine};
use petzval::render::Job;

use super::Failure;

/// The bytes that a command may hold.
pub(super) struct Memory {
    /// As asked for, or as the machine has.
    most: Option<u64>,
    asked: bool,
    /// Held when the first picture was ready, by then and at most, bytes: what the pictures before
    /// have left to the heap is not of the scene.
    held: OnceCell<[u64; 2]>,
    /// Held beside every picture of a sweep for its contact sheet, by the size of a picture.
    sheet: Option<Box<dyn Fn([u32; 2]) -> u64>>,
    /// Whether it was said that little is free.
    warned: Cell<bool>,
}

impl Memory {
    /// Of this option. What is read from now on is refused where it declares more.
    pub fn new(asked: Option<Size>) -> Self {
        let most = asked.map(|size| size.0).or_else(machine::whole);
        budget::allow(most.unwrap_or(u64::MAX));
        let (held, warned) = (OnceCell::new(), Cell::new(false));
        Self { most, asked: asked.is_some(), held, sheet: None, warned }
    }

    /// With a contact sheet beside the pictures, of so many bytes for pictures of a size, pixels.
    pub fn with_sheet(self, bytes: impl Fn([u32; 2]) -> u64 + 'static) -> Self {
        Self { sheet: Some(Box::new(bytes)), ..self }
    }

    /// Refuses a job that takes more, and answers what it takes.
    pub fn check(
        &self,
        job: &Job,
        work: Work,
        format: Option<Format>,
    ) -> Result<Estimate, Failure> {
        let held = *self.held.get_or_init(machine::held);
        let mut estimate = Estimate::new(job, held, work, format);
        if let Some(sheet) = &self.sheet {
            estimate = estimate.beside("contact sheet", sheet(job.frame.size()));
        }
        let bytes = estimate.bytes();
        if let Some(most) = self.most.filter(|most| bytes > *most) {
            let (most, whose) = match self.asked {
                true => (Size(most), "--memory allows"),
                false => (Size(most), "this machine, or the group that limits the process, has"),
            };
            let less = less(job, work);
            return Err(format!("this takes {estimate}, and {whose} {most}; {less}").into());
        }
        if let Some(free) =
            machine::free().filter(|&free| !self.asked && bytes.saturating_sub(held[0]) > free)
        {
            if self.warned.replace(true) {
                return Ok(estimate);
            }
            let free = Size(free);
            say!("petzval: warning: this takes {estimate}, and {free} are free by now");
        }
        Ok(estimate)
    }
}

/// What would take less.
fn less(job: &Job, work: Work) -> String {
    let mut less = vec!["a smaller --resolution", "parts of the picture by --crop"];
    if !job.layers.is_empty() {
        less.push("fewer layers");
    }
    if !job.until.count_only() {
        less.push("--spp instead of --noise and --time");
    }
    if job.plan.has(petzval::plan::Effect::Diffraction) {
        less.push("--effects -diffraction");
    }
    if matches!(work, Work::Render { threads } if threads > 8) {
        less.push("fewer --threads");
    }
    match work {
        Work::Render { .. } => format!("less would be taken by {}", less.join(", ")),
        Work::Merge => "merge on a larger machine, or render with less next time".to_owned(),
    }
}

/// What it took in the end, beside what was expected.
pub(super) fn say_taken(estimate: &Estimate) {
    match machine::held() {
        [_, 0] => say!("memory: expected was {estimate}"),
        [_, most] => say!("memory: {} at most; expected was {estimate}", Size(most)),
    }
}
