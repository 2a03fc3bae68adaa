//! Words in a row: strings, numbers, parameter lists, and what is said about them.

use super::SceneError;
use super::params::{Param, Params, Values, kind_hint, kind_of};
use super::reader::Reader;
use super::token::{Token, Word};
use super::vocabulary::{Entry, QUIET, entry};
use crate::source::Location;

impl Reader {
    /// The next word; at the end of an included file, of the one that includes it.
    pub(super) fn next(&mut self) -> Result<Option<Token>, SceneError> {
        if let Some(token) = self.pending.take() {
            return Ok(Some(token));
        }
        while let Some(file) = self.files.last_mut() {
            if let Some(token) = file.token()? {
                return Ok(Some(token));
            }
            if file.imported {
                return Ok(Some(file.end()));
            }
            if self.files.len() == 1 {
                return Ok(None);
            }
            self.files.pop();
        }
        Ok(None)
    }

    pub(super) fn peek(&mut self) -> Result<Option<&Word>, SceneError> {
        if self.pending.is_none() {
            self.pending = self.next()?;
        }
        Ok(self.pending.as_ref().map(|token| &token.word))
    }

    pub(super) fn place(&self, token: &Token) -> Location {
        self.files.last().map_or_else(|| self.at.clone(), |file| file.place(token))
    }

    /// An error at a word that is not what was expected.
    pub(super) fn unexpected(&self, token: Option<Token>, expected: &str) -> SceneError {
        match token {
            Some(token) => {
                let at = self.place(&token);
                SceneError::at(at, format!("found {}", token.word.shown()), expected)
            }
            None => SceneError::at(self.at.clone(), "the file ends here", expected),
        }
    }

    pub(super) fn string(&mut self) -> Result<String, SceneError> {
        match self.next()? {
            Some(Token { word: Word::Text(text), .. }) => Ok(text),
            other => Err(self.unexpected(other, "expected a string in quotes")),
        }
    }

    /// N numbers, in brackets or not.
    pub(super) fn numbers<const N: usize>(&mut self) -> Result<[f64; N], SceneError> {
        let expected = format!("expected {N} numbers");
        let bracket = matches!(self.peek()?, Some(Word::Open));
        if bracket {
            self.next()?;
        }
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            match self.next()? {
                Some(Token { word: Word::Number(value), .. }) => *number = value,
                other => return Err(self.unexpected(other, &expected)),
            }
        }
        if bracket {
            match self.next()? {
                Some(Token { word: Word::Close, .. }) => {}
                other => return Err(self.unexpected(other, &format!("{expected} and a ]"))),
            }
        }
        Ok(numbers)
    }

    /// A parameter list: as many `"type name" values` as follow.
    pub(super) fn params(&mut self) -> Result<Params, SceneError> {
        self.list(false)
    }

    /// Options: as parameters, or by their name alone, as in `"seed" 7`.
    pub(super) fn options(&mut self) -> Result<Params, SceneError> {
        self.list(true)
    }

    fn list(&mut self, untyped: bool) -> Result<Params, SceneError> {
        let mut all = Vec::new();
        while matches!(self.peek()?, Some(Word::Text(_))) {
            let Some(token) = self.next()? else { break };
            let at = self.place(&token);
            let Word::Text(declaration) = &token.word else { break };
            let words: Vec<&str> = declaration.split_whitespace().collect();
            let (kind, name) = match words[..] {
                [kind, name] => (Some(kind), name),
                [name] if untyped => (None, name),
                _ => {
                    let found = format!("found {}", token.word.shown());
                    return Err(SceneError::at(at, found, "expected a parameter \"type name\""));
                }
            };
            let known = kind.map(|kind| {
                kind_of(kind).ok_or_else(|| {
                    let found = format!("unknown parameter type \"{kind}\"{}", kind_hint(kind));
                    SceneError::at(at.clone(), found, "")
                })
            });
            let known = known.transpose()?;
            let values = self.values(name)?;
            let kind = known.unwrap_or(values.kind()).to_owned();
            all.push(Param { kind, name: name.to_owned(), values, at });
        }
        let (space, folder) = (self.state.space, self.folder.clone());
        Ok(Params { all, at: self.at.clone(), space, folder })
    }

    /// One value, or several in brackets.
    pub(super) fn values(&mut self, name: &str) -> Result<Values, SceneError> {
        let expected = format!("expected a value for \"{name}\", or several of one kind in [ ]");
        let bracket = matches!(self.peek()?, Some(Word::Open));
        if bracket {
            self.next()?;
        }
        let mut values: Option<Values> = None;
        loop {
            let token = self.next()?;
            let word = token.as_ref().map(|token| token.word.clone());
            match (word, &mut values) {
                (Some(Word::Close), _) if bracket => break,
                (Some(Word::Number(v)), None) => {
                    let mut all = vec![v];
                    if bracket && let Some(file) = self.files.last_mut() {
                        file.numbers(&mut all)?;
                    }
                    values = Some(Values::Numbers(all));
                }
                (Some(Word::Number(v)), Some(Values::Numbers(all))) => all.push(v),
                (Some(Word::Text(v)), None) => values = Some(Values::Texts(vec![v])),
                (Some(Word::Text(v)), Some(Values::Texts(all))) => all.push(v),
                (Some(Word::Name(v)), known) if v == "true" || v == "false" => match known {
                    None => values = Some(Values::Truths(vec![v == "true"])),
                    Some(Values::Truths(all)) => all.push(v == "true"),
                    _ => return Err(self.unexpected(token, &expected)),
                },
                _ => return Err(self.unexpected(token, &expected)),
            }
            if !bracket {
                break;
            }
        }
        Ok(values.unwrap_or(Values::Numbers(Vec::new())))
    }

    /// The entry, name and parameters of a directive, checked against the vocabulary, and whether
    /// it is supported; where it is not, the warning is given.
    pub(super) fn kind(
        &mut self,
        directive: &'static str,
    ) -> Result<(&'static Entry, String, Params, bool), SceneError> {
        let name = self.string()?;
        let params = self.params()?;
        self.check(directive, name, params)
    }

    pub(super) fn check(
        &mut self,
        directive: &'static str,
        name: String,
        mut params: Params,
    ) -> Result<(&'static Entry, String, Params, bool), SceneError> {
        let entry = entry(directive, &name, &params)?;
        self.defaults(entry, &mut params);
        if let Some(instead) = entry.instead {
            if instead != QUIET {
                self.notices.instead(&params.at, &format!("{directive} \"{name}\""), instead);
            }
            if !entry.supported() {
                return Ok((entry, name, params, false));
            }
        }
        entry.check(&params, |param, instead| {
            let what = format!("\"{}\" of {directive} \"{name}\"", param.name);
            self.notices.instead(&param.at, &what, instead);
        })?;
        Ok((entry, name, params, true))
    }

    pub(super) fn warn_here(&mut self, what: &str, instead: &str) {
        self.notices.instead(&self.at, what, instead);
    }

    pub(super) fn leave_out(&mut self, directive: &'static str) -> Result<(), SceneError> {
        self.kind(directive).map(|_| ())
    }

    pub(super) fn refuse<T>(
        &self,
        found: impl Into<String>,
        expected: &str,
    ) -> Result<T, SceneError> {
        Err(SceneError::at(self.at.clone(), found, expected))
    }

    pub(super) fn before_world(&self, what: &str) -> Result<(), SceneError> {
        match self.in_world {
            true => self.refuse(format!("{what} after WorldBegin"), "it belongs before"),
            false => Ok(()),
        }
    }

    pub(super) fn after_world(&self, what: &str) -> Result<(), SceneError> {
        match self.in_world {
            false => self.refuse(format!("{what} before WorldBegin"), "it belongs after"),
            true => Ok(()),
        }
    }
}
