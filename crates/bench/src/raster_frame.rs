//! How long does a frame take, the first one of a process and a steady one?
//!
//! `raster-frame [--level portable|avx2|avx512] [--msaa 0|4|8] [--look] [--stats]
//! [--size 1920x1080] [--seconds 2] [--png FOLDER] [--llvmpipe PYTHON] [--euc]
//! [m1 m2 m3 m4 S2 S4 ...]`; threads by `RAYON_NUM_THREADS`, and by
//! `LP_NUM_THREADS` for llvmpipe. Prints the first, the best and the median of
//! the frames drawn within two seconds, or other `--seconds` (with 0 the first
//! alone; of the first subject only that is a cold one); with the path
//! of a Python that has moderngl and numpy, llvmpipe's beside it; and those of
//! the crate euc, which runs on one thread and has no multisampling.
//! With `--look` our frames have edges, occlusion and a shadow as well.
//!
//! m1 and m2 are icospheres of 82 thousand and 1.3 million triangles, m3 a
//! cube of a thousand spheres, m4 a cube that fills the picture, S2 and S4
//! meshes of our own of the reference scenes (S4 at level 3).

#[cfg(target_os = "linux")]
#[path = "../../cli/src/huge_pages.rs"]
mod huge_pages;

use std::time::{Duration, Instant};

use bench::{euc_peer, llvmpipe, meshes};
use cpu_time::ProcessTime;
use csg::Mesh;
use glam::{DVec3, Vec3};
use raster::{
    AntiAliasing, Camera, EdgeOptions, Image, Lens, Level, Light, Prepared, RenderOptions,
    Renderer, View,
};

/// The allocator of the `csg` command, for all that runs in this process.
#[cfg(target_os = "linux")]
#[global_allocator]
static ALLOCATOR: huge_pages::HugePages = huge_pages::HugePages;

/// A named mesh, and where it is seen from.
fn subject(name: &str, size: (u32, u32)) -> Option<(Mesh, View)> {
    let mesh = match name {
        "m1" => meshes::icosphere(6),
        "m2" => meshes::icosphere(8),
        "m3" => meshes::sphere_grid(10, 3),
        "m4" => meshes::cube(),
        "S2" => meshes::drilled(),
        "S4" => meshes::sponge(),
        _ => return None,
    };
    let eye = match name {
        "m4" => DVec3::new(0.0, 0.0, 1.3),
        "m3" => DVec3::new(1.9, 2.3, 2.9),
        "S2" => DVec3::new(0.8, 1.1, 1.7),
        "S4" => DVec3::new(1.4, 1.8, 2.4),
        _ => DVec3::new(0.0, 0.0, 2.2),
    };
    let camera = Camera {
        eye,
        target: DVec3::ZERO,
        up: DVec3::Y,
        lens: Lens::Perspective {
            fov_y: 60f64.to_radians(),
        },
        near: 0.1,
        far: 100.0,
    };
    Some((mesh, camera.view(size.0, size.1).ok()?))
}

fn main() {
    let mut names = Vec::new();
    let mut level = Level::best();
    let mut options = RenderOptions::default();
    let (mut stats, mut euc, mut folder, mut python) = (false, false, None, None);
    let (mut size, mut seconds) = ((1920, 1080), 2.0);
    let mut samples = 0;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--level" => {
                let wanted = arguments.next();
                let found = Level::all()
                    .iter()
                    .find(|level| Some(level.name()) == wanted.as_deref());
                level = *found.expect("a level this machine has");
            }
            "--msaa" => {
                (options.anti_aliasing, samples) = match arguments.next().as_deref() {
                    Some("4") => (AntiAliasing::Msaa4, 4),
                    Some("8") => (AntiAliasing::Msaa8, 8),
                    _ => (AntiAliasing::None, 0),
                }
            }
            "--look" => {
                options.edges = Some(EdgeOptions::default());
                options.ambient_occlusion = true;
                options.ground_shadow = true;
            }
            "--size" => {
                let given = arguments.next().unwrap_or_default();
                let sides = given.split_once('x');
                let sides = sides.and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
                size = sides.expect("a size like 1920x1080");
            }
            "--seconds" => {
                let given = arguments.next().and_then(|given| given.parse().ok());
                seconds = given.expect("a number of seconds");
            }
            "--stats" => stats = true,
            "--euc" => euc = true,
            "--llvmpipe" => python = arguments.next(),
            "--png" => folder = arguments.next(),
            name => names.push(name.to_owned()),
        }
    }
    if names.is_empty() {
        names = ["m1", "m2", "m3", "m4", "S2", "S4"]
            .map(str::to_owned)
            .to_vec();
    }
    options.lights = vec![
        Light::Ambient {
            intensity: Vec3::splat(0.1),
        },
        Light::Directional {
            towards: DVec3::new(1.0, 1.0, 1.0),
            intensity: Vec3::splat(0.9),
        },
    ];
    println!(
        "{} threads, {}, {:?}",
        rayon::current_num_threads(),
        level.name(),
        options.anti_aliasing
    );
    for name in names {
        let Some((mesh, view)) = subject(&name, size) else {
            eprintln!("no subject {name}");
            continue;
        };
        let prepared = Instant::now();
        let scene = Prepared::new(&mesh);
        let prepared = prepared.elapsed();
        let mut renderer = Renderer::with_level(level);
        let mut image = Image::default();
        let mut times = Vec::new();
        let (begun, cpu) = (Instant::now(), ProcessTime::now());
        let mut counts = None;
        // The first touches its memory for the first time, as a process does that
        // draws no more than one.
        let mut first = None;
        let span = Duration::from_secs_f64(seconds);
        while times.is_empty() || begun.elapsed() < span {
            let start = Instant::now();
            let drawn = renderer.draw(&scene, &view, size.0, size.1, &options, &mut image);
            times.push(start.elapsed());
            first.get_or_insert((start.elapsed(), cpu.elapsed()));
            counts = Some(drawn.expect("a picture"));
        }
        let cpu = cpu.elapsed() / times.len() as u32;
        let first = first.unwrap_or_default();
        times.sort();
        let ms = |t: Duration| t.as_secs_f64() * 1e3;
        println!(
            "{name}: {} triangles, prepared in {:.1} ms; first frame {:.2} ms, processor time {:.2} \
             ms; best {:.2} ms, median {:.2} ms of {}, processor time {:.2} ms",
            mesh.triangles.len(),
            ms(prepared),
            ms(first.0),
            ms(first.1),
            ms(times[0]),
            ms(times[times.len() / 2]),
            times.len(),
            ms(cpu),
        );
        if let (true, Some(counts)) = (stats, counts) {
            print!("{counts}");
        }
        let indexed = if euc || python.is_some() {
            meshes::indexed(&mesh)
        } else {
            meshes::Indexed::default()
        };
        if euc {
            let frames = 12;
            let (mut theirs, pixels) = euc_peer::draw(&indexed, &view, size, Vec3::ONE, frames);
            theirs.sort();
            let alike = |(a, b): &(&u32, &[u8; 4])| {
                let near = |(a, b): (&u8, &u8)| a.abs_diff(*b) <= 1;
                a.to_le_bytes().iter().zip(b.iter()).all(near)
            };
            let same = pixels.iter().zip(&image.pixels).filter(alike).count();
            println!(
                "    euc: frame best {:.2} ms, median {:.2} ms of {frames}; {} pixels differ",
                ms(theirs[0]),
                ms(theirs[theirs.len() / 2]),
                pixels.len() - same,
            );
        }
        if let Some(python) = &python {
            let frames = 10;
            match llvmpipe::draw(python, &indexed, &view, size, DVec3::ONE, samples, frames) {
                Ok(mut theirs) => {
                    theirs.times.sort();
                    println!(
                        "    llvmpipe: frame best {:.2} ms, median {:.2} ms of {frames}, \
                         processor time {:.2} ms",
                        ms(theirs.times[0]),
                        ms(theirs.times[theirs.times.len() / 2]),
                        ms(theirs.processor),
                    );
                }
                Err(error) => eprintln!("    llvmpipe: {error}"),
            }
        }
        if let Some(folder) = &folder {
            let file = image.to_png().expect("an encoded picture");
            std::fs::write(format!("{folder}/{name}.png"), file).expect("a written picture");
        }
    }
}
