//! Files of samples by wavelength: text with comments, and the faults that all of them may have.

use std::path::PathBuf;
#[cfg(test)]
use std::{path::Path, sync::Arc};

use super::params::Params;
use super::{SceneError, resolve};
use petzval_base::io::{Location, ReadError, path_excerpt};
use petzval_spectrum::VISIBLE;

/// Limit of the size of a file (bytes).
const MAX_FILE_SIZE: usize = 1 << 24;

/// A file of samples, such as a spectrum or the response of a camera.
pub(super) struct SampleFile {
    /// The parameter that names it.
    at: Location,
    path: PathBuf,
    text: String,
}

/// A fault in a file: its line and column, from 1, and what was found.
#[derive(Debug)]
pub(super) struct Fault {
    pub line: usize,
    pub column: usize,
    pub found: String,
}

/// A word of a line.
#[derive(Clone, Copy)]
pub(super) struct Word<'a> {
    text: &'a str,
    line: usize,
    column: usize,
}

impl SampleFile {
    /// Reads the file of a name, relative to the folder of the scene. `unknown` returns what was found and
    /// expected if it cannot be read.
    pub fn read(
        params: &Params,
        at: Location,
        name: &str,
        unknown: impl FnOnce(ReadError) -> (String, String),
    ) -> Result<Self, SceneError> {
        let path = resolve(&params.folder, name);
        let (found, expected) = match params.context.bytes(&path) {
            Ok(bytes) if bytes.len() <= MAX_FILE_SIZE => {
                return Ok(Self { at, path, text: String::from_utf8_lossy(&bytes).into_owned() });
            }
            Ok(_) => {
                let found = format!("the file {} is too long", path_excerpt(&path));
                (found, "expected at most 16 MiB".to_owned())
            }
            Err(source) => unknown(source),
        };
        Err(SceneError::at(at, found, expected))
    }

    /// A file of this text.
    #[cfg(test)]
    pub fn of(text: &str) -> Self {
        let at = Location { file: Arc::from(Path::new("test.pbrt")), line: 1, column: 1 };
        Self { at, path: PathBuf::new(), text: text.to_owned() }
    }

    /// Returns the words of each line, without comments. Blanks, commas and semicolons divide them.
    pub fn lines(&self) -> impl Iterator<Item = Vec<Word<'_>>> {
        self.text.lines().zip(1..).map(|(whole, line)| {
            let data = whole.split('#').next().unwrap_or_default().trim_start_matches('\u{feff}');
            let column = |text: &str| {
                // A word is a part of its line.
                let bytes = text.as_ptr() as usize - whole.as_ptr() as usize;
                whole[..bytes].chars().count() + 1
            };
            data.split(|c: char| c.is_whitespace() || c == ',' || c == ';')
                .filter(|text| !text.is_empty())
                .map(|text| Word { text, line, column: column(text) })
                .collect()
        })
    }

    /// Returns a fault of the file as a whole.
    pub fn fault_at_end(&self, found: String) -> Fault {
        Fault { line: self.text.lines().count().max(1), column: 1, found }
    }

    /// Returns the error of a fault in the file.
    pub fn refuse(&self, fault: Fault, expected: &str) -> SceneError {
        let Fault { line, column, found } = fault;
        let found = format!("{}:{line}:{column}: {found}", path_excerpt(&self.path));
        SceneError::at(self.at.clone(), found, expected)
    }
}

impl Word<'_> {
    /// Returns the number that it is.
    pub fn number(self) -> Result<f64, Fault> {
        let number = self.text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| self.fault(format!("found {:?}", self.text)))
    }

    /// Returns a fault in its place.
    pub fn fault(self, found: String) -> Fault {
        Fault { line: self.line, column: self.column, found }
    }
}

/// Returns an error if samples from the first to the last wavelength (nm) see no light.
pub(super) fn check_visible(first: f64, last: f64) -> Result<(), String> {
    let [low, high] = VISIBLE.map(f64::from);
    if first < high && last > low {
        return Ok(());
    }
    let found = format!("wavelengths from {first} to {last} nm, none of them visible");
    Err(if last < 10.0 { format!("{found}; micrometres are 1000 nm") } else { found })
}
