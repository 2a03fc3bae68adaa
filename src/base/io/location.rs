//! Locations in input files, and warnings about them.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use super::path_excerpt;

/// A location in a text file. Lines and columns count from 1; a column counts characters. Line 0 stands
/// for input that has no lines, which `file` then names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Location {
    /// The file.
    pub file: Arc<Path>,
    /// The line.
    pub line: u32,
    /// The column.
    pub column: u32,
}

impl Location {
    /// Returns the location of a byte offset in the text of a file.
    pub fn in_text(file: &Path, text: &str, offset: usize) -> Self {
        let before = &text.as_bytes()[..offset.min(text.len())];
        let newline = before.iter().rposition(|&byte| byte == b'\n');
        let line_start = newline.map_or(0, |newline| newline + 1);
        // Columns count characters: continuation bytes are left out.
        let ahead = before[line_start..].iter().filter(|&&byte| byte & 0xc0 != 0x80);
        Self {
            file: file.into(),
            line: 1 + before.iter().filter(|&&byte| byte == b'\n').count() as u32,
            column: 1 + ahead.count() as u32,
        }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => write!(f, "{}", path_excerpt(&self.file)),
            line => write!(f, "{}:{line}:{}", path_excerpt(&self.file), self.column),
        }
    }
}

/// A warning about input, which does not stop the render.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// The location of the fault.
    pub at: Location,
    /// Description of the fault, and of the substitute.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.at, self.message)
    }
}
