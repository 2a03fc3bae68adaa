//! Arrays in NumPy's format, version 1.0.

use std::io::Write as _;

/// Returns a file that holds an array of 32-bit floats, the last axis fastest.
pub fn encode(shape: &[usize], values: &[f32]) -> Vec<u8> {
    let mut file = header(shape);
    file.reserve(4 * values.len());
    for value in values {
        // A vector takes every byte.
        let _ = file.write_all(&value.to_le_bytes());
    }
    file
}

/// Returns the beginning of a file of an array of 32-bit floats, which follow in little-endian order, the last
/// axis fastest.
pub fn header(shape: &[usize]) -> Vec<u8> {
    let axes: Vec<String> = shape.iter().map(|n| format!("{n},")).collect();
    let mut header =
        format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({}), }}", axes.join(" "));
    // Magic, version and length take ten bytes; the data begin at a multiple of 64.
    let padded = (10 + header.len() + 1).next_multiple_of(64) - 10;
    header.extend(std::iter::repeat_n(' ', padded - header.len() - 1));
    header.push('\n');
    let mut file = Vec::with_capacity(10 + padded);
    file.extend(b"\x93NUMPY\x01\x00");
    file.extend((padded as u16).to_le_bytes());
    file.extend(header.as_bytes());
    file
}

#[cfg(test)]
mod tests {
    use super::encode;

    #[test]
    fn the_header_is_padded_and_the_data_follow() {
        let file = encode(&[2, 1], &[1.0, -2.5]);
        assert_eq!(&file[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([file[8], file[9]]));
        assert_eq!(((10 + length) % 64, file[10 + length - 1]), (0, b'\n'));
        let header = std::str::from_utf8(&file[10..10 + length]).unwrap();
        assert!(header.starts_with("{'descr': '<f4', 'fortran_order': False, 'shape': (2, 1,), }"));
        assert_eq!(file[10 + length..], [1.0f32.to_le_bytes(), (-2.5f32).to_le_bytes()].concat());
    }
}
