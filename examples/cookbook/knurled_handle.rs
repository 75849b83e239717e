use stereotomy::csg::{Profile, Solid};

pub fn solid() -> Solid {
    let grip = Solid::extrude(&Profile::knurled(11.0, 24), 0.0..40.0);
    // Its ends are cut off by a cone each.
    let ends = Solid::frustum(9.0, 29.0, 0.0..20.0) & Solid::cylinder(40.0, -1.0..20.0)
        | Solid::frustum(29.0, 9.0, 20.0..40.0);
    (grip & ends) | Solid::cylinder(6.0, -10.0..50.0)
}
