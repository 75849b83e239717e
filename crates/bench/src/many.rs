//! How long do scenes of many primitives take, beside manifold3d?
//!
//! Both are asked for the same parts at the same places, and to be no farther than a tolerance from
//! them: manifold3d by as many segments of each circle as keep its chords so near, by its radius.
//! (Its spheres are up to three times as far off then, which is to its favour.) Times are of wall
//! clock on all threads, from the list of parts to the mesh.

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use csg::{Mesher, Program, Solid};
use glam::DVec3;
use serde_json::{Value, json};
use stereotomy::scenes;

use crate::field::Field;
use crate::scenes::balls_of;
use crate::timing::Passes;

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to measure; all unless given
    scenes: Vec<String>,
    /// A Python that has manifold3d: by default that of the tests
    #[arg(long, default_value = "target/tmp/manifold3d/venv/bin/python")]
    python: PathBuf,
    /// Seconds after which manifold3d is not waited for
    #[arg(long, default_value_t = 300)]
    patience: u32,
}

/// A primitive of a scene.
#[derive(Clone, Copy)]
enum Part {
    Ball {
        center: DVec3,
        radius: f64,
    },
    /// A ball less a smaller one with the same centre.
    Shell {
        outer: f64,
        inner: f64,
    },
    /// A cylinder along an axis, from `start` on.
    Rod {
        axis: usize,
        start: DVec3,
        length: f64,
        radius: f64,
    },
    Block {
        low: DVec3,
        size: DVec3,
    },
}

/// Parts united, or taken from the first of them.
struct Scene {
    name: &'static str,
    tolerance: f64,
    is_difference: bool,
    parts: Vec<Part>,
}

/// Prints a line for each scene.
pub fn run(options: &Options) {
    println!(
        "| scene | parts | tolerance | checked | not checked | triangles | manifold3d | triangles | times as long | volume, of manifold3d's |"
    );
    println!("|{}", " --- |".repeat(10));
    for scene in scenes() {
        if options.scenes.is_empty() || options.scenes.iter().any(|name| name == scene.name) {
            measure(options, &scene);
        }
    }
}

fn measure(options: &Options, scene: &Scene) {
    let passes = Passes::within(0.0, 5.0);
    let mesh = |check: bool| {
        let program = Program::lower(&scene.solid()).expect("a valid scene");
        let mesher = Mesher::new().tolerance(scene.tolerance).check(check);
        mesher.mesh(&program).expect("a bounded scene")
    };
    let (checked, meshed) = passes.best(|| mesh(true));
    let (unchecked, _) = passes.best(|| mesh(false));
    let other = ask(options, scene);
    let number = |name: &str| {
        let value = other.as_ref().and_then(|answer| answer[name].as_f64());
        value.unwrap_or(f64::NAN)
    };
    println!(
        "| {} | {} | {:e} | {:.3} | {:.3} | {} | {:.3} | {} | {:.1} | {:.5} |",
        scene.name,
        scene.parts.len(),
        scene.tolerance,
        checked.wall,
        unchecked.wall,
        meshed.mesh.triangles.len(),
        number("seconds"),
        number("triangles"),
        number("seconds") / checked.wall,
        meshed.mesh.measure().volume / number("volume"),
    );
}

fn scenes() -> Vec<Scene> {
    let scene = |name, tolerance, parts| Scene {
        name,
        tolerance,
        is_difference: false,
        parts,
    };
    let grid = |n: u32| {
        let places = move |i: u32| (0..n).flat_map(move |j| (0..n).map(move |k| [i, j, k]));
        (0..n).flat_map(places)
    };
    let at = |place: [u32; 3]| DVec3::from_array(place.map(f64::from));
    let less = |name, tolerance, block, parts: Vec<Part>| Scene {
        is_difference: true,
        ..scene(name, tolerance, [vec![block], parts].concat())
    };
    let cheese = |name, tolerance, n| {
        let balls = balls_of(&scenes::cheese(n)).into_iter();
        let block = Part::Block {
            low: DVec3::NEG_ONE,
            size: DVec3::splat(2.0),
        };
        let balls = balls.filter_map(|field| match field {
            Field::Ball { center, radius } => Some(Part::Ball {
                center: DVec3::from_array(center),
                radius,
            }),
            _ => None,
        });
        less(name, tolerance, block, balls.collect())
    };
    let cube = |place| Part::Block {
        low: at(place),
        size: DVec3::ONE,
    };
    let rod = |axis, start, length, radius| Part::Rod {
        axis,
        start,
        length,
        radius,
    };
    let strut = |[i, j, k]: [u32; 3]| (0..3).map(move |axis| rod(axis, at([i, j, k]), 1.0, 0.05));
    let holes = (0..10_000).map(|k| {
        let place = DVec3::new(f64::from(k % 100), f64::from(k / 100), -1.0);
        rod(2, place + 0.5 * DVec3::new(1.0, 1.0, 0.0), 3.0, 0.3)
    });
    let plate = Part::Block {
        low: DVec3::ZERO,
        size: DVec3::new(100.0, 100.0, 1.0),
    };
    let steps = (1..=1000).map(|k| {
        let height = f64::from(k) / 1000.0;
        rod(2, DVec3::ZERO, height, 1.5 - height)
    });
    let shells = (1..=500).map(|k| Part::Shell {
        outer: f64::from(k),
        inner: f64::from(k) - 0.5,
    });
    let chain = (0..1000).map(|k| Part::Ball {
        center: DVec3::new(1.5 * f64::from(k), 0.0, 0.0),
        radius: 1.0,
    });
    let is_black = |&[i, j, k]: &[u32; 3]| (i + j + k) % 2 == 0;
    vec![
        cheese("balls-10000", 2e-3, 10_000),
        cheese("balls-10000-coarse", 2e-2, 10_000),
        cheese("balls-100000-coarse", 2e-2, 100_000),
        scene("struts", 0.02, grid(20).flat_map(strut).collect()),
        less("plate", 0.01, plate, holes.collect()),
        scene("coaxial", 0.01, steps.collect()),
        scene("cubes", 0.01, grid(46).map(cube).collect()),
        scene(
            "checkerboard",
            0.01,
            grid(46).filter(is_black).map(cube).collect(),
        ),
        scene("shells", 0.5, shells.collect()),
        scene("chain", 0.01, chain.collect()),
    ]
}

impl Scene {
    fn solid(&self) -> Solid {
        let parts = self.parts.iter().map(Part::solid);
        match self.is_difference {
            true => Solid::difference(parts),
            false => Solid::union(parts),
        }
    }

    /// What manifold3d is asked for: each part's kind, numbers, and segments of its circles.
    fn request(&self) -> Value {
        let parts = self.parts.iter().map(|part| part.request(self.tolerance));
        json!({ "difference": self.is_difference, "parts": parts.collect::<Vec<_>>() })
    }
}

impl Part {
    fn solid(&self) -> Solid {
        match *self {
            Self::Ball { center, radius } => Solid::sphere(radius).translate(center),
            Self::Shell { outer, inner } => Solid::sphere(outer) - Solid::sphere(inner),
            Self::Rod {
                axis,
                start,
                length,
                radius,
            } => {
                let rod = Solid::cylinder(radius, 0.0..length);
                let turned = match axis {
                    0 => rod.rotate_y(0.5 * PI),
                    1 => rod.rotate_x(-0.5 * PI),
                    _ => rod,
                };
                turned.translate(start)
            }
            Self::Block { low, size } => Solid::cuboid(size).translate(low + 0.5 * size),
        }
    }

    fn request(&self, tolerance: f64) -> Value {
        let segments = |radius: f64| {
            let half = (1.0 - tolerance / radius).max(0.0).acos();
            // In fours, like its spheres; a tolerance beyond the radius leaves an octahedron.
            4 * (PI / half / 4.0).ceil().max(1.0) as u32
        };
        match *self {
            Self::Ball { center, radius } => {
                json!(["ball", center.to_array(), radius, segments(radius)])
            }
            Self::Shell { outer, inner } => {
                json!(["shell", outer, inner, segments(outer), segments(inner)])
            }
            Self::Rod {
                axis,
                start,
                length,
                radius,
            } => {
                let at = start.to_array();
                json!(["rod", axis, at, length, radius, segments(radius)])
            }
            Self::Block { low, size } => json!(["block", low.to_array(), size.to_array()]),
        }
    }
}

/// What manifold3d says; nothing if it does not answer in time or Python does not run, which is
/// said.
fn ask(options: &Options, scene: &Scene) -> Option<Value> {
    let file = std::env::temp_dir().join(format!("many-{}.json", std::process::id()));
    fs::write(&file, scene.request().to_string()).expect("a file");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/peers/many.py");
    let output = Command::new(&options.python)
        .arg(script)
        .arg(&file)
        .arg(options.patience.to_string())
        .output();
    // A leftover does no harm.
    let _ = fs::remove_file(&file);
    match output {
        Ok(output) if output.status.success() => serde_json::from_slice(&output.stdout).ok(),
        Ok(output) => {
            let said = String::from_utf8_lossy(&output.stderr);
            eprintln!(
                "{}: manifold3d ends with {} {said}",
                scene.name, output.status
            );
            None
        }
        Err(error) => {
            eprintln!("{} does not run: {error}", options.python.display());
            None
        }
    }
}
