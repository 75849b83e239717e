//! `mesh`: write mesh files, and STEP.

use std::path::{Path, PathBuf};
use std::time::Instant;

use csg::{Program, Solid};
use glam::DVec3;
use io::shard::{is_shard, write_shard_file};
use io::{MeshFormat, WriteOptions};
use serde::Serialize;

use super::account::Account;
use super::exact::ExactAccount;
use crate::failure::{Failure, exit_codes};
use crate::input::{Reader, Subject};
use crate::mesher::{MesherOptions, Product, Unit, no_needs, produce};
use crate::nothing::Nothing;
use crate::output::{self, StepArguments, StreamFormat, is_stream};
use crate::progress::Progress;
use crate::shard::Shard;

/// Options of `mesh`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Where to write: a mesh (.glb .gltf .obj .stl .ply .off .3mf), or the solid with
    /// its exact surfaces, for CAD systems (.step .stp), by extension; or `-` for a mesh
    /// on standard output; may be given more than once
    #[arg(short, long = "output", value_name = "OUT", required = true)]
    outputs: Vec<PathBuf>,
    /// The format on standard output
    #[arg(long, value_enum, default_value_t)]
    format: StreamFormat,
    /// Make .glb files as small as can be: coordinates in 16 bits, coded as glTF's
    /// EXT_meshopt_compression says
    #[cfg(feature = "compress")]
    #[arg(long)]
    compress: bool,
    /// Write bodies that are the same but for where they are, and how they are turned, once in
    /// .glb and .gltf files, as glTF's EXT_mesh_gpu_instancing says
    #[arg(long)]
    instances: bool,
    /// Give vertices of .ply files colours, too, each once for every colour around it, for
    /// programs that pass over colours of faces, as Blender does
    #[arg(long)]
    vertex_colors: bool,
    #[command(flatten)]
    step: StepArguments,
    #[command(flatten)]
    pub(crate) mesher: MesherOptions,
    /// Make only the i-th of n slabs of a mesh by cells, as 1/4, and write it as a .shard: made
    /// anywhere, each by itself, `merge` puts them together to the same mesh, to the byte, for
    /// any n
    #[arg(long, value_name = "I/N", conflicts_with = "json")]
    shard: Option<Shard>,
    /// Write measures, checks, times and the mesher's report as JSON; `-`
    /// writes to standard output
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Options {
    fn write_options(&self) -> WriteOptions {
        let mut write = WriteOptions::default();
        write.instances = self.instances;
        write.vertex_colors = self.vertex_colors;
        #[cfg(feature = "compress")]
        {
            write.compress = self.compress;
        }
        write
    }
}

pub(crate) fn run(
    subject: Reader<'_>,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    if let Some(shard) = options.shard {
        return write_shard(subject, shard, options, progress);
    }
    output::check(&options.outputs, options.json.as_deref())?;
    progress.stage("reading");
    let start = Instant::now();
    let subject = subject()?;
    let read = start.elapsed();
    let is_exact = options.outputs.iter().all(io::step::is_step);
    if is_exact && (matches!(subject, Subject::Mesh(_)) || !options.mesher.is_of_mesh()) {
        let unit = subject.unit(options.mesher.unit);
        return write_exact(&subject.solid(unit)?, unit, options, progress);
    }
    // What a mesh bounds, for STEP files beside other ones.
    let is_bounded =
        matches!(subject, Subject::Mesh(_)) && options.outputs.iter().any(io::step::is_step);
    let bounded = is_bounded.then(|| subject.solid(subject.unit(options.mesher.unit)));
    let bounded = bounded.transpose()?;
    let mut product = produce(
        Box::new(|| Ok(subject)),
        &options.mesher,
        true,
        &no_needs,
        progress,
    )?;
    product.seconds.push(("read", read.as_secs_f64()));
    if options.instances {
        progress.stage("bodies");
        product.stage("bodies", |product| {
            share_triangles(product, options, progress)
        })?;
    }
    product.stage("write", |product| {
        let mut outputs = options.outputs.iter();
        outputs.try_for_each(|path| {
            if io::step::is_step(path) {
                progress.stage("boundary");
                let boundary = options.mesher.boundary(progress).cut_at_seams();
                let brep = match (&product.program, &bounded) {
                    (Some(program), _) => program.boundary(&boundary)?,
                    (None, Some(solid)) => Program::lower(solid)?.boundary(&boundary)?,
                    (None, None) => return Ok(()),
                };
                progress.stage("writing");
                return output::write_step(path, &brep, product.mesh.unit, options.step);
            }
            progress.stage("writing");
            let write = options.write_options();
            output::write_mesh(path, &product.mesh, options.format, &write)
        })
    })?;
    progress.stage("measuring");
    let account = Account::of(&mut product);
    progress.end();
    if options
        .outputs
        .iter()
        .any(|path| is_binary_stl(path, options.format))
    {
        warn_of_rounding(&product);
    }
    tell(&account, options, progress)
}

fn is_binary_stl(path: &Path, stream: StreamFormat) -> bool {
    if is_stream(path) {
        return stream == StreamFormat::Stl;
    }
    matches!(MeshFormat::from_path(path), Ok(MeshFormat::Stl))
}

/// Says if vertices fall together, or a mesh that does not run through itself does so, once its
/// coordinates are rounded to the digits of a binary STL file.
fn warn_of_rounding(product: &Product) {
    /// Of the mesh's deviation: where coordinates are rounded by less it is not looked for, which
    /// would take as long as the check of a mesh.
    const LEAST_STEP: f64 = 1e-3;
    let Product {
        mesh,
        report: Some(report),
        ..
    } = product
    else {
        return;
    };
    let step = io::stl::step_of_binary(mesh);
    let is_seen = report
        .deviation
        .is_none_or(|deviation| step > LEAST_STEP * deviation);
    if !is_seen || !report.fallbacks.is_empty() {
        return;
    }
    let rounded = io::stl::as_in_binary(mesh);
    let crossings = rounded.self_intersections().len();
    let merged = coinciding(&rounded.positions).saturating_sub(coinciding(&mesh.positions));
    if crossings > 0 || merged > 0 {
        say!(
            "warning: binary STL rounds these coordinates to steps of up to {step:.1e}: there \
             {merged} vertices fall together with others, and {crossings} pairs of triangles run \
             through each other; move the model to the origin, or write PLY, 3MF or OBJ"
        );
    }
}

/// How many of these points are where another one is.
fn coinciding(points: &[DVec3]) -> usize {
    let mut all: Vec<[u64; 3]> = points
        .iter()
        .map(|p| p.to_array().map(f64::to_bits))
        .collect();
    all.sort_unstable();
    all.dedup();
    points.len() - all.len()
}

/// Gives bodies that are the same in the solid the same triangles, if these are those of its boundary.
fn share_triangles(
    product: &mut Product,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    let (Some(program), Some(report)) = (&product.program, &mut product.report) else {
        return Ok(());
    };
    if report.deviation.is_none() || report.moved.is_some() {
        return Ok(());
    }
    let brep = program.boundary(&options.mesher.boundary(progress))?;
    if io::share_triangles(&mut product.mesh, &brep) > 0 {
        report.check = product.mesh.check();
    }
    Ok(())
}

/// One slab of the mesh.
fn write_shard(
    subject: Reader<'_>,
    shard: Shard,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    let usage = |context: &str, cause: String| Failure::new(exit_codes::USAGE, context, cause);
    if let Some(other) = options.outputs.iter().find(|path| !is_shard(path)) {
        let cause = format!(
            "{} is not a .shard: give --output names like part-1.shard",
            other.display()
        );
        return Err(usage("no such output of a shard", cause));
    }
    let number = |number: usize| {
        let number = u32::try_from(number).map_err(|_| "there cannot be so many".to_owned());
        number.map_err(|cause| usage("no such shard", cause))
    };
    let (part, of) = (number(shard.part - 1)?, number(shard.of)?);
    if options.mesher.cells.is_none() && options.mesher.cell_size.is_none() {
        let cause = "a shard is a slab of a mesh by cells: give --cells or --cell-size, the same \
                     for all shards";
        return Err(usage("a shard without cells", cause.to_owned()));
    }
    output::check_folders(options.outputs.iter().map(PathBuf::as_path))?;
    progress.stage("reading");
    let Subject::Solid(solid, own) = subject()? else {
        let cause = "the input is a mesh, of which no other one is made".to_owned();
        return Err(usage("a shard of a mesh", cause));
    };
    let program = Program::lower(&solid)?;
    progress.stage("meshing");
    let mesher = options
        .mesher
        .mesher()
        .unit(own.unwrap_or(options.mesher.unit).length_unit())
        .limits(options.mesher.limits.limits())
        .progress(progress.callback());
    let slab = mesher.slab(&program, part, of)?;
    progress.stage("writing");
    for path in &options.outputs {
        write_shard_file(path, &slab)
            .map_err(|error| Failure::output(&path.display().to_string(), error))?;
    }
    progress.end();
    progress.say(format_args!(
        "shard {} of {}: {} vertices, {} triangles",
        shard.part,
        shard.of,
        slab.positions.len(),
        slab.triangles.len()
    ));
    for path in &options.outputs {
        progress.say(format_args!("wrote {}", path.display()));
    }
    Ok(())
}

/// STEP files alone: no mesh is needed for them.
fn write_exact(
    solid: &Solid,
    unit: Unit,
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    progress.stage("boundary");
    let program = &Program::lower(solid)?;
    let boundary = options.mesher.boundary(progress).cut_at_seams();
    // Measures take longer than all else: none are made that nobody is told.
    let (account, brep) = if options.json.is_some() || !progress.is_quiet() {
        let (account, brep) = ExactAccount::of((solid, program), &boundary, unit)?;
        (Some(account), brep)
    } else {
        (None, program.boundary(&boundary)?)
    };
    if brep.is_empty() {
        say!("{}", Nothing::of(solid));
    }
    progress.stage("writing");
    for path in &options.outputs {
        output::write_step(path, &brep, unit.length_unit(), options.step)?;
    }
    progress.end();
    account.map_or(Ok(()), |account| tell(&account, options, progress))
}

/// Says what was written.
fn tell(
    account: &(impl Serialize + ToString),
    options: &Options,
    progress: &Progress,
) -> Result<(), Failure> {
    if let Some(path) = &options.json {
        output::write_json(path, account)?;
    }
    progress.say(account.to_string().trim_end());
    for path in options.outputs.iter().filter(|path| !is_stream(path)) {
        progress.say(format_args!("wrote {}", path.display()));
    }
    Ok(())
}
