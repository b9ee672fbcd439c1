//! Accessors: typed elements in buffers, read one at a time.

use super::buffers::Buffers;
use super::entry::Entry;
use crate::scene::error::SceneError;

/// The most elements of an accessor that has no buffer behind it (all zeros, but for its sparse elements).
const ZEROS_LIMIT: usize = 1 << 24;

#[derive(Clone, Copy, PartialEq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn read(entry: &Entry<'_>) -> Result<Self, SceneError> {
        Ok(match entry.required_integer("componentType")? {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            other => return Err(entry.error(format!("there is no componentType {other}"), "export the scene again")),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number in the first bytes, and the largest that this type can hold.
    fn decode(self, bytes: &[u8]) -> (f64, f64) {
        match (self, bytes) {
            (Self::I8, [a, ..]) => (f64::from(a.cast_signed()), f64::from(i8::MAX)),
            (Self::U8, [a, ..]) => (f64::from(*a), f64::from(u8::MAX)),
            (Self::I16, [a, b, ..]) => (f64::from(i16::from_le_bytes([*a, *b])), f64::from(i16::MAX)),
            (Self::U16, [a, b, ..]) => (f64::from(u16::from_le_bytes([*a, *b])), f64::from(u16::MAX)),
            (Self::U32, [a, b, c, d, ..]) => (f64::from(u32::from_le_bytes([*a, *b, *c, *d])), f64::from(u32::MAX)),
            (Self::F32, [a, b, c, d, ..]) => (f64::from(f32::from_le_bytes([*a, *b, *c, *d])), 1.0),
            _ => (0.0, 1.0),
        }
    }
}

/// Elements at equal distances; all of them lie inside of the bytes.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Elements<'a> {
    /// `count` elements of `size` bytes in the view that `entry` refers to.
    fn open(buffers: &'a Buffers, entry: &Entry<'_>, size: usize, count: usize) -> Result<Option<Self>, SceneError> {
        let Some((_, view)) = entry.reference("bufferView", "bufferViews")? else { return Ok(None) };
        let stride = view.integer("byteStride")?.unwrap_or(size);
        if stride < size || stride > 252.max(size) {
            let problem = format!("a byteStride of {stride} does not fit elements of {size} bytes");
            return Err(view.error(problem, "export the scene again"));
        }
        let bytes = buffers.view(&view)?;
        let offset = entry.integer("byteOffset")?.unwrap_or(0);
        let needed = count.saturating_sub(1).checked_mul(stride).and_then(|span| span.checked_add(size));
        let inside = bytes.get(offset..).filter(|rest| needed.is_some_and(|needed| needed <= rest.len()));
        let Some(bytes) = inside else {
            let problem =
                format!("{count} elements from byte {offset} lead out of their view of {} bytes", bytes.len());
            return Err(entry.error(problem, "export the scene again"));
        };
        Ok(Some(Self { bytes, stride, size }))
    }

    fn get(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..][..self.size]
    }
}

/// A few elements that replace those of the buffer.
struct Sparse<'a> {
    /// Ascending.
    indices: Vec<u32>,
    values: Elements<'a>,
}

/// An accessor whose elements have all been found to lie inside of its buffers.
pub(super) struct Accessor<'a> {
    count: usize,
    component: Component,
    normalized: bool,
    elements: Option<Elements<'a>>,
    sparse: Option<Sparse<'a>>,
}

impl<'a> Accessor<'a> {
    /// Opens an accessor of the type `kind`, for example `VEC3`.
    ///
    /// # Errors
    /// When it is of another type, has no elements, or leads out of its buffers.
    pub(super) fn open(buffers: &'a Buffers, entry: &Entry<'_>, kind: &str) -> Result<Self, SceneError> {
        let given = entry.text("type")?.unwrap_or_default();
        if given != kind {
            return Err(entry.error(format!("the type is {given:?} where {kind} belongs"), "export the scene again"));
        }
        let width = kind.bytes().last().filter(u8::is_ascii_digit).map_or(1, |digit| usize::from(digit - b'0'));
        let component = Component::read(entry)?;
        let count = entry.required_integer("count")?;
        let size = width * component.size();
        let elements = Elements::open(buffers, entry, size, count)?;
        if count == 0 || u32::try_from(count).is_err() || elements.is_none() && count > ZEROS_LIMIT {
            return Err(entry.error(format!("the accessor has {count} elements"), "export the scene again"));
        }
        let sparse = match entry.child("sparse")? {
            Some(sparse) => Some(Sparse::open(buffers, &sparse, size, count)?),
            None => None,
        };
        Ok(Self { count, component, normalized: entry.flag("normalized")?, elements, sparse })
    }

    /// How many elements there are; at least one.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Whether the elements are whole numbers without a sign, as indices are.
    pub(super) fn holds_indices(&self) -> bool {
        matches!(self.component, Component::U8 | Component::U16 | Component::U32) && !self.normalized
    }

    /// The bytes of an element; none stands for zeros.
    fn element(&self, index: usize) -> &'a [u8] {
        if let Some(sparse) = &self.sparse
            && let Ok(position) = sparse.indices.binary_search(&(index as u32))
        {
            return sparse.values.get(position);
        }
        self.elements.as_ref().map_or(&[], |elements| elements.get(index))
    }

    /// Element `index` (below [`Accessor::count`]) as numbers; normalized integers as fractions.
    pub(super) fn vector<const N: usize>(&self, index: usize) -> [f64; N] {
        let bytes = self.element(index);
        let size = self.component.size();
        std::array::from_fn(|axis| {
            let (number, largest) = self.component.decode(bytes.get(axis * size..).unwrap_or_default());
            // The most negative integer would be a little below -1.
            if self.normalized { (number / largest).max(-1.0) } else { number }
        })
    }

    /// Element `index` (below [`Accessor::count`]) of an accessor that [`Accessor::holds_indices`].
    pub(super) fn index(&self, index: usize) -> u32 {
        self.component.decode(self.element(index)).0 as u32
    }
}

impl<'a> Sparse<'a> {
    fn open(buffers: &'a Buffers, entry: &Entry<'_>, size: usize, of: usize) -> Result<Self, SceneError> {
        let count = entry.required_integer("count")?;
        let (Some(places), Some(values)) = (entry.child("indices")?, entry.child("values")?) else {
            return Err(entry.error("sparse elements lack \"indices\" or \"values\"", "export the scene again"));
        };
        let component = Component::read(&places)?;
        let found = Elements::open(buffers, &places, component.size(), count)?;
        let (Some(found), Some(values)) = (found, Elements::open(buffers, &values, size, count)?) else {
            return Err(entry.error("sparse elements lack a \"bufferView\"", "export the scene again"));
        };
        let mut indices = Vec::new();
        for position in 0..count {
            let index = component.decode(found.get(position)).0;
            let ascends = indices.last().is_none_or(|last| f64::from(*last) < index);
            if !(ascends && index >= 0.0 && index < of as f64 && index.fract() == 0.0) {
                let problem = format!("index {position} of the sparse elements is {index}, of {of} elements");
                return Err(places.error(problem, "indices ascend and stay below the accessor's count"));
            }
            indices.push(index as u32);
        }
        Ok(Self { indices, values })
    }
}
