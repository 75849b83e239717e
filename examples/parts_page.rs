//! The page of all parts, `models/parts.md`, with a picture of each, made by the examples
//! themselves: `cargo run --release --example parts_page`.

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, ExitCode};

/// The examples, what they are, and the options of their pictures.
const PARTS: [(&str, &str, &str); 14] = [
    ("flange", "Flange with hub, bolt holes and keyway", ""),
    ("spur_gear", "Spur gear with involute flanks", ""),
    ("ball_bearing", "Ball bearing", "--section y=0"),
    ("bracket", "Bracket with slots and a rib", ""),
    ("enclosure", "Enclosure with bosses, and its lid", ""),
    ("pipe_manifold", "Pipe manifold", "--section y=0"),
    ("chess_pawn", "Chess pawn", ""),
    ("heat_sink", "Heat sink", ""),
    (
        "hinge",
        "Hinge with countersunk holes",
        "--camera=0.5,-1,-0.5",
    ),
    ("knurled_knob", "Knurled knob", ""),
    ("nameplate", "Nameplate with text", ""),
    ("bolt_and_nut", "Bolt and nut with ISO thread", ""),
    ("brick", "Building brick", ""),
    ("vase", "Vase, turned", ""),
];

fn main() -> ExitCode {
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    match page(&models) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn page(models: &Path) -> Result<(), String> {
    let pictures = models.join("parts");
    std::fs::create_dir_all(&pictures).map_err(|e| e.to_string())?;
    let mut page = "# Parts\n\nMade by `cargo run --release --example parts_page`; each is an \
                    example of some twenty to sixty lines, and `-- --help` lists its \
                    parameters.\n"
        .to_owned();
    for (name, what, options) in PARTS {
        let picture = pictures.join(format!("{name}.png"));
        // Examples stand beside this one.
        let beside = std::env::current_exe().map_err(|e| e.to_string())?;
        let status = Command::new(env!("CARGO"))
            .args(["run", "-q", "--example", name])
            .args(profile_of(&beside))
            .args([
                "--",
                "render",
                "--size",
                "480x360",
                "--background",
                "ffffff",
            ])
            .args(options.split_whitespace())
            .arg("-o")
            .arg(&picture)
            .status()
            .map_err(|e| e.to_string())?;
        if !status.success() {
            return Err(format!("{name}: {status}"));
        }
        let _ = write!(
            page,
            "\n## {what}\n\n`examples/{name}.rs`\n\n![{what}](parts/{name}.png)\n"
        );
    }
    std::fs::write(models.join("parts.md"), page).map_err(|e| e.to_string())
}

/// The option that makes cargo build the others as this one was built.
fn profile_of(program: &Path) -> Option<&'static str> {
    let release = program
        .components()
        .any(|part| part.as_os_str() == "release");
    release.then_some("--release")
}
