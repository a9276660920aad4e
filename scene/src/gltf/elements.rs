//! Accessors: numbers in buffers, read one by one within their bounds.

use gltf::json::accessor::{Accessor, ComponentType};
use gltf::json::validation::Checked;
use gltf::json::{Index, buffer::View};

use super::GltfFault;
use super::document::Document;
use super::error::wrong;
use super::layouts::Layout;

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
    sparse: Option<Sparse<'a>>,
}

/// Elements that stand in other places.
struct Sparse<'a> {
    /// Which they are, strictly increasing.
    indices: &'a [u8],
    component: ComponentType,
    values: &'a [u8],
    /// Of a value, bytes.
    size: usize,
}

impl<'a> Elements<'a> {
    /// The elements of an accessor of this layout, which hold a number a component.
    pub(super) fn open(
        document: &'a Document,
        index: Index<Accessor>,
        layout: &Layout,
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
        let component = component.0;
        if !layout.kinds.contains(&kind) {
            let kinds = layout.kinds;
            return Err(wrong(
                thing,
                format!("its type is {kind:?}, but one of {kinds:?} is needed here"),
            ));
        }
        let is_normalized = accessor.normalized;
        if !layout.takes(component, is_normalized) {
            return Err(wrong(
                thing,
                format!(
                    "its components are {component:?} with normalized {is_normalized}, which cannot be here"
                ),
            ));
        }
        let size = component.size() * kind.multiplicity();
        let count = usize::try_from(accessor.count.0)
            .map_err(|_| wrong(&thing, format!("count {}", accessor.count.0)))?;
        let mut stride = size;
        let mut bytes = None;
        if let Some(view) = accessor.buffer_view {
            if let Some(given) = document.get(view)?.byte_stride {
                stride = given.0;
            }
            if stride < size || !stride.is_multiple_of(component.size()) {
                return Err(wrong(
                    thing,
                    format!(
                        "the byteStride {stride} of bufferViews[{view}] is less than the {size} bytes of an element, or no \
                         multiple of the {} bytes of a component",
                        component.size()
                    ),
                ));
            }
            let offset = accessor.byte_offset.unwrap_or_default().0;
            let run = Run {
                view,
                offset,
                count,
                stride,
                size,
            };
            bytes = Some(run.bytes(document, &thing)?);
        }
        let mut elements = Self {
            thing,
            count,
            bytes,
            stride,
            component,
            is_normalized,
            sparse: None,
        };
        elements.sparse = elements.sparse(document, accessor, size)?;
        Ok(elements)
    }

    /// Reads which elements stand in other places (section 3.6.2.3).
    fn sparse(
        &self,
        document: &'a Document,
        accessor: &Accessor,
        size: usize,
    ) -> Result<Option<Sparse<'a>>, GltfFault> {
        let Some(sparse) = &accessor.sparse else {
            return Ok(None);
        };
        let thing = format!("{}.sparse", self.thing);
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err(wrong(thing, "its componentType is none of glTF 2.0"));
        };
        let component = component.0;
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        if count > self.count {
            let most = self.count;
            return Err(wrong(
                thing,
                format!("{count} elements are more than the {most} of the accessor"),
            ));
        }
        let packed = |view, offset, size| Run {
            view,
            offset,
            count,
            stride: size,
            size,
        };
        let (indices, values) = (&sparse.indices, &sparse.values);
        let width = component.size();
        let indices = packed(indices.buffer_view, indices.byte_offset.0, width);
        let values = packed(values.buffer_view, values.byte_offset.0, size);
        let sparse = Sparse {
            indices: indices.bytes(document, &thing)?,
            component,
            values: values.bytes(document, &thing)?,
            size,
        };
        let mut least = 0;
        for index in sparse.indices.chunks_exact(width) {
            let index = number(index, component, false) as usize;
            if index >= self.count {
                let count = self.count;
                return Err(wrong(
                    thing,
                    format!("index {index} is out of range, the accessor has {count}"),
                ));
            }
            if index < least {
                return Err(wrong(
                    thing,
                    format!(
                        "index {index} follows {}; indices have to increase",
                        least - 1
                    ),
                ));
            }
            least = index + 1;
        }
        Ok(Some(sparse))
    }

    /// An element of `N` components, or the first `N` of its components, all finite.
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
        let replaced = self.sparse.as_ref().and_then(|sparse| sparse.get(index));
        let bytes = match (replaced, self.bytes) {
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

    /// An element that is an index of one of `count` vertices. The largest one of its type is none: it starts a strip anew in
    /// some programs (section 3.7.2.1).
    pub(super) fn index(&self, element: usize, count: usize) -> Result<usize, GltfFault> {
        let [index] = self.get(element)?;
        let index = index as usize;
        let bits = 8 * self.component.size() as u32;
        if index as u64 == u64::MAX >> (64 - bits) {
            return Err(wrong(
                &self.thing,
                format!(
                    "element {element} is {index}, the largest number of its type, which is no index"
                ),
            ));
        }
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

    /// What is wrong with an element.
    pub(super) fn wrong(&self, element: usize, what: &str) -> GltfFault {
        wrong(&self.thing, format!("element {element}: {what}"))
    }
}

impl<'a> Sparse<'a> {
    /// The bytes of an element, if it is among these.
    fn get(&self, index: usize) -> Option<&'a [u8]> {
        let width = self.component.size();
        let (mut low, mut high) = (0, self.indices.len() / width);
        while low < high {
            let middle = usize::midpoint(low, high);
            let found = self.indices.get(middle * width..)?;
            let found = number(found, self.component, false) as usize;
            match found.cmp(&index) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
                std::cmp::Ordering::Equal => return self.values.get(middle * self.size..),
            }
        }
        None
    }
}

/// Elements in a view.
struct Run {
    view: Index<View>,
    /// Of the first, bytes.
    offset: u64,
    count: usize,
    /// From one to the next, bytes.
    stride: usize,
    /// Bytes.
    size: usize,
}

impl Run {
    fn bytes<'a>(&self, document: &'a Document, thing: &str) -> Result<&'a [u8], GltfFault> {
        let &Self {
            view: index,
            offset,
            count,
            stride,
            size,
        } = self;
        let view = document.view(index)?;
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
}

/// A component; normalized ones are fractions of 1 (section 3.6.2.2).
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
        (ComponentType::U32, &[a, b, c, d, ..]) => {
            (f64::from(u32::from_le_bytes([a, b, c, d])), 1.0)
        }
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
