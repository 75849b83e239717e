//! How much faster is a mesh on several threads, and how much faster could it
//! be on this machine?
//!
//! Cores that share arithmetic units, or a clock, do not do twice the work of
//! one. So every round takes turns: the mesh on one thread and on several, and
//! as reference a loop that touches no memory, likewise. What is left of the
//! mesher's gain after dividing by the loop's is its own doing: memory, waiting,
//! and what only one thread does. A turn is many passes, the first of which,
//! with threads just woken up, does not count.

use std::hint::black_box;
use std::time::Instant;

use csg::{Mesher, Program};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::scenes::{self, NAMES};

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to mesh
    #[arg(default_values = ["S1", "S2", "S3", "S8", "S4-3", "S5-1000"])]
    scenes: Vec<String>,
    /// Cells along the scene's cube
    #[arg(long, default_value_t = 256)]
    cells: u32,
    /// How many threads are compared with one
    #[arg(long, default_value_t = 2)]
    threads: usize,
    /// Seconds to fill with rounds for each scene
    #[arg(long, default_value_t = 3.0)]
    fill: f64,
}

/// Prints a line of medians for each scene.
pub fn run(options: &Options) {
    println!(
        "| scene | cells | 1 thread ms | {0} threads ms | mesh: times faster | loop: times faster | mesh / loop |",
        options.threads
    );
    println!("|{}", " --- |".repeat(7));
    let pools = Pools {
        one: pool(1),
        several: pool(options.threads),
    };
    for name in &options.scenes {
        let Some(scene) = scenes::scene(name) else {
            eprintln!("no scene {name}: try one of {}", NAMES.join(", "));
            continue;
        };
        let program = Program::lower(&scene.solid).expect("a valid scene");
        let cell = 2.0 * scene.half / f64::from(options.cells);
        let mesher = Mesher::new().cell_size(cell).check(false);
        let mesh = || drop(black_box(mesher.mesh(&program).expect("a bounded scene")));
        // A loop that takes about as long.
        let (expected, _) = pools.times(mesh, mesh);
        let (once, _) = pools.times(|| spin(SPINS), || spin_together(SPINS));
        let spins = (f64::from(SPINS) * expected / once) as u32;
        let mut rounds = Vec::new();
        let begun = Instant::now();
        while rounds.len() < 5 || begun.elapsed().as_secs_f64() < options.fill {
            let meshed = pools.times(mesh, mesh);
            let looped = pools.times(|| spin(spins), || spin_together(spins));
            rounds.push((meshed, looped));
        }
        let median_of = |value: fn(&Round) -> f64| median(rounds.iter().map(value).collect());
        let mesh_gain = median_of(|(mesh, _)| mesh.0 / mesh.1);
        let loop_gain = median_of(|(_, spin)| spin.0 / spin.1);
        println!(
            "| {name} | {} | {:.2} | {:.2} | {mesh_gain:.2} | {loop_gain:.2} | {:.2} |",
            options.cells,
            1e3 * median_of(|(mesh, _)| mesh.0),
            1e3 * median_of(|(mesh, _)| mesh.1),
            mesh_gain / loop_gain,
        );
    }
}

/// Seconds on one thread and on several: of the mesh, and of the loop.
type Round = ((f64, f64), (f64, f64));

struct Pools {
    one: ThreadPool,
    several: ThreadPool,
}

fn pool(threads: usize) -> ThreadPool {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("the system starts threads")
}

impl Pools {
    /// Seconds that one thing takes on one thread, and another on several.
    fn times(&self, on_one: impl Fn() + Sync, on_several: impl Fn() + Sync) -> (f64, f64) {
        let one = self.one.install(|| turn(&on_one));
        (one, self.several.install(|| turn(&on_several)))
    }
}

/// Seconds for a pass, on the average of a turn.
fn turn(pass: impl Fn()) -> f64 {
    const SECONDS: f64 = 0.05;
    pass();
    let start = Instant::now();
    let mut passes = 0;
    loop {
        pass();
        passes += 1;
        let spent = start.elapsed().as_secs_f64();
        if spent >= SECONDS {
            return spent / f64::from(passes);
        }
    }
}

/// What the loop's speed is found with.
const SPINS: u32 = 100_000;

/// So many rounds of multiplications and additions in registers.
fn spin(rounds: u32) {
    let mut sums = [0.0_f64; 16];
    let factor = black_box(0.999);
    for _ in 0..rounds {
        for sum in &mut sums {
            *sum = *sum * factor + 1.0;
        }
    }
    black_box(sums);
}

/// The same by all threads of the pool, in small pieces.
fn spin_together(rounds: u32) {
    const PIECES: u32 = 64;
    let piece = |_| spin(rounds / PIECES);
    (0..PIECES).into_par_iter().with_max_len(1).for_each(piece);
}

/// The value in the middle; there must be some.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
