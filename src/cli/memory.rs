//! Memory limit of a command: budget of its readers, and check of what a picture takes.

use std::cell::{Cell, OnceCell};

use petzval_base::io::machine::ResidentMemory;
use petzval_base::io::{ByteSize, ReadContext};
use petzval_image::ImageFormat;
use petzval_render::ProgressiveRender;
use petzval_render::job::Job;
use petzval_render::memory::{Estimate, MemoryTask, machine};

use super::Failure;
use super::screen::is_verbose;

/// Memory limit of a command.
pub(super) struct Memory {
    /// The limit: --memory, or the memory of the machine (bytes).
    most: Option<u64>,
    /// Whether --memory is given.
    asked: bool,
    /// Budget and log of the readers.
    context: ReadContext,
    /// Memory held when the first picture was ready, and the peak until then (bytes). Later
    /// pictures of a sweep must not count what earlier ones left on the heap as the scene's.
    resident: OnceCell<ResidentMemory>,
    /// Memory of a sweep's contact sheet, as a function of the pictures' size (bytes).
    sheet: Option<Box<dyn Fn([u32; 2]) -> u64>>,
    /// Whether the warning of too little free memory was printed.
    warned: Cell<bool>,
}

impl Memory {
    /// Creates the limit from the option.
    pub fn new(asked: Option<ByteSize>) -> Self {
        let most = asked.map(|size| size.0).or_else(machine::limit);
        let context = ReadContext::with_memory(most.unwrap_or(u64::MAX));
        let (resident, warned) = (OnceCell::new(), Cell::new(false));
        Self { most, asked: asked.is_some(), context, resident, sheet: None, warned }
    }

    /// Returns the context of this command's readers.
    pub fn context(&self) -> &ReadContext {
        &self.context
    }

    /// Adds a contact sheet whose memory depends on the pictures' size (pixels).
    pub fn with_sheet(self, bytes: impl Fn([u32; 2]) -> u64 + 'static) -> Self {
        Self { sheet: Some(Box::new(bytes)), ..self }
    }

    /// Returns the expected memory of a job, with `denoising` bytes if its picture is denoised.
    ///
    /// # Errors
    /// Returns an error if it exceeds the limit.
    pub fn check(
        &self,
        job: &Job,
        work: MemoryTask,
        format: Option<ImageFormat>,
        denoising: Option<u64>,
    ) -> Result<Estimate, Failure> {
        let resident = *self.resident.get_or_init(machine::resident);
        let mut estimate = Estimate::new(job, resident, work, format);
        if let Some(sheet) = &self.sheet {
            estimate = estimate.with_extra("contact sheet", sheet(job.frame.size()));
        }
        if let Some(bytes) = denoising {
            estimate = estimate.with_extra("denoising", bytes);
        }
        self.require(&estimate, job, work)?;
        let bytes = estimate.bytes();
        if let Some(free) = machine::available()
            .filter(|&free| !self.asked && bytes.saturating_sub(resident.now) > free)
        {
            if self.warned.replace(true) {
                return Ok(estimate);
            }
            let free = ByteSize(free);
            say!("petzval: warning: this takes {estimate}, and only {free} are free now");
        }
        Ok(estimate)
    }

    /// Checks a job whose picture is shown while it is refined, with `shown` bytes for a pixel of what
    /// shows it.
    ///
    /// # Errors
    /// Returns an error if its expected memory exceeds the limit, or what is free now.
    pub fn check_shown(&self, job: &Job, threads: usize, shown: u64) -> Result<(), Failure> {
        let resident = *self.resident.get_or_init(machine::resident);
        let work = MemoryTask::Render { threads };
        let pixels: u64 = job.frame.size().map(u64::from).iter().product();
        let estimate = Estimate::new(job, resident, work, None)
            .with_extra("pictures that are shown", ProgressiveRender::bytes(job) + pixels * shown);
        self.require(&estimate, job, work)?;
        let now = machine::resident().now;
        let free = machine::available().filter(|free| estimate.bytes() > now + free);
        free.map_or(Ok(()), |free| {
            let (free, suggestions) = (ByteSize(free), suggestions(job, work));
            Err(format!("this takes {estimate}, and only {free} are free now; {suggestions}")
                .into())
        })
    }

    /// Returns an error if an estimate exceeds the limit.
    fn require(&self, estimate: &Estimate, job: &Job, work: MemoryTask) -> Result<(), Failure> {
        let Some(most) = self.most.filter(|most| estimate.bytes() > *most) else { return Ok(()) };
        let whose = match self.asked {
            true => "--memory allows",
            false => "this machine, or the group that limits the process, has",
        };
        let (most, suggestions) = (ByteSize(most), suggestions(job, work));
        Err(format!("this takes {estimate}, and {whose} {most}; {suggestions}").into())
    }
}

/// Suggests what takes less memory.
fn suggestions(job: &Job, work: MemoryTask) -> String {
    let mut options = vec!["a smaller --resolution", "parts of the picture with --crop"];
    if !job.layers.is_empty() {
        options.push("fewer layers");
    }
    if !job.stop_criteria.count_only() {
        options.push("--spp instead of --noise and --time");
    }
    if job.plan.has(petzval_render::plan::Effect::Diffraction) {
        options.push("--effects -diffraction");
    }
    if matches!(work, MemoryTask::Render { threads } if threads > 8) {
        options.push("fewer --threads");
    }
    match work {
        MemoryTask::Render { .. } => format!("to take less, use {}", options.join(", ")),
        MemoryTask::Merge => "merge on a larger machine, or render a smaller picture".to_owned(),
    }
}

/// Logs the peak memory beside the expected one, with --verbose.
pub(super) fn log_peak(estimate: &Estimate) {
    if !is_verbose() {
        return;
    }
    match machine::resident().peak {
        0 => say!("memory: expected {estimate}"),
        peak => say!("memory: {} at most; expected {estimate}", ByteSize(peak)),
    }
}
