//! The mesh as it grows, by one batch of parts after another.

use rayon::prelude::*;

use glam::DVec3;

use super::part::Part;
use crate::pages::{self, Room};

/// Where the vertices and triangles of one part go: two triangles for every
/// polygon, in order.
pub(super) struct Output<'a> {
    pub positions: Room<'a, DVec3>,
    pub triangles: Room<'a, [u32; 3]>,
    /// The triangles' entries in the mesh's table of surfaces.
    pub surfaces: Room<'a, u32>,
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

/// Vertices and triangles of the parts so far.
#[derive(Debug, Default)]
pub(super) struct Assembly {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    surfaces: Vec<u32>,
    bad: Vec<u32>,
    further: Vec<Further>,
}

/// A triangle beside the two of every polygon.
#[derive(Debug)]
struct Further {
    triangle: [u32; 3],
    entry: u32,
    part: usize,
    group: u32,
}

/// The triangles of a whole mesh.
#[derive(Debug)]
pub(super) struct Assembled {
    pub positions: Vec<DVec3>,
    /// Two for every polygon, in order, then the further ones.
    pub triangles: Vec<[u32; 3]>,
    /// The triangles' entries in the mesh's table of surfaces.
    pub surfaces: Vec<u32>,
    /// Triangles that may have no area or be folded over.
    pub bad: Vec<u32>,
    /// Part and group of the further triangles.
    pub further: Vec<(usize, u32)>,
}

/// Room for the parts to come beside what those so far lead to expect. More
/// costs nothing but addresses, too little a copy of everything.
const MARGIN: f64 = 1.5;

impl Assembly {
    /// Adds the parts from `first` on, from `stitch`, which does one of them,
    /// by its place in `parts`. `done` is the share of all blocks that `parts`
    /// come from.
    pub fn add(
        &mut self,
        parts: &[Part],
        first: usize,
        done: f64,
        stitch: impl Fn(usize, &mut Output<'_>) -> Leftovers + Sync,
    ) {
        let added = &parts[first..];
        let vertices: usize = added.iter().map(|part| part.vertices.len()).sum();
        let polygons: usize = added.iter().map(|part| part.polygons.len()).sum();
        let first_triangle = self.triangles.len() as u32;
        rayon::join(
            || make_room(&mut self.positions, vertices, done),
            || {
                make_room(&mut self.triangles, 2 * polygons, done);
                make_room(&mut self.surfaces, 2 * polygons, done);
            },
        );
        let leftovers: Vec<Leftovers> =
            pages::extend(&mut self.positions, vertices, |mut positions| {
                pages::extend(&mut self.triangles, 2 * polygons, |mut triangles| {
                    pages::extend(&mut self.surfaces, 2 * polygons, |mut surfaces| {
                        let room = |part: &Part| Output {
                            positions: positions.split(part.vertices.len()),
                            triangles: triangles.split(2 * part.polygons.len()),
                            surfaces: surfaces.split(2 * part.polygons.len()),
                        };
                        let rooms: Vec<Output<'_>> = added.iter().map(room).collect();
                        let rooms = rooms.into_par_iter().zip(first..parts.len());
                        let stitched = rooms.with_max_len(1);
                        stitched
                            .map(|(mut out, part)| stitch(part, &mut out))
                            .collect()
                    })
                })
            });
        let mut triangle = first_triangle;
        for ((p, part), leftovers) in (first..).zip(added).zip(leftovers) {
            let bad = leftovers.bad.into_iter();
            self.bad.extend(bad.map(|bad| triangle + bad));
            triangle += 2 * part.polygons.len() as u32;
            let further = leftovers.further.into_iter();
            self.further
                .extend(further.map(|(triangle, group)| Further {
                    triangle,
                    entry: part.groups[group as usize].entry,
                    part: p,
                    group,
                }));
        }
    }

    /// The whole mesh, without room for more.
    pub fn finish(mut self) -> Assembled {
        let regular = self.triangles.len() as u32;
        let all = self.triangles.len() + self.further.len();
        pages::reserve(&mut self.triangles, all);
        pages::reserve(&mut self.surfaces, all);
        let further = self.further.iter();
        self.triangles
            .extend(further.map(|further| further.triangle));
        let further = self.further.iter();
        self.surfaces.extend(further.map(|further| further.entry));
        self.bad.extend(regular..self.triangles.len() as u32);
        pages::shrink(&mut self.positions);
        pages::shrink(&mut self.triangles);
        pages::shrink(&mut self.surfaces);
        let further = self.further.iter();
        Assembled {
            further: further.map(|f| (f.part, f.group)).collect(),
            positions: self.positions,
            triangles: self.triangles,
            surfaces: self.surfaces,
            bad: self.bad,
        }
    }
}

/// Makes room for `additional` items, if there is none, and for those that are
/// still to be expected when the given share is done.
fn make_room<T>(buffer: &mut Vec<T>, additional: usize, done: f64) {
    let len = buffer.len() + additional;
    if len > buffer.capacity() {
        let to_come = len as f64 * (1.0 / done - 1.0);
        pages::reserve(buffer, len + (MARGIN * to_come) as usize);
    }
}
