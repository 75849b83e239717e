use stereotomy::csg::{Color, Solid};

pub fn solid() -> Solid {
    // Names are nodes of glTF, objects of 3MF, products of STEP.
    let steel = Color::from_srgb([0.55, 0.58, 0.62]);
    let brass = Color::from_srgb([0.8, 0.65, 0.3]);
    let housing = Solid::tube(20.0, 12.0, 0.0..30.0)
        .named("housing")
        .colored(steel);
    let bush = Solid::tube(12.0, 8.0, 0.0..30.0)
        .named("bush")
        .colored(brass);
    (housing | bush).named("bearing") & Solid::half_space([0.0, -1.0, 0.0], 0.0)
}
