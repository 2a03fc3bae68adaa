//! Command lines as lists of words: the one of this process, and those that are stored with a
//! picture.

use clap::Parser;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_needs_it() {
        let argv = ["petzval", "render", "a b's.pbrt", ""].map(str::to_owned);
        assert_eq!(shell_line(&argv), r"petzval render 'a b'\''s.pbrt' ''");
    }
}
