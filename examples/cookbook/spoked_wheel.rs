use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    let rim = Solid::tube(40.0, 34.0, -5.0..5.0);
    let hub = Solid::cylinder(10.0, -8.0..8.0);
    let spoke = Solid::elliptic_cylinder([3.0, 1.5], 0.0..36.0).rotate_y_degrees(90.0);
    (rim | hub | spoke.polar_pattern(5)) - Solid::cylinder(4.0, -9.0..9.0)
}
