//! SVG files as flat shapes, against closed forms.

use std::f64::consts::PI;

use crate::flat_files::{assert_area, assert_bounds, assert_warns, exact_area, page, volume};
use io::profile::read_svg;
use io::{ProfileOptions, ReadProfile};

fn svg_with(text: &str, options: &ProfileOptions) -> ReadProfile {
    match read_svg(text.as_bytes(), options) {
        Ok(read) => read,
        Err(error) => panic!("{text}: {error}"),
    }
}

fn svg(content: &str) -> ReadProfile {
    svg_with(&page(content), &ProfileOptions::default())
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
        r#"<path d="M30 50a20 10 0 0 1 40 0a20 10 0 0 1-40 0z"/>"#,
        r#"<path d="M30 50A20 10 0 1 0 70 50A20 10 0 1 0 30 50"/>"#,
        r#"<path d="M50 40A20 10 0 0 1 70 50 20 10 0 0 1 50 60 20 10 0 0 1 30 50 20 10 0 0 1 50 40z"/>"#,
        r#"<path transform="translate(50 50) scale(2 1)" d="M-10 0a10 10 0 1 0 20 0a10 10 0 1 0-20 0"/>"#,
        r#"<rect x="30" y="40" width="40" height="20" rx="20" ry="10"/>"#,
        r#"<rect transform="translate(30 40) scale(2 1)" width="20" height="20" rx="10"/>"#,
    ];
    for content in ellipses {
        let read = svg(content);
        assert!(read.warnings.is_empty());
        let found = volume(&read.profile);
        assert!((found - 200.0 * PI).abs() < 1e-9, "{content}: {found}");
    }
    // So do those in each other, and in other contours; not those that cross.
    let half = "a20 10 0 0 1 40 0a20 10 0 0 1-40 0z";
    for (d, wanted) in [
        (
            format!("M30 50{half} M40 50a10 5 0 0 0 20 0a10 5 0 0 0-20 0z"),
            150.0 * PI,
        ),
        (
            format!("M10 20v60h80v-60z M30 50{half}"),
            4800.0 - 200.0 * PI,
        ),
        (
            format!("M0 50{half} M50 50{half} M48 20h4v2h-4z"),
            400.0 * PI + 8.0,
        ),
    ] {
        let read = svg(&format!(r#"<path fill-rule="evenodd" d="{d}"/>"#));
        assert!(read.warnings.is_empty(), "{d}: {:?}", read.warnings);
        let found = volume(&read.profile);
        assert!((found - wanted).abs() < 1e-8, "{d}: {found}");
    }
    let crossing = format!("M30 50{half} M40 50{half}");
    assert_warns(
        &svg(&format!(r#"<path fill-rule="evenodd" d="{crossing}"/>"#)),
        "chords within",
    );
    // What the file's own rule would fill is still told.
    let same_way = format!("M30 50{half} M40 50a10 5 0 0 1 20 0a10 5 0 0 1-20 0z");
    assert_warns(&svg(&format!(r#"<path d="{same_way}"/>"#)), "nonzero");
    // An element with a hole leaves what was before it.
    let read = svg(&format!(
        r#"<rect width="100" height="100"/><path d="M10 20v60h80v-60z M30 50{half}" fill-rule="evenodd"/>"#
    ));
    assert!((volume(&read.profile) - 1e4).abs() < 1e-8);
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
    // 2/3 of the triangle of a parabola's control points.
    let parabola = svg_with(
        &page(r#"<path d="M0 0Q10 20 20 0z"/>"#),
        &ProfileOptions::default(),
    );
    assert_area(&parabola, 400.0 / 3.0, "a parabola");
    // Closed by a side through the middle.
    let two = svg_with(
        &page(r#"<path d="M0 0Q10 20 20 0T40 0z"/>"#),
        &ProfileOptions::default(),
    );
    let area = two.profile.area(1e-5).expect("an area");
    assert!((area - 800.0 / 3.0).abs() < 1e-3, "{area}");
    for (content, wanted) in [
        // 3/5 and 3/20 by Green's theorem.
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
