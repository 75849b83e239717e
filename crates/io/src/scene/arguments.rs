//! Arguments of nodes by their keys.

use super::build::Builder;
use super::error::SceneError;
use super::facets::Fineness;
use super::parse::{Argument, NodeText, Value};
use super::values::number;

/// The values of the arguments with the given keys (an empty key: without one), in their order; or
/// what is wrong with any other argument.
pub(super) fn by_keys<'a, const N: usize>(
    arguments: &'a [Argument<'_>],
    keys: &[&str; N],
) -> Result<[Option<&'a Value>; N], String> {
    let mut found = [None; N];
    for argument in arguments {
        let key = argument.key.unwrap_or("");
        let name = match argument.key {
            Some(key) => format!("the argument `{key}`"),
            None => "an argument without a name".to_owned(),
        };
        let Some(slot) = keys.iter().position(|&known| known == key) else {
            return Err(format!("{name} is not known here"));
        };
        if found[slot].replace(&argument.value).is_some() {
            return Err(format!("{name} is given twice"));
        }
    }
    Ok(found)
}

impl Builder<'_> {
    /// The values of the arguments with the given keys (an empty key: without
    /// one), in their order; an error for any other argument.
    pub(super) fn arguments<const N: usize>(
        &self,
        node: &NodeText<'_>,
        keys: &[&str; N],
    ) -> Result<[Option<&Value>; N], SceneError> {
        let arguments = &self.tree.arguments[node.arguments.clone()];
        by_keys(arguments, keys).map_err(|problem| self.fault(node, &problem))
    }

    /// A radius, by itself or as half of a diameter, if one of them is given.
    pub(super) fn radius(
        &self,
        node: &NodeText<'_>,
        [r, d]: [&str; 2],
        [radius, diameter]: [Option<&Value>; 2],
    ) -> Result<Option<f64>, SceneError> {
        match (radius, diameter) {
            (None, None) => Ok(None),
            (Some(_), None) => self.number(node, r, radius).map(Some),
            (None, Some(_)) => Ok(Some(0.5 * self.number(node, d, diameter)?)),
            (Some(_), Some(_)) => {
                let problem = format!("`{r}` and `{d}` are both given: leave one out");
                Err(self.fault(node, &problem))
            }
        }
    }

    pub(super) fn fineness(
        &self,
        node: &NodeText<'_>,
        [number, angle, size]: [Option<&Value>; 3],
    ) -> Result<Fineness, SceneError> {
        let or_default = |key, value: Option<&Value>, default| match value {
            Some(_) => self.number(node, key, value),
            None => Ok(default),
        };
        Ok(Fineness {
            number: or_default("$fn", number, 0.0)?,
            angle: or_default("$fa", angle, 12.0)?,
            size: or_default("$fs", size, 2.0)?,
        })
    }

    pub(super) fn number(
        &self,
        node: &NodeText<'_>,
        key: &str,
        value: Option<&Value>,
    ) -> Result<f64, SceneError> {
        value
            .and_then(number)
            .ok_or_else(|| self.fault(node, &format!("it needs a number `{key}`")))
    }

    pub(super) fn flag(
        &self,
        node: &NodeText<'_>,
        key: &str,
        value: Option<&Value>,
    ) -> Result<bool, SceneError> {
        match value {
            None => Ok(false),
            Some(&Value::Bool(flag)) => Ok(flag),
            Some(_) => Err(self.fault(node, &format!("`{key}` must be true or false"))),
        }
    }
}
