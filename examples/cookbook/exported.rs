use stereotomy::csg::{BoundaryOptions, Mesher, Program, Solid};
use stereotomy::io::step::{StepOptions, write_step_file};
use stereotomy::io::{WriteOptions, write_mesh};

pub fn solid() -> Solid {
    Solid::cylinder(20.0, 0.0..10.0)
        - Solid::counterbore(4.0, 11.0, 8.0, 5.0).translate([0.0, 0.0, 10.0])
}

/// A mesh to print, no farther than 0.02 from the surface, and STEP with the surface itself.
pub fn run() -> Result<(), Box<dyn std::error::Error>> {
    let program = Program::lower(&solid())?;
    let meshed = Mesher::new().tolerance(0.02).mesh(&program)?;
    write_mesh("washer.3mf", &meshed.mesh, &WriteOptions::default())?;
    let exact = program.boundary(&BoundaryOptions::new().cut_at_seams())?;
    write_step_file(
        "washer.step",
        &exact,
        &StepOptions::default().name("washer"),
    )?;
    Ok(())
}
