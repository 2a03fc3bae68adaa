//! Reader of glass catalogues in Zemax's AGF format.
//!
//! A glass is a line "NM name formula code nd Vd ...", then "CD" with the coefficients and "LD" with the
//! range (um); the other lines describe its chemistry and price.

mod formula;
mod text;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{CatalogueGlass, GlassError};
use crate::io::{ReadContext, excerpt};

/// Largest size of a catalogue (bytes). The largest of a maker has 2 MB.
const MAX_BYTES: usize = 1 << 26;

/// Reads a catalogue, or all of a folder in the order of their names, and logs the files.
///
/// # Errors
/// Returns an error if a file cannot be read or is not a catalogue, or if a folder has none.
pub(super) fn read(
    path: &Path,
    context: &ReadContext,
) -> Result<Vec<Arc<CatalogueGlass>>, GlassError> {
    let mut glasses = Vec::new();
    for file in files(path)? {
        let bytes = context
            .bytes(&file)
            .map_err(|error| GlassError::Io { path: error.path, source: error.source })?;
        if bytes.len() > MAX_BYTES {
            let source = std::io::Error::other("it is larger than 64 MiB");
            return Err(GlassError::Io { path: file, source });
        }
        glasses.extend(parse(&file, &bytes)?.into_iter().map(Arc::new));
    }
    Ok(glasses)
}

fn files(path: &Path) -> Result<Vec<PathBuf>, GlassError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let io = |source| GlassError::Io { path: path.to_owned(), source };
    let mut files = Vec::new();
    for entry in path.read_dir().map_err(io)? {
        let file = entry.map_err(io)?.path();
        if file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("agf")) {
            files.push(file);
        }
    }
    files.sort();
    match files.is_empty() {
        true => Err(io(std::io::Error::other("the folder has no .agf file"))),
        false => Ok(files),
    }
}

/// Returns the glasses of a catalogue in UTF-8, UTF-16 or Latin-1. Its name without the extension is
/// their maker.
///
/// # Errors
/// Returns an error if a line is invalid, or if there is no glass.
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<CatalogueGlass>, GlassError> {
    let maker = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut glasses = Vec::new();
    let mut open: Option<Entry> = None;
    // Coefficients may go on in the lines that follow.
    let mut in_coefficients = false;
    for (number, line) in (1..).zip(text::decode(bytes).lines()) {
        let mut words = line.split_whitespace();
        let (keyword, words) = (words.next().unwrap_or_default(), words.collect::<Vec<_>>());
        let at = Place { path, number, keyword };
        in_coefficients = keyword == "CD" || (in_coefficients && keyword.parse::<f64>().is_ok());
        match (keyword, &mut open) {
            ("NM", _) => {
                if let Some(entry) = open.replace(Entry::new(&at, &words)?) {
                    glasses.push(entry.finish(path, &maker)?);
                }
            }
            ("CD", Some(entry)) => entry.coefficients = Some(at.numbers(&words)?),
            (first, Some(Entry { coefficients: Some(coefficients), .. })) if in_coefficients => {
                coefficients.extend(at.numbers(&[first])?);
                coefficients.extend(at.numbers(&words)?);
            }
            ("LD", Some(entry)) => entry.range = Some(at.range(&words)?),
            _ => {}
        }
    }
    if let Some(entry) = open {
        glasses.push(entry.finish(path, &maker)?);
    }
    match glasses.is_empty() {
        true => {
            let at = Place { path, number: 1, keyword: "" };
            Err(at.error("no glass in the file".into(), "expected an AGF catalogue with NM lines"))
        }
        false => Ok(glasses),
    }
}

/// A glass whose lines are being read.
struct Entry {
    number: usize,
    name: String,
    formula: u32,
    published: Option<[f64; 2]>,
    coefficients: Option<Vec<f64>>,
    range: Option<[f64; 2]>,
}

impl Entry {
    fn new(at: &Place, words: &[&str]) -> Result<Self, GlassError> {
        let [name, formula, rest @ ..] = words else {
            return Err(
                at.error("NM without a name and a formula".into(), "expected NM NAME FORMULA")
            );
        };
        let number = formula.parse::<f64>().ok().filter(|formula| formula.fract() == 0.0);
        let Some(formula) = number.filter(|number| (1.0..=13.0).contains(number)) else {
            let found = format!("formula \"{}\" of {}", excerpt(formula), excerpt(name));
            return Err(at.error(found, "expected 1 to 13"));
        };
        let figure =
            |i: usize| rest.get(i)?.parse::<f64>().ok().filter(|x| x.is_finite() && *x > 0.0);
        Ok(Self {
            number: at.number,
            name: (*name).to_owned(),
            formula: formula as u32,
            published: figure(1).zip(figure(2)).map(|(nd, vd)| [nd, vd]),
            coefficients: None,
            range: None,
        })
    }

    fn finish(self, path: &Path, maker: &str) -> Result<CatalogueGlass, GlassError> {
        let at = Place { path, number: self.number, keyword: "NM" };
        let missing = |line: &str| {
            at.error(
                format!("the glass {} has no {line} line", excerpt(&self.name)),
                "expected NM, CD and LD lines for every glass",
            )
        };
        let coefficients = self.coefficients.as_ref().ok_or_else(|| missing("CD"))?;
        let range = self.range.ok_or_else(|| missing("LD"))?;
        Ok(CatalogueGlass {
            formula: formula::formula(self.formula, coefficients),
            name: self.name.into(),
            maker: maker.to_owned().into(),
            published: self.published,
            range,
        })
    }
}

/// A line of a catalogue, for messages.
struct Place<'a> {
    path: &'a Path,
    number: usize,
    keyword: &'a str,
}

impl Place<'_> {
    fn error(&self, found: String, expected: &str) -> GlassError {
        GlassError::Malformed {
            path: self.path.to_owned(),
            line: self.number,
            found,
            expected: expected.to_owned(),
        }
    }

    fn numbers(&self, words: &[&str]) -> Result<Vec<f64>, GlassError> {
        let mut numbers = Vec::with_capacity(words.len());
        for word in words {
            let number = word.parse().ok().filter(|number: &f64| number.is_finite());
            numbers.push(number.ok_or_else(|| {
                let found = format!("{} has \"{}\"", self.keyword, excerpt(word));
                self.error(found, "expected finite numbers")
            })?);
        }
        Ok(numbers)
    }

    /// Returns the range of a glass (nm) from its line (um).
    fn range(&self, words: &[&str]) -> Result<[f64; 2], GlassError> {
        let numbers = self.numbers(words)?;
        let [low, high] = [0, 1].map(|i| numbers.get(i).map_or(0.0, |um| um * 1000.0));
        match 0.0 < low && low <= high && high <= 1e7 {
            true => Ok([low, high]),
            false => {
                let found = format!("LD from {low} to {high} nm");
                Err(self.error(found, "expected the shortest and the longest wavelength in um"))
            }
        }
    }
}

#[cfg(test)]
mod tests;
