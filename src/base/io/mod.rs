//! Input and output: the context of readers, locations and excerpts for messages, output
//! files, the binary codec, and image files.

mod budget;
pub mod codec;
mod context;
mod excerpt;
mod files;
mod foreign;
mod identity;
mod location;
pub mod machine;
pub mod npy;
mod output;
mod printable;
mod replace;
mod size;
mod source_line;
mod suggestion;

pub use budget::HeldMemory;
pub use context::{ReadContext, check_seekable};
pub use excerpt::{excerpt, excerpt_words, path_excerpt};
pub use files::{ContentDigest, FileLog, file_digest};
pub use foreign::{foreign_scene, wide_encoding, without_byte_order_mark};
pub use location::{Location, Warning};
pub use output::{OutputError, OutputFile, Outputs, check_writable};
pub use printable::printable;
pub use size::ByteSize;
pub use source_line::SourceLine;
pub use suggestion::{hint, nearest_word};

use std::path::PathBuf;

/// A file that could not be opened or read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}: {source}", path_excerpt(path))]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// The error of the system.
    pub source: std::io::Error,
}
