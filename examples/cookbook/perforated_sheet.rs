use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    // Rows of holes, every other one a half of a step aside.
    let hole = Solid::cylinder(2.0, -1.0..3.0);
    let rows = hole.grid_pattern([10, 4, 1], [6.0, 10.4, 1.0]);
    let sheet = Solid::cuboid_between([-4.0, -4.0, 0.0], [61.0, 40.4, 2.0]);
    sheet - &rows - rows.translate([3.0, 5.2, 0.0])
}
