//! What a boundary representation holds.

use glam::DVec3;

use crate::arrangement::{Curve, Frame, Side};
use crate::program::{Origin, Surface};
use crate::report::Moved;

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub struct $name(u32);

        impl $name {
            /// Its number, from 0 on.
            #[must_use]
            pub fn index(self) -> usize {
                self.0 as usize
            }

            pub(super) fn new(index: usize) -> Self {
                Self(index as u32)
            }
        }
    )*};
}

ids! {
    /// Names a [`crate::brep::Shell`] of a [`Brep`].
    ShellId
    /// Names a [`crate::brep::Face`] of a [`Brep`].
    FaceId
    /// Names a [`crate::brep::Loop`] of a [`Brep`].
    LoopId
    /// Names a [`crate::brep::Coedge`] of a [`Brep`].
    CoedgeId
    /// Names an [`crate::brep::Edge`] of a [`Brep`].
    EdgeId
    /// Names a [`crate::brep::Vertex`] of a [`Brep`].
    VertexId
}

/// The exact boundary of a solid, made by [`crate::Program::boundary`].
///
/// ```
/// use csg::{Program, Solid};
///
/// // A cube with a bore: its side is one face between two circles.
/// let solid = Solid::cube(2.0) - Solid::cylinder(0.5, -2.0..2.0);
/// let brep = Program::lower(&solid)?.boundary(&Default::default())?;
/// assert_eq!((brep.shells().len(), brep.faces().len()), (1, 7));
/// assert_eq!((brep.edges().len(), brep.vertices().len()), (14, 8));
/// assert_eq!(brep.shells().next().map(|shell| shell.genus()), Some(1));
///
/// let bore = brep.faces().find(|face| !face.surface().is_plane()).expect("the bore");
/// for side in bore.loops() {
///     let edge = side.coedges().next().expect("a circle").edge();
///     assert!((edge.length().value - std::f64::consts::PI).abs() < 1e-13);
///     assert!(edge.faces().iter().any(|face| face.surface().is_plane()));
/// }
/// let volume = brep.measure().volume;
/// let exact = 8.0 - 0.5 * std::f64::consts::PI;
/// assert!((volume.value - exact).abs() <= volume.error && volume.error < 1e-12);
/// # Ok::<(), csg::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Brep {
    /// What the geometry below is about: the middle of the solid's bounds.
    pub(super) origin: DVec3,
    pub(super) surfaces: Vec<Surface>,
    pub(super) frames: Vec<Option<Frame>>,
    pub(super) curves: Vec<Curve>,
    pub(super) points: Vec<DVec3>,
    pub(super) edges: Vec<EdgeData>,
    pub(super) coedges: Vec<CoedgeData>,
    pub(super) loops: Vec<LoopData>,
    pub(super) faces: Vec<FaceData>,
    pub(super) shells: Vec<ShellData>,
    pub(super) patches: Vec<Patch>,
    pub(super) origins: Vec<Origin>,
    pub(super) moved: Option<Moved>,
    /// Bound on the volume between surfaces that were made one.
    pub(super) between: f64,
    /// By how much rounding may move points.
    pub(super) rounding: f64,
    pub(super) size: f64,
    pub(super) is_cut_at_seams: bool,
    /// Of spheres that were cut at a meridian the directions to a pole and to its middle.
    pub(super) meridians: Vec<Option<[DVec3; 2]>>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeData {
    pub(super) curve: u32,
    /// Where on the curve; the second is the greater.
    pub(super) range: [f64; 2],
    /// The first runs along the curve, the second back.
    pub(super) coedges: [CoedgeId; 2],
    pub(super) vertices: Option<[VertexId; 2]>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct CoedgeData {
    pub(super) edge: EdgeId,
    pub(super) face_loop: LoopId,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct LoopData {
    pub(super) face: FaceId,
    /// The first coedge, and how many follow each other.
    pub(super) coedges: (u32, u32),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct FaceData {
    pub(super) side: Side,
    pub(super) shell: ShellId,
    pub(super) loops: (u32, u32),
    pub(super) patches: (u32, u32),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct ShellData {
    pub(super) faces: (u32, u32),
    pub(super) genus: u32,
}

/// A part of a face that is a graph in the coordinates of a chart.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    pub(super) side: Side,
    /// Around it, with the patch on the left.
    pub(super) stretches: Vec<Stretch>,
}

/// A piece of a curve, from one place to another, and the points where these should be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    pub(super) curve: u32,
    pub(super) places: [f64; 2],
    /// How far the curve's points are from the vertices.
    pub(super) gap: f64,
}

pub(super) fn range((first, count): (u32, u32)) -> std::ops::Range<usize> {
    first as usize..(first + count) as usize
}

impl Brep {
    /// Of an empty solid.
    pub(super) fn empty() -> Self {
        Self {
            origin: DVec3::ZERO,
            surfaces: Vec::new(),
            frames: Vec::new(),
            curves: Vec::new(),
            points: Vec::new(),
            edges: Vec::new(),
            coedges: Vec::new(),
            loops: Vec::new(),
            faces: Vec::new(),
            shells: Vec::new(),
            patches: Vec::new(),
            origins: Vec::new(),
            moved: None,
            between: 0.0,
            rounding: 0.0,
            size: 0.0,
            is_cut_at_seams: false,
            meridians: Vec::new(),
        }
    }
}
