use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    // Corners and edges of radius 4.
    Solid::rounded_cuboid([40.0, 30.0, 20.0], 4.0)
}
