use stereotomy::csg::{Solid, glam::DVec3};

pub fn solid() -> Solid {
    // The hull of balls at any points: here of a wedge.
    let corners = [
        [0, 0, 0],
        [30, 0, 0],
        [30, 20, 0],
        [0, 20, 0],
        [0, 0, 18],
        [0, 20, 18],
    ];
    let centers = corners.map(|corner| DVec3::from_array(corner.map(f64::from)));
    Solid::hull_of_balls(&centers, 3.0).expect("points that are not in one plane")
}
