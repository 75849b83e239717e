//! Pixels held against Mesa's software rasteriser (llvmpipe).
//!
//! Switched on by STEREOTOMY_MESA=1, which asks for Python 3 and the Debian
//! packages libegl1, libgl1, libgl1-mesa-dri and libgles2; off, the test says
//! so and does nothing.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{common, environment};
use csg::Mesh;
use glam::{DMat4, DVec3, Vec3};
use raster::{Camera, Image, Lens, Light, Material, Prepared, RenderOptions, Renderer, View};

const WIDTH: u32 = 960;
const HEIGHT: u32 = 540;

/// The folder that cargo keeps for integration tests, below `target`.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("mesa")
        .join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

struct Drawn {
    color: Vec<[u8; 4]>,
    depth: Vec<f32>,
}

fn options() -> RenderOptions {
    let mut options = RenderOptions::default();
    options.lights = vec![
        Light::Ambient {
            intensity: Vec3::splat(0.1),
        },
        Light::Directional {
            towards: DVec3::new(1.0, 2.0, 3.0),
            intensity: Vec3::splat(0.9),
        },
    ];
    options
}

fn numbers(values: &[f64]) -> String {
    let list: Vec<String> = values.iter().map(f64::to_string).collect();
    format!("[{}]", list.join(","))
}

fn draw_with_llvmpipe(name: &str, python: &Path, mesh: &Mesh, view: &View) -> Drawn {
    let folder = folder(name);
    let mut vertices = Vec::new();
    for (triangle, normals) in mesh.triangles.iter().zip(&mesh.corner_normals) {
        for (v, normal) in triangle.iter().zip(normals) {
            let position = mesh.positions[*v as usize].as_vec3();
            for value in position.to_array().into_iter().chain(normal.to_array()) {
                vertices.extend(value.to_le_bytes());
            }
        }
    }
    let indices: Vec<u8> = (0..mesh.triangles.len() as u32 * 3)
        .flat_map(u32::to_le_bytes)
        .collect();
    std::fs::write(folder.join("vertices.bin"), vertices).unwrap();
    std::fs::write(folder.join("indices.bin"), indices).unwrap();
    let options = options();
    let material = Material::of_color(options.default_color);
    let matrix: DMat4 = view.world_to_clip();
    let towards = DVec3::new(1.0, 2.0, 3.0).normalize();
    let job = format!(
        "{{\"width\":{WIDTH},\"height\":{HEIGHT},\"world_to_clip\":{},\"viewer\":{},\"towards\":{},\
         \"ambient\":0.1,\"intensity\":0.9,\"diffuse\":{},\"specular\":{},\"shininess\":{}}}",
        numbers(&matrix.to_cols_array()),
        numbers(&view.centre_of_projection().to_array()),
        numbers(&towards.to_array()),
        numbers(&material.diffuse.as_dvec3().to_array()),
        numbers(&material.specular.as_dvec3().to_array()),
        material.shininess,
    );
    std::fs::write(folder.join("job.json"), job).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mesa/llvmpipe.py");
    let output = Command::new(python)
        .arg(script)
        .arg(&folder)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    assert!(text.contains("llvmpipe"), "not llvmpipe: {text}");
    let color = std::fs::read(folder.join("color.bin")).unwrap();
    let depth = std::fs::read(folder.join("depth.bin")).unwrap();
    Drawn {
        color: color.as_chunks::<4>().0.to_vec(),
        depth: depth
            .as_chunks::<4>()
            .0
            .iter()
            .map(|b| f32::from_le_bytes(*b))
            .collect(),
    }
}

/// Whether a sample lies within 1/256 pixel of a triangle's edge in the window.
fn near_an_edge(mesh: &Mesh, view: &View, k: usize) -> bool {
    let limit = 1.0 / 256.0;
    let x = (k as u32 % WIDTH) as f64 + 0.5;
    let y = (k as u32 / WIDTH) as f64 + 0.5;
    let at = glam::DVec2::new(x, y);
    let viewport = raster::Viewport::of_image(WIDTH, HEIGHT);
    mesh.triangles.iter().any(|triangle| {
        let corners = triangle.map(|v| viewport.project(view, mesh.positions[v as usize]));
        let [Some(a), Some(b), Some(c)] = corners else {
            return true;
        };
        [(a, b), (b, c), (c, a)].into_iter().any(|(a, b)| {
            let (a, b) = (a.truncate(), b.truncate());
            let t = ((at - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            at.distance(a.lerp(b, t)) < limit
        })
    })
}

#[test]
fn pixels_agree_with_llvmpipe() {
    if std::env::var_os("STEREOTOMY_MESA").is_none_or(|v| v != "1") {
        println!("STEREOTOMY_MESA is not 1: pixels are not compared with llvmpipe");
        eprintln!("STEREOTOMY_MESA is not 1: pixels are not compared with llvmpipe");
        return;
    }
    let python = environment::python("llvmpipe", include_str!("mesa/requirements.txt"));
    let mut grid = Mesh::default();
    for cell in 0..27 {
        let at = [cell % 3, cell / 3 % 3, cell / 9].map(|i| f64::from(i) * 0.66 - 0.66);
        grid = common::merge(grid, &common::icosphere(DVec3::from_array(at), 0.3, 3));
    }
    let eye = DVec3::new(1.9, 2.3, 1.7);
    let lens = Lens::Perspective { fov_y: 0.9 };
    for (name, mesh, lens, eye) in [
        ("sphere", common::icosphere(DVec3::ZERO, 1.0, 5), lens, eye),
        ("spheres", grid, lens, eye),
        (
            "parallel",
            common::icosphere(DVec3::ZERO, 1.0, 4),
            Lens::Orthographic { height: 2.5 },
            eye,
        ),
        (
            "large",
            common::icosphere(DVec3::ZERO, 1.0, 0),
            lens,
            DVec3::new(0.9, 0.6, 0.7),
        ),
    ] {
        let camera = Camera {
            eye,
            target: DVec3::ZERO,
            up: DVec3::Z,
            lens,
            near: 0.1,
            far: 10.0,
        };
        let view = camera.view(WIDTH, HEIGHT).unwrap();
        let theirs = draw_with_llvmpipe(name, &python, &mesh, &view);
        let mut renderer = Renderer::default();
        let mut image = Image::default();
        renderer
            .draw(
                &Prepared::new(&mesh),
                &view,
                WIDTH,
                HEIGHT,
                &options(),
                &mut image,
            )
            .unwrap();
        let depth = renderer.depth_buffer();
        let ids = renderer.triangle_buffer();
        let planes = common::reversed_depth_planes(&mesh, &view, [WIDTH, HEIGHT]);
        let (mut covered, mut coverage, mut depths, mut colours) = (0, 0, 0, 0);
        // Distances from the exact depth in units of 24 bits: the worst, and
        // how many of the peer's are more than two units off.
        let (mut ours, mut peer) = (0.0f64, (0.0f64, 0));
        let mut apart = 0;
        for k in 0..image.pixels.len() {
            let (a, b) = (image.pixels[k], theirs.color[k]);
            covered += usize::from(b[3] != 0);
            let same = a[3] == b[3];
            // Each against the depth of the triangle's plane at the pixel's
            // centre, in double precision. Depth is kept to 2 units, at every
            // pixel. llvmpipe has the corners of the window in single
            // precision, 2^-14 pixel in the middle of this picture, and sums
            // depth up from the picture's corner: on steep faces that is many
            // units, and no comparison with it can be nearer than it is to
            // the truth.
            let pixel = [k as u32 % WIDTH, k as u32 / WIDTH];
            let (mut own, mut other, mut between, mut slope) = (0.0, 0.0, 0.0, 0.0);
            if let Some(id) = ids.values[k] {
                let plane = planes[id as usize];
                let bounds = common::depth_bounds(&mesh, &view, [WIDTH, HEIGHT], id, plane);
                let error =
                    |depth: f32| common::depth_error(1.0 - f64::from(depth), plane, bounds, pixel);
                own = error(depth.values[k]);
                assert!(
                    own <= 2.0,
                    "{name}: {pixel:?} is {own} units from exact depth"
                );
                if same {
                    other = error(theirs.depth[k]);
                    between = f64::from(depth.values[k] - theirs.depth[k]).abs()
                        * f64::from((1 << 24) - 1);
                    slope = plane.truncate().length();
                }
            }
            // What the peer's own arithmetic allows it: 1/2^13 pixel for the
            // corners and the slope between them.
            let allowed = 4.0 + slope * f64::from(1 << 24) / 8192.0;
            let deep = other <= allowed && between <= 2.0 + other;
            let colour = (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
            if same && deep && colour <= 1 {
                ours = ours.max(own);
                peer = (peer.0.max(other), peer.1 + usize::from(other > 2.0));
                apart += usize::from(between > 2.0);
                continue;
            }
            coverage += usize::from(!same);
            depths += usize::from(same && !deep);
            colours += usize::from(same && deep && colour > 1);
            assert!(
                near_an_edge(&mesh, &view, k),
                "{name}: pixel {} {}: {a:?} and {b:?}, depth {own} units from exact, llvmpipe {other}",
                k as u32 % WIDTH,
                k as u32 / WIDTH
            );
        }
        assert!(covered > 10_000, "{name}: {covered}");
        println!(
            "{name}: {covered} pixels; next to edges {coverage} differ in coverage, {depths} in \
             depth, {colours} in colour; elsewhere colours are within 1/255, depth within {:.2} of \
             2^-24 of exact, llvmpipe's within {:.2} ({} above 2), and {apart} pixels more than 2 apart",
            ours, peer.0, peer.1
        );
    }
}
