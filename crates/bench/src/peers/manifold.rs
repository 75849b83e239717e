//! manifold3d, in Python: polyhedral solids of so many segments a circle.

use std::fs;
use std::path::Path;
use std::process::Command;

use csg::Mesh;
use glam::DVec3;

/// Numbers of segments of a circle.
const SEGMENTS: [u32; 7] = [16, 32, 64, 128, 256, 512, 1024];

/// A mesh it made, and how long that took it.
pub struct Made {
    /// Segments of a circle.
    pub segments: u32,
    /// Its own time, without Python's start or the copy of the mesh.
    pub seconds: f64,
    /// As a mesh of ours.
    pub mesh: Mesh,
}

/// All meshes of a scene; none if it does not know the scene or Python does
/// not run, which is said. `python` has the manifold3d and numpy packages.
pub fn meshes(python: &Path, scene: &str) -> Vec<Made> {
    let folder = std::env::temp_dir().join(format!("bench-manifold-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder for temporary files");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/peers/manifold.py");
    let output = Command::new(python)
        .arg(script)
        .arg(scene)
        .arg(&folder)
        .args(SEGMENTS.map(|n| n.to_string()))
        .output();
    let made = match output {
        Err(error) => {
            eprintln!("{} does not run: {error}", python.display());
            Vec::new()
        }
        Ok(output) => {
            if !output.status.success() {
                eprintln!("{}", String::from_utf8_lossy(&output.stderr));
            }
            let lines = String::from_utf8_lossy(&output.stdout).into_owned();
            lines.lines().map(|line| read(&folder, line)).collect()
        }
    };
    // A leftover does no harm.
    let _ = fs::remove_dir_all(&folder);
    made
}

fn read(folder: &Path, line: &str) -> Made {
    let answer: serde_json::Value = serde_json::from_str(line).expect("a line of JSON");
    let segments = answer["n"].as_u64().expect("a number") as u32;
    let file = |kind: &str| fs::read(folder.join(format!("{segments}.{kind}"))).expect("a file");
    let positions: Vec<f64> = file("positions")
        .as_chunks()
        .0
        .iter()
        .map(|&bytes| f64::from_le_bytes(bytes))
        .collect();
    let triangles: Vec<u32> = file("triangles")
        .as_chunks()
        .0
        .iter()
        .map(|&bytes| u32::from_le_bytes(bytes))
        .collect();
    let positions = positions.as_chunks().0.iter();
    Made {
        segments,
        seconds: answer["seconds"].as_f64().expect("a number"),
        mesh: Mesh::new(
            positions.map(|&p| DVec3::from_array(p)).collect(),
            triangles.as_chunks().0.to_vec(),
        ),
    }
}
