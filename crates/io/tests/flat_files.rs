//! Flat shapes from SVG and DXF files: areas and volumes against closed forms.

use std::f64::consts::{PI, SQRT_2};
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
fn page(content: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
         width=\"100mm\" height=\"100mm\" viewBox=\"0 0 100 100\">{content}</svg>"
    )
}

fn svg_with(text: &str, options: &ProfileOptions) -> ReadProfile {
    match read_svg(text.as_bytes(), options) {
        Ok(read) => read,
        Err(error) => panic!("{text}: {error}"),
    }
}

fn svg(content: &str) -> ReadProfile {
    svg_with(&page(content), &ProfileOptions::default())
}

/// Pairs of group codes and values, in words.
fn pairs(words: &str) -> String {
    words
        .split_whitespace()
        .map(|word| format!("{word}\n"))
        .collect()
}

fn dxf_text(blocks: &str, entities: &str) -> String {
    let section =
        |name: &str, content: &str| format!("0\nSECTION\n2\n{name}\n{}0\nENDSEC\n", pairs(content));
    section("BLOCKS", blocks) + &section("ENTITIES", entities) + "0\nEOF\n"
}

fn dxf_with(text: &str, options: &ProfileOptions) -> ReadProfile {
    match read_dxf(text.as_bytes(), options) {
        Ok(read) => read,
        Err(error) => panic!("{text}: {error}"),
    }
}

fn dxf(entities: &str) -> ReadProfile {
    dxf_with(&dxf_text("", entities), &ProfileOptions::default())
}

fn exact_area(profile: &Profile) -> f64 {
    profile.exact_area().expect("lines and arcs")
}

/// Read without a warning, with this area to rounding.
fn assert_area(read: &ReadProfile, wanted: f64, what: &str) {
    assert!(read.warnings.is_empty(), "{what}: {:?}", read.warnings);
    let area = exact_area(&read.profile);
    assert!(
        (area - wanted).abs() <= 1e-12 * wanted.max(1.0),
        "{what}: {area}, {wanted}"
    );
}

/// Read with one warning, that says this.
fn assert_warns(read: &ReadProfile, says: &str) {
    let warnings = &read.warnings;
    assert!(
        warnings.len() == 1 && warnings[0].contains(says),
        "{says}: {warnings:?}"
    );
}

fn assert_bounds(profile: &Profile, low: [f64; 2], high: [f64; 2]) {
    let (min, max) = profile.bounds(1e-7).expect("bounds").expect("points");
    let near = |a: DVec2, b: [f64; 2]| a.abs_diff_eq(DVec2::from_array(b), 1e-6);
    assert!(
        near(min, low) && near(max, high),
        "{min} {max}, {low:?} {high:?}"
    );
}

/// The volume of what is extruded by 1, by its exact boundary.
fn volume(profile: &Profile) -> f64 {
    let program = Program::lower(&Solid::extrude(profile, 0.0..1.0)).expect("a program");
    let boundary = program
        .boundary(&BoundaryOptions::new())
        .expect("a boundary");
    boundary.measure().volume.value
}

#[test]
fn elements_have_their_areas() {
    for (content, wanted) in [
        (r#"<rect x="10" y="20" width="30" height="40"/>"#, 1200.0),
        (r#"<rect width="50%" height="10%"/>"#, 500.0),
        (r#"<rect width="1in" height="96"/>"#, 96.0 * 96.0),
        (
            r#"<rect width="30" height="40" rx="5"/>"#,
            1200.0 - (4.0 - PI) * 25.0,
        ),
        (r#"<circle cx="50" cy="50" r="7"/>"#, 49.0 * PI),
        (r#"<polygon points="0,0 10,0 10,10"/>"#, 50.0),
        (r#"<polygon points="0 0 3 0 3 3 0 3 0 0"/>"#, 9.0),
        (r#"<polyline points="0,0 10,0 10,10 0,0"/>"#, 50.0),
        (r#"<path d="M0 0h10v10h-10z m2 2h6v6h-6z"/>"#, 64.0),
        (
            r#"<path fill-rule="evenodd" d="M0 0L10 0L10 10L0 10ZM2 2L8 2L8 8L2 8Z"/>"#,
            64.0,
        ),
        (
            r#"<rect width="10" height="10"/><rect x="5" width="10" height="10"/>"#,
            150.0,
        ),
        (
            r#"<rect width="10" height="10"/><circle cx="5" cy="5" r="2"/>"#,
            100.0,
        ),
        ("", 0.0),
        (
            r#"<rect width="0" height="10"/><circle r="0"/><path d=""/>"#,
            0.0,
        ),
    ] {
        let read = svg(content);
        if content.contains("m2 2") {
            // By the rule that the file gives there is no hole.
            assert_warns(&read, "nonzero");
        } else {
            assert!(read.warnings.is_empty(), "{content}: {:?}", read.warnings);
        }
        let area = exact_area(&read.profile);
        assert!(
            (area - wanted).abs() <= 1e-12 * wanted,
            "{content}: {area}, {wanted}"
        );
    }
}

#[test]
fn arcs_of_paths_are_exact_for_every_flag() {
    // A chord of length r √2 spans a quarter of a circle.
    let r = 10.0_f64;
    let quarter = 0.25 * PI * r * r - 0.5 * r * r;
    let rest = PI * r * r - quarter;
    for (large, sweep, wanted) in [(0, 0, quarter), (0, 1, quarter), (1, 0, rest), (1, 1, rest)] {
        for (arc, close) in [("A", "z"), ("a", "z"), ("A", "")] {
            let end = if arc == "A" { "40 50" } else { "10 10" };
            let content =
                format!(r#"<path d="M30 40{arc}10 10 0 {large} {sweep} {end}L30 40{close}"/>"#);
            assert_area(&svg(&content), wanted, &content);
        }
    }
    // Which way they bend.
    let left = svg(r#"<path d="M30 40A10 10 0 0 0 30 60z"/>"#);
    assert_bounds(&left.profile, [20.0, 40.0], [30.0, 60.0]);
    let right = svg(r#"<path d="M30 40A10 10 0 0 1 30 60z"/>"#);
    assert_bounds(&right.profile, [30.0, 40.0], [40.0, 60.0]);
    // Radii that are too small grow; flags may stand without spaces.
    assert_area(
        &svg(r#"<path d="M30 40a1 1 0 0120 0z"/>"#),
        50.0 * PI,
        "small radii",
    );
    // Two halves, however they are rounded, are a circle.
    for decimals in [2, 3, 6, 9, 12] {
        let [x, y, r] = [1.0 / 3.0, 2.0 / 7.0, 10.0 / 7.0].map(|x: f64| x + 20.0);
        let data = format!(
            "M{:.decimals$} {y:.decimals$}A{r:.decimals$} {r:.decimals$} 0 0 1 {:.decimals$} {y:.decimals$}\
             A{r:.decimals$} {r:.decimals$} 0 0 1 {0:.decimals$} {y:.decimals$}Z",
            x + r,
            x - r
        );
        let read = svg(&format!("<path d=\"{data}\"/>"));
        let area = exact_area(&read.profile);
        let off = 2.0 * PI * r * 10.0_f64.powi(-decimals.try_into().unwrap_or(0));
        assert!(
            (area - PI * r * r).abs() < off + 1e-11,
            "{decimals}: {area}"
        );
    }
}

#[test]
fn transforms_nest_and_keep_circles() {
    let circle = r#"<circle cx="1" cy="2" r="3"/>"#;
    for (transform, factor) in [
        ("translate(30)", 1.0),
        ("translate(30, 40) rotate(30)", 1.0),
        ("rotate(77 50 50)", 1.0),
        ("scale(2)", 4.0),
        ("scale(-2 2)", 4.0),
        ("matrix(0 2 -2 0 40 40)", 4.0),
    ] {
        for content in [
            format!("<g transform=\"{transform}\">{circle}</g>"),
            format!("<g transform=\"scale(.5)\"><a><g transform=\"scale(2)\">{circle}</g></a></g>")
                .replace(
                    circle,
                    &circle.replace("<circle", &format!("<circle transform=\"{transform}\"")),
                ),
            format!(
                "<defs>{}</defs><use href=\"#c\" transform=\"{transform}\"/>",
                circle.replace("<circle", "<circle id=\"c\"")
            ),
        ] {
            assert_area(&svg(&content), factor * 9.0 * PI, &content);
        }
        let rounded = format!(r#"<rect transform="{transform}" width="8" height="6" rx="1"/>"#);
        assert_area(&svg(&rounded), factor * (48.0 - 4.0 + PI), &rounded);
    }
    // Whole ellipses stay, too.
    let ellipses = [
        r#"<ellipse cx="50" cy="50" rx="20" ry="10"/>"#,
        r#"<circle transform="translate(50 50) scale(20 10)" r="1"/>"#,
        r#"<circle transform="translate(50 50) skewX(30)" r="14.142135623730951"/>"#,
    ];
    for content in ellipses {
        let read = svg(content);
        assert!(read.warnings.is_empty());
        let found = volume(&read.profile);
        assert!((found - 200.0 * PI).abs() < 1e-9, "{content}: {found}");
    }
    // Arcs do not, within the tolerance.
    for (content, wanted) in [
        (
            r#"<rect transform="scale(2 1)" width="20" height="20" rx="5"/>"#,
            2.0 * (400.0 - 100.0 + 25.0 * PI),
        ),
        (
            r#"<rect width="40" height="20" rx="10" ry="5"/>"#,
            2.0 * (400.0 - 100.0 + 25.0 * PI),
        ),
        (r#"<path d="M40 40A20 10 0 0 1 80 40z"/>"#, 100.0 * PI),
        (
            r#"<path d="M40 40A20 10 90 1 0 60 40 L40 40z"/>"#,
            100.0 * PI,
        ),
        (
            r#"<path transform="scale(2 1)" d="M20 40a10 10 0 0 1 20 0z"/>"#,
            100.0 * PI,
        ),
    ] {
        let options = ProfileOptions::default().tolerance(1e-5);
        let read = svg_with(&page(content), &options);
        assert_warns(&read, "chords within 1.0e-5");
        let area = exact_area(&read.profile);
        assert!(
            (area - wanted).abs() < 1e-5 * 100.0,
            "{content}: {area}, {wanted}"
        );
    }
}

#[test]
fn curves_stray_no_more_than_the_tolerance() {
    for (content, wanted) in [
        // 2/3 of the triangle of a parabola's control points; 3/5 and 3/20 by Green's theorem.
        (r#"<path d="M0 0Q10 20 20 0z"/>"#, 400.0 / 3.0),
        (r#"<path d="M0 0Q10 20 20 0T40 0z"/>"#, 800.0 / 3.0),
        (r#"<path d="M0 0C0 10 10 10 10 0z"/>"#, 60.0),
        (r#"<path d="M0 0c0 10 10 10 10 0s10 -10 10 0z"/>"#, 120.0),
    ] {
        for tolerance in [1e-2, 1e-4] {
            let read = svg_with(
                &page(content),
                &ProfileOptions::default().tolerance(tolerance),
            );
            assert_warns(&read, "chords");
            let area = exact_area(&read.profile);
            assert!(
                (area - wanted).abs() < 90.0 * tolerance,
                "{content}: {area}, {wanted}"
            );
            assert!(
                (area - wanted).abs() > 1e-3 * tolerance,
                "{content}: {area}, {wanted}"
            );
        }
    }
}

#[test]
fn pages_have_the_units_and_the_place_that_openscad_gives_them() {
    let of = |head: &str, dpi: f64| {
        let text =
            format!("<svg {head}><rect x=\"10\" y=\"10\" width=\"20\" height=\"10\"/></svg>");
        svg_with(&text, &ProfileOptions::default().dpi(dpi))
    };
    let inch = 25.4;
    for (head, dpi, scale, height) in [
        (
            r#"width="100mm" height="100mm" viewBox="0 0 100 100""#,
            72.0,
            1.0,
            100.0,
        ),
        (
            r#"width="10cm" height="10cm" viewBox="0 0 100 100""#,
            72.0,
            1.0,
            100.0,
        ),
        (
            r#"width="1in" height="1in" viewBox="0 0 100 100""#,
            72.0,
            0.254,
            inch,
        ),
        (
            r#"width="72pt" height="72pt" viewBox="0 0 100 100""#,
            90.0,
            0.254,
            inch,
        ),
        (
            r#"width="6pc" height="6pc" viewBox="0 0 100 100""#,
            90.0,
            0.254,
            inch,
        ),
        (
            r#"width="96px" height="96px" viewBox="0 0 100 100""#,
            90.0,
            0.254,
            inch,
        ),
        (
            r#"width="72" height="72" viewBox="0 0 100 100""#,
            72.0,
            0.254,
            inch,
        ),
        (
            r#"width="96" height="96" viewBox="0 0 100 100""#,
            96.0,
            0.254,
            inch,
        ),
        (
            r#"viewBox="0 0 100 100""#,
            72.0,
            inch / 72.0,
            100.0 * inch / 72.0,
        ),
        (
            r#"width="100%" height="100%" viewBox="0 0 100 100""#,
            90.0,
            inch / 90.0,
            100.0 * inch / 90.0,
        ),
    ] {
        let read = of(head, dpi);
        assert_area(&read, 200.0 * scale * scale, head);
        let low = [10.0 * scale, height - 20.0 * scale];
        let high = [30.0 * scale, height - 10.0 * scale];
        assert_bounds(&read.profile, low, high);
    }
    // A view box elsewhere, and pages of another shape: as large as fits, in the middle.
    let read = of(
        r#"width="200mm" height="100mm" viewBox="-10 5 100 100""#,
        72.0,
    );
    assert_bounds(&read.profile, [70.0, 85.0], [90.0, 95.0]);
    let read = of(
        r#"width="200mm" height="100mm" viewBox="0 0 100 100" preserveAspectRatio="none""#,
        72.0,
    );
    assert_bounds(&read.profile, [20.0, 80.0], [60.0, 90.0]);
    let read = of(
        r#"width="200mm" height="100mm" viewBox="0 0 100 100" preserveAspectRatio="xMinYMax slice""#,
        72.0,
    );
    assert_bounds(&read.profile, [20.0, 160.0], [60.0, 180.0]);
    let read = of(r#"width="50mm" height="40mm""#, 72.0);
    assert_warns(&read, "without a viewBox");
    assert_bounds(&read.profile, [10.0, 20.0], [30.0, 30.0]);
    let centred = ProfileOptions::default().center(true);
    let read = svg_with(
        &page(r#"<path d="M10 10h20v10h-20z"/><circle cx="60" cy="15" r="10"/>"#),
        &centred,
    );
    assert_bounds(&read.profile, [-30.0, -10.0], [30.0, 10.0]);
    // Inner pages.
    let inner = r##"<svg x="10" y="10" width="20" height="20" viewBox="0 0 1 1"><rect width="1" height="1"/></svg>
        <symbol id="s" viewBox="0 0 2 2"><circle cx="1" cy="1" r="1"/></symbol>
        <use xlink:href="#s" x="50" y="50" width="10" height="10"/>"##;
    let read = svg(inner);
    assert_area(&read, 400.0 + 25.0 * PI, "inner pages");
    assert_bounds(&read.profile, [10.0, 40.0], [60.0, 90.0]);
}

#[test]
fn what_is_hidden_or_not_asked_for_is_left_out() {
    let square = |attributes: &str| format!("<rect width=\"10\" height=\"10\" {attributes}/>");
    for hidden in [
        square("display=\"none\""),
        square("style=\"fill:red; display : none\""),
        square("visibility=\"hidden\""),
        format!("<g style=\"display:none\">{}</g>", square("")),
        format!("<defs>{}</defs>", square("")),
        format!("<clipPath>{}</clipPath>", square("")),
        format!("<symbol>{}</symbol>", square("")),
    ] {
        assert_area(&svg(&hidden), 0.0, &hidden);
    }
    assert_area(
        &svg(&format!(
            "<g visibility=\"hidden\">{}</g>",
            square("visibility=\"visible\"")
        )),
        100.0,
        "shown",
    );
    let layers = page(
        r#"<g inkscape:groupmode="layer" inkscape:label="one"><rect id="a" width="10" height="10"/></g>
        <g inkscape:groupmode="layer" inkscape:label="two" style="display:none">
        <g id="b"><rect width="20" height="10"/></g><rect id="c" y="50" width="30" height="10"/></g>"#,
    );
    let all = ProfileOptions::default();
    for (options, wanted) in [
        (all.clone(), 100.0),
        (all.clone().layer("one"), 100.0),
        (all.clone().layer("two"), 500.0),
        (all.clone().layer(""), 100.0),
        (all.clone().id("a"), 100.0),
        (all.clone().id("b"), 200.0),
        (all.clone().id("c").layer("two"), 300.0),
    ] {
        assert_area(
            &svg_with(&layers, &options),
            wanted,
            &format!("{options:?}"),
        );
    }
    assert_warns(
        &svg_with(&layers, &all.clone().id("a").layer("two")),
        "no element has the id \"a\" and layer \"two\"",
    );
    assert_warns(
        &svg_with(&layers, &all.layer("three")),
        "no element has the layer \"three\"",
    );
}

#[test]
fn what_svg_files_lose_is_told() {
    for (content, says, wanted) in [
        ("<text>a</text>", "`text` is left out", 0.0),
        ("<line x2=\"5\" stroke=\"red\"/>", "it has no area", 0.0),
        (
            "<path d=\"M0 0h10v10\"/>",
            "closed by a straight side",
            50.0,
        ),
        (
            "<path fill=\"none\" d=\"M0 0h10v10\"/>",
            "strokes are passed over",
            0.0,
        ),
        (
            "<use href=\"other.svg#a\"/>",
            "no element of this file",
            0.0,
        ),
        ("<use href=\"#a\"/>", "no element has the id", 0.0),
        (
            "<rect clip-path=\"url(#a)\" width=\"2\" height=\"2\"/>",
            "`clip-path` is passed over",
            4.0,
        ),
        ("<style>.a { display: none }</style>", "style sheets", 0.0),
        (
            "<g transform=\"scale(0 1)\"><rect width=\"2\" height=\"2\"/></g>",
            "no inverse",
            0.0,
        ),
        (
            "<path d=\"M0 0h10v10h-10zM5 5h10v10h-10z\"/>",
            "nonzero",
            150.0,
        ),
    ] {
        let read = svg(content);
        assert_warns(&read, says);
        assert!(
            read.warnings[0].contains("line 1") || says == "nonzero",
            "{:?}",
            read.warnings
        );
        let area = exact_area(&read.profile);
        assert!((area - wanted).abs() < 1e-12, "{content}: {area}");
    }
}

#[test]
fn damaged_svg_is_an_error_with_its_place() {
    let deep = format!("{}{}", "<g>".repeat(100_000), "</g>".repeat(100_000));
    let laughs =
        "<!DOCTYPE svg [<!ENTITY a \"0123456789\"><!ENTITY b \"&a;&a;&a;&a;\">]><svg/>".to_owned();
    let many = format!(
        "<!DOCTYPE svg [<!ENTITY a \"{}\">]><svg>{}</svg>",
        "a".repeat(10_000),
        "<g id=\"&a;\"/>".repeat(1000)
    );
    assert!(read_svg(laughs.as_bytes(), &ProfileOptions::default()).is_ok());
    let copies: String = (0..40)
        .map(|k| {
            format!(
                "<g id=\"a{}\">{}</g>",
                k + 1,
                format!("<use href=\"#a{k}\"/>").repeat(2)
            )
        })
        .collect();
    for (text, says) in [
        (String::new(), "not XML"),
        ("<svg>".to_owned(), "line 1"),
        ("<g/>".to_owned(), "an `svg` element"),
        (
            page("\n<path d=\"M0 0 L5\"/>"),
            "line 2, <path>: its path data",
        ),
        (
            page("<path id=\"a\" d=\"L5 5\"/>"),
            "<path id=\"a\">: its path data",
        ),
        (page("<rect width=\"a\" height=\"1\"/>"), "its width, \"a\""),
        (
            page("<rect width=\"-1\" height=\"1\"/>"),
            "its width is negative",
        ),
        (
            page("<rect width=\"1em\" height=\"1\"/>"),
            "a unit of fonts",
        ),
        (page("<polygon points=\"1 2 3\"/>"), "has no y"),
        (page("<g transform=\"turn(3)\"/>"), "its transform"),
        ("<svg viewBox=\"0 0 0 1\"/>".to_owned(), "its viewBox"),
        (page(&deep), "deep"),
        (many, "256 MiB"),
        (
            page("<g id=\"a\"><use href=\"#a\"/></g>"),
            "a copy of what it is in",
        ),
        (
            page("<g id=\"a\"><use href=\"#b\"/></g><g id=\"b\"><use href=\"#a\"/></g>"),
            "a copy of what it is in",
        ),
        (
            page(&format!(
                "<rect id=\"a0\" width=\"1\" height=\"1\"/>{copies}"
            )),
            "copies included",
        ),
        (page("<circle r=\"1e200\"/>"), "too large"),
    ] {
        let error = read_svg(text.as_bytes(), &ProfileOptions::default()).expect_err(says);
        assert!(error.to_string().contains(says), "{says}: {error}");
    }
    let error = read_svg(b"<svg>\n\xff</svg>", &ProfileOptions::default()).expect_err("no text");
    assert!(
        error.to_string().contains("line 2: the text is not UTF-8"),
        "{error}"
    );
}

const SQUARE: &str = "0 LINE 8 a 10 0 20 0 11 10 21 0  0 LINE 8 a 10 10 20 10 11 10 21 0
    0 LINE 8 a 10 10 20 10 11 0 21 10  0 LINE 8 a 10 0 20 10 11 0 21 0 ";

#[test]
fn entities_have_their_areas() {
    let bulge = SQRT_2 - 1.0;
    for (entities, wanted) in [
        (SQUARE.to_owned(), 100.0),
        ("0 CIRCLE 10 5 20 5 40 3".to_owned(), 9.0 * PI),
        (format!("{SQUARE} 0 CIRCLE 10 5 20 5 40 3"), 100.0 - 9.0 * PI),
        ("0 ARC 10 5 20 5 40 3 50 0 51 180 0 LINE 10 2 20 5 11 8 21 5".to_owned(), 4.5 * PI),
        ("0 ARC 10 5 20 5 40 3 50 90 51 0 0 LINE 10 5 20 5 11 8 21 5 0 LINE 10 5 20 5 11 5 21 8".to_owned(), 6.75 * PI),
        ("0 ARC 10 5 20 5 40 3 50 -30 51 330".to_owned(), 9.0 * PI),
        ("0 LWPOLYLINE 90 3 70 1 10 0 20 0 10 4 20 0 10 4 20 4".to_owned(), 8.0),
        ("0 LWPOLYLINE 90 4 70 0 10 0 20 0 10 4 20 0 10 4 20 4 10 0 20 0".to_owned(), 8.0),
        ("0 LWPOLYLINE 90 2 70 1 10 0 20 0 42 1 10 4 20 0 42 1".to_owned(), 4.0 * PI),
        ("0 LWPOLYLINE 90 2 70 1 10 0 20 0 42 -1 10 4 20 0 42 0".to_owned(), 2.0 * PI),
        (format!("0 LWPOLYLINE 70 1 10 1 20 0 10 9 20 0 42 {bulge} 10 10 20 1 10 10 20 9 42 {bulge} 10 9 20 10
            10 1 20 10 42 {bulge} 10 0 20 9 10 0 20 1 42 {bulge}"), 96.0 + PI),
        ("0 POLYLINE 66 1 70 1 0 VERTEX 10 0 20 0 42 1 0 VERTEX 10 4 20 0 0 SEQEND".to_owned(), 2.0 * PI),
        // Seen from below.
        ("0 LWPOLYLINE 230 -1 90 2 70 1 10 0 20 0 42 -1 10 4 20 0 42 0".to_owned(), 2.0 * PI),
        ("0 ELLIPSE 10 5 20 5 11 3 21 0 40 1".to_owned(), 9.0 * PI),
        ("0 ELLIPSE 10 5 20 5 11 0 21 3 40 1 41 0 42 3.141592653589793 0 LINE 10 5 20 2 11 5 21 8".to_owned(), 4.5 * PI),
        // A polygon of degree 1.
        ("0 SPLINE 70 8 71 1 40 0 40 0 40 1 40 2 40 3 40 3 10 0 20 0 10 4 20 0 10 4 20 4 10 0 20 0".to_owned(), 8.0),
        (String::new(), 0.0),
    ] {
        assert_area(&dxf(&entities), wanted, &entities);
    }
    let below = dxf(
        "0 ARC 230 -1 10 5 20 5 40 3 50 0 51 90 0 LINE 10 -5 20 5 11 -8 21 5 0 LINE 10 -5 20 5 11 -5 21 8",
    );
    assert_area(&below, 2.25 * PI, "below");
    assert_bounds(&below.profile, [-8.0, 5.0], [-5.0, 8.0]);
    for (entities, wanted) in [
        ("0 ELLIPSE 10 5 20 5 11 3 21 4 40 0.5 41 0 42 6.283185307179586", 12.5 * PI),
        ("0 ELLIPSE 10 5 20 5 11 4 21 0 40 0.5 41 0 42 3.141592653589793 0 LINE 10 1 20 5 11 9 21 5", 4.0 * PI),
        // A parabola, and half a circle as a rational spline.
        ("0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 0 20 0 10 5 20 10 10 10 20 0 0 LINE 10 0 20 0 11 10 21 0", 100.0 / 3.0),
        ("0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 2 40 2 40 2 41 1 41 0.70710678118654757 41 1 41 0.70710678118654757 41 1
            10 5 20 0 10 5 20 5 10 0 20 5 10 -5 20 5 10 -5 20 0 0 LINE 10 5 20 0 11 -5 21 0", 12.5 * PI),
        // Two cubic spans with a knot between; the area is that of Cox and de Boor's basis.
        ("0 SPLINE 71 3 40 0 40 0 40 0 40 0 40 1 40 2 40 2 40 2 40 2 10 0 20 0 10 0 20 10 10 5 20 10 10 10 20 10 10 10 20 0
            0 LINE 10 0 20 0 11 10 21 0", 87.5),
    ] {
        let read = dxf_with(&dxf_text("", entities), &ProfileOptions::default().tolerance(1e-6));
        assert_warns(&read, "chords within 1.0e-6");
        let area = exact_area(&read.profile);
        assert!((area - wanted).abs() < 4e-5, "{entities}: {area}, {wanted}");
    }
}

#[test]
fn blocks_are_put_where_they_are_inserted() {
    let blocks = "0 BLOCK 2 tab 10 1 20 1 0 LWPOLYLINE 8 x 70 1 10 1 20 1 10 3 20 1 42 1 10 3 20 3 10 1 20 3 0 ENDBLK
        0 BLOCK 2 pair 10 0 20 0 0 INSERT 2 tab 10 0 20 0 0 INSERT 2 tab 10 10 20 0 50 90 0 ENDBLK";
    let one = 4.0 + 0.5 * PI;
    for (entities, wanted, low, high) in [
        ("0 INSERT 2 tab 10 0 20 0", one, [0.0, 0.0], [3.0, 2.0]),
        (
            "0 INSERT 2 tab 10 5 20 5 50 90",
            one,
            [3.0, 5.0],
            [5.0, 8.0],
        ),
        (
            "0 INSERT 2 tab 10 0 20 0 41 2 42 2",
            4.0 * one,
            [0.0, 0.0],
            [6.0, 4.0],
        ),
        (
            "0 INSERT 2 tab 10 0 20 0 41 -2 42 2",
            4.0 * one,
            [-6.0, 0.0],
            [0.0, 4.0],
        ),
        (
            "0 INSERT 2 tab 10 0 20 0 230 -1",
            one,
            [-3.0, 0.0],
            [0.0, 2.0],
        ),
        (
            "0 INSERT 2 tab 10 0 20 0 70 3 44 10 71 2 45 20",
            6.0 * one,
            [0.0, 0.0],
            [23.0, 22.0],
        ),
        (
            "0 INSERT 2 tab 10 0 20 0 50 90 70 3 44 10 71 2 45 20",
            6.0 * one,
            [-22.0, 0.0],
            [0.0, 23.0],
        ),
        (
            "0 INSERT 2 pair 10 1 20 1",
            2.0 * one,
            [1.0, 1.0],
            [11.0, 4.0],
        ),
    ] {
        let read = dxf_with(&dxf_text(blocks, entities), &ProfileOptions::default());
        assert_area(&read, wanted, entities);
        assert_bounds(&read.profile, low, high);
    }
    let read = dxf_with(
        &dxf_text(blocks, "0 INSERT 2 none 10 0 20 0"),
        &ProfileOptions::default(),
    );
    assert_warns(&read, "there is no block \"none\"");
    let cycle = "0 BLOCK 2 a 0 INSERT 2 b 0 ENDBLK 0 BLOCK 2 b 0 INSERT 2 a 0 ENDBLK";
    let error = read_dxf(
        dxf_text(cycle, "0 INSERT 2 a").as_bytes(),
        &ProfileOptions::default(),
    );
    assert!(
        error
            .expect_err("a cycle")
            .to_string()
            .contains("does it insert itself?")
    );
    let many = dxf_text(blocks, "0 INSERT 2 tab 70 30000 71 30000 44 9 45 9");
    let error = read_dxf(many.as_bytes(), &ProfileOptions::default());
    assert!(
        error
            .expect_err("many")
            .to_string()
            .contains("copies included")
    );
}

#[test]
fn layers_origins_and_scales_are_openscads() {
    let text = dxf_text("", &format!("{SQUARE} 0 CIRCLE 8 b 10 5 20 5 40 3"));
    let all = ProfileOptions::default();
    for (options, wanted) in [
        (all.clone(), 100.0 - 9.0 * PI),
        (all.clone().layer("a"), 100.0),
        (all.clone().layer("b"), 9.0 * PI),
        (
            all.clone().layer("b").scale(2.0).origin([5.0, 5.0]),
            36.0 * PI,
        ),
    ] {
        assert_area(&dxf_with(&text, &options), wanted, &format!("{options:?}"));
    }
    let moved = dxf_with(&text, &all.clone().origin([1.0, 2.0]).scale(3.0));
    assert_bounds(&moved.profile, [-3.0, -6.0], [27.0, 24.0]);
    let centred = dxf_with(&text, &all.clone().center(true));
    assert_bounds(&centred.profile, [-5.0, -5.0], [5.0, 5.0]);
    assert_warns(
        &dxf_with(&text, &all.layer("c")),
        "nothing is on layer \"c\"; there are a, b",
    );
}

#[test]
fn what_does_not_meet_is_joined_or_told() {
    // Ends that are 1e-5 apart, of a drawing of 10.
    let torn = SQUARE.replace("11 10 21 0  0", "11 9.99999 21 0  0");
    let read = dxf(&torn);
    assert_warns(
        &read,
        "1 ends that do not meet are joined; the farthest are 1.000e-5 apart",
    );
    assert!((exact_area(&read.profile) - 100.0).abs() < 1e-4);
    // A side that is not there.
    let three = SQUARE
        .split("0 LINE")
        .take(4)
        .collect::<Vec<_>>()
        .join("0 LINE");
    let read = dxf(&three);
    assert_warns(
        &read,
        "1 contours are open, and closed by straight sides; the widest gap is 10, from (0, ",
    );
    assert!((exact_area(&read.profile) - 100.0).abs() < 1e-12);
    let read = dxf(&format!("{SQUARE} 0 LINE 10 20 20 0 11 30 21 0"));
    assert_warns(&read, "1 lines that meet no other are left out");
    let read = dxf(&format!("{SQUARE} {SQUARE}"));
    assert_warns(&read, "4 lines or contours are drawn twice");
    assert!((exact_area(&read.profile) - 100.0).abs() < 1e-12);
    // Squares that meet in a corner.
    let both = format!(
        "{SQUARE} {}",
        SQUARE
            .replace("10 0 20 0 11 10 21 0", "10 10 20 10 11 20 21 10")
            .replace("10 10 20 10 11 10 21 0", "10 20 20 20 11 20 21 10")
            .replace("10 10 20 10 11 0 21 10", "10 20 20 20 11 10 21 20")
            .replace("10 0 20 10 11 0 21 0", "10 10 20 20 11 10 21 10")
    );
    assert_area(&dxf(&both), 200.0, "two squares");
    for (entities, says) in [
        (
            "0 TEXT 10 0 20 0 1 a 0 TEXT 10 0 20 0",
            "and 1 more: TEXT is left out",
        ),
        ("0 CIRCLE 67 1 10 0 20 0 40 1", "on paper"),
        (
            "0 CIRCLE 210 1 230 0 10 0 20 0 40 1",
            "not in the drawing's plane",
        ),
        (
            "0 SPLINE 71 3 11 0 21 0 11 1 21 0",
            "without control points",
        ),
        ("0 POLYLINE 70 64 0 VERTEX 10 0 20 0 0 SEQEND", "of a mesh"),
    ] {
        assert_warns(&dxf(entities), says);
    }
    assert!(
        dxf("0 CIRCLE 60 1 10 0 20 0 40 1 0 TEXT 60 1")
            .warnings
            .is_empty()
    );
}

#[test]
fn damaged_dxf_is_an_error_with_its_line() {
    let whole = dxf_text("", SQUARE);
    for (text, says) in [
        (String::new(), "no section ENTITIES"),
        ("AutoCAD Binary DXF\r\n".to_owned(), "save it as text"),
        ("solid cube".to_owned(), "no value"),
        (
            "solid\ncube".to_owned(),
            "line 1: \"solid\" is not a group code",
        ),
        ("5\n1\n".to_owned(), "group 0 should be here, not 5"),
        (whole.replace("0\nENDSEC\n0\nEOF\n", ""), "does not end"),
        (
            whole.replacen("11\n10\n", "11\nten\n", 1),
            "line 20: \"ten\" is not a number",
        ),
        (
            whole.replacen("11\n10\n", "", 1),
            "line 12: LINE has no end",
        ),
        (dxf_text("", "0 CIRCLE 10 0 20 0 40 -1"), "its radius is -1"),
        (
            dxf_text("", "0 POLYLINE 0 LINE"),
            "no SEQEND before \"LINE\"",
        ),
        (dxf_text("", "0 SPLINE 71 3 10 0 20 0"), "need 5 knots"),
        (dxf_text("", "0 SPLINE 71 99 10 0 20 0"), "from 1 to 15"),
        (dxf_text("", "0 LINE 10 0 20 0 11 1e200 21 0"), "too large"),
        (dxf_text("", "0 LINE 10 0 20 0 11 nan 21 0"), "not a number"),
    ] {
        let error = read_dxf(text.as_bytes(), &ProfileOptions::default()).expect_err(says);
        assert!(error.to_string().contains(says), "{says}: {error}");
    }
}

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
