//! From crossing edges to triangles.
//!
//! Every lattice edge with a crossing is a polygon between the vertices of the
//! four cells around it, lying on the surface that causes the crossing. Across
//! an ambiguous face the polygon takes in the vertex on its arc as well.

use std::ops::Range;

use glam::UVec3;
use pulp::Simd;
use rustc_hash::FxHashMap;

use super::assembly::{Leftovers, Output};
use super::lattice::CELLS;
use super::loops;
use super::part::{BrickRecord, ComplexCell, FaceArcs, Part, PolygonCode};
use super::quads::{Corner, LANES, Quads, SurfaceSide};
use crate::pages::Room;
use crate::program::Surface;

/// A brick's place in the list of parts.
#[derive(Clone, Copy, Debug)]
struct BrickRef {
    part: u32,
    brick: u32,
}

/// Where the bricks and the vertices of parts are.
#[derive(Debug, Default)]
pub(super) struct Directory {
    /// First vertex of each part in the whole mesh.
    pub vertex_base: Vec<u32>,
    /// Vertices of all parts.
    pub vertices: usize,
    bricks: FxHashMap<UVec3, BrickRef>,
}

impl Directory {
    /// Enters further parts, in order.
    pub fn extend(&mut self, parts: &[Part]) {
        for part in parts {
            let p = self.vertex_base.len() as u32;
            self.vertex_base.push(self.vertices as u32);
            self.vertices += part.vertices.len();
            for (brick, record) in (0..).zip(&part.bricks) {
                let place = BrickRef { part: p, brick };
                self.bricks.insert(record.position, place);
            }
        }
    }

    /// The part and, in it, the brick at the given position, if there is one.
    pub fn brick_at(&self, position: UVec3) -> Option<(usize, usize)> {
        let found = self.bricks.get(&position)?;
        Some((found.part as usize, found.brick as usize))
    }
}

/// The parts so far, with the means to look across brick borders.
#[derive(Clone, Copy)]
pub(super) struct Stitcher<'a> {
    /// In order. Those that are stitched still have their vertices.
    pub parts: &'a [Part],
    pub directory: &'a Directory,
    pub surfaces: &'a [Surface],
    /// A triangle of less area counts as having none.
    pub least_area: f64,
}

/// Scratch memory of one worker.
#[derive(Default)]
pub(super) struct Scratch {
    table: Table,
    quads: Quads,
}

/// A run of polygons of one group, and the first of their triangles.
struct Run<'a> {
    codes: &'a [PolygonCode],
    surface: &'a Surface,
    group: u32,
    first: u32,
}

/// Marks a table entry as an index into the complex cells.
const COMPLEX: u32 = 1 << 31;

/// Entries of a [`Table`]. Tunes speed only.
const TABLE: usize = 4096;

/// Vertex lookup around one brick: cells from -1 to 14 along each axis.
struct Table {
    /// Per cell the place of its corner, or that of its complex cell, marked.
    cells: Vec<u32>,
    corners: Vec<Corner>,
    /// Complex cells, with the corner of their first vertex.
    complex: Vec<(ComplexCell, u32)>,
    /// Ambiguous faces, the corner of their first vertex, and whether their
    /// inside corners are joined.
    arcs: Vec<(u16, u32, bool)>,
}

impl Default for Table {
    fn default() -> Self {
        Self {
            cells: vec![0; TABLE],
            corners: Vec::new(),
            complex: Vec::new(),
            arcs: Vec::new(),
        }
    }
}

/// A neighbour's contribution: for each axis, this brick (0) or the one
/// before it (1), of which only the last layer counts.
fn shifted(sample: u16, before: [bool; 3]) -> Option<u16> {
    let mut index = 0;
    for (axis, &before) in before.iter().enumerate() {
        let along = sample >> (4 * axis) & 15;
        let place = if !before {
            along + 1
        } else if along == CELLS as u16 - 1 {
            0
        } else {
            return None;
        };
        if place > 15 {
            return None;
        }
        index |= place << (4 * axis);
    }
    Some(index)
}

impl Stitcher<'_> {
    fn fill_table(&self, position: UVec3, table: &mut Table) {
        table.corners.clear();
        table.complex.clear();
        table.arcs.clear();
        for octant in 0..8u32 {
            let offset = UVec3::new(octant & 1, octant >> 1 & 1, octant >> 2);
            if offset.cmpgt(position).any() {
                continue;
            }
            let Some((p, b)) = self.directory.brick_at(position - offset) else {
                continue;
            };
            let part = &self.parts[p];
            let brick = &part.bricks[b];
            let base = self.directory.vertex_base[p] + brick.vertices.start;
            if octant == 0 {
                table.add_own(part, brick, base);
            } else {
                table.add_neighbour(part, brick, base, offset.to_array().map(|o| o == 1));
            }
        }
        table.arcs.sort_unstable_by_key(|&(face, ..)| face);
    }

    /// Writes the vertices of a part and the triangles of all polygons that its
    /// bricks own.
    #[inline(always)]
    pub fn part<S: Simd>(
        &self,
        simd: S,
        part: usize,
        scratch: &mut Scratch,
        out: &mut Output<'_>,
    ) -> Leftovers {
        let part = &self.parts[part];
        let Scratch { table, quads } = scratch;
        let mut leftovers = Leftovers::default();
        out.positions.copy(&part.vertices);
        let mut polygons = 0;
        for brick in &part.bricks {
            self.fill_table(brick.position, table);
            for index in brick.groups.clone() {
                let group = &part.groups[index as usize];
                let end = polygons + group.count as usize;
                let run = Run {
                    codes: &part.polygons[polygons..end],
                    surface: &self.surfaces[group.surface as usize],
                    group: index,
                    first: 2 * polygons as u32,
                };
                out.surfaces.fill(2 * run.codes.len(), group.entry);
                self.run(simd, &run, table, quads, &mut out.triangles, &mut leftovers);
                polygons = end;
            }
        }
        leftovers
    }

    /// Triangulates polygons of one group, many at a time.
    #[inline(always)]
    fn run<S: Simd>(
        &self,
        simd: S,
        run: &Run<'_>,
        table: &Table,
        quads: &mut Quads,
        out: &mut Room<'_, [u32; 3]>,
        leftovers: &mut Leftovers,
    ) {
        for (chunk, codes) in run.codes.chunks(LANES).enumerate() {
            let mut fans = 0u32;
            for (lane, &code) in codes.iter().enumerate() {
                let here = code.sample();
                let mut around =
                    AROUND[code.axis_and_side()].map(|offset| table.cells[(here + offset) % TABLE]);
                let [a, b, c, d] = around;
                if (a | b | c | d) & COMPLEX != 0 {
                    let Some(quad) = loops_around(code, table) else {
                        fans |= 1 << lane;
                        continue;
                    };
                    around = quad;
                }
                quads.set(lane, around.map(|corner| &table.corners[corner as usize]));
            }
            let reversed = codes[0].is_reversed();
            let side = SurfaceSide {
                surface: run.surface,
                reversed,
            };
            let any_bad = quads.judge(simd, side, self.least_area, codes.len());
            quads.turn();
            if fans == 0 && !any_bad {
                out.pairs(codes.len(), |lane| quads.triangles(lane));
                continue;
            }
            out.pairs(codes.len(), |lane| {
                let is_fan = fans >> lane & 1 == 1;
                if is_fan || quads.bad[lane] != 0 {
                    let first = run.first + 2 * (chunk * LANES + lane) as u32;
                    leftovers.bad.extend([first, first + 1]);
                }
                if !is_fan {
                    return quads.triangles(lane);
                }
                let fan = fan(codes[lane], table);
                let further = fan[2..].iter().map(|&triangle| (triangle, run.group));
                leftovers.further.extend(further);
                [fan[0], fan[1]]
            });
        }
    }
}

/// The table's entries around a lattice edge, from its sample, in the order
/// that makes the polygon face out of the solid: by axis and by whether the
/// edge starts inside. The table is shifted by one cell along each axis.
const AROUND: [[usize; 4]; 8] = {
    let mut around = [[0; 4]; 8];
    let mut index = 0;
    while index < 6 {
        let (b, c) = loops::next_axes(index / 2);
        let (step_b, step_c) = (1 << (4 * b), 1 << (4 * c));
        around[index] = if index % 2 == 1 {
            [
                0x111,
                0x111 - step_b,
                0x111 - step_b - step_c,
                0x111 - step_c,
            ]
        } else {
            [
                0x111,
                0x111 - step_c,
                0x111 - step_b - step_c,
                0x111 - step_b,
            ]
        };
        index += 1;
    }
    around
};

/// The corners around a polygon some of whose cells are complex; none where
/// there are five or more, one of them on an ambiguous face.
#[inline(never)]
fn loops_around(code: PolygonCode, table: &Table) -> Option<[u32; 4]> {
    let ([a, b, c, d], arcs) = corners_and_arcs(code, table);
    let quad = if code.starts_inside() {
        [a, b, c, d]
    } else {
        [a, d, c, b]
    };
    arcs.iter().all(Option::is_none).then_some(quad)
}

/// The corners in the four cells around an edge, and after each the one on
/// the face to the next cell, if that face is ambiguous.
fn corners_and_arcs(code: PolygonCode, table: &Table) -> ([u32; 4], [Option<u32>; 4]) {
    let axis = code.axis();
    let (b, c) = loops::next_axes(axis);
    let (step_b, step_c) = (1usize << (4 * b), 1usize << (4 * c));
    let here = code.sample() + 0x111;
    let cells = [here, here - step_b, here - step_b - step_c, here - step_c];
    // The edge's place in each cell.
    let edges = [4 * axis, 4 * axis + 1, 4 * axis + 3, 4 * axis + 2];
    // The face from each cell to the next: normal, lowest sample, and the
    // edge's place in its cyclic order.
    let faces = [
        (b, here, 3),
        (c, here - step_b, 2),
        (b, here - step_c, 1),
        (c, here, 0),
    ];
    let (mut corners, mut arcs) = ([0; 4], [None; 4]);
    for i in 0..4 {
        let entry = table.cells[cells[i]];
        corners[i] = if entry & COMPLEX == 0 {
            entry
        } else {
            let (cell, first) = &table.complex[(entry & !COMPLEX) as usize];
            first + cell.loops.of(edges[i]) as u32
        };
        let (normal, lowest, place) = faces[i];
        let face = (normal << 12 | lowest) as u16;
        if let Ok(found) = table.arcs.binary_search_by_key(&face, |&(face, ..)| face) {
            let (_, first, joined) = table.arcs[found];
            let first_inside = code.starts_inside() == (place == 0 || place == 3);
            let partner = loops::ambiguous_partner(first_inside, joined, 0);
            let on_first = place == 0 || place == partner;
            arcs[i] = Some(first + u32::from(!on_first));
        }
    }
    (corners, arcs)
}

/// The triangles of a polygon that takes in vertices on ambiguous faces: a fan
/// around one of those. None of its diagonals can join the same vertices as
/// another edge of the mesh.
#[inline(never)]
fn fan(code: PolygonCode, table: &Table) -> Vec<[u32; 3]> {
    let (cells, arcs) = corners_and_arcs(code, table);
    let mut corners = Vec::with_capacity(8);
    for (cell, arc) in cells.into_iter().zip(arcs) {
        corners.push(cell);
        corners.extend(arc);
    }
    // No face comes before the first one with an arc.
    let apex = arcs.iter().position(Option::is_some).map_or(0, |p| p + 1);
    corners.rotate_left(apex);
    let triangle = |pair: &[u32]| {
        let corners = if code.starts_inside() {
            [corners[0], pair[0], pair[1]]
        } else {
            [corners[0], pair[1], pair[0]]
        };
        corners.map(|corner| table.corners[corner as usize].vertex)
    };
    corners[1..].windows(2).map(triangle).collect()
}

impl Table {
    /// Adds all vertices of a brick itself; its first vertex is `base`.
    fn add_own(&mut self, part: &Part, brick: &BrickRecord, base: u32) {
        let range = |range: &Range<u32>| range.start as usize..range.end as usize;
        let vertices = (base..).zip(&part.vertices[range(&brick.vertices)]);
        let corners = vertices.map(|(vertex, &point)| Corner { point, vertex });
        self.corners.extend(corners);
        for (corner, &sample) in (0..).zip(&part.cells[range(&brick.cells)]) {
            self.cells[(usize::from(sample) + 0x111) % TABLE] = corner;
        }
        for cell in &part.complex[range(&brick.complex)] {
            self.add_complex(cell, usize::from(cell.sample) + 0x111, cell.vertex);
        }
        for arcs in &part.arcs[range(&brick.arcs)] {
            let face = (arcs.face & 0xf000) | ((arcs.face & 0xfff) + 0x111);
            self.arcs.push((face, arcs.vertex, arcs.joined));
        }
    }

    /// Adds what touches the brick of one that comes before it along the given
    /// axes; its first vertex is `base`.
    fn add_neighbour(&mut self, part: &Part, brick: &BrickRecord, base: u32, before: [bool; 3]) {
        let range = |range: &Range<u32>| range.start as usize..range.end as usize;
        // It lies in the last layer along each of the axes; one of them is at
        // hand.
        let axis = before.iter().position(|&before| before).unwrap_or(0);
        for border in &part.borders[range(&brick.borders[axis])] {
            if let Some(place) = shifted(border.sample, before) {
                self.cells[usize::from(place)] = self.corners.len() as u32;
                self.corners.push(Corner {
                    point: border.point,
                    vertex: base + u32::from(border.index),
                });
            }
        }
        let further = |vertex: u32, count: u32| {
            let first = brick.further_vertex(vertex);
            let points = &part.further_vertices[first..first + count as usize];
            let vertices = (base + vertex..).zip(points);
            vertices.map(|(vertex, &point)| Corner { point, vertex })
        };
        for cell in &part.complex[range(&brick.complex)] {
            if let Some(place) = shifted(cell.sample, before) {
                let first = self.corners.len() as u32;
                self.corners
                    .extend(further(cell.vertex, cell.loops.count.into()));
                self.add_complex(cell, usize::from(place), first);
            }
        }
        for arcs in &part.arcs[range(&brick.arcs)] {
            let FaceArcs {
                face,
                vertex,
                joined,
            } = *arcs;
            if let Some(place) = shifted(face & 0xfff, before) {
                let first = self.corners.len() as u32;
                self.corners.extend(further(vertex, 2));
                self.arcs.push((face & 0xf000 | place, first, joined));
            }
        }
    }

    fn add_complex(&mut self, cell: &ComplexCell, place: usize, first: u32) {
        self.cells[place % TABLE] = COMPLEX | self.complex.len() as u32;
        self.complex.push((*cell, first));
    }
}
