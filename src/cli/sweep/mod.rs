//! `petzval render --sweep`: many pictures of one scene, which is read once.

mod axis;
mod orders;
mod proofs;
mod table;
mod template;

pub(super) use axis::{Axis, axis};

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use petzval::contact::Contact;
use petzval::image::{Exposure, Format};
use petzval::memory::budget;
use petzval::render::Progress;
use petzval::scene::pbrt::{self, CameraSpec, Description, RealisticSpec};
use petzval::source::{Files, Warning};

use super::folders::Folders;
use super::inputs::{parsed, words};
use super::kept::{checkpoint_name, resume, written};
use super::memory::Memory;
use super::message;
use super::outputs::{check_distinct, check_writable};
use super::render::{Among, Shot, stop_at_signals};
use super::{Failure, Outcome, RenderArguments};
use orders::Orders;
use proofs::Proofs;
use table::Row;

/// Pictures that are made ready before the first is taken, at most.
const REHEARSED: usize = 64;
/// How long that may take without a word.
const SILENT: Duration = Duration::from_secs(3);

/// Options whose values are all alike to make ready.
const ALIKE: [&str; 6] = ["exposure", "half", "noise", "seed", "spp", "time"];

/// Pictures of one scene.
struct Sweep<'a> {
    arguments: &'a RenderArguments,
    /// The command.
    words: Vec<String>,
    orders: Orders,
    memory: Memory,
    description: Description,
    names: Vec<PathBuf>,
    /// Files that the pictures are made of.
    inputs: Files,
    /// What was noticed, each thing once.
    said: HashSet<String>,
}

pub(super) fn run(arguments: &RenderArguments) -> Result<Outcome, Failure> {
    let words = words();
    let orders = Orders::new(arguments, &words)?;
    let axes = orders.shown();
    let memory = Memory::new(arguments.memory)
        .with_sheet(move |size| Contact::new(String::new(), axes.clone(), size).bytes());
    let mut description = pbrt::read(&arguments.picture.scene)?;
    // Now, because it is not read again: what is there later may be another file.
    description.files.digest()?;
    let names = orders.names(&arguments.picture.scene, lens(arguments, &description))?;
    let _folders = Folders::of(&names)?;
    let (inputs, said) = (description.files.clone(), HashSet::new());
    let mut sweep = Sweep { arguments, words, orders, memory, description, names, inputs, said };
    let size = sweep.rehearse()?;
    let written = sweep.names.iter().flat_map(|name| written(name));
    check_distinct(written, "-o", &sweep.inputs)?;
    let mut proofs = sweep.proofs(size)?;
    let progress = Arc::new(Progress::default());
    stop_at_signals(progress.clone());
    let begun = Instant::now();
    let outcome = sweep.take_all(&mut proofs, &progress);
    // Whatever has happened, they show what there is.
    let written = proofs.write();
    let (outcome, standing) = outcome?;
    written?;
    let (done, count, sheet) = (proofs.done(), sweep.names.len(), proofs.sheet.display());
    match &outcome {
        Outcome::Interrupted => say!("petzval: {done} of {count} pictures are done; see {sheet}"),
        _ => say!(
            "{sheet}: {count} pictures, {standing} of them as they stood, {:.2} s",
            begun.elapsed().as_secs_f64()
        ),
    }
    Ok(outcome)
}

/// The lens file of a command line.
fn lens<'a>(arguments: &'a RenderArguments, description: &'a Description) -> Option<&'a Path> {
    let CameraSpec::Realistic(RealisticSpec::V4 { lens, .. } | RealisticSpec::V2 { lens, .. }) =
        &description.camera
    else {
        return None;
    };
    Some(arguments.picture.lens.as_deref().unwrap_or(lens))
}

impl Sweep<'_> {
    /// The command line of a picture, and what it asks for.
    fn order(&self, number: usize) -> Result<(Vec<String>, RenderArguments), Failure> {
        let words = self.orders.words(number, &self.names[number]);
        let mut arguments = parsed(&words)?;
        arguments.resume = self.arguments.resume && checkpoint_name(&self.names[number]).exists();
        Ok((words, arguments))
    }

    /// In words, which picture it is.
    fn called(&self, number: usize) -> String {
        let axes = self.orders.axes.iter().zip(self.orders.values(number));
        let values: Vec<String> =
            axes.map(|(axis, value)| format!("{} {value}", axis.name)).collect();
        values.join(", ")
    }

    /// Makes pictures ready and takes none, so that no value is refused when hours are over. Answers
    /// the size of the first.
    fn rehearse(&mut self) -> Result<[u32; 2], Failure> {
        let axes = &self.orders.axes;
        let alike = |name: &str| ALIKE.contains(&name);
        let counts: Vec<usize> =
            axes.iter().map(|axis| if alike(&axis.name) { 1 } else { axis.values.len() }).collect();
        let all: usize = counts.iter().product();
        let numbers: Vec<usize> = match all <= REHEARSED {
            true => (0..self.names.len())
                .filter(|&number| {
                    let values = axes.iter().zip(self.orders.values(number));
                    let mut alike = values.filter(|(axis, _)| alike(&axis.name));
                    alike.all(|(axis, value)| axis.values[0] == value)
                })
                .collect(),
            false => {
                // Every value, or of many the ends and those between in even steps.
                let most = counts.iter().copied().max().unwrap_or(1).min(REHEARSED);
                let place = |i: usize, count: usize| match count > most {
                    true => i * (count - 1) / (most - 1),
                    false => i % count,
                };
                (0..most)
                    .map(|i| {
                        let places: Vec<usize> =
                            counts.iter().map(|&count| place(i, count)).collect();
                        self.orders.number(&places)
                    })
                    .collect()
            }
        };
        let (begun, mut silent) = (Instant::now(), true);
        let mut size = [1; 2];
        for &number in numbers.iter().rev() {
            if silent && begun.elapsed() > SILENT {
                silent = false;
                let (some, all) = (numbers.len(), self.names.len());
                say!("petzval: trying {some} of {all} pictures before the first is taken");
            }
            let (words, arguments) = self.order(number)?;
            let made = self.shot(&arguments, words);
            let called = self.called(number);
            let (shot, warnings) = made.map_err(|error| format!("{called}: {error}"))?;
            size = shot.job.frame.size();
            self.inputs.join(shot.job.files);
            self.tell(&warnings);
        }
        Ok(size)
    }

    /// A picture that is made ready, and what was noticed on the way.
    fn shot<'b>(
        &self,
        arguments: &'b RenderArguments,
        words: Vec<String>,
    ) -> Result<(Shot<'b>, Vec<Warning>), Failure> {
        // What is read for a picture alone, such as that of an iris, goes with it.
        let make =
            || Shot::new(arguments, words, self.description.clone(), &self.memory, Instant::now());
        budget::lent(make)
    }

    /// Says what has not been said.
    fn tell(&mut self, warnings: &[Warning]) {
        let new = |warning: &&Warning| self.said.insert(warning.to_string());
        let new: Vec<Warning> = warnings.iter().filter(new).cloned().collect();
        message::warnings(&new);
    }

    /// The contact sheet and the table, with what stands already where the sweep goes on.
    fn proofs(&self, size: [u32; 2]) -> Result<Proofs, Failure> {
        let sheet = match &self.arguments.contact {
            Some(sheet) => sheet.clone(),
            None => self.orders.folder().join("sweep.png"),
        };
        if Format::of(&sheet)? == Format::Exr {
            return Err(format!("--contact {}: expected .png or .jpg", sheet.display()).into());
        }
        check_writable(&sheet, "--contact")?;
        let table = sheet.with_extension("csv");
        check_distinct([&sheet, &table], "--contact", &self.inputs)?;
        if let Some(name) = self.names.iter().find(|&name| [&sheet, &table].contains(&name)) {
            let name = name.display();
            return Err(format!("{name} is both a picture and what is to show them all").into());
        }
        let scene = self.arguments.picture.scene.file_name().unwrap_or_default();
        let axes: Vec<&str> = self.orders.axes.iter().map(|axis| axis.name.as_str()).collect();
        let title = format!("{} by {}", scene.to_string_lossy(), axes.join(" and "));
        // What has eight bits is developed already, and light has no exposure of its own.
        let exposure = match Format::of(&self.names[0])? {
            Format::Exr if !axes.contains(&"exposure") => self.arguments.exposure,
            _ => Exposure::default(),
        };
        let mut proofs =
            Proofs::new(title, &self.orders, [sheet, table], size, exposure, &self.words);
        let mine = proofs.read(&self.names)?;
        let table = proofs.table.display().to_string();
        match (self.arguments.resume, mine.is_empty()) {
            (true, true) => say!("petzval: {table} knows none of these pictures; all are taken"),
            (false, false) => say!(
                "petzval: warning: {table} knows {} of these pictures; --resume would leave those \
                 alone that stand",
                mine.len()
            ),
            (true, false) => {
                for (number, row) in mine {
                    if row.is_of(&self.names[number]) {
                        let values = self.orders.values(number);
                        proofs.put(number, &self.names[number], &values, row);
                    }
                }
            }
            (false, true) => {}
        }
        Ok(proofs)
    }

    /// Takes all pictures that do not stand. Answers how many do.
    fn take_all(
        &mut self,
        proofs: &mut Proofs,
        progress: &Arc<Progress>,
    ) -> Result<(Outcome, usize), Failure> {
        let mut standing = 0;
        for number in 0..self.names.len() {
            if progress.stop.load(Ordering::Relaxed) {
                say!("petzval: interrupted; go on with\n  {}", resume(&self.words));
                return Ok((Outcome::Interrupted, standing));
            }
            let (words, arguments) = self.order(number)?;
            let called = self.called(number);
            let named = |error: Failure| -> Failure { format!("{called}: {error}").into() };
            let made = self.shot(&arguments, words);
            let (shot, warnings) = made.map_err(named)?;
            self.tell(&warnings);
            let inputs = inputs(&arguments, &shot);
            let name = &self.names[number];
            if let Some(row) = proofs.row(number) {
                if row.is_made_of(&inputs) {
                    standing += 1;
                    continue;
                }
                say!("petzval: {} is of other inputs, and taken again", name.display());
                proofs.drop(number);
            }
            let place = format!("{} of {}: {called}", number + 1, self.names.len());
            let among = Among { number: &place, words: &self.words };
            let taken = shot.take(progress, Some(among)).map_err(named)?;
            if matches!(taken.outcome, Outcome::Interrupted) {
                return Ok((Outcome::Interrupted, standing));
            }
            let row = Row::new(name, &taken, inputs)
                .map_err(|error| format!("cannot read {}: {error}", name.display()))?;
            proofs.put(number, name, &self.orders.values(number), row);
            proofs.keep();
        }
        Ok((Outcome::Done, standing))
    }
}

/// A digest of all that decides about the file of a picture.
fn inputs(arguments: &RenderArguments, shot: &Shot) -> String {
    let mut inputs = shot.inputs.clone();
    let encoding = format!("{:?} {}", arguments.exposure, arguments.half);
    inputs.options.insert("the encoding".to_owned(), encoding);
    inputs.digest()
}
