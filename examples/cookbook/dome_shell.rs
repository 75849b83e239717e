use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    let shell = Solid::sphere(30.0) - Solid::sphere(27.0);
    let window = Solid::cylinder(5.0, 0.0..40.0).rotate_x_degrees(60.0);
    (shell - window.polar_pattern(8)) - Solid::half_space([0.0, 0.0, 1.0], 0.0)
}
