//! The lines in which cylinders along one direction meet.
//!
//! Across it they are conics: where the one of the first meets the second is on a line of both. That
//! keeps the digits of the scene also where conics are nearly straight, as most pieces of
//! letters are, and of a size far beyond that of the scene.

use glam::DVec3;

use super::conic::{FAR, conic};
use super::curve::{Branch, Branches, Curve, Meets};
use super::intersection::Nearness;
use super::roots::Roots;
use crate::numeric::tolerance::CANCELLED;
use crate::program::{Kind, Surface};

/// The lines common to two cylinders of any kind, if they are along one direction.
pub(super) fn lines(a: &Surface, b: &Surface, nearness: Nearness) -> Option<Branches> {
    let [direction, other] = [along(a)?, along(b)?];
    if direction.cross(other).length() > CANCELLED {
        return None;
    }
    let across = Surface::plane(DVec3::ZERO, direction);
    let section = conic(&across, a, nearness).ok()?;
    let reach = FAR * nearness.scene();
    let mut branches = Branches::new();
    for Branch { curve, .. } in section {
        let Some(range) = curve.range(DVec3::ZERO, reach) else {
            continue;
        };
        let mut roots = Roots::default();
        let meets = curve.meet(b, range, [nearness.touch; 2], &mut roots);
        if roots.is_lost || meets != Meets::Points {
            return None;
        }
        // Where they touch, along one line.
        roots.simple.retain(|t| !roots.touching.contains(t));
        let places = roots.simple.iter().chain(&roots.touching);
        branches.extend(places.map(|&t| {
            Branch::new(Curve::Line {
                point: curve.at(t),
                direction,
            })
        }));
    }
    Some(branches)
}

/// The direction of the lines on a cylinder.
fn along(surface: &Surface) -> Option<DVec3> {
    let (values, axes) = surface.principal_axes();
    let axes = [axes.x_axis, axes.y_axis, axes.z_axis];
    let by_size = |&j: &usize, &k: &usize| values[j].abs().total_cmp(&values[k].abs());
    match surface.kind {
        Kind::EllipticCylinder | Kind::HyperbolicCylinder => {
            (0..3).min_by(by_size).map(|least| axes[least])
        }
        Kind::ParabolicCylinder => {
            let across = (0..3).max_by(by_size).map(|most| axes[most])?;
            across.cross(surface.linear).try_normalize()
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::tolerance::NEAR;

    /// Whatever the size of the scene about which the conics are told.
    #[test]
    fn nearly_straight_parabolas_meet_in_the_same_lines() {
        let cylinder = |[y, z]: [f64; 2], [yy, zz, yz]: [f64; 3], slope: [f64; 2]| Surface {
            anchor: DVec3::new(0.0, y, z),
            quadratic: [0.0, yy, zz, 0.0, yz, 0.0],
            linear: DVec3::new(0.0, slope[0], slope[1]),
            constant: 0.0,
            kind: Kind::ParabolicCylinder,
        };
        let straight = cylinder(
            [-1.23228, 0.18564],
            [0.5, 0.5, -1.0],
            [751.0951800011561, 258.981_360_000_398_9],
        );
        let root = 0.242_679_587_107_644_98;
        let bent = cylinder(
            [-1.54251, -1.11228],
            [1.0, root * root, 2.0 * root],
            [0.5645694393873717, -0.6506447600637756],
        );
        let known = DVec3::new(0.0, -1.133_939_187_947, -0.099_851_486_905);
        for size in [3.0, 7.0, 14.0, 20.0, 56.0, 500.0] {
            let nearness = Nearness::of(size * NEAR);
            for [one, other] in [[&straight, &bent], [&bent, &straight]] {
                let found = lines(one, other, nearness).expect("parallel cylinders");
                let is_known = |branch: &Branch| branch.curve.at(0.0).distance(known) < 1e-10;
                assert!(found.iter().any(is_known), "{size}: {found:?}");
            }
        }
    }
}
