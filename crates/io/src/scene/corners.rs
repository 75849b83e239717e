//! Operations that need the corners of solids: hull, Minkowski sum, resize,
//! projection. The solids are meshed for that; of flat faces the corners are
//! exact.

use csg::glam::{DAffine3, DVec2, DVec3};
use csg::{FillRule, Limits, Made, Mesh, Mesher, Node, Primitive, Profile, Program, Solid};

/// How far the mesh of a curved solid may stray, as a share of its size.
const SHARE: f64 = 1e-4;
/// The most pairs of convex parts of a Minkowski sum.
const MOST_PAIRS: usize = 1000;
/// The most sums of corners in all Minkowski sums of a scene.
const MOST_SUMS: usize = 10_000_000;
/// The most cells, or blocks between planes, that the mesher may look at while a
/// scene is read: less than a second's work. None of eleven scenes that others
/// wrote with such nodes takes half as many.
const MOST_CELLS: u64 = 200_000;

/// What may still be done while a scene is read. It is counted, not timed: a text
/// is read, or refused, alike on every machine.
pub(super) struct Allowance {
    cells: u64,
    sums: usize,
}

impl Default for Allowance {
    fn default() -> Self {
        Self {
            cells: MOST_CELLS,
            sums: MOST_SUMS,
        }
    }
}

/// The mesh of a solid: exact if all its faces are flat.
fn mesh(solid: &Solid, allowance: &mut Allowance) -> Result<Mesh, String> {
    let program = Program::lower(solid).map_err(|e| e.to_string())?;
    let flat = program.carriers().iter().all(csg::Surface::is_plane);
    let mut mesher = Mesher::new().limits(Limits::new().cells(allowance.cells));
    if !flat {
        let bounds = program.bounds().map_err(|e| e.to_string())?;
        let Some(bounds) = bounds else {
            return Ok(Mesh::default());
        };
        mesher = mesher.tolerance(SHARE * bounds.size().max_element());
    }
    let meshed = mesher.mesh(&program).map_err(|error| match error {
        csg::Error::LimitReached(_) => format!(
            "what is in it takes too much work to mesh (more than {MOST_CELLS} cells for all such nodes of the scene): give simpler operands"
        ),
        other => other.to_string(),
    })?;
    allowance.cells = allowance.cells.saturating_sub(meshed.report.cells_visited);
    if meshed.report.is_proven() {
        Ok(meshed.mesh)
    } else {
        Err("what is in it could not be meshed without doubt".to_owned())
    }
}

/// Points whose convex hull is that of the solid.
fn corners(solid: &Solid, allowance: &mut Allowance) -> Result<Vec<DVec3>, String> {
    let mut points = Vec::new();
    let mut pending = vec![(solid, DAffine3::IDENTITY)];
    while let Some((solid, map)) = pending.pop() {
        match solid.node() {
            Node::Union(operands) => pending.extend(operands.iter().map(|o| (o, map))),
            Node::Transform(Ok(inner), operand) => pending.push((operand, map * *inner)),
            Node::Named(_, operand) | Node::Colored(_, operand) => pending.push((operand, map)),
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
                let positions = mesh(solid, allowance)?.positions;
                points.extend(positions.into_iter().map(|p| map.transform_point3(p)));
            }
        }
    }
    Ok(points)
}

/// The balls that a solid is the union of, as centres and their common radius.
pub(super) fn balls(solids: &[Solid]) -> Option<(Vec<DVec3>, f64)> {
    let mut centers = Vec::new();
    let mut common: Option<f64> = None;
    let mut pending: Vec<(&Solid, DAffine3)> =
        solids.iter().map(|s| (s, DAffine3::IDENTITY)).collect();
    while let Some((solid, map)) = pending.pop() {
        match solid.node() {
            Node::Union(operands) => pending.extend(operands.iter().map(|o| (o, map))),
            Node::Transform(Ok(inner), operand) => pending.push((operand, map * *inner)),
            Node::Named(_, operand) | Node::Colored(_, operand) => pending.push((operand, map)),
            Node::Primitive(Primitive::Ellipsoid { radii }) => {
                let linear = map.matrix3;
                let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
                let radius = radii.x * x.length();
                let same = |a: f64, b: f64| (a - b).abs() <= 1e-12 * x.length();
                let round = radii.x == radii.y
                    && radii.y == radii.z
                    && same(x.length(), y.length())
                    && same(x.length(), z.length())
                    && [x.dot(y), y.dot(z), z.dot(x)]
                        .iter()
                        .all(|dot| dot.abs() <= 1e-12 * x.length_squared());
                let alike = (*common.get_or_insert(radius) - radius).abs() <= 1e-12 * radius;
                if !(round && alike) {
                    return None;
                }
                centers.push(map.translation);
            }
            _ => return None,
        }
    }
    Some((centers, common?))
}

/// The convex hull of solids.
pub(super) fn hull(solids: &[Solid], allowance: &mut Allowance) -> Result<Solid, String> {
    if let Some((centers, radius)) = balls(solids)
        && let Some(rounded) = Solid::hull_of_balls(&centers, radius)
    {
        return Ok(rounded);
    }
    let mut points = Vec::new();
    for solid in solids {
        points.extend(corners(solid, allowance)?);
    }
    Ok(Solid::hull(points))
}

/// The Minkowski sum: all sums of a point of each. Parts that are not convex
/// are cut into convex parts first.
pub(super) fn minkowski(solids: Vec<Solid>, allowance: &mut Allowance) -> Result<Solid, String> {
    let mut solids = solids.into_iter();
    let Some(first) = solids.next() else {
        return Ok(Solid::empty());
    };
    let mut sum = first;
    for solid in solids {
        let (first, second) = (parts(&sum, allowance)?, parts(&solid, allowance)?);
        let pairs = first.len() * second.len();
        if pairs > MOST_PAIRS {
            return Err(format!(
                "{} by {} convex parts are more than {MOST_PAIRS} pairs: give simpler operands",
                first.len(),
                second.len()
            ));
        }
        let mut hulls = Vec::with_capacity(pairs);
        for a in &first {
            for b in &second {
                allowance.sums = allowance.sums.checked_sub(a.len() * b.len()).ok_or_else(|| {
                    format!("its operands have too many corners (more than {MOST_SUMS} pairs in all such nodes of the scene): give simpler ones")
                })?;
                let sums = a.iter().flat_map(|&p| b.iter().map(move |&q| p + q));
                hulls.push(Solid::hull(sums));
            }
        }
        sum = Solid::union(hulls);
    }
    Ok(sum)
}

/// The corners of convex parts that make up a solid.
fn parts(solid: &Solid, allowance: &mut Allowance) -> Result<Vec<Vec<DVec3>>, String> {
    let whole = mesh(solid, allowance)?;
    let parts = Solid::convex_parts(&whole).map_err(|e| e.to_string())?;
    if parts.len() == 1 {
        return Ok(vec![whole.positions]);
    }
    let corners = parts
        .into_iter()
        .map(|planes| Ok(mesh(&Solid::convex_polyhedron(planes), allowance)?.positions));
    corners.collect()
}

/// The least and greatest coordinates of a solid.
pub(super) fn bounds(
    solid: &Solid,
    allowance: &mut Allowance,
) -> Result<Option<(DVec3, DVec3)>, String> {
    Ok(mesh(solid, allowance)?.bounds())
}

/// The solid seen along z.
pub(super) fn shadow(solid: &Solid, allowance: &mut Allowance) -> Result<Profile, String> {
    let mesh = mesh(solid, allowance)?;
    let triangles = (0..mesh.triangles.len()).map(|index| mesh.corners(index));
    let seen = triangles.filter_map(|corners| {
        let [a, b, c]: [DVec2; 3] = corners.map(DVec3::truncate);
        ((b - a).perp_dot(c - a) > 0.0).then_some([a, b, c])
    });
    Ok(Profile::polygons_of(seen, FillRule::NonZero))
}

/// The section with the plane z = 0.
pub(super) fn section(solid: &Solid, allowance: &mut Allowance) -> Result<Profile, String> {
    let mut halves = Vec::with_capacity(2);
    for half in solid.halves() {
        halves.push(mesh(&half, allowance)?.faces_in_plane());
    }
    Ok(Profile::union(halves))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_is_bounded_over_all_nodes() {
        let cube = Solid::cuboid([1.0; 3]);
        // Cuboids have eight corners each, of which all are summed.
        let mut allowance = Allowance {
            sums: 100,
            ..Allowance::default()
        };
        let pair = || vec![cube.clone(), cube.clone()];
        assert!(minkowski(pair(), &mut allowance).is_ok());
        let refused = minkowski(pair(), &mut allowance).expect_err("refused");
        assert!(refused.contains("too many corners"), "{refused}");

        let mut allowance = Allowance {
            cells: 3,
            ..Allowance::default()
        };
        let notched = &cube - Solid::cuboid_between([0.0; 3], [2.0; 3]);
        let refused = (0..4).find_map(|_| bounds(&notched, &mut allowance).err());
        let refused = refused.expect("refused");
        assert!(refused.contains("too much work"), "{refused}");
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
            let nothing = &mut Allowance { cells: 0, sums: 0 };
            let found = corners(&solid, nothing).expect("nothing is meshed");
            assert_eq!(found, points.map(|p| p + DVec3::X));
        }
    }
}
