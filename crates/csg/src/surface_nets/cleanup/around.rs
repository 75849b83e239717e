//! Gathers the faces around vertices.

use std::ops::Range;

use rayon::prelude::*;

use super::stars::{Face, Stars};
use super::{Cleaner, Run, Work};

impl<N: Fn(&[u32]) -> Vec<Range<usize>> + Sync> Cleaner<'_, N> {
    /// The run that a triangle belongs to.
    fn run(&self, triangle: u32) -> usize {
        let after = self.runs.partition_point(|run| run.start <= triangle);
        after.saturating_sub(1)
    }

    pub(super) fn face(&self, triangle: u32) -> Face {
        self.face_of(triangle, self.run(triangle))
    }

    fn face_of(&self, triangle: u32, run: usize) -> Face {
        let run = &self.runs[run];
        Face {
            triangle,
            surface: run.surface,
            reversed: run.reversed,
        }
    }

    pub(super) fn corners(&self, face: Face) -> [u32; 3] {
        self.triangles[face.triangle as usize]
    }

    /// The stars of all vertices of the bad triangles; if it is to be thorough,
    /// of their neighbours, too.
    pub(super) fn stars(&self, bad: &[Face], thorough: bool, work: &Work) -> Stars {
        let mut stars = Stars::none_of(self.positions.len());
        let around = |stars: &Stars| -> Vec<Face> {
            let is_around = |&triangle: &usize| {
                let mut corners = self.triangles[triangle].iter();
                corners.any(|&v| stars.has(v))
            };
            let ranges = (self.near)(&stars.vertices);
            let is_elsewhere = |&triangle: &u32| {
                let after = ranges.partition_point(|range| range.end <= triangle as usize);
                let range = ranges.get(after);
                !range.is_some_and(|range| range.contains(&(triangle as usize)))
            };
            let elsewhere = work.altered.iter().copied().filter(is_elsewhere);
            let elsewhere = elsewhere.filter(|&triangle| is_around(&(triangle as usize)));
            let mut faces: Vec<Face> = elsewhere.map(|triangle| self.face(triangle)).collect();
            faces.par_extend(ranges.par_iter().flat_map_iter(|range| {
                let mut run = self.run(range.start as u32);
                range.clone().filter(is_around).map(move |triangle| {
                    let is_behind = |run: &Run| run.start as usize <= triangle;
                    while self.runs.get(run + 1).is_some_and(is_behind) {
                        run += 1;
                    }
                    self.face_of(triangle as u32, run)
                })
            }));
            faces.retain(|face| !work.removed.contains(&face.triangle));
            // In whatever ranges they were found: the order decides what is tried first.
            faces.sort_unstable_by_key(|face| face.triangle);
            faces
        };
        let want = |faces: &[Face], stars: &mut Stars| {
            let corners = faces.iter().flat_map(|&face| self.corners(face));
            corners.for_each(|vertex| stars.want(vertex));
        };
        want(bad, &mut stars);
        if thorough {
            want(&around(&stars), &mut stars);
        }
        for face in around(&stars) {
            for vertex in self.corners(face) {
                if let Some(star) = stars.get_mut(vertex) {
                    star.faces.push(face);
                }
            }
        }
        stars
    }

    /// Whether any merger after the first `since` has changed what decides
    /// about a face: the stars of its corners and of the vertices around them.
    pub(super) fn changed_around(&self, face: Face, since: u32, stars: &Stars) -> bool {
        let has_changed = |vertex: u32| stars.get(vertex).is_some_and(|star| star.changed > since);
        let around = self.corners(face).into_iter();
        let around = around.filter_map(|vertex| stars.get(vertex));
        around
            .flat_map(|star| &star.faces)
            .any(|&face| self.corners(face).into_iter().any(has_changed))
    }

    /// The other face at the edge between two vertices.
    pub(super) fn neighbour(&self, face: Face, u: u32, v: u32, stars: &Stars) -> Option<Face> {
        let mut star = stars.get(u)?.faces.iter().copied();
        star.find(|&other| other.triangle != face.triangle && self.corners(other).contains(&v))
    }

    /// The vertices around a vertex, each once.
    pub(super) fn link(&self, vertex: u32, star: &[Face], link: &mut Vec<u32>) {
        link.clear();
        for other in star.iter().flat_map(|&face| self.corners(face)) {
            if other != vertex && !link.contains(&other) {
                link.push(other);
            }
        }
    }
}
