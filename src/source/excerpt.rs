//! Excerpts of input for messages: an absurdly long word or path must not bury what is said of it.

use std::path::Path;

/// The most characters of input that a message shows in one piece.
const MOST: usize = 80;
/// How many of them are from its start. The end of a path says more than its start.
const FRONT: usize = 30;
/// Stands for what is left out.
const ELLIPSIS: char = '…';

/// Input as a message shows it: on one line, and with an ellipsis in its middle where it is longer
/// than 80 characters.
pub fn excerpt(input: &str) -> String {
    let flat = |c: char| if c.is_control() { ' ' } else { c };
    // Only a few characters of what may be a whole file are looked at.
    let Some((most, _)) = input.char_indices().nth(MOST) else {
        return input.chars().map(flat).collect();
    };
    let front = input[..most].chars().take(FRONT);
    let back: Vec<char> = input.chars().rev().take(MOST - FRONT - 1).collect();
    front.chain([ELLIPSIS]).chain(back.into_iter().rev()).map(flat).collect()
}

/// A path as a message shows it; see [`excerpt`].
pub fn shown(path: &Path) -> String {
    excerpt(&path.to_string_lossy())
}

/// A message with an [`excerpt`] of every word and of everything in quotes.
pub fn excerpts(message: &str) -> String {
    let mut text = String::new();
    let mut rest = message;
    while let Some(first) = rest.chars().next() {
        let (piece, behind) = rest.split_at(piece(rest, text.chars().next_back()));
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

/// Bytes of the blanks, of the quotation or of the word that a text begins with, behind a character.
fn piece(text: &str, before: Option<char>) -> usize {
    let until = |end: &dyn Fn(char) -> bool| text.find(end).unwrap_or(text.len());
    let first = text.chars().next().unwrap_or(' ');
    if first.is_whitespace() {
        return until(&|c| !c.is_whitespace());
    }
    // An apostrophe begins nothing.
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
    fn what_is_short_stays_and_what_is_long_keeps_both_ends() {
        let short = "é".repeat(MOST);
        assert_eq!(excerpt(&short), short);
        let long = format!("start{}end", "é".repeat(1000));
        let found = excerpt(&long);
        assert_eq!(found.chars().count(), MOST);
        assert!(found.starts_with("start") && found.contains(ELLIPSIS) && found.ends_with("end"));
        assert_eq!(excerpt("a\n\u{1b}[2Jb"), "a  [2Jb");
        assert!(shown(Path::new(&format!("/{long}/a.pbrt"))).ends_with("end/a.pbrt"));
    }

    #[test]
    fn words_and_quotations_of_a_message_are_cut_and_the_message_is_not() {
        let plain = "a.pbrt:3:1: the lens's \"one two\" isn't 'three'\n  and the picture's \"four";
        assert_eq!(excerpts(plain), plain);
        let prose = "word ".repeat(100);
        assert_eq!(excerpts(&prose), prose);
        let [word, words] = ["q".repeat(1000), "q ".repeat(1000)];
        for message in [
            format!("a.pbrt:3:1: found {word}; expected less"),
            format!("a.pbrt:3:1: found \"{words}\"; expected less"),
            format!("a.pbrt:3:1: found '{words}' and \"{word}\"; expected less"),
            format!("a.pbrt:3:1: found (\"{words}\"); expected less"),
            format!("a.pbrt:3:1: found \"{word}; expected less"),
        ] {
            let found = excerpts(&message);
            assert!(found.chars().count() < 220, "{found}");
            assert!(found.starts_with("a.pbrt:3:1: found ") && found.ends_with("; expected less"));
        }
        let place = excerpts(&format!("/{}a.pbrt:12:345: found nothing", "folder/".repeat(50)));
        assert!(place.ends_with("folder/a.pbrt:12:345: found nothing"), "{place}");
    }
}
