//! How much memory does one mesh take?

use csg::{Mesher, Program};

use crate::scenes;

#[derive(clap::Args)]
pub struct Options {
    /// The scene to mesh
    #[arg(default_value = "S2")]
    scene: String,
    /// Cells along the scene's cube
    #[arg(long, default_value_t = 1024)]
    cells: u32,
    /// Check the mesh as well, as a user's run does
    #[arg(long)]
    check: bool,
}

/// Prints the process's largest resident set before and after meshing: run it
/// alone, nothing is ever taken off it.
pub fn run(options: &Options) {
    let Some(scene) = scenes::scene(&options.scene) else {
        eprintln!("no scene {}", options.scene);
        return;
    };
    let program = Program::lower(&scene.solid).expect("a valid scene");
    let cell = 2.0 * scene.half / f64::from(options.cells);
    let before = peak_megabytes();
    let mesher = Mesher::new().cell_size(cell).check(options.check);
    let meshed = mesher.mesh(&program).expect("a bounded scene");
    let after = peak_megabytes();
    let mesh = &meshed.mesh;
    let own = size_of_val(&*mesh.positions)
        + size_of_val(&*mesh.triangles)
        + size_of_val(&*mesh.triangle_surfaces)
        + size_of_val(&*mesh.corner_normals);
    println!(
        "{} at {} cells: {} triangles, {} vertices, the mesh itself {:.0} MB; \
         peak {after:.0} MB, {before:.0} MB of it before meshing",
        options.scene,
        options.cells,
        mesh.triangles.len(),
        mesh.positions.len(),
        own as f64 / 1e6,
    );
}

/// The largest resident set so far, where the system tells it (Linux).
fn peak_megabytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB"));
    let kilobytes = kilobytes.and_then(|number| number.trim().parse::<f64>().ok());
    kilobytes.map_or(f64::NAN, |number| number * 1024.0 / 1e6)
}
