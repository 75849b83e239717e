use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    let hole = Solid::cylinder(4.0, -1.0..11.0).translate([30.0, 0.0, 0.0]);
    Solid::cylinder(40.0, 0.0..10.0) - Solid::cylinder(15.0, -1.0..11.0) - hole.polar_pattern(6)
}
