use stereotomy::csg::{Profile, Solid};

pub fn solid() -> Solid {
    // A quarter of a ring, and straight ends: revolved, and extruded.
    let wall = Profile::circle(6.0) - Profile::circle(4.5);
    let bend = Solid::revolve_by(&wall.translate([20.0, 0.0]), 90f64.to_radians());
    let end = Solid::extrude(&wall, 0.0..25.0);
    let down = end.rotate_x_degrees(90.0).translate([20.0, 0.0, 0.0]);
    let left = end.rotate_y_degrees(-90.0).translate([0.0, 20.0, 0.0]);
    bend | down | left
}
