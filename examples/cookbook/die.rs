use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    let cube = Solid::rounded_cuboid([20.0; 3], 3.0);
    let pip = |x: f64, y: f64| Solid::sphere(2.2).translate([x, y, 10.5]);
    let one = pip(0.0, 0.0);
    let two = pip(-5.0, -5.0) | pip(5.0, 5.0);
    let three = &one | &two;
    cube - one - two.rotate_x_degrees(90.0) - three.rotate_y_degrees(90.0)
}
