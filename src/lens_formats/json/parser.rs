//! Parser of JSON that keeps the place of every value.
//!
//! Lens files in JSON come from Python, which writes `Infinity` and `NaN`: JSON has neither, and
//! serde_json refuses them and forgets the lines of values, which errors name. Comments (`//`) and a
//! comma before a closing bracket are accepted: people edit these files by hand.

use std::path::Path;

use super::value::{Content, Json};
use crate::text::Line;
use petzval_base::io::excerpt;
use petzval_lens::LensError;

/// Deepest nesting.
const DEPTH: usize = 64;

/// Parses a text.
///
/// # Errors
/// Returns an error with line and column if the text is not one JSON value.
pub(super) fn parse<'a>(path: &'a Path, text: &'a str) -> Result<Json<'a>, LensError> {
    let mut lines: Vec<Line<'a>> = Line::all(path, text).collect();
    if lines.is_empty() {
        lines.push(Line { path, number: 1, text: "" });
    }
    let mut parser = Parser { lines, line: 0, at: 0 };
    let value = parser.value(0)?;
    parser.skip();
    match parser.rest() {
        "" => Ok(value),
        _ => Err(parser.error("text after the end of the JSON value", "remove it")),
    }
}

struct Parser<'a> {
    lines: Vec<Line<'a>>,
    line: usize,
    at: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        &self.lines[self.line].text[self.at..]
    }

    fn error(&self, found: &str, expected: &str) -> LensError {
        self.lines[self.line].error(self.rest(), found, expected)
    }

    /// Skips blanks, ends of lines and comments.
    fn skip(&mut self) {
        loop {
            let rest = self.rest();
            let start = rest.trim_start();
            self.at += rest.len() - start.len();
            let ends = start.is_empty() || start.starts_with("//");
            if !ends {
                return;
            }
            if self.line + 1 == self.lines.len() {
                self.at = self.lines[self.line].text.len();
                return;
            }
            (self.line, self.at) = (self.line + 1, 0);
        }
    }

    fn eat(&mut self, sign: char) -> bool {
        self.skip();
        let found = self.rest().starts_with(sign);
        self.at += if found { sign.len_utf8() } else { 0 };
        found
    }

    fn value(&mut self, depth: usize) -> Result<Json<'a>, LensError> {
        self.skip();
        let (line, word) = (self.lines[self.line], self.rest());
        if depth > DEPTH {
            return Err(self.error("values nested more than 64 deep", "expected a lens"));
        }
        let content = match word.chars().next() {
            Some('{') => self.object(depth)?,
            Some('[') => self.values(depth)?,
            Some('"') => Content::Text(self.string()?),
            _ => self.scalar()?,
        };
        Ok(Json { line, word, content })
    }

    fn object(&mut self, depth: usize) -> Result<Content<'a>, LensError> {
        let mut members = Vec::new();
        self.eat('{');
        while !self.eat('}') {
            if !self.rest().starts_with('"') {
                return Err(self.error("no name of a member", "expected \"name\": value, or }"));
            }
            let name = self.string()?;
            if !self.eat(':') {
                return Err(self.error("no colon behind the name", "expected \"name\": value"));
            }
            members.push((name, self.value(depth + 1)?));
            if !self.eat(',') && !self.rest().starts_with('}') {
                return Err(self.error("no comma behind the member", "expected , or }"));
            }
        }
        Ok(Content::Object(members))
    }

    fn values(&mut self, depth: usize) -> Result<Content<'a>, LensError> {
        let mut list = Vec::new();
        self.eat('[');
        while !self.eat(']') {
            list.push(self.value(depth + 1)?);
            if !self.eat(',') && !self.rest().starts_with(']') {
                return Err(self.error("no comma behind the value", "expected , or ]"));
            }
        }
        Ok(Content::List(list))
    }

    fn string(&mut self) -> Result<String, LensError> {
        let rest = &self.rest()[1..];
        let mut text = String::new();
        let mut signs = rest.char_indices();
        while let Some((at, sign)) = signs.next() {
            match sign {
                '"' => {
                    self.at += at + 2;
                    return Ok(text);
                }
                '\\' => match signs.next().map(|(_, sign)| sign) {
                    Some('n') => text.push('\n'),
                    Some('t') => text.push('\t'),
                    Some('u') => {
                        let digits: String = signs.by_ref().take(4).map(|(_, sign)| sign).collect();
                        let code = u32::from_str_radix(&digits, 16).ok();
                        text.push(code.and_then(char::from_u32).unwrap_or('\u{fffd}'));
                    }
                    Some(sign) => text.push(sign),
                    None => break,
                },
                sign => text.push(sign),
            }
        }
        Err(self.error("a text without its closing quotation mark", "expected it in this line"))
    }

    fn scalar(&mut self) -> Result<Content<'a>, LensError> {
        let rest = self.rest();
        let ends = |sign: char| sign.is_whitespace() || ",]}:/".contains(sign);
        let word = &rest[..rest.find(ends).unwrap_or(rest.len())];
        let content = match word {
            "null" | "None" => Content::Null,
            "true" | "True" => Content::Bool(true),
            "false" | "False" => Content::Bool(false),
            _ => match word.parse() {
                Ok(number) => Content::Number(number),
                Err(_) => {
                    let found = match word {
                        "" => "no value".to_owned(),
                        _ => format!("\"{}\" is no JSON value", excerpt(word)),
                    };
                    return Err(
                        self.error(&found, "expected a number, a text, a list or an object")
                    );
                }
            },
        };
        self.at += word.len();
        Ok(content)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &'static str) -> Result<Json<'static>, LensError> {
        parse(Path::new("a.json"), text)
    }

    #[test]
    fn values_of_python_are_read() {
        let value = parsed("{\"a\": [1, -Infinity, NaN,], // x\n \"b\": {\"c\": \"d\\u0041\"}}");
        let value = value.expect("a value");
        let list = value.need("a").expect("a member").list().expect("a list");
        assert_eq!(list[1].number_or_infinity().expect("a number"), f64::NEG_INFINITY);
        assert!(list[2].number_or_infinity().is_err());
        let text = value.get("b").and_then(|b| b.get("c")).and_then(Json::text);
        assert_eq!(text, Some("dA"));
    }

    #[test]
    fn errors_name_line_and_column() {
        for (text, place) in [
            ("{\n  \"a\": x1}", "a.json:2:8: \"x1\" is no JSON value"),
            ("{\"a\" 1}", "a.json:1:6: no colon"),
            ("[1 2]", "a.json:1:4: no comma"),
            ("{\"a", "a.json:1:2: a text without"),
            ("", "a.json:1:1: no value"),
            ("1 2", "a.json:1:3: text after"),
        ] {
            let error = parsed(text).expect_err(text).to_string();
            assert!(error.starts_with(place), "{error}");
        }
        let deep = "[".repeat(100_000);
        assert!(parse(Path::new("a.json"), &deep).is_err());
        let value = parsed("{\"a\":\n [1, \"b\"]}").expect("a value");
        let error = value.need("a").expect("a").numbers().expect_err("a text").to_string();
        assert!(error.starts_with("a.json:2:6: \"b\" is no finite number"), "{error}");
    }
}
