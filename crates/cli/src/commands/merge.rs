//! `merge`: one mesh of the shards that `mesh --shard` wrote.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use csg::Merger;
use io::shard::{Reading, ShardFile, write_merged};
use serde::Serialize;

use super::account::ReportAccount;
use crate::failure::{Failure, exit_codes};
use crate::interrupt;
use crate::output::{self, is_stream};
use crate::progress::Progress;

/// Options of `merge`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// All shards of one mesh, in any order, from `mesh --shard`
    #[arg(value_name = "SHARD", required = true)]
    shards: Vec<PathBuf>,
    /// Where to write the mesh (.ply .stl .glb .gltf .obj .off .3mf), by extension: .ply, .stl
    /// and .glb with no more than a shard at a time in memory, .glb of more than 1,048,576
    /// triangles as chunks, and of more than 64 of them as several files; may be given more than
    /// once
    #[arg(short, long = "output", value_name = "OUT", required = true)]
    outputs: Vec<PathBuf>,
    /// Write what was put together, and the mesher's report, as JSON; `-` writes to standard
    /// output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What was put together of shards.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Account {
    shards: usize,
    vertices: usize,
    triangles: usize,
    /// Of the model's lengths.
    unit: &'static str,
    /// All that were written.
    files: Vec<String>,
    report: ReportAccount,
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
    let json = options.json.as_deref();
    output::check_folders(options.outputs.iter().map(PathBuf::as_path).chain(json))?;
    progress.stage("reading");
    let reading = Reading::new().cancel_token(interrupt::token());
    let unreadable = |error| Failure::new(exit_codes::INPUT, "the shards are no mesh", error);
    // Each file takes the shards' bytes about once.
    let begun = Arc::new(AtomicU64::new(0));
    let length = Arc::new(AtomicU64::new(u64::MAX));
    let told = progress.callback();
    let reading = reading.progress({
        let (begun, length) = (Arc::clone(&begun), Arc::clone(&length));
        move |bytes| {
            let since = bytes.saturating_sub(begun.load(Ordering::Relaxed));
            told((since as f64 / length.load(Ordering::Relaxed) as f64).min(1.0));
        }
    });
    let shards = options.shards.iter().map(ShardFile::open);
    let shards: Vec<ShardFile> = shards
        .map(|shard| shard.map(|shard| shard.followed(&reading)))
        .collect::<Result<_, _>>()
        .map_err(|error| unreadable(error.to_string()))?;
    let all = shards.iter().map(ShardFile::length).sum::<u64>().max(1);
    length.store(all, Ordering::Relaxed);
    let stopped = || {
        Failure::new(
            exit_codes::INTERRUPTED,
            "stopped",
            "no file is half-written",
        )
    };
    let merger = Merger::new(shards).map_err(|error| match error {
        csg::Error::Cancelled => stopped(),
        error => unreadable(error.to_string()),
    })?;
    let mut written = Vec::new();
    for path in &options.outputs {
        progress.stage("writing");
        begun.store(reading.bytes(), Ordering::Relaxed);
        let files = write_merged(path, &merger).map_err(|error| match error {
            io::Error::Slab(csg::Error::Cancelled) => stopped(),
            io::Error::Slab(error) => unreadable(error.to_string()),
            error => Failure::output(&path.display().to_string(), error),
        })?;
        written.extend(files);
    }
    progress.end();
    for fallback in &merger.report().fallbacks {
        progress.say(fallback);
    }
    if let Some(path) = &options.json {
        let files = written.iter().map(|path| path.display().to_string());
        let account = Account {
            shards: options.shards.len(),
            vertices: merger.vertex_count(),
            triangles: merger.triangle_count(),
            unit: merger.unit().symbol(),
            files: files.collect(),
            report: ReportAccount::of(merger.report()),
        };
        output::write_json(path, &account)?;
    }
    progress.say(format_args!(
        "{} vertices, {} triangles of {} shards",
        merger.vertex_count(),
        merger.triangle_count(),
        options.shards.len()
    ));
    for path in written {
        progress.say(format_args!("wrote {}", path.display()));
    }
    Ok(())
}
