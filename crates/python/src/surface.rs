//! The class `Surface`: where triangles come from.

use csg::{Color, MeshSurface};
use pyo3::prelude::*;

use crate::arguments::AnyColor;

/// One surface of one primitive, which triangles of a mesh lie on.
#[pyclass(frozen, from_py_object, name = "Surface", module = "stereotomy")]
#[derive(Clone)]
pub(crate) struct PySurface(pub(crate) MeshSurface);

#[pymethods]
impl PySurface {
    #[new]
    #[pyo3(signature = (surface=0, primitive=0, name=None, color=None))]
    fn new(surface: u32, primitive: u32, name: Option<String>, color: Option<AnyColor>) -> Self {
        Self(MeshSurface {
            surface,
            primitive,
            name: name.map(Into::into),
            color: color.map(|color| color.0),
            ..MeshSurface::default()
        })
    }

    /// The surface's number in the solid that was meshed.
    #[getter]
    fn surface(&self) -> u32 {
        self.0.surface
    }

    /// The primitive's number in the solid that was meshed.
    #[getter]
    fn primitive(&self) -> u32 {
        self.0.primitive
    }

    /// The innermost name around the primitive, if any.
    #[getter]
    fn name(&self) -> Option<&str> {
        self.0.name.as_deref()
    }

    /// Red, green, blue and opacity from 0 to 1 (sRGB, to three decimals), if the primitive
    /// has a colour.
    #[getter]
    fn color(&self) -> Option<(f64, f64, f64, f64)> {
        let color = self.0.color?;
        let [r, g, b] = color.to_srgb();
        let [r, g, b, a] = [r, g, b, color.alpha].map(|c| (f64::from(c) * 1e3).round() / 1e3);
        Some((r, g, b, a))
    }

    fn __repr__(&self) -> String {
        let name = self
            .name()
            .map_or("None".into(), |name| format!("{name:?}"));
        format!(
            "<Surface {} of primitive {}, name {name}>",
            self.0.surface, self.0.primitive
        )
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    fn __hash__(&self) -> u64 {
        u64::from(self.0.surface) << 32 | u64::from(self.0.primitive)
    }

    fn __reduce__(&self, py: Python<'_>) -> PyResult<(Py<PyAny>, LinearSurface)> {
        let function = py.import("stereotomy._stereotomy")?.getattr("_surface")?;
        let color = self.0.color.map(
            |Color {
                 rgb: [r, g, b],
                 alpha,
             }| [r, g, b, alpha],
        );
        let name = self.name().map(str::to_owned);
        let parts = self.0.parts.iter().map(ToString::to_string).collect();
        let numbers = [self.0.surface, self.0.primitive, self.0.body];
        Ok((function.unbind(), (numbers, name, parts, color)))
    }
}

/// A surface's numbers, names and its colour's linear components, to the bit.
pub(crate) type LinearSurface = ([u32; 3], Option<String>, Vec<String>, Option<[f32; 4]>);

/// A surface from what pickles hold.
#[pyfunction]
#[pyo3(name = "_surface")]
pub(crate) fn stored_surface(
    numbers: [u32; 3],
    name: Option<String>,
    parts: Vec<String>,
    color: Option<[f32; 4]>,
) -> PySurface {
    let [surface, primitive, body] = numbers;
    let parts = parts.into_iter().map(Into::into);
    PySurface(MeshSurface {
        surface,
        primitive,
        body,
        name: name.map(Into::into),
        parts: parts.collect(),
        color: color.map(|[r, g, b, alpha]| Color::from_linear([r, g, b]).with_alpha(alpha)),
    })
}
