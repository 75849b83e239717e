//! The circles in which surfaces of revolution about one axis meet, as those of turned parts do.
//!
//! Along the axis both are α ρ² + β t² + γ t + δ = 0 at the distance ρ from it: what the squares of
//! the distance leave of the two is an equation of degree two in t, however flat or steep they are.

use crate::elementary;
use glam::DVec3;

use super::curve::{Branch, Branches, Curve};
use super::intersection::Nearness;
use super::trig::BEGIN;
use crate::numeric::tolerance::{CANCELLED, ROUND};
use crate::program::Surface;

/// A line about which surfaces are turned, and two directions across it.
struct Axis {
    point: DVec3,
    along: DVec3,
    across: [DVec3; 2],
}

/// A surface of revolution along its axis.
struct Meridian {
    /// What ρ² is multiplied by.
    across: f64,
    /// β, γ and δ.
    along: [f64; 3],
}

/// The circles common to two surfaces of revolution about one axis, if they are such, and it is
/// clear that these do not touch there, nor close up in the axis.
pub(super) fn circles(a: &Surface, b: &Surface, nearness: Nearness) -> Option<Branches> {
    let mut axis = [a, b].into_iter().find_map(Axis::of)?;
    let mut both = axis.meridians([a, b], nearness)?;
    // About the middle between the roots, where the terms are least.
    let [(square, _), (linear, _), _] = difference(&both);
    if square == 0.0 {
        // Of surfaces of one shape the plane of their circle is known.
        return None;
    }
    axis.point -= linear / (2.0 * square) * axis.along;
    both = axis.meridians([a, b], nearness)?;
    let [
        (square, of_square),
        (linear, of_linear),
        (constant, of_constant),
    ] = difference(&both);
    let discriminant = linear * linear - 4.0 * square * constant;
    let unsure = 2.0 * linear.abs() * of_linear
        + 4.0 * (square.abs() * of_constant + constant.abs() * of_square);
    // So much of a square of a radius is a distance at which surfaces may touch.
    let touch = 2.0 * nearness.touch * nearness.scene();
    // By how much the squares of the radii differ between the roots.
    let between = discriminant / (4.0 * square * both[0].across * both[1].across);
    let is_clear = between.abs() > touch && discriminant.abs() > unsure;
    if !is_clear {
        return None;
    }
    let mut branches = Branches::new();
    if discriminant < 0.0 {
        return Some(branches);
    }
    let sum = -0.5 * (linear + discriminant.sqrt().copysign(linear));
    let roots = [sum / square, constant / sum];
    if (roots[0] - roots[1]).abs() <= nearness.near {
        return None;
    }
    for t in roots {
        // By the one along which it changes less.
        let steepness = |one: &&Meridian| one.steepness(t);
        let by = both
            .iter()
            .min_by(|p, q| steepness(p).total_cmp(&steepness(q)))?;
        let square = by.square_of_radius(t);
        let off = (of_square * t.abs() + of_linear) * t.abs() + of_constant;
        let unsure = by.steepness(t) * off / discriminant.sqrt();
        if square.abs() <= touch.max(unsure) {
            return None;
        }
        if square > 0.0 {
            let radius = square.sqrt();
            let (sin, cos) = elementary::sin_cos(BEGIN);
            let [u, v] = axis.across.map(|across| radius * across);
            branches.push(Branch::new(Curve::Ellipse {
                center: axis.point + t * axis.along,
                a: cos * u + sin * v,
                b: cos * v - sin * u,
            }));
        }
    }
    Some(branches)
}

/// What the squares of distances leave of two surfaces: the coefficients of an equation along the
/// axis, and how much of each is rounding.
fn difference([one, other]: &[Meridian; 2]) -> [(f64, f64); 3] {
    [0, 1, 2].map(|k| {
        let terms = [other.across * one.along[k], one.across * other.along[k]];
        let nothing = CANCELLED * (terms[0].abs() + terms[1].abs());
        let value = terms[0] - terms[1];
        (if value.abs() <= nothing { 0.0 } else { value }, nothing)
    })
}

impl Axis {
    /// That of a surface that is turned about one line only.
    fn of(surface: &Surface) -> Option<Self> {
        let (values, vectors) = surface.principal_axes();
        let axes = [vectors.x_axis, vectors.y_axis, vectors.z_axis];
        let along = (0..3).find(|&k| {
            let [p, q] = [values[(k + 1) % 3], values[(k + 2) % 3]];
            let is_one = (p - q).abs() <= ROUND * p.abs();
            is_one && p != 0.0 && (values[k] - p).abs() > ROUND * p.abs()
        })?;
        let [u, v, along] = [1, 2, 3].map(|k| axes[(along + k) % 3]);
        let square = 0.5 * surface.curvature_along(u);
        let off = [u, v].map(|across| surface.linear.dot(across) / (2.0 * square) * across);
        Some(Self {
            point: surface.anchor - off[0] - off[1],
            along,
            across: [u, v],
        })
    }

    /// Two surfaces along the axis, if both are turned about it.
    fn meridians(&self, both: [&Surface; 2], nearness: Nearness) -> Option<[Meridian; 2]> {
        let [one, other] = both.map(|surface| self.meridian(surface, nearness));
        Some([one?, other?])
    }

    /// A surface along the axis, if it is turned about it.
    fn meridian(&self, surface: &Surface, nearness: Nearness) -> Option<Meridian> {
        let Self {
            point,
            along,
            across: [u, v],
        } = *self;
        let [uu, vv, tt] = [u, v, along].map(|d| 0.5 * surface.curvature_along(d));
        let mixed = |p: DVec3, q: DVec3| 0.5 * surface.curvature_along(p + q);
        let is_nothing = |p: DVec3, q: DVec3, own: f64| {
            let value = mixed(p, q) - own;
            value.abs() <= ROUND * surface.terms_along(u).max(surface.terms_along(v))
        };
        let is_round = (uu - vv).abs() <= ROUND * uu.abs()
            && is_nothing(u, v, uu + vv)
            && is_nothing(u, along, uu + tt)
            && is_nothing(v, along, vv + tt);
        let gradient = surface.gradient(point);
        let off = (gradient - gradient.dot(along) * along).length();
        // Where it is turned about another point it is off the axis by half of that.
        let is_centred = off <= CANCELLED * nearness.scene() * uu.abs();
        (is_round && is_centred && uu != 0.0).then(|| Meridian {
            across: uu,
            along: [tt, gradient.dot(along), surface.value(point)],
        })
    }
}

impl Meridian {
    /// The square of the radius at a place along the axis.
    fn square_of_radius(&self, t: f64) -> f64 {
        let [square, linear, constant] = self.along;
        -((square * t + linear) * t + constant) / self.across
    }

    /// How much that changes along the axis.
    fn steepness(&self, t: f64) -> f64 {
        let [square, linear, _] = self.along;
        ((2.0 * square * t + linear) / self.across).abs()
    }
}
