//! Faults of the crates as Python's exceptions.

use std::fmt::Debug;

use pyo3::create_exception;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

create_exception!(
    stereotomy,
    Unbounded,
    PyValueError,
    "The solid has no end where one is needed."
);
create_exception!(
    stereotomy,
    LimitReached,
    PyRuntimeError,
    "The mesh would cost more than the limits given (max_cells, max_triangles, ...)."
);
create_exception!(
    stereotomy,
    FileError,
    PyValueError,
    "A file says nothing that can be read, or cannot hold what is to be written."
);

pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("Unbounded", py.get_type::<Unbounded>())?;
    module.add("LimitReached", py.get_type::<LimitReached>())?;
    module.add("FileError", py.get_type::<FileError>())
}

/// What is wrong with a call's arguments.
pub(crate) fn invalid(message: impl Into<String>) -> PyErr {
    PyValueError::new_err(message.into())
}

/// Of a solid that cannot be lowered or meshed. A cancelled one never comes here:
/// who cancelled has an exception of their own.
pub(crate) fn of_model(error: csg::Error) -> PyErr {
    let message = error.to_string();
    match error {
        csg::Error::Unbounded { .. } => Unbounded::new_err(message),
        csg::Error::LimitReached(_) => LimitReached::new_err(format!("{message} (partial=True)")),
        csg::Error::TooLarge { .. } => LimitReached::new_err(message),
        csg::Error::Slab { .. } => FileError::new_err(message),
        csg::Error::Cancelled => PyRuntimeError::new_err(message),
        _ => PyValueError::new_err(message),
    }
}

/// What the system says, as the subclass of `OSError` that it is.
fn of_system(source: &std::io::Error, message: String) -> PyErr {
    let kind = std::io::Error::new(source.kind(), message.clone());
    let error = PyErr::from(kind);
    match source.raw_os_error() {
        // With a number, `OSError` is a `FileNotFoundError` and so on by itself.
        Some(number) => PyOSError::new_err((number, message)),
        None => error,
    }
}

pub(crate) fn of_file(error: io::Error) -> PyErr {
    let message = error.to_string();
    match &error {
        io::Error::Slab(error) => of_model(error.clone()),
        io::Error::File { source, .. } | io::Error::Write(source) => of_system(source, message),
        io::Error::InFile { source, .. } => match &**source {
            io::Error::File { source, .. } | io::Error::Write(source) => of_system(source, message),
            _ => FileError::new_err(message),
        },
        _ => FileError::new_err(message),
    }
}

pub(crate) fn of_scene(error: io::scene::SceneError) -> PyErr {
    let message = error.to_string();
    match error {
        io::scene::SceneError::Io { source, .. } => of_system(&source, message),
        io::scene::SceneError::NotASolid { .. } => {
            FileError::new_err(format!("{message}; `repair=True` mends what it can"))
        }
        _ => FileError::new_err(message),
    }
}

/// An argument as a call shows it: long ones cut short.
pub(crate) fn shown(name: &str, value: &dyn Debug) -> String {
    const MOST: usize = 60;
    let text = format!("{name}={value:?}");
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

/// The call as a message shows it, made only when there is a message:
/// `sphere(radius=-1.0)`.
macro_rules! call {
    ($function:literal $(, $argument:ident)*) => {
        || {
            let arguments: Vec<String> =
                vec![$($crate::errors::shown(stringify!($argument), &$argument)),*];
            format!("{}({})", $function, arguments.join(", "))
        }
    };
}
pub(crate) use call;
