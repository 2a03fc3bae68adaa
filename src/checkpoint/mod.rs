//! What a render has come to, in a file: to go on from, and to add up with other parts.
//!
//! All integers are little-endian:
//!
//! | bytes | |
//! |---|---|
//! | 8 | `PETZVAL` and a byte 0x1a, so that nobody takes it for text |
//! | 4 | the version of this format |
//! | 8 | length of the head |
//! | | [the head](Head), JSON: the command line, [what was read](Inputs), how much is done |
//! | 4 | its CRC-32 |
//! | 8 | length of the body |
//! | | the sums, 64-bit floats, whose count follows from the job |
//! | 4 | its CRC-32 |
//!
//! A file is written beside its name and renamed, so the name holds all of it or what was there
//! before. Whoever reads it believes nothing: lengths must fit the size of the file, sums must be
//! numbers, and memory is asked for by the job, never by what the file says.

mod body;
mod head;
mod inputs;

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

pub use body::{Reader, Writer};
pub use head::Head;
pub use inputs::Inputs;

use crate::image::replace;
use crate::lens::Model;
use crate::render::Job;
use crate::source::{register, shown};

const MAGIC: &[u8; 8] = b"PETZVAL\x1a";
const VERSION: u32 = 2;
/// No head is longer than this: it lists files and words.
const MOST_HEAD: u64 = 1 << 24;
/// Bytes before the head.
const START: u64 = 20;

/// Why a checkpoint or a part of a picture could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The system refuses.
    #[error("cannot {verb} {}: {source}", shown(path))]
    Io {
        /// "read" or "write".
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// It does not hold what its name promises.
    #[error("{}: {found}", shown(path))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        found: String,
    },
}

/// A file of this kind, of which the head has been read.
#[derive(Debug)]
pub struct Saved {
    path: PathBuf,
    /// What it says of itself.
    pub head: Head,
    file: File,
    /// Bytes of the body.
    length: u64,
}

impl Saved {
    /// Opens a file and reads its head.
    ///
    /// # Errors
    /// Where it cannot be read, or is no such file, or one that is damaged or of another version.
    pub fn open(path: &Path) -> Result<Self, CheckpointError> {
        let parse = || {
            // A pipe might never say anything.
            if !fs::metadata(path)?.is_file() {
                return Err(wrong(FOREIGN));
            }
            register(path)?;
            let file = File::open(path)?;
            let size = file.metadata()?.len();
            parse(file, size)
        };
        let (head, file, length) = parse().map_err(|error| failed(path, error))?;
        Ok(Self { path: path.to_owned(), head, file, length })
    }

    /// Where it stands.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Refuses what it says was done where this job cannot have done it.
    pub(crate) fn check(&self, job: &Job) -> Result<(), CheckpointError> {
        let rows = match &job.camera.model {
            Model::Real(lens) => lens.prescription.rows.len(),
            _ => 0,
        };
        match self.head.stats.fits(rows, (job.reach.max_depth as usize).saturating_add(1)) {
            true => Ok(()),
            false => Err(self.damaged("its counts of rays are not of this picture")),
        }
    }

    /// It does not hold what its head promises.
    fn damaged(&self, found: &str) -> CheckpointError {
        failed(&self.path, wrong(format!("it is damaged: {found}")))
    }

    /// Hands its body on; all of it must be taken.
    pub(crate) fn body(
        self,
        take: impl FnOnce(&mut Reader) -> io::Result<()>,
    ) -> Result<(), CheckpointError> {
        let Self { path, file, length, .. } = self;
        let mut reader = Reader::new(file, length);
        take(&mut reader).and_then(|()| reader.finish()).map_err(|error| failed(&path, error))
    }
}

/// What is wrong with the content has the kind [`io::ErrorKind::InvalidData`].
fn failed(path: &Path, error: io::Error) -> CheckpointError {
    let path = path.to_owned();
    match error.kind() {
        io::ErrorKind::InvalidData => CheckpointError::Malformed { path, found: error.to_string() },
        io::ErrorKind::UnexpectedEof => CheckpointError::Malformed { path, found: SHORT.into() },
        _ => CheckpointError::Io { verb: "read", path, source: error },
    }
}

const FOREIGN: &str = "this is no checkpoint or part of a picture by petzval";
const SHORT: &str = "the file is cut short";

pub(crate) fn wrong(found: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, found.into())
}

/// The head of a file of this size, and the length of the body behind it.
fn parse(mut file: File, size: u64) -> io::Result<(Head, File, u64)> {
    let mut magic = [0; 8];
    file.read_exact(&mut magic).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => wrong(FOREIGN),
        _ => error,
    })?;
    if &magic != MAGIC {
        return Err(wrong(FOREIGN));
    }
    let version = u32::from_le_bytes(array(&mut file)?);
    if version != VERSION {
        return Err(wrong(format!(
            "its format has version {version}, and this petzval reads version {VERSION}; use the \
             petzval that wrote it"
        )));
    }
    let length = u64::from_le_bytes(array(&mut file)?);
    if length > MOST_HEAD.min(size) {
        return Err(wrong("it is damaged: its head is longer than any"));
    }
    let mut text = vec![0; length as usize];
    file.read_exact(&mut text)?;
    if crc32fast::hash(&text) != u32::from_le_bytes(array(&mut file)?) {
        return Err(wrong("it is damaged: the checksum of its head is wrong"));
    }
    let head = Head::parse(&text).map_err(|found| wrong(format!("it is damaged: {found}")))?;
    let length = u64::from_le_bytes(array(&mut file)?);
    let around = START + text.len() as u64 + 4 + 8 + 4;
    match around.checked_add(length) {
        Some(whole) if whole == size => Ok((head, file, length)),
        Some(whole) if whole < size => {
            Err(wrong("it is damaged: there is something behind its end"))
        }
        _ => Err(wrong(SHORT)),
    }
}

fn array<const N: usize>(from: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    from.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Writes a file of this kind under its name at once.
///
/// # Errors
/// Where it cannot be written; what stood under its name is then still there.
pub(crate) fn write(
    path: &Path,
    head: &Head,
    fill: impl FnOnce(&mut Writer) -> io::Result<()>,
) -> Result<(), CheckpointError> {
    let write = |file: &mut File| {
        let text = head.text();
        file.write_all(MAGIC)?;
        file.write_all(&VERSION.to_le_bytes())?;
        file.write_all(&(text.len() as u64).to_le_bytes())?;
        file.write_all(&text)?;
        file.write_all(&crc32fast::hash(&text).to_le_bytes())?;
        file.write_all(&[0; 8])?;
        let mut body = Writer::new(&mut *file);
        fill(&mut body)?;
        let (length, checksum) = body.finish()?;
        file.write_all(&checksum.to_le_bytes())?;
        file.seek(SeekFrom::Start(START + text.len() as u64 + 4))?;
        file.write_all(&length.to_le_bytes())
    };
    replace(path, write).map_err(|source| {
        let path = path.to_owned();
        CheckpointError::Io { verb: "write", path, source }
    })
}
