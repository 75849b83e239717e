//! The pictures of the crate's page, one for each stage of the pipeline, half
//! as large again, and a turntable that moves.
//!
//! `cargo run --release -p raster --example tour -- FOLDER`

#[path = "../../tests/common/mod.rs"]
mod common;
mod pictures;

use std::fs::{self, File};
use std::path::Path;

use raster::write_apng;

/// On the page it is 2.
const SCALE: u32 = 3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "tour".to_owned());
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    for (name, image) in pictures::all(SCALE)? {
        fs::write(folder.join(name).with_extension("png"), image.to_png()?)?;
    }
    let frames = pictures::turntable_frames(SCALE, 24)?;
    write_apng(&frames, 12, File::create(folder.join("turntable.png"))?)?;
    Ok(())
}
