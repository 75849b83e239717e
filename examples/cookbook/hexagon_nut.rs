use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    let nut = Solid::regular_prism(6, 10.0, 0.0..8.0);
    // A ball takes the corners off.
    let ball = Solid::sphere(10.2).translate([0.0, 0.0, 4.0]);
    (nut & ball) - Solid::cylinder(5.0, -1.0..9.0)
}
