//! What cleaning up needs to know of a stitched mesh: on which surface its
//! triangles lie, and, without going through all of them, which have a given
//! vertex as a corner: those of its cell's brick and of the next ones.

use std::ops::Range;

use glam::UVec3;

use super::assembly::Assembled;
use super::cleanup::Run;
use super::lattice::CELLS;
use super::part::Part;
use super::stitch::Stitcher;

/// The runs of triangles on one surface; none if no triangle is bad.
pub(super) fn runs(parts: &[Part], assembled: &Assembled) -> Vec<Run> {
    if assembled.bad.is_empty() {
        return Vec::new();
    }
    let regular = parts.iter().flat_map(|part| &part.groups);
    let regular = regular.map(|group| (group, 2 * group.count));
    let further = assembled.further.iter();
    let further = further.map(|&(part, group)| (&parts[part].groups[group as usize], 1));
    let mut start = 0;
    regular
        .chain(further)
        .map(|(group, count)| {
            let run = Run {
                start,
                surface: group.surface,
                reversed: group.reversed,
            };
            start += count;
            run
        })
        .collect()
}

/// The triangles of parts in which something is smaller than a cell, or else
/// the mesher would not have had to make do.
pub(super) fn unresolved(parts: &[Part]) -> Vec<Range<usize>> {
    let mut first = 0;
    let ranges = parts.iter().map(|part| {
        let start = first;
        first += 2 * part.polygons.len();
        (part, start..first)
    });
    let made_do = ranges.filter(|(part, _)| !part.fallbacks.is_empty());
    made_do.map(|(_, range)| range).collect()
}

/// Ranges of triangles among which are all that [`super::stitch`] gave any of
/// the vertices as a corner: `further` ones, and those of the bricks around.
pub(super) fn triangles_around(
    stitcher: &Stitcher<'_>,
    vertices: impl Iterator<Item = u32>,
    further: Range<usize>,
) -> Vec<Range<usize>> {
    // By part and place in it.
    let mut bricks: Vec<(usize, usize)> = Vec::new();
    for vertex in vertices {
        // The last part, and brick, that does not start behind it.
        let bases = &stitcher.directory.vertex_base;
        let p = bases.partition_point(|&base| base <= vertex) - 1;
        let part = &stitcher.parts[p];
        let local = vertex - bases[p];
        let b = part
            .bricks
            .partition_point(|brick| brick.vertices.start <= local)
            - 1;
        let brick = &part.bricks[b];
        if bricks.last() != Some(&(p, b)) {
            bricks.push((p, b));
        }
        // A polygon's edge starts at the first sample of its vertices' cells or
        // at the next one, which may be another brick's.
        let cells = &part.cells[brick.cells.start as usize..brick.cells.end as usize];
        let simple = cells.get((local - brick.vertices.start) as usize);
        let may_leave = |axis: u32| {
            let along = |&sample: &u16| sample >> (4 * axis) & 15;
            simple.is_none_or(|sample| along(sample) == CELLS as u16 - 1)
        };
        let leaves = UVec3::from_array([0, 1, 2].map(|axis| u32::from(may_leave(axis))));
        for octant in 1..8u32 {
            let offset = UVec3::new(octant & 1, octant >> 1 & 1, octant >> 2);
            if offset.cmple(leaves).all() {
                bricks.extend(stitcher.directory.brick_at(brick.position + offset));
            }
        }
    }
    bricks.sort_unstable();
    bricks.dedup();
    let mut ranges: Vec<Range<usize>> = Vec::new();
    let mut bricks = bricks.into_iter().peekable();
    let mut first = 0;
    for (p, part) in stitcher.parts.iter().enumerate() {
        while let Some((_, b)) = bricks.next_if(|&(own, _)| own == p) {
            let polygons = &part.bricks[b].polygons;
            let (start, end) = (2 * polygons.start as usize, 2 * polygons.end as usize);
            match ranges.last_mut() {
                Some(last) if last.end == first + start => last.end = first + end,
                _ => ranges.push(first + start..first + end),
            }
        }
        first += 2 * part.polygons.len();
    }
    ranges.push(further);
    ranges
}
