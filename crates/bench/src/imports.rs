//! How long does it take to read a mesh of many triangles as a solid, and to cut two with each
//! other?

use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use csg::{Mesh, Mesher, Program, Solid};
use glam::DVec3;

use crate::timing::Passes;

#[derive(clap::Args)]
pub struct Options {
    /// Thousands of triangles of each mesh
    #[arg(default_values_t = [21, 82, 336, 1300])]
    thousands: Vec<u32>,
    /// A Python that has manifold3d and numpy: by default that of the tests
    #[arg(long, default_value = "target/tmp/manifold3d/venv/bin/python")]
    python: PathBuf,
}

/// Prints a line for each size: seconds of wall time, ours and manifold3d's, on all threads.
pub fn run(options: &Options) {
    let folder = std::env::temp_dir().join(format!("imports-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder for temporary files");
    println!(
        "| triangles | import | manifold3d | import and difference | manifold3d | volumes differ by |"
    );
    println!("|{}", " --- |".repeat(6));
    for &thousands in &options.thousands {
        let across = (250.0 * f64::from(thousands)).sqrt() as u32;
        let meshes = [
            torus(across, 0.0, DVec3::ZERO),
            torus(across, 1.0, DVec3::new(0.31, 0.17, 0.11)),
        ];
        let passes = Passes::within(0.0, 10.0);
        let read = |mesh: &Mesh| Solid::from_mesh(mesh).expect("a mesh that bounds a solid");
        let (import, _) = passes.best(|| read(&meshes[0]));
        let (difference, mesh) = passes.best(|| {
            let [a, b] = meshes.each_ref().map(read);
            let program = Program::lower(&(a - b)).expect("a valid solid");
            // Like the other's, without a check afterwards.
            let mesher = Mesher::new().check(false).tolerance(1e-3);
            mesher.mesh(&program)
        });
        let mesh = match mesh {
            Ok(meshed) => meshed.mesh,
            Err(error) => {
                eprintln!("{thousands} thousand triangles: {error}");
                continue;
            }
        };
        let Some(other) = ask(options, &folder, &meshes) else {
            continue;
        };
        let number = |name: &str| other[name].as_f64().unwrap_or(f64::NAN);
        let volume = number("volume");
        println!(
            "| {} | {:.3} | {:.3} | {:.3} | {:.3} | {:.1e} |",
            meshes[0].triangles.len(),
            import.wall,
            number("import"),
            difference.wall,
            number("difference"),
            (mesh.measure().volume - volume).abs() / volume,
        );
    }
    // A leftover does no harm.
    let _ = fs::remove_dir_all(&folder);
}

/// A bumpy torus of twice as many times half as many quadrilaterals, cut in triangles.
fn torus(half: u32, phase: f64, at: DVec3) -> Mesh {
    let (around, across) = (2 * half, half);
    let corner = |i: u32, j: u32| i % around * across + j % across;
    let point = |i: u32, j: u32| {
        let [u, v] = [(i, around), (j, across)].map(|(k, n)| TAU * f64::from(k) / f64::from(n));
        let bump = (9.0 * u + phase).sin() * (5.0 * v + phase).cos();
        let radius = 0.35 * (1.0 + 0.1 * bump);
        let out = 1.0 + radius * v.cos();
        at + DVec3::new(out * u.cos(), out * u.sin(), radius * v.sin())
    };
    let places = || (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let triangles = places().flat_map(|(i, j)| {
        let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(k, l)| corner(i + k, j + l));
        [[a, b, c], [a, c, d]]
    });
    Mesh::new(
        places().map(|(i, j)| point(i, j)).collect(),
        triangles.collect(),
    )
}

/// What manifold3d says; nothing if Python does not run, which is said.
fn ask(options: &Options, folder: &Path, meshes: &[Mesh; 2]) -> Option<serde_json::Value> {
    for (name, mesh) in ["a", "b"].into_iter().zip(meshes) {
        let positions = mesh.positions.iter().flat_map(DVec3::to_array);
        let positions: Vec<u8> = positions.flat_map(f64::to_le_bytes).collect();
        let corners = mesh.triangles.iter().flatten();
        let triangles: Vec<u8> = corners.flat_map(|corner| corner.to_le_bytes()).collect();
        for (kind, bytes) in [("positions", positions), ("triangles", triangles)] {
            fs::write(folder.join(format!("{name}.{kind}")), bytes).expect("a file");
        }
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/peers/imports.py");
    let output = Command::new(&options.python)
        .arg(script)
        .arg(folder)
        .output();
    match output {
        Ok(output) if output.status.success() => serde_json::from_slice(&output.stdout).ok(),
        Ok(output) => {
            eprintln!("{}", String::from_utf8_lossy(&output.stderr));
            None
        }
        Err(error) => {
            eprintln!("{} does not run: {error}", options.python.display());
            None
        }
    }
}
