//! General quadrics from ten coefficients: is the zero set a surface, and
//! where should it be anchored?

use glam::DVec3;

use super::Surface;
use super::kind::Kind;
use crate::error::NodeFault;
use crate::numeric::eigen_symmetric;
use crate::numeric::tolerance::{FAR_CENTRE, NO_VALUE};

/// The surface f = 0 of f = c0 x² + c1 y² + c2 z² + c3 xy + c4 yz + c5 zx +
/// c6 x + c7 y + c8 z + c9, anchored at its centre, axis or vertex; a parabolic cylinder, and what
/// has that far away, at the origin.
pub(crate) fn from_coefficients(coefficients: [f64; 10]) -> Result<Surface, NodeFault> {
    if coefficients.iter().any(|c| !c.is_finite()) {
        return Err(NodeFault::NotFinite {
            what: "a coefficient of the quadric",
        });
    }
    let scale = coefficients.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    if scale == 0.0 {
        return Err(NodeFault::QuadricWithoutSurface);
    }
    let [xx, yy, zz, xy, yz, zx, gx, gy, gz, constant] = coefficients.map(|c| c / scale);
    anchored(Surface {
        anchor: DVec3::ZERO,
        quadratic: [xx, yy, zz, xy, yz, zx],
        linear: DVec3::new(gx, gy, gz),
        constant,
        // Until its kind is known.
        kind: Kind::Plane,
    })
}

/// The kind of f about any anchor.
#[cfg(test)]
pub(crate) fn kind_of(
    quadratic: [f64; 6],
    linear: DVec3,
    constant: f64,
) -> Result<Kind, NodeFault> {
    let surface = Surface {
        anchor: DVec3::ZERO,
        quadratic,
        linear,
        constant,
        kind: Kind::Plane,
    };
    anchored(surface).map(|surface| surface.kind)
}

/// Whether a centre, vertex or apex is so far from a part of some size that a surface is kept about
/// that part.
pub(crate) fn is_far(distance: f64, size: f64) -> bool {
    distance * distance > FAR_CENTRE * size * size
}

/// The same surface anchored at its centre, axis or vertex, and its kind: the only place
/// where that is asked of coefficients.
fn anchored(surface: Surface) -> Result<Surface, NodeFault> {
    let Surface {
        quadratic,
        linear,
        constant,
        ..
    } = surface;
    if quadratic == [0.0; 6] {
        if linear == DVec3::ZERO {
            return Err(NodeFault::QuadricWithoutSurface);
        }
        return Ok(Surface::plane(
            -constant / linear.length_squared() * linear,
            linear,
        ));
    }
    let (values, vectors) = eigen_symmetric(quadratic);
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let mut center = DVec3::ZERO;
    // What of the linear part no centre can take away.
    let mut slope = DVec3::ZERO;
    let (mut positive, mut negative) = (0, 0);
    for (&value, axis) in values
        .iter()
        .zip([vectors.x_axis, vectors.y_axis, vectors.z_axis])
    {
        let along = linear.dot(axis);
        if value.abs() > NO_VALUE * largest {
            center -= along / (2.0 * value) * axis;
            if value > 0.0 {
                positive += 1;
            } else {
                negative += 1;
            }
        } else if along.abs() > NO_VALUE * linear.length() {
            slope += along * axis;
        }
    }
    let (_, at_center) = surface.expanded_about(center);
    let has_slope = slope != DVec3::ZERO;
    if has_slope {
        // Along its axis f is linear: move the anchor to the vertex.
        center -= at_center / slope.length_squared() * slope;
    }
    let terms = constant.abs() + linear.abs().dot(center.abs());
    let at_center = if at_center.abs() <= NO_VALUE * terms {
        0.0
    } else {
        at_center
    };
    let kind = Kind::of_signature((positive, negative), has_slope, at_center)?;
    let size = (linear.length_squared() / (4.0 * largest)).max(constant.abs());
    // Kept about the origin, as given. So are parabolic cylinders: the vertex of one that is nearly
    // straight is far from the part that is meant, whose coefficients do not tell where that is.
    if kind == Kind::ParabolicCylinder || is_far(largest.sqrt() * center.length(), size.sqrt()) {
        return Ok(Surface { kind, ..surface });
    }
    let (linear, constant) = if has_slope {
        surface.expanded_about(center)
    } else {
        (DVec3::ZERO, at_center)
    };
    Ok(Surface {
        anchor: center,
        quadratic,
        linear,
        constant,
        kind,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn q(c: [f64; 10]) -> Result<Surface, NodeFault> {
        from_coefficients(c)
    }

    #[test]
    fn spheres_are_anchored_at_their_centre() {
        // (x-1)² + (y-2)² + (z+3)² - 4
        let s = q([1.0, 1.0, 1.0, 0.0, 0.0, 0.0, -2.0, -4.0, 6.0, 10.0]).expect("a sphere");
        assert!(s.anchor.distance(DVec3::new(1.0, 2.0, -3.0)) < 1e-14);
        assert!(s.value(DVec3::new(3.0, 2.0, -3.0)).abs() < 1e-15);
        assert!(s.value(DVec3::new(1.0, 2.0, -3.0)) < 0.0);
    }

    #[test]
    fn every_real_type_is_accepted() {
        let cases = [
            (
                "paraboloid",
                [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 5.0],
            ),
            (
                "hyperbolic paraboloid",
                [1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            ),
            ("cone", [1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            (
                "one sheet",
                [1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0],
            ),
            (
                "two sheets",
                [1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            ),
            (
                "parabolic cylinder",
                [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            ),
            (
                "hyperbolic cylinder",
                [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0],
            ),
            ("slab", [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0]),
            ("plane", [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0]),
            (
                "outside of a sphere",
                [-1.0, -1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            ),
        ];
        for (name, c) in cases {
            let surface = q(c).unwrap_or_else(|fault| panic!("{name}: {fault}"));
            // The same f, up to a positive factor, at some point.
            let p = DVec3::new(0.3, -1.7, 2.9);
            let [x, y, z] = p.to_array();
            let terms = [x * x, y * y, z * z, x * y, y * z, z * x, x, y, z, 1.0];
            let f: f64 = c.iter().zip(terms).map(|(c, t)| c * t).sum();
            let scale = c.iter().fold(0.0f64, |m, c| m.max(c.abs()));
            assert!((surface.value(p) - f / scale).abs() < 1e-13, "{name}");
        }
    }

    #[test]
    fn zero_sets_that_are_no_surface_are_rejected() {
        use NodeFault::{QuadricOfCrossingPlanes, QuadricWithoutSurface};
        let cases = [
            ([0.0; 10], QuadricWithoutSurface),
            (
                [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
                QuadricWithoutSurface,
            ),
            (
                [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
                QuadricWithoutSurface,
            ),
            // One point, one line, one plane counted twice.
            (
                [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                QuadricWithoutSurface,
            ),
            (
                [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 1.0],
                QuadricWithoutSurface,
            ),
            (
                [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 1.0],
                QuadricWithoutSurface,
            ),
            (
                [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                QuadricOfCrossingPlanes,
            ),
            // (x - 1)(y - 2)
            (
                [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -2.0, -1.0, 0.0, 2.0],
                QuadricOfCrossingPlanes,
            ),
        ];
        for (c, fault) in cases {
            assert_eq!(q(c), Err(fault), "{c:?}");
        }
        let nan = [f64::NAN; 10];
        assert!(matches!(q(nan), Err(NodeFault::NotFinite { .. })));
    }
}
