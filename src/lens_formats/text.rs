//! Text of a lens file: its encoding, its lines and their errors.

use std::path::Path;

use petzval_base::io::excerpt;
use petzval_lens::LensError;

/// Decodes a file: UTF-8 or UTF-16 by its mark, UTF-16 without one by its zeros, UTF-8, or Latin-1.
pub(crate) fn decode(bytes: &[u8]) -> String {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        String::from_utf16_lossy(&units.collect::<Vec<u16>>())
    };
    let head = &bytes[..bytes.len().min(64)];
    let zeros = |odd: usize| head.iter().skip(odd).step_by(2).filter(|&&byte| byte == 0).count();
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => decode(rest),
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        _ if head.len() >= 8 && 4 * zeros(1) > head.len() => wide(bytes, u16::from_le_bytes),
        _ if head.len() >= 8 && 4 * zeros(0) > head.len() => wide(bytes, u16::from_be_bytes),
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
        },
    }
}

/// A line of a lens file, for errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a> {
    /// Path of the file.
    pub path: &'a Path,
    /// Number of the line, from 1.
    pub number: usize,
    /// The line, without its end.
    pub text: &'a str,
}

impl<'a> Line<'a> {
    /// Returns the lines of a text.
    pub fn all(path: &'a Path, text: &'a str) -> impl Iterator<Item = Self> {
        (1..).zip(text.lines()).map(move |(number, text)| Self { path, number, text })
    }

    /// Returns the words between blanks.
    pub fn words(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        self.text.split_whitespace()
    }

    /// Returns an error of this line; the column is that of `word` if it is a part of the line.
    pub fn error(&self, word: &str, found: impl Into<String>, expected: &str) -> LensError {
        let at = (word.as_ptr() as usize).checked_sub(self.text.as_ptr() as usize);
        let inside = at.filter(|&at| at <= self.text.len() && self.text.is_char_boundary(at));
        LensError::Malformed {
            path: self.path.to_owned(),
            line: self.number,
            column: inside.map(|at| 1 + self.text[..at].chars().count()),
            found: found.into(),
            expected: expected.to_owned(),
        }
    }

    /// Parses a word of this line as a radius or a distance, which may be infinite: "inf",
    /// "-Infinity", "1e400".
    ///
    /// # Errors
    /// Returns an error with line and column if it is none.
    pub fn length_of(&self, word: &str) -> Result<f64, LensError> {
        match word.parse::<f64>() {
            Ok(length) if length.is_infinite() => Ok(length),
            _ => self.number_of(word),
        }
    }

    /// Parses a word of this line as a finite number.
    ///
    /// # Errors
    /// Returns an error with line and column if it is none.
    pub fn number_of(&self, word: &str) -> Result<f64, LensError> {
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(
                word,
                format!("\"{}\" is not a finite number", excerpt(word)),
                "expected a number",
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_encodings_give_the_same_text() {
        let text = "MODE SEQ\nNAME x";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let marked = |mark: &[u8], rest: &[u8]| [mark, rest].concat();
        for bytes in [
            text.as_bytes().to_vec(),
            marked(&[0xef, 0xbb, 0xbf], text.as_bytes()),
            little.clone(),
            big.clone(),
            marked(&[0xff, 0xfe], &little),
            marked(&[0xfe, 0xff], &big),
        ] {
            assert_eq!(decode(&bytes), text);
        }
        assert_eq!(decode(b"\xb5m"), "\u{b5}m");
        assert_eq!(decode(b""), "");
    }

    #[test]
    fn an_error_names_the_column_of_its_word() {
        let line = Line { path: Path::new("a.zmx"), number: 3, text: "  CURV x1" };
        let word = line.words().nth(1).expect("a word");
        let error = line.number_of(word).expect_err("no number").to_string();
        assert!(error.starts_with("a.zmx:3:8: \"x1\""), "{error}");
    }
}
