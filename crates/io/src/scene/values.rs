//! Values of arguments as what they should be.

use super::parse::Value;

pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => Some(*number),
        _ => None,
    }
}

/// A list, each item read by `item`.
pub(super) fn list<T>(value: &Value, item: impl Fn(&Value) -> Option<T>) -> Option<Vec<T>> {
    match value {
        Value::List(values) => values.iter().map(item).collect(),
        _ => None,
    }
}

/// A list of exactly N values.
pub(super) fn array<T, const N: usize>(
    value: &Value,
    item: impl Fn(&Value) -> Option<T>,
) -> Option<[T; N]> {
    list(value, item)?.try_into().ok()
}

/// A list of N sizes, or one for all.
pub(super) fn sizes<const N: usize>(value: &Value) -> Option<[f64; N]> {
    match value {
        &Value::Number(size) => Some([size; N]),
        value => array(value, number),
    }
}

pub(super) fn text(value: &Value) -> Option<&str> {
    match value {
        Value::Text(text) => Some(text),
        _ => None,
    }
}
