use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    // A hyperboloid and one more within.
    let wall = Solid::hyperboloid_one_sheet([12.0, 12.0, 25.0])
        - Solid::hyperboloid_one_sheet([10.5, 10.5, 25.0]);
    wall & Solid::cuboid_between([-40.0, -40.0, -40.0], [40.0, 40.0, 22.0])
}
