//! The class `Picture`, and pictures of solids and meshes.

use std::path::PathBuf;
use std::sync::Arc;

use csg::{Mesh, Program};
use glam::{DVec2, DVec3};
use numpy::PyArray3;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use raster::{
    Camera, EdgeOptions, Framing, HiddenEdges, Image, Lens, Part, RasterError, RenderOptions,
    Scene, StandardView, clear_view,
};

use crate::arguments::{AnyColor, Place, word};
use crate::arrays;
use crate::errors::{invalid, of_model};
use crate::mesh::PyMesh;
use crate::solid::PySolid;
use crate::waiting::{Follow, wait, wait_out};

/// A picture: Jupyter shows it, `save` writes a PNG file, `pixels` is an array.
#[pyclass(frozen, name = "Picture", module = "stereotomy")]
pub(crate) struct PyPicture(Image);

#[pymethods]
impl PyPicture {
    /// (width, height) in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        (self.0.width, self.0.height)
    }

    /// Red, green, blue and opacity (sRGB), (height, width, 4) uint8, the top row first: a
    /// view, not a copy.
    #[getter]
    fn pixels<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let image = &slf.get().0;
        let shape = [image.height as usize, image.width as usize, 4];
        arrays::view(slf, &image.pixels, shape)
    }

    /// The bytes of a PNG file.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = wait_out(py, || self.0.to_png())?.map_err(of_picture)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes a PNG file.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        wait_out(py, || self.0.save(path))?.map_err(of_picture)
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py)
    }

    fn __repr__(&self) -> String {
        format!("<Picture of {} x {} pixels>", self.0.width, self.0.height)
    }
}

fn of_picture(error: RasterError) -> PyErr {
    invalid(match &error {
        RasterError::NothingToFrame => {
            "there is nothing to draw: the solid is empty, or all of it smaller than the tolerance"
                .to_owned()
        }
        _ => error.to_string(),
    })
}

/// What a picture shows and how.
#[derive(Clone)]
struct PictureOptions {
    render: RenderOptions,
    /// Along which the camera looks, and what is upwards.
    direction: Option<(DVec3, DVec3)>,
    /// The camera's own place and what it looks at.
    eye: Option<(DVec3, DVec3)>,
    lens: Lens,
}

const KNOWN: [&str; 11] = [
    "size",
    "view",
    "eye",
    "target",
    "fov",
    "parallel",
    "background",
    "color",
    "faces_only",
    "hidden_edges",
    "axes",
];

impl PictureOptions {
    fn of(options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut made = Self {
            render: RenderOptions::presentation().size(640, 480),
            direction: None,
            eye: None,
            lens: Lens::DEFAULT,
        };
        let (mut eye, mut target) = (None, [0.0; 3]);
        for (name, value) in options.into_iter().flatten() {
            let name: String = name.extract()?;
            if value.is_none() && KNOWN.contains(&name.as_str()) {
                continue;
            }
            let render = &mut made.render;
            match name.as_str() {
                "size" => (render.width, render.height) = value.extract()?,
                "view" => made.direction = Some(view(&value)?),
                "eye" => eye = Some(value.extract::<[f64; 3]>()?),
                "target" => target = value.extract()?,
                "fov" => {
                    let degrees: f64 = value.extract()?;
                    if !(degrees > 0.0 && degrees < 180.0) {
                        let wanted = "give degrees between 0 and 180";
                        return Err(invalid(format!("fov is {degrees}: {wanted}")));
                    }
                    made.lens = Lens::Perspective {
                        fov_y: degrees.to_radians(),
                    };
                }
                // Framing finds the height.
                "parallel" if value.extract()? => made.lens = Lens::Orthographic { height: 1.0 },
                "background" => render.background = value.extract::<AnyColor>()?.0,
                "color" => render.default_color = value.extract::<AnyColor>()?.0,
                "faces_only" if value.extract()? => *render = render.faces_only(),
                "hidden_edges" if value.extract()? => {
                    render.edges = Some(EdgeOptions::default().hidden(HiddenEdges::Dash));
                }
                "axes" => render.triad = value.extract()?,
                "parallel" | "faces_only" | "hidden_edges" => {}
                _ => {
                    return Err(PyTypeError::new_err(format!(
                        "render() got an unexpected keyword argument '{name}'; known are {}",
                        KNOWN.join(", ")
                    )));
                }
            }
        }
        if let Some(eye) = eye {
            made.eye = Some((eye.into(), target.into()));
        }
        Ok(made)
    }

    /// A quarter of a pixel, if the solid fills the picture.
    fn tolerance(&self, program: &Program) -> Result<Option<f64>, csg::Error> {
        let pixels = self.render.width.max(self.render.height).max(1);
        let size = program.bounds()?.map(|bounds| bounds.size().max_element());
        Ok(size
            .map(|size| size / (4.0 * f64::from(pixels)))
            .filter(|&tolerance| tolerance > 0.0))
    }

    fn camera(&self, mesh: &Mesh) -> Result<Camera, RasterError> {
        let (direction, up) = match (self.eye, self.direction) {
            (Some((eye, target)), _) => upright(target - eye),
            (None, Some(view)) => view,
            (None, None) => upright(clear_view(mesh, &[])),
        };
        let framing = Framing {
            direction,
            up,
            lens: self.lens,
            aspect: f64::from(self.render.width.max(1)) / f64::from(self.render.height.max(1)),
            // From below it would hide the solid.
            shadow: self.render.ground_shadow && direction.z < 0.0,
        };
        let framed = framing.camera(mesh)?;
        let Some((eye, target)) = self.eye else {
            return Ok(framed);
        };
        // The same depths, seen from there.
        let moved = (framed.eye - eye).dot(direction.normalize());
        let far = (framed.far + moved).max(f64::MIN_POSITIVE);
        let near = (framed.near + moved).max(far * 1e-3);
        Ok(Camera {
            eye,
            target,
            near,
            far,
            ..framed
        })
    }

    fn draw(&self, mesh: &Arc<Mesh>) -> Result<Image, RasterError> {
        let camera = self.camera(mesh)?;
        let mut render = self.render.clone();
        render.ground_shadow &= camera.target.z < camera.eye.z;
        let scene = Scene::new().add(Part::new(Arc::clone(mesh)));
        scene.render(&camera, &render)
    }
}

/// Z is up, unless the view is along it.
fn upright(direction: DVec3) -> (DVec3, DVec3) {
    let up = match direction.truncate() == DVec2::ZERO {
        true => DVec3::Y,
        false => DVec3::Z,
    };
    (direction, up)
}

/// A standard view by its name, or a direction to look along.
fn view(value: &Bound<'_, PyAny>) -> PyResult<(DVec3, DVec3)> {
    if let Ok(name) = value.extract::<String>() {
        let known = StandardView::ALL.map(|view| (view.name(), view));
        return Ok(word("view", &name, &known)?.direction_and_up());
    }
    let direction: DVec3 = value.extract::<[f64; 3]>()?.into();
    if direction.is_finite() && direction != DVec3::ZERO {
        return Ok(upright(direction));
    }
    let wanted = "give a name or a direction to look along";
    Err(invalid(format!("view is {direction}: {wanted}")))
}

#[pymethods]
impl PyMesh {
    /// A picture of the mesh: the options are those of `Solid.render`.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, size=(640, 480), view=None, eye=None, target=(0.0, 0.0, 0.0), fov=30.0, parallel=False, background=None, color=None, faces_only=False, hidden_edges=False, axes=False)"
    )]
    fn render(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyPicture> {
        let options = PictureOptions::of(options)?;
        let image = wait_out(py, || options.draw(&self.mesh))?;
        Ok(PyPicture(image.map_err(of_picture)?))
    }

    /// (Eye, target) of the camera of `render(size=size)`.
    fn _camera(&self, size: (u32, u32)) -> PyResult<(Place, Place)> {
        let mut options = PictureOptions::of(None)?;
        options.render = options.render.size(size.0, size.1);
        let camera = options.camera(&self.mesh).map_err(of_picture)?;
        Ok((camera.eye.into(), camera.target.into()))
    }
}

#[pymethods]
impl PySolid {
    /// A picture of the solid, meshed to a quarter of a pixel.
    ///
    /// size: (width, height) in pixels.
    /// view: "front", "back", "left", "right", "top", "bottom" or "iso", or a direction to
    ///     look along; from where most is seen, if nothing is said.
    /// eye, target: where the camera is, and what it looks at.
    /// fov: the vertical field of view in degrees.
    /// parallel: without perspective.
    /// background, color: behind the solid (transparent unless given), and of faces that
    ///     have no colour.
    /// faces_only: without edges, shadow and ambient occlusion.
    /// hidden_edges: dashed.
    /// axes: drawn in the lower left corner.
    ///
    /// >>> import stereotomy as st
    /// >>> picture = st.cube(1).render(size=(64, 48), background="#ffffff")
    /// >>> picture.pixels.shape
    /// (48, 64, 4)
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, size=(640, 480), view=None, eye=None, target=(0.0, 0.0, 0.0), fov=30.0, parallel=False, background=None, color=None, faces_only=False, hidden_edges=False, axes=False)"
    )]
    fn render(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyPicture> {
        let options = PictureOptions::of(options)?;
        let solid = self.0.clone();
        let follow = Follow::default();
        let mesher = csg::Mesher::new()
            .normals()
            .cancel_token(follow.cancel.clone());
        let image = wait(py, &follow, move || {
            let program = Program::lower(&solid).map_err(of_model)?;
            let mesher = match options.tolerance(&program).map_err(of_model)? {
                Some(tolerance) => mesher.tolerance(tolerance),
                None => mesher,
            };
            let meshed = mesher.mesh(&program).map_err(of_model)?;
            options.draw(&Arc::new(meshed.mesh)).map_err(of_picture)
        })?;
        Ok(PyPicture(image?))
    }
}
