use stereotomy::csg::{Program, Solid};

/// A washer by its bore and thickness.
pub fn variant(bore: f64, thickness: f64) -> Solid {
    Solid::tube(20.0, bore, 0.0..thickness)
}

pub fn solid() -> Solid {
    let shown = (0..4).map(|k| {
        let (bore, thickness) = (5.0 + 3.0 * f64::from(k), 4.0 + 4.0 * f64::from(k));
        variant(bore, thickness).translate([45.0 * f64::from(k), 0.0, 0.0])
    });
    Solid::union(shown)
}

/// Job `part` of `of` on a cluster makes its share of a thousand variants, and writes a table.
/// With files in place of a model in Rust, `csg sweep table.csv --shard 3/8` does the same.
pub fn run() -> Result<(), Box<dyn std::error::Error>> {
    let number = |name: &str, or: usize| std::env::var(name).map_or(Ok(or), |text| text.parse());
    let (part, of) = (
        number("SLURM_ARRAY_TASK_ID", 0)?,
        number("SLURM_ARRAY_TASK_COUNT", 8)?,
    );
    let mut table = "bore,thickness,volume\n".to_owned();
    for row in 1000 * part / of..1000 * (part + 1) / of {
        let (bore, thickness) = (5.0 + 0.01 * row as f64, 2.0 + 0.002 * row as f64);
        let program = Program::lower(&variant(bore, thickness))?;
        let volume = program.boundary(&Default::default())?.measure().volume;
        table += &format!("{bore},{thickness},{}\n", volume.value);
    }
    std::fs::write(format!("washers-{part}.csv"), table)?;
    Ok(())
}
