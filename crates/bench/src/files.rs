//! Is every mesh of scene files and reference scenes sound, on grids and to
//! tolerances, and does manifold3d agree?

use std::fs;
use std::path::{Path, PathBuf};

use csg::{Mesher, Program, Solid};
use rayon::prelude::*;
use stereotomy::io::scene::{ReadOptions, SceneError, read_file};

use crate::scenes;
use crate::tally::{Case, Judge, Promise, Tally};

#[derive(clap::Args)]
pub struct Options {
    /// Scene files, folders of them, and scenes by name
    #[arg(default_values = ["models", "models/hard", "S1", "S2", "S3", "S8", "S4-2", "S4-3",
                            "S5-100", "S6", "S7-1e-2", "S7-1e-3"])]
    subjects: Vec<String>,
    /// Cells along the solid's longest side
    #[arg(long, value_delimiter = ',', default_value = "16,64,128")]
    cells: Vec<u32>,
    /// Tolerances, as shares of the solid's longest side
    #[arg(long, value_delimiter = ',', default_value = "1e-2,1e-3,1e-4")]
    tolerances: Vec<f64>,
    /// Polygons and polyhedra in place of the files' circles and spheres
    #[arg(long)]
    faceted: bool,
    /// A Python that has manifold3d and numpy: by default that of the tests
    #[arg(long, default_value = "target/tmp/manifold3d/venv/bin/python")]
    python: PathBuf,
}

/// Prints every failure, and a summary for grids and one for tolerances.
pub fn run(options: &Options) {
    let subjects: Vec<(String, Solid)> = options
        .subjects
        .iter()
        .flat_map(|subject| solids(subject, options.faceted))
        .collect();
    println!("{} solids", subjects.len());
    let grids = options.cells.iter().map(|&cells| Way::Cells(cells));
    let tolerances = options.tolerances.iter().map(|&share| Way::Share(share));
    let ways: [(_, Vec<Way>); 2] = [
        ("on grids", grids.collect()),
        ("to tolerances", tolerances.collect()),
    ];
    for (heading, ways) in ways {
        let tally = Tally::new(Some(Judge::start(&options.python)));
        subjects
            .par_iter()
            .for_each(|(name, solid)| mesh(name, solid, &ways, &tally));
        println!("{heading}:");
        tally.print();
    }
}

/// How to mesh a solid.
#[derive(Clone, Copy)]
enum Way {
    /// So many cells along its longest side.
    Cells(u32),
    /// To this share of it.
    Share(f64),
}

fn mesh(name: &str, solid: &Solid, ways: &[Way], tally: &Tally) {
    const SEGMENTS: u32 = 256;
    let program = Program::lower(solid).unwrap_or_else(|e| panic!("{name}: {e}"));
    let bounds = program.bounds().unwrap_or_else(|e| panic!("{name}: {e}"));
    let size = bounds.map_or(1.0, |bounds| bounds.size().max_element());
    let volume = tally.judge().map(|judge| judge.volume(solid, SEGMENTS));
    for &way in ways {
        let (how, mesher, promise, distance) = match way {
            Way::Cells(cells) => (
                format!("at {cells} cells"),
                Mesher::new().cells(cells),
                Promise::Sound,
                // Faces are off by a term of second order: far less than that
                // of a cell.
                0.15 * size / f64::from(cells),
            ),
            Way::Share(share) => (
                format!("to {share:e} of its size"),
                Mesher::new().tolerance(share * size),
                Promise::Kept,
                share * size,
            ),
        };
        let case = Case {
            what: format!("{name} {how}"),
            program: &program,
            genus: None,
            rounding: 0.0,
            promise,
            volume: volume.map(|(volume, within)| (volume, within + 1e-9 * volume)),
            distance,
        };
        tally.add(&case, &mesher);
    }
}

/// The solids of a scene by name, of a file, or of a folder's files, those
/// left out that have what the reader does not know.
fn solids(subject: &str, faceted: bool) -> Vec<(String, Solid)> {
    if let Some(scene) = scenes::scene(subject) {
        return vec![(scene.name, scene.solid)];
    }
    let path = Path::new(subject);
    let mut files = if path.is_dir() {
        let entries = fs::read_dir(path).unwrap_or_else(|e| panic!("{subject}: {e}"));
        let files = entries.map(|entry| entry.expect("an entry").path());
        files
            .filter(|file| file.extension().is_some_and(|e| e == "csg"))
            .collect()
    } else {
        vec![path.to_owned()]
    };
    files.sort();
    let read = |file: PathBuf| match read_file(&file, &ReadOptions::default().faceted(faceted)) {
        Ok(scene) => Some((file.display().to_string(), scene.solid)),
        Err(SceneError::Unsupported { .. }) => None,
        Err(error) => panic!("{}: {error}", file.display()),
    };
    files.into_iter().filter_map(read).collect()
}
