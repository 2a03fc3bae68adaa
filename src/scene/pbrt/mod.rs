//! Scene files in the language of pbrt: the v4 dialect, and the v2 dialect as far as the
//! scenes of 2016 use it. Unknown words are errors with file, line and column; known ones that
//! are not supported yet are warnings that say what is done instead.

mod attributes;
mod blocks;
mod claims;
mod colour;
mod curves;
mod description;
mod forward;
mod lights;
mod materials;
mod meshes;
mod moving;
mod params;
mod pictures;
mod reader;
mod refractive;
mod settings;
mod shapes;
mod shutter;
mod surfaces;
mod textures;
mod token;
mod transforms;
mod vocabulary;
mod words;
mod world;

pub use description::{
    CameraSpec, Description, FilmSpec, FilterSpec, IrisSpec, RealisticSpec, ThinSpec,
};
pub use reader::read;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::image::ImageError;
use crate::scene::ply::PlyError;
use crate::source::{Location, Unreadable, Warning, excerpts};

/// Why a scene was refused.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A file could not be read.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// An included file could not be read.
    #[error("{at}: {source}")]
    Include {
        /// Where it is included.
        at: Location,
        /// The error of the reader.
        source: Unreadable,
    },
    /// The text is not what it should be.
    #[error("{at}: {message}")]
    Invalid {
        /// Where.
        at: Location,
        /// What was found and what was expected.
        message: String,
    },
    /// A picture that a texture or light names.
    #[error("{at}: {source}")]
    Image {
        /// Where it is named.
        at: Location,
        /// What is wrong with it.
        source: ImageError,
    },
    /// A mesh file that a shape names.
    #[error("{at}: {source}")]
    Mesh {
        /// Where it is named.
        at: Location,
        /// What is wrong with it.
        source: PlyError,
    },
}

/// The dialect of a scene file, where the two read the same words differently.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Dialect {
    /// pbrt-v2.
    V2,
    /// pbrt-v4.
    #[default]
    V4,
}

/// What was noticed so far, each thing once.
#[derive(Default)]
struct Notices {
    warnings: Vec<Warning>,
    seen: HashSet<String>,
}

impl Notices {
    /// Notes what is not supported and what is done instead.
    fn instead(&mut self, at: &Location, what: &str, instead: &str) {
        if self.seen.insert(what.to_owned()) {
            let message = excerpts(&format!("{what} is not supported yet: {instead}"));
            self.warnings.push(Warning { at: at.clone(), message });
        }
    }

    /// Notes what is wrong with the scene and what is done about it.
    fn note(&mut self, at: &Location, message: String) {
        if self.seen.insert(message.clone()) {
            self.warnings.push(Warning { at: at.clone(), message });
        }
    }
}

/// Where a file is that a scene names: in the folder of the scene file, also where an included file
/// names it, or else in the working directory (`ResolveFilename` of pbrt-v4).
fn resolve(folder: &Path, name: &str) -> PathBuf {
    let beside = folder.join(name);
    let here = Path::new(name);
    if !name.is_empty() && !beside.exists() && here.exists() { here.to_owned() } else { beside }
}

impl SceneError {
    fn at(at: Location, found: impl Into<String>, expected: impl Into<String>) -> Self {
        let (found, expected) = (found.into(), expected.into());
        let message = if expected.is_empty() { found } else { format!("{found}; {expected}") };
        Self::Invalid { at, message: excerpts(&message) }
    }
}
