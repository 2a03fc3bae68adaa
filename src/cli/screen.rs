//! Amount of messages, and lines that fit the terminal.

use std::sync::atomic::{AtomicU8, Ordering};

use terminal_size::{Width, terminal_size_of};

/// Options of every command for its messages.
#[derive(Clone, Copy, Debug, clap::Args)]
#[command(next_help_heading = "Messages")]
pub(super) struct MessageArguments {
    /// Print more: after a render, tables of plan, stages and lanes, light losses and memory
    #[arg(short, long, global = true)]
    verbose: bool,
    /// Print no messages but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
}

const QUIET: u8 = 0;
const NORMAL: u8 = 1;
const VERBOSE: u8 = 2;

/// Amount of messages of this process. The macro of messages reads it everywhere.
static AMOUNT: AtomicU8 = AtomicU8::new(NORMAL);

impl MessageArguments {
    /// Sets the amount of messages of this process.
    pub fn apply(self) {
        let amount = match (self.quiet, self.verbose) {
            (true, _) => QUIET,
            (false, true) => VERBOSE,
            (false, false) => NORMAL,
        };
        AMOUNT.store(amount, Ordering::Relaxed);
    }
}

/// Returns whether only errors are printed.
pub(super) fn is_quiet() -> bool {
    AMOUNT.load(Ordering::Relaxed) == QUIET
}

/// Returns whether details are printed.
pub(super) fn is_verbose() -> bool {
    AMOUNT.load(Ordering::Relaxed) == VERBOSE
}

/// Returns the width of lines on stderr (characters): the terminal's; without a terminal, the
/// environment variable `COLUMNS`, or the largest number.
pub(super) fn columns() -> usize {
    match terminal_size_of(std::io::stderr()) {
        Some((Width(columns), _)) if columns > 0 => columns.into(),
        _ => declared_columns(),
    }
}

/// Returns the width of lines on stdout, as [`columns`].
pub(super) fn output_columns() -> usize {
    match terminal_size_of(std::io::stdout()) {
        Some((Width(columns), _)) if columns > 0 => columns.into(),
        _ => declared_columns(),
    }
}

fn declared_columns() -> usize {
    let declared = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok());
    declared.filter(|&columns| columns > 0).unwrap_or(usize::MAX)
}

/// Breaks a line between words so that no line is wider than this, where words allow it. Further
/// lines begin with `indent` blanks.
pub(super) fn wrap(line: &str, columns: usize, indent: usize) -> String {
    let width = |text: &str| text.chars().count();
    if width(line) <= columns {
        return line.to_owned();
    }
    // Deep indents leave no room for words on a narrow terminal.
    let indent = indent.min(columns / 2);
    // Blanks at the start and between columns of a table stay.
    let (mut lines, mut last, mut gap) = (String::new(), String::new(), String::new());
    for part in line.split_inclusive(' ') {
        let word = part.trim_end_matches(' ');
        if word.is_empty() {
            gap += part;
            continue;
        }
        let fits = width(&last) + width(&gap) + width(word) <= columns;
        if fits || last.trim().is_empty() {
            last += &gap;
        } else {
            lines += last.trim_end();
            lines.push('\n');
            last = " ".repeat(indent);
        }
        last += word;
        gap = part[word.len()..].to_owned();
    }
    lines + &last
}

#[cfg(test)]
mod tests {
    use super::wrap;

    #[test]
    fn lines_break_between_words_and_fit() {
        let line = "plan:    dispersion and iris; 8 other effects are off";
        assert_eq!(wrap(line, 80, 9), line);
        let narrow = wrap(line, 30, 9);
        assert_eq!(
            narrow,
            "plan:    dispersion and iris;\n         8 other effects are\n         off"
        );
        assert!(narrow.lines().all(|line| line.chars().count() <= 30));
        // A word that is wider than the terminal stays whole; a deep indent is cut to half.
        assert_eq!(wrap("a bbbbbbbbbbbb c", 8, 40), "a\n    bbbbbbbbbbbb\n    c");
        assert_eq!(wrap("a   b", 3, 0), "a\nb");
    }
}
