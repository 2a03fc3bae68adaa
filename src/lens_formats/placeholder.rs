//! Placeholders of downloads, recognised by their first lines.

use std::path::Path;

use petzval_lens::LensError;

/// Returns an error that says what the file is and what to do, if it is no lens but stands for one.
pub(crate) fn reject(path: &Path, text: &str) -> Option<LensError> {
    let lines = (1..)
        .zip(text.lines())
        .map(|(number, line)| (number, 1 + line.len() - line.trim_start().len(), line.trim()));
    let mut lines = lines.filter(|(_, _, line)| !line.is_empty() && !line.starts_with('#'));
    let first = lines.next()?;
    let (found, advice) = placeholder(first.2)?;
    let (line, column, _) = first;
    Some(LensError::Malformed {
        path: path.to_owned(),
        line,
        column: Some(column),
        found: format!("{found}, not a lens table"),
        expected: advice.to_owned(),
    })
}

/// Returns what a file is that begins with this line, and what to do about it.
fn placeholder(line: &str) -> Option<(&'static str, &'static str)> {
    let begins = |words: &[&str]| {
        let begins = |word: &&str| {
            line.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
        };
        words.iter().any(begins)
    };
    if begins(&["version https://git-lfs."]) {
        let advice = "it stands for a file that was not fetched: run `git lfs pull` in its \
                      repository, or download the file itself";
        return Some(("a Git LFS pointer", advice));
    }
    if begins(&["<!doctype", "<html", "<head", "<?xml"]) {
        let advice = "download the file itself (the \"raw\" one), not the page that shows it";
        return Some(("a web page or XML", advice));
    }
    None
}
