//! How long does a mesh of a given error take?
//!
//! Every mesher goes through its own settings, on one thread; each mesh's
//! distance to the true boundary, both ways, and its volume are measured by
//! the same code; and how many triangles the others need beside ours at their
//! deviations. Times leave out what is done once for a model, as in the
//! table of uniform meshes, and every final check.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::PathBuf;

use csg::{Mesh, Mesher, Program};
use glam::DVec3;

use crate::deviation::{boundary_samples, mesh_to_boundary, points_to_mesh};
use crate::figure::Figure;
use crate::peers::fidget::{self, Evaluator, Run};
use crate::peers::{manifold, surface_nets};
use crate::plot;
use crate::scenes::{self, Scene};
use crate::timing::{Passes, on_threads};
use crate::triangles;

/// The tolerances asked of ours: from coarser than any of the others' meshes on.
const TOLERANCES: [f64; 17] = [
    5e-2, 3e-2, 2e-2, 1e-2, 5e-3, 3e-3, 2e-3, 1e-3, 5e-4, 3e-4, 2e-4, 1.4e-4, 1e-4, 3e-5, 1e-5,
    3e-6, 1e-6,
];

/// No finer setting of a mesher is tried once one took so many seconds.
const MOST: f64 = 5.0;

#[derive(clap::Args)]
pub struct Options {
    /// Scenes to mesh
    scenes: Vec<String>,
    /// Append the figures to this file
    #[arg(long)]
    csv: Option<PathBuf>,
    /// Draw the figures of the CSV file as this SVG, and a PNG beside it, after
    /// whatever is run; time against error of volume beside both, with `-volume`
    /// in their names
    #[arg(long, requires = "csv")]
    plot: Option<PathBuf>,
    /// A Python that has manifold3d and numpy: by default that of the tests
    #[arg(long, default_value = "target/tmp/manifold3d/venv/bin/python")]
    python: PathBuf,
}

/// Prints two tables for each scene, a line for each mesh, and draws the plot.
pub fn run(options: &Options) {
    for name in &options.scenes {
        let Some(scene) = scenes::scene(name) else {
            eprintln!("no scene {name}: try one of {}", scenes::NAMES.join(", "));
            continue;
        };
        triangles::print(&one(&scene, options));
    }
    if let (Some(csv), Some(svg)) = (&options.csv, &options.plot) {
        let text = fs::read_to_string(csv).expect("the CSV file");
        let figures: Vec<Figure> = text.lines().filter_map(Figure::parse).collect();
        plot::draw(svg, &figures).expect("the plot is drawn");
    }
}

/// What all meshes of a scene are measured with.
struct Gauge<'a> {
    scene: &'a Scene,
    program: Program,
    boundary: Vec<DVec3>,
    options: &'a Options,
    figures: Vec<Figure>,
}

impl Gauge<'_> {
    fn record(&mut self, mesher: &str, setting: &str, seconds: f64, mesh: &Mesh) {
        let there = mesh_to_boundary(&self.program, self.scene.half, mesh);
        let back = points_to_mesh(&self.boundary, mesh);
        let figure = Figure {
            scene: self.scene.name.clone(),
            mesher: mesher.to_owned(),
            setting: setting.to_owned(),
            seconds,
            deviation: there.max(back),
            volume_error: ((mesh.volume() - self.scene.volume) / self.scene.volume).abs(),
            triangles: mesh.triangles.len(),
        };
        let columns = figure.columns();
        println!("| {} |", columns.join(" | "));
        if let Some(path) = &self.options.csv {
            let file = OpenOptions::new().append(true).create(true).open(path);
            let written = file.and_then(|mut file| writeln!(file, "{}", columns.join(",")));
            written.expect("the CSV file can be written");
        }
        self.figures.push(figure);
    }
}

fn one(scene: &Scene, options: &Options) -> Vec<Figure> {
    println!("| scene | mesher | setting | s | deviation | volume error | triangles |");
    println!("|{}", " --- |".repeat(7));
    let program = Program::lower(&scene.solid).expect("a valid scene");
    let mut gauge = Gauge {
        scene,
        boundary: boundary_samples(&program, scene.half),
        program,
        options,
        figures: Vec::new(),
    };
    let passes = Passes::within(0.1, 2.0);
    let mut ours = |name: &str, setting: &str, mesher: &Mesher| {
        let (time, meshed) = on_threads(1, || passes.best(|| mesher.mesh(&gauge.program)));
        match meshed {
            Ok(meshed) => gauge.record(name, setting, time.wall, &meshed.mesh),
            Err(error) => eprintln!("{}, {name} {setting}: {error}", scene.name),
        }
        time.wall < MOST
    };
    for t in TOLERANCES {
        let mesher = Mesher::new().check(false).tolerance(t);
        if !ours("ours", &format!("{t:e}"), &mesher) {
            break;
        }
    }
    for cells in [8, 16, 32, 64, 128, 256, 512] {
        let mesher = Mesher::new().check(false).cells(cells);
        if !ours("ours uniform", &cells.to_string(), &mesher) {
            break;
        }
    }
    for depth in 4..=9 {
        let runs = Evaluator::ALL.map(|evaluator| {
            let run = Run {
                evaluator,
                depth,
                half: scene.half,
                threads: 1,
            };
            fidget::with_mesher(&scene.field, run, |mesh| passes.best(mesh))
        });
        let faster = runs
            .into_iter()
            .min_by(|a, b| a.0.wall.total_cmp(&b.0.wall));
        let (time, raw) = faster.expect("two evaluators");
        gauge.record("fidget", &depth.to_string(), time.wall, &raw.into_mesh());
        if time.wall > MOST {
            break;
        }
    }
    for cells in [32, 64, 128, 256] {
        let (time, raw) = passes.best(|| surface_nets::mesh(&scene.field, cells, scene.half));
        let mesh = raw.into_mesh();
        gauge.record("fast-surface-nets", &cells.to_string(), time.wall, &mesh);
        if time.wall > MOST {
            break;
        }
    }
    for made in manifold::meshes(&options.python, &scene.name) {
        let setting = made.segments.to_string();
        gauge.record("manifold3d", &setting, made.seconds, &made.mesh);
    }
    gauge.figures
}
