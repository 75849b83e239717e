//! Faces of polyhedra that nothing comes near: only the rest is meshed, and they are put
//! beside it.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::Run;
use crate::arrangement;
use crate::error::Error;
use crate::limits::Demand;
use crate::mesh::{Mesh, MeshSurface};
use crate::numeric::Welder;
use crate::program::{Apart, Bounds, Program, SurfaceId, Uncut};
use crate::report::Report;
use crate::task::mesh_surface;

impl Run<'_> {
    /// The mesh of a solid with many uncut faces; none if there are few, or if the rest does
    /// not fit them.
    pub(super) fn with_uncut(&self, report: &mut Report) -> Result<Option<Mesh>, Error> {
        if !self.mesher.is_by_boundary() {
            return Ok(None);
        }
        let Some(Apart { uncut, rest }) = self.program.apart() else {
            return Ok(None);
        };
        let rest = Run {
            mesher: self.mesher,
            program: rest,
            smallest: self.smallest,
            goal: self.goal.clone(),
            start: self.start,
            control: self.control.again(Demand::ExactBoundary),
        };
        let mut attempt = report.clone();
        let mesh = rest.shape(&mut attempt)?;
        if !["polyhedral", "boundary"].contains(&attempt.method) {
            return Ok(None);
        }
        let is_empty = mesh.triangles.is_empty();
        let Some(mesh) = joined(&mesh, uncut, self.program) else {
            return Ok(None);
        };
        self.check_size(&mesh, &self.control)?;
        let (own, farthest) = deviation(uncut, self.program);
        // (Of nothing it is not told.)
        let others = attempt.deviation.or(is_empty.then_some(0.0));
        attempt.deviation = others.map(|others| others.max(own));
        if others.is_some_and(|others| own >= others) {
            attempt.farthest = Some(farthest);
        }
        attempt.bounds = mesh.bounds().map(|(min, max)| Bounds { min, max });
        *report = attempt;
        Ok(Some(mesh))
    }
}

/// A mesh of what is left of a solid beside its uncut faces, and these; none if they do not
/// fit.
fn joined(rest: &Mesh, uncut: &Uncut, program: &Program) -> Option<Mesh> {
    const NONE: u32 = u32::MAX;
    let mut mesh = Mesh {
        triangles: Vec::with_capacity(uncut.triangles.len()),
        ..Mesh::default()
    };
    // What of the rest is meant.
    let mut entries = vec![NONE; rest.surfaces.len()];
    for (entry, surface) in entries.iter_mut().zip(&rest.surfaces) {
        if let Some(id) = uncut.meant[surface.surface as usize] {
            *entry = mesh.surfaces.len() as u32;
            mesh.surfaces.push(MeshSurface {
                surface: id,
                ..surface.clone()
            });
        }
    }
    let mut vertices = vec![NONE; rest.positions.len()];
    let mut open: FxHashSet<[u32; 2]> = FxHashSet::default();
    for (triangle, &entry) in rest.triangles.iter().zip(&rest.triangle_surfaces) {
        let entry = entries[entry as usize];
        if entry == NONE {
            continue;
        }
        let corners = triangle.map(|vertex| {
            let known = &mut vertices[vertex as usize];
            if *known == NONE {
                *known = mesh.positions.len() as u32;
                mesh.positions.push(rest.positions[vertex as usize]);
            }
            *known
        });
        for [from, to] in sides(corners) {
            if !open.remove(&[to, from]) {
                open.insert([from, to]);
            }
        }
        mesh.triangles.push(corners);
        mesh.triangle_surfaces.push(entry);
    }
    // Where it ends are vertices that were given.
    let mut welder = Welder::new(uncut.margin);
    let mut ends: Vec<u32> = open.iter().flatten().copied().collect();
    ends.sort_unstable();
    ends.dedup();
    for &vertex in &ends {
        welder.number(mesh.positions[vertex as usize]);
    }
    if welder.points.len() != ends.len() {
        return None;
    }
    let mut numbers = vec![NONE; uncut.vertices.len()];
    for (corners, rims) in uncut.triangles.iter().zip(&uncut.rims) {
        for (side, _) in sides(*corners)
            .into_iter()
            .zip(rims)
            .filter(|(_, rim)| **rim)
        {
            let side = side.map(|vertex| {
                let number = &mut numbers[vertex as usize];
                if *number == NONE {
                    let at = uncut.vertices[vertex as usize];
                    let end = ends.get(welder.number(at) as usize);
                    *number = end.map_or(NONE, |&end| {
                        mesh.positions[end as usize] = at;
                        end
                    });
                }
                *number
            });
            if !open.remove(&[side[1], side[0]]) {
                return None;
            }
        }
    }
    if !open.is_empty() {
        return None;
    }
    for (number, &at) in numbers.iter_mut().zip(&uncut.vertices) {
        if *number == NONE {
            *number = mesh.positions.len() as u32;
            mesh.positions.push(at);
        }
    }
    let triangles = uncut.triangles.iter();
    let triangles = triangles.map(|corners| corners.map(|vertex| numbers[vertex as usize]));
    mesh.triangles.extend(triangles);
    let mut entry_of: FxHashMap<(u32, u32), u32> = FxHashMap::default();
    // Of those that look alike the first stands for all, as in the rest.
    let looks = arrangement::looks(program.origins());
    for &(surface, primitive) in &uncut.faces {
        let primitive = looks[primitive as usize];
        let next = mesh.surfaces.len() as u32;
        let entry = *entry_of.entry((surface, primitive)).or_insert(next);
        if entry == next {
            mesh.surfaces
                .push(mesh_surface(program, SurfaceId(surface), primitive));
        }
        mesh.triangle_surfaces.push(entry);
    }
    Some(mesh)
}

/// The largest distance of a vertex from the surface of an uncut face, and where.
fn deviation(uncut: &Uncut, program: &Program) -> (f64, DVec3) {
    let mut farthest = (0.0, DVec3::ZERO);
    for (corners, &(surface, _)) in uncut.triangles.iter().zip(&uncut.faces) {
        let plane = &program.carriers()[surface as usize];
        for &corner in corners {
            let point = uncut.vertices[corner as usize];
            let distance = plane.value(point).abs();
            if distance > farthest.0 {
                farthest = (distance, point);
            }
        }
    }
    farthest
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::f64::consts::TAU;

    use glam::{DAffine3, DQuat};

    use super::*;
    use crate::clock::Instant;
    use crate::elementary;
    use crate::mesher::Mesher;
    use crate::random::Random;
    use crate::solid::Solid;
    use crate::sweeps::one_in;

    fn number(random: &mut Random, from: f64, to: f64) -> f64 {
        from + (to - from) * random.unit()
    }

    /// A ring with bumps, of some hundred triangles.
    fn ring(random: &mut Random) -> Solid {
        let [along, around] = [12, 8].map(|least| least + random.below(8) as u32);
        let bump = number(random, 0.0, 0.1);
        let mut vertices = Vec::new();
        for u in 0..along {
            for v in 0..around {
                let [a, b] =
                    [(u, along), (v, around)].map(|(k, n)| TAU * f64::from(k) / f64::from(n));
                let [wave, other] = [5.0 * a, 3.0 * b].map(|angle| elementary::direction(angle).x);
                let thick = 0.4 * (1.0 + bump * wave * other);
                let [a, b] = [a, b].map(elementary::direction);
                let away = 1.0 + thick * b.x;
                vertices.push((away * a).extend(thick * b.y));
            }
        }
        let mut faces = Vec::new();
        for u in 0..along {
            for v in 0..around {
                let at = |u: u32, v: u32| (u % along) * around + v % around;
                let [a, b, c, d] = [at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)];
                faces.extend([[a, b, c], [a, c, d]]);
            }
        }
        Solid::polyhedron(vertices, faces)
    }

    fn map(random: &mut Random, is_round: bool) -> DAffine3 {
        let unit = |random: &mut Random| number(random, -1.0, 1.0);
        let at = DVec3::from_array([(); 3].map(|()| 1.6 * unit(random)));
        if is_round {
            let at = (4.0 * at).round() / 4.0;
            let mirror = DVec3::new(1.0, 1.0, if random.below(2) == 0 { 1.0 } else { -1.0 });
            return DAffine3::from_scale_rotation_translation(mirror, DQuat::IDENTITY, at);
        }
        let [x, y, z, w] = [(); 4].map(|()| unit(random));
        let turn = DQuat::from_xyzw(x, y, z, w).normalize();
        let scale = DVec3::splat(number(random, 0.5, 1.5));
        DAffine3::from_scale_rotation_translation(scale, turn, at)
    }

    fn part(random: &mut Random, first: &Solid) -> Solid {
        match random.below(8) {
            0 | 1 => ring(random),
            2 | 3 => first.clone(),
            4 => Solid::prism(
                (0..60).map(|k| 0.7 * elementary::direction(TAU * f64::from(k) / 60.0)),
                -0.5..0.9,
            ),
            5 => Solid::cuboid([1.1, 0.8, 1.3]),
            6 => Solid::cylinder(0.3, -3.0..3.0),
            _ => Solid::sphere(0.6),
        }
    }

    /// Solids with polyhedra of many faces, some of them touching each other, come out as they
    /// do where all of these are evaluated.
    #[test]
    fn uncut_faces_fit_the_rest() {
        let (mut tried, mut joined) = (0, 0);
        for seed in (0..80).step_by(one_in(7)) {
            tried += 1;
            let mut random = Random(seed);
            let is_round = seed % 3 == 0;
            let first = ring(&mut random);
            let mut solid = first.clone();
            for _ in 0..=random.below(3) {
                let place = map(&mut random, is_round);
                let other = part(&mut random, &first).affine(place);
                solid = match random.below(4) {
                    0 | 1 => solid - other,
                    2 => solid | other,
                    _ => other - solid,
                };
            }
            let program = Program::lower(&solid).expect("valid");
            let mesher = Mesher::new().tolerance(0.02).check(true);
            let meshed = mesher.mesh(&program).expect("a mesh");
            let whole = mesher.mesh(&program.expanded()).expect("a mesh");
            let (found, truth) = (&meshed.mesh, &whole.mesh);
            let run = Run::new(&mesher, &program, Instant::now()).expect("valid");
            let fits = run.with_uncut(&mut Report::default()).expect("a mesh");
            joined += usize::from(fits.is_some());
            assert!(
                found.check().is_closed() && found.check().is_manifold(),
                "{seed}"
            );
            let complaints = [&meshed, &whole].map(|meshed| meshed.report.complaints());
            assert_eq!(complaints[0], complaints[1], "{seed}");
            let topology =
                |mesh: &Mesh| (mesh.components().count, mesh.check().euler_characteristic());
            assert_eq!(topology(found), topology(truth), "{seed}");
            let primitives = |mesh: &Mesh| -> BTreeSet<u32> {
                mesh.surfaces.iter().map(|entry| entry.primitive).collect()
            };
            assert_eq!(primitives(found), primitives(truth), "{seed}");
            let off = (found.volume() - truth.volume()).abs();
            let is_flat = program.is_polyhedral();
            let near = if is_flat { 1e-12 } else { 0.02 * truth.area() };
            assert!(
                off <= near,
                "{seed}: {} for {}",
                found.volume(),
                truth.volume()
            );
        }
        assert!(joined + 4 >= tried, "{joined} of {tried}");
    }
}
