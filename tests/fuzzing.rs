//! Fuzz targets on stable: whole files, and what chance makes of them. A fault is told with its
//! seed, and its bytes are kept in the folder of temporary files.

use std::panic::catch_unwind;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::ROOT;
use crate::judge::Random;
use stereotomy::csg::{Color, Mesh, Mesher, Program, Solid};
use stereotomy::io;
use stereotomy::io::drawing::{Drawing, DrawingFormat, Section, SectionFrame, write_drawing_to};

#[path = "../crates/fuzz/src/targets.rs"]
mod targets;

/// How long each target runs, unless STEREOTOMY_FUZZ_SECONDS says another time.
const SECONDS: f64 = 1.0;

/// How long the target runs whose turn it is on the day, counted from any other one, that
/// STEREOTOMY_FUZZ_DAY gives: each in its turn, on inputs that no day before had.
const SECONDS_IN_TURN: f64 = 60.0;

/// Of a day at most so many seeds.
const SEEDS_OF_A_DAY: u64 = 1 << 32;

/// Seeds that once found a fault: tried first.
const FOUND: [(&str, u64); 1] = [("raster", 15_269)];

fn small_mesh() -> Mesh {
    let solid = Solid::cube(1.0)
        .named("block")
        .colored(Color::from_srgb([1.0, 0.5, 0.0]))
        | Solid::cuboid([0.5, 0.5, 2.0]).named("post");
    let program = Program::lower(&solid).expect("a program");
    Mesher::new().normals().mesh(&program).expect("a mesh").mesh
}

/// Whole inputs, which chance damages.
fn seeds(name: &str) -> Vec<Vec<u8>> {
    let mesh = small_mesh();
    let mut out = Vec::new();
    let written = match name {
        "stl" => io::stl::write_stl(&mesh, &mut out),
        "ply" => io::ply::write_ply(&mesh, &mut out),
        "off" => io::off::write_off(&mesh, &mut out),
        "obj" => io::obj::write_obj(&mesh, Some("m"), &mut out),
        "glb" => io::gltf::write_glb(&mesh, &mut out),
        "gltf" => io::gltf::write_gltf(&mesh, "m", &mut out, &mut Vec::new()),
        "threemf" => io::threemf::write_3mf(&mesh, &mut out),
        "svg" | "dxf" => {
            // A plate with a hole and an oblique one: lines, arcs and an ellipse.
            let solid = Solid::cuboid([3.0, 2.0, 1.0])
                - Solid::cylinder(0.3, -1.0..1.0)
                - Solid::cylinder(0.3, -2.0..2.0)
                    .rotate_x(0.5)
                    .translate([0.9, 0.0, 0.0]);
            let frame = SectionFrame::facing([0.0; 3], [0.0, 0.0, 1.0]).expect("a plane");
            let section = Section::of(&solid, &frame, &Default::default()).expect("a section");
            let mut drawing = Drawing::default();
            drawing.outlines = section.outlines;
            let format = match name {
                "svg" => DrawingFormat::Svg,
                _ => DrawingFormat::Dxf,
            };
            write_drawing_to(format, &drawing, &Default::default(), &mut out)
        }
        "raster" => {
            // A matrix, two more, vertices and triangles: all of them small numbers.
            out.extend((0..400u32).map(|k| (40 + k * 37 % 200) as u8));
            Ok(())
        }
        _ => {
            let models = Path::new(ROOT).join("models");
            let folders = [models.clone(), models.join("hard")];
            let files = folders
                .iter()
                .flat_map(|folder| std::fs::read_dir(folder).expect("models"))
                .map(|entry| entry.expect("an entry").path());
            let mut files: Vec<_> = files
                .filter(|path| path.extension().is_some_and(|e| e == "csg"))
                .collect();
            files.sort();
            let texts = files
                .iter()
                .map(|path| std::fs::read(path).expect("a model"));
            // (Of large ones what is damaged is not looked at for long.)
            return texts.filter(|text| text.len() < 2000).collect();
        }
    };
    written.expect("written");
    vec![out]
}

/// Text and numbers that matter somewhere.
const TOKENS: [&[u8]; 16] = [
    b"0",
    b"-1",
    b"1e309",
    b"nan",
    b"4294967296",
    b"0.1",
    b"\n",
    b" ",
    b"/",
    b"null",
    b"[]",
    b"{",
    b"}",
    b"\"",
    b"\xff\xff\xff\xff",
    b"\0\0\0\0",
];

fn damage(data: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..=random.below(5) {
        let at = random.below(data.len().max(1));
        let length = random.below(12);
        let end = data.len().min(at + length);
        match random.below(5) {
            0 if at < data.len() => data[at] = random.below(256) as u8,
            1 => {
                let token = TOKENS[random.below(TOKENS.len())];
                data.splice(at..end.max(at), token.iter().copied());
            }
            2 => drop(data.drain(at..end.max(at))),
            3 => {
                let copy = data[at..end.max(at)].to_vec();
                let place = random.below(data.len() + 1);
                data.splice(place..place, copy);
            }
            _ if at < data.len() && data[at].is_ascii_digit() => {
                data[at] = b'0' + random.below(10) as u8;
            }
            _ => {}
        }
    }
}

/// The seeds of a target begin with, and for how many seconds it runs.
fn turn(name: &str, seconds: f64, day: Option<u64>) -> (u64, f64) {
    let is_its_turn = |day: u64| targets::ALL[day as usize % targets::ALL.len()].0 == name;
    match day.filter(|&day| is_its_turn(day)) {
        Some(day) => (day * SEEDS_OF_A_DAY, seconds.max(SECONDS_IN_TURN)),
        None => (0, seconds),
    }
}

fn fuzz(name: &str) {
    let seconds = std::env::var("STEREOTOMY_FUZZ_SECONDS")
        .map_or(SECONDS, |text| text.parse().expect("a number of seconds"));
    let day = std::env::var("STEREOTOMY_FUZZ_DAY").ok();
    let day = day.map(|text| text.parse().expect("the number of a day"));
    let (first, seconds) = turn(name, seconds, day);
    let until = Instant::now() + Duration::from_secs_f64(seconds);
    let seeds = seeds(name);
    let try_seed = |seed: u64| {
        let mut random = Random(seed);
        let whole = seed as usize / 2 % seeds.len();
        let mut data = seeds[whole].clone();
        // Every other one is whole.
        if seed % 2 == 1 {
            damage(&mut data, &mut random);
        }
        if catch_unwind(|| targets::run(name, &data)).is_err() {
            let path = std::env::temp_dir().join(format!("fuzz-{name}-{seed}"));
            std::fs::write(&path, &data).expect("kept");
            panic!("{name}: seed {seed}, in {}", path.display());
        }
    };
    for (_, seed) in FOUND.iter().filter(|(known, _)| *known == name) {
        try_seed(*seed);
    }
    let mut count = 0;
    while count == 0 || Instant::now() < until {
        try_seed(first + count);
        count += 1;
    }
    println!("{name}: {count} inputs from seed {first}");
}

macro_rules! fuzzed {
    ($($name:ident)*) => {
        $(
            #[test]
            fn $name() {
                fuzz(stringify!($name));
            }
        )*

        #[test]
        fn every_target_is_run() {
            assert_eq!(targets::ALL.map(|(name, _)| name), [$(stringify!($name)),*]);
        }
    };
}

#[test]
fn each_day_has_the_turn_of_one_target() {
    let days = targets::ALL.len() as u64;
    for day in 20_000..20_000 + days {
        let turns = targets::ALL.map(|(name, _)| turn(name, 0.5, Some(day)));
        let long = turns
            .iter()
            .filter(|&&(_, seconds)| seconds == SECONDS_IN_TURN);
        assert_eq!(long.count(), 1, "{day}");
        let later = turns.map(|(first, _)| first).into_iter().max();
        assert_eq!(later, Some(day * SEEDS_OF_A_DAY));
    }
    for (name, _) in targets::ALL {
        let of = |day| turn(name, 0.5, Some(day)).1;
        assert_eq!((0..days).filter(|&day| of(day) > 1.0).count(), 1, "{name}");
        assert_eq!(turn(name, 0.5, None), (0, 0.5));
    }
}

fuzzed! { stl ply off obj glb gltf threemf svg dxf scene solid raster }
