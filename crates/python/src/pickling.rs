//! Solids and profiles as bytes and back, to the bit: for pickles, and so for workers.
//!
//! A tree is written node by node, operands first, each shared node once, in place of
//! which its users have its number.

use std::collections::{HashMap, HashSet};
use std::sync::{Mutex, PoisonError};

use csg::{Color, Made, Node, Primitive, Profile, Solid};
use glam::{DAffine3, DVec3};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::{Deserialize, Serialize};

use crate::errors::invalid;
use crate::profile::PyProfile;
use crate::solid::PySolid;
use crate::surface::stored_surface;

pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(stored_solid, module)?)?;
    module.add_function(wrap_pyfunction!(stored_profile, module)?)?;
    module.add_function(wrap_pyfunction!(stored_surface, module)?)
}

/// One node; operands are numbers of nodes before it.
#[derive(Serialize, Deserialize)]
enum Record {
    Primitive(Primitive),
    Union(Vec<u32>),
    Intersection(Vec<u32>),
    Difference(Vec<u32>),
    Transform(DAffine3, u32),
    Made {
        function: String,
        solid: u32,
        within: Option<[DVec3; 2]>,
        spanning: Vec<DVec3>,
        strays: Option<f64>,
    },
    Named(String, u32),
    Colored(Color, u32),
}

/// The nodes of a tree in an order in which operands come first, without recursion.
fn records(root: &Solid) -> Result<Vec<Record>, String> {
    let mut numbers: HashMap<usize, u32> = HashMap::new();
    let mut records = Vec::new();
    let mut pending = vec![(root, false)];
    while let Some((solid, is_entered)) = pending.pop() {
        if numbers.contains_key(&solid.id()) {
            continue;
        }
        if !is_entered {
            pending.push((solid, true));
            let operands = solid.node().operands().iter().rev();
            pending.extend(operands.map(|operand| (operand, false)));
            continue;
        }
        let number = |operand: &Solid| numbers[&operand.id()];
        let all = |operands: &[Solid]| operands.iter().map(number).collect();
        let record = match solid.node() {
            Node::Primitive(primitive) => Record::Primitive(primitive.clone()),
            Node::Union(operands) => Record::Union(all(operands)),
            Node::Intersection(operands) => Record::Intersection(all(operands)),
            Node::Difference(operands) => Record::Difference(all(operands)),
            Node::Transform(map, operand) => {
                let map = map.clone().map_err(|fault| fault.to_string())?;
                Record::Transform(map, number(operand))
            }
            Node::Made(made) => {
                let solid = made.solid.as_ref().map_err(ToString::to_string)?;
                Record::Made {
                    function: made.function.to_owned(),
                    solid: number(solid),
                    within: made.within,
                    spanning: made.spanning.clone(),
                    strays: made.strays,
                }
            }
            Node::Named(name, operand) => Record::Named(name.to_string(), number(operand)),
            Node::Colored(color, operand) => Record::Colored(*color, number(operand)),
            node => return Err(format!("a node of kind {} cannot be stored", node.kind())),
        };
        let next = u32::try_from(records.len()).map_err(|_| "too many nodes".to_owned())?;
        numbers.insert(solid.id(), next);
        records.push(record);
    }
    Ok(records)
}

/// The solid of the last record.
fn rebuilt(records: Vec<Record>) -> Option<Solid> {
    let mut solids: Vec<Solid> = Vec::with_capacity(records.len());
    for record in records {
        let get = |number: u32| solids.get(number as usize).cloned();
        let all = |numbers: Vec<u32>| numbers.into_iter().map(get).collect::<Option<Vec<_>>>();
        let solid = match record {
            Record::Primitive(primitive) => Solid::primitive(primitive),
            Record::Union(operands) => Solid::union(all(operands)?),
            Record::Intersection(operands) => Solid::intersection(all(operands)?),
            Record::Difference(operands) => Solid::difference(all(operands)?),
            Record::Transform(map, operand) => get(operand)?.affine(map),
            Record::Made {
                function,
                solid,
                within,
                spanning,
                strays,
            } => Solid::from_made(Made {
                function: known(function),
                solid: Ok(get(solid)?),
                within,
                spanning,
                strays,
                with_chords: None,
            }),
            Record::Named(name, operand) => get(operand)?.named(name),
            Record::Colored(color, operand) => get(operand)?.colored(color),
        };
        solids.push(solid);
    }
    solids.pop()
}

/// The name of a function as long as the process lives: there are few, each kept once.
fn known(name: String) -> &'static str {
    static NAMES: Mutex<Option<HashSet<&'static str>>> = Mutex::new(None);
    let mut names = NAMES.lock().unwrap_or_else(PoisonError::into_inner);
    let names = names.get_or_insert_with(HashSet::new);
    match names.get(name.as_str()) {
        Some(name) => name,
        None => {
            let name: &'static str = Box::leak(name.into_boxed_str());
            names.insert(name);
            name
        }
    }
}

fn damaged(problem: impl std::fmt::Display) -> PyErr {
    invalid(format!(
        "these bytes are no pickle of this version: {problem}"
    ))
}

/// A function of the native module, for `__reduce__`.
fn function(py: Python<'_>, name: &str) -> PyResult<Py<PyAny>> {
    Ok(py.import("stereotomy._stereotomy")?.getattr(name)?.unbind())
}

#[pymethods]
impl PySolid {
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Py<PyAny>, (Bound<'py, PyBytes>,))> {
        let records = records(&self.0).map_err(invalid)?;
        let bytes = postcard::to_stdvec(&records).map_err(damaged)?;
        Ok((function(py, "_solid")?, (PyBytes::new(py, &bytes),)))
    }
}

#[pymethods]
impl PyProfile {
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Py<PyAny>, (Bound<'py, PyBytes>,))> {
        let bytes = postcard::to_stdvec(&self.0).map_err(damaged)?;
        Ok((function(py, "_profile")?, (PyBytes::new(py, &bytes),)))
    }
}

/// A solid from what its pickle holds.
#[pyfunction]
#[pyo3(name = "_solid")]
fn stored_solid(bytes: &[u8]) -> PyResult<PySolid> {
    let records: Vec<Record> = postcard::from_bytes(bytes).map_err(damaged)?;
    let solid = rebuilt(records).ok_or_else(|| damaged("a node is missing"))?;
    Ok(PySolid(solid))
}

/// A profile from what its pickle holds.
#[pyfunction]
#[pyo3(name = "_profile")]
fn stored_profile(bytes: &[u8]) -> PyResult<PyProfile> {
    let profile: Profile = postcard::from_bytes(bytes).map_err(damaged)?;
    Ok(PyProfile(profile))
}
