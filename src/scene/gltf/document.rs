//! A glTF document: its text, its buffers, and the places of its elements for messages.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use gltf_json::Root;
use percent_encoding::percent_decode_str;
use serde_json::value::RawValue;

use super::integers::{LargeIndex, plain_integers};
use crate::io::{Location, ReadContext, Warning, excerpt, without_byte_order_mark};
use crate::scene::pbrt::SceneError;

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

/// Length of the header of a GLB, and of the header of each of its chunks (bytes).
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// A parsed document and the content of its buffers.
pub(super) struct Document {
    pub root: Root,
    pub context: ReadContext,
    file: Arc<Path>,
    folder: PathBuf,
    text: String,
    /// Whether the text is part of a binary file.
    binary: bool,
    buffers: Vec<Vec<u8>>,
    warnings: RefCell<Vec<CountedWarning>>,
}

/// The first warning of a message.
struct CountedWarning {
    message: String,
    first: Warning,
    /// Number of further ones.
    more: u32,
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
        let plain = plain_integers(&text).map_err(|LargeIndex { offset, found }| {
            let message = format!("an index of {found}; expected less than 2^32");
            match binary {
                true => not_text(&file, format!("{message} (byte {} of its text)", offset + 1)),
                false => SceneError::Invalid { at: place(&file, &text, offset), message },
            }
        })?;
        let root = serde_json::from_str(&plain).map_err(|error| {
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
        drop(plain);
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

    /// Returns the place of an element, such as `meshes/2/primitives/0`.
    pub fn location(&self, element: &str) -> Location {
        if self.binary {
            return Location { file: Arc::clone(&self.file), line: 1, column: 1 };
        }
        place(&self.file, &self.text, offset(&self.text, element))
    }

    /// Returns an error about an element.
    pub fn error(&self, element: &str, found: impl Into<String>, expected: &str) -> SceneError {
        let message = format!("{}: {}; {expected}", shown(element), found.into());
        match self.binary {
            true => not_text(&self.file, message),
            false => SceneError::Invalid { at: self.location(element), message },
        }
    }

    /// Returns the error for a part that exceeds the memory budget.
    pub fn too_large(&self, element: &str, refusal: &str) -> SceneError {
        let message = format!(
            "{}: {refusal}; use a smaller scene, a larger 'memory' or a larger machine",
            shown(element)
        );
        SceneError::Limit { at: self.location(element), message }
    }

    /// Adds a warning about an element; further ones of the same message are counted.
    pub fn warn(&self, element: &str, message: &str) {
        let mut warnings = self.warnings.borrow_mut();
        // Only the first is located: to find an element reads the text.
        match warnings.iter_mut().find(|counted| counted.message == message) {
            Some(counted) => counted.more += 1,
            None => warnings.push(CountedWarning {
                message: message.to_owned(),
                first: Warning {
                    at: self.location(element),
                    message: format!("{}: {message}", shown(element)),
                },
                more: 0,
            }),
        }
    }

    /// Returns the first warning of each message, with the number of the others.
    pub fn take_warnings(&self) -> Vec<Warning> {
        let all = self.warnings.take().into_iter();
        all.map(|CountedWarning { first, more, .. }| match more {
            0 => first,
            more => Warning {
                message: format!("{} (and {more} more like this)", first.message),
                ..first
            },
        })
        .collect()
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

/// Returns the location of an offset (bytes) in a text.
fn place(file: &Arc<Path>, text: &str, offset: usize) -> Location {
    let before = &text[..offset];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    let [line, column] = [line, column].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    Location { file: Arc::clone(file), line, column }
}

/// Returns how messages write the path of an element: `meshes[2].primitives[0]`.
fn shown(element: &str) -> String {
    let mut shown = String::new();
    for step in element.split('/') {
        match step.parse::<usize>() {
            Ok(index) => shown.push_str(&format!("[{index}]")),
            Err(_) if shown.is_empty() => shown.push_str(step),
            Err(_) => shown.push_str(&format!(".{step}")),
        }
    }
    shown
}

/// Returns the offset of an element in the text, or that of the last one on its path that is there.
fn offset(text: &str, element: &str) -> usize {
    let mut at = text;
    for step in element.split('/') {
        let next = match step.parse::<usize>() {
            Ok(index) => serde_json::from_str::<Vec<&RawValue>>(at)
                .ok()
                .and_then(|all| all.get(index).copied()),
            Err(_) => serde_json::from_str::<BTreeMap<String, &RawValue>>(at)
                .ok()
                .and_then(|all| all.get(step).copied()),
        };
        match next {
            Some(value) => at = value.get(),
            None => break,
        }
    }
    let start = at.as_ptr() as usize - text.as_ptr() as usize;
    // The text itself may begin with blanks.
    start + if start == 0 { text.len() - text.trim_start().len() } else { 0 }
}

/// Returns the message of an error in JSON without its line and column.
fn without_place(error: &serde_json::Error) -> String {
    let message = error.to_string();
    match message.rfind(" at line ") {
        Some(end) => message[..end].to_owned(),
        None => message,
    }
}

fn not_text(file: &Arc<Path>, message: impl Into<String>) -> SceneError {
    let at = Location { file: Arc::clone(file), line: 1, column: 1 };
    SceneError::NotText { at, message: message.into() }
}

/// Splits a GLB into its text and its binary chunk.
fn split_glb(content: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let number = |at: usize| {
        let bytes = content.get(at..).and_then(|rest| rest.first_chunk::<4>());
        bytes.map(|bytes| u32::from_le_bytes(*bytes))
    };
    match number(4) {
        Some(2) => {}
        Some(version) => return Err(format!("a GLB of version {version}; expected version 2")),
        None => return Err("a GLB without a header; the file may be cut off".to_owned()),
    }
    let (mut at, mut text, mut binary) = (GLB_HEADER, None, None);
    while let (Some(length), Some(kind)) = (number(at), number(at + 4)) {
        let start = at + CHUNK_HEADER;
        let chunk = content.get(start..start.saturating_add(length as usize)).ok_or_else(|| {
            let left = content.len() - start;
            format!("a chunk of {length} bytes with {left} left; the file may be cut off")
        })?;
        match &kind.to_le_bytes() {
            b"JSON" if text.is_none() => text = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            // Readers must ignore chunks that they do not know.
            _ => {}
        }
        at = start + chunk.len();
    }
    match text {
        Some(text) => Ok((text, binary)),
        None => Err("a GLB without a JSON chunk; the file may be cut off".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_found_in_the_text() {
        let text = "\n{ \"a\": [ 1, {\"b\\u0063\": [true]} ],\n \"c\": 2 }";
        for (element, expected) in [
            ("a", "[ 1"),
            ("a/0", "1,"),
            ("a/1", "{\"b"),
            ("a/1/bc/0", "true"),
            ("c", "2 }"),
            // The last one that is there.
            ("a/7", "[ 1"),
            ("x", "{ \"a\""),
        ] {
            assert!(text[offset(text, element)..].starts_with(expected), "{element}");
        }
        assert_eq!(shown("meshes/2/primitives/0/attributes"), "meshes[2].primitives[0].attributes");
    }

    #[test]
    fn chunks_that_are_not_known_are_skipped() {
        let chunk = |kind: &[u8; 4], content: &[u8]| {
            [&(content.len() as u32).to_le_bytes()[..], kind, content].concat()
        };
        let glb = |version: u32, chunks: &[Vec<u8>]| {
            let head = [&b"glTF"[..], &version.to_le_bytes(), &[0; 4]].concat();
            [head, chunks.concat()].concat()
        };
        let all = [chunk(b"JSON", b"{}"), chunk(b"MORE", b"?"), chunk(b"BIN\0", b"abc")];
        assert_eq!(split_glb(&glb(2, &all)), Ok((&b"{}"[..], Some(&b"abc"[..]))));
        assert_eq!(split_glb(&glb(2, &all[..1])), Ok((&b"{}"[..], None)));
        assert!(split_glb(&glb(1, &all)).unwrap_err().contains("version 1"));
        assert!(split_glb(&glb(2, &all[1..])).unwrap_err().contains("JSON"));
        let whole = glb(2, &all);
        for end in 4..whole.len() {
            let _ = split_glb(&whole[..end]);
        }
        assert!(split_glb(&whole[..whole.len() - 1]).unwrap_err().contains("2 left"));
    }
}
