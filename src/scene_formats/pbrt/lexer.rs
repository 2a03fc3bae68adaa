//! Lexer: splits the text of a scene file into tokens.

use std::path::Path;
use std::sync::Arc;

use super::numbers::parse_number;
use super::{SceneError, message};
use petzval_base::io::{Location, excerpt, foreign_scene, wide_encoding, without_byte_order_mark};

/// The kind and value of a token.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum TokenKind {
    /// A directive, or `true`, `false`.
    Name(String),
    /// A string in quotes, without them.
    Text(String),
    /// A number.
    Number(f64),
    /// `[`
    Open,
    /// `]`
    Close,
    /// The end of an imported file.
    End,
}

impl TokenKind {
    /// Returns the token as an error message shows it.
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

/// A token and its position in its file.
#[derive(Clone, Debug)]
pub(super) struct Token {
    pub(super) kind: TokenKind,
    line: u32,
    column: u32,
}

/// The lexer of one file.
#[derive(Clone, Debug)]
pub(super) struct Lexer {
    file: Arc<Path>,
    text: Arc<Vec<u8>>,
    next: usize,
    line: u32,
    /// A position in the line from which columns are counted on, so that the time for a line of a
    /// million tokens stays linear.
    counted: Counted,
    /// Whether the end of the file is a token of its own.
    pub(super) imported: bool,
}

/// A position between two tokens of a text.
#[derive(Clone, Copy, Debug)]
pub(super) struct LexerPosition {
    next: usize,
    line: u32,
    counted: Counted,
}

/// A byte offset and its column.
#[derive(Clone, Copy, Debug)]
struct Counted {
    offset: usize,
    column: u32,
}

impl Counted {
    fn line_start(offset: usize) -> Self {
        Self { offset, column: 1 }
    }
}

/// The bytes that end a name or number.
const DELIMITERS: [bool; 256] = {
    let mut delimiters = [false; 256];
    let mut rest: &[u8] = b" \t\n\r\x0c[]\"#";
    while let [byte, others @ ..] = rest {
        delimiters[*byte as usize] = true;
        rest = others;
    }
    delimiters
};

impl Lexer {
    pub(super) fn new(file: Arc<Path>, text: Arc<Vec<u8>>) -> Self {
        let next = text.len() - without_byte_order_mark(&text).len();
        Self { file, text, next, line: 1, counted: Counted::line_start(next), imported: false }
    }

    /// Returns the file.
    pub(super) fn file(&self) -> &Arc<Path> {
        &self.file
    }

    /// Returns the text of the file.
    pub(super) fn text(&self) -> &[u8] {
        &self.text
    }

    /// Returns the text of the file, to share.
    pub(super) fn shared_text(&self) -> &Arc<Vec<u8>> {
        &self.text
    }

    /// Returns the position after the last token.
    pub(super) fn position(&self) -> LexerPosition {
        LexerPosition { next: self.next, line: self.line, counted: self.counted }
    }

    /// Continues at a position of the same text.
    pub(super) fn seek(&mut self, LexerPosition { next, line, counted }: LexerPosition) {
        (self.next, self.line, self.counted) = (next, line, counted);
    }

    /// Returns the number of bytes that are read.
    pub(super) fn offset(&self) -> usize {
        self.next
    }

    /// Returns the location of a token of this file.
    pub(super) fn location(&self, token: &Token) -> Location {
        Location { file: self.file.clone(), line: token.line, column: token.column }
    }

    /// Returns an error if the file is not a scene in the language of pbrt: of another encoding, of
    /// another program, or empty.
    pub(super) fn check_language(&self) -> Result<(), SceneError> {
        let found = if let Some(encoding) = wide_encoding(&self.text) {
            format!("the text is in {encoding}; save it as UTF-8")
        } else if let Some(kind) = foreign_scene(&self.text) {
            let remedy = match kind {
                "a PLY mesh" => ": name it there, in Shape \"plymesh\"",
                "a glTF scene" | "a glTF scene (GLB)" => ", or a name that ends in .gltf or .glb",
                "a lens file" => ": name it there, or with 'lens'",
                _ => "",
            };
            format!("this looks like {kind}; expected a scene in the language of pbrt{remedy}")
        } else {
            return Ok(());
        };
        Err(SceneError::NotText { at: self.here(), message: found })
    }

    /// Returns whether the text has a `WorldEnd`, which pbrt-v4 does not have.
    pub(super) fn has_world_end(&self) -> bool {
        const WORD: &[u8] = b"WorldEnd";
        let is_there = |line: &[u8]| {
            let code = line.split(|&b| b == b'#').next().unwrap_or(line);
            code.split(|&b| DELIMITERS[usize::from(b)]).any(|word| word == WORD)
        };
        // It is one of the last lines.
        self.text.rsplit(|&b| b == b'\n' || b == b'\r').any(is_there)
    }

    /// Returns the location of the next byte to be read.
    pub(super) fn here(&self) -> Location {
        Location { file: self.file.clone(), line: self.line, column: self.column(self.next) }
    }

    /// Returns the token at the end of an imported file.
    pub(super) fn end(&self) -> Token {
        Token { kind: TokenKind::End, line: self.line, column: self.column(self.next) }
    }

    fn column(&self, at: usize) -> u32 {
        let Counted { offset, column } = self.counted;
        // Counts every byte but those that continue a UTF-8 character.
        let characters = self.text[offset..at].iter().filter(|&&b| b & 0xc0 != 0x80).count();
        column + characters as u32
    }

    /// Returns the next token, or `None` at the end of the file.
    pub(super) fn token(&mut self) -> Result<Option<Token>, SceneError> {
        self.skip_blanks();
        let start = self.next;
        let Some(&first) = self.text.get(start) else { return Ok(None) };
        let (line, column) = (self.line, self.column(start));
        self.counted = Counted { offset: start, column };
        let at = Location { file: self.file.clone(), line, column };
        let kind = match first {
            b'[' => {
                self.next += 1;
                TokenKind::Open
            }
            b']' => {
                self.next += 1;
                TokenKind::Close
            }
            b'"' => TokenKind::Text(self.quoted(&at)?),
            // Control characters: of another kind of file.
            0..b' ' | 0x7f => {
                let found = format!("found the byte {first:#04x}, which is not text");
                let expected = "expected a scene in the language of pbrt";
                return Err(SceneError::NotText { at, message: message(found, expected) });
            }
            _ => {
                let word = self.word();
                if first.is_ascii_alphabetic() {
                    TokenKind::Name(String::from_utf8_lossy(word).into_owned())
                } else {
                    let number = parse_number(word);
                    TokenKind::Number(number.map_err(|found| SceneError::at(at, found, ""))?)
                }
            }
        };
        Ok(Some(Token { kind, line, column }))
    }

    /// Reads the bytes of a name or number up to the next delimiter.
    fn word(&mut self) -> &[u8] {
        let start = self.next;
        let length = self.text[start..].iter().position(|&b| DELIMITERS[usize::from(b)]);
        self.next = length.map_or(self.text.len(), |n| start + n);
        &self.text[start..self.next]
    }

    /// Reads all numbers that follow. This is the fast path for the lists of large meshes.
    pub(super) fn numbers(&mut self, into: &mut Vec<f64>) -> Result<(), SceneError> {
        loop {
            self.skip_blanks();
            let start = self.next;
            let first = self.text.get(start);
            if !first.is_some_and(|b| b.is_ascii_digit() || b"+-.".contains(b)) {
                return Ok(());
            }
            match parse_number(self.word()) {
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
                    self.counted = Counted::line_start(self.next + 1);
                }
                b'#' => {
                    let rest = &self.text[self.next..];
                    let end = rest.iter().position(|&b| b == b'\n' || b == b'\r');
                    self.next += end.unwrap_or(rest.len());
                    continue;
                }
                _ if byte.is_ascii_whitespace() => {}
                _ => return,
            }
            self.next += 1;
        }
    }

    /// Reads a string in quotes. An error skips the rest of its line.
    fn quoted(&mut self, at: &Location) -> Result<String, SceneError> {
        let mut text = Vec::new();
        let mut i = self.next + 1;
        let line = self.text[self.next..].iter().position(|&b| b == b'\n');
        self.next = line.map_or(self.text.len(), |n| self.next + n);
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
