//! Accessors: typed elements in buffer views (glTF 2.0 §3.6.2), with every component type, normalised integers,
//! strides and sparse elements. Opening an accessor checks it against the bytes of its buffer view before anything is
//! allocated; reading an element afterwards cannot fail.

use super::buffers::Buffers;
use super::fault::{Fault, Outcome};
use super::json::{Accessor, Document, Index};

/// The type of a component (§3.6.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(number: u32) -> Option<Component> {
        Some(match number {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    /// Size in bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// Whether an integer is in the range of this type.
    pub(super) fn holds(self, value: i64) -> bool {
        match self {
            Component::I8 => i8::try_from(value).is_ok(),
            Component::U8 => u8::try_from(value).is_ok(),
            Component::I16 => i16::try_from(value).is_ok(),
            Component::U16 => u16::try_from(value).is_ok(),
            Component::U32 => u32::try_from(value).is_ok(),
            Component::F32 => false,
        }
    }
}

/// Rows and columns of an element type.
fn shape(kind: &str) -> Option<(usize, usize)> {
    Some(match kind {
        "SCALAR" => (1, 1),
        "VEC2" => (2, 1),
        "VEC3" => (3, 1),
        "VEC4" => (4, 1),
        "MAT2" => (2, 2),
        "MAT3" => (3, 3),
        "MAT4" => (4, 4),
        _ => return None,
    })
}

/// The bytes of an element, and those that the last one needs.
#[derive(Clone, Copy, Debug)]
struct Size {
    all: usize,
    last: usize,
}

impl Size {
    /// Each column of a matrix starts at a multiple of four bytes (§3.6.2.4); the last column of the last element needs no
    /// padding.
    fn of_element(component: usize, rows: usize, columns: usize) -> Size {
        let column = rows * component;
        let padded = if columns > 1 { column.next_multiple_of(4) } else { column };
        Size { all: padded * columns, last: padded * (columns - 1) + column }
    }

    fn of(all: usize) -> Size {
        Size { all, last: all }
    }
}

/// Bytes of a component, of an element, and of the last element without padding, and the columns of an element.
pub(super) fn layout(component: u32, kind: &str) -> Option<[u64; 4]> {
    let (part, (rows, columns)) = (Component::of(component)?.size(), shape(kind)?);
    let size = Size::of_element(part, rows, columns);
    Some([part, size.all, size.last, columns].map(|v| v as u64))
}

/// Elements at a regular stride in bytes.
#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

impl<'a> Strided<'a> {
    #[inline]
    fn element(&self, i: usize) -> &'a [u8] {
        // In range: `locate` has checked the last element.
        i.checked_mul(self.stride).and_then(|at| self.bytes.get(at..)).unwrap_or(&[])
    }
}

/// Sparse elements: they replace those of the buffer view. The indices increase.
#[derive(Clone, Copy, Debug)]
struct Differing<'a> {
    count: usize,
    indices: Strided<'a>,
    index_type: Component,
    values: Strided<'a>,
}

impl Differing<'_> {
    fn index(&self, i: usize) -> usize {
        whole(self.index_type, self.indices.element(i)) as usize
    }

    /// The position of the element `wanted` among the sparse elements. Binary search.
    fn find(&self, wanted: usize) -> Option<usize> {
        let (mut from, mut to) = (0, self.count);
        while from < to {
            let middle = from + (to - from) / 2;
            if self.index(middle) < wanted { from = middle + 1 } else { to = middle }
        }
        (from < self.count && self.index(from) == wanted).then_some(from)
    }
}

/// A checked accessor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Elements<'a> {
    /// Number of elements.
    pub(super) count: usize,
    /// Components per element.
    pub(super) width: usize,
    /// Component type.
    pub(super) component: Component,
    /// Whether integers are mapped to 0..=1 (unsigned) or −1..=1 (signed).
    pub(super) normalized: bool,
    /// Index of the accessor in the document.
    pub(super) accessor: Index,
    size: Size,
    base: Option<Strided<'a>>,
    sparse: Option<Differing<'a>>,
}

#[inline]
fn bytes<const N: usize>(element: &[u8], at: usize) -> [u8; N] {
    element.get(at..).and_then(|e| e.first_chunk()).copied().unwrap_or([0; N])
}

#[inline]
fn whole(component: Component, element: &[u8]) -> u32 {
    match component {
        Component::U8 | Component::I8 => u32::from(bytes::<1>(element, 0)[0]),
        Component::U16 | Component::I16 => u32::from(u16::from_le_bytes(bytes(element, 0))),
        Component::U32 | Component::F32 => u32::from_le_bytes(bytes(element, 0)),
    }
}

impl<'a> Elements<'a> {
    /// Opens an accessor of the document. `pointer` is the JSON pointer of the reference to it.
    pub(super) fn open(
        document: &Document,
        buffers: &'a Buffers,
        accessor: Index,
        pointer: &str,
    ) -> Outcome<Elements<'a>> {
        let json = json_of(document, accessor, pointer)?;
        let mut elements = Elements::without_bytes(json, accessor)?;
        let at = format!("/accessors/{}", accessor.0);
        let (count, size) = (elements.count, elements.size);
        elements.base = match json.buffer_view {
            Some(view) => Some(locate(buffers, view, json.byte_offset.0, count, size, &at)?),
            None => {
                // Without a buffer view all elements are zero and take no bytes of the file; bound
                // their count by its size.
                let most = (buffers.size() as usize).max(65_536);
                if count > most {
                    let message = format!("{count} elements without a buffer view; expected at most {most}");
                    return Err(Fault::too_large(at, message));
                }
                None
            }
        };
        elements.open_sparse(json, buffers, &at)
    }

    /// Opens an accessor whose elements are elsewhere than in its buffer view: in `bytes`, without padding. Their
    /// number is that of the bytes.
    pub(super) fn open_with(
        document: &Document,
        buffers: &'a Buffers,
        accessor: Index,
        bytes: &'a [u8],
        pointer: &str,
    ) -> Outcome<Elements<'a>> {
        let json = json_of(document, accessor, pointer)?;
        let mut elements = Elements::without_bytes(json, accessor)?;
        let size = elements.size.all;
        elements.count = bytes.len() / size.max(1);
        elements.base = Some(Strided { bytes, stride: size });
        elements.open_sparse(json, buffers, &format!("/accessors/{}", accessor.0))
    }

    /// What an accessor says about its elements, without them.
    pub(super) fn describe(document: &Document, accessor: Index, pointer: &str) -> Outcome<Elements<'a>> {
        Elements::without_bytes(json_of(document, accessor, pointer)?, accessor)
    }

    fn without_bytes(json: &Accessor, accessor: Index) -> Outcome<Elements<'a>> {
        let at = format!("/accessors/{}", accessor.0);
        let component = component_of(json.component_type, &at)?;
        let kind = json.kind.as_deref().unwrap_or("");
        let Some((rows, columns)) = shape(kind) else {
            let expected = "SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4";
            return Err(Fault::at(format!("{at}/type"), format!("is \"{kind}\"; expected {expected}")));
        };
        let Some(count) = json.count else {
            return Err(Fault::at(format!("{at}/count"), "is missing; expected the number of elements"));
        };
        let count = usize::try_from(count.0).unwrap_or(usize::MAX);
        let size = Size::of_element(component.size(), rows, columns);
        Ok(Elements {
            count,
            width: rows * columns,
            component,
            normalized: json.normalized,
            accessor,
            size,
            base: None,
            sparse: None,
        })
    }

    /// Adds the sparse elements.
    fn open_sparse(mut self, json: &Accessor, buffers: &'a Buffers, at: &str) -> Outcome<Elements<'a>> {
        if let Some(sparse) = &json.sparse {
            let at = format!("{at}/sparse");
            let changed = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
            let index_type = component_of(Some(sparse.indices.component_type), &format!("{at}/indices"))?;
            if !matches!(index_type, Component::U8 | Component::U16 | Component::U32) {
                let message = "are not unsigned bytes, shorts or ints";
                return Err(Fault::at(format!("{at}/indices"), message));
            }
            let (indices, values) = (&sparse.indices, &sparse.values);
            let offset = indices.byte_offset.0;
            let differing = Differing {
                count: changed,
                indices: locate(
                    buffers,
                    indices.buffer_view,
                    offset,
                    changed,
                    Size::of(index_type.size()),
                    &at,
                )?,
                index_type,
                values: locate(buffers, values.buffer_view, values.byte_offset.0, changed, self.size, &at)?,
            };
            self.sparse = Some(differing);
        }
        Ok(self)
    }

    /// Number of sparse elements.
    pub(super) fn sparse_count(&self) -> usize {
        self.sparse.map_or(0, |sparse| sparse.count)
    }

    /// Refuses sparse indices that are out of range or not strictly increasing. Takes linear time, so it is
    /// called once per accessor; reading is memory-safe without it.
    pub(super) fn check_sparse(&self) -> Outcome<()> {
        let Some(sparse) = &self.sparse else { return Ok(()) };
        let mut before = None;
        for i in 0..sparse.count {
            let (index, count) = (sparse.index(i), self.count);
            if index >= count || before.is_some_and(|b| b >= index) {
                let message = format!("index {i} is {index}; expected increasing indices below {count}");
                return Err(Fault::at(format!("/accessors/{}/sparse/indices", self.accessor.0), message));
            }
            before = Some(index);
        }
        Ok(())
    }

    /// Requires one of these numbers of components per element.
    pub(super) fn with_width(self, widths: &[usize], what: &str) -> Outcome<Self> {
        if widths.contains(&self.width) {
            return Ok(self);
        }
        let expected = widths.iter().map(usize::to_string).collect::<Vec<_>>().join(" or ");
        let message = format!("has {} components per element; expected {expected} for {what}", self.width);
        Err(Fault::at(format!("/accessors/{}", self.accessor.0), message))
    }

    /// Requires this number of elements.
    pub(super) fn with_count(self, count: usize, what: &str) -> Outcome<Self> {
        if self.count == count {
            return Ok(self);
        }
        let message = format!("has {} elements; expected {count} for {what}", self.count);
        Err(Fault::at(format!("/accessors/{}", self.accessor.0), message))
    }

    #[inline]
    fn element(&self, i: usize) -> &'a [u8] {
        if let Some(sparse) = &self.sparse
            && let Some(found) = sparse.find(i)
        {
            return sparse.values.element(found);
        }
        self.base.map_or(&[], |base| base.element(i))
    }

    /// Component `k` of an element, decoded (§3.6.2.2); zero if it has no bytes. Not valid for matrices with
    /// padded columns (of bytes, or 3 × 3 of shorts).
    #[inline]
    fn number(&self, element: &[u8], k: usize) -> f32 {
        let scaled = |v: f32, max: f32| if self.normalized { (v / max).max(-1.0) } else { v };
        match self.component {
            Component::I8 => scaled(f32::from(bytes::<1>(element, k)[0] as i8), 127.0),
            Component::U8 => scaled(f32::from(bytes::<1>(element, k)[0]), 255.0),
            Component::I16 => scaled(f32::from(i16::from_le_bytes(bytes(element, 2 * k))), 32767.0),
            Component::U16 => scaled(f32::from(u16::from_le_bytes(bytes(element, 2 * k))), 65535.0),
            Component::U32 => u32::from_le_bytes(bytes(element, 4 * k)) as f32,
            Component::F32 => f32::from_le_bytes(bytes(element, 4 * k)),
        }
    }

    /// The first `N` components of element `i` as stored, integers without normalisation; missing ones are zero.
    pub(super) fn stored<const N: usize>(&self, i: usize) -> [f32; N] {
        Elements { normalized: false, ..*self }.get(i)
    }

    /// The first `N` components of element `i`; missing ones are zero.
    #[inline]
    pub(super) fn get<const N: usize>(&self, i: usize) -> [f32; N] {
        let element = self.element(i);
        let width = self.width;
        std::array::from_fn(|k| if k < width { self.number(element, k) } else { 0.0 })
    }

    /// Element `i` as an unsigned integer.
    #[inline]
    pub(super) fn index(&self, i: usize) -> u32 {
        whole(self.component, self.element(i))
    }

    /// The first four components of element `i` as unsigned integers.
    pub(super) fn indices(&self, i: usize) -> [u32; 4] {
        let (element, size) = (self.element(i), self.component.size());
        let component = self.component;
        std::array::from_fn(|k| element.get(k * size..).map_or(0, |e| whole(component, e)))
    }

    /// Whether the components are unsigned integers.
    pub(super) fn is_unsigned(&self) -> bool {
        matches!(self.component, Component::U8 | Component::U16 | Component::U32)
    }
}

fn json_of<'d>(document: &'d Document, accessor: Index, pointer: &str) -> Outcome<&'d Accessor> {
    let all = &document.accessors;
    all.get(accessor.index()).ok_or_else(|| Fault::dangling(pointer, "accessor", accessor.0, all.len()))
}

fn component_of(number: Option<Index>, at: &str) -> Outcome<Component> {
    let number = number.map_or(0, |n| n.0);
    Component::of(number).ok_or_else(|| {
        let expected = "5120, 5121, 5122, 5123, 5125 or 5126";
        Fault::at(format!("{at}/componentType"), format!("is {number}; expected {expected}"))
    })
}

/// Checks that `count` elements of a size lie in a buffer view from `offset`.
fn locate<'a>(
    buffers: &'a Buffers,
    view: Index,
    offset: u64,
    count: usize,
    Size { all: size, last }: Size,
    at: &str,
) -> Outcome<Strided<'a>> {
    let (bytes, stride) = buffers.view(view, at)?;
    let stride = stride.unwrap_or(size);
    if stride < size {
        let message =
            format!("elements of {size} bytes overlap: the stride of buffer view {} is {stride}", view.0);
        return Err(Fault::at(at, message));
    }
    let reach = match count.checked_sub(1) {
        Some(before) => (before as u64).checked_mul(stride as u64).and_then(|v| v.checked_add(last as u64)),
        None => Some(0),
    };
    let end = reach.and_then(|reach| reach.checked_add(offset));
    match end {
        Some(end) if end <= bytes.len() as u64 => {
            Ok(Strided { bytes: bytes.get(offset as usize..).unwrap_or(&[]), stride })
        }
        _ => {
            let end = end.map_or_else(|| "an address that overflows".to_owned(), |end| format!("byte {end}"));
            let message = format!(
                "{count} elements of {size} bytes reach {end}, but buffer view {} ends at {}",
                view.0,
                bytes.len()
            );
            Err(Fault::at(at, message))
        }
    }
}

#[cfg(test)]
mod tests;
