use stereotomy::csg::{Profile, Solid, Twist};

pub fn solid() -> Solid {
    // A square, turned by a quarter on its way up.
    let twist = Twist {
        radians: 90f64.to_radians(),
        scale: [0.8, 0.8].into(),
        steps: 24,
    };
    Solid::extrude_in_steps(
        &Profile::rounded_rectangle([30.0, 30.0], 5.0),
        0.0..60.0,
        twist,
    )
}
