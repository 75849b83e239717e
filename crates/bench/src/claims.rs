//! Does a mesh keep what the mesher promises: vertices on their surfaces, no
//! folds, the right kind, the right volume?

use csg::{Mesh, Meshed, Mesher, Program};
use glam::DVec3;

use crate::defects;
use crate::poses::{Pose, pose};
use crate::scenes::{self, NAMES, Scene};

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to mesh
    #[arg(default_values = ["S1", "S2", "S3", "S4-3", "S5-1000", "S6", "S7-1e-2", "S8"])]
    scenes: Vec<String>,
    /// Cells along the scene's cube
    #[arg(long, value_delimiter = ',', default_value = "64,128,256,512")]
    cells: Vec<u32>,
    /// Where the scenes are put: home, turned, far, tiny or huge
    #[arg(long, value_delimiter = ',', value_parser = pose, default_value = "home,turned")]
    poses: Vec<Pose>,
    /// Print the first place of every fallback and defect
    #[arg(long)]
    places: bool,
}

/// Prints one line for each scene, pose and number of cells.
pub fn run(options: &Options) {
    println!(
        "| scene | pose | cells | triangles | fallbacks | folds | no area | duplicates | \
         vertices off | corners off | parts | genus | volume error |"
    );
    println!("|{}", " --- |".repeat(13));
    for name in &options.scenes {
        let Some(scene) = scenes::scene(name) else {
            eprintln!("no scene {name}: try one of {}", NAMES.join(", "));
            continue;
        };
        for pose in &options.poses {
            for &cells in &options.cells {
                line(&scene, *pose, cells, options.places);
            }
        }
    }
}

fn line(scene: &Scene, pose: Pose, cells: u32, places: bool) {
    let program = Program::lower(&pose.of(&scene.solid)).expect("a valid scene");
    let cell = 2.0 * scene.half * pose.scale / f64::from(cells);
    let mesher = Mesher::new().cell_size(cell);
    let Meshed { mesh, report, .. } = mesher.mesh(&program).expect("a bounded scene");
    let found = defects::measure(&program, &mesh);
    let fallbacks: Vec<String> = report
        .fallbacks
        .iter()
        .map(|fallback| format!("{} {}", fallback.count, short(fallback.kind)))
        .collect();
    let corners = corners_off(&scene.name, pose, &mesh);
    println!(
        "| {} | {} | {cells} | {} | {} | {} | {} | {} | {:.1e} | {} | {} | {} | {:.1e} |",
        scene.name,
        pose.name,
        mesh.triangles.len(),
        fallbacks.join(", "),
        found.folded,
        found.without_area,
        found.duplicates,
        found.miss,
        corners.map_or(String::new(), |off| format!("{off:.1e}")),
        report.check.components,
        report
            .check
            .genus()
            .map_or("none".into(), |g| g.to_string()),
        mesh.volume() / pose.scale.powi(3) / scene.volume - 1.0,
    );
    if places {
        for fallback in &report.fallbacks {
            for place in &fallback.places {
                println!("    {} at {place}", short(fallback.kind));
            }
        }
        for (what, place) in &found.places {
            println!("    {what} at {place}");
        }
    }
}

/// A fallback's kind in a word or two.
fn short(kind: &str) -> &str {
    let known = [
        ("common point", "no common point"),
        ("feature", "hidden"),
        ("several times", "several"),
        ("no sample saw", "unseen"),
        ("without area", "degenerate"),
    ];
    let found = known.iter().find(|(part, _)| kind.contains(part));
    found.map_or(kind, |(_, short)| short)
}

/// How far the rotated box's farthest corner is from the nearest vertex.
fn corners_off(scene: &str, pose: Pose, mesh: &Mesh) -> Option<f64> {
    let turn = glam::DMat3::from_rotation_z(0.3)
        * glam::DMat3::from_rotation_y(0.5)
        * glam::DMat3::from_rotation_x(0.7);
    let half = DVec3::new(1.0, 0.6, 0.3);
    let off = (0..8).map(|corner: u32| {
        let sign = |bit: u32| f64::from(corner >> bit & 1) * 2.0 - 1.0;
        let signs = DVec3::new(sign(0), sign(1), sign(2));
        let at = pose.at(turn * (half * signs));
        let distances = mesh.positions.iter().map(|p| p.distance(at));
        distances.fold(f64::INFINITY, f64::min)
    });
    (scene == "S6").then(|| off.fold(0.0, f64::max) / pose.scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::poses::POSES;

    /// The poses of the command line's defaults exist.
    #[test]
    fn poses_have_names() {
        for known in POSES {
            assert_eq!(pose(known.name).map(|p| p.name), Ok(known.name));
        }
    }
}
