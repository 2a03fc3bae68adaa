//! Lists of pictures in the format of EMVA 1288 data sets.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use petzval_base::io::excerpt;

/// Largest difference of exposure times that are the same, relative to them.
const SAME_TIME: f64 = 1e-6;

/// A set of pictures with the same exposure.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSet {
    /// Number of its line in the list, from 1.
    pub line: usize,
    /// Exposure time (ns).
    pub exposure: f64,
    /// The light; `None` in the dark.
    pub light: Option<Light>,
    /// Pictures.
    pub pictures: Vec<ListedPicture>,
}

/// A picture of a list.
#[derive(Clone, Debug, PartialEq)]
pub struct ListedPicture {
    /// Number of its line in the list, from 1.
    pub line: usize,
    /// File.
    pub path: PathBuf,
}

/// Light of a set of pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Photons a pixel, if they are stated.
    pub photons: Option<f64>,
}

/// A word of a line, and its column, from 1.
type Word<'a> = (usize, &'a str);

/// Returns the words of a line up to a comment.
fn words(line: &str) -> Vec<Word<'_>> {
    let mut words = Vec::new();
    let mut start = None;
    for (at, c) in line.char_indices().chain([(line.len(), ' ')]) {
        match (start, c.is_whitespace()) {
            (None, false) => start = Some(at),
            (Some(from), true) => {
                words.push((line[..from].chars().count() + 1, &line[from..at]));
                start = None;
            }
            _ => {}
        }
    }
    let comment = words.iter().position(|(_, word)| word.starts_with('#'));
    words.truncate(comment.unwrap_or(words.len()));
    words
}

/// Returns a number that is not negative.
fn number((column, word): Word<'_>, what: &str) -> Result<f64, (usize, String)> {
    let value = word.parse::<f64>().ok().filter(|value| value.is_finite() && *value >= 0.0);
    value.ok_or_else(|| (column, format!("expected {what}, found {:?}", excerpt(word))))
}

/// Parses a list of pictures: a line `b EXPOSURE PHOTONS` or `d EXPOSURE` begins a set with or without light, and each
/// line `i FILE` adds a picture to it; a time is in ns, and photons may be left out. Lines `n` and `v` (bits and size,
/// version) are not needed, and words that begin with `#` comments, but in names. Files are relative to `folder`.
///
/// # Errors
/// Returns an error with line and column if a line is none of these, if a set has fewer than two pictures or one twice, or
/// if there are no dark pictures of its exposure time.
pub fn parse_data_file(text: &str, folder: &Path) -> Result<Vec<PictureSet>, String> {
    let mut sets: Vec<PictureSet> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        parse_line(i + 1, line, folder, &mut sets)
            .map_err(|(column, problem)| format!("{}:{column}: {problem}", i + 1))?;
    }
    for PictureSet { line, exposure, light, pictures } in &sets {
        if pictures.len() < 2 {
            return Err(format!(
                "{line}:1: the set has {} of at least 2 pictures; noise shows between two of the same exposure",
                pictures.len()
            ));
        }
        let mut seen = HashSet::new();
        if let Some(twice) = pictures.iter().find(|picture| !seen.insert(&picture.path)) {
            return Err(format!(
                "{}:1: the picture is in the set already; noise shows between two different ones",
                twice.line
            ));
        }
        if light.is_some() && dark_of(&sets, *exposure).is_none() {
            return Err(format!(
                "{line}:1: no dark pictures of {exposure} ns; expected a set \"d {exposure}\""
            ));
        }
    }
    Ok(sets)
}

/// Parses a line into the sets so far, or returns a column and what is wrong there.
fn parse_line(
    number_of_line: usize,
    line: &str,
    folder: &Path,
    sets: &mut Vec<PictureSet>,
) -> Result<(), (usize, String)> {
    let words = words(line);
    match words[..] {
        [] | [(_, "n" | "v"), ..] => {}
        [(column, kind @ ("b" | "d"))] => {
            return Err((column, format!("expected an exposure time in ns after {kind:?}")));
        }
        [(_, kind @ ("b" | "d")), exposure, ref rest @ ..] => {
            let exposure = number(exposure, "an exposure time in ns")?;
            let (photons, rest) = match (kind, rest) {
                ("b", &[photons, ref rest @ ..]) => {
                    (Some(number(photons, "photons a pixel")?).filter(|&n| n > 0.0), rest)
                }
                _ => (None, rest),
            };
            if let Some((column, word)) = rest.first() {
                let found = excerpt(word);
                return Err((*column, format!("expected the end of the line, found {found:?}")));
            }
            let light = (kind == "b").then_some(Light { photons });
            sets.push(PictureSet { line: number_of_line, exposure, light, pictures: Vec::new() });
        }
        [(column, "i"), ..] => {
            let name = line.trim().trim_start_matches('i').trim();
            let Some(set) = sets.last_mut() else {
                let expected = "expected \"b EXPOSURE PHOTONS\" or \"d EXPOSURE\" first";
                return Err((column, format!("a picture before any set; {expected}")));
            };
            if name.is_empty() {
                return Err((column, "expected the name of a picture after \"i\"".to_owned()));
            }
            // Data sets are made on Windows.
            let path = folder.join(name.replace('\\', "/"));
            set.pictures.push(ListedPicture { line: number_of_line, path });
        }
        [(column, word), ..] => {
            let expected = "a line that begins with b, d or i (light, dark, picture)";
            return Err((column, format!("expected {expected}, found {:?}", excerpt(word))));
        }
    }
    Ok(())
}

/// Returns which set holds the dark pictures of an exposure time (ns): the one with the most pictures.
pub(super) fn dark_of(sets: &[PictureSet], exposure: f64) -> Option<usize> {
    let same = |set: &PictureSet| (set.exposure - exposure).abs() <= SAME_TIME * exposure;
    let darks = (0..sets.len()).filter(|&i| sets[i].light.is_none() && same(&sets[i]));
    darks.max_by_key(|&i| sets[i].pictures.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_of_a_list_have_their_pictures() {
        let text = "# Vendor: none\nv 3.0\nn 12 640 480\nb 1000000 1659.7\ni images\\a 1.png\ni b.png\r\n\n  b 5\n\
                    i a\ni b\nd 1e6\ni c\n i d\ni e\nd 5 # s\ni f\ni g#1.png\n";
        let found = parse_data_file(text, Path::new("/data")).unwrap();
        let picture =
            |line, name: &str| ListedPicture { line, path: Path::new("/data").join(name) };
        let light = |photons| Some(Light { photons });
        let expected = [
            (4, 1e6, light(Some(1659.7)), vec![picture(5, "images/a 1.png"), picture(6, "b.png")]),
            (8, 5.0, light(None), vec![picture(9, "a"), picture(10, "b")]),
            (11, 1e6, None, vec![picture(12, "c"), picture(13, "d"), picture(14, "e")]),
            (15, 5.0, None, vec![picture(16, "f"), picture(17, "g#1.png")]),
        ];
        let expected = expected.map(|(line, exposure, light, pictures)| PictureSet {
            line,
            exposure,
            light,
            pictures,
        });
        assert_eq!(found, expected);
        assert_eq!([1e6, 5.0, 6.0].map(|time| dark_of(&found, time)), [Some(2), Some(3), None]);
    }

    #[test]
    fn other_lines_are_refused_where_they_stand() {
        for (text, expected) in [
            ("i a.png", "1:1: a picture before any set"),
            ("b 1\ni", "2:1: expected the name of a picture"),
            ("b", "1:1: expected an exposure time in ns after \"b\""),
            ("b 1 many", "1:5: expected photons a pixel, found \"many\""),
            ("d -1", "1:3: expected an exposure time in ns, found \"-1\""),
            ("b 1 2 3 23", "1:7: expected the end of the line, found \"3\""),
            ("b 1 b", "1:5: expected photons a pixel, found \"b\""),
            ("d 1\ni a\ni a", "3:1: the picture is in the set already"),
            ("\n  a.png", "2:3: expected a line that begins with b, d or i"),
            ("b 1\ni a\nd 1\ni a\ni b", "1:1: the set has 1 of at least 2 pictures"),
            ("d 1", "1:1: the set has 0 of at least 2"),
            (
                "\nb 2\ni a\ni b\nd 1\ni a\ni b",
                "2:1: no dark pictures of 2 ns; expected a set \"d 2\"",
            ),
        ] {
            let found = parse_data_file(text, Path::new("")).unwrap_err();
            assert!(found.starts_with(expected), "{text}: {found}");
        }
        assert_eq!(parse_data_file("", Path::new("")), Ok(Vec::new()));
    }
}
