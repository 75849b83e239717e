//! What goes in: a scene, a mesh, or a model written in Rust.

use std::io::Read;
use std::path::{Path, PathBuf};

use csg::{Mesh, Solid};
use io::MeshFormat;
use io::scene::{self, ReadOptions, Scene, SceneError};

use crate::failure::Failure;
use crate::openscad;

/// The input file of the `csg` command.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Input {
    /// The input: a scene (.csg), an OpenSCAD model (.scad, if openscad is
    /// installed), or a mesh (.glb .gltf .obj .stl .ply .off); `-` reads a scene
    /// from standard input
    #[arg(value_name = "IN")]
    pub(crate) path: PathBuf,
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
    /// Set a variable of an OpenSCAD model
    #[arg(short = 'D', value_name = "NAME=VALUE")]
    define: Vec<String>,
}

/// What a command works on.
pub(crate) enum Subject {
    /// A solid, still to be meshed.
    Solid(Solid),
    /// A mesh, as it was read.
    Mesh(Mesh),
}

impl Input {
    /// Reads the file by its extension; warnings go to standard error. With
    /// `faces_only`, a mesh need not be connected ([`io::ReadOptions::to_draw`]).
    pub(crate) fn read(&self, faces_only: bool) -> Result<Subject, Failure> {
        let name = self.name();
        match self.contents(faces_only)? {
            Contents::Mesh(mesh) => Ok(Subject::Mesh(mesh)),
            Contents::Scene(scene) => {
                let scene = scene.map_err(|error| scene_failure(&name, error))?;
                for warning in &scene.warnings {
                    eprintln!("warning: {warning}");
                }
                Ok(Subject::Solid(scene.solid))
            }
        }
    }

    /// The same, with what is wrong in a scene's text as the reader says it.
    pub(crate) fn contents(&self, faces_only: bool) -> Result<Contents, Failure> {
        let options = ReadOptions::default()
            .faceted(self.faceted)
            .any_folder(self.any_folder);
        let options = self.font.iter().fold(options, ReadOptions::font);
        if self.is_stream() {
            let mut bytes = Vec::new();
            std::io::stdin()
                .read_to_end(&mut bytes)
                .map_err(|error| Failure::input("standard input", error))?;
            return Ok(Contents::Scene(scene::read_bytes(&bytes, &options)));
        }
        let name = self.path.display().to_string();
        if MeshFormat::from_path(&self.path).is_ok() {
            let options = io::ReadOptions::default()
                .any_folder(self.any_folder)
                .to_draw(faces_only);
            let mesh = io::read_mesh_with(&self.path, &options)
                .map_err(|error| Failure::input(&name, error))?;
            return Ok(Contents::Mesh(mesh));
        }
        if self.has_extension("scad") {
            let text = openscad::evaluated(&self.path, &self.define)?;
            let folder = self.path.parent().unwrap_or(Path::new(""));
            return Ok(Contents::Scene(scene::read_bytes(
                &text,
                &options.folder(folder),
            )));
        }
        if !self.has_extension("csg") {
            let hint = "name a .csg scene, an OpenSCAD model (.scad) or a .glb, .gltf, .obj, .stl, .ply or .off mesh";
            return Err(Failure::input(&name, "its extension is not known").hint(hint));
        }
        Ok(Contents::Scene(scene::read_file(&self.path, &options)))
    }

    /// What it is called in messages.
    fn name(&self) -> String {
        let name = self.path.display();
        match self {
            _ if self.is_stream() => "standard input".to_owned(),
            _ if self.has_extension("scad") => format!("{name}, as openscad evaluates it"),
            _ => name.to_string(),
        }
    }

    pub(crate) fn is_stream(&self) -> bool {
        self.path.as_os_str() == "-"
    }

    fn has_extension(&self, known: &str) -> bool {
        let extension = self.path.extension().and_then(|e| e.to_str());
        extension.is_some_and(|e| e.eq_ignore_ascii_case(known))
    }
}

/// What a file holds.
pub(crate) enum Contents {
    Mesh(Mesh),
    Scene(Result<Scene, SceneError>),
}

fn scene_failure(name: &str, error: SceneError) -> Failure {
    let hint = match &error {
        SceneError::Unsupported { .. } => {
            Some("rewrite that part with the supported nodes, or leave it out with `%`")
        }
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
