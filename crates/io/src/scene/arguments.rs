//! Arguments of nodes by their keys.

use super::build::Builder;
use super::error::SceneError;
use super::facets::Fineness;
use super::parse::{NodeText, Value};
use super::values::number;

impl Builder<'_> {
    /// The values of the arguments with the given keys (an empty key: without
    /// one), in their order; an error for any other argument.
    pub(super) fn arguments<const N: usize>(
        &self,
        node: &NodeText<'_>,
        keys: &[&str; N],
    ) -> Result<[Option<&Value>; N], SceneError> {
        let mut found = [None; N];
        for argument in &self.tree.arguments[node.arguments.clone()] {
            let key = argument.key.unwrap_or("");
            let name = match argument.key {
                Some(key) => format!("the argument `{key}`"),
                None => "an argument without a name".to_owned(),
            };
            let Some(slot) = keys.iter().position(|&known| known == key) else {
                return Err(self.fault(node, &format!("{name} is not known here")));
            };
            if found[slot].replace(&argument.value).is_some() {
                return Err(self.fault(node, &format!("{name} is given twice")));
            }
        }
        Ok(found)
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
