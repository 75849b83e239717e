//! Fills the triangles of doubly curved faces with as many small ones as the
//! tolerance asks for, in one step.
//!
//! Every triangle has a number n of rows, by how far it strays: n² small
//! triangles stray an n²-th as far. Every edge is cut once, for both its sides:
//! a curve into its chords, any other by what its two triangles need. Inside,
//! the vertices of the regular pattern that are not on the rim are put on the
//! surface, and the strips between them and the rim are filled like a zip, so
//! that any numbers fit together, as in the tessellation of graphics hardware.

use crate::elementary;
use glam::DVec3;
use rayon::prelude::*;

use super::deviation::Corner;
use super::fine::{Fine, ON_SIDE, Subdivision};
use super::goal::Goal;
use super::half_edges::{HalfEdges, NONE, first_of, halves_of, triangle_of};
use super::judge::{self, Judge};
use super::patch::Patch;
use super::piece::Piece;
use super::region::Way;
use super::surfaced::BYTES_PER_TRIANGLE;
use crate::control::Control;
use crate::error::Error;

/// About what is held for each small triangle at a time.
const BYTES_PER_FINE: usize = 80;

/// The points on one side of a large triangle.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    first: u32,
    count: u32,
    /// Whether they are numbered against the half-edge.
    is_backward: bool,
}

/// What is known of a triangle of the half-edge mesh.
#[derive(Clone, Copy, Debug, Default)]
struct Large {
    /// How many rows it needs, as a real number; 0 if it is left alone.
    rows: f64,
    /// Whether a small triangle of it was too far off.
    strays: bool,
}

pub(super) struct Tessellator<'m, 's> {
    mesh: &'m HalfEdges<'s>,
    goal: &'m Goal,
    /// For each triangle of the mesh.
    large: Vec<Large>,
    /// For each half-edge its points.
    sides: Vec<Side>,
    fine: Fine,
}

impl<'m, 's> Tessellator<'m, 's> {
    /// For the triangles of the regions that are to be tessellated.
    pub fn new(mesh: &'m HalfEdges<'s>, goal: &'m Goal) -> Self {
        let count = mesh.triangle_count();
        let is_wanted = |&t: &u32| !mesh.is_gone(t) && mesh.region(first_of(t)).way == Way::AtOnce;
        let wanted: Vec<u32> = (0..count).filter(is_wanted).collect();
        let mut large = vec![Large::default(); count as usize];
        for &triangle in &wanted {
            large[triangle as usize].rows = rows_of(mesh, triangle, goal);
        }
        let subdivision = |large| Subdivision {
            large,
            is_stale: true,
            ..Subdivision::default()
        };
        let subdivisions = wanted.into_iter().map(subdivision).collect();
        Self {
            mesh,
            goal,
            large,
            sides: vec![Side::default(); mesh.end_of_halves() as usize],
            fine: Fine {
                points: Vec::new(),
                subdivisions,
            },
        }
    }

    /// Fills all triangles; where the bound fails, again with more rows.
    pub fn run(
        mut self,
        pieces: &[Piece],
        control: &Control,
        tell: &mut impl FnMut(),
    ) -> Result<Fine, Error> {
        const MOST_TRIES: usize = 12;
        for tries in 1.. {
            // Before a point of them is made.
            control.check_memory(BYTES_PER_FINE.saturating_mul(self.least_count()))?;
            self.cut_sides(pieces);
            let (open, fine) = self.count();
            control.check_triangles(open + fine)?;
            control.check_memory(BYTES_PER_TRIANGLE * open + BYTES_PER_FINE * fine)?;
            self.fill();
            tell();
            let subdivisions = &mut self.fine.subdivisions;
            let strays = |subdivision: &Subdivision| subdivision.deviation > self.goal.tolerance;
            let is_folded = subdivisions.iter().any(|subdivision| subdivision.is_folded);
            if is_folded || tries == MOST_TRIES || !subdivisions.iter().any(strays) {
                break;
            }
            for subdivision in subdivisions
                .iter_mut()
                .filter(|subdivision| strays(subdivision))
            {
                let excess = (subdivision.deviation / self.goal.tolerance).min(4.0);
                let Large { rows, strays } = &mut self.large[subdivision.large as usize];
                *rows = (*rows * excess.sqrt()).max(f64::from(whole(*rows)) + 0.01);
                *strays = true;
                subdivision.is_stale = true;
            }
        }
        Ok(self.fine)
    }

    /// How many triangles are left alone, and how many small ones the others
    /// come to: by Euler's formula two for each vertex inside and one for each
    /// but two on the rim.
    fn count(&self) -> (usize, usize) {
        let subdivisions = self.fine.subdivisions.iter();
        let fine = subdivisions.clone().map(|subdivision| {
            let rows = whole(self.large[subdivision.large as usize].rows) as usize;
            let inner = rows.saturating_sub(1) * rows.saturating_sub(2) / 2;
            let sides = halves_of(subdivision.large);
            let on_sides: u32 = sides.map(|side| self.sides[side as usize].count).sum();
            1 + on_sides as usize + 2 * inner
        });
        let live = self.mesh.triangle_count() as usize - self.mesh.free.len();
        (live - subdivisions.len(), fine.sum())
    }

    /// A count that the small triangles exceed: of rows without what the sides need more.
    fn least_count(&self) -> usize {
        let subdivisions = self.fine.subdivisions.iter();
        let rows = subdivisions.map(|s| whole(self.large[s.large as usize].rows) as usize);
        rows.map(|rows| rows.saturating_sub(2).pow(2)).sum()
    }

    /// Finds the points on all sides that are new or need more than they have.
    fn cut_sides(&mut self, pieces: &[Piece]) {
        let mesh = self.mesh;
        for index in 0..self.fine.subdivisions.len() {
            let triangle = self.fine.subdivisions[index].large;
            for half in halves_of(triangle) {
                let twin = mesh.twin(half);
                let own = self.large[triangle as usize];
                let beyond = self.large[triangle_of(twin) as usize];
                let piece = mesh.piece(half);
                let side = if beyond.rows > 0.0 && half > twin {
                    let side = self.sides[twin as usize];
                    Side {
                        is_backward: !side.is_backward,
                        ..side
                    }
                } else if piece != NONE {
                    let Piece { first, count } = pieces[piece as usize];
                    Side {
                        first,
                        count,
                        is_backward: mesh.piece_halves[piece as usize] != half,
                    }
                } else if mesh.is_on_curve(half) {
                    Side::default()
                } else {
                    let at_least = |large: Large| if large.strays { large.rows } else { 0.0 };
                    let mean = 0.5 * (own.rows + beyond.rows);
                    let chords = whole(mean.max(at_least(own)).max(at_least(beyond)));
                    let side = self.sides[half as usize];
                    if side.count == chords - 1 {
                        side
                    } else {
                        self.cut_side(half, chords)
                    }
                };
                let known = &mut self.sides[half as usize];
                if (known.first, known.count) != (side.first, side.count) {
                    *known = side;
                    self.fine.subdivisions[index].is_stale = true;
                }
            }
        }
    }

    /// Cuts a side into chords that are equal, or nearly.
    fn cut_side(&mut self, half: u32, chords: u32) -> Side {
        let mesh = self.mesh;
        let (surface, region) = (mesh.surface(half), mesh.region(half));
        let (p, q) = (mesh.at(mesh.origin(half)), mesh.at(mesh.target(half)));
        let first = ON_SIDE + self.fine.points.len() as u32;
        let turn = region.turn(surface, [p, q]).powi(2);
        for i in 1..chords {
            // Shares of a chord whose images are equal shares of an arc.
            let x = f64::from(i) / f64::from(chords) - 0.5;
            let share = 0.5 + x * (1.0 + turn * x * x / 3.0) / (1.0 + turn / 12.0);
            let start = p.lerp(q, share);
            let point = region.project(surface, start).unwrap_or(start);
            self.fine.points.push(point);
        }
        Side {
            first,
            count: chords - 1,
            is_backward: false,
        }
    }

    /// Fills all triangles that are not as they should be.
    fn fill(&mut self) {
        /// Triangles worth a task of their own. Tunes speed only.
        const FEWEST: usize = 8;
        let mut subdivisions = std::mem::take(&mut self.fine.subdivisions);
        let stale = subdivisions.par_iter_mut().with_min_len(FEWEST);
        stale.for_each_init(Patch::default, |patch, subdivision| {
            if subdivision.is_stale {
                self.fill_one(patch, subdivision);
            }
        });
        self.fine.subdivisions = subdivisions;
    }

    fn fill_one(&self, patch: &mut Patch, subdivision: &mut Subdivision) {
        let triangle = subdivision.large;
        let mesh = self.mesh;
        let half = first_of(triangle);
        let (surface, region) = (mesh.surface(half), mesh.region(half));
        patch.clear();
        for side in half..half + 3 {
            let corner = mesh.origin(side);
            patch.starts[(side - half) as usize] = patch.names.len() as u32;
            patch.add(corner, mesh.at(corner));
            let Side {
                first,
                count,
                is_backward,
            } = self.sides[side as usize];
            for i in 0..count {
                let name = first + if is_backward { count - 1 - i } else { i };
                let place = match name.checked_sub(ON_SIDE) {
                    Some(point) => self.fine.points[point as usize],
                    None => mesh.at(name),
                };
                patch.add(name, place);
            }
        }
        patch.starts[3] = patch.names.len() as u32;
        let rows = whole(self.large[triangle as usize].rows);
        patch.fill(surface, region, rows);
        subdivision.inner.clear();
        subdivision
            .inner
            .extend_from_slice(&patch.positions[patch.starts[3] as usize..]);
        self.judge(patch, subdivision);
        subdivision.is_stale = false;
    }

    /// Bounds how far the small triangles stray, and hands them over.
    fn judge(&self, patch: &mut Patch, subdivision: &mut Subdivision) {
        let half = first_of(subdivision.large);
        let (surface, region) = (self.mesh.surface(half), self.mesh.region(half));
        let corner = |&at: &DVec3| Corner::new(surface, at);
        patch.corners.extend(patch.positions.iter().map(corner));
        let judge = Judge::new(surface, region, self.goal.tolerance);
        (subdivision.deviation, subdivision.is_folded) = (0.0, false);
        subdivision.triangles.clear();
        for small in &patch.triangles {
            let corners = small.map(|c| &patch.corners[c as usize]);
            let bound = judge.judge(corners);
            subdivision.is_folded |= bound.is_none();
            let bound = bound.unwrap_or(f64::INFINITY);
            if bound > subdivision.deviation {
                (subdivision.deviation, subdivision.farthest) = (bound, corners[0].at);
            }
            subdivision
                .triangles
                .push(small.map(|c| patch.names[c as usize]));
        }
    }
}

/// How many rows a triangle needs, as a real number.
pub(super) fn rows_of(mesh: &HalfEdges<'_>, triangle: u32, goal: &Goal) -> f64 {
    let half = first_of(triangle);
    let surface = mesh.surface(half);
    let corners = mesh.corners(triangle);
    let estimate = judge::estimate(surface, mesh.region(half), corners);
    /// The surface over a triangle is larger than the triangle. Tunes counts only.
    const CURVED: f64 = 1.05;
    let for_distance = (estimate / goal.aim_on(mesh.surface_id(half))).sqrt();
    let for_angle = goal.angle.map_or(0.0, |angle| {
        let [a, b, c] = corners.map(|corner| surface.gradient(corner));
        let turn = elementary::angle_between(a, b)
            .max(elementary::angle_between(b, c))
            .max(elementary::angle_between(c, a));
        turn / angle
    });
    (CURVED * for_distance).max(for_angle).max(1.0)
}

fn whole(rows: f64) -> u32 {
    (rows - 1e-3).ceil().max(1.0) as u32
}
