//! Vectors of a frozen class as NumPy arrays, without copies; and arrays from Python.

use bytemuck::Pod;
use numpy::ndarray::{ArrayView, Dimension, IntoDimension};
use numpy::{Element, PyArray, PyArrayMethods, PyReadonlyArray};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::errors::invalid;

/// The values of a vector that `owner` holds, as an array that cannot be written to and
/// keeps its owner alive.
pub(crate) fn view<'py, S: Pod, T: Pod + Element, D: IntoDimension>(
    owner: &Bound<'py, PyAny>,
    values: &[S],
    shape: D,
) -> PyResult<Bound<'py, PyArray<T, D::Dim>>>
where
    D::Dim: Dimension,
{
    let flat: &[T] = bytemuck::cast_slice(values);
    let array = ArrayView::from_shape(shape.into_dimension(), flat)
        .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    // SAFETY: `owner` is an object of a frozen class and `values` one of its vectors:
    // nothing changes or moves it before the owner is gone, and the array, as its base,
    // keeps the owner. Nobody writes through the array, as it is told right below.
    #[allow(unsafe_code, reason = "a copy of a large mesh takes its memory twice")]
    let array = unsafe { PyArray::borrow_from_array(&array, owner.clone()) };
    array.readwrite().make_nonwriteable();
    Ok(array)
}

/// Whatever NumPy makes rows of `N` numbers of, row by row.
pub(crate) fn rows<T: Element + Copy, const N: usize>(
    name: &str,
    given: &Bound<'_, PyAny>,
    dtype: &str,
) -> PyResult<Vec<[T; N]>> {
    let numpy = given.py().import("numpy")?;
    let wrong = |found: String| {
        invalid(format!(
            "{name} must be an array of shape (n, {N}) of {dtype}: {found}"
        ))
    };
    // Large numbers do not become small ones on the way.
    let array = numpy
        .call_method1("asarray", (given,))
        .map_err(|error| wrong(error.to_string()))?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if shape.iter().product::<usize>() == 0 && matches!(shape.as_slice(), [0] | [0, _]) {
        return Ok(Vec::new());
    }
    if shape.len() != 2 || shape[1] != N {
        return Err(wrong(format!("its shape is {shape:?}")));
    }
    let casting = if dtype.starts_with("uint") {
        let signed = numpy.call_method1("issubdtype", (array.getattr("dtype")?, "int"))?;
        let unsigned = array.getattr("dtype")?.getattr("kind")?;
        if !signed.is_truthy()? && !unsigned.eq("u")? {
            return Err(wrong(format!("it has {}", array.getattr("dtype")?)));
        }
        let (least, most) = (array.call_method0("min")?, array.call_method0("max")?);
        if least.lt(0)? || most.gt(u32::MAX)? {
            return Err(wrong(format!("it has numbers from {least} to {most}")));
        }
        "unsafe"
    } else {
        "same_kind"
    };
    let keywords = pyo3::types::PyDict::new(given.py());
    keywords.set_item("casting", casting)?;
    let array = array
        .call_method("astype", (dtype,), Some(&keywords))
        .map_err(|error| wrong(error.to_string()))?;
    let array: PyReadonlyArray<'_, T, numpy::Ix2> = array.extract()?;
    let array = array.as_array();
    let rows = array.outer_iter();
    Ok(rows
        .map(|row| std::array::from_fn(|column| row[column]))
        .collect())
}
