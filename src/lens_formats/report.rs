//! Record of what a reader cannot simulate, does not know or assumes.

use std::cell::OnceCell;
use std::collections::BTreeMap;

use super::text::Line;
use petzval_base::io::{ReadContext, excerpt};
use petzval_lens::LensError;
use petzval_spectrum::{GlassError, GlassLibrary};

/// Largest number of unknown keywords that a note names.
const NAMED: usize = 12;

/// Notes of a reader for the user.
pub(crate) struct ReadReport<'a> {
    context: &'a ReadContext,
    /// Glasses of the library and of the user's catalogues, read when the first is asked for.
    glasses: OnceCell<GlassLibrary>,
    notes: Vec<String>,
    unknown: BTreeMap<String, usize>,
}

impl<'a> ReadReport<'a> {
    /// Creates an empty report.
    pub fn new(context: &'a ReadContext) -> Self {
        Self { context, glasses: OnceCell::new(), notes: Vec::new(), unknown: BTreeMap::new() }
    }

    /// Returns the glasses of the library and of the user's catalogues.
    ///
    /// # Errors
    /// Returns an error if a catalogue cannot be read.
    pub fn glasses(&self) -> Result<&GlassLibrary, GlassError> {
        if let Some(library) = self.glasses.get() {
            return Ok(library);
        }
        let library = GlassLibrary::for_context(self.context)?;
        Ok(self.glasses.get_or_init(|| library))
    }

    /// Adds a note once.
    pub fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// Reports a statement that changes rays and is not simulated: a note if the reader may
    /// approximate.
    ///
    /// # Errors
    /// Returns an error that names the line if it may not.
    pub fn unsimulated(
        &mut self,
        line: &Line,
        word: &str,
        what: impl Into<String>,
        instead: &str,
    ) -> Result<(), LensError> {
        let what = what.into();
        if !self.context.approximates() {
            let expected = format!("'approximate' reads the lens {instead}");
            return Err(line.error(word, format!("{what} is not simulated"), &expected));
        }
        self.note(format!(
            "line {}: {what} is not simulated; the lens is read {instead}",
            line.number
        ));
        Ok(())
    }

    /// Leaves out a feature that is not simulated, if the reader may approximate.
    ///
    /// # Errors
    /// Returns an error that names the place and the feature if it may not.
    pub fn leave_out(&mut self, line: &Line, word: &str, what: &str) -> Result<(), LensError> {
        self.unsimulated(line, word, what, "without it")
    }

    /// Returns the notes so far and forgets them.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Counts a keyword that the reader does not know.
    pub fn unknown(&mut self, keyword: &str) {
        *self.unknown.entry(excerpt(keyword).to_string()).or_default() += 1;
    }

    /// Returns the notes.
    pub fn finish(mut self) -> Vec<String> {
        if !self.unknown.is_empty() {
            let mut names: Vec<String> = self.unknown.keys().take(NAMED).cloned().collect();
            if self.unknown.len() > NAMED {
                names.push("...".into());
            }
            let count: usize = self.unknown.values().sum();
            let plural = if count == 1 { "" } else { "s" };
            self.notes.push(format!(
                "{count} statement{plural} with unknown keywords ignored: {}",
                names.join(", ")
            ));
        }
        self.notes
    }
}
