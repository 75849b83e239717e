//! How fast and how right is a mesh at a fixed number of cells a side?
//!
//! Times leave out what is done once for a model: lowering the solid here,
//! building and compiling the field there. The final check of our mesh is
//! left out as well, since no peer checks.

use csg::{Mesher, Program};

use crate::measure::{Quality, quality};
use crate::peers::fidget::{self, Evaluator, Run};
use crate::peers::surface_nets;
use crate::scenes::{self, Scene};
use crate::timing::{Passes, Times, on_threads};

/// The JIT compiles a new function for many boxes; the interpreter shortens
/// its tape and wins from about 1,000 operands on. Beyond this many the JIT
/// is left out unless asked for, since it takes minutes.
const JIT_LEAVES: usize = 4000;

/// More leaves than a dense grid can be sampled with in reasonable time.
const DENSE_LEAVES: usize = 200;

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to mesh; the reference table if none is named
    scenes: Vec<String>,
    /// Cells along the scene's cube, a power of two
    #[arg(long)]
    cells: Option<u32>,
    /// Numbers of threads
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    threads: Vec<usize>,
    /// Run both evaluators of fidget whatever they cost
    #[arg(long)]
    all_evaluators: bool,
    /// Leave the peers out
    #[arg(long)]
    alone: bool,
    /// Do not measure meshes, only time them
    #[arg(long)]
    no_measure: bool,
    /// Seconds to fill with passes of each measurement
    #[arg(long, default_value_t = 0.5)]
    fill: f64,
    /// Seconds after which no further pass starts
    #[arg(long, default_value_t = 10.0)]
    most: f64,
}

/// Prints the table.
pub fn run(options: &Options) {
    let table = [
        "S1",
        "S2",
        "S3",
        "S8",
        "S4-3",
        "S4-4",
        "S5-1000",
        "S5-10000",
        "S5-100000",
        "S6",
        "S7-1e-2",
    ];
    let names: Vec<&str> = if options.scenes.is_empty() {
        table.to_vec()
    } else {
        options.scenes.iter().map(String::as_str).collect()
    };
    println!(
        "| scene | cells | threads | program | prepare s | mesh s | times ours | CPU s | times ours | triangles | \
         volume error | chord | vertices off | folds | bad edges | manifold | genus |"
    );
    println!("|{}", " --- |".repeat(17));
    for name in names {
        let Some(scene) = scenes::scene(name) else {
            eprintln!("no scene {name}: try one of {}", scenes::NAMES.join(", "));
            continue;
        };
        let usual = if name.starts_with("S7") { 512 } else { 256 };
        let cells = options.cells.unwrap_or(usual);
        for (i, &threads) in options.threads.iter().enumerate() {
            let measure = i == 0 && !options.no_measure;
            one(&scene, cells, threads, measure, options);
        }
    }
}

fn one(scene: &Scene, cells: u32, threads: usize, measure: bool, options: &Options) {
    let passes = Passes::within(options.fill, options.most);
    let cell = 2.0 * scene.half / f64::from(cells);
    let lower = || Program::lower(&scene.solid).expect("a valid scene");
    let (lowering, program) = passes.best(lower);
    let row = |name: &str, prepare: f64, time: Times, ours: Times, quality: Option<Quality>| {
        print!(
            "| {} | {cells} | {threads} | {name} | {prepare:.1e} | {:.4} | {:.1} | {:.4} | {:.1} |",
            scene.name,
            time.wall,
            time.wall / ours.wall,
            time.cpu,
            time.cpu / ours.cpu,
        );
        let columns = quality.as_ref().map(columns);
        println!("{}", columns.unwrap_or_else(|| " |".repeat(8)));
    };
    let measured = |mesh: &csg::Mesh| measure.then(|| quality(scene, &program, mesh, cell));

    let mesher = Mesher::new().cell_size(cell).check(false);
    let (ours, meshed) = on_threads(threads, || {
        passes.best(|| mesher.mesh(&program).expect("a bounded scene"))
    });
    row("ours", lowering.wall, ours, ours, measured(&meshed.mesh));
    for fallback in meshed.report.fallbacks.iter().filter(|_| measure) {
        eprintln!("{}: {fallback}", scene.name);
    }
    drop(meshed);
    if options.alone {
        return;
    }

    for evaluator in Evaluator::ALL {
        let many = scene.field.leaves() > JIT_LEAVES;
        if evaluator == Evaluator::Jit && many && !options.all_evaluators {
            continue;
        }
        let run = Run {
            evaluator,
            depth: cells.ilog2() as u8,
            half: scene.half,
            threads,
        };
        let start = std::time::Instant::now();
        let (prepare, (time, raw)) = fidget::with_mesher(&scene.field, run, |mesh| {
            (start.elapsed().as_secs_f64(), passes.best(mesh))
        });
        let name = format!("fidget {}", evaluator.name());
        row(&name, prepare, time, ours, measured(&raw.into_mesh()));
    }

    if threads == 1 && scene.field.leaves() <= DENSE_LEAVES {
        let (time, raw) = passes.best(|| surface_nets::mesh(&scene.field, cells, scene.half));
        let quality = measured(&raw.into_mesh());
        row("fast-surface-nets", 0.0, time, ours, quality);
    }
}

fn columns(quality: &Quality) -> String {
    let Quality {
        triangles,
        volume_error,
        chord,
        vertex_distance,
        folds,
        bad_edges,
        manifold,
        genus,
    } = quality;
    let manifold = if *manifold { "yes" } else { "no" };
    let genus = genus.map_or("–".to_owned(), |genus| genus.to_string());
    format!(
        " {triangles} | {volume_error:.1e} | {chord:.1e} | {vertex_distance:.1e} | {folds} | \
         {bad_edges} | {manifold} | {genus} |"
    )
}
