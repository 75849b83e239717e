//! What does a surface cell cost, and where does the time go?

use csg::{Mesher, Program};

use crate::scenes::{self, NAMES};
use crate::timing::{Passes, on_threads};

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to mesh
    #[arg(default_values = ["S2", "S4-4"])]
    scenes: Vec<String>,
    /// Cells along the scene's cube
    #[arg(long, value_delimiter = ',', default_value = "64,128,256,512,1024")]
    cells: Vec<u32>,
    /// How many threads
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Seconds to fill with passes of each measurement
    #[arg(long, default_value_t = 0.5)]
    fill: f64,
}

/// Prints one line for each scene and number of cells.
pub fn run(options: &Options) {
    println!(
        "| scene | cells | surface cells | triangles | ms | CPU ms | ns a cell | stages in ms |"
    );
    println!("|{}", " --- |".repeat(8));
    for name in &options.scenes {
        let Some(scene) = scenes::scene(name) else {
            eprintln!("no scene {name}: try one of {}", NAMES.join(", "));
            continue;
        };
        let program = Program::lower(&scene.solid).expect("a valid scene");
        for &cells in &options.cells {
            let cell = 2.0 * scene.half / f64::from(cells);
            let mesher = Mesher::new().cell_size(cell).check(false);
            let passes = Passes::within(options.fill, 10.0);
            let (time, meshed) = on_threads(options.threads, || {
                passes.best(|| mesher.mesh(&program).expect("a bounded scene"))
            });
            let report = meshed.report;
            let stages: Vec<String> = report
                .stages
                .iter()
                .map(|(stage, seconds)| format!("{stage} {:.2}", seconds * 1e3))
                .collect();
            println!(
                "| {name} | {cells} | {} | {} | {:.2} | {:.2} | {:.1} | {} |",
                report.surface_cells,
                meshed.mesh.triangles.len(),
                time.wall * 1e3,
                time.cpu * 1e3,
                time.wall * 1e9 / report.surface_cells as f64,
                stages.join(", "),
            );
        }
    }
}
