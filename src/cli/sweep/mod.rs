//! `petzval render --sweep`: many pictures of one scene, which is read once.

mod axis;
mod dry_run;
mod names;
mod plan;
mod report;
mod table;
mod template;

pub(super) use axis::{SweepAxis, sweep_axis};

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use petzval_base::io::{FileLog, Outputs, Warning};
use petzval_image::{DisplayExposure, ImageFormat};
use petzval_render::Progress;

use petzval_scene_formats::pbrt::{CameraSpec, Description, RealisticSpec};

use super::arguments::argv::{argv, parse_render};
use super::denoise::Denoiser;
use super::memory::Memory;
use super::outputs::{CreatedFolders, claim, claim_writable};
use super::render::{
    RenderArguments, RenderFiles, RenderTask, SweepItem, checkpoint_name, has_noisy_picture,
    resume_command, stop_at_signals,
};
use super::{Failure, Outcome, message};
use petzval_report::contact_sheet::ContactSheet;
use plan::SweepPlan;
use report::SweepReport;
use table::TableRow;

/// A sweep over a scene that is read.
struct Sweep<'a> {
    arguments: &'a RenderArguments,
    /// Command line of the sweep.
    argv: Vec<String>,
    plan: SweepPlan,
    memory: Memory,
    description: Description,
    /// The pictures' files, by number.
    names: Vec<PathBuf>,
    /// Files that the pictures depend on.
    inputs: FileLog,
    /// Warnings that were printed, to print each once.
    printed: HashSet<String>,
}

pub(super) fn run(arguments: &RenderArguments) -> Result<Outcome, Failure> {
    let argv = argv();
    let denoiser = arguments.denoiser()?;
    let plan = SweepPlan::new(arguments, &argv)?;
    let axes = plan.sheet_axes();
    let memory = Memory::new(arguments.memory)
        .with_sheet(move |size| ContactSheet::new(String::new(), axes.clone(), size).bytes());
    let mut description =
        petzval_scene_formats::read_with(&arguments.picture.scene, memory.context())?;
    // The scene is not read again, so its digest must not be of a later version.
    description.files.fill_digests()?;
    let names = plan.names(&arguments.picture.scene, lens_file(arguments, &description))?;
    let _folders = CreatedFolders::for_pictures(&names)?;
    let (inputs, printed) = (description.files.clone(), HashSet::new());
    let mut sweep = Sweep { arguments, argv, plan, memory, description, names, inputs, printed };
    let size = sweep.dry_run()?;
    let outputs = arguments.picture.lens_file.outputs(&sweep.inputs);
    denoiser.iter().for_each(|denoiser| outputs.protect(&denoiser.files()));
    for name in &sweep.names {
        RenderFiles::claim(name, denoiser.is_some(), &outputs)?;
    }
    let mut report = sweep.report(size, &outputs)?;
    let progress = Arc::new(Progress::default());
    stop_at_signals(progress.clone());
    let begun = Instant::now();
    let outcome = sweep.render_all(&mut report, &progress, denoiser.as_ref());
    // After a failure, too, the report shows the finished pictures.
    let written = report.write();
    let (outcome, unchanged) = outcome?;
    written?;
    let (done, count, sheet) = (report.done(), sweep.names.len(), report.sheet_file.display());
    match &outcome {
        Outcome::Interrupted => say!("petzval: {done} of {count} pictures are done; see {sheet}"),
        _ => say!(
            "{sheet}: {count} pictures, {unchanged} of them unchanged, {:.2} s",
            begun.elapsed().as_secs_f64()
        ),
    }
    Ok(outcome)
}

/// Returns the lens file of a command line.
fn lens_file<'a>(arguments: &'a RenderArguments, description: &'a Description) -> Option<&'a Path> {
    let CameraSpec::Realistic(RealisticSpec::V4 { lens, .. } | RealisticSpec::V2 { lens, .. }) =
        &description.camera
    else {
        return None;
    };
    Some(arguments.picture.lens.as_deref().unwrap_or(lens))
}

impl Sweep<'_> {
    /// Returns the command line of a picture, and its arguments.
    fn command(&self, number: usize) -> Result<(Vec<String>, RenderArguments), Failure> {
        let argv = self.plan.argv(number, &self.names[number]);
        let mut arguments = parse_render(&argv)?;
        arguments.resume = self.arguments.resume && checkpoint_name(&self.names[number]).exists();
        Ok((argv, arguments))
    }

    /// Returns the values of a picture, such as "fstop 4, focus 2".
    fn label(&self, number: usize) -> String {
        let axes = self.plan.axes.iter().zip(self.plan.values(number));
        let values: Vec<String> =
            axes.map(|(axis, value)| format!("{} {value}", axis.name)).collect();
        values.join(", ")
    }

    /// Prepares a picture. Returns it with the warnings of its readers.
    fn task<'b>(
        &self,
        arguments: &'b RenderArguments,
        argv: Vec<String>,
        denoiser: Option<&Denoiser>,
    ) -> Result<(RenderTask<'b>, Vec<Warning>), Failure> {
        let (description, now) = (self.description.clone(), Instant::now());
        RenderTask::new(arguments, argv, description, denoiser, &self.memory, now)
    }

    /// Prints the warnings that have not been printed before.
    fn print_new(&mut self, warnings: &[Warning]) {
        let new = |warning: &&Warning| self.printed.insert(warning.to_string());
        let new: Vec<Warning> = warnings.iter().filter(new).cloned().collect();
        message::warnings(&new);
    }

    /// Creates the report. A sweep that resumes takes finished pictures over into it.
    fn report(&self, size: [u32; 2], outputs: &Outputs) -> Result<SweepReport, Failure> {
        let sheet = match &self.arguments.contact {
            Some(sheet) => sheet.clone(),
            None => self.plan.folder().join("sweep.png"),
        };
        if ImageFormat::of(&sheet)?.is_linear() {
            return Err(
                format!("--contact {}: expected .png, .jpg or .tif", sheet.display()).into()
            );
        }
        let table = claim(outputs, sheet.with_extension("csv"), "--contact")?;
        let sheet = claim_writable(outputs, &sheet, "--contact")?;
        let scene = self.arguments.picture.scene.file_name().unwrap_or_default();
        let axes: Vec<&str> = self.plan.axes.iter().map(|axis| axis.name.as_str()).collect();
        let title = format!("{} by {}", scene.to_string_lossy(), axes.join(" and "));
        // Pictures for display have their exposure already; only EXR pictures get one on the sheet.
        let exposure = match ImageFormat::of(&self.names[0])? {
            ImageFormat::Exr if !axes.contains(&"exposure") => {
                self.arguments.encoding.exposure.unwrap_or_default()
            }
            _ => DisplayExposure::default(),
        };
        let mut report = SweepReport::new(
            title,
            &self.plan,
            [sheet, table],
            size,
            exposure,
            &self.argv,
            self.memory.context(),
        );
        let known = report.read(&self.names)?;
        let table = report.table.display().to_string();
        match (self.arguments.resume, known.is_empty()) {
            (true, true) => {
                say!("petzval: {table} lists none of these pictures; all are rendered");
            }
            (false, false) => say!(
                "petzval: warning: {table} lists {} of these pictures; --resume would keep those \
                 that are unchanged",
                known.len()
            ),
            (true, false) => {
                for (number, row) in known {
                    if row.matches_file(&self.names[number]) {
                        let values = self.plan.values(number);
                        report.add(number, &self.names[number], &values, row);
                    }
                }
            }
            (false, true) => {}
        }
        Ok(report)
    }

    /// Renders all pictures that are not finished. Returns also how many were.
    fn render_all(
        &mut self,
        report: &mut SweepReport,
        progress: &Arc<Progress>,
        denoiser: Option<&Denoiser>,
    ) -> Result<(Outcome, usize), Failure> {
        let mut unchanged = 0;
        for number in 0..self.names.len() {
            if progress.stop.load(Ordering::Relaxed) {
                say!("petzval: interrupted; continue with\n  {}", resume_command(&self.argv));
                return Ok((Outcome::Interrupted, unchanged));
            }
            let (argv, arguments) = self.command(number)?;
            let label = self.label(number);
            let labelled = |error: Failure| -> Failure { format!("{label}: {error}").into() };
            let (task, warnings) = self.task(&arguments, argv, denoiser).map_err(labelled)?;
            self.print_new(&warnings);
            let inputs = input_digest(&arguments, &task, denoiser);
            let name = &self.names[number];
            if let Some(row) = report.row(number) {
                let complete = denoiser.is_none() || has_noisy_picture(name);
                if complete && row.matches_inputs(&inputs) {
                    unchanged += 1;
                    continue;
                }
                let cause = match complete {
                    true => "the inputs of {} have changed",
                    false => "the noisy picture of {} is missing",
                };
                let cause = cause.replace("{}", &name.display().to_string());
                say!("petzval: {cause}; rendering it again");
                report.remove(number);
            }
            let numbered = format!("{} of {}: {label}", number + 1, self.names.len());
            let item = SweepItem { label: &numbered, argv: &self.argv };
            let result = task.run(progress, denoiser, Some(item)).map_err(labelled)?;
            if matches!(result.outcome, Outcome::Interrupted) {
                return Ok((Outcome::Interrupted, unchanged));
            }
            let row = TableRow::new(name, &result, inputs)
                .map_err(|error| format!("cannot read {}: {error}", name.display()))?;
            report.add(number, name, &self.plan.values(number), row);
            report.write_if_due();
        }
        Ok((Outcome::Done, unchanged))
    }
}

/// Returns a digest of everything that determines the file of a picture.
fn input_digest(
    arguments: &RenderArguments,
    task: &RenderTask,
    denoiser: Option<&Denoiser>,
) -> String {
    let mut inputs = task.inputs.clone();
    let mut encoding = format!("{:?}", arguments.encoding);
    if let Some(denoiser) = denoiser {
        encoding += &format!(" denoised by {}", denoiser.name());
    }
    inputs.options.insert("the encoding".to_owned(), encoding);
    inputs.digest()
}
