//! A line of an input file with a fault in it, and the caret under the fault.

use std::{fmt, fs};

use super::printable::is_unprintable;
use super::{Location, ReadContext, without_byte_order_mark};

/// Limit of the characters kept on each side of the fault. A line of a mesh may have millions.
const KEPT: usize = 100;
/// Columns of a message, unless a terminal has fewer.
const COLUMNS: usize = 80;
/// Least characters of the line that are shown, however narrow the terminal is.
const MIN_SHOWN: usize = 16;
/// Replaces the omitted characters.
const ELLIPSIS: char = '…';

/// The part of a line of an input file around a fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceLine {
    line: u32,
    /// Characters around the fault.
    text: Vec<char>,
    /// Index of the fault in the text, and the number of characters at fault.
    fault: usize,
    length: usize,
    /// Whether the line has more characters before and behind the text.
    cut: [bool; 2],
}

impl SourceLine {
    /// Returns the line of a location in the content of its file.
    pub fn new(content: &[u8], at: &Location) -> Option<Self> {
        let content = without_byte_order_mark(content);
        let line = content.split(|&byte| byte == b'\n').nth(at.line.checked_sub(1)? as usize)?;
        let fault = at.column.checked_sub(1)? as usize;
        let skipped = fault.saturating_sub(KEPT);
        let line = String::from_utf8_lossy(line);
        let flat = |c: char| if is_unprintable(c) { ' ' } else { c };
        let mut text: Vec<char> =
            line.trim_end().chars().skip(skipped).take(2 * KEPT + 1).map(flat).collect();
        let more = text.len() > 2 * KEPT;
        text.truncate(2 * KEPT);
        let fault = (fault - skipped).min(text.len());
        let length = token_length(&text[fault..]).max(1);
        Some(Self { line: at.line, text, fault, length, cut: [skipped > 0, more] })
    }

    /// Returns the line of a location, from a file that is read again. A pipe can be read only once.
    pub fn read(at: &Location) -> Option<Self> {
        fs::metadata(&at.file).ok().filter(fs::Metadata::is_file)?;
        Self::new(&ReadContext::default().bytes(&at.file).ok()?, at)
    }

    /// Returns the line and the caret below it, in at most so many columns.
    pub fn shown(&self, columns: usize) -> String {
        let number = format!("{:>5}", self.line);
        let margin = number.len() + 3;
        let room = columns.min(COLUMNS).saturating_sub(margin + 1).max(MIN_SHOWN);
        // As much before the fault as fits, but half of the room for the fault itself.
        let indent = self.text.iter().take_while(|c| c.is_whitespace()).count();
        let needed = (self.fault + self.length.min(room / 2)).saturating_sub(room);
        let first = if needed > 0 { (needed + 2).min(self.fault) } else { indent.min(self.fault) };
        let last = self.text.len().min(first + room);
        let cut = [first > indent || self.cut[0], last < self.text.len() || self.cut[1]];
        let mut text = self.text[first..last].to_vec();
        if cut[0] && self.fault > first {
            text[0] = ELLIPSIS;
        }
        if cut[1]
            && let Some(end) = text.last_mut()
        {
            *end = ELLIPSIS;
        }
        let caret = " ".repeat(self.fault - first)
            + &"^".repeat(self.length.min(room.saturating_sub(self.fault - first)).max(1));
        let text: String = text.into_iter().collect();
        format!("{number} | {text}\n{} | {caret}", " ".repeat(number.len()))
    }
}

impl fmt::Display for SourceLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.shown(COLUMNS))
    }
}

/// Characters of the quotation or the word that a text begins with.
fn token_length(text: &[char]) -> usize {
    match text.first() {
        Some('"') => match text[1..].iter().position(|&c| c == '"') {
            Some(end) => end + 2,
            None => text.len(),
        },
        _ => text.iter().take_while(|c| !c.is_whitespace() && !"[]\"#".contains(**c)).count(),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;

    fn shown(content: &str, line: u32, column: u32, columns: usize) -> String {
        let at = Location { file: Arc::from(Path::new("a.pbrt")), line, column };
        SourceLine::new(content.as_bytes(), &at).unwrap().shown(columns)
    }

    #[test]
    fn the_caret_is_as_long_as_the_word_or_the_quotation() {
        let text = "Film \"rgb\"\n\tShape \"spere\" [ 1 ]\r\n";
        let expected = "    2 | Shape \"spere\" [ 1 ]\n      |       ^^^^^^^";
        assert_eq!(shown(text, 2, 8, 80), expected);
        assert!(shown(text, 2, 2, 80).ends_with("| ^^^^^"));
        assert!(shown(text, 2, 16, 80).ends_with(&format!("| {}^", " ".repeat(14))));
        assert!(shown("é ü x1 y", 1, 5, 80).ends_with("|     ^^"));
        // The fault may be the end of the file.
        assert_eq!(shown("Scale 1", 1, 8, 80), "    1 | Scale 1\n      |        ^");
        assert_eq!(shown("Scale 1\n", 2, 1, 80), "    2 | \n      | ^");
    }

    #[test]
    fn a_long_line_is_cut_around_the_fault_and_fits_the_terminal() {
        let line = format!("{} wrong {}", "12345678 ".repeat(5000), "1 ".repeat(5000));
        for columns in [1, 24, 40, 80, 500] {
            let found = shown(&line, 1, 45_002, columns);
            let [text, caret] = found.split('\n').collect::<Vec<_>>()[..] else { panic!() };
            let [length, fault] = [text.chars().count(), caret.find('^').unwrap()];
            assert!(length <= columns.clamp(MIN_SHOWN + 8, COLUMNS), "{columns}: {found}");
            assert!(text.chars().skip(fault).collect::<String>().starts_with("wro"), "{found}");
            assert_eq!(text.matches(ELLIPSIS).count(), 2, "{found}");
        }
        // Even if the fault is the long word itself.
        let found = shown(&"q".repeat(100_000), 1, 1, 60);
        assert!(found.lines().all(|line| line.chars().count() <= 60), "{found}");
    }

    #[test]
    fn a_byte_order_mark_is_not_part_of_the_line() {
        let found = shown("\u{feff}Film \"rgb\"", 1, 6, 80);
        assert_eq!(found, "    1 | Film \"rgb\"\n      |      ^^^^^");
    }

    #[test]
    fn a_location_beyond_the_file_has_no_line() {
        let at = Location { file: Arc::from(Path::new("a")), line: 9, column: 1 };
        assert_eq!(SourceLine::new(b"one\n", &at), None);
    }
}
