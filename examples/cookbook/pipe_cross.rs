use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    // What is hollow is taken out of the whole, not of each pipe.
    let pipes = |radius: f64, half: f64| {
        let pipe = Solid::cylinder(radius, -half..half);
        &pipe | pipe.rotate_x_degrees(90.0) | pipe.rotate_y_degrees(90.0)
    };
    pipes(10.0, 30.0) - pipes(8.0, 31.0)
}
