//! Places in input files, and what is said about them.

mod excerpt;
mod files;
mod identity;

pub use excerpt::{excerpt, excerpts, shown};
pub use files::{Files, digest, reading};
pub use identity::Identities;

use std::fmt;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use flate2::read::MultiGzDecoder;

use crate::memory::budget;

/// A place in a text file. Lines and columns count from 1; a column counts characters.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Location {
    /// The file.
    pub file: Arc<Path>,
    /// The line.
    pub line: u32,
    /// The column.
    pub column: u32,
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", shown(&self.file), self.line, self.column)
    }
}

/// Something the reader noticed that does not stop the render: where, what, and what is
/// done instead.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// Where it stands.
    pub at: Location,
    /// What was found and what is done instead.
    pub message: String,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.at, self.message)
    }
}

/// A file that could not be opened or read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}: {source}", shown(path))]
pub struct Unreadable {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub source: std::io::Error,
}

/// Notes that a file is read as input, by readers that go to it more than once.
///
/// # Errors
/// Where it is a pipe, which can be read once, or a device.
pub fn register(path: &Path) -> io::Result<()> {
    if fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return Err(io::Error::other("it is a pipe or a device; expected a file"));
    }
    files::add(path, None);
    Ok(())
}

/// Notes what a file or a pipe held that was read as input.
pub(crate) fn note(path: &Path, content: &[u8]) {
    files::add(path, Some(content));
}

/// What is a pipe, and so of no known size, may hold this many bytes.
const MOST_UNKNOWN: u64 = 1 << 28;
/// How many bytes a packed file may unpack to, whatever its size, and how many for each of its
/// own beyond that. Scenes grow three to ten times.
const MOST_UNPACKED: [u64; 2] = [1 << 24, 100];

/// The bytes of a file; of one that gzip packed, unpacked.
///
/// # Errors
/// Where it cannot be read, does not end or unpacks to more than anything sensible.
pub fn bytes(path: &Path) -> Result<Vec<u8>, Unreadable> {
    let read = || {
        let file = open(path)?;
        let length = file.metadata()?.len();
        budget::fits(length).map_err(io::Error::other)?;
        let packed = whole(file, length.max(MOST_UNKNOWN))?;
        note(path, &packed);
        if !packed.starts_with(&[0x1f, 0x8b]) {
            return Ok(packed);
        }
        let most = MOST_UNPACKED[0] + MOST_UNPACKED[1] * packed.len() as u64;
        whole(MultiGzDecoder::new(&packed[..]), most)
    };
    read().map_err(|source| Unreadable { path: path.to_owned(), source })
}

/// Opens a file or a pipe as input. A device may never end, or wait for somebody to type.
///
/// # Errors
/// Where there is none.
pub fn open(path: &Path) -> io::Result<fs::File> {
    let file = fs::File::open(path)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = file.metadata()?.file_type();
        if kind.is_char_device() || kind.is_block_device() {
            return Err(io::Error::other("it is a device; expected a file or a pipe"));
        }
    }
    Ok(file)
}

fn whole(from: impl Read, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(most + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > most {
        true => Err(io::Error::other("it does not end")),
        false => Ok(bytes),
    }
}

/// The known word nearest to a misspelt one, if any is near enough to be meant.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    let length = lower.chars().count();
    known
        .into_iter()
        // The distance takes time and space by the product of both lengths.
        .filter(|candidate| candidate.len().abs_diff(length) <= 1 + candidate.len() / 4)
        .map(|candidate| {
            (strsim::damerau_levenshtein(&lower, &candidate.to_lowercase()), candidate)
        })
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len() / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

/// "; did you mean ...?" for a misspelt word, or nothing.
pub fn hint<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, known).map_or_else(String::new, |near| format!("; did you mean \"{near}\"?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typo_finds_its_word_and_nonsense_finds_none() {
        let known = ["sphere", "disk", "trianglemesh"];
        assert_eq!(nearest("spehre", known), Some("sphere"));
        assert_eq!(nearest("TriangleMesh", known), Some("trianglemesh"));
        assert_eq!(nearest("xyzzy", known), None);
    }
}
