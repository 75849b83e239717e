use stereotomy::csg::{Path, Solid};

pub fn solid() -> Solid {
    // Half of a section, from the axis and back to it.
    let section = Path::from([0.0, 0.0])
        .line_to([6.0, 0.0])
        .line_to([6.0, 8.0])
        .arc_to([15.0, 17.0], -90f64.to_radians())
        .arc_to([0.0, 32.0], 90f64.to_radians())
        .close();
    Solid::revolve(&section)
}
