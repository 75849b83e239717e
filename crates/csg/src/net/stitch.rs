//! From crossing edges to triangles.
//!
//! Every lattice edge with a crossing is a polygon between the vertices of the
//! four cells around it, lying on the surface that causes the crossing. Across
//! an ambiguous face the polygon takes in the vertex on its arc as well.

use glam::{DVec3, UVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::lattice::CELLS;
use super::loops;
use super::part::{BrickRecord, ComplexCell, FaceArcs, Part, PolygonCode};
use super::quads::{LANES, Quads};
use crate::pages;
use crate::program::Surface;

/// A brick's place in the list of parts.
#[derive(Clone, Copy, Debug)]
struct BrickRef {
    part: u32,
    brick: u32,
}

/// All parts, with the means to look across brick borders.
pub(super) struct Stitcher<'a> {
    parts: &'a [Part],
    /// First vertex of each part in the whole mesh.
    vertex_base: Vec<u32>,
    bricks: FxHashMap<UVec3, BrickRef>,
    positions: &'a [DVec3],
    surfaces: &'a [Surface],
    least_area: f64,
}

/// Where the triangles of one part go: two for every polygon, in order.
pub(super) struct Output<'a> {
    pub triangles: &'a mut [[u32; 3]],
    /// The triangles' entries in the mesh's table of surfaces.
    pub surfaces: &'a mut [u32],
}

/// What a part has beside two triangles for every polygon.
#[derive(Debug, Default)]
pub(super) struct Leftovers {
    /// Triangles, counted from the part's first, that may have no area or be
    /// folded over.
    pub bad: Vec<u32>,
    /// The further triangles of polygons with more than four corners, each
    /// with its group's place in the part. They may be bad, too.
    pub further: Vec<([u32; 3], u32)>,
}

/// The triangles of a whole mesh.
#[derive(Debug)]
pub(super) struct Stitched {
    /// Two for every polygon, in order, then the further ones.
    pub triangles: Vec<[u32; 3]>,
    /// The triangles' entries in the mesh's table of surfaces.
    pub surfaces: Vec<u32>,
    /// Triangles that may have no area or be folded over.
    pub bad: Vec<u32>,
    /// Part and group of the further triangles.
    pub further: Vec<(usize, u32)>,
}

/// The triangles of all parts, from `stitch`, which does one of them.
pub(super) fn stitch_all(
    parts: &[Part],
    stitch: impl Fn(usize, &mut Output<'_>) -> Leftovers + Sync,
) -> Stitched {
    let polygons: usize = parts.iter().map(|part| part.polygons.len()).sum();
    // Every ambiguous face is a corner more for four polygons.
    let arcs: usize = parts.iter().map(|part| part.arcs.len()).sum();
    let mut triangles: Vec<[u32; 3]> = pages::zeroed(2 * polygons + 4 * arcs);
    let mut surfaces: Vec<u32> = pages::zeroed(2 * polygons + 4 * arcs);
    let mut outputs = Vec::with_capacity(parts.len());
    let (mut rest, mut rest_surfaces) = (triangles.as_mut_slice(), surfaces.as_mut_slice());
    for part in parts {
        let (triangles, surfaces);
        (triangles, rest) = rest.split_at_mut(2 * part.polygons.len());
        (surfaces, rest_surfaces) = rest_surfaces.split_at_mut(2 * part.polygons.len());
        outputs.push(Output {
            triangles,
            surfaces,
        });
    }
    let leftovers: Vec<Leftovers> = outputs
        .into_par_iter()
        .enumerate()
        .map(|(part, mut out)| stitch(part, &mut out))
        .collect();
    let (mut bad, mut further) = (Vec::new(), Vec::new());
    let (mut first, mut end) = (0, 2 * polygons);
    for (p, (part, leftovers)) in parts.iter().zip(leftovers).enumerate() {
        bad.extend(leftovers.bad.iter().map(|&triangle| first + triangle));
        first += 2 * part.polygons.len() as u32;
        for (triangle, group) in leftovers.further {
            triangles[end] = triangle;
            surfaces[end] = part.groups[group as usize].entry;
            further.push((p, group));
            end += 1;
        }
    }
    bad.extend(2 * polygons as u32..end as u32);
    triangles.truncate(end);
    surfaces.truncate(end);
    Stitched {
        triangles,
        surfaces,
        bad,
        further,
    }
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

/// Entries of a [`Table`].
const TABLE: usize = 4096;

/// Vertex lookup around one brick: cells from -1 to 14 along each axis.
struct Table {
    cells: Vec<u32>,
    complex: Vec<(ComplexCell, u32)>,
    arcs: Vec<(u16, u32, bool)>,
}

impl Default for Table {
    fn default() -> Self {
        Self {
            cells: vec![0; TABLE],
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

impl<'a> Stitcher<'a> {
    /// A triangle of less area than `least_area` counts as having none.
    pub fn new(
        parts: &'a [Part],
        positions: &'a [DVec3],
        surfaces: &'a [Surface],
        least_area: f64,
    ) -> Self {
        let mut vertex_base = Vec::with_capacity(parts.len());
        let mut bricks = FxHashMap::default();
        let mut base = 0;
        for (p, part) in parts.iter().enumerate() {
            vertex_base.push(base);
            base += part.vertices.len() as u32;
            for (b, brick) in part.bricks.iter().enumerate() {
                let place = BrickRef {
                    part: p as u32,
                    brick: b as u32,
                };
                bricks.insert(brick.position, place);
            }
        }
        Self {
            parts,
            vertex_base,
            bricks,
            positions,
            surfaces,
            least_area,
        }
    }

    /// All parts, in order.
    pub fn parts(&self) -> &'a [Part] {
        self.parts
    }

    /// First vertex of each part in the whole mesh.
    pub fn vertex_base(&self) -> &[u32] {
        &self.vertex_base
    }

    /// The part and, in it, the brick at the given position, if there is one.
    pub fn brick_at(&self, position: UVec3) -> Option<(usize, usize)> {
        let found = self.bricks.get(&position)?;
        Some((found.part as usize, found.brick as usize))
    }

    fn fill_table(&self, position: UVec3, table: &mut Table) {
        table.complex.clear();
        table.arcs.clear();
        for octant in 0..8u32 {
            let offset = UVec3::new(octant & 1, octant >> 1 & 1, octant >> 2);
            if offset.cmpgt(position).any() {
                continue;
            }
            let Some(found) = self.bricks.get(&(position - offset)) else {
                continue;
            };
            let part = &self.parts[found.part as usize];
            let brick = &part.bricks[found.brick as usize];
            let base = self.vertex_base[found.part as usize] + brick.vertices;
            add_brick(part, brick, base, offset.to_array().map(|o| o == 1), table);
        }
        table.arcs.sort_unstable_by_key(|&(face, ..)| face);
    }

    /// The triangles of all polygons that the bricks of `part` own.
    #[inline(always)]
    pub fn part(&self, part: usize, scratch: &mut Scratch, out: &mut Output<'_>) -> Leftovers {
        let part = &self.parts[part];
        let Scratch { table, quads } = scratch;
        let mut leftovers = Leftovers::default();
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
                let triangles = 2 * polygons..2 * end;
                out.surfaces[triangles.clone()].fill(group.entry);
                let triangles = &mut out.triangles[triangles];
                self.run(&run, table, quads, triangles, &mut leftovers);
                polygons = end;
            }
        }
        leftovers
    }

    /// Triangulates polygons of one group, many at a time.
    #[inline(always)]
    fn run(
        &self,
        run: &Run<'_>,
        table: &Table,
        quads: &mut Quads,
        triangles: &mut [[u32; 3]],
        leftovers: &mut Leftovers,
    ) {
        let chunks = run.codes.chunks(LANES).zip(triangles.chunks_mut(2 * LANES));
        for (chunk, (codes, triangles)) in chunks.enumerate() {
            let mut fans = 0u32;
            for (lane, &code) in codes.iter().enumerate() {
                let here = code.sample();
                let mut corners =
                    AROUND[code.axis_and_side()].map(|offset| table.cells[(here + offset) % TABLE]);
                let [a, b, c, d] = corners;
                if (a | b | c | d) & COMPLEX != 0 {
                    match loops_around(code, table) {
                        Around::Quad(quad) => corners = quad,
                        Around::Fan => {
                            fans |= 1 << lane;
                            continue;
                        }
                    }
                }
                quads.set(lane, corners, self.positions);
            }
            let reversed = codes[0].is_reversed();
            let any_bad = quads.judge(run.surface, reversed, self.least_area, codes.len());
            quads.cut(triangles);
            if fans == 0 && !any_bad {
                continue;
            }
            for (lane, &code) in codes.iter().enumerate() {
                let is_fan = fans >> lane & 1 == 1;
                if is_fan {
                    let fan = fan(code, table);
                    triangles[2 * lane..2 * lane + 2].copy_from_slice(&fan[..2]);
                    let further = fan[2..].iter().map(|&triangle| (triangle, run.group));
                    leftovers.further.extend(further);
                }
                if is_fan || quads.bad[lane] != 0 {
                    let first = run.first + 2 * (chunk * LANES + lane) as u32;
                    leftovers.bad.extend([first, first + 1]);
                }
            }
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

/// The vertices around a polygon some of whose cells are complex.
enum Around {
    Quad([u32; 4]),
    /// Five or more, one of them on an ambiguous face.
    Fan,
}

/// Which loop each corner of a polygon is, unless it takes in vertices on
/// ambiguous faces.
#[inline(never)]
fn loops_around(code: PolygonCode, table: &Table) -> Around {
    let (corners, arcs) = corners_and_arcs(code, table);
    if arcs.iter().any(Option::is_some) {
        return Around::Fan;
    }
    let [a, b, c, d] = corners;
    Around::Quad(if code.starts_inside() {
        [a, b, c, d]
    } else {
        [a, d, c, b]
    })
}

/// The vertices of the four cells around an edge, and after each the one on
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
            let (cell, vertex) = &table.complex[(entry & !COMPLEX) as usize];
            vertex + cell.loops.of(edges[i]) as u32
        };
        let (normal, lowest, place) = faces[i];
        let face = (normal << 12 | lowest) as u16;
        if let Ok(found) = table.arcs.binary_search_by_key(&face, |&(face, ..)| face) {
            let (_, vertex, joined) = table.arcs[found];
            let first_inside = code.starts_inside() == (place == 0 || place == 3);
            let partner = loops::ambiguous_partner(first_inside, joined, 0);
            let on_first = place == 0 || place == partner;
            arcs[i] = Some(vertex + u32::from(!on_first));
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
        if code.starts_inside() {
            [corners[0], pair[0], pair[1]]
        } else {
            [corners[0], pair[1], pair[0]]
        }
    };
    corners[1..].windows(2).map(triangle).collect()
}

fn add_brick(part: &Part, brick: &BrickRecord, base: u32, before: [bool; 3], table: &mut Table) {
    let cells = &part.cells[brick.cells.start as usize..brick.cells.end as usize];
    if before == [false; 3] {
        for (i, &sample) in cells.iter().enumerate() {
            table.cells[usize::from(sample) + 0x111] = base + i as u32;
        }
    } else if let Some(axis) = before.iter().position(|&before| before) {
        // Whatever touches this brick lies in the last layer along each axis
        // on which the neighbour comes before it; one of them is at hand.
        let border = &brick.borders[axis];
        for &(sample, i) in &part.borders[border.start as usize..border.end as usize] {
            if let Some(place) = shifted(sample, before) {
                table.cells[usize::from(place)] = base + u32::from(i);
            }
        }
    }
    for cell in &part.complex[brick.complex.start as usize..brick.complex.end as usize] {
        if let Some(place) = shifted(cell.sample, before) {
            table.cells[usize::from(place)] = COMPLEX | table.complex.len() as u32;
            table.complex.push((*cell, base + cell.vertex));
        }
    }
    for arcs in &part.arcs[brick.arcs.start as usize..brick.arcs.end as usize] {
        let FaceArcs {
            face,
            vertex,
            joined,
        } = *arcs;
        if let Some(place) = shifted(face & 0xfff, before) {
            table
                .arcs
                .push((face & 0xf000 | place, base + vertex, joined));
        }
    }
}
