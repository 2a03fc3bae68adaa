//! Recovery from errors: the reader goes on at the next directive, so that one run reports all
//! errors of a file, but none that only follows from another.

use std::collections::HashSet;

use super::SceneError;
use super::directives::{Action, DIRECTIVES};
use super::lexer::{Lexer, TokenKind};
use super::reader::SceneReader;
use super::scene_errors::SceneErrors;
use petzval_base::io::nearest_word;

/// The errors so far, and what they leave undefined.
#[derive(Default)]
pub(super) struct Recovery {
    errors: SceneErrors,
    /// The first string of the current directive: the name of what it defines, if it does.
    first_string: Option<String>,
    /// Names whose definitions may have failed.
    lost: HashSet<String>,
    /// Whether a definition of any name may have failed, as in a file that cannot be read.
    any_lost: bool,
    /// Whether an error has made the rest of the scene meaningless.
    pub(super) stopped: bool,
    /// Whether the end of a block has been reported that does not match its begin. Which block lacks
    /// its end is then unknown.
    pub(super) blocks_mismatch: bool,
    /// Whether a directive has been reported that stands before `WorldBegin`.
    pub(super) world_missed: bool,
}

/// Returns the action of a directive.
pub(super) fn action(name: &str) -> Option<Action> {
    DIRECTIVES.iter().find(|(known, _)| *known == name).map(|(_, action)| *action)
}

/// Returns the directive that a misspelt one probably means.
pub(super) fn probable_directive(name: &str) -> Option<&'static str> {
    nearest_word(name, DIRECTIVES.iter().map(|(known, _)| *known))
}

/// Returns whether a word probably begins a directive. All directives have a capital letter.
pub(super) fn begins_directive(token: &TokenKind) -> bool {
    let TokenKind::Name(name) = token else { return false };
    let capital = name.starts_with(|c: char| c.is_ascii_uppercase());
    action(name).is_some() || capital && probable_directive(name).is_some()
}

impl Recovery {
    /// Starts a directive.
    pub(super) fn begin(&mut self) {
        self.first_string = None;
    }

    /// Notes a string of the current directive.
    pub(super) fn note(&mut self, string: &str) {
        if self.first_string.is_none() {
            self.first_string = Some(string.to_owned());
        }
    }

    /// Returns whether the definition of a name may have failed. An error about the name would then
    /// only follow from an error that is reported.
    pub(super) fn is_lost(&self, name: &str) -> bool {
        self.any_lost || self.lost.contains(name)
    }

    /// Notes that the definition of a name has failed.
    pub(super) fn lose(&mut self, name: &str) {
        self.lost.insert(name.to_owned());
    }

    /// Adds an error that is not part of a directive.
    pub(super) fn add(&mut self, error: SceneError, lexers: &[Lexer]) {
        self.stopped |= error.is_fatal() | !self.errors.add(error, lexers);
    }

    /// Returns the errors, if there are any.
    pub(super) fn take(&mut self) -> Option<SceneErrors> {
        let mut errors = std::mem::take(&mut self.errors);
        errors.sort();
        (!errors.is_empty()).then_some(errors)
    }
}

impl SceneReader {
    /// Adds an error to those of the file.
    pub(super) fn report(&mut self, error: SceneError) {
        self.recovery.any_lost |= matches!(error, SceneError::Include { .. });
        self.recovery.add(error, &self.lexers);
    }

    /// Reports the error of a result, if it is one.
    pub(super) fn report_any<T>(&mut self, result: Result<T, SceneError>) -> Option<T> {
        result.map_err(|error| self.report(error)).ok()
    }

    /// Reports the error of a directive, and skips the rest of the directive.
    pub(super) fn recover(&mut self, error: SceneError) {
        self.report(error);
        if !self.recovery.stopped {
            self.skip_directive();
            let lost = self.recovery.first_string.take();
            self.recovery.lost.extend(lost);
        }
    }

    /// Runs the directive that a misspelt one probably means, so that what it begins, ends or
    /// defines is known. Its own errors are not reported: the guess may be wrong.
    pub(super) fn run_probable(&mut self, name: &str) {
        let Some(action) = probable_directive(name).and_then(action) else { return };
        if action(self).is_err() {
            self.skip_directive();
        }
    }

    /// Skips all tokens up to the next directive. Of the errors in them only one that makes the rest
    /// meaningless is reported.
    fn skip_directive(&mut self) {
        loop {
            match self.next() {
                Ok(None) => return,
                Ok(Some(token)) => {
                    if token.kind == TokenKind::End || begins_directive(&token.kind) {
                        self.peeked = Some(token);
                        return;
                    }
                    if let TokenKind::Text(text) = &token.kind {
                        self.recovery.note(text);
                    }
                }
                Err(error) if error.is_fatal() => return self.report(error),
                Err(_) => {}
            }
        }
    }
}
