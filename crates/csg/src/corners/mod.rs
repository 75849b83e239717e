//! Operations that need the corners of solids: hulls, Minkowski sums, new sizes, projections.
//!
//! What is exact without corners is made so: hulls of balls, of discs that are parallel, sums with
//! balls. Otherwise solids are meshed; of flat faces the corners are exact, and what is curved is
//! taken for faces ([`Faceting`]).

mod hull;
mod minkowski;
mod shadow;
mod size;

use glam::{DAffine3, DVec3};

use crate::error::Error;
use crate::limits::Limits;
use crate::mesh::Mesh;
use crate::mesher::Mesher;
use crate::program::Program;
use crate::solid::{Made, Node, Primitive, Solid};

pub use hull::{are_parallel, circles};

/// How near what is curved is taken for faces, where an operation needs the corners of solids, and
/// what all operations may cost that are handed it. It is counted, not timed: the same is made, or
/// refused, on every machine.
///
/// ```
/// use csg::corners::Faceting;
/// use csg::Solid;
///
/// let mut faceting = Faceting::new();
/// let rounded = Solid::minkowski_sum([Solid::cube(2.0), Solid::sphere(0.5)], &mut faceting)?;
/// assert_eq!(faceting.take_strayed(), None); // exact: planes, cylinders and balls
/// rounded.rotate_x(0.3).projection(&mut faceting)?;
/// assert!(faceting.take_strayed().is_some_and(|strayed| strayed < 1e-3));
/// # Ok::<(), csg::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Faceting {
    share: f64,
    /// In model units; in place of the share.
    distance: Option<f64>,
    /// What may still be spent, and could be at first.
    cells: [u64; 2],
    sums: [usize; 2],
    strayed: Option<f64>,
}

impl Default for Faceting {
    fn default() -> Self {
        Self::new()
    }
}

impl Faceting {
    /// To 1e-4 of the size of what is curved; less than a second's work.
    #[must_use]
    pub fn new() -> Self {
        // None of eleven scenes that others wrote with such operations takes half as many.
        const MOST_CELLS: u64 = 200_000;
        const MOST_SUMS: usize = 10_000_000;
        Self {
            share: 1e-4,
            distance: None,
            cells: [MOST_CELLS; 2],
            sums: [MOST_SUMS; 2],
            strayed: None,
        }
    }

    /// How far a mesh of what is curved may stray, as a share of its longest side: from 1e-9 to 0.1.
    #[must_use]
    pub fn within(self, share: f64) -> Self {
        Self { share, ..self }
    }

    /// How far a mesh of what is curved may stray, in model units, in place of a share; with none
    /// the share again.
    #[must_use]
    pub fn to(self, distance: Option<f64>) -> Self {
        Self { distance, ..self }
    }

    /// The most cells, or blocks between planes, that the mesher may look at.
    #[must_use]
    pub fn cells(self, most: u64) -> Self {
        Self {
            cells: [most; 2],
            ..self
        }
    }

    /// The most sums of corners in Minkowski sums.
    #[must_use]
    pub fn sums(self, most: usize) -> Self {
        Self {
            sums: [most; 2],
            ..self
        }
    }

    /// How far meshes of what is curved stray at most, in model units, since it was asked last; none
    /// if all was exact.
    pub fn take_strayed(&mut self) -> Option<f64> {
        self.strayed.take()
    }

    /// What an operation makes; if it took curved surfaces for faces, said to stand for another
    /// solid.
    fn standing_in(
        &mut self,
        of: impl FnOnce(&mut Self) -> Result<Solid, Error>,
    ) -> Result<Solid, Error> {
        let before = self.strayed.take();
        let made = of(self);
        let strays = self.strayed;
        self.strayed = before.into_iter().chain(strays).reduce(f64::max);
        Ok(match strays {
            Some(strays) => made?.standing_in(strays),
            None => made?,
        })
    }

    /// The mesh of a solid: exact if all its faces are flat.
    fn mesh(&mut self, solid: &Solid) -> Result<Mesh, Error> {
        let program = Program::lower(solid)?;
        let [left, most] = self.cells;
        let mut mesher = Mesher::new().limits(Limits::new().cells(left));
        if !program.is_polyhedral() {
            if !(1e-9..=0.1).contains(&self.share) {
                return Err(Error::InvalidOption(format!(
                    "what is curved may stray by {} of its size: give a share from 1e-9 to 0.1",
                    self.share
                )));
            }
            let Some(bounds) = program.bounds()? else {
                return Ok(Mesh::default());
            };
            let longest = bounds.size().max_element();
            let within = self.distance.unwrap_or(self.share * longest);
            mesher = mesher.tolerance(within).normals();
            let strayed = self.strayed.map_or(within, |before| before.max(within));
            self.strayed = Some(strayed);
        }
        let meshed = mesher.mesh(&program).map_err(|error| match error {
            Error::LimitReached(_) => Error::InvalidOption(format!(
                "what is in it takes too much work to mesh (more than {most} cells in all): give simpler operands"
            )),
            other => other,
        })?;
        self.cells[0] = left.saturating_sub(meshed.report.cells_visited);
        let is_nothing = meshed.mesh.triangles.is_empty() && program.bounds()?.is_none();
        if is_nothing || meshed.report.is_proven() {
            Ok(meshed.mesh)
        } else {
            Err(Error::InvalidOption(
                "what is in it could not be meshed without doubt: move or turn one of its parts a little".to_owned(),
            ))
        }
    }
}

/// The solids that solids are the union of, each with the map that puts it in its place.
fn leaves(solids: &[Solid]) -> Vec<(&Solid, DAffine3)> {
    let mut found = Vec::new();
    let mut pending: Vec<(&Solid, DAffine3)> =
        solids.iter().map(|s| (s, DAffine3::IDENTITY)).collect();
    while let Some((solid, map)) = pending.pop() {
        match solid.node() {
            Node::Union(operands) => pending.extend(operands.iter().map(|o| (o, map))),
            Node::Transform(Ok(inner), operand) => pending.push((operand, map * *inner)),
            Node::Named(_, operand) | Node::Colored(_, operand) => pending.push((operand, map)),
            _ => found.push((solid, map)),
        }
    }
    found
}

/// Points whose convex hull is that of the solid.
fn corners(solid: &Solid, faceting: &mut Faceting) -> Result<Vec<DVec3>, Error> {
    let mut points = Vec::new();
    for (solid, map) in leaves(std::slice::from_ref(solid)) {
        match solid.node() {
            Node::Primitive(Primitive::Prism { polygon, z }) => {
                let ends = [z.start, z.end];
                let at = |z: f64| polygon.iter().map(move |p| p.extend(z));
                let ends = ends.into_iter().flat_map(at);
                points.extend(ends.map(|p| map.transform_point3(p)));
            }
            &Node::Primitive(Primitive::Cuboid { min, max }) => {
                let corner = |k: usize| {
                    let is_upper = [1, 2, 4].map(|bit| k & bit != 0);
                    DVec3::select(is_upper.into(), max, min)
                };
                points.extend((0..8).map(|k| map.transform_point3(corner(k))));
            }
            Node::Made(Made {
                solid: Ok(_),
                spanning,
                ..
            }) if !spanning.is_empty() => {
                points.extend(spanning.iter().map(|&p| map.transform_point3(p)));
            }
            _ => {
                let positions = faceting.mesh(solid)?.positions;
                points.extend(positions.into_iter().map(|p| map.transform_point3(p)));
            }
        }
    }
    Ok(points)
}

/// The corners of convex parts that make up a solid.
fn parts(solid: &Solid, faceting: &mut Faceting) -> Result<Vec<Vec<DVec3>>, Error> {
    let whole = faceting.mesh(solid)?;
    if whole.triangles.is_empty() {
        return Ok(Vec::new());
    }
    let parts =
        Solid::convex_parts(&whole).map_err(|fault| Error::InvalidOption(fault.to_string()))?;
    if parts.len() == 1 {
        return Ok(vec![whole.positions]);
    }
    let corners = parts
        .into_iter()
        .map(|planes| Ok(faceting.mesh(&Solid::convex_polyhedron(planes))?.positions));
    corners.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_bounded_over_all_nodes() {
        let cube = Solid::cuboid([1.0; 3]);
        // Cuboids have eight corners each, of which all are summed.
        let mut faceting = Faceting::new().sums(100);
        let pair = || vec![cube.clone(), cube.clone()];
        assert!(Solid::minkowski_sum(pair(), &mut faceting).is_ok());
        let refused = Solid::minkowski_sum(pair(), &mut faceting).expect_err("refused");
        assert!(
            refused.to_string().contains("too many corners"),
            "{refused}"
        );

        let mut faceting = Faceting::new().cells(3);
        let notched = &cube - Solid::cuboid_between([0.0; 3], [2.0; 3]);
        let refused = (0..4).find_map(|_| notched.corner_bounds(&mut faceting).err());
        let refused = refused.expect("refused");
        assert!(refused.to_string().contains("too much work"), "{refused}");
    }

    #[test]
    fn polyhedra_and_hulls_give_their_points() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let polyhedron = Solid::polyhedron(points, faces).translate([1.0, 0.0, 0.0]);
        for solid in [
            polyhedron.clone(),
            Solid::hull(points).translate([1.0, 0.0, 0.0]),
        ] {
            let nothing = &mut Faceting::new().cells(0).sums(0);
            let found = corners(&solid, nothing).expect("nothing is meshed");
            assert_eq!(found, points.map(|p| p + DVec3::X));
        }
    }

    #[test]
    fn sums_and_hulls_of_nothing_are_nothing() {
        let nothing = Solid::cube(1.0) - Solid::cube(1.0);
        let cube = Solid::cube(1.0);
        let faceting = &mut Faceting::new();
        let empty = [
            Solid::hull_of(&[], faceting),
            Solid::hull_of(&[nothing.clone(), nothing.clone()], faceting),
            Solid::minkowski_sum([], faceting),
            Solid::minkowski_sum([cube.clone(), nothing.clone()], faceting),
            Solid::minkowski_sum([nothing.clone(), Solid::sphere(1.0)], faceting),
            nothing.resized([1.0; 3], glam::BVec3::FALSE, faceting),
        ];
        for (place, solid) in empty.into_iter().enumerate() {
            let program = Program::lower(&solid.expect("a solid")).expect("a program");
            assert_eq!(program.bounds(), Ok(None), "{place}");
        }
        let shadow = nothing.projection(faceting).expect("a shadow");
        assert_eq!(shadow.area(1e-3), Ok(0.0));
    }

    #[test]
    fn mistakes_are_told() {
        let cone = Solid::cone(1.0, 0.0..1.0);
        for share in [0.0, 1.0, f64::NAN] {
            let sum = Solid::minkowski_sum(
                [cone.clone(), cone.clone()],
                &mut Faceting::new().within(share),
            );
            let problem = sum.expect_err("no share").to_string();
            assert!(problem.contains("from 1e-9 to 0.1"), "{problem}");
        }
        let faceting = &mut Faceting::new();
        let endless = Solid::half_space([0.0, 0.0, 1.0], 0.0);
        let hull = Solid::hull_of(&[endless, cone.clone()], faceting);
        assert!(matches!(hull, Err(Error::Unbounded { .. })), "{hull:?}");
        let resized = cone.resized([f64::NAN, 0.0, 0.0], glam::BVec3::FALSE, faceting);
        assert!(
            matches!(resized, Err(Error::InvalidOption(_))),
            "{resized:?}"
        );
    }
}
