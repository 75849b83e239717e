//! Is every mesh manifold, resolved or not, wherever and however large the
//! solid is?

use std::sync::atomic::{AtomicUsize, Ordering};

use csg::{Mesher, Program, Solid};
use rayon::prelude::*;

use crate::random_tree::random_tree;
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
    /// How many random trees are meshed
    #[arg(long, default_value_t = 10_000)]
    trees: u64,
    /// The first random tree's seed
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Leave the scenes out
    #[arg(long)]
    trees_only: bool,
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
            let what = format!("random tree {seed} at {cells} cells");
            tally.add(&what, &random_tree(seed), None, &Mesher::new().cells(cells));
        });
    println!(
        "{} meshes: {} not manifold, {} errors, {} of the wrong genus, {} with fallbacks",
        tally.meshes.into_inner(),
        tally.defective.into_inner(),
        tally.errors.into_inner(),
        tally.wrong_genus.into_inner(),
        tally.with_fallbacks.into_inner(),
    );
}

/// Meshes a scene at every grid: at home, rotated, far away, tiny and huge.
fn every_grid(name: &str, options: &Options, tally: &Tally) {
    let Some(scene) = scenes::scene(name) else {
        eprintln!("no scene {name}: try one of {}", scenes::NAMES.join(", "));
        return;
    };
    let home = &scene.solid;
    let places = [
        ("at home", home.clone(), 1.0),
        ("rotated", home.rotate_xyz(0.3, 0.5, 0.7), 1.0),
        ("at 1e6", home.translate([1e6, 1e6, 1e6]), 1.0),
        ("times 1e-6", home.scale(1e-6), 1e-6),
        ("times 1e6", home.scale(1e6), 1e6),
    ];
    // Only grids with two cells across the smallest feature must get the genus right.
    let resolving = smallest_feature(name).map_or(u32::MAX, |feature| {
        (2.0 * 2.0 * scene.half / feature).ceil() as u32 + 1
    });
    for (place, solid, scale) in &places {
        let before = tally.defective.load(Ordering::Relaxed);
        let grids: Vec<u32> = (options.from..=options.to)
            .step_by(options.skip as usize + 1)
            .collect();
        grids.par_iter().for_each(|&cells| {
            let what = format!("{name} {place} at {cells} cells");
            let genus = scene.genus.filter(|_| cells >= resolving);
            let cell = 2.0 * scene.half * scale / f64::from(cells);
            tally.add(&what, solid, genus, &Mesher::new().cell_size(cell));
        });
        let defective = tally.defective.load(Ordering::Relaxed) - before;
        println!(
            "{name} {place}: {} grids, {defective} not manifold",
            grids.len()
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

#[derive(Default)]
struct Tally {
    meshes: AtomicUsize,
    defective: AtomicUsize,
    errors: AtomicUsize,
    wrong_genus: AtomicUsize,
    with_fallbacks: AtomicUsize,
}

impl Tally {
    fn add(&self, what: &str, solid: &Solid, genus: Option<i64>, mesher: &Mesher) {
        let count = |counter: &AtomicUsize| counter.fetch_add(1, Ordering::Relaxed);
        count(&self.meshes);
        let meshed = Program::lower(solid).and_then(|program| mesher.mesh(&program));
        match meshed {
            Err(error) => {
                count(&self.errors);
                println!("{what}: {error}");
            }
            Ok(meshed) => {
                let check = &meshed.report.check;
                if !check.is_manifold() {
                    count(&self.defective);
                    println!("{what}: {check}");
                } else if genus.is_some() && check.genus() != genus {
                    count(&self.wrong_genus);
                    println!("{what}: genus {:?} for {genus:?}", check.genus());
                }
                if !meshed.report.fallbacks.is_empty() {
                    count(&self.with_fallbacks);
                }
            }
        }
    }
}
