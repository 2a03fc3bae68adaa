//! Values of a PLY file, in text or in binary form.

use super::header::{Encoding, PlyElement, ScalarType};
use petzval_base::io::excerpt;

/// Reader of the values after the header.
pub(super) struct ValueReader<'a> {
    encoding: Encoding,
    bytes: &'a [u8],
    /// Offset of the next value (bytes).
    next: usize,
}

impl<'a> ValueReader<'a> {
    pub(super) fn new(encoding: Encoding, bytes: &'a [u8], next: usize) -> Self {
        Self { encoding, bytes, next }
    }

    /// Returns the number of bytes that are not read yet.
    pub(super) fn remaining(&self) -> usize {
        self.bytes.len() - self.next
    }

    pub(super) fn read(&mut self, kind: ScalarType) -> Result<f64, String> {
        if self.encoding == Encoding::Ascii {
            return self.ascii_value();
        }
        let size = kind.size();
        let Some(slice) = self.bytes.get(self.next..self.next + size) else {
            return Err("the file ends too early".to_owned());
        };
        self.next += size;
        let mut raw = [0; 8];
        raw[..size].copy_from_slice(slice);
        if self.encoding == Encoding::BigEndian {
            raw[..size].reverse();
        }
        let [a, b, c, d, ..] = raw;
        Ok(match kind {
            ScalarType::I8 => f64::from(a as i8),
            ScalarType::U8 => f64::from(a),
            ScalarType::I16 => f64::from(i16::from_le_bytes([a, b])),
            ScalarType::U16 => f64::from(u16::from_le_bytes([a, b])),
            ScalarType::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            ScalarType::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            ScalarType::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            ScalarType::F64 => f64::from_le_bytes(raw),
        })
    }

    fn ascii_value(&mut self) -> Result<f64, String> {
        let rest = &self.bytes[self.next..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace());
        let Some(start) = start else { return Err("the file ends too early".to_owned()) };
        let length = rest[start..].iter().position(u8::is_ascii_whitespace);
        let end = length.map_or(rest.len(), |n| start + n);
        self.next += end;
        let text = String::from_utf8_lossy(&rest[start..end]);
        text.parse().map_err(|_| {
            let before = &self.bytes[..self.next];
            let lines = before.iter().filter(|&&b| b == b'\n').count();
            let returns = before.windows(2).filter(|b| b[0] == b'\r' && b[1] != b'\n').count();
            let line = 1 + lines + returns;
            format!("line {line}: \"{}\" is not a number", excerpt(&text))
        })
    }

    /// Reads the length of a list. It is at most the size of the file (bytes).
    pub(super) fn list_length(&mut self, kind: ScalarType) -> Result<usize, String> {
        let length = self.read(kind)?;
        if length >= 0.0 && length.fract() == 0.0 && length <= self.bytes.len() as f64 {
            return Ok(length as usize);
        }
        Err(format!("a list of {length} values"))
    }
}

/// Reads an element that is not needed.
pub(super) fn skip_element(element: &PlyElement, values: &mut ValueReader) -> Result<(), String> {
    for _ in 0..element.count {
        for property in &element.properties {
            let count = property.length.map_or(Ok(1), |kind| values.list_length(kind))?;
            for _ in 0..count {
                values.read(property.value)?;
            }
        }
    }
    Ok(())
}
