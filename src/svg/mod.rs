//! The few words of SVG that drawings and plots need.

mod raster;

pub(crate) use raster::{picture, raster};

use std::fmt::Write as _;

/// A point: to the right and up in the lens (mm), to the right and down on the sheet (px).
pub(crate) type Point = [f64; 2];

/// The name of no particular typeface, so that the drawing takes that of its surroundings.
const FONT: &str = "Helvetica, Arial, sans-serif";

/// How wide a character is, at most, in units of the type size: bold capitals of the wide
/// sans-serifs. Letters of other scripts are as wide as they are high.
const CHARACTER: f64 = 0.72;

/// A sheet of paper, in px.
#[derive(Debug, Default)]
pub(crate) struct Sheet {
    body: String,
}

impl Sheet {
    /// Opens a group whose members share these attributes.
    pub(crate) fn open(&mut self, attributes: &str) {
        let _ = writeln!(self.body, "<g {attributes}>");
    }

    /// Closes the group opened last.
    pub(crate) fn close(&mut self) {
        self.body.push_str("</g>\n");
    }

    /// A polyline, or a polygon if `closed`.
    pub(crate) fn path(&mut self, points: &[Point], closed: bool, attributes: &str) {
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

    /// Words; the point is the left end of their base line.
    pub(crate) fn text(&mut self, [x, y]: Point, size: f64, attributes: &str, words: &str) {
        let (x, y, size) = (number(x), number(y), number(size));
        let gap = if attributes.is_empty() { "" } else { " " };
        let words = escape(words);
        let _ = writeln!(
            self.body,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{gap}{attributes}>{words}</text>"
        );
    }

    /// A circle.
    pub(crate) fn circle(&mut self, [x, y]: Point, radius: f64, attributes: &str) {
        let (x, y, radius) = (number(x), number(y), number(radius));
        let _ = writeln!(self.body, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" {attributes}/>");
    }

    /// The whole file, black on white.
    pub(crate) fn finish(self, [width, height]: Point, title: &str) -> String {
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

    /// A part of an HTML page, in the page's colour of text and without a ground of its own.
    pub(crate) fn inline(self, [width, height]: Point, title: &str) -> String {
        let (width, height, title) = (number(width), number(height), escape(title));
        format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"{FONT}\" \
             fill=\"currentColor\">\n<title>{title}</title>\n{}</svg>\n",
            self.body
        )
    }
}

/// How wide words are at most, px.
pub(crate) fn width(words: &str, size: f64) -> f64 {
    words.chars().map(|c| if c.is_ascii() { CHARACTER } else { 1.0 }).sum::<f64>() * size
}

/// As much of the words as fits.
pub(crate) fn shortened(words: &str, size: f64, room: f64) -> String {
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

/// Two decimals: a hundredth of a pixel is finer than any printer.
fn number(value: f64) -> String {
    // Not even a lens of 1e300 mm may write what is no number.
    let value = if value.is_finite() { value.clamp(-1e6, 1e6) } else { 0.0 };
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Words as XML holds them; what XML 1.0 cannot hold becomes U+FFFD.
pub(crate) fn escape(words: &str) -> String {
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
            // Words that turn the direction of writing would turn what follows them, too.
            '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => text.push('\u{fffd}'),
            _ => text.push(c),
        }
    }
    text
}
