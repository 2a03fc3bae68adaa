//! `petzval dataset`: pairs of clean and degraded pictures.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use petzval_base::io::{ByteSize, Outputs, Warning};
use petzval_image::ImageFormat;
use petzval_render::memory::{MemoryTask, machine};
use petzval_render::{Progress, RenderError, RenderOptions};
use petzval_tools::dataset::{
    DatasetError, DatasetScene, DatasetSpec, Draw, Manifest, prepare_pair, write_pair,
};

use super::arguments::argv::{argv, shell_line};
use super::arguments::values::{Shard, shard};
use super::memory::Memory;
use super::outputs::CreatedFolders;
use super::render::stop_at_signals;
use super::{Failure, Outcome, message};

/// Arguments of `petzval dataset`.
#[derive(Debug, clap::Args)]
pub(super) struct DatasetArguments {
    /// Specification: a TOML file
    spec: PathBuf,
    /// Folder for the pairs and the manifest
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Take the I-th of N parts of the pairs, I from 1, with a manifest of its own
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<Shard>,
    /// Print what would be drawn, and render nothing
    #[arg(long)]
    dry_run: bool,
    /// Number of threads; one per core by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    threads: Option<u16>,
    /// Largest memory use, as for petzval render
    #[arg(long, value_name = "SIZE")]
    memory: Option<ByteSize>,
}

pub(super) fn run(arguments: &DatasetArguments) -> Result<Outcome, Failure> {
    let memory = Memory::new(arguments.memory);
    let spec = DatasetSpec::read(&arguments.spec, memory.context())?;
    let Shard { index, count } = arguments.shard.unwrap_or(Shard { index: 1, count: 1 });
    let pairs: Vec<u32> = (0..spec.pairs).filter(|pair| pair % count == index - 1).collect();
    if arguments.dry_run {
        let lines: Vec<String> =
            pairs.iter().map(|&pair| format!("{pair:06}  {}\n", spec.draw(pair))).collect();
        return super::print(&lines.concat());
    }
    let outputs = Outputs::beside(&memory.context().files());
    outputs.protect(&spec.named_files());
    let mut folders = CreatedFolders::default();
    folders
        .create(&arguments.output)
        .map_err(|error| format!("-o {}: {error}", arguments.output.display()))?;
    let manifest = Manifest::open(&arguments.output, &spec.digest, [index, count], &outputs)?;
    let before = pairs.iter().filter(|&&pair| manifest.has(pair)).count();
    if before > 0 {
        say!("petzval: {before} of {} pairs are done", pairs.len());
    }
    let progress = Arc::new(Progress::default());
    stop_at_signals(progress.clone());
    let mut run = DatasetRun {
        arguments,
        spec: &spec,
        memory: &memory,
        manifest,
        outputs,
        progress,
        scenes: HashMap::new(),
        printed: HashSet::new(),
    };
    let begun = Instant::now();
    let pending: Vec<u32> = pairs.iter().copied().filter(|&pair| !run.manifest.has(pair)).collect();
    // The first pair must not replace a texture of the last one's scene.
    for &pair in &pending {
        run.read_scene(&spec.draw(pair).scene)?;
    }
    let mut new = 0;
    for &pair in &pending {
        if !run.take(spec.draw(pair))? {
            let done = before + new;
            say!(
                "petzval: interrupted after {done} of {} pairs; the same command continues\n  {}",
                pairs.len(),
                shell_line(&argv())
            );
            return Ok(Outcome::Interrupted);
        }
        new += 1;
    }
    run.manifest.create()?;
    let hours = begun.elapsed().as_secs_f64() / 3600.0;
    let rate = if new > 0 {
        format!(", {:.0} pairs/hour", f64::from(new as u32) / hours)
    } else {
        String::new()
    };
    say!("{}: {} pairs{rate}", run.manifest.path.display(), pairs.len());
    Ok(Outcome::Done)
}

/// A run that renders pairs.
struct DatasetRun<'a> {
    arguments: &'a DatasetArguments,
    spec: &'a DatasetSpec,
    memory: &'a Memory,
    manifest: Manifest,
    outputs: Outputs,
    progress: Arc<Progress>,
    /// The scenes read so far.
    scenes: HashMap<PathBuf, DatasetScene>,
    /// Warnings that were printed.
    printed: HashSet<String>,
}

impl DatasetRun<'_> {
    /// Reads a scene if it is not read yet.
    fn read_scene(&mut self, scene: &Path) -> Result<(), Failure> {
        if !self.progress.stop.load(Ordering::Relaxed) && !self.scenes.contains_key(scene) {
            let read = DatasetScene::read(scene, self.spec, self.memory.context())?;
            self.outputs.protect(&read.files);
            self.scenes.insert(scene.to_owned(), read);
        }
        Ok(())
    }

    /// Renders one pair. Returns false if it was stopped.
    fn take(&mut self, draw: Draw) -> Result<bool, Failure> {
        let start = Instant::now();
        if self.progress.stop.load(Ordering::Relaxed) {
            return Ok(false);
        }
        let pair = prepare_pair(self.spec, draw.clone(), &self.scenes[&draw.scene])?;
        let new = |warning: &&Warning| self.printed.insert(warning.to_string());
        let new: Vec<Warning> = pair.warnings.iter().filter(new).cloned().collect();
        message::warnings(&new);
        let (number, words) = (pair.draw.pair, pair.draw.to_string());
        let threads = self.arguments.threads.map_or_else(machine::cores, usize::from);
        for job in [&pair.clean, &pair.degraded] {
            let task = MemoryTask::Render { threads };
            self.memory.check(job, task, Some(ImageFormat::Exr), None)?;
        }
        let options =
            RenderOptions { threads, progress: Some(&self.progress), ..RenderOptions::default() };
        match write_pair(self.spec, &pair, self.manifest.folder(), &self.outputs, options) {
            Ok(row) => self.manifest.add(number, row)?,
            Err(DatasetError::Render(RenderError::Stopped)) => return Ok(false),
            Err(error) => return Err(error.into()),
        }
        say!("{number:06}: {words}, {:.2} s", start.elapsed().as_secs_f64());
        Ok(true)
    }
}
