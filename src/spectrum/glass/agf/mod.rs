//! Reader of glass catalogues in Zemax's AGF format.
//!
//! A glass is a line "NM name formula code nd Vd ...", then "CD" with the coefficients, "LD" with the
//! range (um), and "IT wavelength share thickness" (um, mm) for every measured internal transmittance;
//! the other lines describe its chemistry and price.

mod formula;
mod text;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{Absorption, CatalogueGlass, GlassError, InternalTransmittance};
use petzval_base::io::{ReadContext, excerpt};

/// Largest size of a catalogue (bytes). The largest of a maker has 2 MB.
const MAX_BYTES: usize = 1 << 26;

/// A glass of a catalogue whose lines are invalid: an error where it is used.
#[derive(Debug)]
pub(super) struct FaultyGlass {
    /// Name in the catalogue.
    pub name: String,
    /// The first fault.
    pub error: GlassError,
}

/// Glasses of catalogues.
#[derive(Debug, Default)]
pub(super) struct Catalogue {
    pub glasses: Vec<Arc<CatalogueGlass>>,
    pub faulty: Vec<FaultyGlass>,
}

/// Reads a catalogue, or all of a folder in the order of their names, and logs the files.
///
/// # Errors
/// Returns an error if a file cannot be read or has no valid glass, or if a folder has none.
pub(super) fn read(path: &Path, context: &ReadContext) -> Result<Catalogue, GlassError> {
    let mut all = Catalogue::default();
    for file in files(path)? {
        let bytes = context
            .bytes(&file)
            .map_err(|error| GlassError::Io { path: error.path, source: error.source })?;
        if bytes.len() > MAX_BYTES {
            let source = std::io::Error::other("it is larger than 64 MiB");
            return Err(GlassError::Io { path: file, source });
        }
        let Catalogue { glasses, mut faulty } = parse_all(&file, &bytes)?;
        if glasses.is_empty() && !faulty.is_empty() {
            return Err(faulty.swap_remove(0).error);
        }
        all.glasses.extend(glasses);
        all.faulty.extend(faulty);
    }
    Ok(all)
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
    let Catalogue { glasses, faulty } = parse_all(path, bytes)?;
    match faulty.into_iter().next() {
        Some(first) => Err(first.error),
        None => Ok(glasses.into_iter().map(Arc::unwrap_or_clone).collect()),
    }
}

/// Returns the valid and the faulty glasses of a catalogue.
///
/// # Errors
/// Returns an error if there is neither.
pub(super) fn parse_all(path: &Path, bytes: &[u8]) -> Result<Catalogue, GlassError> {
    let maker = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut all = Catalogue::default();
    let mut open: Option<Entry> = None;
    // Coefficients may go on in the lines that follow.
    let mut in_coefficients = false;
    for (number, line) in (1..).zip(text::decode(bytes).lines()) {
        let mut words = line.split_whitespace();
        let (keyword, words) = (words.next().unwrap_or_default(), words.collect::<Vec<_>>());
        let at = Place { path, number, keyword };
        in_coefficients = keyword == "CD" || (in_coefficients && keyword.parse::<f64>().is_ok());
        if keyword == "NM" {
            all.close(open.take(), path, &maker);
            match Entry::new(&at, &words) {
                Ok(entry) => open = Some(entry),
                Err(error) => all.refuse(words.first().copied().unwrap_or_default(), error),
            }
        } else if let Some(entry) = &mut open
            && let Err(error) = entry.read(&at, &words, in_coefficients)
        {
            all.refuse(&entry.name, error);
            open = None;
        }
    }
    all.close(open, path, &maker);
    match all.glasses.is_empty() && all.faulty.is_empty() {
        true => {
            let at = Place { path, number: 1, keyword: "" };
            Err(at.error("no glass in the file".into(), "expected an AGF catalogue with NM lines"))
        }
        false => Ok(all),
    }
}

impl Catalogue {
    /// Adds a glass whose lines are complete.
    fn close(&mut self, entry: Option<Entry>, path: &Path, maker: &str) {
        let Some(entry) = entry else { return };
        let name = entry.name.clone();
        match entry.finish(path, maker) {
            Ok(glass) => self.glasses.push(Arc::new(glass)),
            Err(error) => self.refuse(&name, error),
        }
    }

    fn refuse(&mut self, name: &str, error: GlassError) {
        self.faulty.push(FaultyGlass { name: name.to_owned(), error });
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
    transmittances: Vec<InternalTransmittance>,
    /// First line without an internal transmittance, and the number of such lines.
    unusable: Option<[usize; 2]>,
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
            transmittances: Vec::new(),
            unusable: None,
        })
    }

    /// Reads a line behind NM.
    fn read(
        &mut self,
        at: &Place,
        words: &[&str],
        in_coefficients: bool,
    ) -> Result<(), GlassError> {
        match (at.keyword, &mut self.coefficients) {
            ("CD", coefficients) => *coefficients = Some(at.numbers(words)?),
            (first, Some(coefficients)) if in_coefficients => {
                coefficients.extend(at.numbers(&[first])?);
                coefficients.extend(at.numbers(words)?);
            }
            ("LD", _) => self.range = Some(at.range(words)?),
            ("IT", _) => match at.internal_transmittance(words) {
                Some(measured) => self.transmittances.push(measured),
                // Makers state -999 where they have none; the index is right all the same.
                None => self.unusable.get_or_insert([at.number, 0])[1] += 1,
            },
            _ => {}
        }
        Ok(())
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
        let mut absorption = Absorption::new(self.transmittances);
        absorption.unusable = self.unusable;
        Ok(CatalogueGlass {
            formula: formula::formula(self.formula, coefficients),
            name: self.name.into(),
            maker: maker.to_owned().into(),
            published: self.published,
            range,
            absorption,
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

    /// Returns an internal transmittance; `None` if the line has none that can have been measured.
    fn internal_transmittance(&self, words: &[&str]) -> Option<InternalTransmittance> {
        let numbers = self.numbers(words).ok()?;
        let &[um, share, thickness, ..] = &numbers[..] else { return None };
        let measured = InternalTransmittance { nm: um * 1000.0, share, thickness };
        measured.is_valid().then_some(measured)
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
