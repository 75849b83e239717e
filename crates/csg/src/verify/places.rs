//! Single places at which a mesh is held against its program: one on each surface.

use glam::DVec3;

use super::proof::{BESIDE, Proof, distance};
use super::spans::Tape;
use super::spread::Spread;
use crate::mesh::Mesh;
use crate::program::{Bounds, Program, Surface, line_roots};

/// A place on a surface or a triangle, and the unit normal there.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: DVec3,
    normal: DVec3,
}

/// Places that are tried on each surface without a triangle.
const TRIES: usize = 3;
/// Surfaces that are tried: those without a triangle, and the others.
const MOST: usize = 64;

/// The places on triangles where the boundary is not, or is the other way round, and those
/// on surfaces without a triangle where it is.
pub(super) fn wrong(proof: &mut Proof<'_>, mesh: &Mesh, bounds: &Bounds) -> Vec<DVec3> {
    let program = proof.program;
    let surfaces = program.carriers();
    let mut triangle_of = vec![None; surfaces.len()];
    for (index, &entry) in mesh.triangle_surfaces.iter().enumerate() {
        triangle_of[mesh.surfaces[entry as usize].surface as usize] = Some(index);
    }
    let mut spread = Spread::default();
    let present: Vec<usize> = triangle_of.iter().flatten().copied().collect();
    let step = present.len().div_ceil(MOST).max(1);
    let present = present.into_iter().step_by(step);
    let present: Vec<Place> = present
        .filter_map(|triangle| within(mesh.corners(triangle), &mut spread))
        .collect();
    let absent = surfaces.iter().zip(&triangle_of);
    let absent = absent.filter(|(_, triangle)| triangle.is_none());
    let absent = absent.map(|(surface, _)| surface).take(MOST);
    let absent = absent.flat_map(|surface| {
        let points = [(); TRIES].map(|()| bounds.min + spread.next() * bounds.size());
        points.into_iter().filter_map(|point| on(surface, point))
    });
    let is_within =
        |place: &Place| place.at.cmpge(bounds.min).all() && place.at.cmple(bounds.max).all();
    let absent: Vec<Place> = absent.filter(is_within).collect();
    let tolerance = proof.tolerance;
    let sides = sides(program, &present, BESIDE * tolerance);
    let misplaced = present.iter().zip(sides);
    let misplaced = misplaced.filter(|&(place, sides)| {
        sides != [true, false] && proof.is_misplaced(place.at, place.normal)
    });
    let mut found: Vec<DVec3> = misplaced.map(|(place, _)| place.at).collect();
    let across = 0.5 * tolerance;
    let sides = self::sides(program, &absent, across);
    let missed = absent.iter().zip(sides).filter(|&(place, [inner, outer])| {
        inner != outer
            && distance(mesh, place.at) > tolerance + across
            && proof.is_thick([across, -across].map(|t| place.at + t * place.normal))
    });
    found.extend(missed.map(|(place, _)| place.at));
    found
}

/// Whether points behind places, and before them, are in the solid.
fn sides(program: &Program, places: &[Place], distance: f64) -> Vec<[bool; 2]> {
    let beside = |place: &Place, sign: f64| place.at + sign * distance * place.normal;
    if program.is_deep() {
        let sides = |place: &Place| [-1.0, 1.0].map(|sign| program.contains(beside(place, sign)));
        return places.iter().map(sides).collect();
    }
    let mut tape = Tape::new(program.formula(), program.surfaces().len());
    for (number, place) in (0..).zip(places) {
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let point = beside(place, sign);
            for (index, surface) in (0..).zip(program.surfaces()) {
                tape.set(index, surface.value(point) <= 0.0);
            }
            tape.add(2 * number + side, [0.0, 1.0]);
        }
    }
    let mut sides = vec![[false; 2]; places.len()];
    for span in tape.finish() {
        sides[span.ray as usize / 2][span.ray as usize % 2] = true;
    }
    sides
}

/// A place in a triangle; none without area.
fn within([a, b, c]: [DVec3; 3], spread: &mut Spread) -> Option<Place> {
    let share = DVec3::splat(0.2) + 0.4 * spread.next();
    let normal = (b - a).cross(c - a).try_normalize()?;
    let at = (a * share.x + b * share.y + c * share.z) / share.element_sum();
    Some(Place { at, normal })
}

/// The place of a surface nearest to a point along the gradient there: of planes, spheres
/// and cylinders the nearest of all.
fn on(surface: &Surface, point: DVec3) -> Option<Place> {
    let gradient = surface.gradient(point);
    let direction = gradient.try_normalize()?;
    let (a, b) = (0.5 * surface.curvature_along(direction), gradient.length());
    let roots = line_roots(a, b, surface.value(point))?;
    let nearest = roots
        .into_iter()
        .min_by(|s, t| s.abs().total_cmp(&t.abs()))?;
    let at = point + nearest * direction;
    let normal = surface.gradient(at).try_normalize()?;
    at.is_finite().then_some(Place { at, normal })
}
