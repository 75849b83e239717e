use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    let base = Solid::cuboid_between([0.0, 0.0, 0.0], [60.0, 40.0, 4.0]);
    let fin = Solid::cuboid_between([0.0, 0.0, 4.0], [1.5, 40.0, 25.0]);
    base | fin.linear_pattern(14, [4.5, 0.0, 0.0])
}
