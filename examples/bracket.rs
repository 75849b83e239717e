//! An angle bracket: rounded plates with slots, a rib between them:
//! `cargo run --release --example bracket -- render -o bracket.png`.

use std::process::ExitCode;

use stereotomy::csg::{Join, Path, Profile, Solid};

/// A plate with two slotted holes, standing on the x axis.
fn plate(depth: f64) -> Profile {
    let outline = Profile::rectangle_between([-25.0, 0.0], [25.0, depth - 8.0])
        | Profile::rounded_rectangle([50.0, 30.0], 8.0).translate([0.0, depth - 15.0]);
    let slot = Profile::slot(8.0, 3.0).rotate(90f64.to_radians());
    outline - slot.translate([-14.0, depth - 18.0]) - slot.translate([14.0, depth - 18.0])
}

fn bracket() -> Solid {
    let quarter = 90f64.to_radians();
    let floor = Solid::extrude(&plate(45.0), 0.0..5.0);
    let wall = Solid::extrude(&plate(55.0), -5.0..0.0).rotate_x(quarter);
    // A rib with a hollow of its own shape.
    let rib = Path::from([4.0, 4.0])
        .line_to([36.0, 4.0])
        .arc_to([4.0, 40.0], -0.7)
        .close();
    let hollow = rib.offset(-4.0, Join::Round);
    let rib = Solid::extrude(&(rib - hollow), -3.0..3.0);
    // Its x along y, its y along z.
    let rib = rib.rotate_x(quarter).rotate_z(quarter);
    floor.named("floor") | wall.named("wall") | rib.named("rib")
}

fn main() -> ExitCode {
    cli::run(bracket)
}
