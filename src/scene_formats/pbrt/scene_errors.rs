//! The errors of a scene file, each with the line of the source that it is about.

use std::fmt;
use std::path::Path;
use std::sync::Arc;

use super::SceneError;
use super::lexer::Lexer;
use petzval_base::io::{Location, SourceLine};

/// Limit of the errors that one reading reports.
const MAX_FAULTS: usize = 20;

/// All errors of a scene file that one reading found, by file and line. There is at least one.
#[derive(Debug, Default)]
pub struct SceneErrors {
    faults: Vec<SceneFault>,
    incomplete: bool,
}

/// An error in a scene, and the line of the source that it is about.
#[derive(Debug)]
pub struct SceneFault {
    /// The error.
    pub error: SceneError,
    /// The line at its location.
    pub source_line: Option<SourceLine>,
    /// Number of further errors with the same message at other locations.
    pub more: u32,
    /// The message, without the location.
    message: String,
}

impl SceneErrors {
    /// Returns the errors.
    pub fn faults(&self) -> &[SceneFault] {
        &self.faults
    }

    /// Returns whether the reader stopped before the end of the file because of their number.
    pub fn is_incomplete(&self) -> bool {
        self.incomplete
    }

    /// Adds an error, or counts it if there is one of the same message. Returns false if there may
    /// be no more errors.
    pub(super) fn add(&mut self, error: SceneError, lexers: &[Lexer]) -> bool {
        let message = error.message();
        if let Some(same) = self.faults.iter_mut().find(|fault| fault.message == message) {
            same.more += 1;
            return true;
        }
        let source_line = match error {
            SceneError::NotText { .. } => None,
            _ => error.location().and_then(|at| source_line(at, lexers)),
        };
        self.faults.push(SceneFault { error, source_line, more: 0, message });
        self.incomplete = self.faults.len() >= MAX_FAULTS;
        !self.incomplete
    }

    pub(super) fn is_empty(&self) -> bool {
        self.faults.is_empty()
    }

    /// Sorts the errors by file, in the order in which errors were found there, and by line.
    pub(super) fn sort(&mut self) {
        let mut files: Vec<Arc<Path>> = Vec::new();
        for at in self.faults.iter().filter_map(|fault| fault.error.location()) {
            if !files.contains(&at.file) {
                files.push(at.file.clone());
            }
        }
        let key = |fault: &SceneFault| {
            let at = fault.error.location();
            at.map(|at| (files.iter().position(|file| *file == at.file), at.line, at.column))
        };
        self.faults.sort_by_key(key);
    }
}

impl From<SceneError> for SceneErrors {
    fn from(error: SceneError) -> Self {
        let mut errors = Self::default();
        errors.add(error, &[]);
        errors
    }
}

impl std::error::Error for SceneErrors {}

impl fmt::Display for SceneErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.faults.iter().enumerate() {
            let newline = if i == 0 { "" } else { "\n" };
            write!(f, "{newline}{fault}")?;
            if let Some(line) = &fault.source_line {
                write!(f, "\n{line}")?;
            }
        }
        Ok(())
    }
}

/// Writes the error without the line of the source.
impl fmt::Display for SceneFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.error)?;
        match self.more {
            0 => Ok(()),
            more => write!(f, " (and {more} more like this)"),
        }
    }
}

/// Returns the line at a location. A file that is no longer open is read again.
fn source_line(at: &Location, lexers: &[Lexer]) -> Option<SourceLine> {
    match lexers.iter().find(|lexer| lexer.file() == &at.file) {
        Some(lexer) => SourceLine::new(lexer.text(), at),
        None => SourceLine::read(at),
    }
}
