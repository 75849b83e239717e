//! Arguments of several forms.

use std::fmt;
use std::ops::Range;

use csg::{Axis, Color};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::invalid;

/// The keywords that a call has, of those that the function knows; `None` stands for what is not
/// said.
pub(crate) fn keywords<'py>(
    function: &str,
    known: &[&str],
    given: Option<&Bound<'py, PyDict>>,
) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let mut said = Vec::new();
    for (name, value) in given.into_iter().flatten() {
        let name: String = name.extract()?;
        if !known.contains(&name.as_str()) {
            // As Python says it, with what may be meant.
            return Err(PyTypeError::new_err(format!(
                "{function}() got an unexpected keyword argument '{name}'; known are {}",
                known.join(", ")
            )));
        }
        if !value.is_none() {
            said.push((name, value));
        }
    }
    Ok(said)
}

/// The value of a keyword, which an error names.
pub(crate) fn read<'py, T>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    let read: Result<T, _> = value.extract();
    read.map_err(|error| {
        let error: PyErr = Into::into(error);
        let message = format!("{name}: {}", error.value(value.py()));
        if error.is_instance_of::<PyTypeError>(value.py()) {
            PyTypeError::new_err(message)
        } else {
            invalid(message)
        }
    })
}

/// A point as Python has it.
pub(crate) type Place = (f64, f64, f64);

/// A box as (least corner, greatest corner).
pub(crate) type Corners<P> = Option<(P, P)>;

/// An extent along z: `(low, high)`, or the height of what stands on z = 0.
#[derive(Clone)]
pub(crate) struct Extent(pub(crate) Range<f64>);

impl fmt::Debug for Extent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({:?}, {:?})", self.0.start, self.0.end)
    }
}

impl<'py> FromPyObject<'_, 'py> for Extent {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(height) = object.extract::<f64>() {
            return Ok(Self(0.0..height));
        }
        match object.extract::<[f64; 2]>() {
            Ok([low, high]) => Ok(Self(low..high)),
            Err(_) => Err(PyTypeError::new_err(format!(
                "expected a height, or its two ends as (low, high), not {}",
                object.repr()?
            ))),
        }
    }
}

/// One number for all axes, or one for each.
#[derive(Clone, Copy)]
pub(crate) enum Each<const N: usize> {
    All(f64),
    Each([f64; N]),
}

impl<const N: usize> fmt::Debug for Each<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All(number) => number.fmt(f),
            Self::Each(numbers) => numbers.fmt(f),
        }
    }
}

impl<const N: usize> Each<N> {
    pub(crate) fn array(self) -> [f64; N] {
        match self {
            Self::All(number) => [number; N],
            Self::Each(numbers) => numbers,
        }
    }
}

impl<'py, const N: usize> FromPyObject<'_, 'py> for Each<N> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(number) = object.extract::<f64>() {
            return Ok(Self::All(number));
        }
        object.extract::<[f64; N]>().map(Self::Each).map_err(|_| {
            let shown = object.repr().map(|text| text.to_string());
            let shown = shown.unwrap_or_default();
            PyTypeError::new_err(format!("expected a number, or {N} of them, not {shown}"))
        })
    }
}

/// An angle in degrees, unless `radians` says otherwise.
pub(crate) fn angle(angle: f64, radians: bool) -> f64 {
    if radians { angle } else { angle.to_radians() }
}

/// Within a turn: whole turns of degrees are no mistake, those of radians are.
pub(crate) fn angle_within_a_turn(value: f64, radians: bool) -> f64 {
    if radians || value.abs() <= 360.0 {
        angle(value, radians)
    } else {
        (value % 360.0).to_radians()
    }
}

/// One of a few words.
pub(crate) fn word<T: Copy>(name: &str, given: &str, known: &[(&str, T)]) -> PyResult<T> {
    let found = known.iter().find(|(word, _)| *word == given);
    found.map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<String> = known.iter().map(|(word, _)| format!("{word:?}")).collect();
        invalid(format!(
            "{name} is {given:?}: give one of {}",
            known.join(", ")
        ))
    })
}

pub(crate) fn axis(name: &str, given: &str) -> PyResult<Axis> {
    word(
        name,
        given,
        &[("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)],
    )
}

/// A colour: `"#c8482c"` (with `"#c8482c80"` half transparent), or red, green, blue
/// and perhaps opacity from 0 to 1, as sRGB has them.
#[derive(Clone, Copy)]
pub(crate) struct AnyColor(pub(crate) Color);

impl<'py> FromPyObject<'_, 'py> for AnyColor {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let wrong = || {
            let shown = object.repr().map(|text| text.to_string());
            invalid(format!(
                "color is {}: give \"#rrggbb\", \"#rrggbbaa\", or three or four numbers from 0 to 1 (sRGB)",
                shown.unwrap_or_default()
            ))
        };
        let components: Vec<f32> = if let Ok(text) = object.extract::<String>() {
            hexadecimal(&text).ok_or_else(wrong)?
        } else {
            object.extract().map_err(|_| wrong())?
        };
        let in_range = components.iter().all(|c| (0.0..=1.0).contains(c));
        match *components.as_slice() {
            [r, g, b] if in_range => Ok(Self(Color::from_srgb([r, g, b]))),
            [r, g, b, a] if in_range => Ok(Self(Color::from_srgb([r, g, b]).with_alpha(a))),
            _ => Err(wrong()),
        }
    }
}

fn hexadecimal(text: &str) -> Option<Vec<f32>> {
    let digits = text.strip_prefix('#')?;
    if !digits.is_ascii() || !matches!(digits.len(), 6 | 8) {
        return None;
    }
    let byte = |at: usize| u8::from_str_radix(&digits[at..at + 2], 16).ok();
    let bytes = (0..digits.len()).step_by(2).map(byte);
    bytes
        .map(|byte| byte.map(|b| f32::from(b) / 255.0))
        .collect()
}
