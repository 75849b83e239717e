use stereotomy::csg::{Program, Solid};

pub fn solid() -> Solid {
    Solid::cube(20.0) - Solid::cylinder(6.0, -11.0..11.0)
}

/// Volume, area and centre of mass, from the exact boundary, each with a bound on its error.
pub fn run() -> Result<(), Box<dyn std::error::Error>> {
    let brep = Program::lower(&solid())?.boundary(&Default::default())?;
    let measure = brep.measure();
    println!(
        "volume {} ± {:.0e}",
        measure.volume.value, measure.volume.error
    );
    println!("area {} ± {:.0e}", measure.area.value, measure.area.error);
    Ok(())
}
