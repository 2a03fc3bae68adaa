//! Saved render state, for resume and merge.
//!
//! All integers are little-endian:
//!
//! | bytes | |
//! |---|---|
//! | 8 | `PETZVAL` and a byte 0x1a, which marks it as not text |
//! | 4 | the version of this format |
//! | 8 | length of the head |
//! | | [the head](Head), JSON: the command line, [the inputs](Inputs), the progress |
//! | 4 | its CRC-32 |
//! | 8 | length of the body |
//! | | the sums, 64-bit floats, whose count follows from the job, and for mattes from the scene |
//! | 4 | its CRC-32 |
//!
//! A file is written under a temporary name and renamed, so it replaces an older one only when it is
//! complete. The reader trusts nothing: lengths must fit the size of the file, sums must be finite, and
//! memory is allocated by the job and for parts of its scene, never by sizes in the file.

mod head;
mod inputs;

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

pub use head::Head;
pub use inputs::Inputs;

use crate::job::Job;
use petzval_base::io::OutputFile;
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter, invalid_data, read_array};
use petzval_base::io::{check_seekable, path_excerpt};
use petzval_lens::LensModel;

const MAGIC: &[u8; 8] = b"PETZVAL\x1a";
const VERSION: u32 = 2;
/// Largest length of a head, which lists files and command-line arguments (bytes).
const MAX_HEAD: u64 = 1 << 24;
/// Offset of the head in the file (bytes).
const HEAD_OFFSET: u64 = 20;

/// Error of reading or writing a checkpoint or a part of a picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The operating system reports an error.
    #[error("cannot {verb} {}: {source}", path_excerpt(path))]
    Io {
        /// "read" or "write".
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file is no checkpoint, is damaged, or has another version.
    #[error("{}: {found}", path_excerpt(path))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The problem.
        found: String,
    },
}

/// Checkpoint or part of a picture whose head has been read.
#[derive(Debug)]
pub struct SavedRender {
    path: PathBuf,
    /// The head.
    pub head: Head,
    file: File,
    /// The length of the body (bytes).
    length: u64,
}

impl SavedRender {
    /// Opens a file and reads its head.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is no checkpoint, is damaged, or has another version.
    pub fn open(path: &Path) -> Result<Self, CheckpointError> {
        let parse = || {
            // A pipe might never end.
            if !fs::metadata(path)?.is_file() {
                return Err(invalid_data(FOREIGN));
            }
            check_seekable(path)?;
            let file = File::open(path)?;
            let size = file.metadata()?.len();
            parse(file, size)
        };
        let (head, file, length) = parse().map_err(|error| read_error(path, error))?;
        Ok(Self { path: path.to_owned(), head, file, length })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns an error if the counts of the head are impossible for this job.
    pub(crate) fn check(&self, job: &Job) -> Result<(), CheckpointError> {
        let rows = match &job.camera.model {
            LensModel::Real(lens) => lens.prescription.rows.len(),
            _ => 0,
        };
        let depths = (job.path_limits.max_depth as usize).saturating_add(1);
        match self.head.stats.is_consistent(rows, depths) {
            true => Ok(()),
            false => Err(self.damaged("its counts of rays are not of this picture")),
        }
    }

    /// Returns an error about the content of the file.
    fn damaged(&self, found: &str) -> CheckpointError {
        read_error(&self.path, invalid_data(format!("it is damaged: {found}")))
    }

    /// Reads the body. `read` must consume all of it.
    pub(crate) fn body(
        self,
        read: impl FnOnce(&mut ChecksumReader) -> io::Result<()>,
    ) -> Result<(), CheckpointError> {
        let Self { path, file, length, .. } = self;
        let mut reader = ChecksumReader::new(file, length);
        read(&mut reader).and_then(|()| reader.finish()).map_err(|error| read_error(&path, error))
    }
}

/// Converts an error. One about the content has the kind [`io::ErrorKind::InvalidData`].
fn read_error(path: &Path, error: io::Error) -> CheckpointError {
    let path = path.to_owned();
    match error.kind() {
        io::ErrorKind::InvalidData => CheckpointError::Malformed { path, found: error.to_string() },
        io::ErrorKind::UnexpectedEof => CheckpointError::Malformed { path, found: SHORT.into() },
        _ => CheckpointError::Io { verb: "read", path, source: error },
    }
}

const FOREIGN: &str = "this is no checkpoint or part of a picture by petzval";
const SHORT: &str = "the file is cut short";

/// Reads the head of a file of this size. Returns it with the file at its body, and the length of the
/// body.
fn parse(mut file: File, size: u64) -> io::Result<(Head, File, u64)> {
    let mut magic = [0; 8];
    file.read_exact(&mut magic).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => invalid_data(FOREIGN),
        _ => error,
    })?;
    if &magic != MAGIC {
        return Err(invalid_data(FOREIGN));
    }
    let version = u32::from_le_bytes(read_array(&mut file)?);
    if version != VERSION {
        return Err(invalid_data(format!(
            "its format has version {version}, and this petzval reads version {VERSION}; use the \
             petzval that wrote it"
        )));
    }
    let length = u64::from_le_bytes(read_array(&mut file)?);
    if length > MAX_HEAD.min(size) {
        return Err(invalid_data("it is damaged: its head is longer than any"));
    }
    let mut text = vec![0; length as usize];
    file.read_exact(&mut text)?;
    if crc32fast::hash(&text) != u32::from_le_bytes(read_array(&mut file)?) {
        return Err(invalid_data("it is damaged: the checksum of its head is wrong"));
    }
    let head =
        Head::parse(&text).map_err(|found| invalid_data(format!("it is damaged: {found}")))?;
    let length = u64::from_le_bytes(read_array(&mut file)?);
    let without_body = HEAD_OFFSET + text.len() as u64 + 4 + 8 + 4;
    match without_body.checked_add(length) {
        Some(whole) if whole == size => Ok((head, file, length)),
        Some(whole) if whole < size => Err(invalid_data("it is damaged: data follow its end")),
        _ => Err(invalid_data(SHORT)),
    }
}

/// Writes a checkpoint and replaces the file of this name at once.
///
/// # Errors
/// Returns an error if it cannot be written. An older file of this name is then still there.
pub(crate) fn write(
    to: &OutputFile,
    head: &Head,
    fill: impl FnOnce(&mut ChecksumWriter) -> io::Result<()>,
) -> Result<(), CheckpointError> {
    let write = |file: &mut File| {
        let text = head.text();
        file.write_all(MAGIC)?;
        file.write_all(&VERSION.to_le_bytes())?;
        file.write_all(&(text.len() as u64).to_le_bytes())?;
        file.write_all(&text)?;
        file.write_all(&crc32fast::hash(&text).to_le_bytes())?;
        file.write_all(&[0; 8])?;
        let mut body = ChecksumWriter::new(&mut *file);
        fill(&mut body)?;
        let (length, checksum) = body.finish()?;
        file.write_all(&checksum.to_le_bytes())?;
        file.seek(SeekFrom::Start(HEAD_OFFSET + text.len() as u64 + 4))?;
        file.write_all(&length.to_le_bytes())
    };
    to.write(write).map_err(|source| {
        let path = to.path().to_owned();
        CheckpointError::Io { verb: "write", path, source }
    })
}
