use stereotomy::csg::{Gear, Solid};

pub fn solid() -> Solid {
    let gear = Gear::new(2.0, 20);
    Solid::extrude(&gear.profile(), 0.0..12.0) - Solid::cylinder(6.0, -1.0..13.0)
}
