//! Spheres that nothing meets: each is a face of the solid as a whole, or none of it, and nothing
//! about it needs to be found.
//!
//! Where all other surfaces keep to one side of a ball, the formula depends on the sphere alone there: its
//! value inside and outside says whether it bounds the solid. Then space inside is taken to be like that
//! around, so that the solid goes on without it. Smaller ones are asked first, as that may leave
//! those around them alone.
//!
//! n log n for n spheres, and n² / 64 steps for the formula's values.

use glam::DVec3;

use super::scene::Scene;
use crate::mesh::Mesh;
use crate::mesh::box_tree::{self, BoxTree, Boxed, along_curve};
use crate::program::{Cell, Formula, Kind, Program, Pruner, Surface, SurfaceId};
use crate::surface::{Bounds, Side, half_space_bounds};
use crate::task::Task;

/// A sphere among others.
#[derive(Clone, Copy)]
struct Ball {
    id: u32,
    center: DVec3,
    radius: f64,
}

/// A sphere that is a face of the solid.
struct Face {
    ball: Ball,
    look: u32,
    /// Whether the solid is within it.
    is_body: bool,
}

/// What is left of a solid without the spheres that nothing meets, and these as far as they bound it.
pub(super) struct Alone {
    pub rest: Cell,
    faces: Vec<Face>,
}

/// Words of values that are computed at most, and pairs of balls and surfaces without an end: below a
/// second's work. Tunes speed only.
const MOST_WORK: usize = 1 << 28;

impl Alone {
    /// None if all spheres meet something.
    pub fn of(task: &Task<'_>, scene: &Scene<'_>) -> Option<Self> {
        let program = task.program;
        if program.is_deep() {
            return None;
        }
        let formula = program.formula();
        let look_of = look_of(formula, scene);
        let mut balls = Vec::new();
        let mut ends = Vec::new();
        let mut endless = Vec::new();
        for (surface, id) in scene.surfaces.iter().zip(0u32..) {
            match ends_of(surface) {
                Some((bounds, beyond)) => {
                    ends.push((id, bounds, beyond));
                    balls.extend(Ball::of(id, surface));
                }
                None => endless.push(id),
            }
        }
        let work = (balls.len() / 64 + 1) * formula.operands.len() + balls.len() * endless.len();
        if balls.is_empty() || work > MOST_WORK {
            return None;
        }
        balls.sort_by(|a, b| a.radius.total_cmp(&b.radius));
        let mut search = Search::new(scene, &ends, endless, &balls);
        let mut alone: Vec<(Ball, Vec<(u32, Side)>)> = Vec::new();
        for &ball in &balls {
            if look_of[ball.id as usize].is_some()
                && let Some(sides) = search.sides_around(&ball)
            {
                search.is_out[ball.id as usize] = true;
                alone.push((ball, sides));
            }
        }
        let mut faces = Vec::new();
        let values = values(formula, &search.usual, &alone);
        for ((ball, _), values) in alone.iter().zip(values) {
            if values[0] != values[1] {
                faces.push(Face {
                    ball: *ball,
                    look: look_of[ball.id as usize].unwrap_or_default(),
                    is_body: values[0],
                });
            }
        }
        let rest = without(program, &search);
        (!alone.is_empty()).then_some(Self { rest, faces })
    }

    /// Puts an octahedron into a mesh for each sphere that bounds the solid.
    pub fn add_to(&self, mesh: &mut Mesh, task: &Task<'_>) {
        for Face {
            ball,
            look,
            is_body,
        } in &self.faces
        {
            let entry = mesh.surfaces.len() as u32;
            let surface = task.mesh_surface(SurfaceId(ball.id), *look);
            mesh.surfaces.push(surface);
            let first = mesh.positions.len() as u32;
            for axis in DVec3::AXES {
                let along = ball.radius * axis;
                mesh.positions
                    .extend([ball.center + along, ball.center - along]);
            }
            for octant in 0..8u32 {
                let [x, y, z] = [0, 1, 2].map(|axis| first + 2 * axis + (octant >> axis & 1));
                let is_turned = octant.count_ones() % 2 == 1;
                let triangle = if is_turned == *is_body {
                    [x, z, y]
                } else {
                    [x, y, z]
                };
                mesh.triangles.push(triangle);
                mesh.triangle_surfaces.push(entry);
            }
        }
    }
}

impl Ball {
    fn of(id: u32, surface: &Surface) -> Option<Self> {
        if surface.kind != Kind::Ellipsoid {
            return None;
        }
        let form = surface.standard_form();
        Some(Self {
            id,
            center: form.center,
            radius: form.radius()?,
        })
    }

    /// Whether no point of it is within another one, or nearer than a margin.
    fn is_outside(&self, other: &Self, margin: f64) -> bool {
        self.center.distance(other.center) >= self.radius + other.radius + margin
    }
}

/// For each surface what it looks like; none if it has several looks.
fn look_of(formula: &Formula, scene: &Scene<'_>) -> Vec<Option<u32>> {
    let count = scene.surfaces.len();
    let mut first: Vec<Option<u32>> = vec![None; count];
    let mut is_mixed = vec![false; count];
    for literal in formula.literals() {
        let look = scene.looks[literal.origin as usize];
        let surface = literal.surface as usize;
        is_mixed[surface] |= *first[surface].get_or_insert(look) != look;
    }
    for (first, is_mixed) in first.iter_mut().zip(is_mixed) {
        first.take_if(|_| is_mixed);
    }
    first
}

/// A box around a surface, and on which side of it all is that is not in the box; none if there
/// is no end of it, or none that is easily told.
fn ends_of(surface: &Surface) -> Option<(Bounds, Side)> {
    let sides = [
        (half_space_bounds(surface), Side::Outside),
        (half_space_bounds(&surface.negated()), Side::Inside),
    ];
    let mut ends = sides.into_iter();
    ends.find(|(bounds, _)| bounds.min.is_finite() && bounds.max.is_finite())
}

/// What else is near a ball.
struct Search<'a> {
    scene: &'a Scene<'a>,
    endless: Vec<u32>,
    tree: BoxTree,
    ball_of: Vec<Option<Ball>>,
    /// Of each surface the side on which nearly all is.
    usual: Vec<Side>,
    /// What was found to be alone.
    is_out: Vec<bool>,
}

impl<'a> Search<'a> {
    fn new(
        scene: &'a Scene<'a>,
        ends: &[(u32, Bounds, Side)],
        endless: Vec<u32>,
        balls: &[Ball],
    ) -> Self {
        let boxed = |k: usize| box_tree::Bounds {
            low: ends[k].1.min,
            high: ends[k].1.max,
        };
        let order = along_curve((0..ends.len()).map(boxed));
        let entries = order.into_iter().map(|k| Boxed {
            bounds: boxed(k as usize),
            index: ends[k as usize].0,
            sheet: k,
            stands: 0,
        });
        let count = scene.surfaces.len();
        let mut usual = vec![Side::Crossing; count];
        for &(id, _, beyond) in ends {
            usual[id as usize] = beyond;
        }
        let mut ball_of = vec![None; count];
        for ball in balls {
            ball_of[ball.id as usize] = Some(*ball);
        }
        Self {
            scene,
            endless,
            tree: BoxTree::new(entries.collect()),
            ball_of,
            usual,
            is_out: vec![false; count],
        }
    }

    /// On which sides of other surfaces a ball is, as far as that is not the usual one; none if one
    /// meets it, nearly touches it, or is within it.
    fn sides_around(&self, ball: &Ball) -> Option<Vec<(u32, Side)>> {
        // Nearer surfaces may be told to touch (`TOUCH`).
        let margin = self.scene.near + (self.scene.touch * self.scene.reach).sqrt();
        let half = DVec3::splat(ball.radius + margin);
        let mut near = self.endless.clone();
        let bounds = box_tree::Bounds {
            low: ball.center - half,
            high: ball.center + half,
        };
        self.tree.overlapping(&bounds, &mut |id| near.push(id));
        let mut sides = Vec::new();
        for id in near {
            if id == ball.id || self.is_out[id as usize] {
                continue;
            }
            let side = match self.ball_of[id as usize] {
                Some(other) if other.is_outside(ball, margin) => self.usual[id as usize],
                _ => self.scene.surfaces[id as usize].side_of_box(ball.center, half),
            };
            if side == Side::Crossing {
                return None;
            }
            if side != self.usual[id as usize] {
                sides.push((id, side));
            }
        }
        Some(sides)
    }
}

/// Of each ball the formula's value inside and outside, where nothing else changes.
fn values(formula: &Formula, usual: &[Side], balls: &[(Ball, Vec<(u32, Side)>)]) -> Vec<[bool; 2]> {
    let word = |side: Side| if side == Side::Inside { u64::MAX } else { 0 };
    let mut inside: Vec<u64> = usual.iter().map(|&side| word(side)).collect();
    let mut gates = Vec::new();
    let mut values = Vec::with_capacity(balls.len());
    for some in balls.chunks(64) {
        // Everything that is not usual is put back after it was asked for.
        for ((_, sides), bit) in some.iter().zip(0..) {
            for &(id, side) in sides {
                let word = &mut inside[id as usize];
                *word = *word & !(1 << bit) | u64::from(side == Side::Inside) << bit;
            }
        }
        let [within, without] = [true, false].map(|is_within| {
            for ((ball, _), bit) in some.iter().zip(0..) {
                let is_inside = (usual[ball.id as usize] == Side::Inside) != is_within;
                let word = &mut inside[ball.id as usize];
                *word = *word & !(1 << bit) | u64::from(is_inside) << bit;
            }
            formula.evaluate_words(&mut gates, |_, surface| inside[surface as usize])
        });
        values.extend((0..some.len()).map(|bit| [within, without].map(|w| w >> bit & 1 == 1)));
        for (ball, sides) in some {
            let others = sides.iter().map(|(id, _)| *id);
            for id in others.chain([ball.id]) {
                inside[id as usize] = word(usual[id as usize]);
            }
        }
    }
    values
}

/// The program with space inside of what is out taken to be like that around.
fn without(program: &Program, search: &Search<'_>) -> Cell {
    let ids = search.is_out.iter().zip(&search.usual);
    let sides = ids.map(|(&is_out, &usual)| if is_out { usual } else { Side::Crossing });
    let sides: Vec<Side> = sides.collect();
    let mut rest = Cell::default();
    let mut pruner = Pruner::literal_by_literal();
    program
        .root_cell()
        .restrict_into(&sides, &mut pruner, &mut rest);
    rest
}
