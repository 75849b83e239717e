use stereotomy::csg::{Solid, glam::DVec3};

pub fn solid() -> Solid {
    let (outer, wall) = (DVec3::new(60.0, 40.0, 25.0), 2.0);
    // The room within is smaller by the wall, but open above.
    let room = outer - DVec3::new(2.0 * wall, 2.0 * wall, 0.0);
    Solid::rounded_cuboid(outer, 3.0)
        - Solid::cuboid(room).translate([0.0, 0.0, wall])
        - Solid::half_space_through([0.0, 0.0, 10.0], [0.0, 0.0, -1.0])
}
