//! Lists of pictures in the format of EMVA 1288 data sets.

use std::path::{Path, PathBuf};

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
    /// Files.
    pub pictures: Vec<PathBuf>,
}

/// Light of a set of pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Photons a pixel, if they are stated.
    pub photons: Option<f64>,
}

/// Parses a list of pictures: a line `b EXPOSURE PHOTONS` or `d EXPOSURE` begins a set with or without light, and each
/// line `i FILE` adds a picture to it; a time is in ns, and photons may be left out. Lines `n` and `v` (bits and size,
/// version) are not needed, and `#` begins a comment. Files are relative to `folder`.
///
/// # Errors
/// Returns an error with line and column if a line is none of these, if a set has fewer than two pictures, or if there
/// are no dark pictures of its exposure time.
pub fn parse_data_file(text: &str, folder: &Path) -> Result<Vec<PictureSet>, String> {
    let mut sets: Vec<PictureSet> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let number = i + 1;
        let word_at = |words: &str| 1 + line.len() - words.trim_start().len();
        let trimmed = line.trim();
        let (kind, rest) = trimmed.split_once(char::is_whitespace).unwrap_or((trimmed, ""));
        let rest = rest.trim();
        let mut numbers = rest.split_whitespace();
        let mut next = |what: &str| -> Result<Option<f64>, String> {
            let Some(word) = numbers.next() else { return Ok(None) };
            match word.parse::<f64>().ok().filter(|value| value.is_finite() && *value >= 0.0) {
                Some(value) => Ok(Some(value)),
                None => {
                    let column = 1 + line.find(word).unwrap_or(0);
                    Err(format!("{number}:{column}: expected {what}, found {word:?}"))
                }
            }
        };
        match kind {
            "" | "n" | "v" => {}
            _ if kind.starts_with('#') => {}
            "b" | "d" => {
                let Some(exposure) = next("an exposure time in ns")? else {
                    return Err(format!(
                        "{number}:1: expected an exposure time in ns after {kind:?}"
                    ));
                };
                let light = match kind {
                    "b" => Some(Light { photons: next("photons a pixel")?.filter(|&n| n > 0.0) }),
                    _ => None,
                };
                if let Some(word) = numbers.next() {
                    let column = 1 + line.rfind(word).unwrap_or(0);
                    return Err(format!(
                        "{number}:{column}: expected the end of the line, found {word:?}"
                    ));
                }
                sets.push(PictureSet { line: number, exposure, light, pictures: Vec::new() });
            }
            "i" if rest.is_empty() => {
                return Err(format!("{number}:1: expected the name of a picture after \"i\""));
            }
            "i" => match sets.last_mut() {
                // Data sets are made on Windows.
                Some(set) => set.pictures.push(folder.join(rest.replace('\\', "/"))),
                None => {
                    return Err(format!(
                        "{number}:1: a picture before any set; expected \"b EXPOSURE PHOTONS\" or \"d EXPOSURE\" first"
                    ));
                }
            },
            _ => {
                return Err(format!(
                    "{number}:{}: expected a line that begins with b, d or i (light, dark, picture), found {:?}",
                    word_at(trimmed),
                    petzval_base::io::excerpt(kind)
                ));
            }
        }
    }
    for PictureSet { line, exposure, light, pictures } in &sets {
        if pictures.len() < 2 {
            return Err(format!(
                "{line}:1: the set has {} of at least 2 pictures; noise shows between two of the same exposure",
                pictures.len()
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
                    i a\ni b\nd 1e6\ni c\n i d\ni e\nd 5\ni f\ni g\n";
        let found = parse_data_file(text, Path::new("/data")).unwrap();
        let path = |name: &str| PathBuf::from("/data").join(name);
        let light = |photons| Some(Light { photons });
        let expected = [
            (4, 1e6, light(Some(1659.7)), vec![path("images/a 1.png"), path("b.png")]),
            (8, 5.0, light(None), vec![path("a"), path("b")]),
            (11, 1e6, None, vec![path("c"), path("d"), path("e")]),
            (15, 5.0, None, vec![path("f"), path("g")]),
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
            ("b 1 2 3", "1:7: expected the end of the line, found \"3\""),
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
