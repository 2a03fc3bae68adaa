//! CSV table of a sweep: the values of each picture, and digests that tell whether it is finished.

use std::fs;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use petzval_base::io::OutputFile;
use petzval_base::io::file_digest;

use crate::cli::Failure;
use crate::cli::render::TaskResult;

/// Column before those of the options.
const NAME: &str = "file";
/// Columns after those of the options.
const FIGURES: [&str; 5] = ["samples", "noise", "seconds", "content", "inputs"];

/// A finished picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct TableRow {
    /// Samples per pixel, noise if measured, and time (s).
    figures: [String; 3],
    /// Digests (BLAKE3) of the picture's file and of its inputs.
    digests: [String; 2],
}

impl TableRow {
    /// Describes a picture that was just written.
    pub fn new(picture: &Path, result: &TaskResult, inputs: String) -> io::Result<Self> {
        let noise = result.noise.map_or_else(String::new, |noise| format!("{noise:.5}"));
        let seconds = format!("{:.2}", result.time.as_secs_f64());
        let figures = [format!("{}", (result.samples * 1e3).round() / 1e3), noise, seconds];
        Ok(Self { figures, digests: [file_digest(picture)?, inputs] })
    }

    /// Returns whether the picture's file is unchanged.
    pub fn matches_file(&self, picture: &Path) -> bool {
        file_digest(picture).is_ok_and(|found| found == self.digests[0])
    }

    /// Returns whether the picture's inputs are unchanged.
    pub fn matches_inputs(&self, inputs: &str) -> bool {
        self.digests[1] == inputs
    }
}

/// Returns a picture's path relative to the folder of the table.
pub(super) fn relative_name(folder: &Path, picture: &Path) -> String {
    let folder = resolved(folder);
    let picture = resolved(picture.parent().unwrap_or(Path::new("")))
        .join(picture.file_name().unwrap_or_default());
    let both = folder.components().zip(picture.components());
    let common = both.take_while(|(one, other)| one == other).count();
    // Another drive, on Windows.
    if common == 0 {
        return picture.to_string_lossy().into_owned();
    }
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    let relative: PathBuf = up.chain(picture.components().skip(common)).collect();
    relative.to_string_lossy().into_owned()
}

/// Resolves the symbolic links of a folder, as ".." does not lead back through them.
fn resolved(folder: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
}

/// Returns the header of a table of these options.
fn header(options: &[String]) -> Vec<&str> {
    let options = options.iter().map(String::as_str);
    std::iter::once(NAME).chain(options).chain(FIGURES).collect()
}

/// A line of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    /// The picture's path relative to the table.
    pub name: String,
    /// The values of the swept options.
    pub values: Vec<String>,
    pub row: TableRow,
}

/// Reads the table of these options; no entries if there is no file.
///
/// # Errors
/// Returns an error if the file is not a table of these options, as it would be overwritten.
pub(super) fn read(path: &Path, options: &[String]) -> Result<Vec<Entry>, Failure> {
    let refused = |error: csv::Error| format!("cannot read {}: {error}", path.display());
    let file = match fs::File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        file => file.map_err(|error| refused(error.into()))?,
    };
    let mut reader = csv::Reader::from_reader(file);
    let header = header(options);
    if !reader.headers().map_err(refused)?.iter().eq(header.iter().copied()) {
        return Err(format!(
            "{} exists and is not a table of this sweep, whose first line is {}; name another \
             with --contact",
            path.display(),
            header.join(",")
        )
        .into());
    }
    let mut entries = Vec::new();
    for record in reader.records() {
        let record = record.map_err(refused)?;
        let mut cells = record.iter().map(str::to_owned);
        let name = cells.next().unwrap_or_default();
        let values = cells.by_ref().take(options.len()).collect();
        let mut next = || cells.next().unwrap_or_default();
        let figures = [next(), next(), next()];
        let row = TableRow { figures, digests: [next(), next()] };
        entries.push(Entry { name, values, row });
    }
    Ok(entries)
}

/// Writes a table of these options.
pub(super) fn write<'a>(
    file: &OutputFile,
    options: &[String],
    entries: impl Iterator<Item = &'a Entry>,
) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(header(options))?;
    for Entry { name, values, row: TableRow { figures, digests } } in entries {
        let figures = figures.iter().chain(digests);
        table.write_record(std::iter::once(name).chain(values).chain(figures))?;
    }
    let bytes = table.into_inner().map_err(|error| error.into_error())?;
    file.write(|file| file.write_all(&bytes))
}
