//! Reader of tensor files, the format of the RGL's material database (Dupuy & Jakob 2018).
//!
//! A file is the text `tensor_file` with a zero byte, the version 1.0 in two bytes, the number of
//! fields, and the fields: length and text of a name, number of dimensions, type, offset of the data
//! and the size of every dimension. All numbers are little-endian.

/// The first bytes of a tensor file.
const MAGIC: &[u8] = b"tensor_file\0";
/// Number of the type of 32-bit floats.
const FLOAT32: u8 = 10;
/// Largest number of fields and dimensions; the RGL's files have 10 and 5.
const MAX_COUNT: usize = 64;

/// An array of 32-bit floats; the last dimension varies fastest.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tensor {
    pub(super) shape: Vec<usize>,
    pub(super) values: Vec<f32>,
}

/// A field of a file: its type, shape and the offset of its data.
#[derive(Clone, Debug)]
struct Field {
    name: String,
    kind: u8,
    shape: Vec<usize>,
    offset: usize,
}

/// The fields of a tensor file.
#[derive(Clone, Debug)]
pub(super) struct TensorFile<'a> {
    bytes: &'a [u8],
    fields: Vec<Field>,
}

/// Position in a file's bytes.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.bytes.len());
        let end = end.ok_or_else(|| format!("the file ends within byte {}", self.at))?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    /// Reads an integer of up to eight bytes.
    fn integer(&mut self, bytes: usize) -> Result<usize, String> {
        let value = self.take(bytes)?.iter().rev().fold(0u64, |sum, &b| sum << 8 | u64::from(b));
        usize::try_from(value).map_err(|_| format!("the number {value} at byte {}", self.at))
    }
}

impl<'a> TensorFile<'a> {
    /// Reads the list of fields.
    ///
    /// # Errors
    /// Returns the fault of a file that is not a tensor file, or is cut off.
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, String> {
        let mut cursor = Cursor { bytes, at: 0 };
        if cursor.take(MAGIC.len()).ok() != Some(MAGIC) {
            return Err("it does not begin with \"tensor_file\"".to_owned());
        }
        let version = cursor.take(2)?;
        if version != [1, 0] {
            return Err(format!("version {}.{} of the format", version[0], version[1]));
        }
        let count = cursor.integer(4)?;
        if count > MAX_COUNT {
            return Err(format!("{count} fields"));
        }
        let mut fields = Vec::with_capacity(count);
        for _ in 0..count {
            let length = cursor.integer(2)?;
            let name = String::from_utf8_lossy(cursor.take(length)?).into_owned();
            let dimensions = cursor.integer(2)?;
            if dimensions > MAX_COUNT {
                return Err(format!("{dimensions} dimensions of the field \"{name}\""));
            }
            let kind = cursor.take(1)?[0];
            let offset = cursor.integer(8)?;
            let shape = (0..dimensions).map(|_| cursor.integer(8)).collect::<Result<_, _>>()?;
            fields.push(Field { name, kind, shape, offset });
        }
        Ok(Self { bytes, fields })
    }

    /// Returns whether the file has a field.
    pub(super) fn has(&self, name: &str) -> bool {
        self.fields.iter().any(|field| field.name == name)
    }

    /// Reads a field of 32-bit floats with this number of dimensions.
    ///
    /// # Errors
    /// Returns the fault of a field that is missing, of another type, empty, cut off, or not finite.
    pub(super) fn floats(&self, name: &str, dimensions: usize) -> Result<Tensor, String> {
        let field = self.fields.iter().find(|field| field.name == name);
        let field = field.ok_or_else(|| format!("no field \"{name}\""))?;
        let Field { kind, shape, offset, .. } = field;
        if *kind != FLOAT32 || shape.len() != dimensions || shape.contains(&0) {
            return Err(format!("the field \"{name}\" has type {kind} and shape {shape:?}"));
        }
        let count = shape.iter().try_fold(4usize, |product, &n| product.checked_mul(n));
        let bytes = count.and_then(|count| {
            self.bytes.get(*offset..)?.get(..count).map(|bytes| bytes.as_chunks::<4>().0)
        });
        let bytes = bytes.ok_or_else(|| format!("the file ends within the field \"{name}\""))?;
        let values: Vec<f32> = bytes.iter().map(|&value| f32::from_le_bytes(value)).collect();
        match values.iter().all(|value| value.is_finite()) {
            true => Ok(Tensor { shape: shape.clone(), values }),
            false => Err(format!("the field \"{name}\" has a value that is not finite")),
        }
    }
}
