//! The page of the cookbook: recipes in `examples/cookbook`, in the order of its list, with
//! their pictures, which pages must hold, for they have no files beside them.

#[path = "../raster/base64.rs"]
mod base64;

use std::env;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use base64::base64;

fn main() -> Result<(), Box<dyn Error>> {
    let root = env::var("CARGO_MANIFEST_DIR")?;
    let [recipes, pictures] =
        ["examples/cookbook", "models/cookbook"].map(|folder| Path::new(&root).join(folder));
    for folder in [&recipes, &pictures] {
        println!("cargo:rerun-if-changed={}", folder.display());
    }
    let list = fs::read_to_string(recipes.join("main.rs"))?;
    let (mut page, mut links) = (String::new(), String::new());
    let entries = list.lines().filter_map(|line| {
        let (name, title) = line.trim().strip_suffix("\",")?.split_once(": \"")?;
        Some((name, title))
    });
    for (number, (name, title)) in (1..).zip(entries) {
        let code = fs::read_to_string(recipes.join(format!("{name}.rs")))?;
        writeln!(page, "## {number}. {title}\n")?;
        if let Ok(picture) = fs::read(pictures.join(format!("{name}.png"))) {
            writeln!(page, "![{title}][{name}]\n")?;
            writeln!(
                links,
                "[{name}]: data:image/png;base64,{}",
                base64(&picture)
            )?;
        }
        // What writes files does so in a folder of its own.
        let run = if code.contains("pub fn run") {
            "# let folder = tempfile::tempdir()?; std::env::set_current_dir(&folder)?; run()?;\n"
        } else {
            ""
        };
        writeln!(
            page,
            "```\n{code}#\n\
             # fn main() -> Result<(), Box<dyn std::error::Error>> {{\n\
             # assert_eq!(stereotomy::csg::Program::lower(&solid())?.boundary(&Default::default())?\
             .is_empty(), false);\n{run}\
             # Ok(())\n# }}\n```\n"
        )?;
    }
    fs::write(
        Path::new(&env::var("OUT_DIR")?).join("cookbook.md"),
        page + &links,
    )?;
    Ok(())
}
