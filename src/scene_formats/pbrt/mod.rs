//! Reader of scene files in pbrt's language: the v4 dialect, and those of v1 to v3 as far as
//! `pbrt --upgrade` translates them.
//!
//! An unknown word is an error with file, line and column. A known word that is not supported yet
//! is a warning that names the substitute.
//!
//! `lexer` splits text into tokens, `parser` reads values and parameter lists, `reader` holds the
//! graphics state and runs the actions of `directives`, `recovery` goes on behind an error. Each
//! directive has the table of its kinds and their parameters beside the code that reads them. `assembly`
//! gives the same reader the parts of a scene that a program has in memory.

mod area_lights;
mod assembly;
mod attributes;
mod camera;
mod camera_sensor;
mod camera_text;
mod colour;
mod curves;
mod description;
mod directive_kinds;
mod directives;
mod displaced_meshes;
mod film;
mod forward_references;
mod goniometric;
mod graphics_state;
mod image_files;
mod image_textures;
mod include;
mod lexer;
mod lights;
mod material_builder;
mod material_kinds;
mod materials;
mod media;
mod medium_coefficients;
mod medium_grids;
mod memory;
mod meshes;
mod moving_shapes;
mod numbers;
mod objects;
mod options;
mod parametric_shapes;
mod params;
mod parser;
mod portals;
mod reader;
mod recovery;
mod refractive_index;
mod repeated_meshes;
mod sample_files;
mod scene_errors;
mod shapes;
mod shutter;
mod solid_textures;
mod subsurface;
mod texture_library;
mod texture_mapping;
mod textures;
mod transforms;

pub use assembly::{KindSpec, MeshSpec, ParameterValue, SceneAssembly, ViewSpec};
pub use camera_text::{CameraEdit, CameraValue};
pub use description::{
    CameraSpec, Description, FilmSpec, FilterSpec, IrisSpec, RealisticSpec, SphericalSpec, ThinSpec,
};
pub(crate) use memory::INSTANCE_BYTES;
pub use reader::{read, read_with};
pub use scene_errors::{SceneErrors, SceneFault};

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use crate::nanovdb::NanoVdbError;
use crate::ply::PlyError;
use petzval_base::io::{Location, ReadError, Warning, excerpt_words};
use petzval_image::ImageError;
use petzval_scene::SceneTooLarge;

/// An error in a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A file cannot be read.
    #[error(transparent)]
    Unreadable(#[from] ReadError),
    /// An included file cannot be read.
    #[error("{at}: {source}")]
    Include {
        /// Location of the directive that includes it.
        at: Location,
        /// The reader's error.
        source: ReadError,
    },
    /// The text is not valid.
    #[error("{at}: {message}")]
    Invalid {
        /// Location of the fault.
        at: Location,
        /// Fault and expected input.
        message: String,
    },
    /// The file is not text.
    #[error("{at}: {message}")]
    NotText {
        /// Location of the first byte that is not text.
        at: Location,
        /// Fault and expected input.
        message: String,
    },
    /// The scene exceeds the memory, or the number of files that may include each other.
    #[error("{at}: {message}")]
    Limit {
        /// Location of the directive.
        at: Location,
        /// The exceeded limit, and the remedy.
        message: String,
    },
    /// The image file of a texture or light is not valid.
    #[error("{at}: {source}")]
    Image {
        /// Location of the parameter that names it.
        at: Location,
        /// The image reader's error.
        source: ImageError,
    },
    /// The mesh file of a shape is not valid.
    #[error("{at}: {source}")]
    Mesh {
        /// Location of the parameter that names it.
        at: Location,
        /// The mesh reader's error.
        source: PlyError,
    },
    /// The volume file of a medium is not valid.
    #[error("{at}: {source}")]
    Volume {
        /// Location of the parameter that names it.
        at: Location,
        /// The volume reader's error.
        source: NanoVdbError,
    },
    /// The scene has more shapes or primitives than the renderer can index.
    #[error("{at}: {source}")]
    TooLarge {
        /// Location of the end of the scene.
        at: Location,
        /// The scene builder's error.
        source: SceneTooLarge,
    },
}

/// The dialect of a scene file, for words that the dialects read differently.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Dialect {
    /// pbrt-v2, or a file of an older one that cannot be told from it.
    V2,
    /// pbrt-v3, or a file of an older one that cannot be told from it.
    V3,
    /// pbrt-v4.
    #[default]
    V4,
}

impl Dialect {
    /// Returns whether it is older than pbrt-v4, which checks more than the others: they warn of
    /// parameters that nothing reads, and keep the blocks of attributes and objects in one stack.
    fn is_older(self) -> bool {
        self != Self::V4
    }
}

/// The warnings so far: the first of each kind, and the number of the others.
#[derive(Default)]
struct WarningLog {
    warnings: Vec<CountedWarning>,
    /// Indices by kind.
    kinds: HashMap<String, usize>,
}

/// The first warning of a kind.
struct CountedWarning {
    first: Warning,
    /// Number of further warnings of this kind at other locations.
    more: u32,
    last: Location,
}

impl WarningLog {
    /// Warns that `feature` is not supported, and names the substitute.
    fn unsupported(&mut self, at: &Location, feature: &str, instead: &str) {
        self.warn(at, feature, || format!("{feature} is not supported yet: {instead}"));
    }

    /// Adds the first warning of a kind, or counts a further one.
    fn warn(&mut self, at: &Location, kind: &str, message: impl FnOnce() -> String) {
        let counted = self.kinds.get(kind).and_then(|&i| self.warnings.get_mut(i));
        if let Some(counted) = counted {
            // A definition that waits for its textures is made twice.
            if at.file != counted.last.file || *at > counted.last {
                counted.more += 1;
                counted.last = at.clone();
            }
            return;
        }
        self.kinds.insert(kind.to_owned(), self.warnings.len());
        let first = Warning { at: at.clone(), message: excerpt_words(&message()) };
        self.warnings.push(CountedWarning { first, more: 0, last: at.clone() });
    }

    /// Returns the first warning of each kind, with the number of the others.
    fn into_warnings(self) -> Vec<Warning> {
        let counted = |CountedWarning { first: Warning { at, message }, more, .. }| match more {
            0 => Warning { at, message },
            more => Warning { at, message: format!("{message} (and {more} more like this)") },
        };
        self.warnings.into_iter().map(counted).collect()
    }
}

/// Returns the path of a file that a scene names. It is relative to the folder of the scene file,
/// even if an included file names it, or else to the working directory (`ResolveFilename` of
/// pbrt-v4).
fn resolve(folder: &Path, name: &str) -> PathBuf {
    let in_folder = folder.join(name);
    let in_working_directory = Path::new(name);
    if !name.is_empty() && !in_folder.exists() && in_working_directory.exists() {
        in_working_directory.to_owned()
    } else {
        in_folder
    }
}

impl SceneError {
    fn at(at: Location, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Invalid { at, message: message(found, expected) }
    }

    fn limit(at: Location, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Limit { at, message: message(found, expected) }
    }

    /// Returns the location of the error in a scene file.
    pub fn location(&self) -> Option<&Location> {
        match self {
            Self::Unreadable(_) => None,
            Self::Include { at, .. }
            | Self::Invalid { at, .. }
            | Self::NotText { at, .. }
            | Self::Limit { at, .. }
            | Self::Image { at, .. }
            | Self::Mesh { at, .. }
            | Self::Volume { at, .. }
            | Self::TooLarge { at, .. } => Some(at),
        }
    }

    /// Returns the message without the location.
    fn message(&self) -> String {
        match self {
            Self::Unreadable(source) | Self::Include { source, .. } => source.to_string(),
            Self::Invalid { message, .. }
            | Self::NotText { message, .. }
            | Self::Limit { message, .. } => message.clone(),
            Self::Image { source, .. } => source.to_string(),
            Self::Mesh { source, .. } => source.to_string(),
            Self::Volume { source, .. } => source.to_string(),
            Self::TooLarge { source, .. } => source.to_string(),
        }
    }

    /// Returns whether the error makes the rest of the scene meaningless.
    fn is_fatal(&self) -> bool {
        matches!(
            self,
            Self::Unreadable(_) | Self::NotText { .. } | Self::Limit { .. } | Self::TooLarge { .. }
        )
    }
}

/// Returns what follows an unknown name in a message: the suggestion if there is one, else what was
/// expected.
fn suggestion_or(hint: String, expected: &str) -> String {
    match hint.is_empty() {
        true => format!("; {expected}"),
        false => hint,
    }
}

/// Returns a message that says what was found and, if that is not clear, what was expected.
fn message(found: impl Into<String>, expected: impl Into<String>) -> String {
    let (found, expected) = (found.into(), expected.into());
    excerpt_words(&if expected.is_empty() { found } else { format!("{found}; {expected}") })
}
