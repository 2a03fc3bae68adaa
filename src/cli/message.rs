//! Errors and warnings as the user sees them: with excerpts of long input.

use std::process::ExitCode;

use petzval::source::{Warning, excerpt, excerpts};

use super::Failure;

/// Says why a command failed.
pub(super) fn error(failure: &Failure) {
    say!("petzval: error: {}", brief(&failure.to_string(), &given()));
}

/// Says what the readers noticed.
pub(super) fn warnings(warnings: &[Warning]) {
    let given = given();
    for warning in warnings {
        say!("petzval: warning: {}", brief(&warning.to_string(), &given));
    }
}

/// Says what is wrong with a command line, or answers what it asks for, help or the version.
pub(super) fn usage(error: &clap::Error) -> ExitCode {
    let message = error.render().to_string();
    let brief = brief(&message, &given());
    match error.use_stderr() && brief != message {
        true => say!("{}", brief.trim_end()),
        // In colours, where the terminal has any.
        false => drop(error.print()),
    }
    ExitCode::from(if error.use_stderr() { 2 } else { 0 })
}

/// The words of the command line, the longest first.
fn given() -> Vec<String> {
    let words = std::env::args_os().skip(1);
    let mut words: Vec<String> = words.map(|word| word.to_string_lossy().into_owned()).collect();
    words.sort_by_key(|word| std::cmp::Reverse(word.len()));
    words
}

/// A message with excerpts of long input. Words of the command line may hold blanks, and a message
/// names paths without quotes. Commands, each on a line of its own, stay whole: they are to be typed.
fn brief(message: &str, given: &[String]) -> String {
    let line = |line: &str| match line.starts_with("  petzval ") {
        true => line.to_owned(),
        false => {
            let cut = |line: String, word: &String| match excerpt(word) {
                cut if cut.len() < word.len() => line.replace(word.trim(), cut.trim()),
                _ => line,
            };
            excerpts(&given.iter().fold(line.to_owned(), cut))
        }
    };
    message.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_words_of_the_command_line_are_cut_and_commands_stay_whole() {
        let path = format!("{}.exr", "a b".repeat(100));
        let message = format!("{path} is not finished; go on with\n  petzval render -o '{path}'");
        let found = brief(&message, &["merge".to_owned(), path.clone()]);
        let [first, second] = found.split('\n').collect::<Vec<_>>()[..] else { panic!("{found}") };
        assert!(first.ends_with(".exr is not finished; go on with"), "{first}");
        assert!(first.chars().count() < 120, "{first}");
        assert_eq!(second, format!("  petzval render -o '{path}'"));
    }
}
