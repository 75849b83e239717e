//! Flat shapes from SVG and DXF files: areas and volumes against closed forms.

use std::f64::consts::PI;
use std::fs;

use csg::glam::DVec2;
use csg::{BoundaryOptions, Profile, Program, Solid};
use io::drawing::{DrawingFormat, DrawingOptions, Section, SectionFrame, write_drawing_to};
use io::profile::{read_dxf, read_svg};
use io::scene::{self, read_file};
use io::{Error, ProfileOptions, ReadProfile, read_profile, read_profile_with};
use proptest::prelude::*;
use proptest::sample::Index;

/// A page of 100 mm by 100 mm whose units are millimetres.
pub fn page(content: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
         width=\"100mm\" height=\"100mm\" viewBox=\"0 0 100 100\">{content}</svg>"
    )
}

/// Pairs of group codes and values, in words.
fn pairs(words: &str) -> String {
    words
        .split_whitespace()
        .map(|word| format!("{word}\n"))
        .collect()
}

pub fn dxf_text(blocks: &str, entities: &str) -> String {
    let section =
        |name: &str, content: &str| format!("0\nSECTION\n2\n{name}\n{}0\nENDSEC\n", pairs(content));
    section("BLOCKS", blocks) + &section("ENTITIES", entities) + "0\nEOF\n"
}

pub fn exact_area(profile: &Profile) -> f64 {
    profile.exact_area().expect("lines and arcs")
}

/// Read without a warning, with this area to rounding.
pub fn assert_area(read: &ReadProfile, wanted: f64, what: &str) {
    assert!(read.warnings.is_empty(), "{what}: {:?}", read.warnings);
    let area = exact_area(&read.profile);
    assert!(
        (area - wanted).abs() <= 1e-12 * wanted.max(1.0),
        "{what}: {area}, {wanted}"
    );
}

/// Read with one warning, that says this.
pub fn assert_warns(read: &ReadProfile, says: &str) {
    let warnings = &read.warnings;
    assert!(
        warnings.len() == 1 && warnings[0].contains(says),
        "{says}: {warnings:?}"
    );
}

pub fn assert_bounds(profile: &Profile, low: [f64; 2], high: [f64; 2]) {
    let (min, max) = profile.bounds(1e-7).expect("bounds").expect("points");
    let near = |a: DVec2, b: [f64; 2]| a.abs_diff_eq(DVec2::from_array(b), 1e-6);
    assert!(
        near(min, low) && near(max, high),
        "{min} {max}, {low:?} {high:?}"
    );
}

/// The volume of what is extruded by 1, by its exact boundary.
pub fn volume(profile: &Profile) -> f64 {
    let program = Program::lower(&Solid::extrude(profile, 0.0..1.0)).expect("a program");
    let boundary = program
        .boundary(&BoundaryOptions::new())
        .expect("a boundary");
    boundary.measure().volume.value
}

pub const SQUARE: &str = "0 LINE 8 a 10 0 20 0 11 10 21 0  0 LINE 8 a 10 10 20 10 11 10 21 0
    0 LINE 8 a 10 10 20 10 11 0 21 10  0 LINE 8 a 10 0 20 10 11 0 21 0 ";

#[test]
fn sections_come_back_from_their_files() {
    let plate = Profile::rounded_rectangle([60.0, 40.0], 5.0)
        - Profile::circle(3.0).translate([-20.0, 10.0])
        - Profile::slot(10.0, 2.5).translate([10.0, -3.0])
        - Profile::polygon([[0.0, 5.0], [7.0, 5.0], [3.0, 12.0]]);
    let solid = Solid::extrude(&plate, 0.0..4.0);
    let frame = SectionFrame::facing([0.0, 0.0, 2.0], [0.0, 0.0, 1.0]).expect("a plane");
    let section = Section::of(&solid, &frame, &Default::default()).expect("a section");
    let wanted = exact_area(&plate);
    let mut drawing = io::drawing::Drawing::default();
    drawing.outlines = section.outlines;
    for format in [DrawingFormat::Svg, DrawingFormat::Dxf] {
        let mut file = Vec::new();
        write_drawing_to(format, &drawing, &DrawingOptions::default(), &mut file).expect("written");
        let read = match format {
            DrawingFormat::Svg => read_svg(&file, &ProfileOptions::default()),
            _ => read_dxf(&file, &ProfileOptions::default()),
        };
        let read = read.expect("read");
        assert!(read.warnings.is_empty(), "{format:?}: {:?}", read.warnings);
        let area = exact_area(&read.profile);
        assert!(
            (area / wanted - 1.0).abs() < 1e-9,
            "{format:?}: {area}, {wanted}"
        );
    }
}

/// Circles are written as thirds, whose centre does not depend on the last digit of their ends,
/// and come back as circles: of the corners of what is read there are two, as far apart as can be.
#[test]
fn circles_of_sections_come_back_as_circles() {
    for (center, radius) in [([0.0, 0.0], 7.0), ([20.0 / 7.0, -31.0 / 3.0], 10.0 / 9.0)] {
        let bore = Profile::circle(radius).translate(center);
        let solid = Solid::extrude(&(Profile::rectangle([60.0, 60.0]) - bore.clone()), 0.0..4.0);
        let frame = SectionFrame::facing([0.0, 0.0, 2.0], [0.0, 0.0, 1.0]).expect("a plane");
        let section = Section::of(&solid, &frame, &Default::default()).expect("a section");
        let mut file = Vec::new();
        let options = DrawingOptions::default();
        write_drawing_to(DrawingFormat::Svg, &section.drawing(), &options, &mut file)
            .expect("written");
        let text = String::from_utf8(file.clone()).expect("text");
        assert_eq!(text.matches('A').count(), 3, "{text}");
        let read = read_svg(&file, &ProfileOptions::default()).expect("read");
        assert!(read.warnings.is_empty(), "{:?}", read.warnings);
        let plate = Solid::extrude(&read.profile, 0.0..4.0);
        let program = Program::lower(&plate).expect("a program");
        let brep = program.boundary(&Default::default()).expect("a boundary");
        // Six planes and one cylinder.
        assert_eq!(brep.faces().len(), 7);
        let wanted = 4.0 * (3600.0 - PI * radius * radius);
        assert!((brep.measure().volume.value - wanted).abs() < 1e-8 * wanted);
    }
}

#[test]
fn scenes_extrude_drawings_exactly() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("written");
        path
    };
    write(
        "plate.svg",
        &page(
            r#"<path id="a" fill-rule="evenodd" d="M10 10h40v20h-40zM20 20a5 5 0 0 1 10 0a5 5 0 0 1 -10 0z"/><circle cx="80" cy="80" r="10"/>"#,
        ),
    );
    write(
        "plate.DXF",
        &dxf_text("", &format!("{SQUARE} 0 CIRCLE 8 b 10 5 20 5 40 3")),
    );
    let common = "convexity = 1, $fn = 0, $fa = 12, $fs = 2, timestamp = 1700000000";
    for (arguments, wanted) in [
        (
            "file = \"plate.svg\", origin = [0, 0], dpi = 72, scale = 1, center = false",
            800.0 + 75.0 * PI,
        ),
        (
            "file = \"plate.svg\", id = \"a\", origin = [0, 0], dpi = 72, scale = 1, center = true",
            800.0 - 25.0 * PI,
        ),
        (
            "file = \"plate.DXF\", layer = \"\", origin = [1, 1], scale = 2, center = false",
            4.0 * (100.0 - 9.0 * PI),
        ),
        (
            "file = \"plate.DXF\", layer = \"b\", origin = [0, 0], scale = 1, center = true",
            9.0 * PI,
        ),
    ] {
        let text = format!("linear_extrude(height = 3) {{ import({arguments}, {common}); }}");
        let path = write("scene.csg", &text);
        let scene = read_file(&path, &scene::ReadOptions::default()).expect(&text);
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        let program = Program::lower(&scene.solid).expect("a program");
        let boundary = program
            .boundary(&BoundaryOptions::new())
            .expect("a boundary");
        let found = boundary.measure().volume;
        let off = (found.value - 3.0 * wanted).abs();
        assert!(
            off <= found.error + 1e-11 * found.value,
            "{arguments}: {found:?}, {wanted}"
        );
    }
    // As OpenSCAD's polygons.
    let faceted = |text: &str, faceted: bool| {
        let path = write("scene.csg", text);
        let options = scene::ReadOptions::default().faceted(faceted);
        let scene = read_file(&path, &options).expect(text);
        let program = Program::lower(&scene.solid).expect("a program");
        let boundary = program
            .boundary(&BoundaryOptions::new())
            .expect("a boundary");
        boundary.measure().volume.value
    };
    let polygon = |n: f64, r: f64| 0.5 * n * r * r * (2.0 * PI / n).sin();
    let text =
        "linear_extrude(height = 1) { import(file = \"plate.DXF\", layer = \"b\", $fn = 8); }";
    for is_faceted in [false, true] {
        let found = faceted(text, is_faceted);
        assert!((found - polygon(8.0, 3.0)).abs() < 1e-12, "{found}");
    }
    // (A circle of SVG has at least 40.)
    let text = "linear_extrude(height = 1) { import(file = \"circle.svg\", $fn = 50); }";
    write("circle.svg", &page(r#"<circle cx="50" cy="50" r="10"/>"#));
    assert!((faceted(text, true) - polygon(50.0, 10.0)).abs() < 1e-12);
    assert!((faceted(text, false) - 100.0 * PI).abs() < 1e-11);
    for (text, says) in [
        (
            "import(file = \"plate.svg\", dpi = 0);",
            "`dpi` must be above 0",
        ),
        (
            "import(file = \"plate.svg\", id = 3);",
            "`id` must be a text",
        ),
        (
            "import(file = \"plate.DXF\", origin = [1]);",
            "`origin` must be [x, y]",
        ),
        ("import(file = \"broken.svg\");", "broken.svg: line 1"),
    ] {
        write("broken.svg", "<svg>");
        let path = write(
            "scene.csg",
            &format!("linear_extrude(height = 1) {{ {text} }}"),
        );
        let error = read_file(&path, &scene::ReadOptions::default()).expect_err(says);
        assert!(error.to_string().contains(says), "{error}");
    }
    let path = write(
        "scene.csg",
        "linear_extrude(height = 1) { import(file = \"plate.svg\", layer = \"x\", scale = 2); }",
    );
    let scene = read_file(&path, &scene::ReadOptions::default()).expect("read");
    let told = scene
        .warnings
        .iter()
        .map(ToString::to_string)
        .collect::<String>();
    assert!(
        told.contains("for .dxf files alone") && told.contains("no element has the layer"),
        "{told}"
    );
}

#[test]
fn files_are_read_by_their_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.SVG");
    fs::write(&path, page("<circle r=\"2\"/>")).expect("written");
    let area = exact_area(&read_profile(&path).expect("read"));
    assert!((area - 4.0 * PI).abs() < 1e-12);
    assert!(matches!(
        read_profile("a.stl"),
        Err(Error::UnknownProfile { .. })
    ));
    let error = read_profile(folder.path().join("b.dxf")).expect_err("no file");
    assert!(error.to_string().contains("cannot read"), "{error}");
    fs::create_dir(folder.path().join("c.dxf")).expect("made");
    let error = read_profile(folder.path().join("c.dxf")).expect_err("a folder");
    assert!(error.to_string().contains("it is a folder"), "{error}");
    let options = ProfileOptions::default().tolerance(0.0);
    assert!(matches!(
        read_profile_with(&path, &options).expect_err("0"),
        Error::InFile { .. }
    ));
    let large = folder.path().join("large.svg");
    let file = fs::File::create(&large).expect("made");
    file.set_len((64 << 20) + 1).expect("grown");
    let error = read_profile(&large).expect_err("large");
    assert!(error.to_string().contains("more than 64 MiB"), "{error}");
}

/// What is likely to matter somewhere.
const TOKENS: [&[u8]; 20] = [
    b"0",
    b"-1",
    b"1e309",
    b"1e30",
    b"nan",
    b"4294967296",
    b"\n",
    b" ",
    b"/>",
    b"\"",
    b"#a",
    b"%",
    b"<use href=\"#a\"/>",
    b"A1 1 0 1 1 3 4",
    b"z",
    b"\n0\nINSERT\n2\ntab\n",
    b"\n42\n1\n",
    b"&a;",
    b"\xff",
    b"\n70\n1\n",
];

fn samples() -> [(Vec<u8>, bool); 2] {
    let svg = page(
        r##"<g id="a" transform="rotate(30) scale(1 2)"><rect width="8" height="6" rx="1"/><ellipse rx="1" ry="2"/></g>
        <use href="#a" x="5"/><path style="fill:none" d="M0 0h1V5q1 1 2 2t1 1C1 2 3 4 5 6s1 2 3 4A5 4 3 0 1 9 9z"/>
        <svg viewBox="0 0 1 1"><polygon points="1,2 3,4 5,7"/></svg>"##,
    );
    let dxf = dxf_text(
        "0 BLOCK 2 tab 10 1 20 1 0 LWPOLYLINE 8 x 70 1 10 1 20 1 10 3 20 1 42 1 10 3 20 3 10 1 20 3 0 ENDBLK",
        &format!("{SQUARE} 0 INSERT 2 tab 10 0 20 0 50 30 41 2 0 ELLIPSE 10 5 20 5 11 3 21 4 40 0.5
            0 POLYLINE 66 1 70 1 0 VERTEX 10 0 20 0 42 1 0 VERTEX 10 4 20 0 0 SEQEND 0 ARC 10 5 20 5 40 3 50 0 51 90
            0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 1 41 1 41 .5 41 1 10 0 20 0 10 5 20 10 10 10 20 0"),
    );
    [(svg.into_bytes(), true), (dxf.into_bytes(), false)]
}

/// Reads, and asks for what comes out; nothing may panic, and all must be finite.
fn survives(data: &[u8], is_svg: bool) {
    let options = ProfileOptions::default().center(data.len().is_multiple_of(2));
    let read = if is_svg {
        read_svg(data, &options)
    } else {
        read_dxf(data, &options)
    };
    match read {
        Ok(read) => {
            if let Ok(Some((low, high))) = read.profile.bounds(1.0) {
                assert!(low.is_finite() && high.is_finite());
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

#[test]
fn every_truncation_is_survived() {
    for (data, is_svg) in samples() {
        let read = if is_svg {
            read_svg(&data, &Default::default())
        } else {
            read_dxf(&data, &Default::default())
        };
        read.expect("whole");
        (0..data.len()).for_each(|length| survives(&data[..length], is_svg));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn random_damage_is_survived(
        is_svg in any::<bool>(),
        edits in prop::collection::vec((any::<Index>(), any::<u8>(), any::<Index>(), 0..4u8), 1..6),
    ) {
        let [svg, dxf] = samples();
        let mut data = if is_svg { svg.0 } else { dxf.0 };
        for (at, byte, other, action) in edits {
            if data.is_empty() {
                break;
            }
            let at = at.index(data.len());
            match action {
                0 => data[at] = byte,
                1 => {
                    let token = other.get(&TOKENS);
                    let end = data.len().min(at + token.len());
                    data.splice(at..end, token.iter().copied());
                }
                2 => {
                    let end = other.index(data.len() + 1);
                    data.drain(at.min(end)..at.max(end));
                }
                _ => {
                    let end = (at + usize::from(byte)).min(data.len());
                    let copy = data[at..end].to_vec();
                    let place = other.index(data.len() + 1);
                    data.splice(place..place, copy);
                }
            }
        }
        survives(&data, is_svg);
    }
}
