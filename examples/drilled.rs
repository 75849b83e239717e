//! The main job from end to end: a solid becomes a mesh, two files and a
//! picture, and its volume is printed beside the exact one.
//!
//! `cargo run --release --example drilled` does that; with arguments, like
//! `-- mesh -o drilled.stl --cells 256`, it is a command line of its own.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use stereotomy::csg::{Mesher, Program};
use stereotomy::io::{WriteOptions, write_mesh};
use stereotomy::raster::{AntiAliasing, Camera, Lens, RenderOptions, StandardView, render};
use stereotomy::scenes;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    if std::env::args().len() > 1 {
        return Ok(cli::run(scenes::drilled));
    }
    let program = Program::lower(&scenes::drilled())?;
    let meshed = Mesher::new().cells(128).normals().mesh(&program)?;
    let mesh = &meshed.mesh;

    let folder = Path::new("out");
    fs::create_dir_all(folder)?;
    for name in ["drilled.glb", "drilled.obj"] {
        write_mesh(folder.join(name), mesh, &WriteOptions::default())?;
    }
    let (width, height) = (1024, 768);
    let aspect = f64::from(width) / f64::from(height);
    let camera = Camera::standard(mesh, StandardView::Iso, Lens::DEFAULT, aspect)?;
    let view = camera.view(width, height)?;
    let mut options = RenderOptions::default();
    options.anti_aliasing = AntiAliasing::Msaa4;
    let image = render(mesh, &view, width, height, &options)?;
    fs::write(folder.join("drilled.png"), image.to_png()?)?;

    let volume = mesh.volume();
    let exact = scenes::DRILLED_VOLUME;
    println!("volume  {volume:.9}");
    println!("exact   {exact:.9}  ({:+.1e} off)", volume / exact - 1.0);
    println!("mesh    {}", meshed.report.check);
    println!("wrote   out/drilled.glb, out/drilled.obj, out/drilled.png");
    Ok(ExitCode::SUCCESS)
}
