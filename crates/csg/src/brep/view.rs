//! The boundary as it is walked through.

use glam::{DVec2, DVec3};

use super::chart::Chart;
use super::curve::CurveShape;
use super::data::{
    Brep, CoedgeId, EdgeData, EdgeId, FaceData, FaceId, LoopId, Patch, ShellId, VertexId, range,
};
use crate::program::{Origin, Surface};
use crate::report::Moved;

macro_rules! views {
    ($($(#[$doc:meta])* $name:ident $id:ident $all:ident)*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug)]
            pub struct $name<'a> {
                brep: &'a Brep,
                id: $id,
            }

            impl<'a> $name<'a> {
                /// Its name.
                #[must_use]
                pub fn id(&self) -> $id {
                    self.id
                }

                fn of(brep: &'a Brep, id: usize) -> Self {
                    Self {
                        brep,
                        id: $id::new(id),
                    }
                }
            }

            impl PartialEq for $name<'_> {
                fn eq(&self, other: &Self) -> bool {
                    std::ptr::eq(self.brep, other.brep) && self.id == other.id
                }
            }

            impl Eq for $name<'_> {}
        )*

        impl Brep {
            $(
                /// All of them, in the order of their numbers.
                pub fn $all(&self) -> impl ExactSizeIterator<Item = $name<'_>> {
                    (0..self.counts().$all).map(|id| $name::of(self, id))
                }
            )*
        }
    };
}

views! {
    /// A connected part of a boundary: the outside of a body, or the wall of a void in it.
    Shell ShellId shells
    /// A connected part of one surface.
    Face FaceId faces
    /// Coedges around a face, in order.
    Loop LoopId loops
    /// One side of an edge: a face lies on its left as seen from outside.
    Coedge CoedgeId coedges
    /// A piece of the curve in which two surfaces meet.
    Edge EdgeId edges
    /// A point in which edges end.
    Vertex VertexId vertices
}

/// How many there are of each.
struct Counts {
    shells: usize,
    faces: usize,
    loops: usize,
    coedges: usize,
    edges: usize,
    vertices: usize,
}

impl Brep {
    fn counts(&self) -> Counts {
        Counts {
            shells: self.shells.len(),
            faces: self.faces.len(),
            loops: self.loops.len(),
            coedges: self.coedges.len(),
            edges: self.edges.len(),
            vertices: self.points.len(),
        }
    }

    /// What was done to surfaces that nearly coincide or touch, if anything was: the
    /// boundary is that of the solid so moved.
    #[must_use]
    pub fn moved(&self) -> Option<Moved> {
        self.moved
    }

    /// Whether its faces were cut at seams ([`crate::BoundaryOptions::cut_at_seams`]).
    #[must_use]
    pub fn is_cut_at_seams(&self) -> bool {
        self.is_cut_at_seams
    }

    /// Whether there is no boundary: the solid is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }
}

impl<'a> Shell<'a> {
    /// Its faces.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = Face<'a>> + use<'a> {
        let brep = self.brep;
        range(brep.shells[self.id.index()].faces).map(|id| Face::of(brep, id))
    }

    /// How many handles it has: 0 for a ball, 1 for a ring.
    #[must_use]
    pub fn genus(&self) -> usize {
        self.brep.shells[self.id.index()].genus as usize
    }

    pub(super) fn brep(&self) -> &'a Brep {
        self.brep
    }
}

impl<'a> Face<'a> {
    /// The shell that it is part of.
    #[must_use]
    pub fn shell(&self) -> Shell<'a> {
        Shell::of(self.brep, self.data().shell.index())
    }

    /// The loops around it, of a plane's face the outline first. None for a face that closes
    /// on itself.
    pub fn loops(&self) -> impl ExactSizeIterator<Item = Loop<'a>> + use<'a> {
        let brep = self.brep;
        range(self.data().loops).map(|id| Loop::of(brep, id))
    }

    /// The edges around it; one of which it is on both sides comes twice.
    pub fn edges(&self) -> impl Iterator<Item = Edge<'a>> + use<'a> {
        let coedges = self.loops().flat_map(|around| around.coedges());
        coedges.map(|coedge| coedge.edge())
    }

    /// The surface on which it lies, in model units.
    #[must_use]
    pub fn surface(&self) -> Surface {
        self.brep.surfaces[self.surface_index()].relative_to(-self.brep.origin)
    }

    /// Of a whole sphere that was cut at seams the half of a great circle at which it was: the unit
    /// directions from the centre to a pole, where it ends, and to its middle.
    #[must_use]
    pub fn meridian(&self) -> Option<[DVec3; 2]> {
        *self.brep.meridians.get(self.surface_index())?
    }

    /// The number of its surface in the program that was evaluated.
    #[must_use]
    pub fn surface_index(&self) -> usize {
        self.data().side.plane.index()
    }

    /// Whether the gradient of the surface's function points out of the solid there.
    #[must_use]
    pub fn is_along_gradient(&self) -> bool {
        self.data().side.along_normal
    }

    /// The primitive that it comes from: the first of those that look like it.
    #[must_use]
    pub fn origin(&self) -> &'a Origin {
        &self.brep.origins[self.data().side.look as usize]
    }

    /// Some points of the face, in model units: corners and middles of edges and seams.
    #[must_use]
    pub fn points(&self) -> Vec<DVec3> {
        let patches = &self.brep.patches[range(self.data().patches)];
        let stretches = patches.iter().flat_map(|patch| &patch.stretches);
        let points = stretches.flat_map(|stretch| {
            let [from, to] = stretch.places;
            let curve = &self.brep.curves[stretch.curve as usize];
            [from, 0.5 * (from + to)].map(|t| curve.at(t) + self.brep.origin)
        });
        points.collect()
    }

    /// A direction along which lines meet the first part of the face once at most: where
    /// faces were cut at seams it is seen whole from there, but for those of cylinders, cones and
    /// whole spheres.
    /// Of a plane its normal.
    #[must_use]
    pub fn view(&self) -> DVec3 {
        let patch = &self.brep.patches[self.data().patches.0 as usize];
        self.brep.chart(patch).view()
    }

    /// The direction out of the solid at a point of the face, of unit length.
    #[must_use]
    pub fn normal(&self, at: DVec3) -> DVec3 {
        let surface = &self.brep.surfaces[self.surface_index()];
        let normal = surface.gradient(at - self.brep.origin).normalize_or_zero();
        if self.is_along_gradient() {
            normal
        } else {
            -normal
        }
    }

    pub(super) fn brep(&self) -> &'a Brep {
        self.brep
    }

    /// The numbers of its patches.
    pub(super) fn patches(&self) -> (u32, u32) {
        self.data().patches
    }

    fn data(&self) -> &'a FaceData {
        &self.brep.faces[self.id.index()]
    }
}

impl<'a> Loop<'a> {
    /// The face that it bounds.
    #[must_use]
    pub fn face(&self) -> Face<'a> {
        Face::of(self.brep, self.brep.loops[self.id.index()].face.index())
    }

    /// Its coedges, each from where the one before ends.
    pub fn coedges(&self) -> impl ExactSizeIterator<Item = Coedge<'a>> + use<'a> {
        let brep = self.brep;
        range(brep.loops[self.id.index()].coedges).map(|id| Coedge::of(brep, id))
    }
}

impl<'a> Coedge<'a> {
    /// The edge of which it is a side.
    #[must_use]
    pub fn edge(&self) -> Edge<'a> {
        Edge::of(self.brep, self.brep.coedges[self.id.index()].edge.index())
    }

    /// Whether it runs along the edge's curve, and not back.
    #[must_use]
    pub fn is_forward(&self) -> bool {
        self.brep.edges[self.edge().id.index()].coedges[0] == self.id
    }

    /// The other side of the edge.
    #[must_use]
    pub fn twin(&self) -> Coedge<'a> {
        let [forward, back] = self.brep.edges[self.edge().id.index()].coedges;
        let twin = if forward == self.id { back } else { forward };
        Coedge::of(self.brep, twin.index())
    }

    /// The loop that it is part of.
    #[must_use]
    pub fn face_loop(&self) -> Loop<'a> {
        let id = self.brep.coedges[self.id.index()].face_loop;
        Loop::of(self.brep, id.index())
    }

    /// The face on its left.
    #[must_use]
    pub fn face(&self) -> Face<'a> {
        self.face_loop().face()
    }

    /// The vertices that it leads from and to; none all around a closed curve.
    #[must_use]
    pub fn vertices(&self) -> Option<[Vertex<'a>; 2]> {
        let [from, to] = self.edge().vertices()?;
        Some(if self.is_forward() {
            [from, to]
        } else {
            [to, from]
        })
    }
}

impl<'a> Edge<'a> {
    /// What curve it is a piece of.
    #[must_use]
    pub fn curve(&self) -> CurveShape {
        let curve = &self.brep.curves[self.data().curve as usize];
        CurveShape::of(curve, self.brep.origin)
    }

    /// From which parameter of the curve to which, the second the greater.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        self.data().range
    }

    /// The point of the curve at a parameter, in model units.
    #[must_use]
    pub fn at(&self, t: f64) -> DVec3 {
        self.brep.curves[self.data().curve as usize].at(t) + self.brep.origin
    }

    /// The vertices it leads from and to; none all around a closed curve.
    #[must_use]
    pub fn vertices(&self) -> Option<[Vertex<'a>; 2]> {
        let brep = self.brep;
        let vertices = self.data().vertices?;
        Some(vertices.map(|vertex| Vertex::of(brep, vertex.index())))
    }

    /// Its sides: along the curve, and back.
    #[must_use]
    pub fn coedges(&self) -> [Coedge<'a>; 2] {
        let brep = self.brep;
        self.data()
            .coedges
            .map(|coedge| Coedge::of(brep, coedge.index()))
    }

    /// The faces on its sides.
    #[must_use]
    pub fn faces(&self) -> [Face<'a>; 2] {
        self.coedges().map(|coedge| coedge.face())
    }

    /// The point of the curve at a parameter, about the middle of the solid.
    pub(super) fn at_about(&self, t: f64) -> DVec3 {
        self.brep.curves[self.data().curve as usize].at(t)
    }

    /// Of the whole solid, the longest side's order.
    pub(super) fn size_of_solid(&self) -> f64 {
        self.brep.size
    }

    fn data(&self) -> &'a EdgeData {
        &self.brep.edges[self.id.index()]
    }
}

impl<'a> Vertex<'a> {
    /// Where it is, in model units.
    #[must_use]
    pub fn point(&self) -> DVec3 {
        self.brep.points[self.id.index()] + self.brep.origin
    }
}

impl Brep {
    /// The chart of a patch, with coordinates near to a point of it.
    pub(super) fn chart(&self, patch: &Patch) -> Chart<'_> {
        let surface = patch.side.plane.index();
        let first = patch.stretches.first();
        let about = first.map_or(DVec3::ZERO, |first| {
            self.curves[first.curve as usize].at(first.places[0])
        });
        let frame = self.frames[surface].as_ref();
        Chart::new(&self.surfaces[surface], frame, &patch.side, about)
    }

    /// The stretches around a patch as so many chords each, as its chart shows them.
    pub(super) fn chords<'a>(
        &'a self,
        patch: &'a Patch,
        chart: &'a Chart<'a>,
        count: u32,
    ) -> impl Iterator<Item = [DVec2; 2]> + 'a {
        patch.stretches.iter().flat_map(move |stretch| {
            let [from, to] = stretch.places;
            let curve = &self.curves[stretch.curve as usize];
            let at = move |k: u32| {
                let share = f64::from(k) / f64::from(count);
                chart.flatten(curve.at(from + share * (to - from)))
            };
            (0..count).map(move |k| [at(k), at(k + 1)])
        })
    }
}
