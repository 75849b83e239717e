use stereotomy::csg::{Profile, Solid};
use stereotomy::text::{Font, HorizontalAlign, Text};

pub fn solid() -> Solid {
    let font = Font::find("Liberation Sans:style=Bold").expect("the font is installed");
    let label = Text::new("CSG")
        .size(14.0)
        .horizontal(HorizontalAlign::Center);
    let letters = label.profile(&font).expect("the letters are in the font");
    let plate = Profile::rounded_rectangle([52.0, 26.0], 4.0).translate([0.0, 7.0]);
    Solid::extrude(&plate, 0.0..3.0) | Solid::extrude(&letters, 3.0..5.0)
}
