//! The options of meshing, from Python's keywords.

use std::time::Duration;

use csg::{Bounds, Limits, Mesher};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::{keywords, read};
use crate::errors::invalid;
use crate::unit;
use crate::waiting::Follow;

const KNOWN: [&str; 17] = [
    "tolerance",
    "angle",
    "cells",
    "cell_size",
    "smallest_feature",
    "draft",
    "bounds",
    "unit",
    "normals",
    "feature_edges",
    "check",
    "max_cells",
    "max_triangles",
    "max_memory",
    "max_seconds",
    "partial",
    "progress",
];

/// How to mesh, and whom to tell of it.
pub(crate) struct MeshOptions<'py> {
    pub(crate) mesher: Mesher,
    pub(crate) follow: Follow<'py>,
}

impl<'py> MeshOptions<'py> {
    /// The keywords of a call.
    pub(crate) fn of(function: &str, options: Option<&Bound<'py, PyDict>>) -> PyResult<Self> {
        let mut follow = Follow::default();
        let mut mesher = Mesher::new();
        let mut limits = Limits::new();
        let mut normals = true;
        for (name, value) in keywords(function, &KNOWN, options)? {
            let number = || -> PyResult<f64> { read(&name, &value) };
            let count = || -> PyResult<u64> { read(&name, &value) };
            mesher = match name.as_str() {
                "tolerance" => mesher.tolerance(number()?),
                "angle" => mesher.angle(number()?.to_radians()),
                "cells" => mesher.cells(read(&name, &value)?),
                "cell_size" => mesher.cell_size(number()?),
                "smallest_feature" => mesher.smallest_feature(number()?),
                "draft" if read(&name, &value)? => mesher.draft(),
                "bounds" => {
                    let (min, max): ([f64; 3], [f64; 3]) = read(&name, &value)?;
                    mesher.bounds(Bounds {
                        min: min.into(),
                        max: max.into(),
                    })
                }
                "unit" => mesher.unit(unit::named(&read::<String>(&name, &value)?)?),
                "feature_edges" => mesher.feature_edges(number()?.to_radians()),
                "check" => mesher.check(read(&name, &value)?),
                _ => {
                    match name.as_str() {
                        "normals" => normals = read(&name, &value)?,
                        "max_cells" => limits = limits.cells(count()?),
                        "max_triangles" => limits = limits.triangles(count()?),
                        "max_memory" => limits = limits.memory(count()?),
                        "max_seconds" => limits = limits.time(seconds(number()?)?),
                        "partial" if read(&name, &value)? => limits = limits.partial(),
                        "progress" => follow.callback = Some(callable(&value)?),
                        // (What is not wished.)
                        _ => {}
                    }
                    mesher
                }
            };
        }
        if normals {
            mesher = mesher.normals();
        }
        let share = follow.share.clone();
        mesher = mesher
            .limits(limits)
            .cancel_token(follow.cancel.clone())
            .progress(move |done| share.set(done));
        Ok(Self { mesher, follow })
    }
}

fn seconds(number: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(number)
        .map_err(|_| invalid(format!("max_seconds is {number}: give a positive number")))
}

fn callable<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    if value.is_callable() {
        Ok(value.clone())
    } else {
        let problem = "progress: give a function of one number, the share that is done";
        Err(PyTypeError::new_err(problem))
    }
}
