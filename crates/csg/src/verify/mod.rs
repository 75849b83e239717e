//! A finished mesh held against the program it was made from, by nothing but the roots
//! of surfaces along rays and the formula between them: whatever went wrong before, a
//! part that is missing, inside out, elsewhere or there twice is seen.

mod crossings;
mod places;
mod proof;
mod rays;
mod spans;
mod spread;

use glam::DVec3;

use self::crossings::Crossing;
use self::proof::Proof;
use self::rays::Lattice;
use self::spans::Span;
use crate::mesh::Mesh;
use crate::numeric::tolerance::NEAR;
use crate::program::{Bounds, Cell, Program, Pruner};

/// What is reported of each place.
pub(crate) const DIFFERENCE: &str = "place where the mesh is not the solid's boundary";

/// Where a mesh is not the boundary of its program's solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Differences {
    /// Places that are in the solid or in the mesh, not in both, each farther than the
    /// tolerance from the solid's boundary; and places of the boundary that are farther
    /// from the mesh.
    pub places: Vec<DVec3>,
    /// Their share of the length of rays in the solid or in the mesh.
    pub share: f64,
}

/// What a mesh may be off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerances {
    /// How far it may be from the solid's boundary.
    pub tolerance: f64,
    /// Walls and gaps thinner than this may be lost.
    pub unseen: f64,
}

/// Holds a mesh that is to be within a tolerance of the solid's boundary against some
/// dozen to some hundred rays, as many as cost a few percent of making it.
///
/// It gives no false alarm: a piece of a ray counts only if the formula has one value on
/// the whole cube about its middle with sides of twice the tolerance.
pub(crate) fn differences(
    program: &Program,
    mesh: &Mesh,
    bounds: &Bounds,
    Tolerances { tolerance, unseen }: Tolerances,
) -> Differences {
    let mut found = Differences::default();
    let surfaces = match program.outline() {
        Some(outline) => outline.cell().surfaces.len(),
        None => program.surfaces().len(),
    };
    let lattice = Lattice::new(bounds, mesh.triangles.len(), surfaces);
    let crossings = crossings::along(mesh, &lattice);
    let spans = spans::along(program, &lattice, bounds);
    let mut proof = Proof {
        program,
        tolerance,
        unseen,
        shortest: 2.0 * tolerance + NEAR * bounds.size().max_element(),
        root: None,
        pruner: Pruner::default(),
        pruned: Cell::default(),
    };
    let (mut length, mut wrong) = (0.0, 0.0);
    let (mut crossings, mut spans) = (&crossings[..], &spans[..]);
    for number in 0..lattice.len() {
        let ray = lattice.ray(number);
        let of_mesh = split_off(&mut crossings, |crossing| crossing.ray as usize == number);
        let of_solid = split_off(&mut spans, |span| span.ray as usize == number);
        length += of_solid
            .iter()
            .map(|span| span.ends[1] - span.ends[0])
            .sum::<f64>();
        let mut check = |low: f64, high: f64, is_inside: bool| {
            let place = ray.at(low.midpoint(high));
            if high - low > proof.shortest && proof.is_all(place, is_inside) {
                found.places.push(place);
                wrong += high - low;
                length += if is_inside { 0.0 } else { high - low };
            }
        };
        compare(of_solid, of_mesh, &mut check);
    }
    if wrong > 0.0 {
        found.share = wrong / length;
    }
    found.places.extend(places::wrong(&mut proof, mesh, bounds));
    found
}

/// The first of a list for which something holds.
fn split_off<'a, T>(list: &mut &'a [T], test: impl Fn(&T) -> bool) -> &'a [T] {
    let (first, rest) = list.split_at(list.partition_point(test));
    *list = rest;
    first
}

/// Hands on the pieces of a ray that are in the solid and not once in the mesh, or in the
/// mesh and not in the solid. None of a ray that leaves the mesh more or less often than
/// it enters it, because it runs through an edge.
fn compare(of_solid: &[Span], of_mesh: &[Crossing], check: &mut impl FnMut(f64, f64, bool)) {
    if of_mesh.iter().map(|crossing| crossing.step).sum::<i32>() != 0 {
        return;
    }
    let mut solid = of_solid.iter().flat_map(|span| span.ends).peekable();
    let mut mesh = of_mesh.iter().peekable();
    let (mut is_inside, mut times) = (false, 0);
    let mut from: Option<f64> = None;
    while let Some(at) = {
        let next = [solid.peek().copied(), mesh.peek().map(|c| c.at)];
        next.into_iter().flatten().reduce(f64::min)
    } {
        if let Some(low) = from.take() {
            check(low, at, is_inside);
        }
        if solid.next_if(|&t| t == at).is_some() {
            is_inside = !is_inside;
        } else if let Some(crossing) = mesh.next() {
            times += crossing.step;
        }
        from = (times != i32::from(is_inside)).then_some(at);
    }
}

#[cfg(test)]
mod tests;
