//! The true boundary: how far is it from a point, and which way is outward
//! there? Answered from the program's surfaces and formula alone, whatever
//! made the point.

use csg::Program;
use csg::program::{Cell, Pruner};
use glam::{DMat3, DVec3};

/// The boundary of a program's solid.
pub struct Truth<'a> {
    program: &'a Program,
    /// The solid lies well within the cube from -half to half.
    half: f64,
    /// Distance up to which a point counts as on a surface.
    contact: f64,
}

/// The boundary near a point.
#[derive(Clone, Debug)]
pub struct Nearest {
    /// How far it is.
    pub distance: f64,
    /// Outward unit normals of the surfaces that bound the solid there: more
    /// than one on an edge or at a corner.
    pub normals: Vec<DVec3>,
}

/// Surfaces tried about one point: of more, the farther ones are left out.
const CANDIDATES: usize = 8;
/// A box with so few surfaces, or so few points, is not divided further.
const FEW_SURFACES: usize = 6;
const FEW_POINTS: usize = 16;

impl<'a> Truth<'a> {
    pub fn new(program: &'a Program, half: f64) -> Self {
        let contact = 1e-9 * half;
        Self {
            program,
            half,
            contact,
        }
    }

    /// Calls `visit` with each point's index and the boundary nearest to it,
    /// or `None` where none was found; in any order, from many threads.
    ///
    /// Most points should be nearer than `reach`: that is how far around them
    /// is looked first.
    pub fn visit(
        &self,
        points: &[DVec3],
        reach: f64,
        visit: &(dyn Fn(usize, Option<&Nearest>) + Sync),
    ) {
        let mut pending: Vec<u32> = (0..points.len() as u32).collect();
        let mut reach = reach.min(self.half);
        while !pending.is_empty() {
            let last = reach > 4.0 * self.half;
            let search = Search {
                truth: self,
                points,
                reach,
                last,
                visit,
            };
            let root = self.program.root_cell();
            pending = search.divide(&root, DVec3::ZERO, self.half, pending);
            reach *= 4.0;
        }
    }

    /// The boundary nearest to `p` among the surfaces of `cell`.
    fn nearest(&self, cell: &Cell, p: DVec3) -> Option<Nearest> {
        let surfaces = self.program.surfaces();
        let mut near: Vec<(f64, u32)> = (0..cell.surfaces.len() as u32)
            .map(|local| {
                let s = &surfaces[cell.surfaces[local as usize] as usize];
                let distance = s.value(p).abs() / s.gradient(p).length();
                (distance, local)
            })
            .filter(|(distance, _)| distance.is_finite())
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(CANDIDATES);
        let mut best: Option<Nearest> = None;
        let consider = |on: &[u32], best: &mut Option<Nearest>| {
            let Some(q) = self.project(cell, on, p) else {
                return;
            };
            let distance = q.distance(p);
            if best.as_ref().is_none_or(|b| distance < b.distance) {
                let normals = self.normals(cell, on, q);
                if !normals.is_empty() {
                    *best = Some(Nearest { distance, normals });
                }
            }
        };
        // The nearest surface of all is the answer where it bounds the solid;
        // otherwise edges and corners may be nearer than the next that does.
        for (i, &(_, a)) in near.iter().enumerate() {
            consider(&[a], &mut best);
            if i == 0 && best.is_some() {
                break;
            }
        }
        let closer = |best: &Option<Nearest>, local: (f64, u32)| {
            // First-order distances may be off where surfaces bend.
            best.as_ref().is_none_or(|b| local.0 < 2.0 * b.distance)
        };
        if best.as_ref().is_none_or(|b| near[0].0 < 0.999 * b.distance) {
            for i in 0..near.len() {
                for j in 0..i {
                    if closer(&best, near[i]) && closer(&best, near[j]) {
                        consider(&[near[i].1, near[j].1], &mut best);
                    }
                    for k in 0..j {
                        if closer(&best, near[i]) && closer(&best, near[k]) {
                            consider(&[near[i].1, near[j].1, near[k].1], &mut best);
                        }
                    }
                }
            }
        }
        best
    }

    /// The point on one, two or three surfaces that Newton's steps of least
    /// length lead to: for planes the nearest, for spheres and circular
    /// cylinders too as long as they are alone.
    fn project(&self, cell: &Cell, on: &[u32], p: DVec3) -> Option<DVec3> {
        let all = self.program.surfaces();
        let surface = |i: usize| &all[cell.surfaces[on[i] as usize] as usize];
        let mut q = p;
        for _ in 0..30 {
            let step = match on.len() {
                1 => {
                    let g = surface(0).gradient(q);
                    g * (surface(0).value(q) / g.length_squared())
                }
                2 => {
                    let (f, g) = (surface(0).value(q), surface(1).value(q));
                    let (df, dg) = (surface(0).gradient(q), surface(1).gradient(q));
                    let across = df.cross(dg);
                    // The step lies in the plane of both gradients.
                    (dg.cross(across) * f + across.cross(df) * g) / across.length_squared()
                }
                _ => {
                    let values = DVec3::from_array([0, 1, 2].map(|i| surface(i).value(q)));
                    let rows = DMat3::from_cols(
                        surface(0).gradient(q),
                        surface(1).gradient(q),
                        surface(2).gradient(q),
                    );
                    rows.transpose().inverse() * values
                }
            };
            q -= step;
            if !q.is_finite() || q.distance(p) > 8.0 * self.half {
                return None;
            }
            if step.length() <= 1e-15 * self.half {
                return Some(q);
            }
        }
        let misses = on.iter().any(|&local| {
            let s = &all[cell.surfaces[local as usize] as usize];
            s.value(q).abs() > self.contact * s.gradient(q).length()
        });
        (!misses).then_some(q)
    }

    /// Outward normals at `q` of those surfaces in `on` across which the solid
    /// changes there.
    fn normals(&self, cell: &Cell, on: &[u32], q: DVec3) -> Vec<DVec3> {
        let all = self.program.surfaces();
        let mut inside = Vec::with_capacity(cell.surfaces.len());
        // Surfaces through q may be on either side of it: all ways are tried.
        let mut undecided: Vec<usize> = on.iter().map(|&i| i as usize).collect();
        for (local, &id) in cell.surfaces.iter().enumerate() {
            let s = &all[id as usize];
            let value = s.value(q);
            inside.push(value <= 0.0);
            let touches = value.abs() <= self.contact * s.gradient(q).length();
            if touches && !undecided.contains(&local) && undecided.len() < 6 {
                undecided.push(local);
            }
        }
        let mut normals = Vec::new();
        for (index, &local) in on.iter().enumerate() {
            let gradient = all[cell.surfaces[local as usize] as usize].gradient(q);
            let (mut leaves, mut enters) = (false, false);
            for ways in 0..1_u32 << undecided.len() {
                if ways >> index & 1 == 1 {
                    continue;
                }
                for (bit, &local) in undecided.iter().enumerate() {
                    inside[local] = ways >> bit & 1 == 1;
                }
                let outer = cell.formula.evaluate(&inside);
                inside[local as usize] = true;
                let inner = cell.formula.evaluate(&inside);
                leaves |= inner && !outer;
                enters |= outer && !inner;
            }
            if leaves {
                normals.push(gradient.normalize());
            }
            if enters {
                normals.push(-gradient.normalize());
            }
        }
        normals
    }
}

/// One sweep over the points.
struct Search<'a> {
    truth: &'a Truth<'a>,
    points: &'a [DVec3],
    reach: f64,
    last: bool,
    visit: &'a (dyn Fn(usize, Option<&Nearest>) + Sync),
}

impl Search<'_> {
    /// Settles the points of a box, and returns those that need a wider look.
    fn divide(&self, cell: &Cell, center: DVec3, half: f64, mut indices: Vec<u32>) -> Vec<u32> {
        let few = cell.surfaces.len() <= FEW_SURFACES || indices.len() <= FEW_POINTS;
        if few || half < self.reach {
            indices.retain(|&i| {
                let found = self.truth.nearest(cell, self.points[i as usize]);
                let settled = found.as_ref().is_some_and(|f| f.distance <= self.reach);
                if settled || self.last {
                    (self.visit)(i as usize, found.as_ref());
                }
                !settled && !self.last
            });
            return indices;
        }
        let mut octants: [Vec<u32>; 8] = Default::default();
        for i in indices {
            let above = self.points[i as usize].cmpge(center);
            octants[above.bitmask() as usize].push(i);
        }
        let mut remaining: [Vec<u32>; 8] = Default::default();
        rayon::scope(|scope| {
            let tasks = octants.into_iter().zip(&mut remaining).enumerate();
            for (octant, (indices, remaining)) in tasks {
                if indices.is_empty() {
                    continue;
                }
                scope.spawn(move |_| {
                    let side = |bit: usize| if octant >> bit & 1 == 1 { 0.5 } else { -0.5 };
                    let center = center + DVec3::new(side(0), side(1), side(2)) * half;
                    let (mut pruned, mut pruner) = (Cell::default(), Pruner::default());
                    let surfaces = self.truth.program.surfaces();
                    let around = DVec3::splat(0.5 * half + self.reach);
                    cell.prune_into(surfaces, center, around, &mut pruner, &mut pruned);
                    *remaining = self.divide(&pruned, center, 0.5 * half, indices);
                });
            }
        });
        remaining.concat()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use csg::Solid;

    use super::*;

    fn distances(solid: &Solid, points: &[DVec3]) -> Vec<(f64, usize)> {
        let program = Program::lower(solid).expect("valid");
        let found = Mutex::new(vec![(f64::NAN, 0); points.len()]);
        Truth::new(&program, 1.6).visit(points, 0.01, &|i, nearest| {
            let nearest = nearest.expect("some boundary");
            found.lock().expect("no panic")[i] = (nearest.distance, nearest.normals.len());
        });
        found.into_inner().expect("no panic")
    }

    #[test]
    fn distances_to_faces_edges_and_corners_of_a_box() {
        let points = [
            DVec3::new(0.3, 0.2, 0.9),
            DVec3::new(0.3, 1.3, 1.4),
            DVec3::new(1.1, 1.2, -1.2),
            DVec3::new(1.0, 1.0, 1.0),
        ];
        let found = distances(&Solid::cube(2.0), &points);
        let expected = [(0.1, 1), (0.5, 2), (0.3, 3), (0.0, 1)];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found.0 - expected.0).abs() < 1e-12, "{found:?}");
            assert_eq!(found.1, expected.1);
        }
    }

    #[test]
    fn surfaces_buried_in_the_solid_do_not_count() {
        let two = Solid::cube(2.0) | Solid::sphere(0.5).translate([0.9, 0.0, 0.0]);
        // The first on the sphere, but inside the cube, whose face is nearer.
        let points = [DVec3::new(0.9, 0.0, 0.5), DVec3::new(1.5, 0.0, 0.0)];
        for (distance, normals) in distances(&two, &points) {
            assert!((distance - 0.1).abs() < 1e-12, "{distance}");
            assert_eq!(normals, 1);
        }
    }
}
