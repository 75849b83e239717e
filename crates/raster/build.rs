//! The pictures of the crate's page, as definitions of links that hold them, for
//! pages have no files beside them.

mod base64;

use std::env;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use base64::base64;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(&env::var("CARGO_MANIFEST_DIR")?).join("docs");
    println!("cargo:rerun-if-changed={}", folder.display());
    let mut files: Vec<_> = fs::read_dir(&folder)?
        .filter_map(|entry| entry.ok().map(|entry| entry.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "png"))
        .collect();
    files.sort();
    let mut links = String::new();
    for file in files {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let data = base64(&fs::read(&file)?);
        writeln!(links, "[{name}]: data:image/png;base64,{data}")?;
    }
    fs::write(Path::new(&env::var("OUT_DIR")?).join("pictures.md"), links)?;
    Ok(())
}
