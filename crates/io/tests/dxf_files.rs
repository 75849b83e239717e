//! DXF files as flat shapes, against closed forms.

use std::f64::consts::{PI, SQRT_2};

use crate::flat_files::{
    SQUARE, assert_area, assert_bounds, assert_warns, dxf_text, exact_area, volume,
};
use io::profile::read_dxf;
use io::{ProfileOptions, ReadProfile};

fn dxf_with(text: &str, options: &ProfileOptions) -> ReadProfile {
    match read_dxf(text.as_bytes(), options) {
        Ok(read) => read,
        Err(error) => panic!("{text}: {error}"),
    }
}

fn dxf(entities: &str) -> ReadProfile {
    dxf_with(&dxf_text("", entities), &ProfileOptions::default())
}

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
    let parabola = dxf(
        "0 SPLINE 71 2 40 0 40 0 40 0 40 1 40 1 40 1 10 0 20 0 10 5 20 10 10 10 20 0 0 LINE 10 0 20 0 11 10 21 0",
    );
    assert_area(&parabola, 100.0 / 3.0, "a parabola");
    for (entities, wanted) in [
        ("0 ELLIPSE 10 5 20 5 11 3 21 4 40 0.5 41 0 42 3.141592653589793 0 LINE 10 8 20 9 11 2 21 1", 6.25 * PI),
        ("0 ELLIPSE 10 5 20 5 11 4 21 0 40 0.5 41 0 42 3.141592653589793 0 LINE 10 1 20 5 11 9 21 5", 4.0 * PI),
        // Half a circle as a rational spline.
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
        (dxf_text("", "0 CIRCLE 10 0 20 0 40 1e200"), "too large"),
        (dxf_text("", "0 LINE 10 0 20 0 11 nan 21 0"), "not a number"),
    ] {
        let error = read_dxf(text.as_bytes(), &ProfileOptions::default()).expect_err(says);
        assert!(error.to_string().contains(says), "{says}: {error}");
    }
}

#[test]
fn whole_ellipses_that_cross_nothing_are_exact() {
    let ellipse = |x: f64, long: f64| format!("0 ELLIPSE 10 {x} 20 5 11 {long} 21 0 40 0.5 ");
    let half = |from: f64, to: f64| ellipse(0.0, 4.0) + &format!("41 {from} 42 {to} ");
    let halves = half(0.5, PI) + &half(PI, 2.0 * PI + 0.5);
    let area = |long: f64| 0.5 * PI * long * long;
    let square = "0 LWPOLYLINE 70 1 10 -20 20 -20 10 20 20 -20 10 20 20 20 10 -20 20 20 ";
    let small = "0 CIRCLE 10 0 20 5 40 0.25 ";
    let slit = "0 LWPOLYLINE 70 1 10 -1 20 4.5 10 1 20 4.5 10 1 20 4.75 10 -1 20 4.75 ";
    let round = PI / 16.0;
    for (entities, wanted) in [
        (ellipse(0.0, 4.0), area(4.0)),
        (halves, area(4.0)),
        (ellipse(0.0, 4.0) + &ellipse(10.0, 4.0), 2.0 * area(4.0)),
        (
            ellipse(0.0, 4.0) + &ellipse(0.0, 2.0),
            area(4.0) - area(2.0),
        ),
        (
            ellipse(0.0, 2.0) + &ellipse(0.0, 4.0),
            area(4.0) - area(2.0),
        ),
        (square.to_owned() + &ellipse(0.0, 4.0), 1600.0 - area(4.0)),
        (
            ellipse(0.0, 4.0) + square + small,
            1600.0 - area(4.0) + round,
        ),
        (
            small.to_owned()
                + &ellipse(0.0, 2.0)
                + &ellipse(10.0, 4.0)
                + &ellipse(0.0, 4.0)
                + square
                + slit,
            1600.0 - 2.0 * area(4.0) + area(2.0) - round - 0.5,
        ),
    ] {
        let read = dxf(&entities);
        assert!(read.warnings.is_empty(), "{entities}: {:?}", read.warnings);
        let found = volume(&read.profile);
        assert!(
            (found - wanted).abs() < 1e-9,
            "{entities}: {found}, {wanted}"
        );
    }
    // What crosses others is cut.
    let read = dxf(&(ellipse(0.0, 4.0) + &ellipse(1.0, 4.0)));
    assert_warns(&read, "chords");
}
