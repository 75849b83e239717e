//! What is done with arbitrary bytes: by cargo-fuzz, and on stable by `tests/fuzzing.rs`. None of it
//! may panic.

use std::time::Duration;

use crate::csg::glam::{DMat4, DVec3};
use crate::csg::{BoundaryOptions, Limits, Mesh, Mesher, Program};
use crate::io::scene::ReadOptions;
use crate::io::{
    Error, ProfileOptions, ReadProfile, gltf, obj, off, ply, profile, scene, stl, threemf,
};
use crate::raster::{Camera, Part, RenderOptions, Scene, View, render};

/// A target: its name, and what it does.
pub type Target = (&'static str, fn(&[u8]));

/// All of them.
pub const ALL: [Target; 12] = [
    ("stl", |data| mesh(stl::read_stl(data))),
    ("ply", |data| mesh(ply::read_ply(data))),
    ("off", |data| mesh(off::read_off(data))),
    ("obj", |data| {
        mesh(obj::read_obj(data, |_| Some(data.to_vec())));
    }),
    ("glb", |data| mesh(gltf::read_glb(data))),
    ("gltf", |data| {
        mesh(gltf::read_gltf(data, |_| Ok(data.to_vec())));
    }),
    ("threemf", |data| mesh(threemf::read_3mf(data))),
    ("svg", |data| {
        flat(profile::read_svg(data, &ProfileOptions::default()));
    }),
    ("dxf", |data| {
        flat(profile::read_dxf(data, &ProfileOptions::default()));
    }),
    ("scene", |data| {
        let _ = scene::read_bytes(data, &ReadOptions::default());
    }),
    ("solid", solid),
    ("raster", raster),
];

/// Runs a target by its name.
///
/// # Panics
/// If there is none of that name, or it found a fault.
pub fn run(name: &str, data: &[u8]) {
    let target = ALL.iter().find(|(known, _)| *known == name);
    target.unwrap_or_else(|| panic!("no target {name}")).1(data);
}

/// What is read names no vertex that is not there.
fn mesh(read: Result<Mesh, Error>) {
    if let Ok(mesh) = read {
        let check = mesh.check();
        assert_eq!(check.out_of_range_triangles, 0);
        assert_eq!(check.non_finite_vertices, 0);
    }
}

/// What is read is at no fault, and has bounds.
fn flat(read: Result<ReadProfile, Error>) {
    if let Ok(read) = read {
        assert_eq!(read.profile.fault(), None);
        if let Ok(Some((low, high))) = read.profile.bounds(1.0) {
            assert!(low.is_finite() && high.is_finite());
        }
    }
}

/// A solid that a scene describes, meshed and measured.
fn solid(data: &[u8]) {
    let Ok(scene) = scene::read_bytes(data, &ReadOptions::default()) else {
        return;
    };
    let Ok(program) = Program::lower(&scene.solid) else {
        return;
    };
    let limits = Limits::new()
        .triangles(100_000)
        .time(Duration::from_secs(5));
    if let Ok(made) = Mesher::new().tolerance(0.05).limits(limits).mesh(&program) {
        assert!(made.mesh.check().is_manifold());
    }
    if data.len() < 1000
        && let Ok(brep) = program.boundary(&BoundaryOptions::new().limits(limits))
    {
        let _ = brep.measure();
    }
}

/// Numbers out of bytes: most of them small, some any bits there are.
struct Numbers<'a>(&'a [u8]);

impl Numbers<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (&first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(first)
    }

    fn number(&mut self) -> Option<f64> {
        Some(match self.byte()? {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::MAX,
            3 => f64::MIN_POSITIVE,
            4..16 => {
                let (bits, rest) = self.0.split_first_chunk::<8>()?;
                self.0 = rest;
                f64::from_bits(u64::from_le_bytes(*bits))
            }
            byte => (f64::from(byte) - 135.0) / 32.0,
        })
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Some(numbers)
    }

    /// A matrix that is near to one that makes sense, or any.
    fn matrix(&mut self, near: DMat4) -> Option<DMat4> {
        let is_any = self.byte()? < 32;
        let numbers = DMat4::from_cols_array(&self.numbers()?);
        Some(if is_any {
            numbers
        } else {
            near + 0.05 * numbers
        })
    }
}

/// Triangles, where they are, and two matrices that see them.
fn raster(data: &[u8]) {
    let mut from = Numbers(data);
    let _ = draw(&mut from);
}

fn draw(from: &mut Numbers<'_>) -> Option<()> {
    const SIDE: u32 = 40;
    let camera = Camera::looking_at(DVec3::new(2.0, -3.0, 2.0), DVec3::ZERO).depths(0.5, 9.0);
    let (eye, lens) = (camera.world_to_eye(), camera.eye_to_clip(1.0));
    let model = from.matrix(DMat4::IDENTITY)?;
    let view = View::new(from.matrix(eye)?, from.matrix(lens)?).ok()?;
    let count = usize::from(from.byte()?) % 12;
    let mut positions = Vec::new();
    for _ in 0..count {
        positions.push(DVec3::from_array(from.numbers()?));
    }
    let mut triangles = Vec::new();
    while let (Some(a), Some(b), Some(c)) = (from.byte(), from.byte(), from.byte()) {
        // (Some of no vertex that there is.)
        let corner = |byte: u8| u32::from(byte) % (count as u32 + 1);
        triangles.push([a, b, c].map(corner));
    }
    let part = Part::new(Mesh::new(positions, triangles)).transformed(model);
    let scene = Scene::new().add(part);
    let options = RenderOptions::default().size(SIDE, SIDE);
    let mesh = scene.to_mesh();
    if let Ok(image) = render(&mesh, &view, SIDE, SIDE, &options) {
        assert_eq!(image.pixels.len(), (SIDE * SIDE) as usize);
    }
    let camera = scene.camera(&options).ok()?;
    let _ = scene.render(&camera, &options);
    let _ = view.towards_viewer(DVec3::ONE);
    let _ = view.centre_of_projection();
    Some(())
}
