//! Error and warning messages, with long input shortened and repeated ones counted.

use std::collections::HashMap;
use std::fmt::Display;
use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;

use petzval_base::io::{SourceLine, Warning, excerpt, excerpt_words, path_excerpt};
use petzval_render::prepare::PrepareError;
use petzval_scene_formats::pbrt::SceneErrors;

use super::Failure;
use super::screen::{columns, wrap};

/// Most messages of one kind that are printed; the rest are counted.
const MOST_ALIKE: usize = 3;
/// Longest line of a message (characters).
const MOST_CHARACTERS: usize = 4000;

/// Messages by kind, with their number.
#[derive(Default)]
struct Kinds {
    counts: HashMap<String, usize>,
    /// A kind that was printed often enough, and its first message.
    first: Vec<(String, String)>,
}

impl Kinds {
    /// Counts a message, and returns whether to print it. Messages of one kind differ in numbers alone.
    fn add(&mut self, message: &str) -> bool {
        let is_number = |word: &str| {
            let word = word.trim_matches(|c: char| !c.is_alphanumeric());
            !word.is_empty() && word.chars().all(|c| c.is_ascii_digit() || ".,-+eE:x".contains(c))
        };
        let kind: Vec<&str> =
            message.split(' ').map(|word| if is_number(word) { "#" } else { word }).collect();
        let kind = kind.join(" ");
        let count = self.counts.entry(kind.clone()).or_default();
        *count += 1;
        if *count == 1 {
            self.first.push((kind, message.to_owned()));
        }
        *count <= MOST_ALIKE
    }

    /// Returns lines that say how many messages were not printed.
    fn rest(&self, what: &str, argv: &[String]) -> Vec<String> {
        let line = |(kind, message): &(String, String)| {
            let more = self.counts[kind].checked_sub(MOST_ALIKE).filter(|&more| more > 0)?;
            Some(format!("petzval: {more} more {what} such as: {}", brief(message, argv)))
        };
        self.first.iter().filter_map(line).collect()
    }
}

/// Prints why a command failed.
pub(super) fn error(failure: &Failure) {
    let argv = longest_first();
    if let Some(errors) = failure.downcast_ref::<SceneErrors>() {
        return scene_errors(errors, &argv);
    }
    say_error!("petzval: error: {}", brief(&failure.to_string(), &argv));
    if let Some(PrepareError::Unreadable { at, .. } | PrepareError::Camera { at, .. }) =
        failure.downcast_ref()
        && let Some(line) = SourceLine::read(at)
    {
        say_error!("{}", line.shown(columns()));
    }
}

/// Prints the errors of a scene, each with the line of the source that it is about.
fn scene_errors(errors: &SceneErrors, argv: &[String]) {
    let mut kinds = Kinds::default();
    for fault in errors.faults() {
        let text = fault.to_string();
        let place = fault.error.location().map(|at| format!("{at}: ")).unwrap_or_default();
        if !kinds.add(text.strip_prefix(&place).unwrap_or(&text)) {
            continue;
        }
        say_error!("petzval: error: {}", brief(&text, argv));
        if let Some(line) = &fault.source_line {
            say_error!("{}", line.shown(columns()));
        }
    }
    for line in kinds.rest("errors", argv) {
        say_error!("{line}");
    }
    if errors.is_incomplete() {
        say_error!("petzval: stopped after {} errors; there may be more", errors.faults().len());
    }
}

/// Prints the warnings of the readers.
pub(super) fn warnings(warnings: &[Warning]) {
    warn(warnings.iter().map(|warning| (warning.at.to_string(), warning.message.clone())));
}

/// Prints warnings about a file.
pub(super) fn file_warnings(file: &Path, warnings: impl IntoIterator<Item = impl Display>) {
    let file = path_excerpt(file);
    warn(warnings.into_iter().map(|warning| (file.clone(), warning.to_string())));
}

/// Prints warnings, each with its place.
fn warn(warnings: impl Iterator<Item = (String, String)>) {
    let (argv, mut kinds) = (longest_first(), Kinds::default());
    for (place, message) in warnings {
        if kinds.add(&message) {
            let line = format!("petzval: warning: {place}: {}", brief(&message, &argv));
            say!("{}", wrap(&line, columns(), 2));
        }
    }
    for line in kinds.rest("warnings", &argv) {
        say!("{}", wrap(&line, columns(), 2));
    }
}

/// Prints what is wrong with a command line, or the help or version that it asks for.
pub(super) fn usage(error: &clap::Error) -> ExitCode {
    let message = error.render().to_string();
    let brief = brief(&message, &longest_first());
    match error.use_stderr() && brief != message {
        true => say_error!("{}", brief.trim_end()),
        // clap prints colours on a terminal.
        false => match error.print().and_then(|()| std::io::stdout().flush()) {
            // The reader of help has closed the pipe, as `head` does.
            Err(problem) if problem.kind() != std::io::ErrorKind::BrokenPipe => {
                say_error!("petzval: error: cannot write to the standard output: {problem}");
                return ExitCode::from(2);
            }
            _ => {}
        },
    }
    ExitCode::from(if error.use_stderr() { 2 } else { 0 })
}

/// Returns the words of the command line, the longest first.
fn longest_first() -> Vec<String> {
    let words = std::env::args_os().skip(1);
    let mut words: Vec<String> = words.map(|word| word.to_string_lossy().into_owned()).collect();
    words.sort_by_key(|word| std::cmp::Reverse(word.len()));
    words
}

/// Shortens long words of the command line in a message. A message names paths without quotes, so
/// each word is searched for as a whole, blanks included. Lines with commands stay whole, to be
/// typed.
fn brief(message: &str, argv: &[String]) -> String {
    let line = |line: &str| match line.starts_with("  petzval ") {
        true => line.to_owned(),
        false => {
            let cut = |line: String, word: &String| match excerpt(word) {
                cut if cut.len() < word.len() => line.replace(word.trim(), cut.trim()),
                _ => line,
            };
            shortened(excerpt_words(&argv.iter().fold(line.to_owned(), cut)))
        }
    };
    message.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

/// Returns a line without its middle if it is very long, such as a list of a thousand names.
fn shortened(line: String) -> String {
    let count = line.chars().count();
    if count <= MOST_CHARACTERS {
        return line;
    }
    let half = MOST_CHARACTERS / 2;
    let front: String = line.chars().take(half).collect();
    let back: String = line.chars().skip(count - half).collect();
    format!("{front} … ({} characters left out) … {back}", count - 2 * half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_that_differ_in_numbers_are_counted() {
        let mut kinds = Kinds::default();
        let printed = |kinds: &mut Kinds, text: String| usize::from(kinds.add(&text));
        let alike =
            (0..20).map(|i| printed(&mut kinds, format!("surface {i}: no index at 1.{i}e-3,")));
        assert_eq!(alike.sum::<usize>(), MOST_ALIKE);
        let others = (0..20).map(|i| printed(&mut kinds, format!("no texture \"t{i}\"")));
        assert_eq!(others.sum::<usize>(), 20);
        assert_eq!(kinds.first.len(), 21);
    }

    #[test]
    fn a_long_list_keeps_both_ends() {
        let list = format!("these: {}end", "name, ".repeat(10_000));
        let found = brief(&list, &[]);
        assert!(found.chars().count() < MOST_CHARACTERS + 100);
        assert!(found.starts_with("these: name") && found.ends_with("name, end"));
    }

    #[test]
    fn long_words_are_shortened_and_commands_stay_whole() {
        let path = format!("{}.exr", "a b".repeat(100));
        let message =
            format!("{path} is not finished; continue with\n  petzval render -o '{path}'");
        let found = brief(&message, &["merge".to_owned(), path.clone()]);
        let [first, second] = found.split('\n').collect::<Vec<_>>()[..] else { panic!("{found}") };
        assert!(first.ends_with(".exr is not finished; continue with"), "{first}");
        assert!(first.chars().count() < 120, "{first}");
        assert_eq!(second, format!("  petzval render -o '{path}'"));
    }
}
