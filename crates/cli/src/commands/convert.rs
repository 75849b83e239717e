//! `convert`: from one format to another, by the names of files.

use std::path::{Path, PathBuf};

use csg::{BoundaryOptions, Program};
use io::WriteOptions;

use crate::failure::Failure;
use crate::input::{Input, Wanted};
use crate::mesher::{MesherOptions, no_needs, produce};
use crate::output::{self, StepArguments, StreamFormat};
use crate::progress::Progress;

/// Options of `convert`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    #[command(flatten)]
    input: Input,
    /// Where to write, in the format of its extension: a mesh (.glb .gltf .obj .stl .ply
    /// .off .3mf), or the solid, that which a mesh bounds, too, as a scene (.csg) or with its
    /// exact surfaces (.step .stp); may be given more than once
    #[arg(value_name = "OUT", required = true)]
    outputs: Vec<PathBuf>,
    #[command(flatten)]
    step: StepArguments,
    #[command(flatten)]
    mesher: MesherOptions,
}

pub(crate) fn run(options: &Options, progress: &Progress) -> Result<(), Failure> {
    let meshes: Vec<PathBuf> = options
        .outputs
        .iter()
        .filter(|path| !is_scene(path))
        .cloned()
        .collect();
    output::check(&meshes, None)?;
    output::check_folders(options.outputs.iter().map(PathBuf::as_path))?;
    progress.stage("reading");
    let given = options.mesher.unit;
    let subject = options.input.read(Wanted::solid(given))?;
    let is_exact = |path: &PathBuf| is_scene(path) || io::step::is_step(path);
    if options.outputs.iter().any(is_exact) {
        for path in options.outputs.iter().filter(|path| is_scene(path)) {
            progress.stage("writing");
            // (Scenes have no unit: it is the one that they are read with.)
            let text = io::scene::write(&subject.solid(given)?)
                .map_err(|error| Failure::output(&path.display().to_string(), error))?;
            output::write_bytes(path, text.as_bytes())?;
        }
        for path in options
            .outputs
            .iter()
            .filter(|path| io::step::is_step(path))
        {
            progress.stage("boundary");
            let boundary = BoundaryOptions::new()
                .progress(progress.callback())
                .cut_at_seams();
            let unit = subject.unit(given);
            let brep = Program::lower(&subject.solid(unit)?)?.boundary(&boundary)?;
            progress.stage("writing");
            output::write_step(path, &brep, unit.length_unit(), options.step)?;
        }
    }
    let mut meshes = options
        .outputs
        .iter()
        .filter(|path| !is_exact(path))
        .peekable();
    if meshes.peek().is_some() {
        let product = produce(
            Box::new(|| Ok(subject)),
            &options.mesher,
            true,
            &no_needs,
            progress,
        )?;
        progress.stage("writing");
        for path in meshes {
            let options = WriteOptions::default();
            output::write_mesh(path, &product.mesh, StreamFormat::default(), &options)?;
        }
    }
    progress.end();
    for path in &options.outputs {
        progress.say(format_args!("wrote {}", path.display()));
    }
    Ok(())
}

fn is_scene(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|extension| extension.eq_ignore_ascii_case("csg"))
}
