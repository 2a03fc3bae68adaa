//! What a picture takes of the memory, and what there is.

use petzval::image::Format;
use petzval::memory::{Estimate, Size, Work, budget, machine};
use petzval::render::Job;

use super::Failure;

/// The bytes that a command may hold.
pub(super) struct Memory {
    /// As asked for, or as the machine has.
    most: Option<u64>,
    asked: bool,
}

impl Memory {
    /// Of this option. What is read from now on is refused where it declares more.
    pub fn new(asked: Option<Size>) -> Self {
        let most = asked.map(|size| size.0).or_else(machine::whole);
        budget::allow(most.unwrap_or(u64::MAX));
        Self { most, asked: asked.is_some() }
    }

    /// Refuses a job that takes more, and answers what it takes.
    pub fn check(
        &self,
        job: &Job,
        work: Work,
        format: Option<Format>,
    ) -> Result<Estimate, Failure> {
        let held = machine::held();
        let estimate = Estimate::new(job, held, work, format);
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
