//! Is every mesh manifold, resolved or not, wherever and however large the
//! solid is?

mod classes;
mod features;
mod table;
mod trial;

use std::path::PathBuf;
use std::time::Duration;

use csg::{Mesher, Program};
use rayon::prelude::*;

use self::classes::Class;
use self::table::Trials;
use crate::poses::{Pose, pose};
use crate::random_tree::{Position, random_tree};
use crate::scenes;
use crate::tally::{Case, Judge, Promise, Tally};

/// To which solids are meshed that are judged one by one.
const TOLERANCE: f64 = 0.01;

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to mesh
    #[arg(default_values = ["S1", "S2", "S3", "S4-3", "S5-1000", "S6", "S7-1e-2", "S8"])]
    scenes: Vec<String>,
    /// The least number of cells along the scene's cube
    #[arg(long, default_value_t = 32)]
    from: u32,
    /// The greatest
    #[arg(long, default_value_t = 512)]
    to: u32,
    /// How many of the numbers of cells are left out after each
    #[arg(long, default_value_t = 0)]
    skip: u32,
    /// Where the scenes are put: home, turned, far, tiny or huge
    #[arg(long, value_delimiter = ',', value_parser = pose, default_value = "home,turned,far,tiny,huge")]
    poses: Vec<Pose>,
    /// How many random trees are meshed
    #[arg(long, default_value_t = 10_000)]
    trees: u64,
    /// The first random tree's seed
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Leave the scenes out
    #[arg(long)]
    trees_only: bool,
    /// Mesh the trees to this tolerance, not on grids: then whatever there is to
    /// report is a failure
    #[arg(long)]
    tolerance: Option<f64>,
    /// Trees in general position: no faces that coincide or touch
    #[arg(long)]
    general: bool,
    /// Trees as people put them together: few primitives, at round places and angles
    #[arg(long, conflicts_with = "general")]
    aligned: bool,
    /// Ask manifold3d whether it takes the meshes, and about the trees' volumes:
    /// a Python that has it and numpy
    #[arg(long)]
    python: Option<PathBuf>,
    /// Trees of these classes alone, each meshed to the tolerance (0.01 unless given) and
    /// judged in a process of its own; prints a table
    #[arg(long, value_enum, value_delimiter = ',', conflicts_with_all = ["general", "aligned", "python"])]
    class: Vec<Class>,
    /// With classes: seconds after which a process is ended
    #[arg(long, default_value_t = 30.0)]
    limit: f64,
    /// With classes: a folder for the trees that fail or whose surfaces are moved, as scene files
    #[arg(long)]
    write: Option<PathBuf>,
    /// Judge these scene files alone, each meshed to the tolerance (0.01 unless given)
    #[arg(long, num_args = 1.., conflicts_with_all = ["class", "general", "aligned", "python"])]
    judge: Vec<PathBuf>,
    /// Be the process that meshes and judges one tree
    #[arg(long, hide = true, requires = "class")]
    alone: bool,
}

/// Prints every failure, with what it takes to repeat it, and a summary.
pub fn run(options: &Options) {
    /// Of circles, where manifold3d tells the volume of a tree.
    const SEGMENTS: u32 = 32;
    if !options.class.is_empty() {
        return by_classes(options);
    }
    if !options.judge.is_empty() {
        let tolerance = options.tolerance.unwrap_or(TOLERANCE);
        return trial::files(&options.judge, options.seed, tolerance);
    }
    let tally = Tally::new(options.python.as_deref().map(Judge::start));
    if !options.trees_only {
        for name in &options.scenes {
            every_grid(name, options, &tally);
        }
    }
    (options.seed..options.seed + options.trees)
        .into_par_iter()
        .for_each(|seed| {
            // Grids from hopeless to well resolved.
            let cells = [7, 16, 29, 48][(seed % 4) as usize];
            let position = match (options.general, options.aligned) {
                (true, _) => Position::General,
                (_, true) => Position::Aligned,
                _ => Position::Special,
            };
            let solid = random_tree(seed, position);
            let program = Program::lower(&solid).expect("a valid tree");
            let (how, mesher) = match options.tolerance {
                Some(tolerance) => (
                    format!("to {tolerance}"),
                    Mesher::new().tolerance(tolerance),
                ),
                None => (format!("at {cells} cells"), Mesher::new().cells(cells)),
            };
            let case = Case {
                what: format!("random tree {seed} {how}"),
                program: &program,
                genus: None,
                rounding: 0.0,
                promise: match options.tolerance {
                    Some(_) => Promise::Kept,
                    None => Promise::Manifold,
                },
                volume: tally
                    .judge()
                    .filter(|_| options.tolerance.is_some())
                    .map(|judge| judge.volume(&solid, SEGMENTS)),
                distance: options.tolerance.unwrap_or_default(),
            };
            tally.add(&case, &mesher);
        });
    tally.print();
}

/// Judges trees of classes.
fn by_classes(options: &Options) {
    let tolerance = options.tolerance.unwrap_or(TOLERANCE);
    if options.alone {
        return trial::alone(options.class[0], options.seed, tolerance);
    }
    table::run(&Trials {
        classes: options.class.clone(),
        seed: options.seed,
        count: options.trees,
        tolerance,
        limit: Duration::from_secs_f64(options.limit.clamp(0.0, 1e6)),
        write: options.write.clone(),
    });
}

/// Meshes a scene at every grid in the poses asked for.
fn every_grid(name: &str, options: &Options, tally: &Tally) {
    let Some(scene) = scenes::scene(name) else {
        eprintln!("no scene {name}: try one of {}", scenes::NAMES.join(", "));
        return;
    };
    // Only grids with two cells across the smallest feature must get the genus right.
    let resolving = smallest_feature(name).map_or(u32::MAX, |feature| {
        (2.0 * 2.0 * scene.half / feature).ceil() as u32 + 1
    });
    for pose in &options.poses {
        let program = Program::lower(&pose.of(&scene.solid)).expect("a valid scene");
        let before = tally.failures();
        let grids: Vec<u32> = (options.from..=options.to)
            .step_by(options.skip as usize + 1)
            .collect();
        grids.par_iter().for_each(|&cells| {
            let case = Case {
                what: format!("{name} {} at {cells} cells", pose.name),
                program: &program,
                genus: scene.genus.filter(|_| cells >= resolving),
                rounding: pose.rounding(),
                promise: Promise::Manifold,
                volume: None,
                distance: 0.0,
            };
            let cell = 2.0 * scene.half * pose.scale / f64::from(cells);
            tally.add(&case, &Mesher::new().cell_size(cell));
        });
        println!(
            "{name} {}: {} grids, {} failures",
            pose.name,
            grids.len(),
            tally.failures() - before,
        );
    }
}

/// The least thickness of wall or gap.
fn smallest_feature(name: &str) -> Option<f64> {
    let (kind, argument) = name.split_once('-').unwrap_or((name, ""));
    Some(match kind {
        "S1" | "S3" => 2.0,
        // Three bores of radius 1/2 leave a wall of 1/4 to the cube's faces.
        "S2" => 0.25,
        "S4" => 2.0 / 3_f64.powi(argument.parse().ok()?),
        "S6" => 0.6,
        "S7" => argument.parse().ok()?,
        // Between keyway and hub: 0.45 - 0.38.
        "S8" => 0.07,
        _ => return None,
    })
}
