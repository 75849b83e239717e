//! Primitives as conjunctions of half-spaces, in their own coordinates.

use crate::elementary;
use std::ops::Range;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::error::NodeFault;
use crate::numeric::tolerance::{COORDINATE, IN_PROFILE, WHOLE_TURN};
use crate::solid::polyhedron::FEW_FACES;
use crate::solid::{Plane, Polyhedron, Primitive};
use crate::surface::{Kind, Surface, from_coefficients, is_far};

/// A primitive as half-spaces: all must hold; none at all is all of space.
pub(super) enum LocalShape {
    /// A constant: all of space, or nothing.
    Constant(bool),
    /// The intersection of f <= 0 over these surfaces.
    HalfSpaces(Vec<Surface>),
    /// A closed surface of many faces.
    Polyhedron(Arc<Polyhedron>),
}

/// Lengths beyond these would leave the range of f64 when multiplied.
const LENGTHS: Range<f64> = 1e-100..1e100;

fn positive(what: &'static str, value: f64) -> Result<f64, NodeFault> {
    if !(value > 0.0 && value.is_finite()) {
        Err(NodeFault::NotPositive { what, value })
    } else if LENGTHS.contains(&value) {
        Ok(value)
    } else {
        Err(NodeFault::OutOfRange { what })
    }
}

fn coordinate(what: &'static str, value: f64) -> Result<f64, NodeFault> {
    if !value.is_finite() {
        Err(NodeFault::NotFinite { what })
    } else if value.abs() < LENGTHS.end {
        Ok(value)
    } else {
        Err(NodeFault::OutOfRange { what })
    }
}

fn point(what: &'static str, value: DVec3) -> Result<DVec3, NodeFault> {
    for component in value.to_array() {
        coordinate(what, component)?;
    }
    Ok(value)
}

/// xx dx² + yy dy² + zz dz² + c about `anchor`.
fn separable(kind: Kind, anchor: DVec3, squares: DVec3, constant: f64) -> Surface {
    Surface {
        anchor,
        quadratic: [squares.x, squares.y, squares.z, 0.0, 0.0, 0.0],
        linear: DVec3::ZERO,
        constant,
        kind,
    }
}

/// The two planes that bound an extent along z.
fn z_slab(z: &Range<f64>) -> Result<[Surface; 2], NodeFault> {
    let bottom = coordinate("the lower z", z.start)?;
    let top = coordinate("the upper z", z.end)?;
    positive("the height", top - bottom)?;
    Ok([
        Surface::plane(DVec3::new(0.0, 0.0, bottom), -DVec3::Z),
        Surface::plane(DVec3::new(0.0, 0.0, top), DVec3::Z),
    ])
}

/// 1/r² for each radius, scaled by the least radius squared so that the
/// largest is 1; and that least radius.
fn inverse_squares(radii: DVec3, what: &'static str) -> Result<(DVec3, f64), NodeFault> {
    for radius in radii.to_array() {
        positive(what, radius)?;
    }
    let least = radii.min_element();
    let ratio = DVec3::splat(least) / radii;
    Ok((ratio * ratio, least))
}

/// The half-spaces of `primitive`, or what is wrong with its arguments.
pub(super) fn half_spaces(primitive: &Primitive) -> Result<LocalShape, NodeFault> {
    let surfaces = match primitive {
        Primitive::Empty => return Ok(LocalShape::Constant(false)),
        Primitive::Space => return Ok(LocalShape::Constant(true)),
        &Primitive::HalfSpace {
            point: anchor,
            normal,
        } => {
            let normal = direction("the normal", normal)?;
            vec![Surface::plane(
                point("the point on the plane", anchor)?,
                normal,
            )]
        }
        &Primitive::Quadric(coefficients) => vec![from_coefficients(coefficients)?],
        &Primitive::Cuboid { min, max } => cuboid(min, max)?,
        &Primitive::Ellipsoid { radii } => {
            let (squares, least) = inverse_squares(radii, "a radius")?;
            vec![separable(
                Kind::Ellipsoid,
                DVec3::ZERO,
                squares,
                -least * least,
            )]
        }
        Primitive::Cylinder { radii, z } => {
            // A third radius that does not bind keeps the scaling in one place.
            let across = radii.extend(radii.max_element());
            let (squares, least) = inverse_squares(across, "a radius")?;
            let squares = DVec3::new(squares.x, squares.y, 0.0);
            let Some(z) = z else {
                let wall = separable(Kind::EllipticCylinder, DVec3::ZERO, squares, -least * least);
                return Ok(LocalShape::HalfSpaces(vec![wall]));
            };
            let [bottom, top] = z_slab(z)?;
            // Anchored within its height: digits are lost with distance from it.
            let anchor = DVec3::new(0.0, 0.0, 0.5 * z.start + 0.5 * z.end);
            let wall = separable(Kind::EllipticCylinder, anchor, squares, -least * least);
            vec![wall, bottom, top]
        }
        &Primitive::Frustum { bottom, top, ref z } => frustum(bottom, top, z)?,
        &Primitive::InfiniteCone { slope } => {
            let slope = positive("the tangent of the half-angle", slope)?;
            vec![
                cone(DVec3::ZERO, slope),
                Surface::plane(DVec3::ZERO, -DVec3::Z),
            ]
        }
        &Primitive::Paraboloid { scales } => {
            let across = scales.extend(scales.max_element());
            let (squares, least) = inverse_squares(across, "a scale")?;
            vec![Surface {
                linear: DVec3::new(0.0, 0.0, -least * least),
                ..separable(
                    Kind::EllipticParaboloid,
                    DVec3::ZERO,
                    DVec3::new(squares.x, squares.y, 0.0),
                    0.0,
                )
            }]
        }
        &Primitive::HyperboloidOneSheet { radii } => {
            let (squares, least) = inverse_squares(radii, "a radius")?;
            let squares = squares * DVec3::new(1.0, 1.0, -1.0);
            vec![separable(
                Kind::HyperboloidOneSheet,
                DVec3::ZERO,
                squares,
                -least * least,
            )]
        }
        &Primitive::HyperboloidTwoSheets { radii } => {
            let (squares, least) = inverse_squares(radii, "a radius")?;
            let squares = squares * DVec3::new(1.0, 1.0, -1.0);
            vec![separable(
                Kind::HyperboloidTwoSheets,
                DVec3::ZERO,
                squares,
                least * least,
            )]
        }
        Primitive::ConvexPolyhedron(planes) => {
            if planes.is_empty() {
                return Err(NodeFault::NoOperands {
                    operation: "convex polyhedron",
                });
            }
            let surfaces = planes.iter().map(face).collect::<Result<_, _>>()?;
            if planes.len() > FEW_FACES
                && let Some(polyhedron) = Polyhedron::within(planes)
            {
                return Ok(LocalShape::Polyhedron(Arc::new(polyhedron)));
            }
            surfaces
        }
        Primitive::Prism { polygon, z } => {
            let surfaces = prism(polygon, z)?;
            if polygon.len() > FEW_FACES
                && let Some(polyhedron) = upright(polygon, z, &surfaces)
            {
                return Ok(LocalShape::Polyhedron(Arc::new(polyhedron)));
            }
            surfaces
        }
        Primitive::Polyhedron(polyhedron) => {
            return Ok(LocalShape::Polyhedron(Arc::clone(polyhedron)));
        }
    };
    Ok(LocalShape::HalfSpaces(surfaces))
}

fn direction(what: &'static str, normal: DVec3) -> Result<DVec3, NodeFault> {
    if !normal.is_finite() {
        return Err(NodeFault::NotFinite { what });
    }
    (normal / normal.abs().max_element())
        .try_normalize()
        .ok_or(NodeFault::ZeroDirection { what })
}

fn cuboid(min: DVec3, max: DVec3) -> Result<Vec<Surface>, NodeFault> {
    point("the box's least corner", min)?;
    point("the box's greatest corner", max)?;
    let mut surfaces = Vec::with_capacity(6);
    let middle = 0.5 * min + 0.5 * max;
    for (axis, unit) in DVec3::AXES.into_iter().enumerate() {
        positive("a side of the box", max[axis] - min[axis])?;
        for (bound, outward) in [(min[axis], -unit), (max[axis], unit)] {
            let mut anchor = middle;
            anchor[axis] = bound;
            surfaces.push(Surface::plane(anchor, outward));
        }
    }
    Ok(surfaces)
}

/// x² + y² - (slope z)² about the apex: both nappes. Scaled so that the
/// largest coefficient is 1.
fn cone(apex: DVec3, slope: f64) -> Surface {
    let scale = slope.max(1.0);
    let across = 1.0 / (scale * scale);
    let along = (slope / scale) * (slope / scale);
    separable(Kind::Cone, apex, DVec3::new(across, across, -along), 0.0)
}

fn frustum(bottom: f64, top: f64, z: &Range<f64>) -> Result<Vec<Surface>, NodeFault> {
    for (what, radius) in [("the bottom radius", bottom), ("the top radius", top)] {
        if radius != 0.0 {
            positive(what, radius)?;
        }
    }
    let widest = positive("the larger radius", bottom.max(top))?;
    let [lower, upper] = z_slab(z)?;
    let height = z.end - z.start;
    let slope = (top - bottom) / height;
    if bottom == top {
        let anchor = DVec3::new(0.0, 0.0, 0.5 * z.start + 0.5 * z.end);
        let wall = separable(
            Kind::EllipticCylinder,
            anchor,
            DVec3::new(1.0, 1.0, 0.0),
            -widest * widest,
        );
        return Ok(vec![wall, lower, upper]);
    }
    // The apex, where the radius comes to 0, if it is near enough to keep the
    // digits of the radii; exactly the end where the radius is given as 0.
    let apex_above_bottom = -bottom / slope;
    let size = height + widest;
    let wall = if bottom == 0.0 {
        cone(DVec3::new(0.0, 0.0, z.start), slope.abs())
    } else if top == 0.0 {
        cone(DVec3::new(0.0, 0.0, z.end), slope.abs())
    } else if !is_far(apex_above_bottom, size) {
        cone(
            DVec3::new(0.0, 0.0, z.start + apex_above_bottom),
            slope.abs(),
        )
    } else {
        // x² + y² - (r + slope dz)² about the middle.
        let radius = 0.5 * (bottom + top);
        let anchor = DVec3::new(0.0, 0.0, 0.5 * z.start + 0.5 * z.end);
        let squares = DVec3::new(1.0, 1.0, -slope * slope);
        Surface {
            linear: DVec3::new(0.0, 0.0, -2.0 * radius * slope),
            ..separable(Kind::Cone, anchor, squares, -radius * radius)
        }
    };
    Ok(vec![wall, lower, upper])
}

fn face(face: &Plane) -> Result<Surface, NodeFault> {
    let length = face.normal.length();
    let normal = direction("a face's normal", face.normal)?;
    let offset = coordinate("a face's offset", face.offset / length)?;
    Ok(Surface::plane(normal * offset, normal))
}

/// A prism with the planes of its sides, then of its ends.
fn upright(polygon: &[DVec2], z: &Range<f64>, surfaces: &[Surface]) -> Option<Polyhedron> {
    let count = polygon.len() as u32;
    let next = polygon.iter().cycle().skip(1);
    let doubled: f64 = polygon.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum();
    let at = |z: f64| polygon.iter().map(move |corner| corner.extend(z));
    let vertices = at(z.start).chain(at(z.end)).collect();
    let mut faces: Vec<Vec<u32>> = (0..count)
        .map(|k| {
            let next = (k + 1) % count;
            vec![k, next, count + next, count + k]
        })
        .collect();
    faces.push((0..count).rev().collect());
    faces.push((count..2 * count).collect());
    if doubled < 0.0 {
        faces.iter_mut().for_each(|face| face.reverse());
    }
    let planes = surfaces.iter().map(|surface| Plane {
        normal: surface.linear,
        offset: surface.linear.dot(surface.anchor),
    });
    Polyhedron::of_convex_faces(vertices, &faces, planes.collect())
}

fn prism(polygon: &[DVec2], z: &Range<f64>) -> Result<Vec<Surface>, NodeFault> {
    let fault = |problem| Err(NodeFault::PolygonNotConvex { problem });
    for corner in polygon {
        coordinate("a corner of the polygon", corner.x)?;
        coordinate("a corner of the polygon", corner.y)?;
    }
    if polygon.len() < 3 {
        return fault("it has fewer than three corners");
    }
    let middle = polygon.iter().sum::<DVec2>() / polygon.len() as f64;
    let edges = || {
        let next = polygon.iter().cycle().skip(1);
        polygon.iter().zip(next).map(|(&from, &to)| (from, to))
    };
    let doubled_area: f64 = edges()
        .map(|(from, to)| (from - middle).perp_dot(to - middle))
        .sum();
    if doubled_area == 0.0 {
        return fault("it has no area");
    }
    let turn = doubled_area.signum();
    // Each edge must have every corner on its inner side, but for rounding:
    // local turns alone would accept a pentagram.
    let size = polygon
        .iter()
        .map(|p| (*p - middle).length())
        .fold(0.0, f64::max);
    let middle_z = 0.5 * z.start + 0.5 * z.end;
    let mut surfaces = Vec::with_capacity(polygon.len() + 2);
    let mut total_turn = 0.0;
    let mut previous: Option<DVec2> = None;
    let mut first = None;
    for (from, to) in edges() {
        let along = to - from;
        if along.length() <= COORDINATE * size {
            return fault("two corners in succession coincide");
        }
        let outward = -along.perp() * turn;
        let outward = outward / outward.length();
        if let Some(before) = previous {
            total_turn += elementary::turn(before, along) * turn;
            if elementary::turn(before, along) * turn < -IN_PROFILE {
                return fault("it has a reflex corner");
            }
        }
        previous = Some(along);
        first.get_or_insert(along);
        let anchor = (0.5 * (from + to)).extend(middle_z);
        surfaces.push(Surface::plane(anchor, outward.extend(0.0)));
    }
    if let (Some(last), Some(first)) = (previous, first) {
        let closing = elementary::turn(last, first) * turn;
        total_turn += closing;
        if closing < -IN_PROFILE {
            return fault("it has a reflex corner");
        }
    }
    if (total_turn - std::f64::consts::TAU).abs() > WHOLE_TURN {
        return fault("it crosses itself");
    }
    surfaces.extend(z_slab(z)?);
    Ok(surfaces)
}
