//! What surfaces are, for those who write them down elsewhere.

use glam::DVec3;

use super::Surface;
use super::kind::Kind;
use super::standard_form::StandardForm;
use crate::numeric::tolerance::ROUND;

/// A surface's own coordinates x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Where they are 0, in model units.
    pub origin: DVec3,
    /// The directions of x, y and z: of unit length, at right angles, right-handed.
    pub axes: [DVec3; 3],
}

/// What a surface is, and where, in model units: the whole of f = 0, whichever side of it is
/// solid.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SurfaceShape {
    /// A plane.
    Plane {
        /// A point of it.
        point: DVec3,
        /// Where f grows, of unit length.
        normal: DVec3,
    },
    /// A sphere.
    Sphere {
        /// The centre.
        center: DVec3,
        /// The radius.
        radius: f64,
    },
    /// A round cylinder.
    Cylinder {
        /// A point of the axis.
        point: DVec3,
        /// The direction of the axis, of unit length.
        axis: DVec3,
        /// The radius.
        radius: f64,
    },
    /// A round cone, both halves: at a distance s along the axis from the point, the radius is
    /// |radius + slope s|.
    Cone {
        /// A point of the axis: the apex, or one near to where the cone is used.
        point: DVec3,
        /// The direction of the axis, of unit length.
        axis: DVec3,
        /// The radius around the point, 0 or more.
        radius: f64,
        /// By how much the radius grows along the axis: the tangent of the half angle.
        slope: f64,
    },
    /// x²/a² + y²/b² + z²/c² = 1, not all radii the same.
    Ellipsoid {
        /// Its centre and axes.
        placement: Placement,
        /// a, b and c.
        radii: [f64; 3],
    },
    /// x²/a² + y²/b² = 1, not round.
    EllipticCylinder {
        /// A point of its axis z, and its axes.
        placement: Placement,
        /// a and b.
        radii: [f64; 2],
    },
    /// x²/a² + y²/b² = z², not round.
    EllipticCone {
        /// Its apex and axes.
        placement: Placement,
        /// a and b.
        slopes: [f64; 2],
    },
    /// x²/a² + y²/b² - z²/c² = 1.
    HyperboloidOneSheet {
        /// Its centre and axes.
        placement: Placement,
        /// a, b and c.
        radii: [f64; 3],
    },
    /// x²/a² + y²/b² - z²/c² = -1, two sheets.
    HyperboloidTwoSheets {
        /// Its centre and axes.
        placement: Placement,
        /// a, b and c.
        radii: [f64; 3],
    },
    /// z = a x² + b y², with a and b above 0.
    EllipticParaboloid {
        /// Its vertex and axes.
        placement: Placement,
        /// a and b.
        bends: [f64; 2],
    },
    /// z = a x² - b y², with a and b above 0.
    HyperbolicParaboloid {
        /// Its saddle point and axes.
        placement: Placement,
        /// a and b.
        bends: [f64; 2],
    },
    /// x²/a² - y²/b² = 1, two sheets.
    HyperbolicCylinder {
        /// A point midway between the sheets, and the axes.
        placement: Placement,
        /// a and b.
        radii: [f64; 2],
    },
    /// z = a x², with a above 0.
    ParabolicCylinder {
        /// A point of the vertices' line, which runs along y, and the axes.
        placement: Placement,
        /// a.
        bend: f64,
    },
    /// x² = a².
    ParallelPlanes {
        /// A point midway between the planes, and the axes.
        placement: Placement,
        /// a.
        distance: f64,
    },
}

impl Surface {
    /// What it is, and where.
    ///
    /// ```
    /// use csg::{Program, Solid, SurfaceShape};
    /// use csg::glam::dvec3;
    ///
    /// let ball = Solid::sphere(2.0).translate([1.0, 0.0, 0.0]);
    /// let surface = Program::lower(&ball)?.surfaces()[0];
    /// let (center, radius) = (dvec3(1.0, 0.0, 0.0), 2.0);
    /// assert_eq!(surface.shape(), SurfaceShape::Sphere { center, radius });
    /// # Ok::<(), csg::Error>(())
    /// ```
    #[must_use]
    pub fn shape(&self) -> SurfaceShape {
        if self.is_plane() {
            let normal = self.linear.normalize_or_zero();
            let point = self.anchor - self.constant / self.linear.length() * normal;
            return SurfaceShape::Plane { point, normal };
        }
        let form = self.standard_form();
        let StandardForm {
            center,
            axes,
            values,
            slope,
            constant,
        } = form;
        // Where x² and so on is as large as the rest of the equation.
        let radius = |k: usize| (constant / values[k]).abs().sqrt();
        let same = |i: usize, j: usize| is_same(values[i], values[j]);
        let (point, axis) = (center, axes[2]);
        let bend = |k: usize| (values[k] / slope).abs();
        let vertex = center - constant / slope * axes[2];
        // The side to which the first axis bends.
        let up = axes[2] * -(values[0] / slope).signum();
        match self.kind {
            Kind::Plane => unreachable!("told above"),
            Kind::Ellipsoid if same(0, 1) && same(1, 2) && same(0, 2) => {
                let mean = values.iter().sum::<f64>() / 3.0;
                let radius = (constant / mean).abs().sqrt();
                SurfaceShape::Sphere { center, radius }
            }
            Kind::Ellipsoid => SurfaceShape::Ellipsoid {
                placement: placed(center, axes),
                radii: [0, 1, 2].map(radius),
            },
            Kind::EllipticCylinder if same(0, 1) => SurfaceShape::Cylinder {
                point,
                axis,
                radius: (2.0 * constant / (values[0] + values[1])).abs().sqrt(),
            },
            Kind::EllipticCylinder => SurfaceShape::EllipticCylinder {
                placement: placed(center, axes),
                radii: [0, 1].map(radius),
            },
            Kind::Cone if same(0, 1) => self.round_cone(&form),
            Kind::Cone => SurfaceShape::EllipticCone {
                placement: placed(center, axes),
                slopes: [0, 1].map(|k| (values[2] / values[k]).abs().sqrt()),
            },
            Kind::HyperboloidOneSheet => SurfaceShape::HyperboloidOneSheet {
                placement: placed(center, axes),
                radii: [0, 1, 2].map(radius),
            },
            Kind::HyperboloidTwoSheets => SurfaceShape::HyperboloidTwoSheets {
                placement: placed(center, axes),
                radii: [0, 1, 2].map(radius),
            },
            Kind::EllipticParaboloid => SurfaceShape::EllipticParaboloid {
                placement: placed(vertex, [axes[0], axes[1], up]),
                bends: [0, 1].map(bend),
            },
            Kind::HyperbolicParaboloid => SurfaceShape::HyperbolicParaboloid {
                placement: placed(vertex, [axes[0], axes[1], up]),
                bends: [0, 1].map(bend),
            },
            // The sheets are across the axis whose value has the other sign.
            Kind::HyperbolicCylinder => {
                let (x, y) = if values[0] * constant < 0.0 {
                    (0, 1)
                } else {
                    (1, 0)
                };
                SurfaceShape::HyperbolicCylinder {
                    placement: placed(center, [axes[x], axes[y], axes[2]]),
                    radii: [x, y].map(radius),
                }
            }
            Kind::ParabolicCylinder => SurfaceShape::ParabolicCylinder {
                placement: placed(vertex, [axes[0], axes[1], up]),
                bend: bend(0),
            },
            Kind::ParallelPlanes => SurfaceShape::ParallelPlanes {
                placement: placed(center, axes),
                distance: radius(0),
            },
        }
    }

    /// A cone whose apex may be so far away that it is only known to few digits.
    fn round_cone(&self, form: &StandardForm) -> SurfaceShape {
        let axis = form.axes[2];
        let value = 0.5 * (form.values[0] + form.values[1]);
        if let Some(apex) = self.apex() {
            return SurfaceShape::Cone {
                point: apex,
                axis,
                radius: 0.0,
                slope: (-form.values[2] / value).max(0.0).sqrt(),
            };
        }
        let off_axis: DVec3 = (0..2)
            .map(|k| self.linear.dot(form.axes[k]) / (2.0 * form.values[k]) * form.axes[k])
            .sum();
        let point = self.anchor - off_axis;
        let radius = (-self.value(point) / value).max(0.0).sqrt();
        // f / value is -(radius + slope s)². (The square of the slope may have no digits.)
        let slope = -self.gradient(point).dot(axis) / (2.0 * value * radius);
        SurfaceShape::Cone {
            point,
            axis: axis * slope.signum(),
            radius,
            slope: slope.abs(),
        }
    }
}

/// Whether two values of a quadratic form are one.
fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= ROUND * one.abs().max(other.abs())
}

/// A right-handed placement: x is turned around if need be.
fn placed(origin: DVec3, [x, y, z]: [DVec3; 3]) -> Placement {
    let x = if x.cross(y).dot(z) < 0.0 { -x } else { x };
    Placement {
        origin,
        axes: [x, y, z],
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, dvec3};
    use proptest::prelude::*;

    use super::*;
    use crate::solid::Primitive;
    use crate::{Program, Solid};

    fn shape(solid: &Solid) -> (Surface, SurfaceShape) {
        let program = Program::lower(solid).expect("valid");
        let curved = program.surfaces().iter().find(|s| !s.is_plane());
        let surface = *curved.expect("a quadric");
        (surface, surface.shape())
    }

    fn close(a: DVec3, b: DVec3) -> bool {
        a.distance(b) < 1e-12
    }

    fn parallel(a: DVec3, b: DVec3) -> bool {
        a.cross(b).length() < 1e-12
    }

    /// Points on a shape by its equation.
    fn points(shape: &SurfaceShape) -> Vec<DVec3> {
        let at = |placement: &Placement, p: DVec3| {
            placement.origin + DMat3::from_cols_array_2d(&placement.axes.map(|a| a.to_array())) * p
        };
        let around = (0..7).map(|k| f64::from(k).sin_cos());
        let heights = [-1.7, -0.4, 0.3, 1.1];
        let mut points = Vec::new();
        for (s, c) in around {
            for h in heights {
                let (p, q) = (1.0 + h * h, h * h - 1.0);
                points.extend(match shape {
                    SurfaceShape::Plane { point, normal } => {
                        let (x, y) = normal.any_orthonormal_pair();
                        vec![*point + h * c * x + h * s * y]
                    }
                    SurfaceShape::Sphere { center, radius } => {
                        vec![*center + *radius * dvec3(2.0 * h * c, 2.0 * h * s, q) / p]
                    }
                    SurfaceShape::Cylinder {
                        point,
                        axis,
                        radius,
                    } => {
                        let (x, y) = axis.any_orthonormal_pair();
                        vec![*point + h * *axis + *radius * (c * x + s * y)]
                    }
                    SurfaceShape::Cone {
                        point,
                        axis,
                        radius,
                        slope,
                    } => {
                        let (x, y) = axis.any_orthonormal_pair();
                        vec![*point + h * *axis + (radius + slope * h) * (c * x + s * y)]
                    }
                    SurfaceShape::Ellipsoid { placement, radii } => {
                        let unit = dvec3(2.0 * h * c, 2.0 * h * s, q) / p;
                        vec![at(placement, DVec3::from(*radii) * unit)]
                    }
                    SurfaceShape::EllipticCylinder { placement, radii } => {
                        vec![at(placement, dvec3(radii[0] * c, radii[1] * s, h))]
                    }
                    SurfaceShape::EllipticCone { placement, slopes } => {
                        vec![at(placement, h * dvec3(slopes[0] * c, slopes[1] * s, 1.0))]
                    }
                    SurfaceShape::HyperboloidOneSheet { placement, radii } => {
                        let r = DVec3::from(*radii);
                        vec![at(
                            placement,
                            r * dvec3(h.cosh() * c, h.cosh() * s, h.sinh()),
                        )]
                    }
                    SurfaceShape::HyperboloidTwoSheets { placement, radii } => {
                        let r = DVec3::from(*radii);
                        let point = dvec3(h.sinh() * c, h.sinh() * s, h.cosh());
                        vec![at(placement, r * point), at(placement, -r * point)]
                    }
                    SurfaceShape::EllipticParaboloid { placement, bends } => {
                        let (x, y) = (h * c, h * s);
                        let z = bends[0] * x * x + bends[1] * y * y;
                        vec![at(placement, dvec3(x, y, z))]
                    }
                    SurfaceShape::HyperbolicParaboloid { placement, bends } => {
                        let (x, y) = (h * c, h * s);
                        let z = bends[0] * x * x - bends[1] * y * y;
                        vec![at(placement, dvec3(x, y, z))]
                    }
                    SurfaceShape::HyperbolicCylinder { placement, radii } => {
                        let x = radii[0] * h.cosh();
                        let y = radii[1] * h.sinh();
                        [x, -x].map(|x| at(placement, dvec3(x, y, c))).to_vec()
                    }
                    SurfaceShape::ParabolicCylinder { placement, bend } => {
                        vec![at(placement, dvec3(h, c, bend * h * h))]
                    }
                    SurfaceShape::ParallelPlanes {
                        placement,
                        distance,
                    } => [1.0, -1.0]
                        .map(|sign| at(placement, dvec3(sign * distance, h, c)))
                        .to_vec(),
                });
            }
        }
        points
    }

    fn quadric(xx: f64, yy: f64, xy: f64, z: f64, constant: f64) -> Solid {
        Solid::quadric([xx, yy, 0.0, xy, 0.0, 0.0, 0.0, 0.0, z, constant])
    }

    /// One solid of each kind.
    fn solids() -> Vec<Solid> {
        vec![
            Solid::sphere(1.5),
            Solid::cylinder(0.7, -1.0..1.0),
            Solid::frustum(1.0, 0.5, 0.0..1.0),
            Solid::frustum(1.0, 1.0 - 1e-9, 0.0..1.0),
            Solid::infinite_cone(0.5),
            Solid::ellipsoid([1.0, 2.0, 3.0]),
            Solid::ellipsoid([2.0, 2.0, 1.0]),
            Solid::elliptic_cylinder([1.0, 2.0], -1.0..1.0),
            Solid::infinite_cone(0.5).scale_xyz([1.0, 2.0, 1.0]),
            Solid::hyperboloid_one_sheet([1.0, 2.0, 3.0]),
            Solid::hyperboloid_two_sheets([1.0, 2.0, 3.0]),
            Solid::paraboloid([1.0, 2.0]),
            quadric(1.0, -2.0, 0.5, 1.0, 0.3),
            quadric(0.0, 1.0, 1.0, 0.0, -1.0),
            quadric(0.0, 1.0, 1.0, 0.0, 1.0),
            quadric(1.0, 0.0, 0.0, 1.0, 0.5),
            // (As the surface that it is: authors get half-spaces.)
            Solid::primitive(Primitive::Quadric([
                1.0, 1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0,
            ])),
        ]
    }

    proptest! {
        /// Whatever way they went: round ones are told from others, and the points of the
        /// shape are on the surface.
        #[test]
        fn points_of_shapes_are_on_their_surfaces(
            turn in prop::array::uniform3(-3.0..3.0f64),
            size in 0.1..10.0f64,
            offset in prop::array::uniform3(-5.0..5.0f64),
        ) {
            for solid in solids() {
                let same = solid
                    .rotate_z(turn[0])
                    .rotate_x(turn[1])
                    .rotate_y(turn[2])
                    .scale(size)
                    .translate(offset);
                let ((_, before), (surface, found)) = (shape(&solid), shape(&same));
                prop_assert_eq!(std::mem::discriminant(&before), std::mem::discriminant(&found));
                for point in points(&found) {
                    let slope = surface.gradient(point).length();
                    let far = surface.value(point).abs() / slope.max(1e-3);
                    prop_assert!(far < 1e-10 * size, "{found:?}: {point} is {far} off");
                }
            }
        }

        /// An ellipse is none however round it is, if it is not so but for rounding.
        #[test]
        fn what_is_not_round_is_elliptic(by in -11.0..-1.0f64, turn in -3.0..3.0f64) {
            let stretch = 1.0 + 10f64.powf(by);
            let solid = Solid::cylinder(1.0, -1.0..1.0).scale_xyz([stretch, 1.0, 1.0]);
            let (_, shape) = shape(&solid.rotate_x(turn).rotate_y(1.0));
            let SurfaceShape::EllipticCylinder { radii, .. } = shape else {
                panic!("{stretch}: {shape:?}");
            };
            prop_assert!((radii[0].max(radii[1]) - stretch).abs() < 1e-13);
            prop_assert!((radii[0].min(radii[1]) - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn round_shapes_have_their_closed_forms() {
        let moved = |solid: Solid| solid.rotate_x(0.7).translate([1.0, 2.0, 3.0]);
        let axis = dvec3(0.0, -0.7f64.sin(), 0.7f64.cos());
        let at = dvec3(1.0, 2.0, 3.0);
        match shape(&moved(Solid::cylinder(0.3, -1.0..5.0))).1 {
            SurfaceShape::Cylinder {
                point,
                axis: found,
                radius,
            } => {
                assert!(parallel(found, axis) && parallel(point - at, axis));
                assert!((radius - 0.3).abs() < 1e-14);
            }
            other => panic!("{other:?}"),
        }
        match shape(&moved(Solid::cone(1.0, 0.0..2.0))).1 {
            SurfaceShape::Cone {
                point,
                axis: found,
                radius,
                slope,
            } => {
                assert!(parallel(found, axis) && close(point, at + 2.0 * axis));
                assert!(radius < 1e-14 && (slope - 0.5).abs() < 1e-14);
            }
            other => panic!("{other:?}"),
        }
        match shape(&moved(Solid::frustum(1.0, 1.0 - 1e-7, 0.0..1.0))).1 {
            SurfaceShape::Cone {
                point,
                axis: found,
                radius,
                slope,
            } => {
                // It narrows upwards.
                assert!(close(found, -axis) && (slope - 1e-7).abs() < 1e-13);
                let bottom = radius + slope * (at - point).dot(found);
                assert!((bottom - 1.0).abs() < 1e-13);
            }
            other => panic!("{other:?}"),
        }
        match shape(&moved(Solid::paraboloid([0.5, 0.5]))).1 {
            SurfaceShape::EllipticParaboloid { placement, bends } => {
                assert!(close(placement.origin, at) && close(placement.axes[2], axis));
                let z = dvec3(0.5, 0.0, 1.0);
                assert!(
                    bends
                        .iter()
                        .all(|bend| (bend * z.x * z.x - z.z).abs() < 1e-12)
                );
            }
            other => panic!("{other:?}"),
        }
    }
}
