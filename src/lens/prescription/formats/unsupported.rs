//! Files of unsupported formats, recognised by their first lines.

use std::path::Path;

use crate::lens::prescription::error::LensError;

/// Number of bytes that are examined.
const HEAD: usize = 4096;

/// Returns an error that names the format of the file and advises, if it is a known unsupported
/// one.
pub(crate) fn reject(path: &Path, bytes: &[u8]) -> Option<LensError> {
    // UTF-16, as Zemax writes it, has a NUL beside every ASCII letter.
    let head = bytes.iter().take(HEAD).copied().filter(|&byte| byte != 0).collect::<Vec<u8>>();
    let text = String::from_utf8_lossy(&head);
    let lines = (1..).zip(text.lines()).map(|(number, line)| {
        let line = line.trim_start_matches(['\u{feff}', '\u{fffd}']);
        (number, 1 + line.len() - line.trim_start().len(), line.trim())
    });
    let mut lines = lines.filter(|(_, _, line)| !line.is_empty() && !line.starts_with('#'));
    let first = lines.next()?;
    let (found, advice) = detect_format(path, first.2)?;
    let (line, column, _) = first;
    Some(LensError::Malformed {
        path: path.to_owned(),
        line,
        column: Some(column),
        found: format!("{found}, not a lens table"),
        expected: advice,
    })
}

/// Returns the format of a file that begins with this line, and what to do about it.
fn detect_format(path: &Path, line: &str) -> Option<(&'static str, String)> {
    let begins = |words: &[&str]| {
        let begins = |word: &&str| {
            line.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
        };
        words.iter().any(begins)
    };
    let named =
        |extension: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension));
    if begins(&["version https://git-lfs."]) {
        let advice = "it stands for a file that was not fetched: run `git lfs pull` in its \
                      repository, or download the file itself";
        return Some(("a Git LFS pointer", advice.to_owned()));
    }
    if begins(&["<!doctype", "<html", "<head", "<?xml"]) {
        let advice = "download the file itself (the \"raw\" one), not the page that shows it";
        return Some(("a web page or XML", advice.to_owned()));
    }
    let key = line.split_once('=').map_or("", |(key, _)| key.trim());
    let is_word = |word: &str| {
        !word.is_empty() && word.chars().all(|c| c.is_ascii_alphanumeric() || "_-.".contains(c))
    };
    if !named("toml") && (line.starts_with("[[") || is_word(key)) {
        let name = path.with_extension("toml");
        let name = name.file_name().unwrap_or_default().to_string_lossy().into_owned();
        return Some(("a lens in TOML", format!("its name has to end in .toml: rename it {name}")));
    }
    None
}
