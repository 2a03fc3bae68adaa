//! Minimal SVG writer for drawings and plots.

mod raster;

pub use raster::{picture, png};

use std::fmt::Write as _;

/// A position: to the right and up in the lens (mm), to the right and down on the sheet (px).
pub type Position = [f64; 2];

/// Generic typefaces, so that a drawing takes that of its surroundings.
const FONT: &str = "Helvetica, Arial, sans-serif";

/// Largest width of an ASCII character relative to the type size: bold capitals of wide
/// sans-serifs. Characters of other scripts count as wide as they are high.
const CHARACTER: f64 = 0.72;

/// A drawing in the making; coordinates in px.
#[derive(Debug, Default)]
pub struct Sheet {
    body: String,
}

impl Sheet {
    /// Opens a group whose elements share these attributes.
    pub fn open(&mut self, attributes: &str) {
        let _ = writeln!(self.body, "<g {attributes}>");
    }

    /// Closes the group that was opened last.
    pub fn close(&mut self) {
        self.body.push_str("</g>\n");
    }

    /// Adds a polyline, or a polygon if `closed`.
    pub fn path(&mut self, points: &[Position], closed: bool, attributes: &str) {
        self.body.push_str("<path d=\"");
        let mut last = None;
        for &[x, y] in points {
            let written = format!("{} {}", number(x), number(y));
            if last.as_ref() == Some(&written) {
                continue;
            }
            let _ = write!(self.body, "{}{written}", if last.is_none() { 'M' } else { 'L' });
            last = Some(written);
        }
        let close = if closed { "Z" } else { "" };
        let gap = if attributes.is_empty() { "" } else { " " };
        let _ = writeln!(self.body, "{close}\"{gap}{attributes}/>");
    }

    /// Adds text; the position is the left end of its base line.
    pub fn text(&mut self, [x, y]: Position, size: f64, attributes: &str, words: &str) {
        let (x, y, size) = (number(x), number(y), number(size));
        let gap = if attributes.is_empty() { "" } else { " " };
        let words = escape(words);
        let _ = writeln!(
            self.body,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{gap}{attributes}>{words}</text>"
        );
    }

    /// Adds a circle.
    pub fn circle(&mut self, [x, y]: Position, radius: f64, attributes: &str) {
        let (x, y, radius) = (number(x), number(y), number(radius));
        let _ = writeln!(self.body, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" {attributes}/>");
    }

    /// Returns the drawing as a file, black on white.
    pub fn finish(self, [width, height]: Position, title: &str) -> String {
        let (width, height, title) = (number(width), number(height), escape(title));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{FONT}\" fill=\"#000\">\n\
             <title>{title}</title>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
             {}</svg>\n",
            self.body
        )
    }

    /// Returns the drawing as a part of an HTML page, in the page's text colour and without
    /// background.
    pub fn inline(self, [width, height]: Position, title: &str) -> String {
        let (width, height, title) = (number(width), number(height), escape(title));
        format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"{FONT}\" \
             fill=\"currentColor\">\n<title>{title}</title>\n{}</svg>\n",
            self.body
        )
    }
}

/// Returns an upper bound of the width of text (px).
pub fn width(words: &str, size: f64) -> f64 {
    words.chars().map(|c| if c.is_ascii() { CHARACTER } else { 1.0 }).sum::<f64>() * size
}

/// Shortens text, with an ellipsis, to fit into `room` px.
pub fn shortened(words: &str, size: f64, room: f64) -> String {
    if width(words, size) <= room {
        return words.to_owned();
    }
    let mut short = String::new();
    for c in words.chars() {
        short.push(c);
        if width(&short, size) > room - size {
            short.pop();
            break;
        }
    }
    short + "\u{2026}"
}

/// Formats a number with two decimals: a hundredth of a pixel is finer than any printer.
fn number(value: f64) -> String {
    // A lens of 1e300 mm must still give a valid file.
    let value = if value.is_finite() { value.clamp(-1e6, 1e6) } else { 0.0 };
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Escapes text for XML; characters that XML 1.0 cannot hold become U+FFFD.
pub fn escape(words: &str) -> String {
    let mut text = String::with_capacity(words.len());
    for c in words.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            '\t' | '\n' | '\r' => text.push(' '),
            '\0'..='\u{1f}' | '\u{7f}'..='\u{9f}' | '\u{fffe}' | '\u{ffff}' => {
                text.push('\u{fffd}');
            }
            // Bidirectional overrides would turn the text that follows, too.
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => text.push('\u{fffd}'),
            _ => text.push(c),
        }
    }
    text
}
