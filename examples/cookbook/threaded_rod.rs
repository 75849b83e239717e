use stereotomy::csg::{Screw, Solid};

pub fn solid() -> Solid {
    let screw = Screw::metric(10.0).expect("M10 is in the table");
    Solid::threaded_rod(Screw { steps: 12, ..screw }, 12.0)
}
