//! Parser: strings, numbers and parameter lists from tokens, across included files.

use super::SceneError;
use super::lexer::{Token, TokenKind};
use super::params::{Param, Params, Values, kind_hint, kind_of};
use super::reader::SceneReader;
use super::recovery::begins_directive;
use petzval_base::io::Location;

/// Whether a parameter list may hold names without a type.
#[derive(Clone, Copy, PartialEq)]
enum Declarations {
    /// `"type name"`.
    Typed,
    /// `"type name"` or `"name"`.
    MaybeUntyped,
}

impl SceneReader {
    /// Returns the next token. At the end of an included file it continues in the file that
    /// includes it.
    pub(super) fn next(&mut self) -> Result<Option<Token>, SceneError> {
        if let Some(token) = self.peeked.take() {
            return Ok(Some(token));
        }
        while let Some(lexer) = self.lexers.last_mut() {
            if let Some(token) = lexer.token()? {
                return Ok(Some(token));
            }
            if lexer.imported {
                return Ok(Some(lexer.end()));
            }
            if self.lexers.len() == 1 {
                return Ok(None);
            }
            self.lexers.pop();
        }
        Ok(None)
    }

    pub(super) fn peek(&mut self) -> Result<Option<&TokenKind>, SceneError> {
        if self.peeked.is_none() {
            self.peeked = self.next()?;
        }
        Ok(self.peeked.as_ref().map(|token| &token.kind))
    }

    pub(super) fn location(&self, token: &Token) -> Location {
        self.lexers.last().map_or_else(|| self.at.clone(), |lexer| lexer.location(token))
    }

    /// Returns the error for a token, or the end of the file, that is not what was expected.
    /// It stays the next one if it begins a directive.
    pub(super) fn unexpected(&mut self, token: Option<Token>, expected: &str) -> SceneError {
        match token {
            Some(token) => {
                let at = self.location(&token);
                let found = format!("found {}", token.kind.shown());
                if begins_directive(&token.kind) {
                    self.peeked = Some(token);
                }
                SceneError::at(at, found, expected)
            }
            None => SceneError::at(self.at.clone(), "the file ends here", expected),
        }
    }

    pub(super) fn string(&mut self) -> Result<String, SceneError> {
        match self.next()? {
            Some(Token { kind: TokenKind::Text(text), .. }) => {
                self.recovery.note(&text);
                Ok(text)
            }
            other => Err(self.unexpected(other, "expected a string in quotes")),
        }
    }

    /// Reads `N` numbers, with or without brackets.
    pub(super) fn numbers<const N: usize>(&mut self) -> Result<[f64; N], SceneError> {
        let expected = format!("expected {N} numbers");
        let bracket = matches!(self.peek()?, Some(TokenKind::Open));
        if bracket {
            self.next()?;
        }
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            match self.next()? {
                Some(Token { kind: TokenKind::Number(value), .. }) => *number = value,
                other => return Err(self.unexpected(other, &expected)),
            }
        }
        if bracket {
            match self.next()? {
                Some(Token { kind: TokenKind::Close, .. }) => {}
                other => return Err(self.unexpected(other, &format!("{expected} and a ]"))),
            }
        }
        Ok(numbers)
    }

    /// Reads a parameter list: all `"type name" values` that follow.
    pub(super) fn params(&mut self) -> Result<Params, SceneError> {
        self.param_list(Declarations::Typed)
    }

    /// Reads the parameter list of `Option`, whose names need no type, as in `"seed" 7`.
    pub(super) fn option_params(&mut self) -> Result<Params, SceneError> {
        self.param_list(Declarations::MaybeUntyped)
    }

    fn param_list(&mut self, declarations: Declarations) -> Result<Params, SceneError> {
        let mut all = Vec::new();
        while matches!(self.peek()?, Some(TokenKind::Text(_))) {
            let Some(token) = self.next()? else { break };
            let at = self.location(&token);
            let TokenKind::Text(declaration) = &token.kind else { break };
            let words: Vec<&str> = declaration.split_whitespace().collect();
            let (kind, name) = match words[..] {
                [kind, name] => (Some(kind), name),
                [name] if declarations == Declarations::MaybeUntyped => (None, name),
                _ => {
                    let found = format!("found {}", token.kind.shown());
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
            self.params_end = self.lexers.last().map(|lexer| (self.lexers.len(), lexer.position()));
        }
        Ok(self.params_of(all))
    }

    /// Returns parameters of the current directive.
    pub(super) fn params_of(&self, all: Vec<Param>) -> Params {
        let (space, folder) = (self.state.colour_space, self.folder.clone());
        Params { all, at: self.at.clone(), space, folder, context: self.context.clone() }
    }

    /// Reads one value, or several in brackets.
    pub(super) fn values(&mut self, name: &str) -> Result<Values, SceneError> {
        let expected = format!("expected a value for \"{name}\", or several of one kind in [ ]");
        let bracket = matches!(self.peek()?, Some(TokenKind::Open));
        if bracket {
            self.next()?;
        }
        let mut values: Option<Values> = None;
        loop {
            let token = self.next()?;
            let kind = token.as_ref().map(|token| token.kind.clone());
            match (kind, &mut values) {
                (Some(TokenKind::Close), _) if bracket => break,
                (Some(TokenKind::Number(v)), None) => {
                    let mut all = vec![v];
                    if bracket && let Some(lexer) = self.lexers.last_mut() {
                        lexer.numbers(&mut all)?;
                    }
                    values = Some(Values::Numbers(all));
                }
                (Some(TokenKind::Number(v)), Some(Values::Numbers(all))) => all.push(v),
                (Some(TokenKind::Text(v)), None) => values = Some(Values::Texts(vec![v])),
                (Some(TokenKind::Text(v)), Some(Values::Texts(all))) => all.push(v),
                (Some(TokenKind::Name(v)), known) if v == "true" || v == "false" => match known {
                    None => values = Some(Values::Booleans(vec![v == "true"])),
                    Some(Values::Booleans(all)) => all.push(v == "true"),
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

    /// Warns, at the current directive, of a feature that is not supported.
    pub(super) fn warn_unsupported(&mut self, feature: &str, instead: &str) {
        self.warnings.unsupported(&self.at, feature, instead);
    }

    /// Returns an error at the current directive.
    pub(super) fn refuse<T>(
        &self,
        found: impl Into<String>,
        expected: &str,
    ) -> Result<T, SceneError> {
        Err(SceneError::at(self.at.clone(), found, expected))
    }

    /// Returns an error if a directive stands after `WorldBegin`.
    pub(super) fn require_before_world(&self, directive: &str) -> Result<(), SceneError> {
        match self.in_world {
            true => {
                self.refuse(format!("{directive} after WorldBegin"), "move it before WorldBegin")
            }
            false => Ok(()),
        }
    }

    /// Returns an error if a directive stands before `WorldBegin`, and none has before it: the
    /// `WorldBegin` may be missing.
    pub(super) fn require_in_world(&mut self, directive: &str) -> Result<(), SceneError> {
        match self.in_world || std::mem::replace(&mut self.recovery.world_missed, true) {
            false => {
                self.refuse(format!("{directive} before WorldBegin"), "move it after WorldBegin")
            }
            true => Ok(()),
        }
    }
}
