use stereotomy::csg::{Profile, Solid};

pub fn solid() -> Solid {
    let slot = Profile::slot(20.0, 3.0);
    let plate = Profile::rounded_rectangle([50.0, 40.0], 6.0);
    let slots = [-12.0, 0.0, 12.0].map(|y| slot.translate([0.0, y]));
    Solid::extrude(&(plate - Profile::union(slots)), 0.0..5.0)
}
