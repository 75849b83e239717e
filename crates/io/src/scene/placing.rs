//! What a scene written by hand may have: arguments without names, and `translate`, `rotate`,
//! `scale` and `mirror`, which are matrices in an evaluated tree.

use csg::elementary;
use glam::{DMat3, DVec3};

use super::arguments::by_keys;
use super::parse::{Argument, Value};
use super::values::{list, number};

/// The names of the arguments of a node that may stand without, in their order.
pub(super) fn names(node: &str) -> &'static [&'static str] {
    match node {
        "translate" | "scale" | "mirror" => &["v"],
        "rotate" => &["a", "v"],
        "color" => &["c", "alpha"],
        "cube" | "square" => &["size", "center"],
        "sphere" | "circle" | "offset" => &["r"],
        "cylinder" => &["h", "r1", "r2", "center"],
        "polygon" => &["points", "paths"],
        "polyhedron" => &["points", "faces"],
        "text" => &["text", "size", "font"],
        "import" | "surface" => &["file"],
        "linear_extrude" => &["height"],
        "resize" => &["newsize", "auto"],
        _ => &[],
    }
}

/// Whether a node puts its children elsewhere by something else than a matrix.
pub(super) fn is_placing(node: &str) -> bool {
    matches!(node, "translate" | "rotate" | "scale" | "mirror")
}

/// The matrix of a node that [`is_placing`].
///
/// # Errors
/// What is wrong with its arguments.
pub(super) fn matrix(node: &str, arguments: &[Argument<'_>]) -> Result<Value, String> {
    let (mut linear, mut offset) = (DMat3::IDENTITY, DVec3::ZERO);
    if node == "rotate" {
        let [angle, axis] = by_keys(arguments, &["a", "v"])?;
        linear = rotation(angle, axis)?;
    } else {
        let [value] = by_keys(arguments, &["v"])?;
        let value = value.ok_or_else(|| format!("it needs `[x, y, z]`{}", uniform(node)))?;
        let wrong = || {
            format!(
                "it needs three numbers `[x, y, z]`, or two{}",
                uniform(node)
            )
        };
        match node {
            "translate" => offset = vector(value, 0.0).ok_or_else(wrong)?,
            "scale" => {
                let scale = match value {
                    &Value::Number(scale) => Some(DVec3::splat(scale)),
                    value => vector(value, 1.0),
                };
                linear = DMat3::from_diagonal(scale.ok_or_else(wrong)?);
            }
            _ => {
                let normal = vector(value, 0.0).ok_or_else(wrong)?;
                // (As in OpenSCAD: without a direction nothing is mirrored.)
                if let Some(normal) = normal.try_normalize() {
                    let twice = 2.0 * normal;
                    let across =
                        DMat3::from_cols(normal * twice.x, normal * twice.y, normal * twice.z);
                    linear = DMat3::IDENTITY - across;
                }
            }
        }
    }
    let row = |k: usize| {
        let row = linear.row(k);
        [row.x, row.y, row.z, offset[k]]
    };
    let rows = [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]];
    let rows = rows.map(|row| Value::List(row.map(Value::Number).into()));
    Ok(Value::List(rows.into()))
}

/// What else a node takes.
fn uniform(node: &str) -> &'static str {
    if node == "scale" {
        ", or one for all axes"
    } else {
        ""
    }
}

/// Three numbers, or two and what the third is then.
fn vector(value: &Value, rest: f64) -> Option<DVec3> {
    match list(value, number)?[..] {
        [x, y] => Some(DVec3::new(x, y, rest)),
        [x, y, z] => Some(DVec3::new(x, y, z)),
        _ => None,
    }
}

/// By degrees about X, then Y, then Z; or by one angle about an axis, Z if there is none.
fn rotation(angle: Option<&Value>, axis: Option<&Value>) -> Result<DMat3, String> {
    let wrong = "it needs degrees about the axes `[x, y, z]`, or one angle and an axis";
    match angle {
        Some(&Value::Number(degrees)) => {
            let axis = match axis {
                None | Some(Value::Undefined) => DVec3::Z,
                Some(axis) => vector(axis, 0.0).ok_or(wrong)?,
            };
            let axis = axis
                .try_normalize()
                .ok_or("the axis has no direction: give one that is not [0, 0, 0]")?;
            Ok(about(axis, degrees))
        }
        Some(value) => {
            let degrees = vector(value, 0.0).ok_or(wrong)?;
            let [x, y, z] = [0, 1, 2].map(|k| about(DVec3::AXES[k], degrees[k]));
            Ok(z * y * x)
        }
        None => Err(wrong.to_owned()),
    }
}

/// About an axis of length 1 (Rodrigues).
fn about(axis: DVec3, degrees: f64) -> DMat3 {
    let [cos, sin] = cos_sin(degrees);
    let turned = |v: DVec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
    let [x, y, z] = DVec3::AXES.map(turned);
    DMat3::from_cols(x, y, z)
}

/// Cosine and sine of an angle in degrees; those that are 0, a half or 1 exactly so.
fn cos_sin(degrees: f64) -> [f64; 2] {
    let degrees = degrees % 360.0;
    let quarter = (degrees / 90.0).round();
    let rest = degrees - 90.0 * quarter;
    let (sin, cos) = elementary::sin_cos(rest.to_radians());
    let sin = if rest.abs() == 30.0 {
        0.5_f64.copysign(rest)
    } else if rest.abs() == 45.0 {
        cos.copysign(rest)
    } else {
        sin
    };
    match quarter.rem_euclid(4.0) as u8 {
        0 => [cos, sin],
        1 => [-sin, cos],
        2 => [-cos, -sin],
        _ => [sin, -cos],
    }
}
