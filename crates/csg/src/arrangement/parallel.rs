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
