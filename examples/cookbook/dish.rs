use stereotomy::csg::Solid;

pub fn solid() -> Solid {
    // z = (x² + y²) / 80: its focus is 20 above the bottom.
    let scale = 80f64.sqrt();
    let inside = Solid::paraboloid([scale, scale]);
    let dish = inside.translate([0.0, 0.0, -1.5]) - inside;
    dish & Solid::cylinder(40.0, -5.0..20.0)
}
