//! Sections as drawings: closed forms, and what an independent program reads of them.

use std::f64::consts::PI;
use std::process::Command;

use crate::python;
use csg::glam::{DVec2, DVec3};
use csg::{BoundaryOptions, LengthUnit, Path, Profile, Solid};
use io::drawing::{
    Drawing, DrawingFormat, DrawingOptions, Outline, Piece, Section, SectionFrame, Shape, View,
    write_drawing, write_drawing_to, write_profile,
};

fn section(solid: &Solid, point: [f64; 3], normal: [f64; 3]) -> Section {
    let frame = SectionFrame::facing(point, normal).expect("a plane");
    Section::of(solid, &frame, &Default::default()).expect("a section")
}

/// What outlines bound, by so many chords of each piece.
fn area(outlines: &[Outline]) -> f64 {
    const CHORDS: u32 = 4000;
    let around = |outline: &Outline| -> f64 {
        let pieces = outline.pieces.iter();
        let points: Vec<DVec2> = pieces
            .flat_map(|piece| (0..CHORDS).map(|k| piece.at(f64::from(k) / f64::from(CHORDS))))
            .collect();
        let next = points.iter().cycle().skip(1);
        0.5 * points
            .iter()
            .zip(next)
            .map(|(a, b)| a.perp_dot(*b))
            .sum::<f64>()
    };
    outlines.iter().map(around).sum()
}

fn shapes(section: &Section) -> Vec<&'static str> {
    let pieces = section.outlines.iter().flat_map(|outline| &outline.pieces);
    let mut names: Vec<&str> = pieces
        .map(|piece| match piece.shape {
            Shape::Line => "line",
            Shape::Ellipse {
                is_circle: true, ..
            } => "circle",
            Shape::Ellipse { .. } => "ellipse",
            _ => "conic",
        })
        .collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Solids with a plane each, and the area in closed form, if that is short.
fn cases() -> Vec<(&'static str, Section, Option<f64>, &'static [&'static str])> {
    let cone = Solid::cone(1.0, 0.0..2.0);
    let bent = |solid: &Solid| {
        solid
            .clone()
            .rotate_xyz(0.4, -0.7, 1.1)
            .translate([3.0, -2.0, 1.0])
    };
    let ball = Solid::sphere(1.0);
    let tilt = [0.0, 1.0, 2.0];
    let drilled = (Solid::cube(1.5) & Solid::sphere(1.0)) - Solid::cylinder(0.5, -2.0..2.0);
    vec![
        (
            "ball",
            section(&ball, [0.0, 0.0, 0.6], [0.0, 0.0, 1.0]),
            Some(PI * 0.64),
            &["circle"],
        ),
        (
            "moved ball",
            section(
                &ball.clone().translate([5.0, 6.0, 7.0]),
                [5.0, 6.0, 7.0],
                [1.0, 2.0, 3.0],
            ),
            Some(PI),
            &["circle"],
        ),
        (
            "cylinder, tilted plane",
            section(&Solid::cylinder(0.5, -3.0..3.0), [0.0; 3], tilt),
            Some(PI * 0.25 * 5.0_f64.sqrt() / 2.0),
            &["ellipse"],
        ),
        // A piece of a parabola is two thirds of the rectangle around it: √3 wide in the base,
        // and ¾ √5 high, up to z = 1.5.
        (
            "cone, along a line of it",
            section(&cone, [0.0, 0.5, 0.0], [0.0, 2.0, 1.0]),
            Some(3.75_f64.sqrt()),
            &["conic", "line"],
        ),
        (
            "cone, along its axis",
            section(&cone, [0.0; 3], [0.0, -1.0, 0.0]),
            Some(2.0),
            &["line"],
        ),
        (
            "cone, beside its axis",
            section(&cone, [0.0, 0.3, 0.0], [0.0, -1.0, 0.0]),
            None,
            &["conic", "line"],
        ),
        (
            "paraboloid",
            section(
                &(Solid::paraboloid([0.8, 1.1]) & Solid::cube(3.0)),
                [0.1, 0.0, 0.0],
                [1.0, 0.0, 0.0],
            ),
            None,
            &["conic", "line"],
        ),
        (
            "hyperboloid",
            section(
                &(Solid::hyperboloid_one_sheet([0.4, 0.6, 0.5]) & Solid::cube(3.0)),
                [0.1, 0.2, 0.0],
                [1.0, 0.3, 0.1],
            ),
            None,
            &["conic", "line"],
        ),
        (
            "bent cone",
            section(&bent(&cone), [3.0, -2.0, 1.6], [0.3, 0.2, 1.0]),
            None,
            &[],
        ),
        (
            "drilled",
            section(&drilled, [0.0, 0.0, 0.1], [0.0, 0.0, 1.0]),
            None,
            &["circle", "line"],
        ),
        (
            "drilled, across",
            section(&bent(&drilled), [3.0, -2.0, 1.1], [1.0, 1.0, 1.0]),
            None,
            &[],
        ),
    ]
}

#[test]
fn sections_have_the_area_of_their_outlines_and_true_shapes() {
    for (name, section, wanted, kinds) in cases() {
        let sum = area(&section.outlines);
        let off = (sum - section.area.value).abs();
        assert!(
            off < 2e-6 * section.area.value,
            "{name}: {sum} {}",
            section.area.value
        );
        if let Some(wanted) = wanted {
            let off = (section.area.value - wanted).abs();
            assert!(off <= section.area.error + 1e-14, "{name}: off by {off:e}");
        }
        if !kinds.is_empty() {
            assert_eq!(shapes(&section), kinds, "{name}");
        }
        for outline in &section.outlines {
            let next = outline.pieces.iter().cycle().skip(1);
            for (piece, next) in outline.pieces.iter().zip(next) {
                assert_eq!(piece.to, next.from, "{name}");
                for (share, end) in [(0.0, piece.from), (1.0, piece.to)] {
                    assert!(piece.at(share).distance(end) < 1e-12, "{name}: {piece:?}");
                }
            }
        }
    }
}

/// The box of an outline is that of its points.
/// Two rods a hair apart are one where surfaces may be moved, which measures count, and polygons where
/// they may not. The area is that of two discs, to the third power of the distance.
#[test]
fn sections_that_nearly_touch_are_within_their_errors() {
    let frame = SectionFrame::facing([0.0, 0.0, 0.3], [0.0, 0.0, 1.0]).expect("a plane");
    let rod = Solid::cylinder(1.0, -1.0..1.0);
    for distance in [1e-9, 1e-10, 1e-11] {
        let both = &rod | rod.translate([distance, 0.0, 0.0]);
        let moved = Section::of(&both, &frame, &BoundaryOptions::new()).expect("a section");
        let as_is = BoundaryOptions::new().most_moved(0.0);
        let polygons = Section::of(&both, &frame, &as_is).expect("a section");
        for section in [&moved, &polygons] {
            let (area, length) = (section.area, section.length);
            let off = (area.value - PI - 2.0 * distance).abs();
            assert!(off <= area.error, "{distance}: {off} {area:?}");
            let off = (length.value - 2.0 * PI - 2.0 * distance).abs();
            assert!(off <= length.error, "{distance}: {off} {length:?}");
            assert_eq!((section.parts, section.outlines.len()), (1, 1));
        }
        // A circle is drawn, off by less than anyone would see.
        assert_eq!(shapes(&moved), ["circle"], "{distance}");
        assert!(moved.moved.is_none() && moved.strays.is_none(), "{moved:?}");
        assert!(moved.area.error < 7.0 * distance, "{:?}", moved.area);
        let strays = polygons.strays.expect("polygons");
        assert!(polygons.area.error < 7.0 * strays, "{:?}", polygons.area);
        let farthest = polygons.outlines[0].pieces.iter();
        let farthest = farthest.map(|piece| (piece.from.length() - 1.0).abs());
        assert!(farthest.fold(0.0, f64::max) <= strays + distance);
    }
}

#[test]
fn boxes_hold_outlines() {
    for (name, section, ..) in cases() {
        for outline in &section.outlines {
            let [low, high] = outline.bounds();
            let mut found = [DVec2::INFINITY, DVec2::NEG_INFINITY];
            for piece in &outline.pieces {
                for k in 0..=1000 {
                    let point = piece.at(f64::from(k) / 1000.0);
                    found = [found[0].min(point), found[1].max(point)];
                }
            }
            assert!(low.cmple(found[0] + 1e-12).all() && high.cmpge(found[1] - 1e-12).all());
            let has_conics = shapes(&section).contains(&"conic");
            let slack = 1e-5 * (high - low).max_element();
            let is_least = found[0].distance(low).max(found[1].distance(high)) < slack;
            assert!(is_least || has_conics, "{name}: {low} {high} {found:?}");
        }
    }
}

#[test]
fn nothing_and_wrong_tolerances_are_errors() {
    let options = DrawingOptions::default();
    let empty = section(&Solid::sphere(1.0), [0.0, 0.0, 2.0], [0.0, 0.0, 1.0]);
    let mut out = Vec::new();
    for format in [DrawingFormat::Svg, DrawingFormat::Dxf, DrawingFormat::Pdf] {
        let error = write_drawing_to(format, &empty.drawing(), &options, &mut out);
        assert!(
            error
                .expect_err("nothing")
                .to_string()
                .contains("does not meet")
        );
        let disk = section(&Solid::sphere(1.0), [0.0; 3], [0.0, 0.0, 1.0]);
        for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let options = options.clone().tolerance(tolerance);
            let error = write_drawing_to(format, &disk.drawing(), &options, &mut out);
            assert!(error.expect_err("a fault").to_string().contains("above 0"));
        }
    }
    assert!(write_drawing("no/such/a.svg", &Drawing::default(), &options).is_err());
    assert!(write_drawing("a.txt", &Drawing::default(), &options).is_err());
    assert_eq!(SectionFrame::facing([0.0; 3], [0.0; 3]), None);
    assert_eq!(SectionFrame::facing([f64::NAN; 3], [0.0, 0.0, 1.0]), None);
}

/// The length of pieces, by so many chords of each.
fn length(pieces: &[Piece]) -> f64 {
    const CHORDS: u32 = 4000;
    let of = |piece: &Piece| -> f64 {
        let at = |k: u32| piece.at(f64::from(k) / f64::from(CHORDS));
        (0..CHORDS).map(|k| at(k).distance(at(k + 1))).sum()
    };
    pieces.iter().map(of).sum()
}

fn view(solid: &Solid, towards_eye: [f64; 3]) -> View {
    let frame = SectionFrame::facing([0.0; 3], towards_eye).expect("a direction");
    View::of(solid, &frame, &Default::default()).expect("a view")
}

/// Lengths of what is seen and hidden, in closed form.
#[test]
fn views_tell_what_is_seen_and_what_is_hidden() {
    let up = [0.0, 0.0, 1.0];
    let front = [0.0, -1.0, 0.0];
    let diagonal = [1.0, -1.0, 1.0];
    let cube = Solid::cube(2.0);
    let bore = Solid::cylinder(0.5, -2.0..2.0);
    let ball = Solid::sphere(1.0);
    // A side of a cube is seen as √(2/3) of its length along a diagonal.
    let side = 2.0 * (2.0f64 / 3.0).sqrt();
    let far = Solid::cube(1.0).translate([0.0, 5.0, 0.0]);
    let near = Solid::cuboid([1.0, 1.0, 1.0]).translate([0.5, 0.0, 0.0]);
    let dome = &ball & Solid::half_space_through([0.0; 3], [0.0, 0.0, -1.0]);
    let post = Solid::cylinder(0.5, 0.0..2.0);
    let plate = Solid::cuboid_between([-2.0, -2.0, -1.0], [2.0, 2.0, 0.0]);
    let slit = Solid::cuboid([0.5, 3.0, 3.0]);
    let round = 2.0 * PI;
    let cases: [(&str, View, f64, f64); 13] = [
        ("a cube from above", view(&cube, up), 8.0, 0.0),
        (
            "a cube along a diagonal",
            view(&cube, diagonal),
            9.0 * side,
            3.0 * side,
        ),
        (
            "a bore from above",
            view(&(&cube - &bore), up),
            8.0 + PI,
            0.0,
        ),
        (
            "a bore from the front",
            view(&(&cube - &bore), front),
            8.0,
            4.0,
        ),
        ("a ball", view(&ball, [0.3, 0.4, 0.5]), round, 0.0),
        (
            "a ball, turned",
            view(
                &ball.rotate_xyz(1.0, 2.0, 3.0).translate([9.0, 8.0, 7.0]),
                [-0.3, 0.4, 0.1],
            ),
            round,
            0.0,
        ),
        ("a cylinder lying", view(&bore, front), 2.0 + 8.0, 0.0),
        ("a dome from the front", view(&dome, front), 2.0 + PI, 0.0),
        (
            "a dome from below",
            view(&dome, [0.0, 0.0, -1.0]),
            round,
            0.0,
        ),
        // Its far end is out of sight.
        (
            "one cube behind another",
            view(&(&far | &near), front),
            6.0,
            1.0,
        ),
        // Of the post's foot a half is hidden by the post itself.
        (
            "a post on a plate",
            view(&(&post | &plate), [0.0, -3f64.sqrt(), 1.0]),
            f64::NAN,
            f64::NAN,
        ),
        (
            "two bores across",
            view(&(&ball - &bore - bore.rotate_x(0.5 * PI)), up),
            f64::NAN,
            f64::NAN,
        ),
        (
            "a ball slit through",
            view(&(&ball - &slit), front),
            f64::NAN,
            f64::NAN,
        ),
    ];
    for (name, view, seen, hidden) in &cases {
        println!("{name}: {} {}", length(&view.visible), length(&view.hidden));
        let near = |found: f64, wanted: f64| wanted.is_nan() || (found - wanted).abs() < 1e-5;
        assert!(
            near(length(&view.visible), *seen),
            "{name}: {}",
            length(&view.visible)
        );
        assert!(
            near(length(&view.hidden), *hidden),
            "{name}: {}",
            length(&view.hidden)
        );
    }
    // The two halves of the ball end in circles seen as lines, and in arcs.
    let (_, slit, ..) = &cases[12];
    let angle = 0.25f64.acos();
    let flat = 4.0 * (1.0f64 - 0.0625).sqrt();
    assert!((length(&slit.visible) - 4.0 * angle - flat).abs() < 1e-5);
    // Three ellipses, two of them in part, and straight lines.
    let (_, post, ..) = &cases[10];
    let is_ellipse = |piece: &&Piece| {
        matches!(
            piece.shape,
            Shape::Ellipse {
                is_circle: false,
                ..
            }
        )
    };
    assert!((2..=3).contains(&post.visible.iter().filter(is_ellipse).count()));
    assert!((1..=2).contains(&post.hidden.iter().filter(is_ellipse).count()));
}

/// Lines of views lie within the shadow that a mesh of the solid throws.
#[test]
fn views_lie_within_the_shadow_of_a_mesh() {
    let bore = Solid::cylinder(0.35, -3.0..3.0);
    let solids = [
        Solid::cube(1.5) & Solid::sphere(1.0),
        Solid::cylinder(1.0, -0.5..0.5) - bore.rotate_x(1.2),
        Solid::cone(1.0, -1.0..1.0) | Solid::cuboid([1.2, 0.5, 0.4]),
        Solid::sphere(1.0) - Solid::sphere(0.8).translate([0.5, 0.3, 0.6]),
        Solid::ellipsoid([1.0, 0.7, 0.4]) | bore.rotate_y(1.0) & Solid::cube(2.5),
        Solid::paraboloid([0.8, 0.8]) & Solid::cuboid([1.9, 2.1, 1.8]),
    ];
    let eyes = [[0.31, -0.87, 0.44], [-0.2, 0.5, -0.9], [1.0, -1.0, 1.0]];
    let mut asked = 0;
    for (k, solid) in solids.iter().enumerate() {
        let program = csg::Program::lower(solid).expect("a program");
        let mesh = csg::Mesher::new()
            .tolerance(1e-3)
            .mesh(&program)
            .expect("a mesh")
            .mesh;
        for eye in eyes {
            let frame = SectionFrame::facing([0.0; 3], eye).expect("a direction");
            let view = View::of(solid, &frame, &Default::default()).expect("a view");
            let is_short = |piece: &&Piece| !matches!(piece.shape, Shape::Cubic { .. });
            for pieces in [&view.visible, &view.hidden] {
                assert!(pieces.iter().filter(is_short).count() < 60, "{k}");
            }
            let flat = |p: DVec3| DVec2::new(p.dot(frame.x), p.dot(frame.y));
            let shadow: Vec<[DVec2; 3]> = (0..mesh.triangles.len())
                .map(|t| mesh.corners(t).map(flat))
                .collect();
            let covers = |point: DVec2, by: f64| {
                shadow.iter().any(|[a, b, c]| {
                    let turn = (*b - *a).perp_dot(*c - *a).signum();
                    [(a, b), (b, c), (c, a)].iter().all(|(from, to)| {
                        let side = **to - **from;
                        turn * side.perp_dot(point - **from) >= by * side.length()
                    })
                })
            };
            for piece in view.visible.iter().chain(&view.hidden) {
                let at = piece.at(0.37);
                let around = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
                let is_near = around.iter().any(|off| covers(at + 4e-3 * *off, -1e-9));
                assert!(is_near, "{k}: {piece:?} beside the solid, from {eye:?}");
                asked += 1;
            }
        }
    }
    assert!(asked > 150, "{asked}");
}

/// Reads drawings: a line for each, the areas of closed outlines added up (holes counted as
/// often as they wind), and the number of faults.
const READER: &str = r#"
import math, sys
import ezdxf
from svgpathtools import svg2paths
def area(points):
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(points, points[1:] + points[:1])) / 2
for line in sys.stdin:
    name = line.rstrip("\n")
    drawing = ezdxf.readfile(name + ".dxf")
    audit = drawing.audit()
    # Lines and arcs end where others begin.
    closed, loose = [], []
    for entity in drawing.modelspace():
        parts = entity.virtual_entities() if entity.dxftype() == "LWPOLYLINE" else [entity]
        for part in parts:
            line = part.dxftype() == "LINE"
            ends = [part.dxf.start, part.dxf.end] if line else part.flattening(1e-7)
            points = [(v.x, v.y) for v in ends]
            whole = math.dist(points[0], points[-1]) < 1e-9
            (closed if whole else loose).append(points)
    while loose:
        chain = loose.pop()
        while math.dist(chain[0], chain[-1]) > 1e-9:
            for k, other in enumerate(loose):
                if math.dist(chain[-1], other[0]) < 1e-9:
                    chain += loose.pop(k)[1:]
                    break
                if math.dist(chain[-1], other[-1]) < 1e-9:
                    chain += loose.pop(k)[::-1][1:]
                    break
            else:
                raise SystemExit(f"{name}: an outline is open")
        closed.append(chain)
    areas = [abs(area(points)) for points in closed]
    paths, _ = svg2paths(name + ".svg")
    svg = []
    for whole in paths:
        for part in whole.continuous_subpaths():
            points = [part.point(k / 4000) for k in range(4000)]
            svg.append(abs(area([(p.real, p.imag) for p in points])))
    print(len(audit.errors) + len(audit.fixes), drawing.units, sum(areas), sum(svg), flush=True)
"#;

/// ezdxf and svgpathtools find the outlines' areas: each of them counted positive, as who reads
/// a piece of an outline alone cannot know that it bounds a hole.
#[test]
fn other_programs_read_the_same() {
    let packages = "ezdxf==1.4.5\nsvgpathtools==1.8.0\n";
    let python = python::python("drawings", packages);
    let folder = tempfile::tempdir().expect("a folder");
    let mut names = String::new();
    let mut wanted = Vec::new();
    for (k, (name, section, ..)) in cases().into_iter().enumerate() {
        let units = [
            (LengthUnit::Millimetre, 4),
            (LengthUnit::Inch, 1),
            (LengthUnit::Metre, 6),
        ];
        let (unit, code) = units[k % units.len()];
        let path = folder.path().join(k.to_string());
        let options = DrawingOptions::default().unit(unit).title(name);
        for extension in ["dxf", "svg", "pdf"] {
            write_drawing(path.with_extension(extension), &section.drawing(), &options)
                .expect("a drawing");
        }
        names += &format!("{}\n", path.display());
        let each = section
            .outlines
            .iter()
            .map(|outline| area(std::slice::from_ref(outline)).abs());
        wanted.push((name, code, each.sum::<f64>()));
    }
    let input = folder.path().join("names");
    std::fs::write(&input, names).expect("a file");
    let output = Command::new(python)
        .args(["-c", READER])
        .stdin(std::fs::File::open(&input).expect("a file"))
        .output()
        .expect("Python runs");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert_eq!(said.lines().count(), wanted.len());
    for (line, (name, code, area)) in said.lines().zip(wanted) {
        let fields: Vec<f64> = line
            .split(' ')
            .map(|f| f.parse().expect("a number"))
            .collect();
        assert_eq!(
            (fields[0], fields[1]),
            (0.0, f64::from(code)),
            "{name}: {line}"
        );
        for found in &fields[2..] {
            assert!((found - area).abs() < 2e-6 * area, "{name}: {line}, {area}");
        }
    }
}

/// Reads views: the number of faults, and how long lines on layers are.
const VIEW_READER: &str = r#"
import math, sys
import ezdxf
for line in sys.stdin:
    drawing = ezdxf.readfile(line.rstrip("\n"))
    audit = drawing.audit()
    lengths = {"VISIBLE": 0.0, "HIDDEN": 0.0}
    texts = []
    for entity in drawing.modelspace():
        layer = entity.dxf.layer
        if entity.dxftype() == "TEXT":
            texts.append(entity.plain_text())
        if layer in lengths:
            is_line = entity.dxftype() == "LINE"
            ends = [entity.dxf.start, entity.dxf.end] if is_line else list(entity.flattening(1e-8))
            lengths[layer] += sum(a.distance(b) for a, b in zip(ends, ends[1:]))
    dashes = drawing.linetypes.get(drawing.layers.get("HIDDEN").dxf.linetype).pattern_tags.tags
    print(len(audit.errors) + len(audit.fixes), lengths["VISIBLE"], lengths["HIDDEN"],
          len(dashes), "|".join(texts), sep="\t", flush=True)
"#;

#[test]
fn views_are_read_by_another_program() {
    let python = python::python("drawings", "ezdxf==1.4.5\nsvgpathtools==1.8.0\n");
    let folder = tempfile::tempdir().expect("a folder");
    let bore = Solid::cylinder(0.5, -2.0..2.0);
    let solids = [
        Solid::cube(2.0) - &bore,
        Solid::cylinder(1.0, -1.0..1.0) - bore.rotate_x(1.2),
        Solid::sphere(1.0) - Solid::sphere(0.5).translate([0.8, 0.0, 0.0]),
    ];
    let mut names = String::new();
    let mut views = Vec::new();
    for (k, solid) in solids.iter().enumerate() {
        for eye in [[0.0, 0.0, 1.0], [1.0, -1.0, 1.0]] {
            let view = view(solid, eye);
            let path = folder.path().join(format!("{}.dxf", views.len()));
            write_drawing(&path, &view.drawing(k == 0), &DrawingOptions::default())
                .expect("a drawing");
            names += &format!("{}\n", path.display());
            views.push(view);
        }
    }
    let input = folder.path().join("names");
    std::fs::write(&input, names).expect("a file");
    let output = Command::new(python)
        .args(["-c", VIEW_READER])
        .stdin(std::fs::File::open(&input).expect("a file"))
        .output()
        .expect("Python runs");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let problem = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{problem}");
    assert_eq!(said.lines().count(), views.len());
    for (line, view) in said.lines().zip(&views) {
        let fields: Vec<&str> = line.split('\t').collect();
        assert_eq!(fields[0], "0", "{line}");
        for (field, pieces) in fields[1..3].iter().zip([&view.visible, &view.hidden]) {
            let found: f64 = field.parse().expect("a number");
            assert!(
                (found - length(pieces)).abs() < 1e-5,
                "{line}: {}",
                length(pieces)
            );
        }
    }
    assert!(
        said.lines()
            .next()
            .is_some_and(|line| line.contains("2 mm|2 mm|")),
        "{said}"
    );
}

/// What is written is read back as the same shape: nothing is in one alone.
#[test]
fn profiles_are_read_back_as_they_were() {
    let folder = tempfile::tempdir().expect("a folder");
    let plate = Profile::rounded_rectangle([60.0, 40.0], 5.0)
        - Profile::circle(3.0).translate([-20.0, 5.0])
        - Profile::polygon([[10.0, 0.0], [22.0, -4.0], [15.0, 9.5]]);
    let arcs = Path::from([0.0, 0.0])
        .arc_to([4.0, 1.0], 2.5)
        .line_to([3.0, 6.0])
        .arc_to([-1.0, 4.0], -1.0)
        .close();
    let islands = Profile::circle(1e-3) | Profile::rectangle([1.0, 2e-3]).translate([2.0, 0.0]);
    let cases = [
        ("plate", plate),
        ("arcs", arcs.clone()),
        ("islands", islands),
        ("moved", arcs.rotate(0.3).scale(1e4).translate([1e5, -1e5])),
    ];
    for (name, profile) in &cases {
        for format in ["svg", "dxf"] {
            let path = folder.path().join(format!("{name}.{format}"));
            let drawn = write_profile(&path, profile, &Default::default()).expect("written");
            assert_eq!(drawn.strays, None, "{name}");
            let area = profile.exact_area().expect("lines and arcs");
            assert!((drawn.area.value - area).abs() <= drawn.area.error);
            let read = io::read_profile_with(&path, &Default::default()).expect("read");
            assert_eq!(read.warnings, [] as [String; 0], "{name}.{format}");
            let far = drawn
                .drawing()
                .bounds()
                .map_or(0.0, |[low, high]| low.abs().max(high.abs()).max_element());
            let low = |profile: &Profile| {
                let bounds = profile.bounds(1e-9 * far).expect("bounds");
                bounds.expect("not empty").0
            };
            // (A page of SVG has its own origin.)
            let moved = match format {
                "svg" => low(profile) - low(&read.profile),
                _ => DVec2::ZERO,
            };
            let read = read.profile.translate(moved);
            let alone = (profile - &read) | (&read - profile);
            let alone = alone.area(1e-9 * far).expect("an area");
            let most = 1e-8 * far * drawn.length.value;
            assert!(
                alone.abs() < most,
                "{name}.{format}: {alone:e}, not {most:e}"
            );
        }
    }
    let ellipse = Profile::ellipse([2.0, 1.0]).rotate(0.5);
    let path = folder.path().join("ellipse.svg");
    let drawn = write_profile(&path, &ellipse, &Default::default()).expect("written");
    assert!((drawn.area.value - 2.0 * PI).abs() <= drawn.area.error);
    for (profile, problem) in [
        (
            Profile::circle(-1.0),
            "ellipse.svg: what is to be drawn is faulty",
        ),
        (Profile::empty(), "the shape has no points"),
    ] {
        let error = write_profile(&path, &profile, &Default::default()).expect_err(problem);
        assert!(error.to_string().contains(problem), "{error}");
    }
}
