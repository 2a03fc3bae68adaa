//! The words of a scene file.

use std::path::Path;
use std::sync::Arc;

use super::SceneError;
use crate::source::Location;

/// One word.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Word {
    /// A directive, or `true`, `false`.
    Name(String),
    /// Something in quotes.
    Text(String),
    /// A number.
    Number(f64),
    /// `[`
    Open,
    /// `]`
    Close,
}

impl Word {
    /// How an error message shows it.
    pub(super) fn shown(&self) -> String {
        match self {
            Self::Name(name) => name.chars().take(60).collect(),
            Self::Text(text) => format!("\"{}\"", text.chars().take(60).collect::<String>()),
            Self::Number(number) => number.to_string(),
            Self::Open => "[".to_owned(),
            Self::Close => "]".to_owned(),
        }
    }
}

/// A word and where it stands.
#[derive(Clone, Debug)]
pub(super) struct Token {
    pub(super) word: Word,
    line: u32,
    column: u32,
}

/// Splits a file into words.
#[derive(Clone, Debug)]
pub(super) struct Lexer {
    file: Arc<Path>,
    text: Vec<u8>,
    next: usize,
    line: u32,
    /// A place in the line and its column: columns are counted on from there, so that a line
    /// may hold a million words.
    counted: (usize, u32),
}

impl Lexer {
    pub(super) fn new(file: Arc<Path>, text: Vec<u8>) -> Self {
        Self { file, text, next: 0, line: 1, counted: (0, 1) }
    }

    /// Where a token stands.
    pub(super) fn place(&self, token: &Token) -> Location {
        Location { file: self.file.clone(), line: token.line, column: token.column }
    }

    /// Where reading has come to.
    pub(super) fn here(&self) -> Location {
        Location { file: self.file.clone(), line: self.line, column: self.column(self.next) }
    }

    fn column(&self, at: usize) -> u32 {
        let (from, column) = self.counted;
        // Every byte but those that continue a UTF-8 character.
        let characters = self.text[from..at].iter().filter(|&&b| b & 0xc0 != 0x80).count();
        column + characters as u32
    }

    /// The next word, or `None` at the end of the file.
    pub(super) fn token(&mut self) -> Result<Option<Token>, SceneError> {
        self.skip_blanks();
        let start = self.next;
        let Some(&first) = self.text.get(start) else { return Ok(None) };
        let (line, column) = (self.line, self.column(start));
        self.counted = (start, column);
        let at = Location { file: self.file.clone(), line, column };
        let word = match first {
            b'[' => {
                self.next += 1;
                Word::Open
            }
            b']' => {
                self.next += 1;
                Word::Close
            }
            b'"' => Word::Text(self.quoted(&at)?),
            _ => {
                let ends = |b: u8| b.is_ascii_whitespace() || b"[]\"#".contains(&b);
                let length = self.text[start..].iter().position(|&b| ends(b));
                self.next = length.map_or(self.text.len(), |n| start + n);
                let text = String::from_utf8_lossy(&self.text[start..self.next]).into_owned();
                if first.is_ascii_alphabetic() { Word::Name(text) } else { number(text, at)? }
            }
        };
        Ok(Some(Token { word, line, column }))
    }

    fn skip_blanks(&mut self) {
        while let Some(&byte) = self.text.get(self.next) {
            match byte {
                b'\n' => {
                    self.line += 1;
                    self.counted = (self.next + 1, 1);
                }
                b'#' => {
                    let rest = &self.text[self.next..];
                    self.next += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
                    continue;
                }
                _ if byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.next += 1;
        }
    }

    fn quoted(&mut self, at: &Location) -> Result<String, SceneError> {
        let mut text = Vec::new();
        let mut i = self.next + 1;
        loop {
            match self.text.get(i).copied() {
                Some(b'"') => break,
                None | Some(b'\n') => {
                    return Err(SceneError::at(
                        at.clone(),
                        "a quoted string that does not end on its line",
                        "close it with \"",
                    ));
                }
                Some(b'\\') => {
                    i += 1;
                    text.push(match self.text.get(i).copied() {
                        Some(b'n') => b'\n',
                        Some(b't') => b'\t',
                        Some(b'r') => b'\r',
                        Some(other @ (b'\\' | b'"' | b'\'')) => other,
                        _ => {
                            return Err(SceneError::at(
                                at.clone(),
                                "an unknown escape in a quoted string",
                                "known are \\n \\t \\r \\\\ \\\" \\'",
                            ));
                        }
                    });
                }
                Some(byte) => text.push(byte),
            }
            i += 1;
        }
        self.next = i + 1;
        String::from_utf8(text).map_err(|_| {
            SceneError::at(at.clone(), "a string that is not UTF-8", "write it in UTF-8")
        })
    }
}

fn number(text: String, at: Location) -> Result<Word, SceneError> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(Word::Number(number)),
        Ok(_) => Err(SceneError::at(at, format!("the number {text} is out of range"), "")),
        Err(_) => {
            let shown: String = text.chars().take(60).collect();
            Err(SceneError::at(at, format!("\"{shown}\" is no number and no directive"), ""))
        }
    }
}
