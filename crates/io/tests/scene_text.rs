//! `text` in scenes. The letters themselves are held to OpenSCAD's by the tests
//! of the crate that draws them; these hold what a scene makes of its arguments.
//! They need Debian's `fonts-liberation`.

use csg::{Mesher, Program};
use io::scene::{ReadOptions, Scene, read};

fn scene(arguments: &str, options: &ReadOptions) -> Scene {
    let text = format!("linear_extrude(height = 2) {{ text({arguments}); }}");
    read(&text, options).unwrap_or_else(|e| panic!("{text}: {e}"))
}

fn volume(scene: &Scene) -> f64 {
    let program = Program::lower(&scene.solid).expect("a program");
    let meshed = Mesher::new().mesh(&program).expect("a mesh");
    assert!(meshed.report.is_proven());
    meshed.mesh.volume()
}

const B: &str = "text = \"B\", size = 10, spacing = 1, font = \"Liberation Sans\", direction = \"ltr\", language = \"en\", script = \"Latn\", halign = \"center\", valign = \"center\", $fn = 64, $fa = 12, $fs = 2";

#[test]
fn curves_have_the_chords_of_openscad_or_finer_ones() {
    let faceted = ReadOptions::default().faceted(true);
    // The area that OpenSCAD 2021.01 writes to SVG.
    let wanted = 2.0 * 35.9278;
    let found = volume(&scene(B, &faceted));
    assert!((found / wanted - 1.0).abs() < 1e-5, "{found}, not {wanted}");
    // Two chords a curve at the least.
    // (Holes shrink as well: little of the area changes.)
    let coarse = volume(&scene(&B.replace("$fn = 64", "$fn = 3"), &faceted));
    let share = (coarse / wanted - 1.0).abs();
    assert!(share > 1e-4 && share < 0.05, "{coarse}");
    let smooth = volume(&scene(B, &ReadOptions::default()));
    assert!((smooth / wanted - 1.0).abs() < 1e-3, "{smooth}");
}

#[test]
fn what_is_not_as_asked_is_said() {
    let options = ReadOptions::default();
    let other = scene("text = \"B\", font = \"No Such Font:style=Bold\"", &options);
    let [warning] = &other.warnings[..] else {
        panic!("{:?}", other.warnings)
    };
    assert!(warning.to_string().contains("`No Such Font`"), "{warning}");
    assert!(volume(&other) > 60.0);
    let lacking = scene("text = \"a漢b😀漢\"", &options);
    let [warning] = &lacking.warnings[..] else {
        panic!("{:?}", lacking.warnings)
    };
    let said = warning.to_string();
    let named =
        "the font Liberation Sans has no glyph for '漢' (U+6F22), '😀' (U+1F600), and boxes";
    assert!(said.contains(named), "{said}");
    let many: String = ('\u{4e00}'..'\u{4e0a}').collect();
    let lacking = scene(&format!("text = \"{many}\""), &options);
    assert!(lacking.warnings[0].to_string().contains(" and 2 more"));
    let aligned = scene("text = \"B\", halign = \"middle\"", &options);
    assert!(aligned.warnings[0].to_string().contains("\"middle\""));
    for nothing in ["text = \"\"", "text = \" \"", "text = \"B\", size = 0"] {
        let scene = scene(nothing, &options);
        let program = Program::lower(&scene.solid).expect("a program");
        assert_eq!(program.bounds(), Ok(None), "{nothing}");
    }
    for (arguments, problem) in [
        ("text = 3", "`text` must be a string"),
        ("text = \"B\", size = \"big\"", "a number `size`"),
        ("text = \"B\", direction = \"up\"", "ltr, rtl, ttb or btt"),
    ] {
        let text = format!("text({arguments});");
        let error = read(&text, &options).expect_err(&text).to_string();
        assert!(error.contains(problem), "{error}");
    }
    let missing = ReadOptions::default().font("no/such/file.ttf");
    let error = read("text(text = \"B\");", &missing).expect_err("no file");
    assert!(error.to_string().contains("no/such/file.ttf"), "{error}");
}
