//! Letters against those that OpenSCAD 2021.01 draws with the same fonts
//! (Debian's `fonts-liberation`, which these tests need), as it writes them to
//! SVG with six digits.

use std::ops::Range;

use csg::brep::Bounded;
use csg::glam::{DAffine3, DVec2, DVec3};
use csg::{BoundaryOptions, Program, Solid};
use text::{Curves, Font, HorizontalAlign, Text, TextError, VerticalAlign};

/// Area, and the least and greatest coordinates.
type Measure = [f64; 5];

fn measure(text: &Text, font: &str) -> Measure {
    let font = Font::find(font).unwrap_or_else(|e| panic!("{e}"));
    let profile = text.profile(&font).unwrap_or_else(|e| panic!("{e}"));
    let (min, max) = profile.bounds(1.0).expect("bounds").expect("letters");
    let area = profile.area(1.0).expect("an area");
    [area, min.x, min.y, max.x, max.y]
}

#[test]
fn letters_are_those_of_openscad() {
    use HorizontalAlign::{Center, Left, Right};
    use VerticalAlign::{Baseline, Bottom, Top};
    let text = |written: &str, chords: usize, horizontal, vertical| {
        Text::new(written)
            .metrics(1000.0 / 1024.0)
            .curves(Curves::Chords(chords))
            .horizontal(horizontal)
            .vertical(vertical)
    };
    let middle = VerticalAlign::Center;
    let cases: [(&str, Text, Measure); 9] = [
        (
            "Liberation Sans",
            text("B", 9, Center, middle),
            [35.9278, -3.38403, -4.66562, 4.00745, 4.88916],
        ),
        (
            "Liberation Sans:style=bold",
            text("Y", 4, Center, middle).size(22.0),
            [139.946, -9.42928, -10.2644, 9.93532, 10.7562],
        ),
        (
            "",
            text("BAg", 4, Right, Top).spacing(1.2),
            [94.5138, -29.6246, -12.2132, -2.22321, 0.223541],
        ),
        // A ligature.
        (
            "",
            text("office", 4, Left, Bottom),
            [103.586, 0.583191, 0.00189209, 31.7369, 10.2009],
        ),
        // Kerned.
        (
            "",
            text("AVATAR To", 3, Center, Baseline).size(7.0),
            [98.1128, -23.812, -0.0949097, 23.5492, 6.68835],
        ),
        (
            "",
            text("abc", 4, Left, Baseline).direction("rtl"),
            [69.0946, 0.589996, -0.13559, 22.0488, 10.0634],
        ),
        (
            "Liberation Serif:style=Italic",
            text("quick, brown", 3, Left, Top).size(3.5),
            [20.0904, 0.161377, -4.32918, 24.4673, 0.0782928],
        ),
        (
            "Liberation Mono:style=Bold Italic",
            text("0O8&@", 13, Right, Bottom),
            [199.581, -39.9237, -0.0440979, 0.37114, 11.9384],
        ),
        (
            "",
            text("Grüße", 4, Left, Baseline).language("de"),
            [120.736, 0.698486, -0.13559, 38.0018, 10.0634],
        ),
    ];
    for (font, text, wanted) in cases {
        let found = measure(&text, font);
        let digits = |value: f64| 1e-5 * value.abs() + 2e-5;
        for (found, wanted) in found.into_iter().zip(wanted) {
            let off = (found - wanted).abs();
            assert!(off < digits(wanted), "{text:?}: {found}, not {wanted}");
        }
    }
}

#[test]
fn finer_chords_come_nearer_by_the_square() {
    let area = |share| measure(&Text::new("Sco8").curves(Curves::Within(share)), "")[0];
    let best = area(1e-7);
    let off = [1e-2, 1e-3, 1e-4].map(|share| (area(share) - best).abs() / best);
    // A tenth of the tolerance: about a tenth of what is cut off.
    assert!(
        off[0] < 0.03 && off[1] < 0.2 * off[0] && off[2] < 0.2 * off[1],
        "{off:?}"
    );
    // No chord strays further than the tolerance says.
    let [_, min_x, min_y, max_x, max_y] = measure(&Text::new("O").curves(Curves::Within(1e-7)), "");
    let [_, a, b, c, d] = measure(&Text::new("O").curves(Curves::Within(1e-3)), "");
    let strays = DVec2::new(a - min_x, b - min_y).max(DVec2::new(max_x - c, max_y - d));
    assert!(strays.max_element() <= 1e-2, "{strays}");
}

#[test]
fn size_and_metrics_scale_what_they_say() {
    let text = || Text::new("Text").curves(Curves::Within(1e-3));
    let [area, min_x, _, max_x, _] = measure(&text(), "");
    let [double, low, _, high, _] = measure(&text().size(20.0), "");
    assert!((double / area - 4.0).abs() < 1e-12);
    assert!(((high - low) / (max_x - min_x) - 2.0).abs() < 1e-12);
    // Letters keep their size, only their distance grows.
    let [same, low, _, high, _] = measure(&text().metrics(1.5), "");
    assert!((same / area - 1.0).abs() < 1e-12 && high - low > 1.2 * (max_x - min_x));
}

/// Most joints of letters are tangent, many of them to the second order; strokes of some overlap, and
/// many a curve is nearly straight.
#[test]
fn letters_are_solids_within_parabolic_cylinders() {
    let font = Font::find("").unwrap_or_else(|e| panic!("{e}"));
    let written = ('!'..='~').chain("äçéñßØÅęþ½µΩαζбж€@".chars());
    let written: Vec<char> = written.collect();
    for letters in written.chunks(3) {
        let letters: String = letters.iter().collect();
        let text = Text::new(letters.as_str());
        let profile = text
            .profile(&font)
            .unwrap_or_else(|e| panic!("{letters}: {e}"));
        let solid = Solid::extrude(&profile, 0.0..2.0);
        assert_eq!(solid.strays(), None, "{letters}");
        let solid = solid.rotate_x(0.3).rotate_z(1.1);
        let program = Program::lower(&solid).unwrap_or_else(|e| panic!("{letters}: {e}"));
        let boundary = program.boundary(&BoundaryOptions::default());
        let boundary = boundary.unwrap_or_else(|e| panic!("{letters}: {e}"));
        assert_eq!(boundary.moved(), None, "{letters}");
        let volume = boundary.measure().volume;
        assert!(volume.error < 1e-6, "{letters}: {volume:?}");
        // Chords cut off, or add, no more than their distance times what they are beside.
        let area = profile.area(1e-6).expect("an area");
        let off = (volume.value - 2.0 * area).abs();
        assert!(off < 1e-4, "{letters}: {volume:?}, not {}", 2.0 * area);
    }
}

/// The volume of an exact boundary, nothing of which was moved.
fn volume(solid: &Solid, case: &str) -> Bounded {
    let program = Program::lower(solid).unwrap_or_else(|e| panic!("{case}: {e}"));
    let boundary = program.boundary(&BoundaryOptions::new().most_moved(0.0));
    let boundary = boundary.unwrap_or_else(|e| panic!("{case}: {e}"));
    boundary.measure().volume
}

/// Upright and facing along x, its middle there, between two distances from the z axis.
fn raised(text: Text, font: &str, distances: Range<f64>) -> Solid {
    let font = Font::find(font).unwrap_or_else(|e| panic!("{e}"));
    let text = text
        .horizontal(HorizontalAlign::Center)
        .vertical(VerticalAlign::Center);
    let profile = text.profile(&font).unwrap_or_else(|e| panic!("{e}"));
    let raised = Solid::extrude(&profile, distances);
    raised.rotate_x_degrees(90.0).rotate_z_degrees(90.0)
}

/// What two solids are together and have in common is what they are apart.
#[track_caller]
fn assert_add_up(one: &Solid, other: &Solid, case: &str) {
    let of = |solid: &Solid| volume(solid, case);
    let [apart, both] = [
        [of(one), of(other)],
        [of(&(one | other)), of(&(one & other))],
    ];
    let error: f64 = apart.iter().chain(&both).map(|v| v.error).sum();
    let off = both[0].value + both[1].value - apart[0].value - apart[1].value;
    assert!(off.abs() <= error && error < 1e-6, "{case}: {off}, {error}");
}

/// As inscriptions are: most of their curves are of degree four, and meet where parabolas of one
/// letter do.
#[test]
fn letters_on_round_bodies_add_up() {
    let bodies = [
        (Solid::cylinder(10.0, -7.0..7.0), 10.0, 4.0),
        (Solid::sphere(12.5), 12.5, 5.0),
        (Solid::frustum(8.0, 6.4, -7.0..7.0), 7.2, 3.0),
    ];
    for (k, letter) in ('!'..='~').enumerate() {
        let (body, radius, size) = &bodies[k % 3];
        let text = Text::new(letter).size(*size);
        let raised = raised(text, "", radius - 1.4..radius + 0.6);
        assert_add_up(body, &raised, &letter.to_string());
    }
}

/// Joints where a stroke turns back, parabolas nearly straight or nearly one, and contacts beside
/// crossings.
#[test]
fn letters_of_other_fonts_on_round_bodies_add_up() {
    let rod = Solid::cylinder(8.0, -7.0..7.0);
    let [wide, narrow] = [8.0, 6.0].map(|radius| Solid::frustum(radius, 0.8 * radius, -7.0..7.0));
    for (body, written, font, size, from) in [
        (&rod, "iB", "Liberation Serif", 4.0, 7.1),
        (&wide, "v", "Liberation Mono", 2.0, 6.6),
        (&wide, "d", "Liberation Mono", 2.0, 7.1),
        (&narrow, "?", "Liberation Serif:style=Italic", 5.0, 4.6),
    ] {
        let raised = raised(Text::new(written).size(size), font, from..from + 2.0);
        assert_add_up(body, &raised, written);
    }
}

/// All their cones and planes have one tip.
#[test]
fn letters_are_drawn_in() {
    let font = Font::find("").unwrap_or_else(|e| panic!("{e}"));
    let written: Vec<char> = ('!'..='~').collect();
    for letters in written.chunks(2) {
        let letters: String = letters.iter().collect();
        let profile = Text::new(letters.as_str()).profile(&font);
        let profile = profile.unwrap_or_else(|e| panic!("{letters}: {e}"));
        let [straight, drawn] = [1.0, 0.5].map(|scale| {
            volume(
                &Solid::extrude_scaled(&profile, 0.0..3.0, [scale; 2]),
                &letters,
            )
        });
        let off = (drawn.value - straight.value * 1.75 / 3.0).abs();
        let error = drawn.error + straight.error;
        assert!(
            off <= error && error < 1e-5,
            "{letters}: {drawn:?} of {straight:?}"
        );
    }
}

/// As what is cut is: parabolas of a few sides, as formulas of half-planes, and of many.
#[test]
fn sections_of_letters_are_their_profiles() {
    let written: Vec<char> = ('!'..='~').collect();
    for (name, count) in [
        ("", 2),
        ("Liberation Sans:style=Bold", 1),
        ("Liberation Serif:style=Italic", 1),
    ] {
        let font = Font::find(name).unwrap_or_else(|e| panic!("{e}"));
        for letters in written.chunks(count) {
            let letters: String = letters.iter().collect();
            let profile = Text::new(letters.as_str()).profile(&font);
            let profile = profile.unwrap_or_else(|e| panic!("{letters}: {e}"));
            let solid = Solid::extrude(&profile, 0.0..1.0);
            let frame = DAffine3::from_translation(DVec3::new(0.0, 0.0, 0.37));
            let section = solid.exact_section(frame, &BoundaryOptions::default());
            let section = section.unwrap_or_else(|e| panic!("{letters}: {e}"));
            let section = section.unwrap_or_else(|| panic!("{name}, {letters}: not exact"));
            let [cut, whole] = [&section, &profile].map(|p| p.area(1e-5).expect("an area"));
            assert!(
                (cut - whole).abs() < 2e-3,
                "{name}, {letters}: {cut}, not {whole}"
            );
        }
    }
}

#[test]
fn characters_without_a_glyph_are_told() {
    let font = Font::find("").unwrap_or_else(|e| panic!("{e}"));
    let missing = |written: &str| Text::new(written).missing(&font).expect("shaped");
    assert_eq!(missing("Écart: ½ µm, Ω"), []);
    assert_eq!(missing("a漢b😀漢"), ['漢', '😀']);
    // Ligatures, marks, and what is not drawn.
    assert_eq!(missing("fi e\u{301} a\u{ad}b\u{200b}"), []);
    // From right to left in the order of the text.
    let arabic = Text::new("漢😀").direction("rtl");
    assert_eq!(arabic.missing(&font).expect("shaped"), ['漢', '😀']);
    assert!(Text::new("a").direction("up").missing(&font).is_err());
}

#[test]
fn mistakes_are_named() {
    let font = Font::find("").unwrap_or_else(|e| panic!("{e}"));
    let says = |text: Text| text.profile(&font).expect_err("a mistake").to_string();
    assert!(says(Text::new("a").size(-1.0)).contains("the size is -1"));
    assert!(says(Text::new("a").size(f64::NAN)).contains("the size is NaN"));
    assert!(says(Text::new("a").spacing(0.0)).contains("the spacing"));
    assert!(says(Text::new("a").direction("up")).contains("ltr, rtl, ttb or btt"));
    let tolerance = Text::new("a").curves(Curves::Within(0.0)).profile(&font);
    assert!(matches!(tolerance, Err(TextError::NotPositive { .. })));
    // Nothing is written: no error, and no points.
    let nothing = Text::new(" ").profile(&font).expect("a space");
    assert_eq!(nothing.bounds(1.0), Ok(None));
}
