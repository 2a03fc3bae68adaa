//! A glTF document: its elements and the content of its buffers.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::glb::split_glb;
use super::messages::{CountedWarning, not_text, without_place};
use super::schema::Root;
use crate::pbrt::SceneError;
use petzval_base::io::{Location, ReadContext, excerpt, without_byte_order_mark};

/// Extensions that are read.
const EXTENSIONS: [&str; 11] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// A parsed document and the content of its buffers.
pub(super) struct Document {
    pub root: Root,
    pub context: ReadContext,
    pub(super) file: Arc<Path>,
    folder: PathBuf,
    pub(super) text: String,
    /// Whether the text is part of a binary file.
    pub(super) binary: bool,
    buffers: Vec<Vec<u8>>,
    pub(super) warnings: RefCell<Vec<CountedWarning>>,
}

impl Document {
    /// Reads a document and its buffers.
    pub fn read(path: &Path, context: &ReadContext) -> Result<Self, SceneError> {
        let content = context.bytes(path)?;
        let file: Arc<Path> = Arc::from(path);
        let binary = content.starts_with(b"glTF");
        let (text, chunk) = match binary {
            true => split_glb(&content).map_err(|message| not_text(&file, message))?,
            false => (without_byte_order_mark(&content), None),
        };
        let text = std::str::from_utf8(text)
            .map_err(|error| {
                let offset = error.valid_up_to();
                not_text(&file, format!("byte {offset} is not UTF-8; expected a glTF document"))
            })?
            .to_owned();
        let root = serde_json::from_str(&text).map_err(|error| {
            let message = format!("this is no glTF document: {}", without_place(&error));
            let line = u32::try_from(error.line().max(1)).unwrap_or(u32::MAX);
            let column = u32::try_from(error.column().max(1)).unwrap_or(u32::MAX);
            match binary {
                true => not_text(&file, format!("{message} (byte {column} of its text)")),
                false => SceneError::Invalid {
                    at: Location { file: Arc::clone(&file), line, column },
                    message,
                },
            }
        })?;
        let chunk = chunk.map(<[u8]>::to_vec);
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut document = Self {
            root,
            context: context.clone(),
            file,
            folder,
            text,
            binary,
            buffers: Vec::new(),
            warnings: RefCell::default(),
        };
        document.check_version()?;
        document.buffers = document.read_buffers(chunk)?;
        Ok(document)
    }

    fn check_version(&self) -> Result<(), SceneError> {
        let version = &self.root.asset.version;
        if !version.starts_with("2.") {
            let found = format!("version {}", excerpt(version));
            return Err(self.error("asset/version", found, "expected glTF 2.0: export it again"));
        }
        let unknown = self.root.extensions_required.iter().enumerate();
        let mut unknown = unknown.filter(|(_, name)| !EXTENSIONS.contains(&name.as_str()));
        if let Some((i, name)) = unknown.next() {
            let found = format!("the extension {} is required", excerpt(name));
            let expected = match name.as_str() {
                "KHR_draco_mesh_compression" | "EXT_meshopt_compression" => {
                    "export it again without compression"
                }
                "KHR_texture_basisu" | "EXT_texture_webp" => "export it again with PNG or JPEG",
                _ => "petzval does not read it: export the scene again without it",
            };
            return Err(self.error(&format!("extensionsRequired/{i}"), found, expected));
        }
        Ok(())
    }

    /// Warns of what the document uses and petzval does not read.
    pub fn warn_unread(&self) {
        for (i, name) in self.root.extensions_used.iter().enumerate() {
            if !EXTENSIONS.contains(&name.as_str()) {
                let message = format!("the extension {} is not read", excerpt(name));
                self.warn(&format!("extensionsUsed/{i}"), &message);
            }
        }
        if !self.root.animations.is_empty() {
            self.warn("animations", "animations are not read: everything stands still");
        }
        if !self.root.skins.is_empty() {
            self.warn("skins", "skins are not read: meshes are in their pose of rest");
        }
    }

    /// Returns an element of a list, or the error for an index that is too large.
    pub fn entry<'a, T>(
        &self,
        all: &'a [T],
        index: usize,
        list: &str,
        named_at: &str,
    ) -> Result<&'a T, SceneError> {
        all.get(index).ok_or_else(|| {
            let found = format!("there is no {list}[{index}]");
            let expected = match all.len() {
                0 => format!("the document has no {list}"),
                count => format!("expected 0 to {}", count - 1),
            };
            self.error(named_at, found, &expected)
        })
    }

    /// Returns the content of a buffer.
    pub fn buffer(&self, index: usize, named_at: &str) -> Result<&[u8], SceneError> {
        self.entry(&self.buffers, index, "buffers", named_at).map(Vec::as_slice)
    }

    fn read_buffers(&self, mut chunk: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>, SceneError> {
        let mut buffers = Vec::new();
        for (i, buffer) in self.root.buffers.iter().enumerate() {
            let element = format!("buffers/{i}");
            let content = match &buffer.uri {
                Some(uri) => self.resource(uri, &format!("{element}/uri"))?,
                None => match chunk.take().filter(|_| i == 0) {
                    Some(chunk) => chunk,
                    None => {
                        let found = "a buffer without \"uri\"";
                        let expected = "only the first buffer of a GLB may leave it out";
                        return Err(self.error(&element, found, expected));
                    }
                },
            };
            let (length, found) = (buffer.byte_length.0, content.len() as u64);
            if found < length {
                let found = format!("{found} bytes in place of {length}");
                return Err(self.error(&element, found, "the file may be cut off"));
            }
            self.context
                .claim(content.len() as u64)
                .map_err(|refusal| self.too_large(&element, &refusal))?;
            buffers.push(content);
        }
        Ok(buffers)
    }

    /// Returns the content that a URI names: a file beside the document, or the data in it.
    pub fn resource(&self, uri: &str, element: &str) -> Result<Vec<u8>, SceneError> {
        if let Some(data) = uri.strip_prefix("data:") {
            let found = |why: &str| self.error(element, why, "expected data:...;base64,...");
            let (_, data) =
                data.split_once(";base64,").ok_or_else(|| found("data that are not in base64"))?;
            let config = GeneralPurposeConfig::new()
                .with_decode_padding_mode(DecodePaddingMode::Indifferent);
            let engine = GeneralPurpose::new(&base64::alphabet::STANDARD, config);
            return engine.decode(data).map_err(|error| found(&format!("bad base64: {error}")));
        }
        let path = self.path(uri, element)?;
        self.context
            .bytes(&path)
            .map_err(|source| SceneError::Include { at: self.location(element), source })
    }

    /// Returns the path of the file that a URI names.
    fn path(&self, uri: &str, element: &str) -> Result<PathBuf, SceneError> {
        let expected = "expected a path relative to the document";
        let scheme = uri.split(['/', '?', '#']).next().is_some_and(|first| first.contains(':'));
        if scheme || uri.starts_with(['/', '\\']) {
            return Err(self.error(element, format!("the address {}", excerpt(uri)), expected));
        }
        let name = percent_decode_str(uri)
            .decode_utf8()
            .map_err(|_| self.error(element, format!("{} is not UTF-8", excerpt(uri)), expected))?;
        if name.is_empty() || name.contains('\0') || Path::new(&*name).is_absolute() {
            return Err(self.error(element, format!("the address {}", excerpt(uri)), expected));
        }
        Ok(self.folder.join(&*name))
    }
}
