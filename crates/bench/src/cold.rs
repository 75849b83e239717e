//! How long from a file to a picture, by a process that has just been started?

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use bench::meshes;
use csg::Mesh;
use stereotomy::io::{WriteOptions, write_mesh};

#[derive(clap::Args)]
pub struct Options {
    /// The `csg` command [default: beside this program]
    #[arg(long, value_name = "PATH")]
    csg: Option<PathBuf>,
    /// What to draw: m1 (82 thousand triangles), m2 (1.31 million), flange
    /// (a scene, which is meshed)
    #[arg(default_values = ["m1", "m2", "flange"])]
    subjects: Vec<String>,
    /// File formats of the meshes
    #[arg(long, value_delimiter = ',', default_value = "glb,stl,obj")]
    formats: Vec<String>,
    /// How often each picture is drawn
    #[arg(long, default_value_t = 15)]
    passes: u32,
    /// Say where the time goes, too
    #[arg(long)]
    stages: bool,
}

/// Kinds of anti-aliasing: the command's own choice, and none.
const SMOOTHING: [&str; 2] = ["msaa4", "none"];

/// Prints one line for each subject and format: the least wall time of a
/// process, from its start to its end.
pub fn run(options: &Options) {
    let folder = std::env::temp_dir().join(format!("cold-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder for temporary files");
    let csg = options.csg.clone().unwrap_or_else(|| {
        let own = std::env::current_exe().expect("the path of this program");
        own.with_file_name("csg")
    });
    println!("| input | MB | 4x MSAA, ms | without, ms |");
    println!("|{}", " --- |".repeat(4));
    for subject in &options.subjects {
        for input in inputs(subject, &options.formats, &folder) {
            let picture = folder.join("picture.png");
            let size = if subject == "flange" {
                "1600x1200"
            } else {
                "1920x1080"
            };
            let command = |smoothing: &str| {
                let mut command = Command::new(&csg);
                command
                    .arg("render")
                    .arg("--plain")
                    .arg(&input)
                    .arg("-o")
                    .arg(&picture);
                command.args(["--size", size, "--anti-aliasing", smoothing]);
                command
            };
            let times = SMOOTHING.map(|smoothing| best(command(smoothing), options.passes));
            let name = input.file_name().unwrap_or_default().to_string_lossy();
            let bytes = fs::metadata(&input).map_or(0, |about| about.len());
            println!(
                "| {name} | {:.1} | {:.1} | {:.1} |",
                bytes as f64 / 1e6,
                times[0] * 1e3,
                times[1] * 1e3,
            );
            if options.stages {
                let said = command(SMOOTHING[0]).arg("--stats").output();
                let said = said.expect("the command runs").stderr;
                eprintln!("{}", String::from_utf8_lossy(&said));
            }
        }
    }
    let _ = fs::remove_dir_all(&folder);
}

/// The files of a subject, one for each format.
fn inputs(subject: &str, formats: &[String], folder: &Path) -> Vec<PathBuf> {
    let mesh: Mesh = match subject {
        "m1" => meshes::icosphere(6),
        "m2" => meshes::icosphere(8),
        "flange" => {
            let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
            return vec![models.join("flange.csg")];
        }
        _ => {
            eprintln!("no subject {subject}");
            return Vec::new();
        }
    };
    let write = |format: &String| {
        let path = folder.join(subject).with_extension(format);
        write_mesh(&path, &mesh, &WriteOptions::default()).expect("a written mesh");
        path
    };
    formats.iter().map(write).collect()
}

/// The least wall time of a process, in seconds.
fn best(mut command: Command, passes: u32) -> f64 {
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let pass = |_| {
        let start = Instant::now();
        let ended = command.status().expect("the command runs");
        assert!(ended.success(), "{command:?} failed");
        start.elapsed().as_secs_f64()
    };
    (0..passes.max(1)).map(pass).fold(f64::INFINITY, f64::min)
}
