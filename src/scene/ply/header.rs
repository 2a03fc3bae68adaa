//! The header of a PLY file: what follows it, and in which form.

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Order {
    Ascii,
    Little,
    Big,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
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

    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) value: Scalar,
    /// The type of the length, if this is a list.
    pub(super) length: Option<Scalar>,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

/// The order of bytes, what follows, and where it begins.
pub(super) fn header(bytes: &[u8]) -> Result<(Order, Vec<Element>, usize), String> {
    let mut order = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut next = 0;
    for line in 1.. {
        let rest = &bytes[next..];
        let end = rest.iter().take(1000).position(|&b| b == b'\n');
        let Some(end) = end else { return Err(format!("line {line}: the header does not end")) };
        let text = String::from_utf8_lossy(&rest[..end]);
        let words: Vec<&str> = text.split_whitespace().collect();
        next += end + 1;
        let wrong = || format!("line {line}: \"{}\" is no PLY header line", text.trim());
        match words[..] {
            _ if line == 1 && words != ["ply"] => {
                return Err("not a PLY file: it does not begin with \"ply\"".to_owned());
            }
            ["ply"] | ["comment", ..] | ["obj_info", ..] | [] => {}
            ["format", format, _] => {
                order = Some(match format {
                    "ascii" => Order::Ascii,
                    "binary_little_endian" => Order::Little,
                    "binary_big_endian" => Order::Big,
                    _ => return Err(wrong()),
                });
            }
            ["element", name, count] => elements.push(Element {
                name: name.to_owned(),
                count: count.parse().map_err(|_| wrong())?,
                properties: Vec::new(),
            }),
            ["property", "list", length, value, name] => {
                let length = Some(Scalar::named(length).ok_or_else(wrong)?);
                let value = Scalar::named(value).ok_or_else(wrong)?;
                let property = Property { name: name.to_owned(), value, length };
                elements.last_mut().ok_or_else(wrong)?.properties.push(property);
            }
            ["property", value, name] => {
                let value = Scalar::named(value).ok_or_else(wrong)?;
                let property = Property { name: name.to_owned(), value, length: None };
                elements.last_mut().ok_or_else(wrong)?.properties.push(property);
            }
            ["end_header"] => break,
            _ => return Err(wrong()),
        }
    }
    if let Some(empty) = elements.iter().find(|e| e.properties.is_empty() && e.count > 0) {
        return Err(format!("element \"{}\" has no properties", empty.name));
    }
    Ok((order.ok_or("the header names no format")?, elements, next))
}
