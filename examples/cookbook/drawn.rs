use stereotomy::csg::Solid;
use stereotomy::io::drawing::{DrawingOptions, Section, SectionFrame, View, write_drawing};

pub fn solid() -> Solid {
    let bore = Solid::cylinder(5.0, -21.0..21.0);
    Solid::cuboid([40.0, 30.0, 20.0]) - &bore - bore.rotate_y_degrees(90.0)
}

/// What is seen from the front, with sizes, and a section in the middle.
pub fn run() -> Result<(), Box<dyn std::error::Error>> {
    let front = SectionFrame::facing([0.0; 3], [0.0, -1.0, 0.0]).ok_or("no direction")?;
    let options = DrawingOptions::default();
    let view = View::of(&solid(), &front, &Default::default())?;
    write_drawing("front.svg", &view.drawing(true), &options)?;
    let section = Section::of(&solid(), &front, &Default::default())?;
    write_drawing("section.dxf", &section.drawing(), &options)?;
    Ok(())
}
