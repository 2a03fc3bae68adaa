//! Container of binary glTF files: chunks of text and of data.

/// Length of the header of a GLB, and of the header of each of its chunks (bytes).
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Splits a GLB into its text and its binary chunk.
pub(super) fn split_glb(content: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
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
