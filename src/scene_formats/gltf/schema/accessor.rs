//! Buffers, their views, and accessors.

use serde::Deserialize;

use super::{Index, Integer};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    /// Length (bytes).
    #[serde(default)]
    pub byte_length: Integer,
    pub uri: Option<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: Index,
    pub byte_length: Integer,
    pub byte_offset: Option<Integer>,
    pub byte_stride: Option<Integer>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<Index>,
    pub byte_offset: Option<Integer>,
    pub count: Integer,
    component_type: Integer,
    #[serde(rename = "type")]
    kind: String,
    #[serde(default)]
    pub normalized: bool,
    pub sparse: Option<Sparse>,
}

impl Accessor {
    /// Returns the kind of its numbers, or `None` for one that glTF does not know.
    pub fn component(&self) -> Option<ComponentType> {
        ComponentType::new(self.component_type)
    }

    /// Returns the number of components of an element, or `None` for a type that glTF does not know.
    pub fn width(&self) -> Option<usize> {
        match &self.kind[..] {
            "SCALAR" => Some(1),
            "VEC2" => Some(2),
            "VEC3" => Some(3),
            "VEC4" | "MAT2" => Some(4),
            "MAT3" => Some(9),
            "MAT4" => Some(16),
            _ => None,
        }
    }
}

/// Elements that differ from those of the view.
#[derive(Deserialize)]
pub struct Sparse {
    pub count: Integer,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: Index,
    #[serde(default)]
    pub byte_offset: Integer,
    component_type: Integer,
}

impl SparseIndices {
    /// Returns the kind of the indices if they are unsigned integers.
    pub fn component(&self) -> Option<ComponentType> {
        use ComponentType::{U8, U16, U32};
        ComponentType::new(self.component_type).filter(|kind| matches!(kind, U8 | U16 | U32))
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: Index,
    #[serde(default)]
    pub byte_offset: Integer,
}

/// Kind of a number in a buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ComponentType {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl ComponentType {
    fn new(code: Integer) -> Option<Self> {
        match code.0 {
            5120 => Some(Self::I8),
            5121 => Some(Self::U8),
            5122 => Some(Self::I16),
            5123 => Some(Self::U16),
            5125 => Some(Self::U32),
            5126 => Some(Self::F32),
            _ => None,
        }
    }

    /// Returns the size of a number (bytes).
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}
