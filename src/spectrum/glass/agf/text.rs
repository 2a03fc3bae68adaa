//! Encodings of catalogues.

use petzval_base::io::wide_encoding;

/// Returns the text of a file in UTF-8, UTF-16 or Latin-1, which is what is not UTF-8.
pub(super) fn decode(bytes: &[u8]) -> String {
    let wide = |from: fn([u8; 2]) -> u16| {
        let units = bytes.as_chunks().0.iter().map(|pair| from(*pair));
        let text: String = char::decode_utf16(units).map(|c| c.unwrap_or('?')).collect();
        text.trim_start_matches('\u{feff}').to_owned()
    };
    match (wide_encoding(bytes), bytes) {
        (Some("UTF-16"), [0xfe, 0xff, ..] | [0, ..]) => wide(u16::from_be_bytes),
        (Some("UTF-16"), _) => wide(u16::from_le_bytes),
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
            Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
        },
    }
}
