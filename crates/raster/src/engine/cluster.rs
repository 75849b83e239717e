//! Clusters: a few neighbouring triangles that are culled, transformed and
//! set up together.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Most triangles in a cluster.
const CLUSTER_TRIANGLES: usize = 256;
/// Most vertices in a cluster.
pub(crate) const CLUSTER_VERTICES: usize = 256;
/// A cluster's vertices begin at a multiple of this.
const ALIGNMENT: usize = 16;
/// Triangles per parallel task: clusters end there, whatever the number of
/// threads.
const BLOCK: usize = CLUSTER_TRIANGLES * 64;

/// A few neighbouring triangles with vertices of their own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cluster {
    /// First triangle in drawing order; a cluster's triangles are consecutive.
    pub first_triangle: u32,
    pub triangles: u32,
    /// First vertex in [`Clusters::vertices`], a multiple of 16.
    pub first_vertex: u32,
    pub vertices: u32,
    /// Bounding sphere.
    pub centre: DVec3,
    pub radius: f64,
    /// Normals are within the cone about `axis` of half-angle asin(`sine`);
    /// sine is above 1 where there is no such cone.
    pub axis: DVec3,
    pub sine: f64,
    /// Whether the corners at each vertex share their normal.
    pub smooth: bool,
    /// Bits of the section planes that it lies beyond.
    pub beyond: u8,
    /// A mean of log2 of its triangles' longest sides.
    scale: f64,
}

impl Cluster {
    /// Its triangles, in drawing order.
    pub fn range(&self) -> Range<usize> {
        let first = self.first_triangle as usize;
        first..first + self.triangles as usize
    }

    /// Vertices with the gap before the next cluster's first.
    pub fn padded_vertices(&self) -> usize {
        (self.vertices as usize).next_multiple_of(ALIGNMENT)
    }
}

/// A mesh cut into clusters, in drawing order.
pub(crate) struct Clusters {
    pub clusters: Vec<Cluster>,
    /// x, y, z and 0 of all clusters' vertices, and zeros after them, so that
    /// every cluster's part can be taken for a full one.
    pub vertices: Vec<[f32; 4]>,
    /// The same of what single precision leaves of them; or empty.
    pub remainders: Vec<[f32; 4]>,
    /// For each triangle the numbers of its vertices within the cluster.
    pub local: Vec<[u8; 4]>,
}

impl Clusters {
    /// Cuts triangles, in drawing order, into clusters. Those that name a
    /// vertex out of range or not finite become points, which are not drawn.
    /// `groups` are numbers of consecutive triangles, all of them together;
    /// no cluster has triangles of two groups.
    /// `remainders` is empty, or what single precision leaves of each position.
    pub fn new(
        positions: &[Vec3],
        remainders: &[Vec3],
        triangles: &[[u32; 3]],
        groups: &[usize],
    ) -> Self {
        let finite = positions.par_chunks(BLOCK);
        let all_finite = finite.all(|chunk| chunk.iter().all(|p| p.is_finite()));
        // (Whether a vertex is there is asked often; where it is, seldom.)
        let usable = |v: u32| {
            if all_finite {
                (v as usize) < positions.len()
            } else {
                positions.get(v as usize).is_some_and(|p| p.is_finite())
            }
        };
        let mut local = vec![[0; 4]; triangles.len()];
        let mut first = 0;
        let mut pieces = Vec::new();
        for &group in groups {
            pieces.extend(triangles[first..first + group].chunks(BLOCK));
            first += group;
        }
        let lengths = pieces.iter().map(|piece| piece.len());
        let mut blocks: Vec<Block> = split(&mut local, lengths)
            .into_par_iter()
            .zip(&pieces)
            .map(|(local, triangles)| Block::cut(usable, triangles, local))
            .collect();
        let (mut clusters, mut vertices, mut first) = (0, 0, 0);
        for (block, piece) in blocks.iter_mut().zip(&pieces) {
            for cluster in &mut block.clusters {
                cluster.first_triangle += first;
                cluster.first_vertex = vertices as u32;
                vertices += cluster.padded_vertices();
            }
            clusters += block.clusters.len();
            first += piece.len() as u32;
        }
        // (Zeros from the system, which the threads touch first.)
        let mut all_vertices: Vec<[f32; 4]> = bytemuck::zeroed_vec(vertices + CLUSTER_VERTICES);
        let lengths: Vec<usize> = blocks.iter().map(Block::padded_vertices).collect();
        blocks
            .par_iter_mut()
            .zip(split(&mut all_vertices, lengths.iter().copied()))
            .for_each(|(block, vertices)| {
                block.finish(positions, remainders, &local, vertices);
            });
        let mut all_remainders = Vec::new();
        if !remainders.is_empty() {
            all_remainders = bytemuck::zeroed_vec(all_vertices.len());
            for block in &blocks {
                block.copy(remainders, &mut all_remainders);
            }
        }
        let mut all = Vec::with_capacity(clusters);
        for block in &blocks {
            all.extend_from_slice(&block.clusters);
        }
        Self {
            clusters: all,
            vertices: all_vertices,
            remainders: all_remainders,
            local,
        }
    }

    /// Whether some clusters' triangles are so small beside the box around all
    /// that rounding to single precision may be seen.
    pub fn are_tiny(&self, low: DVec3, high: DVec3) -> bool {
        /// Rounding is then a millionth of a side, or less.
        const SHARE: f64 = 1.0 / 4096.0;
        let size = (high - low).max_element() / 2.0;
        let smallest = self.clusters.iter().map(|cluster| cluster.scale);
        smallest.fold(f64::INFINITY, f64::min) < (size * SHARE).log2()
    }
}

/// Cuts a slice into pieces of the given lengths.
pub(crate) fn split<T>(mut rest: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    let cut = |length| rest.split_off_mut(..length).unwrap_or_default();
    lengths.map(cut).collect()
}

/// The clusters of one block of triangles.
struct Block {
    clusters: Vec<Cluster>,
    /// The vertices of one cluster after the other.
    members: Vec<u32>,
}

impl Block {
    /// Decides where clusters end, and numbers their vertices. Triangles and
    /// vertices are counted from the block's first.
    fn cut(usable: impl Fn(u32) -> bool, triangles: &[[u32; 3]], local: &mut [[u8; 4]]) -> Self {
        let mut block = Self {
            clusters: Vec::with_capacity(triangles.len() / CLUSTER_TRIANGLES * 3 / 2 + 1),
            members: Vec::with_capacity(triangles.len()),
        };
        let mut numbers = Numbers::new();
        let (mut first, mut first_member) = (0, 0);
        for (index, (triangle, local)) in triangles.iter().zip(local).enumerate() {
            if !triangle.iter().all(|&v| usable(v)) {
                // Three times one vertex has no area, and is never drawn.
                if index - first >= CLUSTER_TRIANGLES {
                    block.end_cluster(first, index, first_member);
                    (first, first_member) = (index, block.members.len());
                    numbers.clear();
                }
                continue;
            }
            let fresh = |v: &&u32| numbers.get(**v).is_none();
            let count = block.members.len() - first_member;
            if index - first >= CLUSTER_TRIANGLES
                || (count + 3 > CLUSTER_VERTICES
                    && count + triangle.iter().filter(fresh).count() > CLUSTER_VERTICES)
            {
                block.end_cluster(first, index, first_member);
                (first, first_member) = (index, block.members.len());
                numbers.clear();
            }
            for (slot, &v) in local.iter_mut().zip(triangle) {
                let next = block.members.len() - first_member;
                *slot = numbers.get_or_insert(v, next as u8);
                if usize::from(*slot) == next {
                    block.members.push(v);
                }
            }
        }
        if first < triangles.len() {
            block.end_cluster(first, triangles.len(), first_member);
        }
        block
    }

    fn end_cluster(&mut self, first: usize, end: usize, first_member: usize) {
        self.clusters.push(Cluster {
            first_triangle: first as u32,
            triangles: (end - first) as u32,
            first_vertex: 0,
            vertices: (self.members.len() - first_member) as u32,
            centre: DVec3::ZERO,
            radius: 0.0,
            axis: DVec3::ZERO,
            sine: 2.0,
            smooth: false,
            beyond: 0,
            scale: f64::INFINITY,
        });
    }

    /// Vertices with the gaps that align each cluster's first.
    fn padded_vertices(&self) -> usize {
        self.clusters.iter().map(Cluster::padded_vertices).sum()
    }

    /// Copies the vertices to where they belong, and bounds each cluster.
    fn finish(
        &mut self,
        positions: &[Vec3],
        remainders: &[Vec3],
        local: &[[u8; 4]],
        vertices: &mut [[f32; 4]],
    ) {
        let mut members = &self.members[..];
        let mut at = 0;
        let mut points = Vec::with_capacity(CLUSTER_VERTICES);
        let mut normals = Vec::with_capacity(CLUSTER_TRIANGLES);
        for cluster in &mut self.clusters {
            let (own, rest) = members.split_at(cluster.vertices as usize);
            members = rest;
            points.clear();
            points.extend(own.iter().map(|&v| positions[v as usize]));
            for (to, point) in vertices[at..].iter_mut().zip(&points) {
                *to = point.extend(0.0).to_array();
            }
            at += cluster.padded_vertices();
            // Relative to one of them, where they are near each other beside
            // their distance from the origin.
            let mut origin = Vec3::ZERO;
            if !remainders.is_empty() {
                origin = points.first().copied().unwrap_or_default();
                for (point, &v) in points.iter_mut().zip(own) {
                    *point = (*point - origin) + remainders[v as usize];
                }
            }
            let (centre, radius) = bounding_sphere(&points);
            cluster.centre = centre.as_dvec3() + origin.as_dvec3();
            // (Rounding of the positions, where remainders are left out.)
            cluster.radius = f64::from(radius) + cluster.centre.length() * 1e-7;
            let first = cluster.first_triangle as usize;
            normals.clear();
            let mut scale = Scale::default();
            normals.extend(
                local[first..first + cluster.triangles as usize]
                    .iter()
                    .filter_map(|&[a, b, c, _]| {
                        let at = |v: u8| points.get(usize::from(v)).copied();
                        let (pa, pb, pc) = (at(a)?, at(b)?, at(c)?);
                        let (u, v) = (pb - pa, pc - pa);
                        if a != b {
                            scale.add(u.length_squared().max(v.length_squared()));
                        }
                        u.cross(v).try_normalize()
                    }),
            );
            (cluster.axis, cluster.sine) = normal_cone(&normals);
            cluster.scale = scale.mean();
        }
    }

    /// Copies what belongs to the vertices to the rows of all clusters.
    fn copy(&self, values: &[Vec3], rows: &mut [[f32; 4]]) {
        let mut members = &self.members[..];
        for cluster in &self.clusters {
            let (own, rest) = members.split_at(cluster.vertices as usize);
            members = rest;
            let rows = &mut rows[cluster.first_vertex as usize..];
            for (to, &v) in rows.iter_mut().zip(own) {
                *to = values[v as usize].extend(0.0).to_array();
            }
        }
    }
}

/// A mean of the binary logarithms of lengths, to a half: exponents cost
/// nothing, and a few slivers among many triangles do not matter.
#[derive(Default)]
struct Scale {
    sum: i64,
    count: i64,
}

impl Scale {
    /// Adds the square of a length. Zero has the least exponent.
    fn add(&mut self, squared: f32) {
        let exponent = i64::from(squared.to_bits() >> 23 & 0xff) - 127;
        self.sum += exponent;
        self.count += 1;
    }

    fn mean(&self) -> f64 {
        if self.count == 0 {
            return f64::INFINITY;
        }
        self.sum as f64 / self.count as f64 / 2.0
    }
}

/// A sphere around points, a little larger for its own rounding and that of
/// culling.
fn bounding_sphere(points: &[Vec3]) -> (Vec3, f32) {
    let start = points.first().copied().unwrap_or_default();
    let (low, high) = points
        .iter()
        .fold((start, start), |(low, high), &p| (low.min(p), high.max(p)));
    let centre = low / 2.0 + high / 2.0;
    let squares = points.iter().map(|p| p.distance_squared(centre));
    let radius = squares.fold(0.0, f32::max).sqrt();
    (centre, radius * 1.0001 + f32::MIN_POSITIVE)
}

/// The axis of a cone of unit normals and the sine of its half-angle, above 1
/// where it is (nearly) a half-space or more.
fn normal_cone(normals: &[Vec3]) -> (DVec3, f64) {
    let axis = normals.iter().sum::<Vec3>().normalize_or_zero();
    let cosine = normals.iter().map(|n| n.dot(axis)).fold(1.0, f32::min);
    let sine = if cosine > 0.1 {
        // A little wider: rounding, and triangles that snapping tilts.
        (1.0 - cosine * cosine).max(0.0).sqrt() + 0.02
    } else {
        2.0
    };
    (axis.as_dvec3(), f64::from(sine))
}

/// The numbers of vertices within a cluster: a hash table that fits the first
/// level cache and is emptied fast.
struct Numbers {
    /// Vertex and number, probed one after another.
    slots: [(u32, u8); SLOTS],
}

/// At least twice [`CLUSTER_VERTICES`].
const SLOTS: usize = 1024;

/// No vertex: too large an index to be one that is in range.
const FREE: (u32, u8) = (u32::MAX, 0);

impl Numbers {
    fn new() -> Self {
        Self {
            slots: [FREE; SLOTS],
        }
    }

    fn clear(&mut self) {
        self.slots.fill(FREE);
    }

    /// The slot of a vertex, or the free one for it.
    fn slot(&self, vertex: u32) -> usize {
        let mut slot = (vertex.wrapping_mul(0x9e37_79b9) >> 22) as usize % SLOTS;
        while self.slots[slot].0 != vertex && self.slots[slot].0 != FREE.0 {
            slot = (slot + 1) % SLOTS;
        }
        slot
    }

    fn get(&self, vertex: u32) -> Option<u8> {
        let (found, number) = self.slots[self.slot(vertex)];
        (found == vertex).then_some(number)
    }

    fn get_or_insert(&mut self, vertex: u32, number: u8) -> u8 {
        let slot = self.slot(vertex);
        if self.slots[slot].0 != vertex {
            self.slots[slot] = (vertex, number);
        }
        self.slots[slot].1
    }
}
