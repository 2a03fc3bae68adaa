//! Files that hold something else than their names say: placeholders of downloads, and files of
//! other programs.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Bytes at the start of a file by which its kind is recognised.
const HEAD: usize = 1024;

/// Returns an error if a file is a placeholder of its content: a pointer of Git LFS, or a web page.
///
/// # Errors
/// Returns an error that names the placeholder and the remedy.
pub(super) fn refuse_placeholder(content: &[u8]) -> io::Result<()> {
    match placeholder(content) {
        Some(found) => Err(io::Error::other(found)),
        None => Ok(()),
    }
}

/// As [`refuse_placeholder`], for a file that its reader opens itself. A file that cannot be opened
/// is left to the reader.
///
/// # Errors
/// Returns an error that names the placeholder and the remedy.
pub(super) fn refuse_placeholder_file(path: &Path) -> io::Result<()> {
    let mut head = Vec::new();
    if let Ok(file) = File::open(path) {
        let _ = file.take(HEAD as u64).read_to_end(&mut head);
    }
    refuse_placeholder(&head)
}

fn placeholder(content: &[u8]) -> Option<&'static str> {
    let head = Head::new(content);
    if head.starts_with("version https://git-lfs.github.com/spec/") {
        return Some(
            "it is a pointer of Git LFS, not the file itself; run `git lfs pull` in its repository",
        );
    }
    if head.starts_with("<!doctype html") || head.starts_with("<html") {
        return Some("it is a web page (HTML), not the file itself; download the file again");
    }
    None
}

/// Returns the encoding of a text in UTF-16 or UTF-32, by its byte order mark or its zero bytes.
pub fn wide_encoding(content: &[u8]) -> Option<&'static str> {
    match content {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some("UTF-32"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16"),
        // A letter and a zero, twice.
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] if a.is_ascii_graphic() && b.is_ascii_graphic() => {
            Some("UTF-16")
        }
        _ => None,
    }
}

/// Returns a file's content without the byte order mark of UTF-8.
pub fn without_byte_order_mark(content: &[u8]) -> &[u8] {
    content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content)
}

/// Returns what a file looks like that is not a scene in the language of pbrt.
pub fn foreign_scene(content: &[u8]) -> Option<&'static str> {
    BINARY
        .iter()
        .find(|(magic, _)| content.starts_with(magic))
        .map(|(_, kind)| *kind)
        .or_else(|| foreign_text(&Head::new(content)))
        .or_else(|| is_binary_stl(content).then_some("an STL mesh"))
}

/// Kinds of files by their first bytes.
const BINARY: &[(&[u8], &str)] = &[
    (b"glTF", "a glTF scene (GLB)"),
    (b"PXR-USDC", "a USD scene"),
    (b"BLENDER", "a Blender file"),
    (b"\x28\xb5\x2f\xfd", "a Blender file, or another that is packed by zstd"),
    (b"Kaydara FBX", "an FBX scene"),
    // The number of the format, the fifth of which is the last.
    (b"\x04\0\0\0", "a binary scene of pbrt-parser (.pbf)"),
    (b"\x05\0\0\0", "a binary scene of pbrt-parser (.pbf)"),
    (b"\x89PNG", "a picture (PNG)"),
    (b"\xff\xd8\xff", "a picture (JPEG)"),
    (b"\x76\x2f\x31\x01", "a picture (OpenEXR)"),
    (b"GIF8", "a picture (GIF)"),
    (b"qoif", "a picture (QOI)"),
    (b"#?RADIANCE", "a picture (Radiance HDR)"),
    (b"#?RGBE", "a picture (Radiance HDR)"),
    (b"II*\0", "a picture (TIFF)"),
    (b"MM\0*", "a picture (TIFF)"),
    (b"BM", "a picture (BMP)"),
    (b"%PDF", "a PDF document"),
    (b"\x7fELF", "an executable"),
    (b"PK\x03\x04", "a ZIP archive, or a packed USD scene (.usdz)"),
    (b"\xfd7zXZ\0", "an archive (XZ)"),
    (b"BZh", "an archive (bzip2)"),
    (b"7z\xbc\xaf\x27\x1c", "an archive (7-Zip)"),
];

fn foreign_text(head: &Head) -> Option<&'static str> {
    if head.starts_with("#usda") {
        return Some("a USD scene");
    }
    if head.starts_with("ply\n") || head.starts_with("ply\r") {
        return Some("a PLY mesh");
    }
    if head.starts_with("solid ") && head.contains("facet") {
        return Some("an STL mesh");
    }
    if head.starts_with("{") || head.starts_with("[{") {
        return Some(match head.contains("\"asset\"") || head.contains("\"meshes\"") {
            true => "a glTF scene",
            false => "a JSON file",
        });
    }
    if head.starts_with("<") {
        return Some(match head.contains("<scene") {
            true => "a scene of Mitsuba (XML)",
            false => "an XML file",
        });
    }
    // Comments of Wavefront are those of pbrt.
    let first = head.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    let (word, rest) = first?.split_once([' ', '\t'])?;
    match word {
        "mtllib" | "usemtl" | "v" | "vn" | "vt" | "o" | "g" | "f" => Some("an OBJ mesh"),
        "newmtl" => Some("the materials of an OBJ mesh (.mtl)"),
        "[[surface]]" => Some("a lens file"),
        _ => (word.parse::<f64>().is_ok() && rest.split_whitespace().count() == 3)
            .then_some("a lens file"),
    }
}

/// Returns whether a file is as long as the number of triangles says that a binary STL declares.
fn is_binary_stl(content: &[u8]) -> bool {
    let declared = content.get(80..84).and_then(|bytes| bytes.first_chunk::<4>());
    declared.is_some_and(|count| {
        content.len() as u64 == 84 + 50 * u64::from(u32::from_le_bytes(*count))
    })
}

/// The start of a file as text in lower case, without blanks before it.
struct Head(String);

impl Head {
    fn new(content: &[u8]) -> Self {
        let content = without_byte_order_mark(content).trim_ascii_start();
        let head = &content[..content.len().min(HEAD)];
        Self(String::from_utf8_lossy(head).to_lowercase())
    }

    fn starts_with(&self, start: &str) -> bool {
        self.0.starts_with(start)
    }

    fn contains(&self, part: &str) -> bool {
        self.0.contains(part)
    }

    fn lines(&self) -> impl Iterator<Item = &str> {
        self.0.lines()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_other_programs_are_named() {
        let binary_stl = [&[0; 80][..], &1u32.to_le_bytes(), &[0; 50]].concat();
        for (content, expected) in [
            (&b"# Blender 4.1\nmtllib a.mtl\no Cube\nv 1 1 1"[..], "an OBJ mesh"),
            (b"v 1 2 3\nv 1 2 4", "an OBJ mesh"),
            (b"newmtl red\nKd 1 0 0", "the materials of an OBJ mesh (.mtl)"),
            (b"{ \"asset\": { \"version\": \"2.0\" } }", "a glTF scene"),
            (b"{ \"a\": 1 }", "a JSON file"),
            (b"glTF\x02\0\0\0", "a glTF scene (GLB)"),
            (b"#usda 1.0\n(", "a USD scene"),
            (b"PXR-USDC\0", "a USD scene"),
            (b"<?xml version=\"1.0\"?>\n<scene version=\"3.0.0\">", "a scene of Mitsuba (XML)"),
            (b"<scene version=\"2.0.0\">", "a scene of Mitsuba (XML)"),
            (b"BLENDER-v303", "a Blender file"),
            (b"ply\nformat ascii 1.0\n", "a PLY mesh"),
            (b"solid cube\n facet normal 0 0 1", "an STL mesh"),
            (&binary_stl, "an STL mesh"),
            (b"\x89PNG\r\n\x1a\n", "a picture (PNG)"),
            (b"# dgauss\n29.475 3.76 1.67 25.2\n", "a lens file"),
        ] {
            assert_eq!(foreign_scene(content), Some(expected));
        }
    }

    #[test]
    fn scenes_are_not_mistaken_for_others() {
        for content in [
            &b"Film \"rgb\"\nWorldBegin\n"[..],
            b"# v 1 2 3\n\nLookAt 0 0 0 1 1 1 0 1 0\n",
            b"",
            b"Include \"a.pbrt\"",
            b"Transform [ 1 0 0 0 ]",
        ] {
            assert_eq!(foreign_scene(content), None, "{}", String::from_utf8_lossy(content));
            assert_eq!(wide_encoding(content), None);
            assert!(refuse_placeholder(content).is_ok());
        }
    }

    #[test]
    fn utf_16_is_named_with_and_without_a_mark() {
        for content in [&b"\xff\xfeF\0i\0"[..], b"\xfe\xff\0F\0i", b"F\0i\0l\0", b"\0F\0i\0l"] {
            assert_eq!(wide_encoding(content), Some("UTF-16"));
        }
        assert_eq!(wide_encoding(b"\xff\xfe\0\0F\0\0\0"), Some("UTF-32"));
    }

    #[test]
    fn placeholders_come_with_a_remedy() {
        let refusal = |content: &[u8]| refuse_placeholder(content).unwrap_err().to_string();
        let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n";
        assert!(refusal(pointer).contains("git lfs pull"));
        assert!(refusal(b"\n<!DOCTYPE HTML><html>").contains("web page"));
        assert!(refusal(b"\xef\xbb\xbf<html lang=\"en\">").contains("download"));
    }
}
