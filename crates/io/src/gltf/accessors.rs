//! Reading the accessors of a glTF document: typed views of its buffers.

use glam::{DVec3, DVec4};

use super::document::{Accessor, Document};
use super::read::{CUT_OFF, malformed};
use crate::Error;
use crate::contents::Contents;

/// A document with the data of its buffers.
pub(super) struct Loaded<'data> {
    pub document: Document,
    pub buffers: Vec<Contents<'data>>,
}

impl Loaded<'_> {
    /// An accessor of three coordinates an element.
    pub fn vectors(&self, accessor: usize, place: &str) -> Result<Vectors<'_>, Error> {
        let elements = self.elements(accessor, "VEC3", 3, place)?;
        Ok(Vectors {
            component: component_reader(elements.entry, place)?,
            elements,
        })
    }

    /// An accessor of four components an element.
    pub fn quadruples(&self, accessor: usize, place: &str) -> Result<Vec<DVec4>, Error> {
        let elements = self.elements(accessor, "VEC4", 4, place)?;
        let component = component_reader(elements.entry, place)?;
        let size = elements.size / 4;
        let all = (0..elements.count()).map(|index| {
            let bytes = elements.get(index);
            DVec4::from_array([0, 1, 2, 3].map(|i| component(&bytes[i * size..])))
        });
        Ok(all.collect())
    }

    /// An accessor of indices.
    pub fn indices(&self, accessor: usize, place: &str) -> Result<Indices<'_>, Error> {
        let elements = self.elements(accessor, "SCALAR", 1, place)?;
        match elements.entry.component_type {
            5121 | 5123 | 5125 => Ok(Indices::Listed(elements)),
            _ => Err(malformed(place, "its indices are no unsigned integers")),
        }
    }

    /// The bytes of each element of an accessor, all of them in range.
    fn elements(
        &self,
        accessor: usize,
        kind: &str,
        components: usize,
        place: &str,
    ) -> Result<Elements<'_>, Error> {
        let wrong = |problem: &str| malformed(format!("{place}, accessor {accessor}"), problem);
        let entry = self.document.accessors.get(accessor);
        let entry = entry.ok_or_else(|| wrong("there is no such accessor"))?;
        if entry.sparse.is_some() {
            return Err(wrong(
                "sparse accessors cannot be read; export without them",
            ));
        }
        if entry.kind != kind {
            return Err(wrong(&format!(
                "its type is {:?} instead of {kind}",
                entry.kind
            )));
        }
        let view = entry
            .buffer_view
            .and_then(|view| self.document.buffer_views.get(view));
        let view = view.ok_or_else(|| wrong("there is no such buffer view"))?;
        let size = component_size(entry.component_type) * components;
        if size == 0 {
            return Err(wrong("its component type is unknown"));
        }
        let stride = view.byte_stride.unwrap_or(size);
        if stride < size {
            return Err(wrong(
                "its elements overlap: the view's stride is too small",
            ));
        }
        let bytes = (|| {
            let view_end = view.byte_offset.checked_add(view.byte_length)?;
            let data = self
                .buffers
                .get(view.buffer)?
                .get(view.byte_offset..view_end)?;
            let data = data.get(entry.byte_offset..)?;
            match entry.count.checked_sub(1) {
                None => Some(&data[..0]),
                Some(before) => data.get(..stride.checked_mul(before)?.checked_add(size)?),
            }
        })();
        let bytes = bytes.ok_or_else(|| wrong(CUT_OFF))?;
        Ok(Elements {
            entry,
            bytes,
            stride,
            size,
        })
    }
}

/// The elements of an accessor, all of them in range.
pub(super) struct Elements<'a> {
    entry: &'a Accessor,
    bytes: &'a [u8],
    stride: usize,
    /// Bytes of an element.
    size: usize,
}

impl Elements<'_> {
    pub fn count(&self) -> usize {
        self.entry.count
    }

    #[inline]
    fn get(&self, index: usize) -> &[u8] {
        &self.bytes[index * self.stride..][..self.size]
    }
}

/// An accessor of three coordinates an element.
pub(super) struct Vectors<'a> {
    elements: Elements<'a>,
    component: fn(&[u8]) -> f64,
}

impl Vectors<'_> {
    pub fn count(&self) -> usize {
        self.elements.count()
    }

    #[inline]
    pub fn get(&self, index: usize) -> DVec3 {
        let bytes = self.elements.get(index);
        if let ([x, y, z], []) = bytes.as_chunks::<4>()
            && self.elements.entry.component_type == FLOAT
        {
            return DVec3::from_array([x, y, z].map(|c| f64::from(f32::from_le_bytes(*c))));
        }
        let size = self.elements.size / 3;
        DVec3::from_array([0, 1, 2].map(|i| (self.component)(&bytes[i * size..])))
    }
}

/// The indices of a primitive.
pub(super) enum Indices<'a> {
    Listed(Elements<'a>),
    /// 0, 1, 2, ...
    Counted(usize),
}

impl Indices<'_> {
    pub fn count(&self) -> usize {
        match self {
            Self::Listed(elements) => elements.count(),
            Self::Counted(count) => *count,
        }
    }

    #[inline]
    fn get(&self, index: usize) -> u32 {
        match self {
            Self::Listed(elements) => match *elements.get(index) {
                [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
                [a, b] => u32::from(u16::from_le_bytes([a, b])),
                [a] => u32::from(a),
                _ => u32::MAX,
            },
            Self::Counted(_) => index as u32,
        }
    }

    /// The corners of a triangle of a list, a strip or a fan.
    #[inline]
    pub fn corners(&self, mode: u32, triangle: usize) -> [u32; 3] {
        if let Self::Listed(Elements {
            bytes, stride: 4, ..
        }) = self
            && mode == LIST
            && let Some((&[a, b, c], _)) = bytes
                .get(12 * triangle..)
                .and_then(|rest| rest.as_chunks::<4>().0.split_first_chunk::<3>())
            && matches!(self, Self::Listed(elements) if elements.size == 4)
        {
            return [a, b, c].map(u32::from_le_bytes);
        }
        corners_of(mode, triangle).map(|index| self.get(index))
    }
}

/// The component type of single precision.
const FLOAT: u32 = 5126;

/// Bytes of a component type, 0 for an unknown one.
fn component_size(component_type: u32) -> usize {
    match component_type {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        5125 | FLOAT => 4,
        _ => 0,
    }
}

/// Reads a component of an accessor of floats (or of the integers that
/// KHR_mesh_quantization allows in their place).
fn component_reader(entry: &Accessor, place: &str) -> Result<fn(&[u8]) -> f64, Error> {
    Ok(match (entry.component_type, entry.normalized) {
        (FLOAT, _) => |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        (5120, false) => |b| f64::from(i8::from_le_bytes([b[0]])),
        (5121, false) => |b| f64::from(b[0]),
        (5122, false) => |b| f64::from(i16::from_le_bytes([b[0], b[1]])),
        (5123, false) => |b| f64::from(u16::from_le_bytes([b[0], b[1]])),
        (5120, true) => |b| (f64::from(i8::from_le_bytes([b[0]])) / 127.0).max(-1.0),
        (5121, true) => |b| f64::from(b[0]) / 255.0,
        (5122, true) => |b| (f64::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0).max(-1.0),
        (5123, true) => |b| f64::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0,
        _ => {
            return Err(malformed(
                place,
                "its coordinates have an unknown component type",
            ));
        }
    })
}

/// The mode of a list of triangles; the modes below are points and lines.
pub(super) const LIST: u32 = 4;

/// How many triangles so many indices make in a list, a strip (5) or a fan (6).
pub(super) const fn triangle_count(mode: u32, indices: usize) -> usize {
    match mode {
        5 | 6 => indices.saturating_sub(2),
        _ => indices / 3,
    }
}

/// Which of the indices are the corners of a triangle.
const fn corners_of(mode: u32, triangle: usize) -> [usize; 3] {
    let t = triangle;
    match mode {
        5 if t.is_multiple_of(2) => [t, t + 1, t + 2],
        5 => [t + 1, t, t + 2],
        6 => [0, t + 1, t + 2],
        _ => [3 * t, 3 * t + 1, 3 * t + 2],
    }
}
