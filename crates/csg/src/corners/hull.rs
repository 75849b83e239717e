//! Hulls of solids.

use std::ops::Range;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use super::{Faceting, corners, leaves};
use crate::error::Error;
use crate::limits::Limits;
use crate::mesher::Mesher;
use crate::numeric::tolerance::{SAME_LENGTH, SIX_DIGITS};
use crate::program::Program;
use crate::solid::profile::Profile;
use crate::solid::{Node, Primitive, Solid};

/// The primitives that solids are the union of, each where it is put; none if they are no such
/// union.
pub(super) fn primitives(solids: &[Solid]) -> Option<Vec<(&Primitive, DAffine3)>> {
    let leaves = leaves(solids).into_iter();
    let found = leaves.map(|(solid, map)| match solid.node() {
        Node::Primitive(primitive) => Some((primitive, map)),
        _ => None,
    });
    found.collect()
}

/// The balls that a solid is the union of, as centres and their common radius.
pub(super) fn balls(solids: &[Solid]) -> Option<(Vec<DVec3>, f64)> {
    let all = all_balls(solids)?;
    let &(_, common) = all.first()?;
    let alike = |&(_, radius): &(DVec3, f64)| (common - radius).abs() <= SAME_LENGTH * radius;
    let centers = all.iter().map(|(center, _)| *center).collect();
    all.iter().all(alike).then_some((centers, common))
}

/// The balls that solids are the union of, as centres and radii.
fn all_balls(solids: &[Solid]) -> Option<Vec<(DVec3, f64)>> {
    let mut found = Vec::new();
    for (primitive, map) in primitives(solids)? {
        let Primitive::Ellipsoid { radii } = primitive else {
            return None;
        };
        let linear = map.matrix3;
        let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
        let radius = radii.x * x.length();
        let same = |a: f64, b: f64| (a - b).abs() <= SAME_LENGTH * x.length();
        let round = radii.x == radii.y
            && radii.y == radii.z
            && same(x.length(), y.length())
            && same(x.length(), z.length())
            && [x.dot(y), y.dot(z), z.dot(x)]
                .iter()
                .all(|dot| dot.abs() <= SAME_LENGTH * x.length_squared());
        if !round {
            return None;
        }
        found.push((map.translation, radius));
    }
    Some(found)
}

/// Cylinders with their ends in two planes.
struct Upright {
    /// From where these are across the z axis.
    frame: DAffine3,
    discs: Vec<(DVec2, f64)>,
    z: Range<f64>,
}

impl Upright {
    /// Cylinders that solids are the union of, if they are.
    fn of(solids: &[Solid]) -> Option<Self> {
        let mut known: Option<Self> = None;
        for (primitive, map) in primitives(solids)? {
            let Primitive::Cylinder { radii, z: Some(z) } = primitive else {
                return None;
            };
            let [x, y, up] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
            let upright = known.get_or_insert_with(|| {
                let axis = up.normalize_or_zero();
                let (x, y) = axis.any_orthonormal_pair();
                Self {
                    frame: DAffine3::from_mat3(DMat3::from_cols(x, y, axis)),
                    discs: Vec::new(),
                    z: f64::NAN..f64::NAN,
                }
            });
            let axis = upright.frame.matrix3.z_axis;
            let ends = [z.start, z.end].map(|z| map.transform_point3(z * DVec3::Z));
            let heights = ends.map(|end| axis.dot(end));
            let (low, high) = (heights[0].min(heights[1]), heights[0].max(heights[1]));
            if upright.discs.is_empty() {
                upright.z = low..high;
            }
            let radius = radii.x * x.length();
            let size = ends[0].length().max(ends[1].length()).max(radius);
            let is_same = |a: f64, b: f64| (a - b).abs() <= SAME_LENGTH * size;
            let is_upright = radii.x == radii.y
                && is_same(radius, radii.y * y.length())
                && is_same(radius * x.dot(y) / x.length_squared(), 0.0)
                && [x, y]
                    .iter()
                    .all(|v| is_same(radius * axis.dot(*v) / v.length(), 0.0))
                && is_same(up.cross(axis).length() / up.length() * size, 0.0)
                && is_same(low, upright.z.start)
                && is_same(high, upright.z.end);
            if !is_upright {
                return None;
            }
            let flat = upright.frame.matrix3.transpose() * ends[0];
            upright.discs.push((flat.truncate(), radius));
        }
        known
    }
}

/// The normal of the plane in which a map makes circles of circles across the z axis, and how many
/// times as large these are; none if it makes ellipses of them.
///
/// Of ellipses nobody can tell those that are meant for circles, but for the six digits of the
/// matrices in which they are turned.
#[must_use]
pub fn circles(linear: DMat3, radii: DVec2) -> Option<(DVec3, f64)> {
    let (x, y) = (radii.x * linear.x_axis, radii.y * linear.y_axis);
    let is_round = (x.length() - y.length()).abs() <= SIX_DIGITS * x.length()
        && x.dot(y).abs() <= SIX_DIGITS * x.length() * y.length();
    let normal = x.cross(y).try_normalize()?;
    is_round.then(|| (normal, (0.5 * (x.length() + y.length()))))
}

/// Whether two planes with these normals are parallel but for the six digits of matrices.
#[must_use]
pub fn are_parallel(one: DVec3, other: DVec3) -> bool {
    one.cross(other).length() <= SIX_DIGITS
}

/// The ends of a cylinder, cone or frustum, as discs, each a centre and a radius, and their normal.
fn ends(primitive: &Primitive, map: DAffine3) -> Option<([(DVec3, f64); 2], DVec3)> {
    let (radii, [low, high], z) = match primitive {
        Primitive::Cylinder { radii, z: Some(z) } => (*radii, [1.0; 2], z),
        Primitive::Frustum { bottom, top, z } => (DVec2::ONE, [*bottom, *top], z),
        _ => return None,
    };
    let (normal, size) = circles(map.matrix3, radii)?;
    let end = |z: f64, share: f64| (map.transform_point3(z * DVec3::Z), share * size);
    Some(([end(z.start, low), end(z.end, high)], normal))
}

/// The hull of cylinders, cones and frusta with parallel axes and of what has flat faces; none if
/// other solids are among these, or it would not be meshed without doubt.
fn hull_of_discs(solids: &[Solid], faceting: &mut Faceting) -> Result<Option<Solid>, Error> {
    let mut discs = Vec::new();
    let mut normal = None;
    let mut others = Vec::new();
    for (leaf, map) in leaves(solids) {
        let ends = match leaf.node() {
            Node::Primitive(primitive) => ends(primitive, map),
            _ => None,
        };
        let Some((ends, own)) = ends else {
            others.push(leaf.affine(map));
            continue;
        };
        if !are_parallel(own, *normal.get_or_insert(own)) {
            return Ok(None);
        }
        discs.extend(ends);
    }
    let Some(normal) = normal else {
        return Ok(None);
    };
    for other in others {
        let program = Program::lower(&other)?;
        if !program.is_polyhedral() {
            return Ok(None);
        }
        let corners = corners(&other, faceting)?;
        discs.extend(corners.into_iter().map(|corner| (corner, 0.0)));
    }
    let hull = Solid::hull_of_discs(&discs, normal);
    Ok(hull.filter(|hull| is_sound(hull, faceting)))
}

/// Whether a convex solid is meshed without doubt.
fn is_sound(solid: &Solid, faceting: &mut Faceting) -> bool {
    /// What is meshed without doubt takes some dozens.
    const FEW_CELLS: u64 = 2000;
    /// Of its size.
    const COARSE: f64 = 1e-3;
    let Ok(program) = Program::lower(solid) else {
        return false;
    };
    let Ok(Some(bounds)) = program.bounds() else {
        return false;
    };
    let mesher = Mesher::new()
        .limits(Limits::new().cells(faceting.cells[0].min(FEW_CELLS)))
        .tolerance(COARSE * bounds.size().max_element());
    let Ok(meshed) = mesher.mesh(&program) else {
        return false;
    };
    faceting.cells[0] = faceting.cells[0].saturating_sub(meshed.report.cells_visited);
    meshed.report.is_proven() && meshed.mesh.check().euler_characteristic() == 2
}

impl Solid {
    /// The convex hull of solids: exact of balls, of cylinders with their ends in two planes, of what has
    /// flat faces, and mostly of cylinders, cones and frusta with parallel axes and of what has flat
    /// faces; else the polyhedron of the corners of meshes, which lies within the hull. Nothing of
    /// nothing but empty solids.
    ///
    /// Meshes of what is not exact, and n log n for their n corners.
    ///
    /// # Errors
    /// What is wrong with a solid, one without end, [`Error::InvalidOption`] for more work than
    /// `faceting` has left.
    pub fn hull_of(solids: &[Self], faceting: &mut Faceting) -> Result<Self, Error> {
        if solids.is_empty() {
            return Ok(Self::empty());
        }
        faceting.standing_in(|faceting| hull_of(solids, faceting))
    }
}

fn hull_of(solids: &[Solid], faceting: &mut Faceting) -> Result<Solid, Error> {
    if let Some((centers, radius)) = balls(solids)
        && let Some(rounded) = Solid::hull_of_balls(&centers, radius)
    {
        return Ok(rounded);
    }
    if let Some(balls) = all_balls(solids)
        && let Some(hull) = Solid::hull_of_unequal_balls(&balls)
    {
        return Ok(hull);
    }
    if let Some(Upright { frame, discs, z }) = Upright::of(solids) {
        return Ok(Solid::extrude(&Profile::hull_of_discs(discs), z).affine(frame));
    }
    if let Some(hull) = hull_of_discs(solids, faceting)? {
        return Ok(hull);
    }
    let mut points = Vec::new();
    for solid in solids {
        points.extend(corners(solid, faceting)?);
    }
    if points.is_empty() {
        return Ok(Solid::empty());
    }
    Ok(Solid::hull(points))
}
