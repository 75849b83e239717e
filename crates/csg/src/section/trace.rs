//! What surfaces leave in the plane z = 0: lines and conics, each extended across it.
//!
//! Where a solid is cut next to a face, or to where a face begins to bend away, the plane and
//! the surface are one but for rounding, and what they have in common is lost in that. In the
//! plane alone nothing is: f(x, y, 0) is a conic whatever z does to f, and a plane beside it is
//! on one side. So the section is that of the solid whose surfaces go on from these conics at right
//! angles to the plane: lines, ellipses and parabolas along z, hyperbolas around their axis.

use glam::{DVec2, DVec3};

use crate::numeric::eigen_symmetric;
use crate::numeric::tolerance::{NEAR, NO_VALUE, VALUE};
use crate::program::{Formula, Operand, Operation, Surface};
use crate::solid::Solid;

/// What is known of rounding in the plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rounding {
    /// How far the plane, or a surface, may be off.
    pub off: f64,
    /// How far the solid reaches in the plane.
    pub size: f64,
}

/// From which side of the plane surfaces in it are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Looked {
    /// At what lies just below it.
    Below,
    /// At what lies just above it.
    Above,
}

/// A set of points as surfaces leave it in the plane.
#[derive(Clone)]
enum Trace {
    Constant(bool),
    Solid(Solid),
}

/// The solid that a formula over surfaces leaves in the plane, extended across it; none where it
/// is empty. And whether one of the surfaces lies in the plane.
pub(super) fn extended(
    surfaces: &[Surface],
    formula: &Formula,
    rounding: Rounding,
    looked: Looked,
) -> (Option<Solid>, bool) {
    let mut has_plane = false;
    let literals: Vec<Trace> = formula
        .literals()
        .iter()
        .map(|literal| {
            let surface = &surfaces[literal.surface as usize];
            let (trace, is_in_plane) = match literal.outside {
                true => trace(&surface.negated(), rounding, looked),
                false => trace(surface, rounding, looked),
            };
            has_plane |= is_in_plane;
            trace
        })
        .collect();
    let mut gates: Vec<Trace> = Vec::with_capacity(formula.gates().len());
    let value = |operand: Operand, gates: &[Trace]| match operand {
        Operand::Constant(value) => Trace::Constant(value),
        Operand::Literal(index) => literals[index as usize].clone(),
        Operand::Gate(index) => gates[index as usize].clone(),
    };
    for gate in formula.gates() {
        let operands = formula.operands_of(gate).iter();
        let combined = combine(gate.operation, operands.map(|&one| value(one, &gates)));
        gates.push(combined);
    }
    let whole = match value(formula.root(), &gates) {
        Trace::Constant(false) => None,
        Trace::Constant(true) => Some(Solid::space()),
        Trace::Solid(solid) => Some(solid),
    };
    (whole, has_plane)
}

fn combine(operation: Operation, operands: impl Iterator<Item = Trace>) -> Trace {
    let mut solids = Vec::new();
    for operand in operands {
        match operand {
            Trace::Constant(value) if value == operation.absorbing() => return operand,
            Trace::Constant(_) => {}
            Trace::Solid(solid) => solids.push(solid),
        }
    }
    match (operation, solids.len()) {
        (_, 0) => Trace::Constant(!operation.absorbing()),
        (_, 1) => Trace::Solid(solids.swap_remove(0)),
        (Operation::And, _) => Trace::Solid(Solid::intersection(solids)),
        (Operation::Or, _) => Trace::Solid(Solid::union(solids)),
    }
}

/// Behind the line through a point with an outward normal.
fn behind(point: DVec2, normal: DVec2) -> Solid {
    Solid::half_space_through(point.extend(0.0), normal.extend(0.0))
}

/// What f <= 0 leaves in the plane, and whether that depends on how one looks at it.
fn trace(surface: &Surface, rounding: Rounding, looked: Looked) -> (Trace, bool) {
    let Rounding { off, size } = rounding;
    let origin = surface.anchor.truncate();
    let about = surface.anchor.with_z(0.0);
    let (gradient, constant) = surface.expanded_about(about);
    let [xx, yy, zz, xy, ..] = surface.quadratic;
    // What f may be off: its terms by rounding, and the plane by where it is.
    let z = surface.anchor.z;
    let terms = surface.constant.abs() + (surface.linear.z * z).abs() + zz.abs() * z * z;
    let noise = VALUE * terms + off * (gradient.length() + zz.abs() * off);
    let linear = gradient.truncate();
    let ([first, second, _], axes) = eigen_symmetric([xx, yy, 0.0, xy, 0.0, 0.0]);
    let axes = [first, second].into_iter().zip([axes.x_axis, axes.y_axis]);
    // (Of a quadric's coefficients the largest is 1.)
    let (bent, straight): (Vec<_>, Vec<_>) = axes
        .map(|(value, axis)| (value, axis.truncate()))
        .partition(|(value, _)| value.abs() > NO_VALUE);
    let mut center = origin;
    let mut at_center = constant;
    for &(value, axis) in &bent {
        let along = linear.dot(axis);
        center -= along / (2.0 * value) * axis;
        at_center -= along * along / (4.0 * value);
    }
    let slope: DVec2 = straight
        .iter()
        .map(|&(_, axis)| linear.dot(axis) * axis)
        .sum();
    let has_slope = slope.length() * size > noise;
    let is_zero = at_center.abs() <= noise;
    let solid = match bent[..] {
        [] if has_slope => behind(origin - constant / slope.length_squared() * slope, slope),
        [] if is_zero => {
            let is_below = (gradient.z > 0.0) == (looked == Looked::Below);
            return (Trace::Constant(is_below), true);
        }
        [] => return (Trace::Constant(constant < 0.0), false),
        [(value, axis)] if !has_slope => {
            if is_zero || (at_center > 0.0) == (value > 0.0) {
                return (Trace::Constant(value < 0.0), false);
            }
            let half = (-at_center / value).sqrt() * axis;
            let sides = [half, -half];
            if value > 0.0 {
                Solid::intersection(sides.map(|side| behind(center + side, side)))
            } else {
                Solid::union(sides.map(|side| behind(center + side, -side)))
            }
        }
        [(one, _), (other, _)]
            if (one > 0.0) == (other > 0.0) && (is_zero || (at_center > 0.0) == (one > 0.0)) =>
        {
            return (Trace::Constant(one < 0.0), false);
        }
        // A hyperbola parts from the two lines that it is beside by no more than it is from its
        // centre, where it is nearest.
        [(one, s), (other, t)]
            if (one > 0.0) != (other > 0.0)
                && (is_zero
                    || at_center.abs() <= (NEAR * size).powi(2) * one.abs().min(other.abs())) =>
        {
            // f = one (s - k t) (s + k t).
            let k = (-other / one).sqrt();
            let sign = one.signum();
            let [a, b] = [sign * (s - k * t), s + k * t];
            Solid::union([
                behind(center, a) & behind(center, -b),
                behind(center, -a) & behind(center, b),
            ])
        }
        _ => {
            // Hyperbolas turn about the axis that they cross: those surfaces are at right angles to the
            // plane, too, and have charts. Parabolas go on as cylinders, about where their surface was told.
            let (zz, about, linear, constant) = match bent[..] {
                [(one, _), (other, _)] => {
                    let is_ellipse = (one > 0.0) == (other > 0.0);
                    let is_across = (one > 0.0) == (at_center > 0.0);
                    let turned = if is_across { one } else { other };
                    let zz = if is_ellipse { 0.0 } else { turned };
                    (zz, center, slope, at_center)
                }
                _ => (0.0, origin, linear, constant),
            };
            let coefficients = [xx, yy, zz, xy, 0.0, 0.0, linear.x, linear.y, 0.0, constant];
            Solid::quadric(coefficients).translate(DVec3::from((about, 0.0)))
        }
    };
    (Trace::Solid(solid), false)
}
