//! OpenSCAD's polygons and polyhedra for circles, spheres, cylinders, cones.
//!
//! A circle of n fragments has its corners at the angles k 360°/n. A sphere
//! has ceil(n/2) rings of n corners at the polar angles (i + ½) 180°/rings;
//! its poles are cut off. All of these are convex, so they are held as the
//! planes of their faces, each from a formula of its own rather than from
//! rounded corners: parallel faces come out parallel, and trapezoids flat.

use csg::elementary;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::ops::Range;

use csg::{Plane, Solid, turn};
use glam::{DVec2, DVec3};

/// How finely OpenSCAD divides a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fineness {
    /// `$fn`: the number of fragments, if positive.
    pub number: f64,
    /// `$fa`: the least angle of a fragment, in degrees.
    pub angle: f64,
    /// `$fs`: the least length of a fragment.
    pub size: f64,
}

impl Fineness {
    /// The number of fragments of a circle, as a whole f64 of at least 3;
    /// infinite where the text asks for infinitely many. The rule of
    /// OpenSCAD's `Calc::get_fragments_from_r`.
    pub(crate) fn fragments(&self, radius: f64) -> f64 {
        // The finest grid OpenSCAD knows.
        const GRID_FINE: f64 = 1.0 / (1 << 20) as f64;
        if radius < GRID_FINE || !self.number.is_finite() {
            3.0
        } else if self.number > 0.0 {
            self.number.max(3.0).trunc()
        } else {
            (360.0 / self.angle)
                .min(TAU * radius / self.size)
                .max(5.0)
                .ceil()
        }
    }

    /// Whether `$fn` asks for a polygon on purpose.
    pub(super) fn is_polygon(&self) -> bool {
        self.number > 0.0 && self.number <= 12.0
    }
}

/// The outward direction of the middle of side k of an n-gon.
fn side(k: usize, n: usize) -> DVec2 {
    turn(2 * k + 1, 2 * n)
}

/// The number of rings of a sphere.
pub(super) fn rings(fragments: usize) -> usize {
    fragments.div_ceil(2)
}

/// The planes of a faceted sphere: cap above, cap below, then band by band.
///
/// The trapezoid between the rings at polar angles φ ± δ, on the side in
/// direction θ, has its two parallel edges at the distances r c sin(φ ± δ)
/// from the axis and the heights r cos(φ ± δ), where c = cos(180°/n). The
/// plane through both is sin φ (cos θ x + sin θ y) + c cos φ z = r c cos δ.
pub(super) fn sphere(radius: f64, fragments: usize) -> Vec<Plane> {
    let rings = rings(fragments);
    let half_step = FRAC_PI_2 / rings as f64;
    let across = turn(1, 2 * fragments).x;
    let cap = radius * elementary::cos(half_step);
    let mut planes = vec![
        Plane {
            normal: DVec3::Z,
            offset: cap,
        },
        Plane {
            normal: -DVec3::Z,
            offset: cap,
        },
    ];
    for band in 1..rings {
        let polar = turn(band, 2 * rings);
        for k in 0..fragments {
            planes.push(Plane {
                normal: (polar.y * side(k, fragments)).extend(across * polar.x),
                offset: across * cap,
            });
        }
    }
    planes
}

/// A faceted cylinder, frustum or cone: a prism or a pyramid, cut or whole.
pub(super) fn cylinder(bottom: f64, top: f64, z: Range<f64>, fragments: usize) -> Solid {
    if bottom == top {
        let corners = (0..fragments).map(|k| bottom * turn(k, fragments));
        return Solid::prism(corners, z);
    }
    Solid::convex_polyhedron(frustum(bottom, top, z, fragments))
}

/// The planes of a faceted frustum: the sides, then the ends that are not a
/// point. Side k holds the edges at the distances c bottom and c top from the
/// axis, where c = cos(180°/n).
pub(super) fn frustum(bottom: f64, top: f64, z: Range<f64>, fragments: usize) -> Vec<Plane> {
    let across = turn(1, 2 * fragments).x;
    let height = z.end - z.start;
    let slope = (bottom - top) * across / height;
    // From the wider end, so that a cone's sides are no worse than its base.
    let offset = if bottom > top {
        across * bottom + slope * z.start
    } else {
        across * top + slope * z.end
    };
    let mut planes: Vec<Plane> = (0..fragments)
        .map(|k| Plane {
            normal: side(k, fragments).extend(slope),
            offset,
        })
        .collect();
    if bottom > 0.0 {
        planes.push(Plane {
            normal: -DVec3::Z,
            offset: -z.start,
        });
    }
    if top > 0.0 {
        planes.push(Plane {
            normal: DVec3::Z,
            offset: z.end,
        });
    }
    planes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fragments_follow_the_rule() {
        let fine = |number, angle, size| Fineness {
            number,
            angle,
            size,
        };
        // The defaults: 30 fragments of 12° from the radius where 2πr/30 = 2.
        assert_eq!(fine(0.0, 12.0, 2.0).fragments(10.0), 30.0);
        assert_eq!(fine(0.0, 12.0, 2.0).fragments(5.0), 16.0);
        assert_eq!(fine(0.0, 12.0, 2.0).fragments(0.1), 5.0);
        assert_eq!(fine(0.1, 12.0, 2.0).fragments(5.0), 3.0);
        assert_eq!(fine(7.9, 12.0, 2.0).fragments(5.0), 7.0);
        assert_eq!(fine(f64::INFINITY, 12.0, 2.0).fragments(5.0), 3.0);
        assert_eq!(fine(f64::NAN, 12.0, 2.0).fragments(5.0), 3.0);
        assert_eq!(fine(100.0, 12.0, 2.0).fragments(1e-7), 3.0);
        assert_eq!(fine(-5.0, 12.0, 2.0).fragments(10.0), 30.0);
    }

    /// Every corner lies in the solid and on at least three of its planes, and
    /// every plane holds at least three corners: the solid is their hull.
    fn assert_hull(planes: &[Plane], corners: &[DVec3], size: f64) {
        let tolerance = 4e-15 * size;
        let distance = |plane: &Plane, corner: DVec3| {
            (plane.normal.dot(corner) - plane.offset) / plane.normal.length()
        };
        for &corner in corners {
            let distances = planes.iter().map(|plane| distance(plane, corner));
            assert!(distances.clone().all(|d| d < tolerance), "{corner} is out");
            let touching = distances.filter(|d| d.abs() < tolerance).count();
            assert!(touching >= 3, "{corner} touches {touching}");
        }
        for plane in planes {
            let touching = corners
                .iter()
                .filter(|&&corner| distance(plane, corner).abs() < tolerance)
                .count();
            assert!(touching >= 3, "{plane:?} holds {touching} corners");
        }
    }

    fn ring(radius: f64, z: f64, fragments: usize) -> impl Iterator<Item = DVec3> {
        (0..fragments).map(move |k| {
            let (sin, cos) = (360.0 * k as f64 / fragments as f64).to_radians().sin_cos();
            DVec3::new(radius * cos, radius * sin, z)
        })
    }

    #[test]
    fn spheres_are_the_hulls_of_their_rings() {
        for fragments in (3_usize..=13).chain([30, 31, 100]) {
            let radius = 7.5;
            let rings = fragments.div_ceil(2);
            let corners: Vec<DVec3> = (0..rings)
                .flat_map(|i| {
                    let polar = (180.0 * (i as f64 + 0.5) / rings as f64).to_radians();
                    ring(radius * polar.sin(), radius * polar.cos(), fragments)
                })
                .collect();
            let planes = sphere(radius, fragments);
            assert_eq!(planes.len(), fragments * (rings - 1) + 2);
            assert_hull(&planes, &corners, radius);
        }
    }

    #[test]
    fn frusta_are_the_hulls_of_their_ends() {
        for fragments in [3, 4, 5, 12, 30] {
            for (bottom, top) in [(5.0, 1.0), (5.0, 0.0), (0.0, 5.0), (1.0, 2.0)] {
                let end = |radius: f64, z| {
                    let corners = if radius == 0.0 { 1 } else { fragments };
                    ring(radius, z, fragments).take(corners)
                };
                let corners: Vec<DVec3> = end(bottom, -2.0).chain(end(top, 3.0)).collect();
                let planes = frustum(bottom, top, -2.0..3.0, fragments);
                assert_hull(&planes, &corners, 5.0);
            }
        }
    }
}
