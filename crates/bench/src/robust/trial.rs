//! One random solid meshed and judged, in a process of its own: whatever it does there,
//! the others go on.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use csg::{BoundaryOptions, Mesh, Meshed, Mesher, Program, Report, Solid};
use serde_json::{Value, json};
use stereotomy::io::scene::{self, ReadOptions};

use super::classes::Class;
use crate::judge::{self, Case, Tree, is_seen};

/// What became of a solid.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Of processor time for meshing, with the mesher's own check.
    pub seconds: f64,
    /// What the mesher says was settled for, each kind once.
    pub reported: Vec<String>,
    /// What it could not tell on the way there.
    pub undecided: Vec<String>,
    /// Whether surfaces were moved or merged.
    pub moved: bool,
    /// Why there is no mesh, though the solid is not empty.
    pub refused: Option<String>,
    /// Whether it was ended before it had an answer.
    pub ended: bool,
    /// What is wrong with the mesh.
    pub faults: Vec<String>,
}

/// What a process prints when it has a mesh, or an error: judging it takes longer.
const ANSWERED: &str = "answered";

/// Meshes a solid and judges the mesh, on one thread, and prints a line as soon as
/// there is a mesh, and the outcome.
pub fn alone(class: Class, seed: u64, tolerance: f64) {
    let solid = class.solid(seed);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let outcome = pool
        .expect("a thread")
        .install(|| outcome(&solid, seed, tolerance));
    print(outcome);
}

/// The same for scene files, one after another.
pub fn files(files: &[PathBuf], seed: u64, tolerance: f64) {
    for file in files {
        println!("{}", file.display());
        match scene::read_file(file, &ReadOptions::default()) {
            Ok(scene) => print(outcome(&scene.solid, seed, tolerance)),
            Err(error) => println!("{error}"),
        }
    }
}

fn print(outcome: Outcome) {
    let Outcome {
        seconds,
        reported,
        undecided,
        moved,
        refused,
        faults,
        ended: _,
    } = outcome;
    println!(
        "{}",
        json!({
            "seconds": seconds, "reported": reported, "undecided": undecided,
            "moved": moved, "refused": refused, "faults": faults,
        })
    );
}

fn outcome(solid: &Solid, seed: u64, tolerance: f64) -> Outcome {
    let start = cpu_time::ThreadTime::now();
    let made = Program::lower(solid).and_then(|program| {
        let meshed = Mesher::new().tolerance(tolerance).mesh(&program)?;
        Ok((program, meshed))
    });
    let seconds = start.elapsed().as_secs_f64();
    println!("{ANSWERED}");
    let (program, Meshed { mesh, report, .. }) = match made {
        Ok(made) => made,
        Err(error) => {
            let refused = is_seen(solid, seed).then(|| error.to_string());
            return Outcome {
                seconds,
                refused,
                ..Outcome::default()
            };
        }
    };
    let tree = Tree::new(solid);
    let verdict = judge::judge(&Case {
        tree: &tree,
        mesh: &mesh,
        tolerance,
        unseen: report.moved.map_or(0.0, |moved| 2.0 * moved.distance),
        seed,
    });
    let mut faults = verdict.faults;
    faults.extend(fault_of_boundary(&program, &mesh, &report));
    Outcome {
        seconds,
        reported: reported(&report, tolerance),
        undecided: report.undecided.iter().map(ToString::to_string).collect(),
        moved: report.moved.is_some(),
        refused: None,
        ended: false,
        faults,
    }
}

/// What is wrong with the exact boundary of a solid, whose volume must be that of a mesh that is
/// proven.
fn fault_of_boundary(program: &Program, mesh: &Mesh, report: &Report) -> Option<String> {
    let deviation = report.deviation.filter(|_| report.is_proven())?;
    let measure = match program.boundary(&BoundaryOptions::new()) {
        Ok(brep) => brep.measure(),
        Err(error) => return Some(format!("no exact boundary: {error}")),
    };
    // A layer as thick as that all around, and as much again for its second order.
    let of_mesh = mesh.measure();
    let rounding = measure.volume.error + of_mesh.volume_rounding;
    let most = 2.0 * deviation * measure.area.upper() + rounding;
    let off = (of_mesh.volume - measure.volume.value).abs();
    /// Of slivers in solids whose sizes are about 1 no more is known.
    const LEAST: f64 = 1e-11;
    // Not so of what is no number.
    let is_told = measure.volume.error <= (1e-3 * measure.area.value).max(LEAST);
    let is_right = off <= most && is_told;
    (!is_right).then(|| {
        format!(
            "the exact boundary's volume is {:?}, off {off}",
            measure.volume
        )
    })
}

fn reported(report: &Report, tolerance: f64) -> Vec<String> {
    let mut words: Vec<String> = report.fallbacks.iter().map(ToString::to_string).collect();
    let deviation = report.deviation.unwrap_or_default();
    if words.is_empty() && deviation > tolerance {
        words.push(format!("a deviation of {deviation}"));
    }
    words
}

/// The same by a process of its own, which is ended if it has no answer after some time.
pub fn apart(class: Class, seed: u64, tolerance: f64, limit: Duration) -> Outcome {
    /// In which a mesh is judged at the longest.
    const JUDGING: Duration = Duration::from_secs(600);
    let start = Instant::now();
    let name = clap::ValueEnum::to_possible_value(&class).expect("a name");
    let mut child = Command::new(std::env::current_exe().expect("this program"))
        .args(["robust", "--alone", "--class", name.get_name()])
        .args(["--seed", &seed.to_string()])
        .args(["--tolerance", &tolerance.to_string()])
        .env("RAYON_NUM_THREADS", "1")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("this program again");
    let output = BufReader::new(child.stdout.take().expect("its output"));
    let (sender, lines) = mpsc::channel();
    thread::spawn(move || {
        for line in output.lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                return;
            }
        }
    });
    let failed = |ended: bool, words: String| Outcome {
        seconds: start.elapsed().as_secs_f64(),
        refused: Some(words),
        ended,
        ..Outcome::default()
    };
    let answer = lines.recv_timeout(limit);
    let judged = match &answer {
        Ok(_) => lines.recv_timeout(JUDGING),
        Err(why) => Err(*why),
    };
    if judged == Err(RecvTimeoutError::Timeout) {
        // It may be over by now.
        let _ = child.kill();
    }
    let status = child.wait().expect("a process");
    let value: Value = match (answer, judged) {
        (Err(RecvTimeoutError::Timeout), _) => {
            return failed(true, format!("no answer in {limit:?}"));
        }
        (_, Err(RecvTimeoutError::Timeout)) => {
            return failed(false, format!("not judged in {JUDGING:?}"));
        }
        (_, judged) => match judged.map(|line| serde_json::from_str(&line)) {
            Ok(Ok(value)) => value,
            _ => return failed(false, format!("ended with {status}")),
        },
    };
    let words = |name: &str| -> Vec<String> {
        let list = value[name].as_array().into_iter().flatten();
        list.filter_map(|word| word.as_str().map(str::to_owned))
            .collect()
    };
    Outcome {
        seconds: value["seconds"].as_f64().unwrap_or_default(),
        reported: words("reported"),
        undecided: words("undecided"),
        moved: value["moved"] == true,
        refused: value["refused"].as_str().map(str::to_owned),
        ended: false,
        faults: words("faults"),
    }
}

/// Stores a solid as a scene file.
pub fn write(class: Class, seed: u64, folder: &Path) {
    let name = format!("{class:?}-{seed}.csg").to_lowercase();
    let text = scene::write(&class.solid(seed)).expect("of nodes that scenes have");
    let written = fs::create_dir_all(folder).and_then(|()| fs::write(folder.join(name), text));
    written.unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
}
