//! Sections: what a plane meets of a solid, as a profile.

mod trace;

use glam::{DAffine2, DAffine3, DMat2, DVec2, DVec3};

use crate::brep::{BoundaryOptions, Coedge, CurveShape, Face, HalfAxes, Loop};
use crate::elementary;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::mesher::{Meshed, Mesher};
use crate::numeric::tolerance::{MAPPED, NEAR, ON_FACE};
use crate::program::Program;
use crate::solid::Solid;
use crate::solid::profile::{Contour, Corner, FillRule, Profile, corner_on_parabola};
use crate::surface::SurfaceShape;
use trace::{Looked, Rounding};

impl Solid {
    /// The section with the plane z = 0 of a frame (a rigid map from its
    /// coordinates to the solid's), in the frame's x and y: all points of the plane
    /// that the solid or its boundary has, without lines and lone points. A box
    /// that stands on the plane has its base there.
    ///
    /// Lines, circles and whole ellipses are such ([`Solid::exact_section`]); with other curves
    /// a part of the section is a polygon that strays at most `tolerance`, by a mesh if it cannot
    /// be told how surfaces meet ([`Meshed::faces_in_plane`]).
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
    /// that is not positive, and [`Error::Undecided`] where meshes are doubtful, too.
    pub fn section(&self, frame: DAffine3, tolerance: f64) -> Result<Profile, Error> {
        let parts = self.cut_at(frame)?;
        if let Some(section) = of_faces(&parts, &BoundaryOptions::new(), Some(tolerance))? {
            return Ok(section);
        }
        let mesher = Mesher::new().tolerance(tolerance);
        let mesh = |part: &Self| mesher.mesh(&Program::lower(part)?)?.faces_in_plane();
        let faces: Result<Vec<Profile>, Error> = parts.iter().map(mesh).collect();
        Ok(Profile::union(faces?))
    }

    /// The section as [`Solid::section`] makes it, of lines, circles and whole ellipses. `None`
    /// if it has other curves, or if it cannot be told how surfaces meet. The boundaries of
    /// [`Solid::cut_at`] are evaluated for it.
    ///
    /// # Errors
    /// What is wrong with the solid or the frame, and as [`Program::boundary`] has.
    pub fn exact_section(
        &self,
        frame: DAffine3,
        options: &BoundaryOptions,
    ) -> Result<Option<Profile>, Error> {
        of_faces(&self.cut_at(frame)?, options, None)
    }

    /// The same with other curves cut into chords that stray at most `tolerance` from them. `None`
    /// if it cannot be told how surfaces meet.
    ///
    /// # Errors
    /// As [`Solid::exact_section`]; [`Error::InvalidOption`] for a tolerance that is not positive.
    pub fn chorded_section(
        &self,
        frame: DAffine3,
        tolerance: f64,
        options: &BoundaryOptions,
    ) -> Result<Option<Profile>, Error> {
        of_faces(&self.cut_at(frame)?, options, Some(tolerance))
    }

    /// Solids, in the coordinates of a frame, whose faces in the plane z = 0
    /// ([`Face::is_in_plane`]) are the section there: of what lies just below the plane first, and
    /// then, if the solid may have a face in the plane, of what lies just above it. A face is in
    /// the plane if it is so but for rounding, some 1e-14 of the largest coordinate.
    ///
    /// They are what surfaces leave in the plane, extended across it; of a solid with large polyhedra
    /// the two halves, where faces are in the plane to 1e-9 of the size. No solid where the
    /// plane does not meet it.
    ///
    /// # Errors
    /// What is wrong with the solid or the frame, a solid without end.
    pub fn cut_at(&self, frame: DAffine3) -> Result<Vec<Self>, Error> {
        let local = self.affine(frame.inverse());
        let program = Program::lower(&local)?;
        if program.is_deep() {
            let halves = [DVec3::Z, -DVec3::Z];
            let halves = halves.map(|normal| &local & Self::half_space(normal, 0.0));
            return Ok(halves.into());
        }
        let Some(bounds) = program.bounds()? else {
            return Ok(Vec::new());
        };
        let far = bounds.min.abs().max(bounds.max.abs()).max_element();
        let size = bounds.size().truncate().max_element();
        let rounding = Rounding {
            off: MAPPED * far.max(frame.translation.abs().max_element()),
            size,
        };
        if bounds.min.z > rounding.off || bounds.max.z < -rounding.off {
            return Ok(Vec::new());
        }
        let margin = DVec2::splat(size);
        let [low, high] = [
            (bounds.min.truncate() - margin).extend(-size),
            (bounds.max.truncate() + margin).extend(0.0),
        ];
        let slab = Self::cuboid_between(low, high);
        let mut parts = Vec::with_capacity(2);
        for looked in [Looked::Below, Looked::Above] {
            let (part, has_plane) =
                trace::extended(program.surfaces(), program.formula(), rounding, looked);
            parts.extend(part.map(|part| part & &slab));
            if !has_plane {
                break;
            }
        }
        Ok(parts)
    }
}

/// The faces of solids in the plane z = 0, those with other curves than lines, circles and whole
/// ellipses by chords to a tolerance; none if there is no tolerance, or no boundary.
fn of_faces(
    parts: &[Solid],
    options: &BoundaryOptions,
    tolerance: Option<f64>,
) -> Result<Option<Profile>, Error> {
    if let Some(tolerance) = tolerance
        && !(tolerance > 0.0 && tolerance.is_finite())
    {
        return Err(Error::InvalidOption(format!(
            "a section may stray by {tolerance}: give a tolerance above 0"
        )));
    }
    let mut faces = Vec::new();
    for part in parts {
        let part = match Program::lower(part)?.boundary(options) {
            Ok(part) => part,
            Err(Error::Undecided(_)) => return Ok(None),
            Err(error) => return Err(error),
        };
        for face in part.faces().filter(Face::is_in_plane) {
            match (flat(&face), tolerance) {
                (Some(face), _) => faces.push(face),
                (None, Some(tolerance)) => faces.push(chorded(&face, tolerance)),
                (None, None) => return Ok(None),
            }
        }
    }
    // What is on both sides of the plane has most faces alike.
    Ok(Some(Profile::union(faces).resolved()))
}

/// A face in the plane z = 0 with chords for curves.
fn chorded(face: &Face<'_>, tolerance: f64) -> Profile {
    let around = |around: Loop<'_>| -> Vec<DVec2> {
        let mut points = Vec::new();
        for coedge in around.coedges() {
            let edge = coedge.edge();
            let mut range = edge.range();
            if !coedge.is_forward() {
                range.reverse();
            }
            let at = |t: f64| edge.at(t).truncate();
            points.push(at(range[0]));
            // (No closed curve is seen by its ends.)
            let middle = 0.5 * (range[0] + range[1]);
            chords(&at, [range[0], middle], tolerance, &mut points);
            points.push(at(middle));
            chords(&at, [middle, range[1]], tolerance, &mut points);
        }
        points
    };
    Profile::polygons_of(face.loops().map(around), FillRule::EvenOdd)
}

/// Adds points between the ends of a stretch of a conic: until half of the tolerance holds at
/// quarters, between which it turns little.
fn chords(
    at: &impl Fn(f64) -> DVec2,
    [from, to]: [f64; 2],
    tolerance: f64,
    points: &mut Vec<DVec2>,
) {
    let [start, end] = [at(from), at(to)];
    let along = (end - start).normalize_or_zero();
    let middle = 0.5 * (from + to);
    let quarters = [0.5 * (from + middle), middle, 0.5 * (middle + to)];
    let is_near = |t: f64| (at(t) - start).perp_dot(along).abs() <= 0.5 * tolerance;
    if quarters.into_iter().all(is_near) || middle <= from.min(to) || middle >= from.max(to) {
        return;
    }
    chords(at, [from, middle], tolerance, points);
    points.push(at(middle));
    chords(at, [middle, to], tolerance, points);
}

impl Face<'_> {
    /// Whether it lies in the plane z = 0: to 1e-9 of the farthest coordinate, as planes that
    /// are so near are one to a boundary.
    #[must_use]
    pub fn is_in_plane(&self) -> bool {
        let SurfaceShape::Plane { point, normal } = self.surface().shape() else {
            return false;
        };
        let points = self.points();
        let far = points.iter().map(|p| p.abs().max_element());
        let slack = NEAR * far.fold(point.length(), f64::max);
        normal.truncate().length() <= NEAR && point.dot(normal).abs() <= slack
    }
}

/// A face in the plane z = 0, if its edges are lines, circles, parabolas and whole
/// ellipses.
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

/// A loop of lines, circles and parabolas.
fn contour(around: &Loop<'_>) -> Option<Contour> {
    let corner = |coedge: Coedge<'_>| {
        let edge = coedge.edge();
        let curve = edge.curve();
        let [from, to] = coedge.vertices()?.map(|vertex| vertex.point().truncate());
        let [start, end] = edge.range();
        match (curve, curve.half_axes()) {
            (CurveShape::Line { .. }, _) => Some(Corner::straight(from)),
            (_, Some(axes)) if axes.is_circle => {
                let turn = axes.long.truncate().perp_dot(axes.short.truncate());
                let sweep = (end - start).copysign(if coedge.is_forward() { turn } else { -turn });
                Some(Corner::arc(from, elementary::tan(0.25 * sweep)))
            }
            (CurveShape::Conic { .. }, _) => {
                let [_, control, _] = curve.control([start, end])?;
                let control = (control.truncate() / control.w).truncate();
                let middle = edge.at(0.5 * (start + end)).truncate();
                corner_on_parabola([from, control, to], middle)
            }
            _ => None,
        }
    };
    around.coedges().map(corner).collect()
}

impl Meshed {
    /// The triangles that lie in the plane z = 0 within rounding, as a profile.
    ///
    /// # Errors
    /// [`Error::Undecided`] if something had to be settled for in the mesh because it could not be
    /// told how surfaces meet: some may be lost.
    pub fn faces_in_plane(&self) -> Result<Profile, Error> {
        match self.report.undecided.last() {
            Some(&why) if !self.report.fallbacks.is_empty() => Err(Error::Undecided(why)),
            _ => Ok(self.mesh.faces_in_plane()),
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::undecided::{Undecided, Why};

    /// A mesh that had to do in place of a boundary, and may lack a part, has no section.
    #[test]
    fn doubtful_meshes_have_no_section() {
        let cube = Solid::cuboid_between([0.0, 0.0, -1.0], [1.0, 1.0, 0.0]);
        let program = Program::lower(&cube).expect("valid");
        let mut meshed = Mesher::new().tolerance(0.1).mesh(&program).expect("a mesh");
        let area = |meshed: &Meshed| {
            let faces = meshed.faces_in_plane()?;
            Ok::<f64, Error>(faces.area(0.1).expect("an area"))
        };
        assert_eq!(area(&meshed), Ok(1.0));
        let undecided = Undecided {
            why: Why::Contour,
            place: DVec3::ZERO,
        };
        meshed.report.undecided.push(undecided);
        // Another way was found, with nothing to be said of it.
        assert_eq!(area(&meshed), Ok(1.0));
        meshed.report.add_fallback("gap", DVec3::ZERO);
        assert_eq!(area(&meshed), Err(Error::Undecided(undecided)));
    }
}
