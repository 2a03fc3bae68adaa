//! Numbers in buffers: accessors, with strides, normalized integers and sparse replacements.

use super::document::Document;
use super::schema::{BufferView, ComponentType, Index};
use crate::pbrt::SceneError;
use petzval_base::io::HeldMemory;

/// Items of equal size in a buffer.
struct Items<'a> {
    bytes: &'a [u8],
    size: usize,
    stride: usize,
    count: usize,
}

impl<'a> Items<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> {
        let (bytes, size, stride) = (self.bytes, self.size, self.stride);
        (0..self.count).map(move |i| &bytes[i * stride..i * stride + size])
    }
}

/// Kind of the numbers of an accessor.
#[derive(Clone, Copy)]
struct Layout {
    component: ComponentType,
    normalized: bool,
}

impl Layout {
    /// Returns the i-th number of an item.
    fn number(self, item: &[u8], i: usize) -> f32 {
        let size = self.component.size();
        let bytes = &item[i * size..(i + 1) * size];
        let scaled = |value: f32, most: f32| match self.normalized {
            true => (value / most).max(-1.0),
            false => value,
        };
        match (self.component, bytes) {
            (ComponentType::I8, [a]) => scaled(f32::from(*a as i8), 127.0),
            (ComponentType::U8, [a]) => scaled(f32::from(*a), 255.0),
            (ComponentType::I16, [a, b]) => {
                scaled(f32::from(i16::from_le_bytes([*a, *b])), 32767.0)
            }
            (ComponentType::U16, [a, b]) => {
                scaled(f32::from(u16::from_le_bytes([*a, *b])), 65535.0)
            }
            (ComponentType::U32, [a, b, c, d]) => u32::from_le_bytes([*a, *b, *c, *d]) as f32,
            (ComponentType::F32, [a, b, c, d]) => f32::from_le_bytes([*a, *b, *c, *d]),
            _ => 0.0,
        }
    }
}

fn integer(component: ComponentType, item: &[u8]) -> Option<u32> {
    match (component, item) {
        (ComponentType::U8, [a]) => Some(u32::from(*a)),
        (ComponentType::U16, [a, b]) => Some(u32::from(u16::from_le_bytes([*a, *b]))),
        (ComponentType::U32, [a, b, c, d]) => Some(u32::from_le_bytes([*a, *b, *c, *d])),
        _ => None,
    }
}

impl Document {
    /// Returns the vectors of an accessor that the element `named_at` names. Their memory is added to
    /// `held`.
    pub fn vectors<const N: usize>(
        &self,
        index: Index,
        named_at: &str,
        held: &mut HeldMemory,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let accessors = &self.root.accessors;
        let accessor = self.entry(accessors, index.value(), "accessors", named_at)?;
        let element = format!("accessors/{}", index.value());
        let (Some(component), Some(width)) = (accessor.component(), accessor.width()) else {
            let expected = "expected a type and a componentType of glTF 2.0";
            return Err(self.error(&element, "numbers of no known type", expected));
        };
        if width != N {
            let found = format!("vectors of {width} components");
            return Err(self.error(&element, found, &format!("expected {N}")));
        }
        let layout = Layout { component, normalized: accessor.normalized };
        let size = N * layout.component.size();
        let vector = |item: &[u8]| std::array::from_fn(|i| layout.number(item, i));
        let count = self.hold(held, accessor.count.0, N * size_of::<f32>(), &element)?;
        let mut vectors: Vec<[f32; N]> = match accessor.buffer_view {
            Some(view) => {
                let start = accessor.byte_offset.unwrap_or_default().0;
                self.items(view, start, count, size, &element)?.iter().map(vector).collect()
            }
            None => vec![[0.0; N]; count],
        };
        if let Some(sparse) = &accessor.sparse {
            let element = format!("{element}/sparse");
            let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
            let Some(component) = sparse.indices.component() else {
                let expected = "expected unsigned integers";
                return Err(self.error(&element, "indices of no known type", expected));
            };
            let indices = self.items(
                sparse.indices.buffer_view,
                sparse.indices.byte_offset.0,
                count,
                component.size(),
                &format!("{element}/indices"),
            )?;
            let values = self.items(
                sparse.values.buffer_view,
                sparse.values.byte_offset.0,
                count,
                size,
                &format!("{element}/values"),
            )?;
            for (index, value) in indices.iter().zip(values.iter()) {
                let at = integer(component, index).map_or(usize::MAX, |i| i as usize);
                let Some(place) = vectors.get_mut(at) else {
                    let expected = format!("the accessor has {} elements", accessor.count.0);
                    return Err(self.error(&element, format!("an index of {at}"), &expected));
                };
                *place = vector(value);
            }
        }
        if let Some(i) = vectors.iter().position(|v| !v.iter().all(|x| x.is_finite())) {
            let found = format!("element {i} is not finite");
            return Err(self.error(&element, found, "expected finite numbers"));
        }
        Ok(vectors)
    }

    /// Returns the colours of an accessor that the element `named_at` names, linear RGB and opacity,
    /// 0 to 1. Their memory is added to `held`.
    pub fn colours(
        &self,
        index: Index,
        named_at: &str,
        held: &mut HeldMemory,
    ) -> Result<Vec<[f32; 4]>, SceneError> {
        let accessor = self.entry(&self.root.accessors, index.value(), "accessors", named_at)?;
        let is_float = accessor.component() == Some(ComponentType::F32);
        if !is_float && !accessor.normalized {
            let element = format!("accessors/{}", index.value());
            let expected = "expected floats or normalized integers";
            return Err(self.error(&element, "colours that are plain integers", expected));
        }
        let clamped = |v: f32| v.clamp(0.0, 1.0);
        Ok(match accessor.width() {
            Some(4) => {
                let colours = self.vectors::<4>(index, named_at, held)?.into_iter();
                colours.map(|colour| colour.map(clamped)).collect()
            }
            _ => {
                let colours = self.vectors::<3>(index, named_at, held)?;
                self.hold(held, colours.len() as u64, size_of::<[f32; 4]>(), named_at)?;
                let colours = colours.into_iter();
                colours.map(|[r, g, b]| [r, g, b, 1.0].map(clamped)).collect()
            }
        })
    }

    /// Returns the indices of an accessor that the element `named_at` names. Their memory is added to
    /// `held`.
    pub fn indices(
        &self,
        index: Index,
        named_at: &str,
        held: &mut HeldMemory,
    ) -> Result<Vec<u32>, SceneError> {
        let accessors = &self.root.accessors;
        let accessor = self.entry(accessors, index.value(), "accessors", named_at)?;
        let element = format!("accessors/{}", index.value());
        let expected = "expected scalars that are unsigned integers, in a bufferView";
        let refuse = |found: &str| Err(self.error(&element, found, expected));
        let (Some(component), Some(1)) = (accessor.component(), accessor.width()) else {
            return refuse("indices of another type");
        };
        let Some(view) = accessor.buffer_view.filter(|_| accessor.sparse.is_none()) else {
            return refuse("indices that are sparse");
        };
        let count = self.hold(held, accessor.count.0, size_of::<u32>(), &element)?;
        let start = accessor.byte_offset.unwrap_or_default().0;
        let items = self.items(view, start, count, component.size(), &element)?;
        let all: Option<Vec<u32>> = items.iter().map(|item| integer(component, item)).collect();
        all.map_or_else(|| refuse("indices of another type"), Ok)
    }

    /// Holds memory for items of so many bytes, and returns their number.
    fn hold(
        &self,
        held: &mut HeldMemory,
        count: u64,
        bytes: usize,
        element: &str,
    ) -> Result<usize, SceneError> {
        held.add(count.saturating_mul(bytes as u64))
            .map_err(|refusal| self.too_large(element, &refusal))?;
        Ok(count as usize)
    }

    /// Returns the bytes of a view of a buffer, and its stride.
    pub fn view(&self, view: Index, named_at: &str) -> Result<(&[u8], Option<usize>), SceneError> {
        let BufferView { buffer, byte_length, byte_offset, byte_stride } =
            self.entry(&self.root.buffer_views, view.value(), "bufferViews", named_at)?;
        let element = format!("bufferViews/{}", view.value());
        let content = self.buffer(buffer.value(), &element)?;
        let start = byte_offset.unwrap_or_default().0;
        let end = start.saturating_add(byte_length.0);
        let range = usize::try_from(start).ok().zip(usize::try_from(end).ok());
        let bytes = range.and_then(|(start, end)| content.get(start..end)).ok_or_else(|| {
            let expected = format!("its buffer has {} bytes", content.len());
            self.error(&element, format!("bytes {start} to {end}"), &expected)
        })?;
        Ok((bytes, byte_stride.map(|stride| usize::try_from(stride.0).unwrap_or(usize::MAX))))
    }

    /// Returns items in a view from an offset on.
    fn items(
        &self,
        view: Index,
        start: u64,
        count: usize,
        size: usize,
        named_at: &str,
    ) -> Result<Items<'_>, SceneError> {
        let (bytes, stride) = self.view(view, named_at)?;
        let stride = stride.unwrap_or(size);
        if stride < size {
            let element = format!("bufferViews/{}/byteStride", view.value());
            let expected = format!("its elements have {size} bytes");
            return Err(self.error(&element, format!("a stride of {stride}"), &expected));
        }
        let length = match count {
            0 => Some(0),
            _ => (count - 1).checked_mul(stride).and_then(|all| all.checked_add(size)),
        };
        let rest = usize::try_from(start).ok().and_then(|start| bytes.get(start..));
        match rest.zip(length).filter(|(rest, length)| rest.len() >= *length) {
            Some((bytes, _)) => Ok(Items { bytes, size, stride, count }),
            None => {
                let found = format!("{count} elements of {size} bytes from byte {start} on");
                let expected = format!("its bufferView has {} bytes", bytes.len());
                Err(self.error(named_at, found, &expected))
            }
        }
    }
}
