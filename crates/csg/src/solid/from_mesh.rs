//! Solids from meshes that others made, and what is wrong with these.

use std::fmt;

use glam::DVec3;

use super::polyhedron::same_places;
use super::tree::Solid;
use crate::mesh::{Mesh, MeshCheck, MeshDefect};

/// How many places of crossing or empty faces [`MeshFaults`] keeps.
const PLACES: usize = 8;

/// Why a mesh bounds no solid: the faces, as indices of triangles, and where.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeshFaults {
    /// Open edges, faces that are there twice, faces that look the other way, and
    /// so on, with places.
    pub check: MeshCheck,
    /// How many pairs of triangles run through each other.
    pub crossings: usize,
    /// Some of these pairs, with a corner of the first.
    pub crossing_places: Vec<([u32; 2], DVec3)>,
    /// How many triangles have three corners and no area.
    pub empty_faces: usize,
    /// Some of them, with a corner.
    pub empty_places: Vec<(u32, DVec3)>,
    /// All is closed, but looks inwards.
    pub inside_out: bool,
    /// Of a shell that looks the same way as the one that it lies in, or inwards beside
    /// others, a triangle and a corner. (Looked for where there is nothing else.)
    pub misplaced: Option<(u32, DVec3)>,
    /// Fewer than four triangles.
    pub too_few: bool,
}

impl MeshFaults {
    /// What is wrong with a mesh, and its volume if that can be told.
    fn of(mesh: &Mesh) -> (Self, f64) {
        let check = mesh.check();
        let mut faults = Self {
            crossings: 0,
            crossing_places: Vec::new(),
            empty_faces: 0,
            empty_places: Vec::new(),
            inside_out: false,
            misplaced: None,
            too_few: mesh.triangles.len() < 4,
            check,
        };
        // Without these nothing more can be told.
        if faults.check.out_of_range_triangles > 0 || faults.check.non_finite_vertices > 0 {
            return (faults, f64::NAN);
        }
        for index in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(index);
            let longest = (b - a).length_squared().max((c - a).length_squared());
            // (Triangles that name a vertex twice are in the check.)
            let named = mesh.triangles[index];
            let differ = named[0] != named[1] && named[1] != named[2] && named[2] != named[0];
            if differ && (b - a).cross(c - a).length() <= f64::EPSILON * longest {
                faults.empty_faces += 1;
                if faults.empty_places.len() < PLACES {
                    faults.empty_places.push((index as u32, a));
                }
            }
        }
        let pairs = mesh.self_intersections();
        faults.crossings = pairs.len();
        let first = pairs.iter().take(PLACES);
        faults.crossing_places = first
            .map(|&pair| (pair, mesh.corners(pair[0] as usize)[0]))
            .collect();
        let volume = mesh.volume();
        let closed = faults.check.is_closed() && faults.check.is_oriented();
        faults.inside_out = closed && volume < 0.0;
        let is_one = faults.check.is_manifold() && mesh.components().count < 2;
        if !is_one && faults.bounds_a_solid() {
            let corner = |face: u32| (face, mesh.corners(face as usize)[0]);
            faults.misplaced = mesh.misplaced().map(corner);
        }
        (faults, volume)
    }

    /// Whether the mesh bounds a solid: closed, facing out and nowhere through
    /// itself. Faces without area do no harm, nor do edges or vertices at which
    /// parts of the solid touch.
    #[must_use]
    pub fn bounds_a_solid(&self) -> bool {
        let check = &self.check;
        check.is_closed()
            && check.is_oriented()
            && check.non_finite_vertices == 0
            && check.duplicate_triangles == 0
            && self.crossings == 0
            && !self.inside_out
            && self.misplaced.is_none()
            && !self.too_few
    }
}

impl fmt::Display for MeshFaults {
    /// What is wrong, each with how often and where first.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at = |p: DVec3| format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z);
        let mut said = Vec::new();
        if self.too_few {
            said.push(format!(
                "{} triangles enclose nothing",
                self.check.triangles
            ));
        }
        for defect in MeshDefect::ALL {
            let harmless = matches!(
                defect,
                MeshDefect::UnreferencedVertex
                    | MeshDefect::NonManifoldVertex
                    | MeshDefect::NonManifoldEdge
                    | MeshDefect::DegenerateTriangle
            );
            let count = self.check.count(defect);
            if harmless || count == 0 {
                continue;
            }
            let place = self.check.places.iter().find(|p| p.defect == defect);
            let place = place.map_or(String::new(), |p| match defect {
                MeshDefect::OutOfRangeTriangle => format!(", first triangle {}", p.index),
                _ => format!(", first at {}", at(p.at)),
            });
            said.push(format!("{count} x {defect}{place}"));
        }
        if let Some(&([a, b], place)) = self.crossing_places.first() {
            said.push(format!(
                "{} x triangles through each other, first {a} and {b} at {}",
                self.crossings,
                at(place)
            ));
        }
        if self.inside_out {
            said.push("all triangles face inwards: turn them round".to_owned());
        }
        if let Some((face, place)) = self.misplaced {
            said.push(format!(
                "the shell of triangle {face} at {} looks the same way as the one that it lies in, \
                 or inwards beside others: turn it round if it is a hollow, leave it out if not",
                at(place)
            ));
        }
        if let Some(&(face, place)) = self.empty_places.first() {
            said.push(format!(
                "{} x triangle without area (harmless by itself), first {face} at {}",
                self.empty_faces,
                at(place)
            ));
        }
        if said.is_empty() {
            return f.write_str("the mesh bounds a solid");
        }
        write!(f, "the mesh bounds no solid: {}", said.join("; "))
    }
}

impl std::error::Error for MeshFaults {}

impl Solid {
    /// The solid that a mesh bounds ([`Solid::polyhedron`], which says what that
    /// costs). Of a mesh that is open vertices at one place are one. Names, colours and the unit of the
    /// mesh are not kept.
    ///
    /// # Errors
    /// All that is wrong with the mesh, if it bounds no solid: nothing is mended
    /// silently.
    pub fn from_mesh(mesh: &Mesh) -> Result<Self, Box<MeshFaults>> {
        let (faults, volume) = MeshFaults::of(mesh);
        if faults.bounds_a_solid() {
            return Ok(Self::of_checked(mesh, volume));
        }
        let joined = (!faults.check.is_closed()).then(|| joined(mesh)).flatten();
        let Some(joined) = joined else {
            return Err(Box::new(faults));
        };
        let (faults, volume) = MeshFaults::of(&joined);
        if faults.bounds_a_solid() {
            Ok(Self::of_checked(&joined, volume))
        } else {
            Err(Box::new(faults))
        }
    }
}

/// The mesh with one vertex at each place, if there were more.
fn joined(mesh: &Mesh) -> Option<Mesh> {
    let same = same_places(&mesh.positions);
    let is_joined = (0..).zip(&same).any(|(index, &first)| index != first);
    is_joined.then(|| {
        let corner = |vertex: u32| same.get(vertex as usize).copied().unwrap_or(vertex);
        let triangles = mesh.triangles.iter().map(|t| t.map(corner)).collect();
        Mesh::new(mesh.positions.clone(), triangles)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoundaryOptions, Program};

    /// Triangles with vertices of their own, as many programs write them.
    #[test]
    fn vertices_at_one_place_are_one() {
        let place = |k: u32| DVec3::from([1, 2, 4].map(|bit| f64::from(u8::from(k & bit != 0))));
        let cube = Solid::hull((0..8).map(place));
        let program = Program::lower(&cube).expect("a cube");
        let mesh = crate::Mesher::new().mesh(&program).expect("a mesh").mesh;
        let corners = mesh.triangles.iter().flatten();
        let positions = corners.map(|&vertex| mesh.positions[vertex as usize]);
        let triangles = (0..mesh.triangles.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]);
        let mut split = Mesh::new(positions.collect(), triangles.collect());
        let solid = Solid::from_mesh(&split).expect("a solid");
        let brep = Program::lower(&solid)
            .expect("valid")
            .boundary(&BoundaryOptions::default());
        assert!((brep.expect("a boundary").measure().volume.value - 1.0).abs() < 1e-12);
        split.positions[7].x += 1e-9;
        let faults = Solid::from_mesh(&split).expect_err("it is open");
        assert!(faults.to_string().contains("open edge"), "{faults}");
    }
}
