//! What is wrong with meshes, counted, with what it takes to repeat it printed.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use csg::{Mesh, Meshed, Mesher, Program, Solid};

use crate::defects::{self, largest_miss, size};
use crate::script::Script;

/// What a mesh is held to besides being manifold.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Promise {
    /// Nothing.
    Manifold,
    /// It does not fold or run through itself, unless something is reported.
    Sound,
    /// It does not, nor is anything reported.
    Kept,
}

/// One mesh to make, and what to expect of it.
pub struct Case<'a> {
    /// Whatever it takes to make it again.
    pub what: String,
    /// The solid.
    pub program: &'a Program,
    /// Of the mesh, where known.
    pub genus: Option<i64>,
    /// How far vertices may be off besides 1e-12 of the mesh's diagonal.
    pub rounding: f64,
    /// What else is expected.
    pub promise: Promise,
    /// The volume, and how far off that may be besides what the mesh is.
    pub volume: Option<(f64, f64)>,
    /// How far the mesh may be from the solid, on average; its volume may be
    /// off by as much for each unit of area.
    pub distance: f64,
}

/// manifold3d, which says whether it takes a mesh.
pub struct Judge {
    script: Mutex<Script>,
    folder: PathBuf,
}

impl Judge {
    /// By a Python that has manifold3d and numpy.
    pub fn start(python: &Path) -> Self {
        let folder = std::env::temp_dir().join(format!("bench-judge-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a folder for temporary files");
        Self {
            script: Mutex::new(Script::start(python)),
            folder,
        }
    }

    /// The volume of a solid whose circles have so many segments, and a bound of
    /// what that is off.
    pub fn volume(&self, solid: &Solid, segments: u32) -> (f64, f64) {
        let mut script = self.script.lock().expect("no panic");
        script.volume(solid, segments)
    }

    fn status(&self, mesh: &Mesh) -> String {
        let mut script = self.script.lock().expect("no panic");
        script.status(mesh, &self.folder).0
    }
}

impl Drop for Judge {
    fn drop(&mut self) {
        // A leftover does no harm.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// How many meshes had which fault.
#[derive(Default)]
pub struct Tally {
    judge: Option<Judge>,
    meshes: AtomicUsize,
    defective: AtomicUsize,
    errors: AtomicUsize,
    wrong_genus: AtomicUsize,
    off: AtomicUsize,
    crossed: AtomicUsize,
    folded: AtomicUsize,
    refused: AtomicUsize,
    wrong_volume: AtomicUsize,
    with_fallbacks: AtomicUsize,
}

impl Tally {
    /// That asks manifold3d, too, if it can.
    pub fn new(judge: Option<Judge>) -> Self {
        Self {
            judge,
            ..Self::default()
        }
    }

    /// Whom it asks.
    pub fn judge(&self) -> Option<&Judge> {
        self.judge.as_ref()
    }

    /// How many faults there were.
    pub fn failures(&self) -> usize {
        [
            &self.defective,
            &self.errors,
            &self.wrong_genus,
            &self.off,
            &self.crossed,
            &self.folded,
            &self.refused,
            &self.wrong_volume,
        ]
        .map(|counter| counter.load(Ordering::Relaxed))
        .iter()
        .sum()
    }

    /// Makes a mesh, prints its faults and counts them.
    pub fn add(&self, case: &Case<'_>, mesher: &Mesher) {
        let what = &case.what;
        let fault = |counter: &AtomicUsize, words: String| {
            counter.fetch_add(1, Ordering::Relaxed);
            println!("{what}: {words}");
        };
        self.meshes.fetch_add(1, Ordering::Relaxed);
        let Meshed { mesh, report, .. } = match mesher.mesh(case.program) {
            Ok(meshed) => meshed,
            Err(error) => return fault(&self.errors, error.to_string()),
        };
        let check = &report.check;
        if !check.is_manifold() {
            fault(&self.defective, check.to_string());
        } else if case.genus.is_some() && check.genus() != case.genus {
            let words = format!("genus {:?} for {:?}", check.genus(), case.genus);
            fault(&self.wrong_genus, words);
        }
        let fallbacks = &report.fallbacks;
        if !fallbacks.is_empty() {
            self.with_fallbacks.fetch_add(1, Ordering::Relaxed);
            if case.promise == Promise::Kept {
                for fallback in fallbacks {
                    println!("{what}: {fallback}");
                }
            }
        }
        let is_sound = match case.promise {
            Promise::Manifold => false,
            Promise::Sound => fallbacks.is_empty(),
            Promise::Kept => true,
        };
        if is_sound {
            let crossings = mesh.self_intersections().len();
            if crossings > 0 {
                let words = format!("{crossings} places where it runs through itself");
                fault(&self.crossed, words);
            }
            let found = defects::measure(case.program, &mesh);
            if found.folded > 0 {
                let words = format!("{} folds: {:?}", found.folded, found.places);
                fault(&self.folded, words);
            }
        }
        // A vertex whose surfaces have no common point cannot be on them all.
        if !fallbacks.iter().any(|f| f.kind.contains("common point")) {
            let miss = largest_miss(case.program, &mesh);
            let allowed = 1e-12 * size(&mesh) + case.rounding;
            if miss > allowed {
                let words = format!("vertices off by {miss:e}, allowed {allowed:e}");
                fault(&self.off, words);
            }
        }
        // What is lost or settled for may be any volume.
        if let Some((volume, within)) = case.volume
            && (fallbacks.is_empty() || case.promise == Promise::Kept)
        {
            let off = (mesh.volume() - volume).abs();
            let allowed = within + mesh.area() * case.distance;
            if off > allowed {
                let words = format!("volume off by {off:e} of {volume}, allowed {allowed:e}");
                fault(&self.wrong_volume, words);
            }
        }
        if let Some(judge) = &self.judge
            && check.is_manifold()
            && !mesh.triangles.is_empty()
        {
            let status = judge.status(&mesh);
            if status != "NoError" {
                fault(&self.refused, format!("manifold3d says {status}"));
            }
        }
    }

    /// Prints the counts.
    pub fn print(self) {
        let count = AtomicUsize::into_inner;
        println!(
            "{} meshes: {} not manifold, {} errors, {} of the wrong genus, {} with vertices off \
             their surfaces; {} through themselves and {} folded where none should be; {} with \
             fallbacks",
            count(self.meshes),
            count(self.defective),
            count(self.errors),
            count(self.wrong_genus),
            count(self.off),
            count(self.crossed),
            count(self.folded),
            count(self.with_fallbacks),
        );
        if self.judge.is_some() {
            println!(
                "manifold3d: {} meshes refused, {} of another volume",
                count(self.refused),
                count(self.wrong_volume),
            );
        }
    }
}
