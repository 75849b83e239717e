//! Primitives as leaves of the scene text, each perhaps under one map.

use std::ops::Range;

use csg::{Plane, Primitive, Program, Solid, turn};
use glam::{DAffine3, DVec2, DVec3};

use super::facets;
use super::polyhedra;
use super::write::{across, list, number};

/// A leaf, and the map around it.
pub(super) struct Shape {
    pub map: Option<DAffine3>,
    pub node: String,
}

/// Circles for the reader; what `$fn = 0` says.
const ROUND: usize = 0;
/// Polygons with more corners would be read as circles.
const MOST_CORNERS: usize = 12;
/// How far corners and planes may be, relative to their size, from the exact
/// figure: some roundings, no more.
const SAME: f64 = 1e-14;

/// The leaf for a primitive, or why there is none.
pub(super) fn shape(primitive: &Primitive) -> Result<Shape, String> {
    match primitive {
        Primitive::Empty => Ok(Shape {
            map: None,
            node: "group();".to_owned(),
        }),
        &Primitive::Cuboid { min, max } => cuboid(min, max),
        &Primitive::Ellipsoid { radii } => {
            radii.to_array().into_iter().try_for_each(positive)?;
            let round = radii.x == radii.y && radii.y == radii.z;
            Ok(if round {
                sphere(ROUND, radii.x, None)
            } else {
                sphere(ROUND, 1.0, Some(DAffine3::from_scale(radii)))
            })
        }
        Primitive::Cylinder { radii, z: Some(z) } => {
            radii.to_array().into_iter().try_for_each(positive)?;
            if radii.x == radii.y {
                return cylinder(ROUND, radii.x, radii.x, z, None);
            }
            let map = DAffine3::from_scale(radii.extend(1.0));
            cylinder(ROUND, 1.0, 1.0, z, Some(map))
        }
        &Primitive::Frustum { bottom, top, ref z } => cylinder(ROUND, bottom, top, z, None),
        Primitive::Prism { polygon, z } => prism(polygon, z),
        Primitive::ConvexPolyhedron(planes) => match faceted(planes) {
            Some(shape) => Ok(shape),
            None => polyhedra::polyhedron(&Solid::convex_polyhedron(planes.iter().copied())).map(
                |mesh| Shape {
                    map: None,
                    node: mesh.map_or_else(|| "group();".to_owned(), |mesh| polyhedra::node(&mesh)),
                },
            ),
        },
        Primitive::Polyhedron(polyhedron) => {
            let (vertices, triangles) = (polyhedron.vertices(), polyhedron.triangles());
            let mesh = csg::Mesh::new(vertices.to_vec(), triangles.to_vec());
            Ok(Shape {
                map: None,
                node: polyhedra::node(&mesh),
            })
        }
        other => Err(format!("{} has no end, and no node", other.kind())),
    }
}

fn positive(size: f64) -> Result<(), String> {
    if size > 0.0 && size.is_finite() {
        Ok(())
    } else {
        Err(format!("the size {size} is not positive and finite"))
    }
}

fn cuboid(min: DVec3, max: DVec3) -> Result<Shape, String> {
    let size = max - min;
    size.to_array().into_iter().try_for_each(positive)?;
    let center = min == -max;
    let offset = !center && min != DVec3::ZERO;
    Ok(Shape {
        map: offset.then(|| DAffine3::from_translation(min)),
        node: format!(
            "cube(size = {}, center = {center});",
            list(&size.to_array())
        ),
    })
}

/// `$fn` and the two finenesses that do not matter beside it.
fn fineness(fragments: usize) -> String {
    format!("$fn = {fragments}, $fa = 12, $fs = 2")
}

fn sphere(fragments: usize, radius: f64, map: Option<DAffine3>) -> Shape {
    let fineness = fineness(fragments);
    Shape {
        map,
        node: format!("sphere({fineness}, r = {});", number(radius)),
    }
}

/// A cylinder or frustum, standing on the ground or centred as it is, else
/// moved along z; `map` leaves z alone.
fn cylinder(
    fragments: usize,
    bottom: f64,
    top: f64,
    z: &Range<f64>,
    map: Option<DAffine3>,
) -> Result<Shape, String> {
    let height = z.end - z.start;
    positive(height)?;
    positive(bottom.max(top))?;
    if !(bottom >= 0.0 && top >= 0.0) {
        return Err("a radius is negative".to_owned());
    }
    let center = z.start == -z.end;
    let lift = if center { 0.0 } else { z.start };
    let map = (map.is_some() || lift != 0.0).then(|| {
        let mut map = map.unwrap_or(DAffine3::IDENTITY);
        map.translation.z += lift;
        map
    });
    let fineness = fineness(fragments);
    let [height, bottom, top] = [height, bottom, top].map(number);
    Ok(Shape {
        map,
        node: format!(
            "cylinder({fineness}, h = {height}, r1 = {bottom}, r2 = {top}, center = {center});"
        ),
    })
}

/// A prism: over an affine image of a regular polygon as a cylinder, else extruded.
fn prism(polygon: &[DVec2], z: &Range<f64>) -> Result<Shape, String> {
    let n = polygon.len();
    positive(z.end - z.start)?;
    let extruded = || {
        // What is wrong with it, if anything is.
        Program::lower(&Solid::prism(polygon.iter().copied(), z.clone()))
            .map_err(|e| e.to_string())?;
        let (node, lift) = polyhedra::extrusion(polygon, z);
        let map = (lift != 0.0).then(|| DAffine3::from_translation(lift * DVec3::Z));
        Ok(Shape { map, node })
    };
    if !(3..=MOST_CORNERS).contains(&n) {
        return extruded();
    }
    let radius = polygon[0].x;
    let deviation = |x: DVec2, y: DVec2, center: DVec2| {
        let distance = |(k, corner): (usize, &DVec2)| {
            let unit = turn(k, n);
            corner.distance(center + unit.x * x + unit.y * y)
        };
        polygon.iter().enumerate().map(distance).fold(0.0, f64::max)
    };
    let standing = deviation(radius * DVec2::X, radius * DVec2::Y, DVec2::ZERO);
    if radius > 0.0 && standing <= SAME * radius {
        return cylinder(n, radius, radius, z, None);
    }
    // The constant and first Fourier coefficients of the corners are the
    // centre and columns of the map from the regular polygon, if there is one.
    let center = polygon.iter().sum::<DVec2>() / n as f64;
    let (mut x, mut y) = (DVec2::ZERO, DVec2::ZERO);
    for (k, &corner) in polygon.iter().enumerate() {
        let unit = turn(k, n) * (2.0 / n as f64);
        x += unit.x * (corner - center);
        y += unit.y * (corner - center);
    }
    let size = polygon.iter().map(|c| c.length()).fold(0.0, f64::max);
    let misses = deviation(x, y, center);
    if misses.is_nan() || misses > SAME * size {
        return extruded();
    }
    cylinder(n, 1.0, 1.0, z, Some(across(x, y, center)))
}

/// The faceted sphere or frustum that has these planes.
fn faceted(planes: &[Plane]) -> Option<Shape> {
    (3..=MOST_CORNERS)
        .find_map(|n| {
            let (radius, found) = faceted_sphere(planes, n)?;
            same(planes, &found).then(|| sphere(n, radius, None))
        })
        .or_else(|| (3..=MOST_CORNERS).find_map(|n| faceted_frustum(planes, n)))
}

fn faceted_sphere(planes: &[Plane], n: usize) -> Option<(f64, Vec<Plane>)> {
    let rings = facets::rings(n);
    if planes.len() != n * (rings - 1) + 2 {
        return None;
    }
    let radius = planes[0].offset / turn(1, 4 * rings).x;
    Some((radius, facets::sphere(radius, n)))
}

fn faceted_frustum(planes: &[Plane], n: usize) -> Option<Shape> {
    let (sides, ends) = planes.split_at_checked(n)?;
    let slope = sides[0].normal.z;
    let offset = sides[0].offset;
    let apex = offset / slope;
    let z = match ends {
        [lower, upper] => -lower.offset..upper.offset,
        [base] if slope > 0.0 => -base.offset..apex,
        [base] if slope < 0.0 => apex..base.offset,
        _ => return None,
    };
    let z = snapped(z);
    let across = turn(1, 2 * n).x;
    let radius = |z: f64| (offset - slope * z) / across;
    let whole = ends.len() == 1;
    let bottom = if whole && slope < 0.0 {
        0.0
    } else {
        radius(z.start)
    };
    let top = if whole && slope > 0.0 {
        0.0
    } else {
        radius(z.end)
    };
    if same(planes, &facets::frustum(bottom, top, z.clone(), n)) {
        cylinder(n, bottom, top, &z, None).ok()
    } else {
        None
    }
}

/// An extent that stands on the ground or is centred but for roundings, made
/// exactly so.
fn snapped(z: Range<f64>) -> Range<f64> {
    let nearly_zero = |value: f64| value.abs() <= SAME * (z.end - z.start);
    if nearly_zero(z.start) {
        0.0..z.end
    } else if nearly_zero(z.start + z.end) {
        let half = 0.5 * (z.end - z.start);
        -half..half
    } else {
        z
    }
}

/// Whether the planes are the same one by one, but for roundings.
fn same(planes: &[Plane], others: &[Plane]) -> bool {
    let size = planes.iter().map(|p| p.offset.abs()).fold(0.0, f64::max);
    planes.len() == others.len()
        && planes.iter().zip(others).all(|(plane, other)| {
            plane
                .normal
                .abs_diff_eq(other.normal, SAME * other.normal.length())
                && (plane.offset - other.offset).abs() <= SAME * size
        })
}
