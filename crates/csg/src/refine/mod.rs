//! From a mesh whose topology is right to one with just enough triangles: no
//! point of it is farther than the tolerance from the boundary, nor the
//! reverse.
//!
//! 1. [`coarsen`] takes out what vertices can be spared.
//! 2. [`curves`] finds for every curve between two faces the points that it
//!    needs, and [`grow`] puts them in, coarse to fine, and those that the
//!    faces need; [`flips`] keeps triangles in shape.
//! 3. Faces that bend both ways are only cut into large triangles that way
//!    ([`patches`]), which [`tessellate`] then fills with small ones in one step.
//! 4. [`deviation`] bounds how far the result strays.
//!
//! Where triangles of the result run through each other, [`mod@separate`] cuts them up.
//!
//! Vertices never leave their surfaces. One thread does all but the
//! tessellation, in a fixed order.

mod beside;
mod chains;
mod coarsen;
mod conics;
mod contacts;
mod curves;
pub(crate) mod deviation;
mod flips;
mod grow;
mod half_edges;
mod patch;
mod patches;
mod project;
mod regions;
mod round;
mod separate;
mod shape;
mod smooth;
mod tessellate;

use glam::DVec3;
use rustc_hash::FxHashMap;

use self::grow::Grower;
use self::half_edges::{HalfEdges, NONE, first_of};
use self::regions::Way;
pub(crate) use self::separate::{Parting, folded, separate};
use self::tessellate::{Fine, INNER, ON_SIDE};
use crate::control::Control;
use crate::error::Error;
use crate::evaluation::Borders;
use crate::program::Surface;

/// What is asked of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Goal {
    /// The largest distance between mesh and boundary, both ways.
    pub tolerance: f64,
    /// What is farther off than this is reported.
    pub promised: f64,
    /// Whether vertices lie evenly along curves, and not as chance would have it:
    /// those that the tolerance needs are kept.
    pub even_curves: bool,
    /// The largest angle that a surface may turn along an edge, in radians.
    pub angle: Option<f64>,
    /// For every surface that needs a smaller tolerance the share that it gets:
    /// where faces run close to each other.
    pub tight: FxHashMap<u32, f64>,
}

impl Goal {
    /// Coarser by a factor, about evenly in chords and angles.
    pub fn loosened(&self, factor: f64) -> Self {
        Self {
            tolerance: factor * self.tolerance,
            angle: self
                .angle
                .map(|angle| (factor.sqrt() * angle).min(std::f64::consts::PI)),
            ..self.clone()
        }
    }

    /// What is left of it for the mesh if surfaces were moved by a distance.
    pub fn less(&self, moved: f64) -> Self {
        Self {
            tolerance: self.tolerance - moved,
            promised: self.promised - moved,
            ..self.clone()
        }
    }

    /// The tolerance on a surface.
    pub fn tolerance_on(&self, surface: u32) -> f64 {
        self.tolerance * self.tight.get(&surface).unwrap_or(&1.0)
    }

    /// The distance to aim for on a surface, so that what is found by curvature
    /// meets the tolerance as it is bounded.
    fn aim_on(&self, surface: u32) -> f64 {
        0.98 * self.tolerance_on(surface)
    }
}

/// A mesh whose triangles know their surfaces.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surfaced {
    /// In the frame of the surfaces.
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle its group. Groups are kept apart.
    pub groups: Vec<u32>,
    /// For each group its surface.
    pub surface_of_group: Vec<u32>,
    /// Edges between groups of one surface whose curves are known.
    pub borders: Borders,
}

/// Why a promise could not be kept at some place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unkept {
    /// The mesh is no closed manifold.
    NotManifold,
    /// A curve between two faces could not be followed.
    Lost,
    /// A vertex could not be brought to its surfaces without a fold.
    Folded,
    /// The mesh runs through itself.
    Crossing,
    /// A triangle faces into the solid.
    TurnedOver,
    /// A triangle or a chord for which the tolerance could not be proven.
    Far,
}

impl Unkept {
    pub(crate) const fn describe(self) -> &'static str {
        match self {
            Self::NotManifold => "mesh that is not manifold: left as it is, whatever the tolerance",
            Self::Lost => "curve between two faces that could not be followed: not cut up",
            Self::Folded => "vertex that could not be put on its surfaces without a fold",
            Self::Crossing => "place where the mesh runs through itself",
            Self::TurnedOver => "triangle that faces into the solid",
            Self::Far => "place where the tolerance could not be proven to be kept",
        }
    }
}

/// What came of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outcome {
    /// The largest distance between mesh and boundary, a bound; and where.
    pub deviation: f64,
    pub farthest: DVec3,
    /// In the frame of the surfaces.
    pub unkept: Vec<(Unkept, DVec3)>,
    /// Surfaces for which a smaller tolerance may help; some several times.
    pub tighter: Vec<u32>,
}

impl Outcome {
    /// Notes a bound of the distance at a place, of the mesh from surfaces.
    fn note(&mut self, bound: f64, place: DVec3, surfaces: &[u32], promised: f64) {
        if bound > self.deviation {
            (self.deviation, self.farthest) = (bound, place);
        }
        if bound > promised {
            self.unkept.push((Unkept::Far, place));
            self.tighter.extend(surfaces);
        }
    }
}

/// A point nearer to a surface than this share of the mesh's size lies on it.
const ON_SURFACE: f64 = 1e-12;

/// About what is held for each triangle at a time.
const BYTES_PER_TRIANGLE: usize = 200;

/// Brings a mesh to the tolerance with as few triangles as it knows how.
///
/// `surfaces` are in the frame of the positions. The mesh must be closed,
/// oriented and manifold, its vertices on the surfaces of their triangles to
/// rounding. Some hundred nanoseconds a triangle, of the mesh given or that
/// returned.
pub(crate) fn to_tolerance(
    surfaced: &mut Surfaced,
    surfaces: &[Surface],
    goal: &Goal,
    control: &Control,
) -> Result<Outcome, Error> {
    let precision = precision(&surfaced.positions);
    let Some(mut mesh) = HalfEdges::new(surfaced, surfaces) else {
        let place = surfaced.positions.first().copied().unwrap_or_default();
        return Ok(Outcome {
            deviation: f64::INFINITY,
            farthest: place,
            unkept: vec![(Unkept::NotManifold, place)],
            tighter: Vec::new(),
        });
    };
    control.check_memory(BYTES_PER_TRIANGLE * surfaced.triangles.len())?;
    mesh.fix_contacts();
    coarsen::coarsen(&mut mesh, goal);
    control.check()?;
    let mut grower = Grower::new(&mut mesh, goal, precision);
    grower.cut_contacts();
    grower.run(control)?;
    let (outcome, fine) = (grower.outcome, grower.fine);
    hand_back(&mesh, &fine, surfaced);
    control.check_triangles(surfaced.triangles.len())?;
    Ok(outcome)
}

/// How near points must come to their surfaces.
fn precision(positions: &[DVec3]) -> f64 {
    let size = positions
        .iter()
        .fold(0.0f64, |m, p| m.max(p.abs().max_element()));
    ON_SURFACE * size
}

/// The mesh without what is gone, and with what was tessellated.
fn hand_back(mesh: &HalfEdges<'_>, fine: &Fine, surfaced: &mut Surfaced) {
    surfaced.triangles.clear();
    surfaced.groups.clear();
    let mut places = vec![NONE; mesh.positions.len()];
    let mut places_on_sides = vec![NONE; fine.points.len()];
    let mut positions = Vec::with_capacity(mesh.positions.len() + fine.points.len());
    for subdivision in &fine.subdivisions {
        let first_inner = positions.len() as u32;
        positions.extend_from_slice(&subdivision.inner);
        let mut place = |vertex: u32| {
            let (place, position) = if vertex >= ON_SIDE {
                let point = (vertex - ON_SIDE) as usize;
                (&mut places_on_sides[point], fine.points[point])
            } else if vertex >= INNER {
                return vertex - INNER + first_inner;
            } else {
                (&mut places[vertex as usize], mesh.at(vertex))
            };
            if *place == NONE {
                *place = positions.len() as u32;
                positions.push(position);
            }
            *place
        };
        let group = mesh.region(first_of(subdivision.large)).group;
        let triangles = subdivision
            .triangles
            .iter()
            .map(|corners| corners.map(&mut place));
        surfaced.triangles.extend(triangles);
        surfaced.groups.resize(surfaced.triangles.len(), group);
    }
    let mut place = |vertex: u32| {
        let place = &mut places[vertex as usize];
        if *place == NONE {
            *place = positions.len() as u32;
            positions.push(mesh.at(vertex));
        }
        *place
    };
    for triangle in 0..mesh.triangle_count() {
        if mesh.is_gone(triangle) || mesh.region(first_of(triangle)).way == Way::Done {
            continue;
        }
        surfaced
            .triangles
            .push(mesh.triangle(triangle).map(&mut place));
        surfaced.groups.push(mesh.region(first_of(triangle)).group);
    }
    surfaced.positions = positions;
    let renumbered = |(ends, &other): (&[u32; 2], &u32)| {
        let mut ends = ends.map(|end| places[end as usize]);
        ends.sort_unstable();
        (!ends.contains(&NONE)).then_some((ends, other))
    };
    surfaced.borders = mesh.borders.iter().filter_map(renumbered).collect();
}
