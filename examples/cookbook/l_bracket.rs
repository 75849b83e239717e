use stereotomy::csg::{Path, Solid};

pub fn solid() -> Solid {
    // An outline of lines and arcs: the inner corner is round.
    let outline = Path::from([0.0, 0.0])
        .line_to([40.0, 0.0])
        .line_to([40.0, 5.0])
        .line_to([13.0, 5.0])
        .arc_to([5.0, 13.0], -90f64.to_radians())
        .line_to([5.0, 40.0])
        .line_to([0.0, 40.0])
        .close();
    let bracket = Solid::extrude(&outline, 0.0..25.0).rotate_x_degrees(90.0);
    let hole = Solid::cylinder(3.0, -1.0..6.0).translate([28.0, -12.5, 0.0]);
    let other = Solid::cylinder(3.0, -1.0..6.0)
        .rotate_y_degrees(90.0)
        .translate([0.0, -12.5, 28.0]);
    bracket - hole - other
}
