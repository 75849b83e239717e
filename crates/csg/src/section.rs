//! Sections: what a plane meets of a solid, as a profile.

use glam::{DAffine3, DVec2, DVec3};

use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesher::Mesher;
use crate::numeric::tolerance::ON_FACE;
use crate::program::Program;
use crate::solid::Solid;
use crate::solid::profile::{FillRule, Profile};

impl Solid {
    /// The section with the plane z = 0 of a frame (a rigid map from its
    /// coordinates to the solid's), in the frame's x and y: all points of the plane
    /// that the solid or its boundary has, without lines and lone points. A box
    /// that stands on the plane has its base there.
    ///
    /// Of a solid of flat faces the section is exact to rounding; of curved ones it
    /// is a polygon that strays at most `tolerance`. Both halves are meshed for it.
    ///
    /// ```
    /// use csg::Solid;
    /// use csg::glam::DAffine3;
    ///
    /// let tube = Solid::cuboid([3.0, 3.0, 5.0]) - Solid::cuboid([1.0, 1.0, 9.0]);
    /// let across = tube.section(DAffine3::from_translation([0.0, 0.0, 1.0].into()), 1e-3)?;
    /// assert!((across.area(1e-3).expect("an area") - 8.0).abs() < 1e-12);
    /// # Ok::<(), csg::Error>(())
    /// ```
    ///
    /// # Errors
    /// What is wrong with the solid or the frame, a solid without end, a tolerance
    /// that is not positive.
    pub fn section(&self, frame: DAffine3, tolerance: f64) -> Result<Profile, Error> {
        let local = self.affine(frame.inverse());
        let mesher = Mesher::new().tolerance(tolerance);
        let mut halves = Vec::with_capacity(2);
        for half in local.halves() {
            halves.push(mesher.mesh(&Program::lower(&half)?)?.mesh);
        }
        Ok(Profile::union(halves.iter().map(Mesh::faces_in_plane)))
    }

    /// What is below and above the plane z = 0.
    #[must_use]
    pub fn halves(&self) -> [Self; 2] {
        [DVec3::Z, -DVec3::Z].map(|normal| self & Self::half_space(normal, 0.0))
    }
}

impl Mesh {
    /// The triangles that lie in the plane z = 0 within rounding, as a profile.
    #[must_use]
    pub fn faces_in_plane(&self) -> Profile {
        let far = self.positions.iter().map(|p| p.abs().max_element());
        let slack = ON_FACE * far.fold(0.0, f64::max);
        let triangles = (0..self.triangles.len()).map(|index| self.corners(index));
        let flat = triangles.filter(|corners| corners.iter().all(|p| p.z.abs() <= slack));
        let flat = flat.map(|corners| {
            let mut corners: [DVec2; 3] = corners.map(DVec3::truncate);
            if (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]) < 0.0 {
                corners.reverse();
            }
            corners
        });
        Profile::polygons_of(flat, FillRule::NonZero)
    }
}
