//! Accessors: numbers in buffers, read one by one within their bounds.

use std::collections::HashMap;

use gltf::json::accessor::{Accessor, ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer::View};

use super::GltfFault;
use super::document::Document;
use super::error::wrong;

/// The elements of an accessor, all of which lie inside of its buffer.
pub(super) struct Elements<'a> {
    /// As errors call it.
    thing: String,
    pub count: usize,
    /// From the first element on; `None` where all are 0 but those of `sparse`.
    bytes: Option<&'a [u8]>,
    /// From one element to the next, bytes.
    stride: usize,
    component: ComponentType,
    is_normalized: bool,
    /// Elements that stand in other places.
    sparse: HashMap<usize, &'a [u8]>,
}

impl<'a> Elements<'a> {
    /// The elements of an accessor of this type, which hold a number a component.
    pub(super) fn open(
        document: &'a Document,
        index: Index<Accessor>,
        wanted: Type,
    ) -> Result<Self, GltfFault> {
        let accessor = document.get(index)?;
        let thing = match &accessor.name {
            Some(name) => format!("accessors[{index}] \"{name}\""),
            None => format!("accessors[{index}]"),
        };
        let (Checked::Valid(kind), Checked::Valid(component)) =
            (accessor.type_, accessor.component_type)
        else {
            return Err(wrong(
                thing,
                "its type or componentType is none of glTF 2.0",
            ));
        };
        if kind != wanted {
            return Err(wrong(
                thing,
                format!("its type is {kind:?}, but {wanted:?} is needed here"),
            ));
        }
        let component = component.0;
        let size = component.size() * kind.multiplicity();
        let count = usize::try_from(accessor.count.0)
            .map_err(|_| wrong(&thing, format!("count {}", accessor.count.0)))?;
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let mut stride = size;
        let mut bytes = None;
        if let Some(view) = accessor.buffer_view {
            if let Some(given) = document.get(view)?.byte_stride {
                stride = given.0;
            }
            if stride < size {
                return Err(wrong(
                    thing,
                    format!(
                        "the byteStride {stride} of bufferViews[{view}] is less than the {size} bytes of an element"
                    ),
                ));
            }
            bytes = Some(range(document, view, offset, count, stride, size, &thing)?);
        }
        let mut elements = Self {
            thing,
            count,
            bytes,
            stride,
            component,
            is_normalized: accessor.normalized,
            sparse: HashMap::new(),
        };
        elements.replace(document, accessor, size)?;
        Ok(elements)
    }

    /// Reads which elements stand in other places.
    fn replace(
        &mut self,
        document: &'a Document,
        accessor: &Accessor,
        size: usize,
    ) -> Result<(), GltfFault> {
        let Some(sparse) = &accessor.sparse else {
            return Ok(());
        };
        let thing = format!("{}.sparse", self.thing);
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err(wrong(thing, "its componentType is none of glTF 2.0"));
        };
        let component = component.0;
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        if count > self.count {
            return Err(wrong(
                thing,
                format!(
                    "{count} elements are more than the {} of the accessor",
                    self.count
                ),
            ));
        }
        let width = component.size();
        let (indices, values) = (&sparse.indices, &sparse.values);
        let indices = range(
            document,
            indices.buffer_view,
            indices.byte_offset.0,
            count,
            width,
            width,
            &thing,
        )?;
        let values = range(
            document,
            values.buffer_view,
            values.byte_offset.0,
            count,
            size,
            size,
            &thing,
        )?;
        for (index, value) in indices.chunks_exact(width).zip(values.chunks_exact(size)) {
            let index = number(index, component, false) as usize;
            if index >= self.count {
                return Err(wrong(
                    thing,
                    format!(
                        "index {index} is out of range, the accessor has {}",
                        self.count
                    ),
                ));
            }
            self.sparse.insert(index, value);
        }
        Ok(())
    }

    /// An element of `N` components, all finite.
    pub(super) fn get<const N: usize>(&self, index: usize) -> Result<[f64; N], GltfFault> {
        let width = self.component.size();
        let beyond = || {
            wrong(
                &self.thing,
                format!(
                    "index {index} is out of range, the accessor has {}",
                    self.count
                ),
            )
        };
        if index >= self.count {
            return Err(beyond());
        }
        let mut element = [0.0; N];
        let bytes = match (self.sparse.get(&index), self.bytes) {
            (Some(value), _) => value,
            (None, Some(bytes)) => bytes.get(index * self.stride..).ok_or_else(beyond)?,
            (None, None) => return Ok(element),
        };
        for (value, bytes) in element.iter_mut().zip(bytes.chunks_exact(width)) {
            *value = number(bytes, self.component, self.is_normalized);
            if !value.is_finite() {
                return Err(wrong(
                    &self.thing,
                    format!("element {index} has the value {value}, which is not finite"),
                ));
            }
        }
        Ok(element)
    }

    /// An element that is an index of one of `count` vertices.
    pub(super) fn index(&self, element: usize, count: usize) -> Result<usize, GltfFault> {
        let [index] = self.get(element)?;
        let index = index as usize;
        if index >= count {
            return Err(wrong(
                &self.thing,
                format!(
                    "element {element} is index {index}, but the primitive has {count} vertices"
                ),
            ));
        }
        Ok(index)
    }

    /// Checks that the elements are unsigned integers.
    pub(super) fn check_indices(&self) -> Result<(), GltfFault> {
        match self.component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 if !self.is_normalized => {
                Ok(())
            }
            _ => Err(wrong(
                &self.thing,
                format!("its components are {:?}, no indices", self.component),
            )),
        }
    }

    /// Checks that there are as many elements as vertices.
    pub(super) fn check_count(&self, vertices: usize) -> Result<(), GltfFault> {
        if self.count == vertices {
            return Ok(());
        }
        Err(wrong(
            &self.thing,
            format!(
                "it has {} elements, but the primitive has {vertices} vertices",
                self.count
            ),
        ))
    }
}

/// The bytes of `count` elements of a view.
fn range<'a>(
    document: &'a Document,
    index: Index<View>,
    offset: u64,
    count: usize,
    stride: usize,
    size: usize,
    thing: &str,
) -> Result<&'a [u8], GltfFault> {
    let view = view(document, index)?;
    let needed = match count {
        0 => Some(0),
        _ => (count as u64 - 1)
            .checked_mul(stride as u64)
            .and_then(|bytes| bytes.checked_add(size as u64)),
    };
    let end = needed.and_then(|needed| offset.checked_add(needed));
    let found =
        end.and_then(|end| view.get(usize::try_from(offset).ok()?..usize::try_from(end).ok()?));
    found.ok_or_else(|| {
        let length = view.len();
        wrong(
            thing,
            format!("{count} elements from byte {offset} on, {stride} bytes apart, go beyond the {length} bytes of bufferViews[{index}]"),
        )
    })
}

/// The bytes of a view.
pub(super) fn view(document: &Document, index: Index<View>) -> Result<&[u8], GltfFault> {
    let view = document.get(index)?;
    let buffer = view.buffer.value();
    let length = document.get(view.buffer)?.byte_length.0;
    let offset = view.byte_offset.unwrap_or_default().0;
    let end = offset.checked_add(view.byte_length.0);
    let found = end.filter(|&end| end <= length).and_then(|end| {
        let bytes = document.buffers.get(buffer)?;
        bytes.get(usize::try_from(offset).ok()?..usize::try_from(end).ok()?)
    });
    found.ok_or_else(|| {
        wrong(
            format!("bufferViews[{index}]"),
            format!(
                "{} bytes from byte {offset} on go beyond the {length} bytes of buffers[{buffer}]",
                view.byte_length.0
            ),
        )
    })
}

/// A component; normalized ones are fractions of 1, as the format says.
fn number(bytes: &[u8], component: ComponentType, is_normalized: bool) -> f64 {
    let (value, most) = match (component, bytes) {
        (ComponentType::I8, &[a, ..]) => (f64::from(a as i8), f64::from(i8::MAX)),
        (ComponentType::U8, &[a, ..]) => (f64::from(a), f64::from(u8::MAX)),
        (ComponentType::I16, &[a, b, ..]) => {
            (f64::from(i16::from_le_bytes([a, b])), f64::from(i16::MAX))
        }
        (ComponentType::U16, &[a, b, ..]) => {
            (f64::from(u16::from_le_bytes([a, b])), f64::from(u16::MAX))
        }
        (ComponentType::U32, &[a, b, c, d, ..]) => (
            f64::from(u32::from_le_bytes([a, b, c, d])),
            f64::from(u32::MAX),
        ),
        (ComponentType::F32, &[a, b, c, d, ..]) => {
            (f64::from(f32::from_le_bytes([a, b, c, d])), 1.0)
        }
        // Callers hand over whole components.
        _ => (0.0, 1.0),
    };
    if is_normalized {
        (value / most).max(-1.0)
    } else {
        value
    }
}
