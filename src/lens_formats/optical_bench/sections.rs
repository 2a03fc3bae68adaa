//! Sections of the text, as lines of cells.

use std::path::Path;

use crate::text::Line;
use petzval_base::io::excerpt;
use petzval_lens::LensError;

/// A cell, trimmed.
pub(super) type Cell<'a> = &'a str;

/// Sections of the text, as lines of cells.
pub(super) struct Sections<'a> {
    rows: Vec<(&'a str, Line<'a>, Vec<Cell<'a>>)>,
}

impl<'a> Sections<'a> {
    /// Splits a text. Lines that are empty or begin with `#` are left out.
    pub fn read(path: &'a Path, text: &'a str) -> Self {
        let mut section = "";
        let mut rows = Vec::new();
        // Some editors replace tabs by blanks; two blanks then separate cells.
        let has_tabs = text.contains('\t');
        for line in Line::all(path, text) {
            let start = line.text.trim();
            if let Some(name) = start.strip_prefix('[') {
                section = name.split(']').next().unwrap_or_default().trim();
                continue;
            }
            if start.is_empty() || start.starts_with('#') {
                continue;
            }
            let cells: Vec<Cell<'a>> = match has_tabs {
                true => line.text.split('\t').map(str::trim).collect(),
                false => start.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect(),
            };
            rows.push((section, line, cells));
        }
        Self { rows }
    }

    /// Returns the lines of a section.
    pub fn rows(&self, section: &str) -> impl Iterator<Item = (&Line<'a>, &[Cell<'a>])> {
        let inside = move |name: &str| name.eq_ignore_ascii_case(section);
        let rows = self.rows.iter().filter(move |(name, ..)| inside(name));
        rows.map(|(_, line, cells)| (line, &cells[..]))
    }

    /// Returns the line of a section that begins with a name.
    pub fn row(&self, section: &str, name: &str) -> Option<(&Line<'a>, &[Cell<'a>])> {
        self.rows(section).find(|(_, cells)| cells[0].eq_ignore_ascii_case(name))
    }

    /// Returns the text behind a name.
    pub fn text(&self, section: &str, name: &str) -> Option<&'a str> {
        self.row(section, name).and_then(|(_, cells)| cells.get(1).copied())
    }
}

/// Parses a cell as a radius, which may be infinite; a minus sign of typography counts as one.
///
/// # Errors
/// Returns an error with line and column if it is none.
pub(super) fn length(line: &Line<'_>, word: &str) -> Result<f64, LensError> {
    let plain = word.replace(['\u{2212}', '\u{2013}'], "-");
    match plain.parse::<f64>() {
        Ok(length) if length.is_infinite() => Ok(length),
        _ => number(line, word),
    }
}

/// Parses a cell as a finite number; a minus sign of typography counts as one.
///
/// # Errors
/// Returns an error with line and column if it is none.
pub(super) fn number(line: &Line<'_>, word: &str) -> Result<f64, LensError> {
    let plain = word.replace(['\u{2212}', '\u{2013}'], "-");
    match plain.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => {
            let found = format!("\"{}\" is not a finite number", excerpt(word));
            Err(line.error(word, found, "expected a number"))
        }
    }
}
