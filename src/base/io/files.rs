//! Log of input files and their digests.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::ReadError;

/// The files that were read as input. Each has a digest (BLAKE3) of the content that was read, if a
/// reader read all of it at once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileLog(BTreeMap<PathBuf, Option<String>>);

impl FileLog {
    /// Adds the files of another log.
    pub fn join(&mut self, others: Self) {
        for (path, digest) in others.0 {
            let entry = self.0.entry(path).or_default();
            *entry = digest.or(entry.take());
        }
    }

    /// Adds a file, and the digest of its content if that is known.
    pub fn add(&mut self, path: &Path, content: Option<&[u8]>) {
        let digest = self.0.entry(path.to_owned()).or_default();
        if let Some(content) = content {
            *digest = Some(blake3::hash(content).to_hex().to_string());
        }
    }

    /// Adds input that is no file, by a name and the digest of its content.
    pub fn add_digest(&mut self, name: &Path, digest: &ContentDigest) {
        self.0.insert(name.to_owned(), Some(digest.0.finalize().to_hex().to_string()));
    }

    /// Computes the digests that are not known, from the present content of the files.
    ///
    /// # Errors
    /// Returns an error if a file cannot be read again.
    pub fn fill_digests(&mut self) -> Result<(), ReadError> {
        for (path, known) in &mut self.0 {
            if known.is_none() {
                let source = |source| ReadError { path: path.clone(), source };
                *known = Some(file_digest(path).map_err(source)?);
            }
        }
        Ok(())
    }

    /// Iterates over the files, each with its digest if that is known.
    pub fn iter(&self) -> impl Iterator<Item = (&Path, Option<&str>)> {
        self.0.iter().map(|(path, digest)| (path.as_path(), digest.as_deref()))
    }
}

/// Digest (BLAKE3) of content that comes in parts.
#[derive(Clone, Debug, Default)]
pub struct ContentDigest(blake3::Hasher);

impl ContentDigest {
    /// Adds a list of values: their number, and their bytes in memory.
    pub fn add<T: bytemuck::NoUninit>(&mut self, values: &[T]) {
        self.0.update(&(values.len() as u64).to_le_bytes());
        self.0.update(bytemuck::cast_slice(values));
    }
}

/// Returns a digest of the content of a file (BLAKE3).
///
/// # Errors
/// Returns an error if the file cannot be read.
pub fn file_digest(path: &Path) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}
