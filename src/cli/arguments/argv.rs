//! Command lines as lists of words: the one of this process, and those that are stored with a
//! picture.

use clap::parser::ValueSource;
use clap::{ArgAction, CommandFactory, Parser};

use crate::cli::render::RenderArguments;
use crate::cli::{Arguments, Command, Failure};

/// Returns this process's command line, with the program's name in place of its path.
pub(in crate::cli) fn argv() -> Vec<String> {
    let own = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    std::iter::once("petzval".to_owned()).chain(own).collect()
}

/// Returns whether the words are those that the user typed. A word that is not UTF-8 is stored with
/// replacement characters, and would name another file.
pub(in crate::cli) fn is_faithful(argv: &[String]) -> bool {
    !argv.iter().any(|word| word.contains(char::REPLACEMENT_CHARACTER))
}

/// Quotes the words for a shell and joins them.
pub(in crate::cli) fn shell_line(argv: &[String]) -> String {
    argv.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// Parses the command line of a render.
pub(in crate::cli) fn parse_render(argv: &[String]) -> Result<RenderArguments, Failure> {
    match Arguments::try_parse_from(argv)?.command {
        Command::Render(arguments) => Ok(*arguments),
        _ => Err(format!("\"{}\" is not a petzval render command", shell_line(argv)).into()),
    }
}

/// Returns the command line of another command with the scene and the options of this one that the
/// other accepts too; `None` if this one cannot be parsed.
pub(in crate::cli) fn accepted_words(argv: &[String], other: &str) -> Option<Vec<String>> {
    let command = Arguments::command();
    let matches = command.clone().try_get_matches_from(argv).ok()?;
    let (_, given) = matches.subcommand()?;
    let mut options = Vec::new();
    let mut words = vec!["petzval".to_owned(), other.to_owned()];
    for argument in command.find_subcommand(other)?.get_arguments() {
        let id = argument.get_id().as_str();
        // Options of the other command alone were not given; defaults are left out.
        let Ok(Some(values)) = given.try_get_raw(id) else { continue };
        let said = given.value_source(id) == Some(ValueSource::CommandLine);
        // Only what determines the samples, which are the same for each backend.
        if !said || id == "backend" {
            continue;
        }
        let values = values.map(|value| value.to_string_lossy());
        match (argument.get_long(), argument.get_action()) {
            (None, _) => words.extend(values.map(|value| match value.starts_with('-') {
                true => format!("./{value}"),
                false => value.into_owned(),
            })),
            (Some(long), ArgAction::SetTrue) => options.push(format!("--{long}")),
            (Some(long), _) => options.extend(values.map(|value| format!("--{long}={value}"))),
        }
    }
    words.extend(options);
    Some(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_needs_it() {
        let argv = ["petzval", "render", "a b's.pbrt", ""].map(str::to_owned);
        assert_eq!(shell_line(&argv), r"petzval render 'a b'\''s.pbrt' ''");
    }
}
