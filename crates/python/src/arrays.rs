//! Vectors of a frozen class as NumPy arrays, without copies; and arrays from Python.

use bytemuck::Pod;
use numpy::ndarray::{ArrayView, Dimension, IntoDimension};
use numpy::{Element, PyArray, PyArrayDescrMethods, PyArrayMethods, PyReadonlyArrayDyn};
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

/// The numbers of whatever NumPy makes an array of, and its shape. `wanted` says which
/// numbers of which shape.
fn numbers<T: Element + Copy>(
    name: &str,
    given: &Bound<'_, PyAny>,
    wanted: &str,
) -> PyResult<(Vec<usize>, Vec<T>)> {
    let wrong = |found: String| invalid(format!("{name} must be an array {wanted}: {found}"));
    let py = given.py();
    let numpy = py.import("numpy")?;
    let array = numpy
        .call_method1("asarray", (given,))
        .map_err(|error| wrong(error.to_string()))?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let kind = T::get_dtype(py);
    if shape.iter().product::<usize>() > 0 && kind.kind() == b'u' {
        // Neither shares nor negative numbers become others on the way.
        let given = array.getattr("dtype")?;
        if !"iu".contains(&given.getattr("kind")?.extract::<String>()?) {
            return Err(wrong(format!("it has numbers of type {given}")));
        }
        let (least, most) = (array.call_method0("min")?, array.call_method0("max")?);
        if least.lt(0)? || most.gt(u32::MAX)? {
            return Err(wrong(format!("it has numbers from {least} to {most}")));
        }
    }
    let array = numpy
        .call_method1("ascontiguousarray", (array, kind))
        .map_err(|error| wrong(error.to_string()))?;
    let array: PyReadonlyArrayDyn<'_, T> = array.extract()?;
    Ok((shape, array.as_slice()?.to_vec()))
}

/// Rows of `N` numbers.
pub(crate) fn rows<T: Element + Copy, const N: usize>(
    name: &str,
    given: &Bound<'_, PyAny>,
) -> PyResult<Vec<[T; N]>> {
    let wanted = format!("of shape (n, {N})");
    let (shape, numbers) = numbers(name, given, &wanted)?;
    match shape.as_slice() {
        [_, columns] if *columns == N => Ok(numbers.as_chunks().0.to_vec()),
        [0] => Ok(Vec::new()),
        _ => Err(invalid(format!(
            "{name} must be an array {wanted}: its shape is {shape:?}"
        ))),
    }
}

/// One row of numbers.
pub(crate) fn row<T: Element + Copy>(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<T>> {
    let (shape, numbers) = numbers(name, given, "of one dimension")?;
    match shape.as_slice() {
        [_] => Ok(numbers),
        _ => Err(invalid(format!(
            "{name} must be an array of one dimension: its shape is {shape:?}"
        ))),
    }
}
