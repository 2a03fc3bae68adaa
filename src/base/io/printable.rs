//! Text from files as a terminal may show it: without escape sequences and hidden characters.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Returns text in which every character that a terminal obeys instead of showing it is written as
/// `\uXXXX`: control characters but the line feed and the tab, and those that hide or reorder
/// text (Unicode TR 36, "Bidirectional Text Spoofing"). TOML and JSON read that form back.
pub fn printable(text: &str) -> Cow<'_, str> {
    let obeyed = |c: char| !matches!(c, '\n' | '\t') && is_unprintable(c);
    if !text.contains(obeyed) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match (obeyed(c), u32::from(c)) {
            (false, _) => shown.push(c),
            (true, code @ ..=0xffff) => drop(write!(shown, "\\u{code:04X}")),
            (true, code) => drop(write!(shown, "\\U{code:08X}")),
        }
    }
    Cow::Owned(shown)
}

/// Returns whether a terminal obeys a character instead of showing it.
pub(crate) fn is_unprintable(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            // Marks, embeddings, overrides and isolates of direction; separators of lines.
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{206f}'
            // Characters without width, annotations and tags.
            | '\u{ad}' | '\u{180e}' | '\u{200b}' | '\u{2060}'..='\u{2065}' | '\u{feff}'
            | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_that_a_terminal_obeys_are_spelled_out() {
        let plain = "f/2 \"Biotar\" 58 mm, µ ∞ é 双高斯\n\tnext";
        assert!(matches!(printable(plain), Cow::Borrowed(text) if text == plain));
        assert_eq!(printable("a\u{1b}[2Jb\rc\u{7}"), "a\\u001B[2Jb\\u000Dc\\u0007");
        assert_eq!(printable("\u{202e}fpd\u{2066}\u{9b}31m"), "\\u202Efpd\\u2066\\u009B31m");
        assert_eq!(printable("\u{e0041}"), "\\U000E0041");
    }
}
