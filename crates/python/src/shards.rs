//! Slabs of a mesh as shards, and the mesh that they make together: what
//! `stereotomy.distributed` hands out to workers.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use csg::{Merger, Meshed, Program};
use io::shard::{Reading, ShardFile, write_merged, write_shard, write_shard_file};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rayon::ThreadPoolBuilder;

use crate::errors::{of_file, of_model};
use crate::mesh::PyMesh;
use crate::meshing::MeshOptions;
use crate::solid::PySolid;
use crate::waiting::{Follow, wait, wait_out};

pub(crate) fn add_to(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(shard, module)?)?;
    module.add_function(wrap_pyfunction!(merge, module)?)
}

/// A shard, to a file or as bytes, made by some threads; `options` are those of `mesh`.
#[pyfunction]
#[pyo3(name = "_shard", signature = (solid, part, path, threads, options))]
fn shard<'py>(
    py: Python<'py>,
    solid: &PySolid,
    part: (u32, u32),
    path: Option<PathBuf>,
    threads: usize,
    options: &Bound<'py, PyDict>,
) -> PyResult<Option<Bound<'py, PyBytes>>> {
    let MeshOptions { mesher, follow } = MeshOptions::of("mesh", Some(options))?;
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool =
        pool.map_err(|error| PyRuntimeError::new_err(format!("no threads to work with: {error}")))?;
    let (part, of) = part;
    let solid = solid.0.clone();
    let slab = wait(py, &follow, move || {
        pool.install(|| mesher.slab(&Program::lower(&solid)?, part, of))
    })?;
    let slab = slab.map_err(of_model)?;
    if let Some(path) = path {
        wait_out(py, move || write_shard_file(path, &slab))?.map_err(of_file)?;
        return Ok(None);
    }
    let bytes = wait_out(py, move || {
        let mut bytes = Vec::new();
        write_shard(&slab, &mut bytes).map(|()| bytes)
    })?;
    Ok(Some(PyBytes::new(py, &bytes.map_err(of_file)?)))
}

/// The mesh of shards, in a file or in memory.
#[pyfunction]
#[pyo3(name = "_merge", signature = (shards, path, normals, check, progress))]
fn merge<'py>(
    py: Python<'py>,
    shards: Vec<PathBuf>,
    path: Option<PathBuf>,
    normals: bool,
    check: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Option<PyMesh>> {
    let follow = Follow {
        callback: progress,
        ..Follow::default()
    };
    let (share, length) = (follow.share.clone(), Arc::new(AtomicU64::new(u64::MAX)));
    let all = Arc::clone(&length);
    let reading = Reading::new()
        .cancel_token(follow.cancel.clone())
        .progress(move |bytes| {
            // (To begin with some shards are looked at, then all of them once.)
            share.set((bytes as f64 / all.load(Ordering::Relaxed) as f64).min(1.0));
        });
    let made = wait(py, &follow, move || {
        let shards = shards.iter().map(ShardFile::open);
        let shards = shards.collect::<Result<Vec<_>, _>>()?;
        let bytes = shards.iter().map(ShardFile::length).sum::<u64>().max(1);
        length.store(bytes, Ordering::Relaxed);
        let shards = shards.into_iter().map(|shard| shard.followed(&reading));
        let merger = Merger::new(shards.collect())?;
        if let Some(path) = path {
            return write_merged(path, &merger).map(|_| None);
        }
        let mut meshed = Meshed::default();
        meshed.mesh = match normals {
            true => merger.mesh_with_normals()?,
            false => merger.mesh()?,
        };
        meshed.report = merger.report().clone();
        if check {
            meshed.report.check = meshed.mesh.check();
        }
        Ok(Some(meshed))
    })?;
    Ok(made.map_err(of_file)?.map(PyMesh::of))
}
