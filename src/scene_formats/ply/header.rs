//! Header of a PLY file: the encoding, elements and properties that it declares.

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ScalarType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl ScalarType {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct PlyProperty {
    pub(super) name: String,
    pub(super) value: ScalarType,
    /// The type of the length of a list; `None` if the property is a scalar.
    pub(super) length: Option<ScalarType>,
}

#[derive(Clone, Debug)]
pub(super) struct PlyElement {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<PlyProperty>,
}

/// The header of a PLY file.
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<PlyElement>,
    /// Offset of the first value (bytes).
    pub(super) size: usize,
}

/// Parses the header at the start of a PLY file.
pub(super) fn parse_header(bytes: &[u8]) -> Result<Header, String> {
    let mut encoding = None;
    let mut elements: Vec<PlyElement> = Vec::new();
    let mut next = 0;
    // All lines end as the first one, with \n, \r\n or \r: binary data after \r may begin with \n.
    let first = bytes.iter().take(1000).position(|&b| b == b'\n' || b == b'\r');
    let ends_with_return =
        first.is_some_and(|at| bytes[at] == b'\r' && bytes.get(at + 1) != Some(&b'\n'));
    let line_end = if ends_with_return { b'\r' } else { b'\n' };
    for line in 1.. {
        let rest = &bytes[next..];
        let end = rest.iter().take(1000).position(|&b| b == line_end);
        let Some(end) = end else { return Err(format!("line {line}: the header does not end")) };
        let text = String::from_utf8_lossy(&rest[..end]);
        let words: Vec<&str> = text.split_whitespace().collect();
        next += end + 1;
        let wrong = || format!("line {line}: \"{}\" is not a line of a PLY header", text.trim());
        match words[..] {
            _ if line == 1 && words != ["ply"] => {
                return Err("not a PLY file: it does not begin with \"ply\"".to_owned());
            }
            ["ply"] | ["comment", ..] | ["obj_info", ..] | [] => {}
            ["format", format, _] => {
                encoding = Some(match format {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(wrong()),
                });
            }
            ["element", name, count] => elements.push(PlyElement {
                name: name.to_owned(),
                count: count.parse().map_err(|_| wrong())?,
                properties: Vec::new(),
            }),
            ["property", "list", length, value, name] => {
                let length = Some(ScalarType::from_name(length).ok_or_else(wrong)?);
                let value = ScalarType::from_name(value).ok_or_else(wrong)?;
                let property = PlyProperty { name: name.to_owned(), value, length };
                elements.last_mut().ok_or_else(wrong)?.properties.push(property);
            }
            ["property", value, name] => {
                let value = ScalarType::from_name(value).ok_or_else(wrong)?;
                let property = PlyProperty { name: name.to_owned(), value, length: None };
                elements.last_mut().ok_or_else(wrong)?.properties.push(property);
            }
            ["end_header"] => break,
            _ => return Err(wrong()),
        }
    }
    if let Some(empty) = elements.iter().find(|e| e.properties.is_empty() && e.count > 0) {
        return Err(format!("element \"{}\" has no properties", empty.name));
    }
    let encoding = encoding.ok_or("the header names no format")?;
    Ok(Header { encoding, elements, size: next })
}
