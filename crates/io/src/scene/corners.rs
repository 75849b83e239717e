//! Operations that need the corners of solids: hull, Minkowski sum, resize,
//! projection. The solids are meshed for that; of flat faces the corners are
//! exact.

use std::collections::BTreeMap;
use std::ops::Range;

use csg::glam::{DAffine3, DMat3, DVec2, DVec3};
use csg::{
    BoundaryOptions, FillRule, Join, Limits, Made, Mesh, Mesher, Node, Primitive, Profile, Program,
    Solid,
};

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
    /// How far meshes of curved solids stray at most, since it was asked last; none if there was
    /// none.
    pub strayed: Option<f64>,
}

impl Default for Allowance {
    fn default() -> Self {
        Self {
            cells: MOST_CELLS,
            sums: MOST_SUMS,
            strayed: None,
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
        let within = SHARE * bounds.size().max_element();
        mesher = mesher.tolerance(within).normals();
        allowance.strayed = Some(
            allowance
                .strayed
                .map_or(within, |before| before.max(within)),
        );
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

/// The solids that solids are the union of, each with the map that puts it in its place.
fn leaves(solids: &[Solid]) -> Vec<(&Solid, DAffine3)> {
    let mut found = Vec::new();
    let mut pending: Vec<(&Solid, DAffine3)> =
        solids.iter().map(|s| (s, DAffine3::IDENTITY)).collect();
    while let Some((solid, map)) = pending.pop() {
        match solid.node() {
            Node::Union(operands) => pending.extend(operands.iter().map(|o| (o, map))),
            Node::Transform(Ok(inner), operand) => pending.push((operand, map * *inner)),
            Node::Named(_, operand) | Node::Colored(_, operand) => pending.push((operand, map)),
            _ => found.push((solid, map)),
        }
    }
    found
}

/// Points whose convex hull is that of the solid.
fn corners(solid: &Solid, allowance: &mut Allowance) -> Result<Vec<DVec3>, String> {
    let mut points = Vec::new();
    for (solid, map) in leaves(std::slice::from_ref(solid)) {
        match solid.node() {
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

/// Of lengths, below which they are the same: some thousand roundings, as a chain of maps may make.
const SAME: f64 = 1e-12;

/// The primitives that solids are the union of, each where it is put; none if they are no such
/// union.
fn primitives(solids: &[Solid]) -> Option<Vec<(&Primitive, DAffine3)>> {
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
    let alike = |&(_, radius): &(DVec3, f64)| (common - radius).abs() <= SAME * radius;
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
        let same = |a: f64, b: f64| (a - b).abs() <= SAME * x.length();
        let round = radii.x == radii.y
            && radii.y == radii.z
            && same(x.length(), y.length())
            && same(x.length(), z.length())
            && [x.dot(y), y.dot(z), z.dot(x)]
                .iter()
                .all(|dot| dot.abs() <= SAME * x.length_squared());
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
            let is_same = |a: f64, b: f64| (a - b).abs() <= SAME * size;
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
pub(super) fn circles(linear: DMat3, radii: DVec2) -> Option<(DVec3, f64)> {
    const SIX_DIGITS: f64 = 3e-6;
    let (x, y) = (radii.x * linear.x_axis, radii.y * linear.y_axis);
    let is_round = (x.length() - y.length()).abs() <= SIX_DIGITS * x.length()
        && x.dot(y).abs() <= SIX_DIGITS * x.length() * y.length();
    let normal = x.cross(y).try_normalize()?;
    is_round.then(|| (normal, (0.5 * (x.length() + y.length()))))
}

/// Whether two planes with these normals are parallel but for the six digits of matrices.
pub(super) fn are_parallel(one: DVec3, other: DVec3) -> bool {
    const SIX_DIGITS: f64 = 3e-6;
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
fn hull_of_discs(solids: &[Solid], allowance: &mut Allowance) -> Result<Option<Solid>, String> {
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
        let program = Program::lower(&other).map_err(|e| e.to_string())?;
        if !program.carriers().iter().all(csg::Surface::is_plane) {
            return Ok(None);
        }
        let corners = corners(&other, allowance)?;
        discs.extend(corners.into_iter().map(|corner| (corner, 0.0)));
    }
    let hull = Solid::hull_of_discs(&discs, normal);
    Ok(hull.filter(|hull| is_sound(hull, allowance)))
}

/// Whether a convex solid is meshed without doubt.
fn is_sound(solid: &Solid, allowance: &mut Allowance) -> bool {
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
        .limits(Limits::new().cells(allowance.cells.min(FEW_CELLS)))
        .tolerance(COARSE * bounds.size().max_element());
    let Ok(meshed) = mesher.mesh(&program) else {
        return false;
    };
    allowance.cells = allowance.cells.saturating_sub(meshed.report.cells_visited);
    meshed.report.is_proven() && meshed.mesh.check().euler_characteristic() == 2
}

/// The convex hull of solids.
pub(super) fn hull(solids: &[Solid], allowance: &mut Allowance) -> Result<Solid, String> {
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
    if let Some(hull) = hull_of_discs(solids, allowance)? {
        return Ok(hull);
    }
    let mut points = Vec::new();
    for solid in solids {
        points.extend(corners(solid, allowance)?);
    }
    Ok(Solid::hull(points))
}

/// The Minkowski sum: all sums of a point of each. Parts that are not convex
/// are cut into convex parts first. Rounded by balls of one size it is exact, if there are
/// few corners.
pub(super) fn minkowski(solids: Vec<Solid>, allowance: &mut Allowance) -> Result<Solid, String> {
    // In another order it is the same.
    let is_round = |solid: &Solid| balls(std::slice::from_ref(solid)).is_some();
    let (round, flat): (Vec<Solid>, Vec<Solid>) = solids.into_iter().partition(is_round);
    let kinds = [
        sum_in_order(flat, allowance)?,
        sum_in_order(round, allowance)?,
    ];
    let sum = sum_in_order(kinds.into_iter().flatten().collect(), allowance)?;
    Ok(sum.unwrap_or_else(Solid::empty))
}

/// The Minkowski sum of flat shapes. That of one with circles is what its outline moved outwards
/// encloses; others are summed as prisms.
pub(super) fn flat_sum(
    profiles: Vec<Profile>,
    allowance: &mut Allowance,
) -> Result<Profile, String> {
    let mut others = Vec::new();
    let (mut radius, mut place) = (0.0, DVec2::ZERO);
    for profile in profiles {
        match profile.as_circle() {
            Some((center, of)) => {
                radius += of;
                place += center;
            }
            None => others.push(profile),
        }
    }
    let Some(first) = others.pop() else {
        return Ok(Profile::circle(radius).translate(place));
    };
    let sum = if others.is_empty() {
        first
    } else {
        let prism = |profile| Solid::extrude(profile, -0.5..0.5);
        let prisms = others.iter().chain([&first]).map(prism).collect();
        section(&minkowski(prisms, allowance)?, allowance)?
    };
    if radius == 0.0 {
        return Ok(sum);
    }
    let moved = sum.exact_offset(radius, Join::Round);
    let moved = moved.ok_or("rounding leaves open how its outline is moved by the circles")?;
    Ok(moved.translate(place))
}

/// None of no solids.
fn sum_in_order(solids: Vec<Solid>, allowance: &mut Allowance) -> Result<Option<Solid>, String> {
    let mut solids = solids.into_iter();
    let Some(mut sum) = solids.next() else {
        return Ok(None);
    };
    for solid in solids {
        sum = match rounded(&sum, &solid, allowance)? {
            Some(rounded) => rounded,
            None => sum_of_parts(&sum, &solid, allowance)?,
        };
    }
    Ok(Some(sum))
}

/// The hulls of all sums of corners.
fn sum_of_parts(one: &Solid, other: &Solid, allowance: &mut Allowance) -> Result<Solid, String> {
    let (first, second) = (parts(one, allowance)?, parts(other, allowance)?);
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
    Ok(Solid::union(hulls))
}

/// The sum of two solids if one of them is made of balls, and the other one too, or of few flat
/// faces.
fn rounded(one: &Solid, other: &Solid, allowance: &mut Allowance) -> Result<Option<Solid>, String> {
    /// Of all parts; with more, chords of the balls are cheaper.
    const MOST_CORNERS: usize = 200;
    let of = |solid: &Solid| balls(std::slice::from_ref(solid));
    let (parts, (centers, radius)) = match (of(one), of(other)) {
        (None, None) => return Ok(None),
        (Some((ones, radius)), Some((others, other))) => {
            let parts = ones.into_iter().map(|center| vec![center]).collect();
            (parts, (others, radius + other))
        }
        (Some(balls), None) => (parts(other, allowance)?, balls),
        (None, Some(balls)) => (parts(one, allowance)?, balls),
    };
    let corners: usize = parts.iter().map(Vec::len).sum();
    if corners * centers.len() > MOST_CORNERS {
        return Ok(None);
    }
    let pairs = parts
        .iter()
        .flat_map(|part| centers.iter().map(move |&center| (part, center)));
    let hulls = pairs.map(|(part, center)| {
        let moved: Vec<DVec3> = part.iter().map(|&corner| corner + center).collect();
        Solid::hull_of_balls(&moved, radius)
    });
    Ok(hulls.collect::<Option<Vec<Solid>>>().map(Solid::union))
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

/// Normals that rise by less are level: they are in single precision, 6e-8, and were made from
/// coordinates and transforms that are rounded. Of a wall that leans by no more its shadow is off by as much of
/// its height, a hundredth of what its mesh may stray ([`SHARE`]).
const UPRIGHT: f32 = 1e-6;

/// The solid seen along z.
pub(super) fn shadow(solid: &Solid, allowance: &mut Allowance) -> Result<Profile, String> {
    let outlines = outlines(&mesh(solid, allowance)?)?;
    Ok(Profile::polygons_of(outlines, FillRule::NonZero))
}

/// What is between the triangles of a mesh that face up and the others, seen along z: the contours
/// of its shadow, and those of what is above or below some of it.
fn outlines(mesh: &Mesh) -> Result<Vec<Vec<DVec2>>, String> {
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
                return Err("its outline does not close".to_owned());
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

/// The section with the plane z = 0.
pub(super) fn section(solid: &Solid, allowance: &mut Allowance) -> Result<Profile, String> {
    let options = BoundaryOptions::new().limits(Limits::new().cells(allowance.cells));
    let exact = solid.exact_section(DAffine3::IDENTITY, &options);
    if let Some(section) = exact.map_err(|e| e.to_string())? {
        return Ok(section);
    }
    let parts = solid.cut_at(DAffine3::IDENTITY);
    let mut sections = Vec::with_capacity(2);
    for part in parts.map_err(|e| e.to_string())? {
        sections.push(mesh(&part, allowance)?.faces_in_plane());
    }
    Ok(Profile::union(sections))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn shadows_have_the_corners_of_their_outlines_alone() {
        let mut allowance = Allowance::default();
        let ball = Solid::sphere(2.0).rotate_x(0.3);
        let ring = ball.clone() - Solid::cylinder(1.0, -3.0..3.0).translate([0.25, 0.0, 0.0]);
        for (solid, area) in [(ball, 4.0 * PI), (ring, 3.0 * PI)] {
            let shadow = shadow(&solid, &mut allowance).expect("a shadow");
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
        let mesh = mesh(&post, &mut Allowance::default()).expect("a mesh");
        let outlines = outlines(&mesh).expect("outlines");
        let corners: usize = outlines.iter().map(Vec::len).sum();
        let around = |radius: f64| {
            let rim = |p: &&DVec3| p.z > 0.9 && (p.truncate().length() - radius).abs() < 1e-9;
            mesh.positions.iter().filter(rim).count()
        };
        // The floor of the pit is seen through its mouth.
        assert_eq!(corners, around(2.0) + 2 * around(1.5));
    }

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
            let nothing = &mut Allowance {
                cells: 0,
                sums: 0,
                strayed: None,
            };
            let found = corners(&solid, nothing).expect("nothing is meshed");
            assert_eq!(found, points.map(|p| p + DVec3::X));
        }
    }
}
