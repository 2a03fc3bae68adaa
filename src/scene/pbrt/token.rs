//! The words of a scene file.

use std::path::Path;
use std::sync::Arc;

use super::SceneError;
use crate::source::{Location, excerpt};

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
    /// The end of a file that is imported.
    End,
}

impl Word {
    /// How an error message shows it.
    pub(super) fn shown(&self) -> String {
        match self {
            Self::Name(name) => excerpt(name),
            Self::Text(text) => format!("\"{}\"", excerpt(text)),
            Self::Number(number) => excerpt(&number.to_string()),
            Self::Open => "[".to_owned(),
            Self::Close => "]".to_owned(),
            Self::End => "the end of the file".to_owned(),
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
    /// Whether the end of the file is a word of its own.
    pub(super) imported: bool,
}

/// The bytes that no word of a name or number holds.
const ENDS: [bool; 256] = {
    let mut ends = [false; 256];
    let mut rest: &[u8] = b" \t\n\r\x0c[]\"#";
    while let [byte, others @ ..] = rest {
        ends[*byte as usize] = true;
        rest = others;
    }
    ends
};

impl Lexer {
    pub(super) fn new(file: Arc<Path>, text: Vec<u8>) -> Self {
        Self { file, text, next: 0, line: 1, counted: (0, 1), imported: false }
    }

    /// Where a token stands.
    pub(super) fn place(&self, token: &Token) -> Location {
        Location { file: self.file.clone(), line: token.line, column: token.column }
    }

    /// Where reading has come to.
    pub(super) fn here(&self) -> Location {
        Location { file: self.file.clone(), line: self.line, column: self.column(self.next) }
    }

    /// The word behind the last one.
    pub(super) fn end(&self) -> Token {
        Token { word: Word::End, line: self.line, column: self.column(self.next) }
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
                let word = self.word();
                if first.is_ascii_alphabetic() {
                    Word::Name(String::from_utf8_lossy(word).into_owned())
                } else {
                    Word::Number(number(word).map_err(|found| SceneError::at(at, found, ""))?)
                }
            }
        };
        Ok(Some(Token { word, line, column }))
    }

    /// The bytes of a word that has begun.
    fn word(&mut self) -> &[u8] {
        let start = self.next;
        let length = self.text[start..].iter().position(|&b| ENDS[usize::from(b)]);
        self.next = length.map_or(self.text.len(), |n| start + n);
        &self.text[start..self.next]
    }

    /// As many numbers as follow. They are most of what large scenes hold.
    pub(super) fn numbers(&mut self, into: &mut Vec<f64>) -> Result<(), SceneError> {
        loop {
            self.skip_blanks();
            let start = self.next;
            let first = self.text.get(start);
            if !first.is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b)) {
                return Ok(());
            }
            match number(self.word()) {
                Ok(number) => into.push(number),
                Err(found) => {
                    self.next = start;
                    return Err(SceneError::at(self.here(), found, ""));
                }
            }
        }
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

/// The number that a word is, or what is wrong with it.
fn number(word: &[u8]) -> Result<f64, String> {
    if let Some(number) = short_decimal(word) {
        return Ok(number);
    }
    let text = String::from_utf8_lossy(word);
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(format!("the number {} is out of range", excerpt(&text))),
        Err(_) => Err(format!("\"{}\" is no number and no directive", excerpt(&text))),
    }
}

/// A decimal of few digits: both its digits and its power of ten are exact, so that one
/// rounding gives what correct rounding gives (Clinger 1990, "How to read floating point
/// numbers accurately"). `None` is no verdict.
fn short_decimal(word: &[u8]) -> Option<f64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.len() > 17 {
        return None;
    }
    let (mut whole, mut point, mut behind) = (0u64, false, 0usize);
    for &byte in digits {
        match byte {
            b'0'..=b'9' => {
                whole = 10 * whole + u64::from(byte - b'0');
                behind += usize::from(point);
            }
            b'.' if !point => point = true,
            _ => return None,
        }
    }
    if digits.len() == usize::from(point) || whole >= 1 << 53 {
        return None;
    }
    let value = whole as f64 / TENS[behind];
    Some(if negative { -value } else { value })
}

/// The powers of ten that are exact and that a short decimal can need.
const TENS: [f64; 18] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_decimals_round_as_the_standard_library_does() {
        for word in [
            "0",
            "-0",
            "1",
            "+2",
            "-3.5",
            ".5",
            "5.",
            "0.1",
            "-.25",
            "123456.789",
            "0.30000000000",
            "9007199254740991",
            "9007199254740993",
            "0.1234567890123456",
            "3.4028235e38",
            "1e-7",
            "16777217.0000001",
            "00000000000000001",
            "72057594037927945",
        ] {
            let expected: f64 = word.parse().unwrap();
            assert_eq!(number(word.as_bytes()).unwrap().to_bits(), expected.to_bits(), "{word}");
        }
        for word in ["", "-", ".", "+.", "1.2.3", "--1", "1-", "0x10", "1e", "é"] {
            assert!(number(word.as_bytes()).is_err(), "{word}");
        }
    }
}
