//! Projections and sections: solids seen along z, and cut across it.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec2, DVec3};

use super::Faceting;
use crate::brep::BoundaryOptions;
use crate::error::Error;
use crate::limits::Limits;
use crate::mesh::Mesh;
use crate::solid::Solid;
use crate::solid::profile::{FillRule, Profile};

impl Solid {
    /// The section with the plane z = 0, as [`Solid::section`] has it: of lines, circles and whole
    /// ellipses exact, else the polygons of a mesh.
    ///
    /// # Errors
    /// As [`Self::projection`].
    pub fn faceted_section(&self, faceting: &mut Faceting) -> Result<Profile, Error> {
        let options = BoundaryOptions::new().limits(Limits::new().cells(faceting.cells[0]));
        if let Some(section) = self.exact_section(DAffine3::IDENTITY, &options)? {
            return Ok(section);
        }
        let parts = self.cut_at(DAffine3::IDENTITY)?;
        let meshes = parts.iter().map(|part| faceting.mesh(part));
        let meshes = meshes.collect::<Result<Vec<Mesh>, Error>>()?;
        Ok(Profile::union(meshes.iter().map(Mesh::faces_in_plane)))
    }
}

/// Normals that rise by less are level: they are in single precision, 6e-8, and were made from
/// coordinates and transforms that are rounded. Of a wall that leans by no more its shadow is off by as much of
/// its height, a hundredth of what its mesh may stray ([`Faceting::within`]).
const UPRIGHT: f32 = 1e-6;

impl Solid {
    /// The projection onto the plane z = 0, in x and y: of flat faces exact, of what is curved the
    /// polygon of a mesh.
    ///
    /// ```
    /// use csg::{Solid, corners::Faceting};
    ///
    /// let cube = Solid::cube(2.0).rotate_x(0.25 * std::f64::consts::PI);
    /// let seen = cube.projection(&mut Faceting::new())?;
    /// assert!((seen.area(1e-3).expect("an area") - 32.0f64.sqrt()).abs() < 1e-12);
    /// # Ok::<(), csg::Error>(())
    /// ```
    ///
    /// # Errors
    /// What is wrong with the solid, one without end, [`Error::InvalidOption`] for more work than
    /// `faceting` has left.
    pub fn projection(&self, faceting: &mut Faceting) -> Result<Profile, Error> {
        let outlines = outlines(&faceting.mesh(self)?)?;
        Ok(Profile::polygons_of(outlines, FillRule::NonZero))
    }
}

/// What is between the triangles of a mesh that face up and the others, seen along z: the contours
/// of its shadow, and those of what is above or below some of it.
fn outlines(mesh: &Mesh) -> Result<Vec<Vec<DVec2>>, Error> {
    let faces_up = |index: usize| {
        let [p, q, r]: [DVec2; 3] = mesh.corners(index).map(DVec3::truncate);
        // Of a wall that stands upright triangles face up or down as its chords have it:
        // their sides would cross each other everywhere.
        let normals = mesh.corner_normals.get(index);
        let stands = normals.is_some_and(|all| all.iter().all(|normal| normal.z.abs() < UPRIGHT));
        !stands && (q - p).perp_dot(r - p) > 0.0
    };
    let mut open: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for (index, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        if faces_up(index) {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                if !take(&mut open, [to, from]) {
                    *open.entry([from, to]).or_default() += 1;
                }
            }
        }
    }
    let mut outlines = Vec::new();
    while let Some((&[start, mut to], _)) = open.first_key_value() {
        take(&mut open, [start, to]);
        let mut outline = vec![start];
        while to != start {
            outline.push(to);
            let next = open.range([to, 0]..=[to, u32::MAX]).next();
            let Some((&next, _)) = next else {
                let problem = "its outline does not close";
                return Err(Error::InvalidOption(problem.to_owned()));
            };
            take(&mut open, next);
            to = next[1];
        }
        let at = |vertex: u32| mesh.positions[vertex as usize].truncate();
        outlines.push(outline.into_iter().map(at).collect());
    }
    Ok(outlines)
}

/// Takes one of what is counted, if there is any.
fn take(counts: &mut BTreeMap<[u32; 2], u32>, side: [u32; 2]) -> bool {
    let Some(count) = counts.get_mut(&side) else {
        return false;
    };
    *count -= 1;
    if *count == 0 {
        counts.remove(&side);
    }
    true
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn shadows_have_the_corners_of_their_outlines_alone() {
        let mut faceting = Faceting::default();
        let ball = Solid::sphere(2.0).rotate_x(0.3);
        let ring = ball.clone() - Solid::cylinder(1.0, -3.0..3.0).translate([0.25, 0.0, 0.0]);
        for (solid, area) in [(ball, 4.0 * PI), (ring, 3.0 * PI)] {
            let shadow = solid.projection(&mut faceting).expect("a shadow");
            let contours = shadow.contours(1e-3).expect("contours");
            let corners: usize = contours.iter().map(Vec::len).sum();
            assert!(corners < 3000, "{corners}");
            let off = (shadow.area(1e-3).expect("an area") - area).abs();
            assert!(off < 1e-3 * area, "{off}");
        }
    }

    /// Of a round wall that stands upright some triangles face up, and some down.
    #[test]
    fn walls_that_stand_upright_cast_no_shadow() {
        let post = Solid::cylinder(2.0, -1.0..1.0) - Solid::cylinder(1.5, -0.5..2.0);
        let post = post.rotate_x(0.3).rotate_y(0.7);
        let post = post.rotate_y(-0.7).rotate_x(-0.3);
        let mesh = Faceting::new().mesh(&post).expect("a mesh");
        let outlines = outlines(&mesh).expect("outlines");
        let corners: usize = outlines.iter().map(Vec::len).sum();
        let around = |radius: f64| {
            let rim = |p: &&DVec3| p.z > 0.9 && (p.truncate().length() - radius).abs() < 1e-9;
            mesh.positions.iter().filter(rim).count()
        };
        // The floor of the pit is seen through its mouth.
        assert_eq!(corners, around(2.0) + 2 * around(1.5));
    }
}
