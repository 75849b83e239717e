//! What goes in: a scene, a mesh, or a model written in Rust.

use std::io::Read;
use std::path::{Path, PathBuf};

use csg::{Repairs, Solid};
use io::scene::{self, ReadOptions, Scene, SceneError};
use io::{MeshFile, MeshFormat};

use crate::failure::{Failure, exit_codes};
use crate::mesher::Unit;
use crate::openscad;

/// The input file of the `csg` command.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Input {
    /// The input: a scene (.csg), an OpenSCAD model (.scad, if openscad is
    /// installed), or a mesh (.glb .gltf .obj .stl .ply .off .3mf); `-` reads a scene
    /// from standard input
    #[arg(value_name = "IN")]
    path: PathBuf,
    #[command(flatten)]
    reading: Reading,
}

/// How inputs are read.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Reading {
    /// Read circles, spheres and cones as the polygons that OpenSCAD makes of
    /// them
    #[arg(long)]
    faceted: bool,
    /// A file with fonts that text in the scene may name, beside those installed
    #[arg(long, value_name = "FILE")]
    font: Vec<PathBuf>,
    /// Let the input name files (imports, data, materials) in folders other than
    /// its own
    #[arg(long)]
    any_folder: bool,
    /// Mend meshes, imported ones too, that bound no solid, and say what was changed:
    /// holes, triangles that look the wrong way or are there twice, shells through others
    #[arg(long)]
    repair: bool,
    /// Set a variable of an OpenSCAD model (.scad)
    #[arg(short = 'D', value_name = "NAME=VALUE")]
    define: Vec<String>,
}

/// What an input is read for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted {
    /// Whether a mesh need not be connected ([`io::ReadOptions::to_draw`]).
    pub(crate) faces_only: bool,
    /// The unit of scenes, which have none of their own.
    pub(crate) unit: Unit,
    /// How near chords and flat faces are to be to what they stand for in scenes, if that is asked.
    pub(crate) within: Option<f64>,
}

impl Wanted {
    /// A solid as it is.
    pub(crate) fn solid(unit: Unit) -> Self {
        Self {
            faces_only: false,
            unit,
            within: None,
        }
    }
}

/// Reads what a command works on. (Not generic: every model of its own would compile the commands
/// anew.)
pub(crate) type Reader<'a> = Box<dyn FnOnce() -> Result<Subject, Failure> + 'a>;

/// What a command works on.
pub(crate) enum Subject {
    /// A solid, still to be meshed, and the unit of its lengths, if it has one of its own.
    Solid(Solid, Option<Unit>),
    /// A mesh, as it was read.
    Mesh(MeshFile),
}

impl Subject {
    /// The unit of its lengths: its own, or else the one that is given.
    pub(crate) fn unit(&self, given: Unit) -> Unit {
        match self {
            Self::Solid(_, own) => own.unwrap_or(given),
            Self::Mesh(file) if file.has_unit => Unit::of(file.mesh.unit),
            Self::Mesh(_) => given,
        }
    }

    /// The solid, or that which the mesh bounds, with its lengths in a unit: converted from its
    /// own, if it has one. A mesh that is inside out is turned, with a warning, as scenes do with
    /// what they import.
    pub(crate) fn solid(&self, unit: Unit) -> Result<Solid, Failure> {
        let file = match self {
            Self::Solid(solid, own) => {
                let own = own.filter(|own| *own != unit);
                return Ok(own.map_or_else(
                    || solid.clone(),
                    |own| solid.scale(io::unit_ratio(own.length_unit(), unit.length_unit())),
                ));
            }
            Self::Mesh(file) => file.clone().in_unit(unit.length_unit()),
        };
        let solid = match file.solid() {
            Err(faults) if faults.inside_out => {
                say!("warning: the faces of the mesh are inside out: they are turned");
                file.turned().solid()
            }
            other => other,
        };
        solid.map_err(|faults| no_solid(faults).hint(REPAIR))
    }
}

/// How meshes that bound no solid are mended.
const REPAIR: &str = "--repair mends what it can";

fn no_solid(faults: Box<csg::MeshFaults>) -> Failure {
    Failure::new(exit_codes::MODEL, "the mesh is no solid", faults)
}

impl Input {
    /// Its name.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn is_stream(&self) -> bool {
        is_stream(&self.path)
    }

    /// Reads the file: see [`Reading::read`].
    pub(crate) fn read(&self, wanted: Wanted) -> Result<Subject, Failure> {
        self.reading.read(&self.path, &[], wanted)
    }

    /// The same, with what is wrong in a scene's text as the reader says it.
    #[cfg(feature = "view")]
    pub(crate) fn contents(&self, unit: Unit) -> Result<Contents, Failure> {
        self.reading.contents(&self.path, &[], Wanted::solid(unit))
    }
}

/// What a file holds.
pub(crate) enum Contents {
    Mesh(MeshFile),
    /// With the unit of its lengths, if the file has one.
    Repaired(Solid, Option<Unit>, Repairs),
    Scene(Result<Scene, SceneError>),
}

/// What is to be said of a mesh that was mended, if anything was changed.
pub(crate) fn repaired(path: &Path, repairs: &Repairs) -> Option<String> {
    (!repairs.is_empty()).then(|| format!("{} was repaired: {repairs}", path.display()))
}

impl Reading {
    /// Reads a file by its extension, some more variables of an OpenSCAD model set as in
    /// `name=value`; warnings go to standard error.
    pub(crate) fn read(
        &self,
        path: &Path,
        define: &[String],
        wanted: Wanted,
    ) -> Result<Subject, Failure> {
        match self.contents(path, define, wanted)? {
            Contents::Mesh(file) => Ok(Subject::Mesh(file)),
            Contents::Repaired(solid, own, repairs) => {
                if let Some(warning) = repaired(path, &repairs) {
                    say!("warning: {warning}");
                }
                Ok(Subject::Solid(solid, own))
            }
            Contents::Scene(scene) => {
                let scene = scene.map_err(|error| scene_failure(&name_of(path), error))?;
                for warning in &scene.warnings {
                    say!("warning: {warning}");
                }
                Ok(Subject::Solid(scene.solid, None))
            }
        }
    }

    fn contents(
        &self,
        path: &Path,
        define: &[String],
        wanted: Wanted,
    ) -> Result<Contents, Failure> {
        let Wanted {
            faces_only,
            unit,
            within,
        } = wanted;
        let define = [&self.define, define].concat();
        let name = path.display().to_string();
        if !define.is_empty() && !is_openscad(path) {
            let cause = "it has no variables: only OpenSCAD models (.scad) do, and scenes are \
                         evaluated already";
            return Err(Failure::new(
                exit_codes::USAGE,
                format!("cannot set variables of {name}"),
                cause,
            ));
        }
        let options = ReadOptions::default()
            .faceted(self.faceted)
            .any_folder(self.any_folder)
            .repair(self.repair)
            .unit(unit.length_unit());
        let options = match within.filter(|within| *within > 0.0) {
            Some(within) => options.within(within),
            None => options,
        };
        let options = self.font.iter().fold(options, ReadOptions::font);
        if is_stream(path) {
            let mut bytes = Vec::new();
            std::io::stdin()
                .read_to_end(&mut bytes)
                .map_err(|error| Failure::input("standard input", error))?;
            return Ok(Contents::Scene(scene::read_bytes(&bytes, &options)));
        }
        if MeshFormat::from_path(path).is_ok() {
            let options = io::ReadOptions::default()
                .any_folder(self.any_folder)
                .to_draw(faces_only);
            let file =
                io::read_mesh_file(path, &options).map_err(|error| mesh_failure(&name, error))?;
            for warning in &file.warnings {
                say!("warning: {name}: {warning} (--any-folder)");
            }
            if self.repair {
                let (solid, repairs) = file.repaired().map_err(no_solid)?;
                let own = file.has_unit.then(|| Unit::of(file.mesh.unit));
                return Ok(Contents::Repaired(solid, own, repairs));
            }
            return Ok(Contents::Mesh(file));
        }
        if is_openscad(path) {
            let text = openscad::evaluated(path, &define)?;
            let folder = path.parent().unwrap_or(Path::new(""));
            let scene = scene::read_bytes(&text, &options.folder(folder));
            return Ok(Contents::Scene(scene));
        }
        if path.is_dir() {
            let hint = "name a file in it";
            return Err(Failure::input(&name, "it is a folder").hint(hint));
        }
        if io::step::is_step(path) {
            let hint = "export the part as a mesh (.stl, .3mf, .obj) from the program that made it";
            return Err(Failure::input(&name, "STEP is written, not read").hint(hint));
        }
        let extension = path.extension().and_then(|e| e.to_str());
        if !extension.is_some_and(|e| e.eq_ignore_ascii_case("csg")) {
            let hint = "name a .csg scene, an OpenSCAD model (.scad) or a .glb, .gltf, .obj, .stl, .ply, .off or .3mf mesh";
            return Err(Failure::input(&name, "its extension is not known").hint(hint));
        }
        Ok(Contents::Scene(scene::read_file(path, &options)))
    }
}

/// What a file is called in messages.
fn name_of(path: &Path) -> String {
    let name = path.display();
    match path {
        _ if is_stream(path) => "standard input".to_owned(),
        _ if is_openscad(path) => format!("{name}, as openscad evaluates it"),
        _ => name.to_string(),
    }
}

fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Whether a file's name says that it is an OpenSCAD model.
pub(crate) fn is_openscad(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.is_some_and(|e| e.eq_ignore_ascii_case("scad"))
}

/// How files in other folders are allowed.
const ANY_FOLDER: &str = "--any-folder allows files of any folder";

fn mesh_failure(name: &str, error: io::Error) -> Failure {
    let is_outside = match &error {
        io::Error::InFile { source, .. } => matches!(**source, io::Error::OtherFolder { .. }),
        _ => false,
    };
    let failure = Failure::input(name, error);
    if is_outside {
        failure.hint(ANY_FOLDER)
    } else {
        failure
    }
}

fn scene_failure(name: &str, error: SceneError) -> Failure {
    let hint = match &error {
        SceneError::Unsupported { .. } => {
            Some("rewrite that part with the supported nodes, or leave it out with `%`")
        }
        SceneError::OtherFolder { .. } => Some(ANY_FOLDER),
        SceneError::NotASolid { .. } => Some(REPAIR),
        SceneError::Syntax { .. } => Some(
            "scenes are OpenSCAD's evaluated trees, as `openscad -o part.csg part.scad` writes them",
        ),
        _ => None,
    };
    let failure = Failure::input(name, error);
    match hint {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}
