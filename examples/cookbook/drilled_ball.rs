use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    let bore = Solid::infinite_cylinder(5.0);
    let across = bore.rotate_x_degrees(90.0) | bore.rotate_y_degrees(90.0);
    (Solid::cube(30.0) & Solid::sphere(20.0)) - bore - across
}
