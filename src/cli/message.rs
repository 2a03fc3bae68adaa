//! Error and warning messages, with long input shortened.

use std::process::ExitCode;

use petzval::io::{SourceLine, Warning, excerpt, excerpt_words};
use petzval::prepare::PrepareError;
use petzval::scene::pbrt::SceneErrors;
use terminal_size::{Width, terminal_size_of};

use super::Failure;

/// Prints why a command failed.
pub(super) fn error(failure: &Failure) {
    let argv = longest_first();
    if let Some(errors) = failure.downcast_ref::<SceneErrors>() {
        return scene_errors(errors, &argv);
    }
    say!("petzval: error: {}", brief(&failure.to_string(), &argv));
    if let Some(PrepareError::Unreadable { at, .. } | PrepareError::Camera { at, .. }) =
        failure.downcast_ref()
        && let Some(line) = SourceLine::read(at)
    {
        say!("{}", line.shown(columns()));
    }
}

/// Returns the width of the terminal, or the largest number if there is none.
fn columns() -> usize {
    terminal_size_of(std::io::stderr()).map_or(usize::MAX, |(Width(columns), _)| columns.into())
}

/// Prints the errors of a scene, each with the line of the source that it is about.
fn scene_errors(errors: &SceneErrors, argv: &[String]) {
    for fault in errors.faults() {
        say!("petzval: error: {}", brief(&fault.to_string(), argv));
        if let Some(line) = &fault.source_line {
            say!("{}", line.shown(columns()));
        }
    }
    if errors.is_incomplete() {
        say!("petzval: stopped after {} errors; there may be more", errors.faults().len());
    }
}

/// Prints the warnings of the readers.
pub(super) fn warnings(warnings: &[Warning]) {
    let argv = longest_first();
    for warning in warnings {
        say!("petzval: warning: {}", brief(&warning.to_string(), &argv));
    }
}

/// Prints what is wrong with a command line, or the help or version that it asks for.
pub(super) fn usage(error: &clap::Error) -> ExitCode {
    let message = error.render().to_string();
    let brief = brief(&message, &longest_first());
    match error.use_stderr() && brief != message {
        true => say!("{}", brief.trim_end()),
        // clap prints colours on a terminal.
        false => drop(error.print()),
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
            excerpt_words(&argv.iter().fold(line.to_owned(), cut))
        }
    };
    message.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

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
