//! The table of a sweep: which picture is of which values, for whoever learns from them; and which
//! are finished, for the sweep that goes on.

use std::fs;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use petzval::image::replace;
use petzval::source::digest;

use super::super::Failure;
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
        Ok(Self { figures, digests: [digest(picture)?, inputs] })
    }

    /// Whether the picture's file is the one that was written then.
    pub fn is_of(&self, picture: &Path) -> bool {
        digest(picture).is_ok_and(|found| found == self.digests[0])
    }

    /// Whether these are its inputs.
    pub fn is_made_of(&self, inputs: &str) -> bool {
        self.digests[1] == inputs
    }
}

/// A picture's name as a table in this folder has it: the way from there.
pub(super) fn name(folder: &Path, picture: &Path) -> String {
    let folder = real(folder);
    let picture = real(picture.parent().unwrap_or(Path::new("")))
        .join(picture.file_name().unwrap_or_default());
    let both = folder.components().zip(picture.components());
    let common = both.take_while(|(one, other)| one == other).count();
    // Another drive.
    if common == 0 {
        return picture.to_string_lossy().into_owned();
    }
    let up = folder.components().skip(common).map(|_| Component::ParentDir);
    let way: PathBuf = up.chain(picture.components().skip(common)).collect();
    way.to_string_lossy().into_owned()
}

/// A folder without symbolic links, of which ".." does not lead back.
fn real(folder: &Path) -> PathBuf {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
}

/// The columns of a table of these options.
fn head(options: &[String]) -> Vec<&str> {
    let options = options.iter().map(String::as_str);
    std::iter::once(NAME).chain(options).chain(FIGURES).collect()
}

/// A picture in a table: its name there, the values of its options, and what is known.
pub(super) type Entry = (String, Vec<String>, Row);

/// What the table of these options says; nothing where there is none. Another table, or what is none,
/// is refused: it would be lost.
pub(super) fn read(path: &Path, options: &[String]) -> Result<Vec<Entry>, Failure> {
    let refused = |error: csv::Error| format!("cannot read {}: {error}", path.display());
    let file = match fs::File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        file => file.map_err(|error| refused(error.into()))?,
    };
    let mut reader = csv::Reader::from_reader(file);
    let head = head(options);
    if !reader.headers().map_err(refused)?.iter().eq(head.iter().copied()) {
        return Err(format!(
            "{} is there and no table of such a sweep, whose first line is {}; name another by \
             --contact",
            path.display(),
            head.join(",")
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
        entries.push((name, values, Row { figures, digests: [next(), next()] }));
    }
    Ok(entries)
}

/// Writes a table of these options.
pub(super) fn write<'a>(
    path: &Path,
    options: &[String],
    entries: impl Iterator<Item = (&'a String, &'a Vec<String>, &'a Row)>,
) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(head(options))?;
    for (name, values, Row { figures, digests }) in entries {
        let known = figures.iter().chain(digests);
        table.write_record(std::iter::once(name).chain(values).chain(known))?;
    }
    let bytes = table.into_inner().map_err(|error| error.into_error())?;
    replace(path, |file| file.write_all(&bytes))
}
