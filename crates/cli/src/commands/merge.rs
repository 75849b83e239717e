//! `merge`: one mesh of the shards that `mesh --shard` wrote.

use std::path::PathBuf;

use csg::Merger;
use io::shard::{ShardFile, write_merged};

use crate::failure::{Failure, exit_codes};
use crate::output::is_stream;
use crate::progress::Progress;

/// Options of `merge`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// All shards of one mesh, in any order, from `mesh --shard`
    #[arg(value_name = "SHARD", required = true)]
    shards: Vec<PathBuf>,
    /// Where to write the mesh (.ply .stl .glb .gltf .obj .off .3mf), by extension: .ply and .stl
    /// with no more than a shard at a time in memory; may be given more than once
    #[arg(short, long = "output", value_name = "OUT", required = true)]
    outputs: Vec<PathBuf>,
}

pub(crate) fn run(options: &Options, progress: &Progress) -> Result<(), Failure> {
    for path in &options.outputs {
        let usage = |cause| Failure::new(exit_codes::USAGE, "no such mesh format", cause);
        if is_stream(path) {
            return Err(usage(
                "a merged mesh is written to a file: name one".to_owned(),
            ));
        }
        io::MeshFormat::from_path(path).map_err(|error| usage(error.to_string()))?;
    }
    progress.stage("reading");
    let unreadable = |error| Failure::new(exit_codes::INPUT, "the shards are no mesh", error);
    let shards = options.shards.iter().map(ShardFile::open);
    let shards: Vec<ShardFile> = shards
        .collect::<Result<_, _>>()
        .map_err(|error| unreadable(error.to_string()))?;
    let merger = Merger::new(shards).map_err(|error| unreadable(error.to_string()))?;
    progress.stage("writing");
    for path in &options.outputs {
        write_merged(path, &merger).map_err(|error| match error {
            io::Error::Slab(error) => unreadable(error.to_string()),
            error => Failure::output(&path.display().to_string(), error),
        })?;
    }
    progress.end();
    for fallback in &merger.report().fallbacks {
        progress.say(fallback);
    }
    progress.say(format_args!(
        "{} vertices, {} triangles of {} shards",
        merger.vertex_count(),
        merger.triangle_count(),
        options.shards.len()
    ));
    for path in &options.outputs {
        progress.say(format_args!("wrote {}", path.display()));
    }
    Ok(())
}
