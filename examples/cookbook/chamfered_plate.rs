use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    let plate = Solid::chamfered_cuboid([60.0, 40.0, 10.0], 2.0);
    // Holes have chamfers, too: a cone at each end.
    let chamfer = Solid::frustum(5.0, 3.0, -0.01..2.01);
    let hole = Solid::cylinder(3.0, -6.0..6.0)
        | chamfer.translate([0.0, 0.0, -5.0])
        | chamfer.rotate_x_degrees(180.0).translate([0.0, 0.0, 5.0]);
    plate
        - hole
            .grid_pattern([2, 2, 1], [36.0, 20.0, 1.0])
            .translate([-18.0, -10.0, 0.0])
}
