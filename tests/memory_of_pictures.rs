//! What a first frame takes beside its picture.
#![allow(missing_docs, reason = "a test")]

use csg::{Mesher, Program};
use peak_alloc::PeakAlloc;
use raster::{AntiAliasing, Camera, Image, Lens, Prepared, RenderOptions, Renderer, StandardView};
use stereotomy::{csg, raster, scenes};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// At most twice the picture's own memory, with several samples a pixel as with
/// one. (One test, for peaks are those of the whole process.)
#[test]
fn samples_are_kept_one_tile_at_a_time() {
    let program = Program::lower(&scenes::flange()).expect("a valid solid");
    let mesher = Mesher::new().tolerance(1e-3).normals();
    let mesh = mesher.mesh(&program).expect("a mesh").mesh;
    let scene = Prepared::new(&mesh);
    let camera = Camera::standard(&mesh, StandardView::Iso, Lens::DEFAULT, 4.0 / 3.0);
    let (width, height) = (1600, 1200);
    let view = camera.and_then(|camera| camera.view(width, height));
    let view = view.expect("a sound view");
    let picture = 4 * width as usize * height as usize;
    for anti_aliasing in [AntiAliasing::None, AntiAliasing::Msaa4, AntiAliasing::Msaa8] {
        let mut options = RenderOptions::default();
        options.anti_aliasing = anti_aliasing;
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let mut image = Image::default();
        let mut renderer = Renderer::default();
        let drawn = renderer.draw(&scene, &view, width, height, &options, &mut image);
        drawn.expect("a picture");
        let beside = ALLOCATOR.peak_usage() - before - picture;
        // What the mesh's triangles take is little here: tiles at the border hold
        // more than the picture, and each thread a tile of samples.
        let most = 2 * picture + picture / 4;
        assert!(beside <= most, "{anti_aliasing:?}: {beside} of {most}");
    }
}
