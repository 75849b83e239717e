//! A mesh falls apart into closed parts, each of which is brought to the tolerance alone.

use rustc_hash::FxHashMap;

use super::outcome::Outcome;
use super::surfaced::Surfaced;
use crate::numeric::Groups;

/// A mesh, or a part of one, brought to a tolerance.
#[derive(Clone, Debug, Default)]
pub(crate) struct Refined {
    pub surfaced: Surfaced,
    pub outcome: Outcome,
}

/// No part.
const NONE: u32 = u32::MAX;

/// The parts of a mesh, in the order of their first triangles; none if it is one. What has
/// vertices in the same place, where the solid touches itself, is one part. Takes some
/// nanoseconds a triangle, where there are several some ten.
pub(crate) fn parts(surfaced: &Surfaced) -> Option<Vec<Surfaced>> {
    let mut groups = Groups::new(surfaced.positions.len());
    for &[a, b, c] in &surfaced.triangles {
        groups.join([a, b]);
        groups.join([b, c]);
    }
    let first = groups.first(surfaced.triangles.first()?[0]);
    let mut corners = surfaced.triangles.iter().map(|corners| corners[0]);
    if corners.all(|corner| groups.first(corner) == first) {
        return None;
    }
    join_places(surfaced, &mut groups);
    let mut part_of = vec![NONE; surfaced.positions.len()];
    let mut parts: Vec<Surfaced> = Vec::new();
    let mut new_name = vec![NONE; surfaced.positions.len()];
    for (corners, &group) in surfaced.triangles.iter().zip(&surfaced.groups) {
        let root = groups.first(corners[0]);
        let number = &mut part_of[root as usize];
        if *number == NONE {
            *number = parts.len() as u32;
            parts.push(surfaced.empty());
        }
        let part = &mut parts[*number as usize];
        let renamed = corners.map(|corner| {
            let name = &mut new_name[corner as usize];
            if *name == NONE {
                *name = part.positions.len() as u32;
                part.positions.push(surfaced.positions[corner as usize]);
            }
            *name
        });
        part.triangles.push(renamed);
        part.groups.push(group);
    }
    for (&ends, &other) in &surfaced.borders {
        let part = part_of[groups.first(ends[0]) as usize];
        let mut ends = ends.map(|end| new_name[end as usize]);
        ends.sort_unstable();
        if part != NONE && !ends.contains(&NONE) {
            parts[part as usize].borders.insert(ends, other);
        }
    }
    (parts.len() > 1).then_some(parts)
}

/// Joins the groups of vertices that are in the same place.
fn join_places(surfaced: &Surfaced, groups: &mut Groups) {
    let mut first_at = FxHashMap::default();
    first_at.reserve(surfaced.positions.len());
    for (vertex, position) in (0u32..).zip(&surfaced.positions) {
        // Zero has two signs.
        let bits = (position + 0.0).to_array().map(f64::to_bits);
        let first = *first_at.entry(bits).or_insert(vertex);
        groups.join([first, vertex]);
    }
}

/// Parts put together again, one after another.
pub(crate) fn join<'a>(parts: impl Iterator<Item = &'a Surfaced> + Clone) -> Surfaced {
    let Some(first) = parts.clone().next() else {
        return Surfaced::default();
    };
    let mut all = first.empty();
    let count = |size: fn(&Surfaced) -> usize| parts.clone().map(size).sum();
    all.positions.reserve(count(|part| part.positions.len()));
    all.triangles.reserve(count(|part| part.triangles.len()));
    all.groups.reserve(count(|part| part.groups.len()));
    for part in parts {
        let offset = all.positions.len() as u32;
        all.positions.extend_from_slice(&part.positions);
        let moved = |corners: &[u32; 3]| corners.map(|corner| corner + offset);
        all.triangles.extend(part.triangles.iter().map(moved));
        all.groups.extend_from_slice(&part.groups);
        let borders = part.borders.iter();
        let moved = borders.map(|(ends, &other)| (ends.map(|end| end + offset), other));
        all.borders.extend(moved);
    }
    all
}

/// The same of parts that are finished.
pub(crate) fn join_refined(parts: &[&Refined]) -> Refined {
    let mut outcome = Outcome::default();
    for part in parts {
        outcome.add(&part.outcome);
    }
    Refined {
        surfaced: join(parts.iter().map(|part| &part.surfaced)),
        outcome,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tessellate::separate::tests::spheres;
    use glam::DVec3;

    #[test]
    fn parts_are_what_shares_no_vertex_and_no_place() {
        let (two, _) = spheres([1.0, 0.5], DVec3::ZERO, [3, 2]);
        let found = parts(&two).expect("two");
        let counts: Vec<[usize; 2]> = found
            .iter()
            .map(|part| [part.triangles.len(), part.positions.len()])
            .collect();
        assert_eq!(counts, [[72, 38], [32, 18]]);
        let joined = join(found.iter());
        assert_eq!(joined.groups, two.groups);
        let corners = |all: &Surfaced| -> Vec<[DVec3; 3]> {
            let places = |corners: &[u32; 3]| corners.map(|c| all.positions[c as usize]);
            all.triangles.iter().map(places).collect()
        };
        assert_eq!(corners(&joined), corners(&two));
        // The corner of an octahedron touches that of the other one.
        let (touching, _) = spheres([1.0, 0.5], DVec3::new(0.5, 0.0, 0.0), [3, 2]);
        assert!(parts(&touching).is_none());
        assert!(parts(&found[0]).is_none());
        assert!(parts(&Surfaced::default()).is_none());
    }
}
