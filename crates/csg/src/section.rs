//! Sections: what a plane meets of a solid, as a profile.

use glam::{DAffine2, DAffine3, DMat2, DVec2, DVec3};

use crate::brep::{BoundaryOptions, Coedge, CurveShape, Face, HalfAxes, Loop};
use crate::elementary;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesher::Mesher;
use crate::numeric::tolerance::{ON_FACE, ON_PLANE};
use crate::program::Program;
use crate::solid::Solid;
use crate::solid::profile::{Contour, Corner, FillRule, Profile};
use crate::surface::SurfaceShape;

impl Solid {
    /// The section with the plane z = 0 of a frame (a rigid map from its
    /// coordinates to the solid's), in the frame's x and y: all points of the plane
    /// that the solid or its boundary has, without lines and lone points. A box
    /// that stands on the plane has its base there.
    ///
    /// Lines, circles and whole ellipses are such ([`Solid::exact_section`]); with other curves
    /// the section is a polygon that strays at most `tolerance`, for which both halves are meshed.
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
        if let Some(section) = self.exact_section(frame, &BoundaryOptions::new())? {
            return Ok(section);
        }
        let local = self.affine(frame.inverse());
        let mesher = Mesher::new().tolerance(tolerance);
        let mut halves = Vec::with_capacity(2);
        for half in local.halves() {
            halves.push(mesher.mesh(&Program::lower(&half)?)?.mesh);
        }
        Ok(Profile::union(halves.iter().map(Mesh::faces_in_plane)))
    }

    /// The section as [`Solid::section`] makes it, of lines, circles and whole ellipses. `None`
    /// if it has other curves, or if it cannot be told how surfaces meet. The boundary of both
    /// halves is evaluated for it.
    ///
    /// # Errors
    /// What is wrong with the solid or the frame, and as [`Program::boundary`] has.
    pub fn exact_section(
        &self,
        frame: DAffine3,
        options: &BoundaryOptions,
    ) -> Result<Option<Profile>, Error> {
        let local = self.affine(frame.inverse());
        let mut faces = Vec::new();
        for half in local.halves() {
            let half = match Program::lower(&half)?.boundary(options) {
                Ok(half) => half,
                Err(Error::Undecided(_)) => return Ok(None),
                Err(error) => return Err(error),
            };
            for face in half.faces().filter(is_in_plane) {
                let Some(face) = flat(&face) else {
                    return Ok(None);
                };
                faces.push(face);
            }
        }
        // Both halves have most faces alike.
        Ok(Some(Profile::union(faces).resolved()))
    }

    /// What is below and above the plane z = 0.
    #[must_use]
    pub fn halves(&self) -> [Self; 2] {
        [DVec3::Z, -DVec3::Z].map(|normal| self & Self::half_space(normal, 0.0))
    }
}

/// Whether a face lies in the plane z = 0 within rounding.
fn is_in_plane(face: &Face<'_>) -> bool {
    let SurfaceShape::Plane { point, normal } = face.surface().shape() else {
        return false;
    };
    let points = face.points();
    let far = points.iter().map(|p| p.abs().max_element());
    let slack = ON_PLANE * far.fold(point.length(), f64::max);
    normal.truncate().length() <= ON_PLANE && point.dot(normal).abs() <= slack
}

/// A face in the plane z = 0, if its edges are lines, circles and whole ellipses.
fn flat(face: &Face<'_>) -> Option<Profile> {
    let faces_up = face.normal(DVec3::ZERO).z > 0.0;
    let (mut contours, mut outer, mut holes) = (Vec::new(), None, Vec::new());
    for around in face.loops() {
        match ellipse(&around) {
            Some((disc, is_left)) if is_left == faces_up => outer = Some(disc),
            Some((disc, _)) => holes.push(disc),
            None => contours.push(contour(&around)?),
        }
    }
    let within = Profile::within(contours);
    Some(match outer {
        Some(outer) => outer - within - Profile::union(holes),
        None => within - Profile::union(holes),
    })
}

/// What a loop encloses that is one ellipse, and whether it runs counter-clockwise.
fn ellipse(around: &Loop<'_>) -> Option<(Profile, bool)> {
    let mut coedges = around.coedges();
    let (coedge, None) = (coedges.next()?, coedges.next()) else {
        return None;
    };
    let curve = coedge.edge().curve();
    let CurveShape::Ellipse { center, .. } = curve else {
        return None;
    };
    let HalfAxes { long, short, .. } = curve.half_axes()?;
    let axes = DMat2::from_cols(long.truncate(), short.truncate());
    let disc =
        Profile::circle(1.0).affine(DAffine2::from_mat2_translation(axes, center.truncate()));
    Some((disc, (axes.determinant() > 0.0) == coedge.is_forward()))
}

/// A loop of lines and circles.
fn contour(around: &Loop<'_>) -> Option<Contour> {
    let corner = |coedge: Coedge<'_>| {
        let edge = coedge.edge();
        let [from, _] = coedge.vertices()?;
        let curve = edge.curve();
        let sweep = match (curve, curve.half_axes()) {
            (CurveShape::Line { .. }, _) => 0.0,
            (_, Some(axes)) if axes.is_circle => {
                let [start, end] = edge.range();
                let turn = axes.long.truncate().perp_dot(axes.short.truncate());
                (end - start).copysign(if coedge.is_forward() { turn } else { -turn })
            }
            _ => return None,
        };
        Some(Corner {
            point: from.point().truncate(),
            bulge: elementary::tan(0.25 * sweep),
        })
    };
    around.coedges().map(corner).collect()
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
