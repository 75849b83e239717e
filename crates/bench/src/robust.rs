//! Is every mesh manifold, resolved or not, wherever and however large the
//! solid is?

use std::sync::atomic::{AtomicUsize, Ordering};

use csg::{Mesher, Program};
use rayon::prelude::*;

use crate::defects::{largest_miss, size};
use crate::poses::{Pose, pose};
use crate::random_tree::{Position, random_tree};
use crate::scenes;

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
}

/// Prints every failure, with what it takes to repeat it, and a summary.
pub fn run(options: &Options) {
    let tally = Tally::default();
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
            let position = if options.general {
                Position::General
            } else {
                Position::Special
            };
            let program = Program::lower(&random_tree(seed, position)).expect("a valid tree");
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
                is_promised: options.tolerance.is_some(),
            };
            tally.add(&case, &mesher);
        });
    println!(
        "{} meshes: {} not manifold, {} errors, {} of the wrong genus, {} with vertices off \
         their surfaces; {} through themselves where none should be; {} with fallbacks",
        tally.meshes.into_inner(),
        tally.defective.into_inner(),
        tally.errors.into_inner(),
        tally.wrong_genus.into_inner(),
        tally.off.into_inner(),
        tally.crossed.into_inner(),
        tally.with_fallbacks.into_inner(),
    );
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
                is_promised: false,
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

/// One mesh to make, and what to expect of it.
struct Case<'a> {
    what: String,
    program: &'a Program,
    genus: Option<i64>,
    /// How far vertices may be off besides 1e-12 of the mesh's diagonal.
    rounding: f64,
    /// Whether there should be nothing to report.
    is_promised: bool,
}

#[derive(Default)]
struct Tally {
    meshes: AtomicUsize,
    defective: AtomicUsize,
    errors: AtomicUsize,
    wrong_genus: AtomicUsize,
    off: AtomicUsize,
    crossed: AtomicUsize,
    with_fallbacks: AtomicUsize,
}

impl Tally {
    fn failures(&self) -> usize {
        [&self.defective, &self.errors, &self.wrong_genus, &self.off]
            .map(|counter| counter.load(Ordering::Relaxed))
            .iter()
            .sum()
    }

    fn add(&self, case: &Case<'_>, mesher: &Mesher) {
        let what = &case.what;
        let count = |counter: &AtomicUsize| counter.fetch_add(1, Ordering::Relaxed);
        count(&self.meshes);
        let meshed = match mesher.mesh(case.program) {
            Ok(meshed) => meshed,
            Err(error) => {
                count(&self.errors);
                println!("{what}: {error}");
                return;
            }
        };
        let check = &meshed.report.check;
        if !check.is_manifold() {
            count(&self.defective);
            println!("{what}: {check}");
        } else if case.genus.is_some() && check.genus() != case.genus {
            count(&self.wrong_genus);
            println!("{what}: genus {:?} for {:?}", check.genus(), case.genus);
        }
        let fallbacks = &meshed.report.fallbacks;
        if !fallbacks.is_empty() {
            count(&self.with_fallbacks);
        }
        if case.is_promised {
            for fallback in fallbacks {
                println!("{what}: {fallback}");
            }
            let crossings = meshed.mesh.self_intersections().len();
            if crossings > 0 {
                count(&self.crossed);
                println!("{what}: {crossings} places where it runs through itself");
            }
        }
        // A vertex whose surfaces have no common point cannot be on them all.
        if !fallbacks.iter().any(|f| f.kind.contains("common point")) {
            let miss = largest_miss(case.program, &meshed.mesh);
            let allowed = 1e-12 * size(&meshed.mesh) + case.rounding;
            if miss > allowed {
                count(&self.off);
                println!("{what}: vertices off by {miss:e}, allowed {allowed:e}");
            }
        }
    }
}
