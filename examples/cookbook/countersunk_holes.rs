use stereotomy::csg::{Color, Solid};

pub fn solid() -> Solid {
    // A hole's top is at the origin.
    let hole = Solid::countersink(2.2, 10.0, 4.5);
    let row = hole.linear_pattern(4, [15.0, 0.0, 0.0]);
    let bar = Solid::cuboid_between([-8.0, -8.0, -6.0], [53.0, 8.0, 0.0]);
    (bar - row).colored(Color::from_srgb([0.72, 0.6, 0.35]))
}
