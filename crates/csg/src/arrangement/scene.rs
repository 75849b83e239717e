//! What all blocks have in common.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::frame::Frame;
use super::intersection::Nearness;
use super::piece::Side;
use super::relations::Relations;
use crate::control::Control;
use crate::numeric::exact::{sign_of_3, sign_of_4};
use crate::numeric::tolerance::{BLURRED_REACH, NEAR, SAME_BEND, TOUCHING_REACH};
use crate::program::{Given, Surface, SurfaceId};
use crate::surface::solve;
use crate::undecided::Stop;

/// n·x - offset, at most 0 inside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub normal: DVec3,
    pub offset: f64,
}

impl Plane {
    pub fn of(surface: &Surface) -> Self {
        Self {
            normal: surface.linear,
            offset: surface.linear.dot(surface.anchor),
        }
    }

    pub fn value(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Which of two planes the line that two others have in common comes to first, along the cross
    /// product of their normals, as if all coefficients were exact: the value of one where the other
    /// one crosses is a determinant over another one.
    pub fn order_along(own: [&Self; 2], [one, other]: [&Self; 2]) -> Ordering {
        let rise = |plane: &Self| sign_of_3([own[0], own[1], plane].map(|p| p.normal.to_array()));
        let value =
            sign_of_4([own[0], own[1], one, other].map(|p| p.normal.extend(-p.offset).to_array()));
        let signs = [value, rise(one), rise(other)];
        let is_before = signs.iter().filter(|sign| sign.is_lt()).count() % 2 == 1;
        match signs.contains(&Ordering::Equal) {
            true => Ordering::Equal,
            false if is_before => Ordering::Less,
            false => Ordering::Greater,
        }
    }
}

/// What all blocks have in common.
pub(super) struct Scene<'a> {
    pub surfaces: &'a [Surface],
    pub planes: &'a [Plane],
    /// For each curved surface its frame, if it has one.
    pub frames: &'a [Option<Frame>],
    /// For each primitive the first that looks like it.
    pub looks: &'a [u32],
    pub on_plane: f64,
    pub near: f64,
    /// Nearer surfaces and curves that do not cross touch.
    pub touch: f64,
    /// No point of the solid is farther from the origin.
    pub reach: f64,
    pub weld: f64,
    /// Distances that rounding may make.
    pub rounding: f64,
    /// The edges and vertices of polyhedra.
    pub given: Option<&'a Given>,
    /// What surfaces have in common.
    pub relations: &'a Relations,
    pub control: &'a Control,
}

impl<'a> Scene<'a> {
    pub fn surface(&self, id: SurfaceId) -> &'a Surface {
        &self.surfaces[id]
    }

    pub fn plane(&self, id: SurfaceId) -> &'a Plane {
        &self.planes[id.index()]
    }

    /// Of a curved surface, if it has one.
    pub fn frame(&self, id: SurfaceId) -> Option<&'a Frame> {
        self.frames[id.index()].as_ref()
    }

    /// Distances below which its surfaces agree.
    pub fn nearness(&self) -> Nearness {
        let &Self { near, touch, .. } = self;
        Nearness { near, touch }
    }

    /// How near to a surface a curve runs along it, and how near it touches it: for
    /// [`Curve::meet`](super::curve::Curve::meet).
    pub fn tolerances(&self) -> [f64; 2] {
        [self.on_plane, self.touch]
    }

    /// Whether the caller wants more.
    pub fn go_on(&self) -> Result<(), Stop> {
        self.control.check().map_err(|_| Stop::Halted)
    }

    /// Curvatures that differ by less are the same: those of curves that over the
    /// length of the scene part by less than what is near.
    pub fn same_bend(&self) -> f64 {
        self.same_bends()[0]
    }

    /// The same of the factors of s², s³ and s⁴ in how far surfaces part at a distance s.
    pub fn same_bends(&self) -> [f64; 3] {
        let size = self.near / NEAR;
        [1, 2, 3].map(|power| SAME_BEND / size.powi(power))
    }

    /// Next to where surfaces touch, points nearer to each other may not be told apart:
    /// where a curve touches a surface to the fourth order, the place is known to a
    /// quarter of the digits.
    pub fn touching_reach(&self) -> f64 {
        TOUCHING_REACH * self.weld
    }

    /// Contacts farther from each other are two.
    pub fn blurred_reach(&self) -> f64 {
        BLURRED_REACH * self.weld
    }

    /// By how much rounding may move points of a surface before its values are to be
    /// known to more digits.
    pub fn blur(&self) -> f64 {
        4.0 * self.rounding
    }

    /// The point common to some surfaces next to another one; that itself, if there is none.
    pub fn common_to(&self, surfaces: &[&Surface], start: DVec3) -> DVec3 {
        let reach = self.touching_reach();
        let found = solve::sharp_common_point(surfaces, start, reach, self.blur());
        let is_near = found.point.distance(start) <= reach;
        if is_near && found.residual <= self.weld {
            found.point
        } else {
            start
        }
    }

    /// The point common to three planes, the same to the bit in whatever order
    /// they are named: of faces of a polyhedron that share a vertex, this; of two
    /// that share an edge and another one, where that crosses the edge.
    pub fn common_point(&self, mut ids: [SurfaceId; 3]) -> DVec3 {
        ids.sort_unstable();
        self.given_point(ids)
            .unwrap_or_else(|| self.point_of_planes(ids))
    }

    fn given_point(&self, ids: [SurfaceId; 3]) -> Option<DVec3> {
        let given = self.given?;
        let mut vertices = given.common_vertices(ids);
        if let Some(first) = vertices.next() {
            let others: SmallVec<[DVec3; 1]> = vertices.collect();
            if others.is_empty() {
                return Some(first);
            }
            let middle = self.point_of_planes(ids);
            let distance = |p: &DVec3| p.distance_squared(middle);
            let all = others.into_iter().chain([first]);
            return all.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        }
        let [a, b, c] = ids;
        // Whether the crossing is on the edge, by how much the plane's value changes along it.
        let mut best: Option<((bool, f64), DVec3)> = None;
        for (pair, third) in [([a, b], c), ([a, c], b), ([b, c], a)] {
            for &ends in given.edges_of(pair) {
                let ends = ends.map(|v| given.vertex(v));
                let values = ends.map(|v| self.plane(third).value(v));
                let change = values[0] - values[1];
                let share = values[0] / change;
                let is_on = (-1e-6..=1.0 + 1e-6).contains(&share);
                let merit = (is_on, change.abs() / ends[0].distance(ends[1]));
                if share.is_finite() && best.is_none_or(|(known, _)| merit > known) {
                    best = Some((merit, ends[0].lerp(ends[1], share)));
                }
            }
        }
        best.map(|(_, point)| point)
    }

    /// The point common to three planes, in ascending order.
    fn point_of_planes(&self, ids: [SurfaceId; 3]) -> DVec3 {
        let planes = ids.map(|id| self.plane(id));
        let [p, q, r] = planes.map(|plane| plane.normal);
        let crosses = [q.cross(r), r.cross(p), p.cross(q)];
        let solve = |values: [f64; 3]| {
            (values[0] * crosses[0] + values[1] * crosses[1] + values[2] * crosses[2])
                / p.dot(crosses[0])
        };
        let point = solve(planes.map(|plane| plane.offset));
        // A step of iterative refinement.
        point - solve(planes.map(|plane| plane.value(point)))
    }

    /// A point of a face seen from outside, along the axis that its plane faces
    /// most: no coordinate is rounded.
    pub fn flatten(&self, side: &Side, point: DVec3) -> DVec2 {
        match self.frame(side.plane) {
            Some(frame) => frame.flatten(side.patch, side.along_normal, point),
            None => self.flatten_direction(side, point),
        }
    }

    /// The same of a direction, however short beside the coordinates of the face.
    pub fn flatten_direction(&self, side: &Side, direction: DVec3) -> DVec2 {
        if let Some(frame) = self.frame(side.plane) {
            return frame.flatten_direction(side.patch, side.along_normal, direction);
        }
        let normal = self.plane(side.plane).normal;
        let axis = normal.abs().max_position();
        let (u, v) = (direction[(axis + 1) % 3], direction[(axis + 2) % 3]);
        if (normal[axis] > 0.0) == side.along_normal {
            DVec2::new(u, v)
        } else {
            DVec2::new(v, u)
        }
    }
}
