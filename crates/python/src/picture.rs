//! The class `Picture`, and pictures of solids and meshes.

use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;

use csg::{Color, Mesh, Program};
use glam::{DVec2, DVec3, Vec3};
use io::AtomicFile;
use numpy::PyArray3;
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use raster::{
    Camera, EdgeOptions, Finish, Framing, HiddenEdges, Image, Lens, Light, MAX_SECTIONS, Part,
    Prepared, RasterError, RenderOptions, Renderer, Scene, SectionPlane, StandardView, clear_view,
    turntable, turntable_camera, write_apng, write_gif,
};

use crate::arguments::{AnyColor, Place, keywords, read, word};
use crate::arrays;
use crate::errors::{invalid, of_file, of_model};
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

/// Pictures of one size, one after another: Jupyter plays them, `save` writes an animated PNG or a
/// GIF file, and `animation[k]` is a `Picture`.
#[pyclass(frozen, sequence, name = "Animation", module = "stereotomy")]
pub(crate) struct PyAnimation {
    frames: Vec<Image>,
    frames_per_second: u16,
}

impl PyAnimation {
    fn bytes(&self, is_gif: bool) -> Result<Vec<u8>, RasterError> {
        let mut bytes = Vec::new();
        let write = if is_gif { write_gif } else { write_apng };
        write(&self.frames, self.frames_per_second, &mut bytes)?;
        Ok(bytes)
    }
}

#[pymethods]
impl PyAnimation {
    /// (width, height) in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        let first = self.frames.first();
        first.map_or((0, 0), |first| (first.width, first.height))
    }

    fn __len__(&self) -> usize {
        self.frames.len()
    }

    fn __getitem__(&self, index: isize) -> PyResult<PyPicture> {
        let count = self.frames.len() as isize;
        let at = if index < 0 { index + count } else { index };
        let frame = usize::try_from(at).ok().and_then(|at| self.frames.get(at));
        frame
            .cloned()
            .map(PyPicture)
            .ok_or_else(|| PyIndexError::new_err(format!("frame {index} of {count}")))
    }

    /// The bytes of an animated PNG file.
    fn png<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = wait_out(py, || self.bytes(false))?.map_err(of_picture)?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Writes an animated PNG file, or a GIF if the name ends so.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        let is_gif = ending == "gif";
        if !(is_gif || ending == "png") {
            let wanted = "animations are written as .png or .gif";
            return Err(invalid(format!("{}: {wanted}", path.display())));
        }
        let bytes = wait_out(py, || self.bytes(is_gif))?.map_err(of_picture)?;
        let mut file = AtomicFile::create(&path).map_err(of_file)?;
        file.write_all(&bytes)?;
        file.commit().map_err(of_file)
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py)
    }

    fn __repr__(&self) -> String {
        let (width, height) = self.size();
        let count = self.frames.len();
        format!("<Animation of {count} pictures of {width} x {height} pixels>")
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
    sections: Vec<SectionPlane>,
}

const KNOWN: [&str; 17] = [
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
    "sections",
    "cap_color",
    "lights",
    "point_lights",
    "ambient",
    "material",
];

impl PictureOptions {
    /// The keywords of a call.
    fn of(function: &str, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut made = Self {
            render: RenderOptions::presentation().size(640, 480),
            direction: None,
            eye: None,
            lens: Lens::DEFAULT,
            sections: Vec::new(),
        };
        let (mut eye, mut target) = (None, [0.0; 3]);
        let (mut given, mut ambient) = (Vec::new(), None);
        for (name, value) in keywords(function, &KNOWN, options)? {
            let color = || -> PyResult<Color> { Ok(read::<AnyColor>(&name, &value)?.0) };
            let point = || -> PyResult<[f64; 3]> { read(&name, &value) };
            let render = &mut made.render;
            match name.as_str() {
                "size" => (render.width, render.height) = read(&name, &value)?,
                "view" => made.direction = Some(view(&value)?),
                "eye" => eye = Some(point()?),
                "target" => target = point()?,
                "fov" => {
                    let degrees: f64 = read(&name, &value)?;
                    if !(degrees > 0.0 && degrees < 180.0) {
                        let wanted = "give degrees between 0 and 180";
                        return Err(invalid(format!("fov is {degrees}: {wanted}")));
                    }
                    made.lens = Lens::Perspective {
                        fov_y: degrees.to_radians(),
                    };
                }
                // Framing finds the height.
                "parallel" if read(&name, &value)? => {
                    made.lens = Lens::Orthographic { height: 1.0 }
                }
                "background" => render.background = color()?,
                "color" => render.default_color = color()?,
                "faces_only" if read(&name, &value)? => *render = render.faces_only(),
                "hidden_edges" if read(&name, &value)? => {
                    render.edges = Some(EdgeOptions::default().hidden(HiddenEdges::Dash));
                }
                "axes" => render.triad = read(&name, &value)?,
                "sections" => made.sections = sections(&value)?,
                "cap_color" => render.cap_color = Some(color()?),
                "lights" | "point_lights" => given.extend(lights(&name, &value)?),
                "ambient" => ambient = Some(intensity(color()?)),
                "material" => render.finish = finish(&value)?,
                // (What is not wished.)
                _ => {}
            }
        }
        if let Some(eye) = eye {
            made.eye = Some((eye.into(), target.into()));
        }
        let lights = &mut made.render.lights;
        let is_ambient = |light: &Light| matches!(light, Light::Ambient { .. });
        if given.len() > 16 {
            return Err(invalid(format!("{} lights: give 16 at most", given.len())));
        }
        if !given.is_empty() {
            lights.retain(is_ambient);
            lights.append(&mut given);
        }
        if let Some(intensity) = ambient {
            lights.retain(|light| !is_ambient(light));
            lights.push(Light::Ambient { intensity });
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
            (None, None) => upright(clear_view(mesh, &self.sections)),
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

    fn prepared(&self, mesh: &Arc<Mesh>) -> Result<Prepared, RasterError> {
        if self.sections.is_empty() {
            return Ok(Scene::new().add(Part::new(Arc::clone(mesh))).prepare());
        }
        Prepared::with_sections(mesh, &self.sections)
    }

    fn draw(&self, mesh: &Arc<Mesh>) -> Result<Image, RasterError> {
        let camera = self.camera(mesh)?;
        let mut render = self.render.clone();
        render.ground_shadow &= camera.target.z < camera.eye.z;
        let (width, height) = (render.width, render.height);
        let view = camera.view(width, height)?;
        let mut image = Image::default();
        let prepared = self.prepared(mesh)?;
        Renderer::default().draw(&prepared, &view, width, height, &render, &mut image)?;
        Ok(image)
    }

    /// Pictures from all around, at the attitude of the camera and as far away as all sides
    /// need.
    fn turn(&self, mesh: &Arc<Mesh>, frames: u32) -> Result<Vec<Image>, RasterError> {
        let camera = self.camera(mesh)?;
        let (width, height) = (self.render.width, self.render.height);
        let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
        let around = turntable_camera(mesh, StandardView::Iso, self.lens, aspect)?;
        let back = (camera.eye - camera.target).normalize_or_zero();
        let camera = Camera {
            eye: around.target + back * around.eye.distance(around.target),
            up: camera.up,
            ..around
        };
        let mut render = self.render.clone();
        render.ground_shadow &= back.z > 0.0;
        turntable(
            &self.prepared(mesh)?,
            &camera,
            frames,
            width,
            height,
            &render,
        )
    }
}

/// Planes as (normal, point).
fn sections(value: &Bound<'_, PyAny>) -> PyResult<Vec<SectionPlane>> {
    let wrong = |said: &str| invalid(format!("sections: {said}"));
    let planes: Vec<([f64; 3], [f64; 3])> = value.extract().map_err(|_| {
        wrong("give a list of planes, each as (normal, point), with the normal towards what goes")
    })?;
    if planes.len() > MAX_SECTIONS {
        let count = planes.len();
        return Err(wrong(&format!(
            "{count} planes: give {MAX_SECTIONS} at most"
        )));
    }
    let plane = |(normal, point): ([f64; 3], [f64; 3])| {
        let (normal, point) = (DVec3::from(normal), DVec3::from(point));
        match normal.try_normalize() {
            Some(_) if point.is_finite() => Ok(SectionPlane { normal, point }),
            _ => Err(wrong("a normal is zero, or a number not finite")),
        }
    };
    planes.into_iter().map(plane).collect()
}

fn intensity(color: Color) -> Vec3 {
    Vec3::from_array(color.rgb)
}

/// Lights, each as a direction or (`point_lights`) a place, or that and a colour.
fn lights(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Vec<Light>> {
    let is_directional = name == "lights";
    let wrong = || {
        let form = "give a list of (x, y, z), or of ((x, y, z), color)";
        invalid(format!(
            "{name}: {form}, of numbers that are finite and not all 0"
        ))
    };
    let light = |light: PyResult<Bound<'_, PyAny>>| {
        let light = light?;
        let (place, intensity) = match light.extract::<[f64; 3]>() {
            Ok(place) => (place, Vec3::ONE),
            Err(_) => {
                let (place, color) = light
                    .extract::<([f64; 3], AnyColor)>()
                    .map_err(|_| wrong())?;
                (place, intensity(color.0))
            }
        };
        let place = DVec3::from(place);
        if !place.is_finite() || is_directional && place == DVec3::ZERO {
            return Err(wrong());
        }
        Ok(match is_directional {
            true => Light::Directional {
                towards: place,
                intensity,
            },
            false => Light::Point {
                position: place,
                intensity,
            },
        })
    };
    value.try_iter().map_err(|_| wrong())?.map(light).collect()
}

/// Ka, Kd, Ks and n of the Phong model.
fn finish(value: &Bound<'_, PyAny>) -> PyResult<Finish> {
    match value.extract::<[f32; 4]>() {
        Ok(numbers) if numbers.iter().all(|n| (0.0..=1e4).contains(n)) => {
            let [ambient, diffuse, specular, exponent] = numbers;
            Ok(Finish::new(ambient, diffuse, specular, exponent))
        }
        _ => Err(invalid(
            "material: give Ka, Kd, Ks and n of the Phong model, four numbers from 0",
        )),
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
    let direction = DVec3::from(read::<[f64; 3]>("view", value)?);
    if direction.is_finite() && direction != DVec3::ZERO {
        return Ok(upright(direction));
    }
    let wanted = "give a name or a direction to look along";
    Err(invalid(format!("view is {direction}: {wanted}")))
}

/// What pictures are drawn of.
trait Drawn {
    /// Draws its mesh, as fine as its pictures need.
    fn drawn<T: Send>(
        &self,
        py: Python<'_>,
        options: &PictureOptions,
        draw: impl FnOnce(&Arc<Mesh>) -> Result<T, RasterError> + Send,
    ) -> PyResult<T>;

    fn picture(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyPicture> {
        let options = PictureOptions::of("render", options)?;
        let image = self.drawn(py, &options, |mesh| options.draw(mesh))?;
        Ok(PyPicture(image))
    }

    fn animation(
        &self,
        py: Python<'_>,
        frames: u32,
        frames_per_second: u16,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyAnimation> {
        if !((1..=1000).contains(&frames) && (1..=100).contains(&frames_per_second)) {
            return Err(invalid(format!(
                "turntable: frames={frames}, frames_per_second={frames_per_second}: give 1 to 1000, and 1 to 100"
            )));
        }
        let options = PictureOptions::of("turntable", options)?;
        let frames = self.drawn(py, &options, |mesh| options.turn(mesh, frames))?;
        Ok(PyAnimation {
            frames,
            frames_per_second,
        })
    }
}

impl Drawn for PyMesh {
    fn drawn<T: Send>(
        &self,
        py: Python<'_>,
        _: &PictureOptions,
        draw: impl FnOnce(&Arc<Mesh>) -> Result<T, RasterError> + Send,
    ) -> PyResult<T> {
        wait_out(py, || draw(&self.mesh))?.map_err(of_picture)
    }
}

impl Drawn for PySolid {
    fn drawn<T: Send>(
        &self,
        py: Python<'_>,
        options: &PictureOptions,
        draw: impl FnOnce(&Arc<Mesh>) -> Result<T, RasterError> + Send,
    ) -> PyResult<T> {
        let follow = Follow::default();
        let mesher = csg::Mesher::new()
            .normals()
            .cancel_token(follow.cancel.clone());
        wait(py, &follow, move || {
            let program = Program::lower(&self.0).map_err(of_model)?;
            let mesher = match options.tolerance(&program).map_err(of_model)? {
                Some(tolerance) => mesher.tolerance(tolerance),
                None => mesher,
            };
            let meshed = mesher.mesh(&program).map_err(of_model)?;
            draw(&Arc::new(meshed.mesh)).map_err(of_picture)
        })?
    }
}

#[pymethods]
impl PyMesh {
    /// A picture of the mesh: the options are those of `Solid.render`.
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, size=(640, 480), view=None, eye=None, target=(0.0, 0.0, 0.0), fov=30.0, parallel=False, background=None, color=None, faces_only=False, hidden_edges=False, axes=False, sections=(), cap_color=None, lights=None, point_lights=None, ambient=None, material=None)"
    )]
    fn render(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyPicture> {
        self.picture(py, options)
    }

    /// Pictures from all around, once about the upward axis; the options are those of
    /// `Solid.render`.
    #[pyo3(signature = (frames=36, *, frames_per_second=15, **options))]
    fn turntable(
        &self,
        py: Python<'_>,
        frames: u32,
        frames_per_second: u16,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyAnimation> {
        self.animation(py, frames, frames_per_second, options)
    }

    /// (Eye, target) of the camera of `render(size=size)`.
    fn _camera(&self, size: (u32, u32)) -> PyResult<(Place, Place)> {
        let mut options = PictureOptions::of("render", None)?;
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
    /// sections: planes as (normal, point), up to 4, which cut away what lies on the side of
    ///     the normal; caps are hatched, and have `cap_color` if it is given.
    /// lights, point_lights: in place of the three that follow the camera: directions towards
    ///     lights, and places of lights, each alone or as ((x, y, z), color).
    /// ambient: the light from everywhere.
    /// material: Ka, Kd, Ks and n of the Phong model.
    ///
    /// >>> import stereotomy as st
    /// >>> picture = st.cube(1).render(size=(64, 48), background="#ffffff")
    /// >>> picture.pixels.shape
    /// (48, 64, 4)
    #[pyo3(
        signature = (**options),
        text_signature = "($self, *, size=(640, 480), view=None, eye=None, target=(0.0, 0.0, 0.0), fov=30.0, parallel=False, background=None, color=None, faces_only=False, hidden_edges=False, axes=False, sections=(), cap_color=None, lights=None, point_lights=None, ambient=None, material=None)"
    )]
    fn render(&self, py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<PyPicture> {
        self.picture(py, options)
    }

    /// Pictures from all around, once about the upward axis; the options are those of
    /// `render`.
    ///
    /// >>> import stereotomy as st
    /// >>> round_one = st.cube(1).turntable(12, size=(64, 48))
    /// >>> len(round_one), round_one.size
    /// (12, (64, 48))
    #[pyo3(signature = (frames=36, *, frames_per_second=15, **options))]
    fn turntable(
        &self,
        py: Python<'_>,
        frames: u32,
        frames_per_second: u16,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<PyAnimation> {
        self.animation(py, frames, frames_per_second, options)
    }
}
