//! Meshes whose triangles are divided until a number that is known at their
//! corners changes little within each, so that colours that tell it show no
//! triangles.

use std::collections::HashMap;

use csg::Mesh;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Most often that a side is halved: where a number jumps, it never changes
/// little.
const ROUNDS: usize = 8;
/// No more is divided beyond so many triangles.
const MOST_TRIANGLES: usize = 200_000;

/// A part of a triangle.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub corners: [u32; 3],
    /// The triangle that it is a part of.
    pub parent: usize,
    /// Unit normals at the corners, if the mesh has any.
    pub normals: Option<[Vec3; 3]>,
    /// Numbers at the corners, as far as they are known.
    pub values: [Option<f64>; 3],
}

impl Piece {
    /// Whether the number changes by more than a step along a side.
    fn is_steep(&self, side: usize, step: f64) -> bool {
        let [a, b] = [self.values[side], self.values[(side + 1) % 3]];
        a.zip(b).is_some_and(|(a, b)| (a - b).abs() > step)
    }

    /// The mean of the numbers.
    pub fn mean(&self) -> Option<f64> {
        let known: Vec<_> = self.values.iter().flatten().collect();
        (!known.is_empty()).then(|| known.iter().copied().sum::<f64>() / known.len() as f64)
    }

    /// The pieces that halved sides, with their middles, leave of it.
    fn divide(&self, middles: [Option<u32>; 3]) -> Vec<Self> {
        // Corners 0 to 2, then the middles of the sides that begin there.
        let corner = |k: usize| match k {
            0..3 => self.corners[k],
            _ => middles[k - 3].unwrap_or_default(),
        };
        let normal = |k: usize| {
            let normals = self.normals.unwrap_or_default();
            match k {
                0..3 => normals[k],
                _ => (normals[k - 3] + normals[(k - 2) % 3]).normalize_or(normals[k - 3]),
            }
        };
        let piece = |corners: [usize; 3]| Self {
            corners: corners.map(corner),
            parent: self.parent,
            normals: self.normals.map(|_| corners.map(normal)),
            values: [None; 3],
        };
        let halved = middles.map(|middle| middle.is_some());
        let first = |wanted: bool| halved.iter().position(|&h| h == wanted).unwrap_or(0);
        match halved.into_iter().filter(|&h| h).count() {
            0 => vec![self.clone()],
            1 => {
                let a = first(true);
                let (b, c, m) = ((a + 1) % 3, (a + 2) % 3, a + 3);
                vec![piece([a, m, c]), piece([m, b, c])]
            }
            2 => {
                let a = first(false);
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                let (after_b, after_c) = (b + 3, c + 3);
                let corner = piece([after_c, after_b, c]);
                vec![corner, piece([a, b, after_b]), piece([a, after_b, after_c])]
            }
            _ => [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
                .map(piece)
                .into(),
        }
    }
}

/// Divides a mesh's triangles until a number changes by no more than a `share`
/// of its range along every side, and returns them with it. What shares a side
/// still does: a side is halved for both of its triangles. `value` is asked for
/// a corner of a piece, with the positions of all three. The mesh gets the
/// pieces' triangles, normals and points, and its feature edges their points.
pub(crate) fn refine(
    mesh: &mut Mesh,
    share: f64,
    value: impl Fn(&Piece, usize, [DVec3; 3]) -> Option<f64> + Sync,
) -> Vec<Piece> {
    let smooth = mesh.corner_normals.len() == mesh.triangles.len();
    let triangles = mesh.triangles.iter().enumerate();
    let mut pieces: Vec<_> = triangles
        .map(|(parent, &corners)| Piece {
            corners,
            parent,
            normals: smooth.then(|| mesh.corner_normals[parent]),
            values: [None; 3],
        })
        .collect();
    let find = |positions: &[DVec3], pieces: &mut [Piece]| {
        let fresh = pieces.par_iter_mut();
        let fresh = fresh.filter(|piece| piece.values == [None; 3]);
        fresh.for_each(|piece| {
            let at = piece.corners.map(|v| positions.get(v as usize).copied());
            if let [Some(a), Some(b), Some(c)] = at {
                piece.values = [0, 1, 2].map(|k| value(piece, k, [a, b, c]));
            }
        });
    };
    find(&mesh.positions, &mut pieces);
    for _ in 0..ROUNDS {
        let [low, high] = range(&pieces);
        let step = (high - low) * share;
        let mut middles = HashMap::new();
        for piece in &pieces {
            for side in (0..3).filter(|&side| piece.is_steep(side, step)) {
                let ends = side_of(piece, side);
                middles.entry(ends).or_insert_with(|| {
                    let [a, b] = ends.map(|v| mesh.positions[v as usize]);
                    mesh.positions.push(a.midpoint(b));
                    mesh.positions.len() as u32 - 1
                });
            }
        }
        if middles.is_empty() || pieces.len() > MOST_TRIANGLES {
            break;
        }
        let middle = |a: u32, b: u32| middles.get(&[a.min(b), a.max(b)]).copied();
        let mut finer = Vec::with_capacity(pieces.len() * 2);
        for piece in &pieces {
            let [a, b, c] = piece.corners;
            let halved = [middle(a, b), middle(b, c), middle(c, a)];
            finer.extend(piece.divide(halved));
        }
        pieces = finer;
        find(&mesh.positions, &mut pieces);
        for line in &mut mesh.feature_edges {
            let old = std::mem::take(line);
            for (k, &v) in old.iter().enumerate() {
                let before = k.checked_sub(1).and_then(|k| middle(old[k], v));
                line.extend(before.into_iter().chain([v]));
            }
        }
    }
    mesh.triangles = pieces.iter().map(|piece| piece.corners).collect();
    mesh.corner_normals = pieces.iter().filter_map(|piece| piece.normals).collect();
    pieces
}

/// The ends of a side, the lesser one first.
fn side_of(piece: &Piece, side: usize) -> [u32; 2] {
    let [a, b] = [piece.corners[side], piece.corners[(side + 1) % 3]];
    [a.min(b), a.max(b)]
}

/// The least and the greatest number; twice 0, if none is known.
pub(crate) fn range(pieces: &[Piece]) -> [f64; 2] {
    let known = || pieces.iter().flat_map(|piece| piece.values).flatten();
    let low = known().fold(f64::INFINITY, f64::min);
    let high = known().fold(f64::NEG_INFINITY, f64::max);
    if low <= high { [low, high] } else { [0.0; 2] }
}
