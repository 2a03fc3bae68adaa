//! The table of a sweep: which picture is of which values, for whoever learns from them; and which
//! are finished, for the sweep that goes on.

use std::collections::HashMap;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use petzval::image::replace;

use super::super::render::Taken;

/// Columns beside those of the options.
const NAME: &str = "file";
const FIGURES: [&str; 5] = ["samples", "noise", "seconds", "content", "inputs"];

/// A picture that is finished.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    /// Samples a pixel, the noise where it is known, and the time that it took, s.
    figures: [String; 3],
    /// Digests (BLAKE3) of the picture's file, and of all that it is made of.
    digests: [String; 2],
}

impl Row {
    /// Of a picture that was just written.
    pub fn new(picture: &Path, taken: &Taken, inputs: String) -> io::Result<Self> {
        let noise = taken.noise.map_or_else(String::new, |noise| format!("{noise:.5}"));
        let seconds = format!("{:.2}", taken.time.as_secs_f64());
        let figures = [format!("{}", (taken.samples * 1e3).round() / 1e3), noise, seconds];
        Ok(Self { figures, digests: [content(picture)?, inputs] })
    }

    /// Whether the picture's file is the one that was written then.
    pub fn is_of(&self, picture: &Path) -> bool {
        content(picture).is_ok_and(|found| found == self.digests[0])
    }

    /// Whether these are its inputs.
    pub fn is_made_of(&self, inputs: &str) -> bool {
        self.digests[1] == inputs
    }
}

fn content(picture: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(fs::File::open(picture)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// A picture's name as its table has it.
fn name(table: &Path, picture: &Path) -> String {
    let folder = table.parent().unwrap_or(Path::new(""));
    picture.strip_prefix(folder).unwrap_or(picture).to_string_lossy().into_owned()
}

/// What a table says of each of its pictures, by their names; nothing where there is none. What is no
/// row of such a table is of no picture.
pub(super) fn read(path: &Path) -> io::Result<HashMap<PathBuf, Row>> {
    let file = match fs::File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(HashMap::new()),
        file => file?,
    };
    let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(file);
    let head = reader.headers().map_err(io::Error::other)?.clone();
    // The first and the last: an option may have the name of a figure.
    let mut rows = HashMap::new();
    let first = head.len().saturating_sub(FIGURES.len());
    if head.get(0) != Some(NAME) || !head.iter().skip(first).eq(FIGURES) {
        return Ok(rows);
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    for record in reader.records() {
        let record = record.map_err(io::Error::other)?;
        let values: Vec<String> = record.iter().skip(first).map(str::to_owned).collect();
        let values: Result<[String; 5], _> = values.try_into();
        if let (Some(name), Ok([samples, noise, seconds, content, inputs])) =
            (record.get(0), values)
        {
            let row = Row { figures: [samples, noise, seconds], digests: [content, inputs] };
            rows.insert(folder.join(name), row);
        }
    }
    Ok(rows)
}

/// Writes a table: pictures, the values of these options, and what is known of them.
pub(super) fn write<'a>(
    path: &Path,
    options: &[String],
    rows: impl Iterator<Item = (&'a Path, &'a Vec<String>, &'a Row)>,
) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let head = std::iter::once(NAME).chain(options.iter().map(String::as_str)).chain(FIGURES);
    table.write_record(head)?;
    for (picture, values, Row { figures, digests }) in rows {
        let name = name(path, picture);
        let known = figures.iter().chain(digests).map(String::as_str);
        let values = values.iter().map(String::as_str);
        table.write_record(std::iter::once(name.as_str()).chain(values).chain(known))?;
    }
    let bytes = table.into_inner().map_err(|error| error.into_error())?;
    replace(path, |file| file.write_all(&bytes))
}
