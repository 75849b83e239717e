//! From crossing edges to triangles.
//!
//! Every lattice edge with a crossing is a polygon between the vertices of the
//! four cells around it, lying on the surface that causes the crossing. Across
//! an ambiguous face the polygon takes in the vertex on its arc as well.

use glam::{DVec3, UVec3};
use rustc_hash::FxHashMap;

use super::lattice::CELLS;
use super::loops;
use super::part::{BrickRecord, ComplexCell, FaceArcs, Part, PolygonCode};
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

/// The triangles of one part.
#[derive(Debug, Default)]
pub(super) struct Stitched {
    pub triangles: Vec<[u32; 3]>,
    /// Triangles, among these, that have no area or are folded over.
    pub bad: Vec<u32>,
    /// Triangles of each polygon group, in order.
    pub group_triangles: Vec<u32>,
}

/// Marks a table entry as an index into the complex cells.
const COMPLEX: u32 = 1 << 31;

/// Entries of a [`Table`].
const TABLE: usize = 4096;

/// Vertex lookup around one brick: cells from -1 to 14 along each axis.
pub(super) struct Table {
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
    pub fn part(&self, part: usize, table: &mut Table) -> Stitched {
        let part = &self.parts[part];
        let mut out = Stitched {
            triangles: Vec::with_capacity(2 * part.polygons.len()),
            ..Stitched::default()
        };
        for brick in &part.bricks {
            self.fill_table(brick.position, table);
            let mut polygons = brick.polygons.start as usize;
            for group in &part.groups[brick.groups.start as usize..brick.groups.end as usize] {
                let surface = &self.surfaces[group.surface as usize];
                let before = out.triangles.len();
                let end = polygons + group.count as usize;
                self.polygons(&part.polygons[polygons..end], surface, table, &mut out);
                polygons = end;
                let count = (out.triangles.len() - before) as u32;
                out.group_triangles.push(count);
            }
        }
        out
    }

    /// Triangulates polygons of one surface, many at a time.
    #[inline(always)]
    fn polygons(
        &self,
        codes: &[PolygonCode],
        surface: &Surface,
        table: &Table,
        out: &mut Stitched,
    ) {
        let mut quads = Quads::default();
        for codes in codes.chunks(LANES) {
            let mut corners = [[0u32; 4]; LANES];
            let mut complex = 0u32;
            for (lane, &code) in codes.iter().enumerate() {
                let (b, c) = loops::next_axes(code.axis());
                let (step_b, step_c) = (1usize << (4 * b), 1usize << (4 * c));
                // Indices into the table are shifted by one cell along each
                // axis.
                let here = code.sample() + 0x111;
                let cells = [here, here - step_b, here - step_b - step_c, here - step_c];
                let mut quad = [0; 4];
                for (vertex, cell) in quad.iter_mut().zip(cells) {
                    *vertex = table.cells[cell % TABLE];
                }
                if (quad[0] | quad[1] | quad[2] | quad[3]) & COMPLEX != 0 {
                    complex |= 1 << lane;
                    continue;
                }
                if !code.starts_inside() {
                    quad.swap(1, 3);
                }
                corners[lane] = quad;
                let p = quad.map(|v| self.positions[v as usize]);
                quads.set(lane, p, code.is_reversed());
            }
            let (even, bad) = quads.choose_diagonals(surface, self.least_area, codes.len());
            if complex == 0 && bad == 0 && codes.len() == LANES {
                let mut triangles = [[0; 3]; 2 * LANES];
                for (lane, corners) in corners.into_iter().enumerate() {
                    let [first, second] = split(corners, even >> lane & 1 == 1);
                    triangles[2 * lane] = first;
                    triangles[2 * lane + 1] = second;
                }
                out.triangles.extend_from_slice(&triangles);
                continue;
            }
            for (lane, &code) in codes.iter().enumerate() {
                if complex >> lane & 1 == 1 {
                    self.complex_polygon(code, surface, table, out);
                    continue;
                }
                out.add(
                    split(corners[lane], even >> lane & 1 == 1),
                    bad >> lane & 1 == 1,
                );
            }
        }
    }

    /// A polygon with a complex cell: looks up which loop each corner is, and
    /// takes in the vertices on ambiguous faces.
    #[inline(never)]
    fn complex_polygon(
        &self,
        code: PolygonCode,
        surface: &Surface,
        table: &Table,
        out: &mut Stitched,
    ) {
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
        let mut corners = Vec::with_capacity(8);
        let mut first_arc = None;
        for i in 0..4 {
            let entry = table.cells[cells[i]];
            corners.push(if entry & COMPLEX == 0 {
                entry
            } else {
                let (cell, vertex) = &table.complex[(entry & !COMPLEX) as usize];
                vertex + loops::trace(cell.corners, cell.joined).of(edges[i]) as u32
            });
            let (normal, lowest, place) = faces[i];
            let face = (normal << 12 | lowest) as u16;
            if let Ok(found) = table.arcs.binary_search_by_key(&face, |&(face, ..)| face) {
                let (_, vertex, joined) = table.arcs[found];
                let first_inside = code.starts_inside() == (place == 0 || place == 3);
                let partner = loops::ambiguous_partner(first_inside, joined, 0);
                let on_first = place == 0 || place == partner;
                first_arc.get_or_insert(corners.len());
                corners.push(vertex + u32::from(!on_first));
            }
        }
        let Some(apex) = first_arc else {
            let mut quad = [corners[0], corners[1], corners[2], corners[3]];
            if !code.starts_inside() {
                quad.swap(1, 3);
            }
            self.quad(quad, surface, code.is_reversed(), out);
            return;
        };
        // A fan around a vertex on a face: none of its diagonals can join the
        // same vertices as another edge of the mesh.
        corners.rotate_left(apex);
        for pair in corners[1..].windows(2) {
            let triangle = if code.starts_inside() {
                [corners[0], pair[0], pair[1]]
            } else {
                [corners[0], pair[1], pair[0]]
            };
            out.add([triangle], true);
        }
    }

    /// One quad on its own.
    fn quad(&self, corners: [u32; 4], surface: &Surface, reversed: bool, out: &mut Stitched) {
        let mut quads = Quads::default();
        let points = corners.map(|v| self.positions[v as usize]);
        quads.set(0, points, reversed);
        let (even, bad) = quads.choose_diagonals(surface, self.least_area, 1);
        out.add(split(corners, even & 1 == 1), bad & 1 == 1);
    }
}

impl Stitched {
    /// Adds triangles; if one of them may be bad, all are looked at later.
    fn add(&mut self, triangles: impl IntoIterator<Item = [u32; 3]>, may_be_bad: bool) {
        let before = self.triangles.len() as u32;
        self.triangles.extend(triangles);
        if may_be_bad {
            self.bad.extend(before..self.triangles.len() as u32);
        }
    }
}

/// The two triangles of a quad, cut along its even diagonal (0, 2) or its odd
/// one (1, 3).
#[inline(always)]
fn split([a, b, c, d]: [u32; 4], even: bool) -> [[u32; 3]; 2] {
    if even {
        [[a, b, c], [a, c, d]]
    } else {
        [[b, c, d], [b, d, a]]
    }
}

/// Quads handled together: so many that what is written coordinate by
/// coordinate has left the store buffer when it is read in whole vectors.
const LANES: usize = 32;

/// The corners of many quads, coordinate by coordinate.
struct Quads {
    /// Corner, coordinate, lane.
    corners: [[[f64; LANES]; 3]; 4],
    /// 1 where the surface's gradient points out of the solid, else -1.
    outward: [f64; LANES],
}

impl Default for Quads {
    fn default() -> Self {
        Self {
            corners: [[[0.0; LANES]; 3]; 4],
            outward: [0.0; LANES],
        }
    }
}

impl Quads {
    #[inline(always)]
    fn set(&mut self, lane: usize, points: [DVec3; 4], reversed: bool) {
        for (corner, point) in self.corners.iter_mut().zip(points) {
            corner[0][lane] = point.x;
            corner[1][lane] = point.y;
            corner[2][lane] = point.z;
        }
        self.outward[lane] = if reversed { -1.0 } else { 1.0 };
    }

    /// For every quad a bit whether to cut it along its even diagonal, and one
    /// whether a triangle is all the same folded over, or smaller than
    /// `least_area`.
    ///
    /// The diagonal whose midpoint is nearer to the surface wins, unless only
    /// the other leaves no fold; on a plane the one whose smaller triangle is
    /// larger.
    #[inline(always)]
    fn choose_diagonals(&self, surface: &Surface, least_area: f64, count: usize) -> (u32, u32) {
        let [p, q, r, s] = &self.corners;
        let anchor = surface.anchor();
        let [xx, yy, zz, xy, yz, zx] = surface.quadratic;
        let (xy, yz, zx) = (0.5 * xy, 0.5 * yz, 0.5 * zx);
        let g = surface.linear;
        let is_plane = surface.is_plane();
        let (mut even_bits, mut bad_bits) = ([0u32; LANES], [0u32; LANES]);
        // Whole vectors of whatever width.
        for lane in 0..count.next_multiple_of(8).min(LANES) {
            let at =
                |corner: &[[f64; LANES]; 3]| (corner[0][lane], corner[1][lane], corner[2][lane]);
            let (px, py, pz) = at(p);
            let (qx, qy, qz) = at(q);
            let (rx, ry, rz) = at(r);
            let (sx, sy, sz) = at(s);
            // f and half its gradient's quadratic part, about the anchor.
            let half_gradient = |x: f64, y: f64, z: f64| {
                (
                    xx * x + (xy * y + zx * z),
                    yy * y + (yz * z + xy * x),
                    zz * z + (zx * x + yz * y),
                )
            };
            let value = |x: f64, y: f64, z: f64| {
                let (hx, hy, hz) = half_gradient(x, y, z);
                (hx + g.x) * x + (hy + g.y) * y + (hz + g.z) * z + surface.constant
            };
            let middle = |a: f64, b: f64, anchor: f64| 0.5 * (a + b) - anchor;
            let (ex, ey, ez) = (
                middle(px, rx, anchor.x),
                middle(py, ry, anchor.y),
                middle(pz, rz, anchor.z),
            );
            let (ox, oy, oz) = (
                middle(qx, sx, anchor.x),
                middle(qy, sy, anchor.y),
                middle(qz, sz, anchor.z),
            );
            let even_miss = value(ex, ey, ez).abs();
            let odd_miss = value(ox, oy, oz).abs();
            let (hx, hy, hz) = half_gradient(0.5 * (ex + ox), 0.5 * (ey + oy), 0.5 * (ez + oz));
            let sign = self.outward[lane];
            let (nx, ny, nz) = (
                sign * (2.0 * hx + g.x),
                sign * (2.0 * hy + g.y),
                sign * (2.0 * hz + g.z),
            );
            // Twice the signed areas, seen from outside, on both sides of the
            // diagonal a-c of a, b, c, d: (b - a)·((c - a) × n) and
            // (a - d)·((c - a) × n).
            let smaller = |ax: f64,
                           ay: f64,
                           az: f64,
                           bx: f64,
                           by: f64,
                           bz: f64,
                           cx: f64,
                           cy: f64,
                           cz: f64,
                           dx: f64,
                           dy: f64,
                           dz: f64| {
                let (ux, uy, uz) = (cx - ax, cy - ay, cz - az);
                let (vx, vy, vz) = (uy * nz - uz * ny, uz * nx - ux * nz, ux * ny - uy * nx);
                let before = (bx - ax) * vx + (by - ay) * vy + (bz - az) * vz;
                let after = (ax - dx) * vx + (ay - dy) * vy + (az - dz) * vz;
                if before < after { before } else { after }
            };
            let even = smaller(px, py, pz, qx, qy, qz, rx, ry, rz, sx, sy, sz);
            let odd = smaller(qx, qy, qz, rx, ry, rz, sx, sy, sz, px, py, pz);
            let prefer_even = if is_plane {
                even >= odd
            } else {
                even_miss <= odd_miss
            };
            let take_even = if prefer_even {
                even > 0.0 || odd <= 0.0
            } else {
                odd <= 0.0 && even > 0.0
            };
            let taken = if take_even { even } else { odd };
            even_bits[lane] = u32::from(take_even) << lane;
            // Areas carry the gradient's length.
            let limit = 2.0 * least_area;
            let square = nx * nx + ny * ny + nz * nz;
            let is_bad = taken <= 0.0 || taken * taken <= limit * limit * square;
            bad_bits[lane] = u32::from(is_bad) << lane;
        }
        let all = |bits: [u32; LANES]| bits.into_iter().fold(0, |all, bit| all | bit);
        (all(even_bits), all(bad_bits))
    }
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
