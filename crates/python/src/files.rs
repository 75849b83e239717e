//! Files: meshes and scenes, in and out.

use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use csg::{BoundaryOptions, Program, Repairs, Solid};
use io::drawing::{DrawingOptions, write_profile};
use io::scene::{ReadOptions, Scene};
use io::step::StepOptions;
use io::{MeshFormat, SolidOptions, WriteOptions};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{FileError, of_file, of_model, of_scene};
use crate::mesh::PyMesh;
use crate::profile::PyProfile;
use crate::solid::PySolid;
use crate::unit;
use crate::waiting::{Follow, wait, wait_out};

pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(load, module)?)?;
    module.add_function(wrap_pyfunction!(read_solid, module)?)?;
    module.add_function(wrap_pyfunction!(load_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(from_csg, module)?)?;
    module.add_function(wrap_pyfunction!(check_name, module)?)?;
    module.add_function(wrap_pyfunction!(write_file, module)?)
}

/// Refuses names of which a mesh is no file, or a solid.
#[pyfunction]
#[pyo3(name = "_check_name")]
fn check_name(path: PathBuf, is_of_solid: bool) -> PyResult<()> {
    if is_of_solid && (is_scene(&path) || io::step::is_step(&path)) {
        return Ok(());
    }
    MeshFormat::from_path(&path).map_err(of_file).map(|_| ())
}

/// Writes a file, whole or not at all.
#[pyfunction]
#[pyo3(name = "_write_file")]
fn write_file(py: Python<'_>, path: PathBuf, data: Vec<u8>) -> PyResult<()> {
    wait_out(py, move || whole(&path, &data))?.map_err(of_file)
}

fn whole(path: &Path, data: &[u8]) -> Result<(), io::Error> {
    let mut file = io::AtomicFile::create(path)?;
    std::io::Write::write_all(&mut file, data)?;
    file.commit()
}

fn is_scene(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|extension| extension.eq_ignore_ascii_case("csg"))
}

/// The solid; warnings become Python's.
fn warned(py: Python<'_>, scene: Scene) -> PyResult<PySolid> {
    for warning in &scene.warnings {
        warn(py, &warning.to_string())?;
    }
    Ok(PySolid(scene.solid))
}

pub(crate) fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let text = CString::new(text.replace('\0', " "))?;
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)
}

/// A solid that was mended, with a warning that says what was changed, if anything was.
pub(crate) fn repaired(py: Python<'_>, (solid, repairs): (Solid, Repairs)) -> PyResult<PySolid> {
    if !repairs.is_empty() {
        warn(py, &format!("the mesh was repaired: {repairs}"))?;
    }
    Ok(PySolid(solid))
}

/// The solid of a file: an OpenSCAD tree (.csg), or a mesh that bounds it (.stl, .obj, .ply,
/// .off, .glb, .gltf: see `read_solid`). With `faceted` circles of a tree are the polygons
/// that OpenSCAD makes of them. A file may name others in its own folder or below only,
/// unless `any_folder` is said. With `repair` meshes that bound no solid are mended, with a
/// warning that says what was changed. Lengths of .3mf, .glb and .gltf files, also of those that
/// a tree imports, are converted to `unit` (um, mm, cm, m, in, ft); others have no unit and are
/// taken as they are.
///
/// >>> import stereotomy as st
/// >>> st.load("nowhere.csg")
/// Traceback (most recent call last):
/// FileNotFoundError: [Errno 2] nowhere.csg: No such file or directory (os error 2)
#[pyfunction]
#[pyo3(signature = (path, *, faceted=false, any_folder=false, repair=false, unit="mm"))]
fn load(
    py: Python<'_>,
    path: PathBuf,
    faceted: bool,
    any_folder: bool,
    repair: bool,
    unit: &str,
) -> PyResult<PySolid> {
    if !is_scene(&path) {
        return read_solid(py, path, repair, unit);
    }
    let options = ReadOptions::default()
        .unit(unit::named(unit)?)
        .faceted(faceted)
        .any_folder(any_folder)
        .repair(repair);
    let scene = wait_out(py, move || io::scene::read_file(path, &options))?;
    warned(py, scene.map_err(of_scene)?)
}

/// The solid that a mesh file bounds, by its extension (.stl, .obj, .ply, .off, .glb or
/// .gltf), to be combined with others. All that is wrong with the mesh is an error with
/// places; with `repair` what can be is mended, with a warning that says what was changed.
/// Objects that touch, overlap or lie in each other are united. Lengths of .3mf, .glb and .gltf
/// files are converted to `unit` (um, mm, cm, m, in, ft); others have no unit and are taken as
/// they are.
#[pyfunction]
#[pyo3(signature = (path, *, repair=false, unit="mm"))]
fn read_solid(py: Python<'_>, path: PathBuf, repair: bool, unit: &str) -> PyResult<PySolid> {
    let options = SolidOptions::default()
        .repair(repair)
        .unit(unit::named(unit)?);
    let solid = wait_out(py, move || io::read_solid_with(path, &options))?;
    repaired(py, solid.map_err(of_file)?)
}

/// The mesh of a file, by its extension (.stl, .obj, .ply, .off, .glb or .gltf).
#[pyfunction]
#[pyo3(signature = (path, *, any_folder=false))]
fn load_mesh(py: Python<'_>, path: PathBuf, any_folder: bool) -> PyResult<PyMesh> {
    let options = io::ReadOptions::default().any_folder(any_folder);
    let mesh = wait_out(py, move || io::read_mesh_with(path, &options))?;
    Ok(PyMesh::without_report(mesh.map_err(of_file)?))
}

/// The solid of an OpenSCAD tree as text.
///
/// >>> import stereotomy as st
/// >>> st.from_csg("cube(size = [1, 2, 3], center = true);").contains([0, 0, 1.4])
/// True
/// >>> st.from_csg("cube(")
/// Traceback (most recent call last):
/// stereotomy.FileError: line 1, column 6: found the end of the text, not a value
#[pyfunction]
#[pyo3(signature = (text, *, faceted=false))]
fn from_csg(py: Python<'_>, text: String, faceted: bool) -> PyResult<PySolid> {
    let options = ReadOptions::default().faceted(faceted);
    let scene = wait_out(py, move || io::scene::read(&text, &options))?;
    warned(py, scene.map_err(of_scene)?)
}

#[pymethods]
impl PySolid {
    /// The solid as text of an OpenSCAD tree (.csg).
    ///
    /// >>> import stereotomy as st
    /// >>> print(st.sphere(2).to_csg().strip())
    /// sphere($fn = 0, $fa = 12, $fs = 2, r = 2);
    fn to_csg(&self, py: Python<'_>) -> PyResult<String> {
        let text = wait_out(py, || io::scene::write(&self.0))?;
        text.map_err(|error| FileError::new_err(error.to_string()))
    }

    /// Writes the solid to a file, by its extension: an OpenSCAD tree (.csg), its exact
    /// boundary for CAD systems (.step, .stp; of the options `unit` alone), or the mesh that
    /// the options of `mesh` give (.glb, .gltf, .obj, .stl, .ply, .off, .3mf). The file is
    /// replaced whole or not at all.
    ///
    /// `text`, `vertex_colors` and `instances` are those of `Mesh.save`; with `instances` bodies
    /// that are the same in the solid get the same triangles.
    #[pyo3(signature = (path, *, text=false, vertex_colors=false, instances=false, **options))]
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        text: bool,
        vertex_colors: bool,
        instances: bool,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let is_exact = is_scene(&path) || io::step::is_step(&path);
        if is_exact && (text || vertex_colors || instances) {
            return Err(FileError::new_err(format!(
                "{}: text, vertex_colors and instances are of meshes",
                path.display()
            )));
        }
        if is_scene(&path) {
            if let Some(name) = options.into_iter().flatten().map(|(name, _)| name).next() {
                return Err(FileError::new_err(format!(
                    "{}: a tree is not meshed: leave out {name}",
                    path.display()
                )));
            }
            let text = self.to_csg(py)?;
            return wait_out(py, move || whole(&path, text.as_bytes()))?.map_err(of_file);
        }
        if io::step::is_step(&path) {
            return self.save_step(py, path, options);
        }
        // Before minutes of meshing.
        MeshFormat::from_path(&path).map_err(of_file)?;
        let mut mesh = self.mesh(py, options)?;
        if instances {
            self.share_triangles(py, &mut mesh)?;
        }
        mesh.save(py, path, text, vertex_colors, instances)
    }
}

impl PySolid {
    /// Gives bodies that are the same the same triangles, if the mesh is that of the boundary.
    fn share_triangles(&self, py: Python<'_>, mesh: &mut PyMesh) -> PyResult<()> {
        let report = mesh.report.as_ref().map(|report| &report.0);
        if report.is_none_or(|report| report.deviation.is_none() || report.moved.is_some()) {
            return Ok(());
        }
        let follow = Follow::default();
        let boundary = BoundaryOptions::new().cancel_token(follow.cancel.clone());
        let solid = self.0.clone();
        let mut shared = csg::Mesh::clone(&mesh.mesh);
        let shared = wait(py, &follow, move || {
            let brep = Program::lower(&solid)?.boundary(&boundary)?;
            io::share_triangles(&mut shared, &brep);
            Ok(shared)
        })?;
        mesh.mesh = Arc::new(shared.map_err(of_model)?);
        Ok(())
    }

    /// Writes a STEP file; the product's name is the file's.
    fn save_step(
        &self,
        py: Python<'_>,
        path: PathBuf,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut step = StepOptions::default().name(name);
        for (name, value) in options.into_iter().flatten() {
            if name.extract::<&str>()? != "unit" {
                return Err(FileError::new_err(format!(
                    "{}: an exact boundary is not meshed: leave out {name}",
                    path.display()
                )));
            }
            step = step.unit(unit::named(value.extract()?)?);
        }
        let follow = Follow::default();
        let boundary = BoundaryOptions::new()
            .cut_at_seams()
            .cancel_token(follow.cancel.clone());
        let solid = self.0.clone();
        let brep = wait(py, &follow, move || {
            Program::lower(&solid)?.boundary(&boundary)
        })?;
        let brep = brep.map_err(of_model)?;
        wait_out(py, move || io::step::write_step_file(path, &brep, &step))?.map_err(of_file)
    }
}

#[pymethods]
impl PyProfile {
    /// Writes the profile as a drawing: .svg, .dxf or .pdf by the path's extension, with lines,
    /// arcs and ellipses as such.
    ///
    /// >>> import pathlib, tempfile, stereotomy as st
    /// >>> with tempfile.TemporaryDirectory() as folder:
    /// ...     path = pathlib.Path(folder) / "plate.dxf"
    /// ...     (st.rectangle([4, 2]) - st.circle(0.5)).save(path)
    /// ...     "CIRCLE" in path.read_text()
    /// True
    #[pyo3(signature = (path, *, title="", unit="mm"))]
    fn save(&self, py: Python<'_>, path: PathBuf, title: &str, unit: &str) -> PyResult<()> {
        let options = DrawingOptions::default()
            .title(title)
            .unit(unit::named(unit)?);
        let drawn = wait_out(py, || write_profile(path, &self.0, &options))?;
        let drawn = drawn.map_err(of_file)?;
        match drawn.strays {
            Some(strays) => warn(
                py,
                &format!("curves are drawn as chords within {strays:.0e} of them"),
            ),
            None => Ok(()),
        }
    }
}

#[pymethods]
impl PyMesh {
    /// Writes the mesh to a file, by its extension: .glb, .gltf, .obj, .stl, .ply, .off or
    /// .3mf. The file is replaced whole or not at all.
    ///
    /// With `text` an STL file is text. With `vertex_colors` a PLY file has colours of vertices, too,
    /// for programs that pass over those of faces. With `instances` bodies of the same triangles, but
    /// for where they are and how they are turned, are written once in glTF, as
    /// EXT_mesh_gpu_instancing says. Other files are what they are without.
    ///
    /// >>> import os, tempfile, stereotomy as st
    /// >>> balls = st.sphere(1).linear_pattern(20, [3, 0, 0])
    /// >>> folder = tempfile.mkdtemp()
    /// >>> plain, once = (os.path.join(folder, name) for name in ("plain.glb", "once.glb"))
    /// >>> balls.mesh(tolerance=0.01).save(plain)
    /// >>> balls.mesh(tolerance=0.01).save(once, instances=True)
    /// >>> 8 * os.path.getsize(once) < os.path.getsize(plain)
    /// True
    #[pyo3(signature = (path, *, text=false, vertex_colors=false, instances=false))]
    pub(crate) fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        text: bool,
        vertex_colors: bool,
        instances: bool,
    ) -> PyResult<()> {
        let mut options = WriteOptions::default();
        options.text = text;
        options.vertex_colors = vertex_colors;
        options.instances = instances;
        wait_out(py, || io::write_mesh(path, &self.mesh, &options))?.map_err(of_file)
    }
}
