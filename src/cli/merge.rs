//! `petzval merge`

use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

use petzval::checkpoint::{Head, Inputs, Saved};
use petzval::image::{Encoding, Format};
use petzval::memory::Work;
use petzval::render::merge;
use petzval::scene::pbrt;
use petzval::source::reading;

use super::develop::Development;
use super::inputs::{inputs, line, parsed, words};
use super::kept::resume;
use super::memory::{Memory, say_taken};
use super::message;
use super::outputs::{check_distinct, check_writable};
use super::render::job;
use super::{Failure, MergeArguments, Outcome};

pub(super) fn run(arguments: &MergeArguments) -> Result<Outcome, Failure> {
    let start = Instant::now();
    let MergeArguments { parts, output, half, exposure, threads, memory } = arguments;
    let memory = Memory::new(*memory);
    let format = Format::of(output)?;
    check_writable(output, "-o")?;
    let (together, mut files) = reading(|| together(parts));
    let (first, parts) = together?;
    let begun = &first.words;
    let render = parsed(begun)?;
    // What comes behind the film needs the scene and the lens.
    let description = pbrt::read(&render.picture.scene).map_err(|error| {
        format!("{error}; the parts were rendered by\n  {}\nmerge where its files are", line(begun))
    })?;
    let (mut job, notes, warnings) = job(&render, description, true)?;
    files.join(job.files.clone());
    check_distinct([output], "-o", &files)?;
    message::warnings(&warnings);
    // It only adds up; but all parts must be of one build.
    let build = first.inputs.build.clone();
    let now = Inputs { build, ..inputs(begun, &job, first.of)? };
    let changes = first.inputs.changes(&now);
    if !changes.is_empty() {
        let changes = changes.join("; ");
        return Err(format!("the parts cannot be merged any more: {changes}").into());
    }
    job.samples = 0..first.of;
    if *half && format != Format::Exr {
        say!("petzval: warning: --half is for EXR; {} has 8 bits", output.display());
    }
    let estimate = memory.check(&job, Work::Merge, Some(format))?;
    let read = start.elapsed();
    let exposed = merge(&job, &parts)?;
    let encoding = Encoding { half: *half, exposure: *exposure };
    let threads = threads.map_or(0, usize::from);
    let (words, rendered_by, among) = (&words(), begun, None);
    let development = Development {
        job: &job,
        notes,
        words,
        rendered_by,
        among,
        output,
        encoding,
        threads,
        start,
        read,
    };
    development.develop(exposed)?;
    say_taken(&estimate);
    Ok(Outcome::Done)
}

/// The head of parts that belong together, and their files in the order of their samples.
fn together(paths: &[PathBuf]) -> Result<(Head, Vec<PathBuf>), Failure> {
    let mut first: Option<Head> = None;
    let mut parts: Vec<(Range<u32>, &PathBuf)> = Vec::new();
    for path in paths {
        let head = Saved::open(path)?.head;
        if !head.complete {
            let words = resume(&head.words);
            let path = path.display();
            return Err(format!("{path} is not finished; go on with\n  {words}").into());
        }
        parts.push((head.samples.clone(), path));
        let Some(first) = &first else {
            first = Some(head);
            continue;
        };
        let changes = first.inputs.changes(&head.inputs);
        if !changes.is_empty() {
            let [one, other] = [&paths[0], path].map(|path| path.display());
            let changes = changes.join("; ");
            return Err(format!("{one} and {other} are of different pictures: {changes}").into());
        }
    }
    let first = first.ok_or("there are no parts")?;
    parts.sort_by_key(|(samples, _)| [samples.start, samples.end]);
    let problems = problems(&parts, first.of);
    match problems.is_empty() {
        true => Ok((first, parts.into_iter().map(|(_, path)| path.clone()).collect())),
        false => Err(problems.join("; ").into()),
    }
}

/// Which samples are missing, and which are there twice.
fn problems(parts: &[(Range<u32>, &PathBuf)], all: u32) -> Vec<String> {
    let mut problems = Vec::new();
    let missing = |range: Range<u32>| format!("samples {}..{} are missing", range.start, range.end);
    let (mut end, mut last): (u32, Option<&PathBuf>) = (0, None);
    for &(ref samples, path) in parts {
        if samples.start > end {
            problems.push(missing(end..samples.start));
        }
        if let Some(last) = last.filter(|_| samples.start < end) {
            let common = samples.start..end.min(samples.end);
            let [one, other] = [last, path].map(|path| path.display());
            let (start, end) = (common.start, common.end);
            problems.push(format!("{one} and {other} both hold samples {start}..{end}"));
        }
        if samples.end >= end {
            (end, last) = (samples.end, Some(path));
        }
    }
    if end < all {
        problems.push(missing(end..all));
    }
    problems
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_or_double_is_said() {
        let names = ["a", "b", "c"].map(PathBuf::from);
        let found = |ranges: [Range<u32>; 3]| {
            let parts: Vec<_> = ranges.into_iter().zip(&names).collect();
            problems(&parts, 30).join("; ")
        };
        assert_eq!(found([0..10, 10..20, 20..30]), "");
        assert_eq!(
            found([0..10, 12..20, 20..29]),
            "samples 10..12 are missing; samples 29..30 are missing"
        );
        assert_eq!(found([0..10, 5..20, 20..30]), "a and b both hold samples 5..10");
        assert_eq!(
            found([0..30, 5..10, 8..9]),
            "a and b both hold samples 5..10; a and c both hold samples 8..9"
        );
        assert_eq!(found([5..10, 10..20, 20..30]), "samples 0..5 are missing");
    }
}
