//! Excerpts of input for messages: a very long word or path must not hide the rest of a message.

use std::path::Path;

use super::printable::is_unprintable;

/// Limit of the characters of input that a message shows in one piece.
const MAX_CHARACTERS: usize = 80;
/// Number of them from the start of the input. The end of a path is more specific than its start.
const FRONT_CHARACTERS: usize = 30;
/// Replaces the omitted characters.
const ELLIPSIS: char = '…';

/// Returns input as a message shows it: on one line, and with an ellipsis in its middle if it is
/// longer than 80 characters.
pub fn excerpt(input: &str) -> String {
    let flat = |c: char| if is_unprintable(c) { ' ' } else { c };
    // The input may be a whole file: only its ends are read.
    let Some((most, _)) = input.char_indices().nth(MAX_CHARACTERS) else {
        return input.chars().map(flat).collect();
    };
    let front = input[..most].chars().take(FRONT_CHARACTERS);
    let back: Vec<char> = input.chars().rev().take(MAX_CHARACTERS - FRONT_CHARACTERS - 1).collect();
    front.chain([ELLIPSIS]).chain(back.into_iter().rev()).map(flat).collect()
}

/// Returns a path as a message shows it, by [`excerpt`].
pub fn path_excerpt(path: &Path) -> String {
    excerpt(&path.to_string_lossy())
}

/// Returns a message in which every word and every quotation is replaced by its [`excerpt`].
pub fn excerpt_words(message: &str) -> String {
    let mut text = String::new();
    let mut rest = message;
    while let Some(first) = rest.chars().next() {
        let (piece, behind) = rest.split_at(piece_length(rest, text.chars().next_back()));
        let quoted = piece.strip_prefix(first).and_then(|inner| inner.strip_suffix(first));
        match quoted.filter(|_| QUOTES.contains(&first)) {
            _ if first.is_whitespace() => text.push_str(piece),
            Some(inner) => {
                text.push(first);
                text.push_str(&excerpt(inner));
                text.push(first);
            }
            None => text.push_str(&excerpt(piece)),
        }
        rest = behind;
    }
    text
}

const QUOTES: [char; 2] = ['"', '\''];

/// Bytes of the blanks, of the quotation or of the word that a text begins with, behind a
/// character.
fn piece_length(text: &str, before: Option<char>) -> usize {
    let until = |end: &dyn Fn(char) -> bool| text.find(end).unwrap_or(text.len());
    let first = text.chars().next().unwrap_or(' ');
    if first.is_whitespace() {
        return until(&|c| !c.is_whitespace());
    }
    // A quote after a letter or digit is an apostrophe.
    let opens = |before: Option<char>| !before.is_some_and(char::is_alphanumeric);
    if QUOTES.contains(&first) && opens(before) {
        let ends = text[1..].match_indices(first).map(|(at, _)| at + 2);
        let closes = |end: &usize| !text[*end..].starts_with(char::is_alphanumeric);
        if let Some(end) = ends.into_iter().find(closes) {
            return end;
        }
    }
    let mut last = Some(first);
    for (at, c) in text.char_indices().skip(1) {
        if c.is_whitespace() || (QUOTES.contains(&c) && opens(last)) {
            return at;
        }
        last = Some(c);
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_input_is_unchanged_and_long_input_keeps_both_ends() {
        let short = "é".repeat(MAX_CHARACTERS);
        assert_eq!(excerpt(&short), short);
        let long = format!("start{}end", "é".repeat(1000));
        let found = excerpt(&long);
        assert_eq!(found.chars().count(), MAX_CHARACTERS);
        assert!(found.starts_with("start") && found.contains(ELLIPSIS) && found.ends_with("end"));
        assert_eq!(excerpt("a\n\u{1b}[2Jb"), "a  [2Jb");
        assert!(path_excerpt(Path::new(&format!("/{long}/a.pbrt"))).ends_with("end/a.pbrt"));
    }

    #[test]
    fn words_and_quotations_are_cut_and_messages_are_not() {
        let plain = "a.pbrt:3:1: the lens's \"one two\" isn't 'three'\n  and the picture's \"four";
        assert_eq!(excerpt_words(plain), plain);
        let prose = "word ".repeat(100);
        assert_eq!(excerpt_words(&prose), prose);
        let [word, words] = ["q".repeat(1000), "q ".repeat(1000)];
        for message in [
            format!("a.pbrt:3:1: found {word}; expected less"),
            format!("a.pbrt:3:1: found \"{words}\"; expected less"),
            format!("a.pbrt:3:1: found '{words}' and \"{word}\"; expected less"),
            format!("a.pbrt:3:1: found (\"{words}\"); expected less"),
            format!("a.pbrt:3:1: found \"{word}; expected less"),
        ] {
            let found = excerpt_words(&message);
            assert!(found.chars().count() < 220, "{found}");
            assert!(found.starts_with("a.pbrt:3:1: found ") && found.ends_with("; expected less"));
        }
        let place =
            excerpt_words(&format!("/{}a.pbrt:12:345: found nothing", "folder/".repeat(50)));
        assert!(place.ends_with("folder/a.pbrt:12:345: found nothing"), "{place}");
    }
}
