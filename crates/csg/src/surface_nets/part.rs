//! What classification and placement leave behind for stitching: per brick
//! its cells, its vertices and the lattice edges that become polygons.

use std::mem;
use std::ops::Range;

use glam::{DVec3, UVec3};
use serde::{Deserialize, Serialize};

use super::lattice::CELLS;
use super::loops::Loops;

/// The output of one task: consecutive bricks, their lists concatenated.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// The number of its block's first brick.
    pub first: u64,
    pub bricks: Vec<BrickRecord>,
    /// Simple cells, by lowest sample; the i-th of a brick has its i-th vertex.
    pub cells: Vec<u16>,
    /// The vertices of the simple cells in the last layer along x, along y and
    /// along z, which the next bricks need.
    pub borders: Vec<BorderVertex>,
    /// Cells with several loops or an ambiguous face.
    pub complex: Vec<ComplexCell>,
    /// Vertices on ambiguous faces.
    pub arcs: Vec<FaceArcs>,
    /// Vertex positions in the local frame, until they are in the mesh.
    pub vertices: Vec<DVec3>,
    /// Of every brick those that are not in a simple cell, for the next bricks.
    pub further_vertices: Vec<DVec3>,
    /// Lattice edges that carry a polygon, packed, grouped by provenance.
    pub polygons: Vec<PolygonCode>,
    pub groups: Vec<PolygonGroup>,
    pub fallbacks: Vec<Fallback>,
    pub surface_cells: u64,
    pub bricks_sampled: u64,
    pub cells_pruned: u64,
}

impl Part {
    /// What was collected, in memory of just its size; but the vertices' memory
    /// is given away in exchange for that of `vertices`, of some earlier part.
    pub fn take(&mut self, mut vertices: Vec<DVec3>) -> Self {
        vertices.clear();
        let vertices = mem::replace(&mut self.vertices, vertices);
        Self {
            vertices,
            ..self.clone()
        }
    }

    /// Forgets everything, and keeps the memory.
    pub fn clear(&mut self) {
        self.first = 0;
        self.bricks.clear();
        self.cells.clear();
        self.borders.clear();
        self.complex.clear();
        self.arcs.clear();
        self.vertices.clear();
        self.further_vertices.clear();
        self.polygons.clear();
        self.groups.clear();
        self.fallbacks.clear();
        self.surface_cells = 0;
        self.bricks_sampled = 0;
        self.cells_pruned = 0;
    }

    /// A record of a brick whose lists start where the part's end now.
    pub fn open_brick(&self, position: UVec3) -> BrickRecord {
        let empty_at_end = |length: usize| length as u32..length as u32;
        BrickRecord {
            position,
            cells: empty_at_end(self.cells.len()),
            borders: [0..0, 0..0, 0..0],
            complex: empty_at_end(self.complex.len()),
            arcs: empty_at_end(self.arcs.len()),
            groups: empty_at_end(self.groups.len()),
            polygons: empty_at_end(self.polygons.len()),
            vertices: empty_at_end(self.vertices.len()),
            further_vertices: self.further_vertices.len() as u32,
        }
    }

    /// Adds the record of a brick all of whose lists are written.
    #[inline(always)]
    pub fn close_brick(&mut self, mut record: BrickRecord) {
        record.cells.end = self.cells.len() as u32;
        record.complex.end = self.complex.len() as u32;
        record.arcs.end = self.arcs.len() as u32;
        record.groups.end = self.groups.len() as u32;
        record.polygons.end = self.polygons.len() as u32;
        record.vertices.end = self.vertices.len() as u32;
        let cells = &self.cells[record.cells.start as usize..];
        let vertices = &self.vertices[record.vertices.start as usize..];
        self.further_vertices
            .extend_from_slice(&vertices[cells.len()..]);
        // Those in each last layer, without a branch for each.
        let mut last = [[0u16; MOST_IN_LAST_LAYER + 1]; 3];
        let mut counts = [0; 3];
        for (chunk, cells) in cells.chunks(64).enumerate() {
            let mut in_any = 0u64;
            for (i, &sample) in cells.iter().enumerate() {
                in_any |= u64::from(last_layers(sample) != 0) << i;
            }
            while in_any != 0 {
                let i = in_any.trailing_zeros() as usize;
                in_any &= in_any - 1;
                let layers = last_layers(cells[i]);
                for (axis, (last, count)) in last.iter_mut().zip(&mut counts).enumerate() {
                    last[*count] = (64 * chunk + i) as u16;
                    *count += usize::from(layers >> (4 * axis) & 1);
                }
            }
        }
        for ((range, last), count) in record.borders.iter_mut().zip(&last).zip(counts) {
            range.start = self.borders.len() as u32;
            let last = last[..count].iter().map(|&index| BorderVertex {
                point: vertices[usize::from(index)],
                sample: cells[usize::from(index)],
                index,
            });
            self.borders.extend(last);
            range.end = self.borders.len() as u32;
        }
        self.surface_cells += record.cells.len() as u64 + record.complex.len() as u64;
        self.bricks.push(record);
    }
}

/// The vertex of a simple cell in a brick's last layers.
#[derive(Clone, Copy, Debug)]
pub(super) struct BorderVertex {
    pub point: DVec3,
    /// The cell's lowest sample.
    pub sample: u16,
    /// The vertex, counted from the brick's first.
    pub index: u16,
}

/// The cells of a brick that are in the last layer along one axis.
const MOST_IN_LAST_LAYER: usize = CELLS.pow(2);

/// Bit 4a for every axis a along which a cell is in the last layer.
#[inline(always)]
fn last_layers(sample: u16) -> u16 {
    // Its place along an axis is 14: 15 after one more, all bits set.
    let next = sample + 0x111;
    let pairs = next & next >> 1;
    pairs & pairs >> 2 & 0x111
}

/// One brick's share of a [`Part`].
#[derive(Clone, Debug)]
pub(super) struct BrickRecord {
    pub position: UVec3,
    pub cells: Range<u32>,
    pub borders: [Range<u32>; 3],
    pub complex: Range<u32>,
    pub arcs: Range<u32>,
    pub groups: Range<u32>,
    pub polygons: Range<u32>,
    pub vertices: Range<u32>,
    /// The first of those that are not in a simple cell.
    pub further_vertices: u32,
}

impl BrickRecord {
    /// Where a vertex, counted from the brick's first, that is not in a simple
    /// cell is among the part's further ones.
    pub fn further_vertex(&self, vertex: u32) -> usize {
        (self.further_vertices + vertex) as usize - self.cells.len()
    }
}

/// A cell that is more than one loop without ambiguous faces.
#[derive(Clone, Copy, Debug)]
pub(super) struct ComplexCell {
    pub sample: u16,
    pub loops: Loops,
    /// Its first vertex, counted from the brick's first; one a loop.
    pub vertex: u32,
}

/// The two vertices on the arcs across an ambiguous face.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceArcs {
    /// Normal axis << 12 | lowest sample.
    pub face: u16,
    /// The first vertex, counted from the brick's first, and the next: on the
    /// arc through edge 0 of the face's cyclic order, and on the other.
    pub vertex: u32,
    /// Whether the face's inside corners are joined.
    pub joined: bool,
}

/// A lattice edge that the solid's boundary crosses, owned by a brick: whether
/// the surface's gradient points into the solid, the edge's axis, whether its
/// lower sample is inside the solid, and that sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct PolygonCode(u16);

impl PolygonCode {
    #[inline(always)]
    pub fn new(axis: usize, starts_inside: bool, surface_starts_inside: bool, sample: u16) -> Self {
        Self(Self::pack(
            axis,
            starts_inside.into(),
            surface_starts_inside.into(),
            sample,
        ))
    }

    /// The same in bits, for many at a time.
    #[inline(always)]
    pub fn pack(axis: usize, starts_inside: u16, surface_starts_inside: u16, sample: u16) -> u16 {
        let reversed = starts_inside ^ surface_starts_inside;
        (reversed << 3 | (axis as u16) << 1 | starts_inside) << 12 | sample
    }

    /// From what [`Self::pack`] returned.
    #[inline(always)]
    pub fn unpack(bits: u16) -> Self {
        Self(bits)
    }

    #[inline(always)]
    pub fn axis(self) -> usize {
        (self.0 >> 13 & 3) as usize
    }

    /// 2 axis + whether the lower sample is inside.
    #[inline(always)]
    pub fn axis_and_side(self) -> usize {
        (self.0 >> 12 & 7) as usize
    }

    #[inline(always)]
    pub fn is_reversed(self) -> bool {
        self.0 >> 15 == 1
    }

    #[inline(always)]
    pub fn starts_inside(self) -> bool {
        self.0 >> 12 & 1 == 1
    }

    #[inline(always)]
    pub fn sample(self) -> usize {
        (self.0 & 0xfff) as usize
    }
}

/// A run of polygons that lie on one surface, come from one primitive and face
/// one way.
#[derive(Clone, Copy, Debug)]
pub(super) struct PolygonGroup {
    pub surface: u32,
    pub origin: u32,
    /// Whether the surface's gradient points into the solid there.
    pub reversed: bool,
    pub count: u32,
    /// The entry in the mesh's table of surfaces, once that is made.
    pub entry: u32,
}

/// Where the mesher had to make do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fallback {
    pub kind: FallbackKind,
    /// In the local frame.
    pub place: DVec3,
}

/// Why the mesher had to make do at some place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum FallbackKind {
    NoCommonPoint,
    HiddenFeature,
    SeveralCrossings,
    Unseen,
    Degenerate,
}

impl FallbackKind {
    pub const fn describe(self) -> &'static str {
        match self {
            Self::NoCommonPoint => {
                "surfaces of a vertex without a common point near its cell: it lies on some only"
            }
            Self::HiddenFeature => {
                "feature that no sample saw: the solid does not change across a vertex's surfaces"
            }
            Self::SeveralCrossings => {
                "lattice edge that the boundary crosses several times: thinner than a cell"
            }
            Self::Unseen => "part of the boundary that no sample saw: thinner than a cell",
            Self::Degenerate => "triangle without area or folded against its surface",
        }
    }
}
