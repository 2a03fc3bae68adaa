//! Statements of CODE V files.

use std::path::Path;

use crate::text::Line;
use petzval_lens::LensError;

/// A word with its line.
#[derive(Clone, Copy)]
pub(super) struct CodeVWord<'a> {
    pub line: Line<'a>,
    pub text: &'a str,
}

impl CodeVWord<'_> {
    /// Returns the word as a finite number.
    pub fn number(&self) -> Result<f64, LensError> {
        self.line.number_of(self.text)
    }

    /// Returns the word as a radius or a distance, which may be infinite.
    pub fn length(&self) -> Result<f64, LensError> {
        self.line.length_of(self.text)
    }

    /// Returns an error at this word.
    pub fn error(&self, found: impl Into<String>, expected: &str) -> LensError {
        self.line.error(self.text, found, expected)
    }
}

/// Returns the statements of a file: words between blanks or in quotes, up to `;` or the end of a
/// line that does not end with `&`. The rest of a line behind `!` is a comment.
pub(super) fn statements<'a>(path: &'a Path, text: &'a str) -> Vec<Vec<CodeVWord<'a>>> {
    let mut all = Vec::new();
    let mut words: Vec<CodeVWord> = Vec::new();
    for line in Line::all(path, text) {
        let mut goes_on = false;
        let mut rest = line.text;
        loop {
            rest = rest.trim_start();
            let Some(first) = rest.chars().next() else { break };
            let end = match first {
                '!' => break,
                ';' => {
                    all.push(std::mem::take(&mut words));
                    rest = &rest[1..];
                    continue;
                }
                '&' => {
                    goes_on = true;
                    rest = &rest[1..];
                    continue;
                }
                '\'' | '"' => rest[1..].find(first).map_or(rest.len(), |end| end + 2),
                _ => rest
                    .find(|c: char| c.is_whitespace() || ";!&".contains(c))
                    .unwrap_or(rest.len()),
            };
            goes_on = false;
            words.push(CodeVWord { line, text: &rest[..end] });
            rest = &rest[end..];
        }
        if !goes_on {
            all.push(std::mem::take(&mut words));
        }
    }
    all.push(words);
    all.retain(|words| !words.is_empty());
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn continued_lines_quotes_and_comments_are_understood() {
        let text = "RDM;LEN \"a; b\"\nWL 500&\n 600 ! 700\nS 1 2 'E 48'";
        let found: Vec<Vec<&str>> = statements(Path::new("a"), text)
            .iter()
            .map(|words| words.iter().map(|word| word.text).collect())
            .collect();
        let expected: [&[&str]; 4] =
            [&["RDM"], &["LEN", "\"a; b\""], &["WL", "500", "600"], &["S", "1", "2", "'E 48'"]];
        assert_eq!(found, expected);
    }
}
