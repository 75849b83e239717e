//! What a first frame takes beside its picture.
#![allow(missing_docs, reason = "a test")]

use csg::{Mesher, Program};
use peak_alloc::PeakAlloc;
use raster::{AntiAliasing, Camera, Image, Lens, Prepared, RenderOptions, Renderer, StandardView};
use stereotomy::{csg, raster, scenes};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// (Each has lists of triangles.)
const THREADS: usize = 2;

/// At most twice the picture's own memory, with several samples a pixel as with
/// one. (One test, for peaks are those of the whole process.)
#[test]
fn samples_are_kept_one_tile_at_a_time() {
    let program = Program::lower(&scenes::flange()).expect("a valid solid");
    let mesher = Mesher::new().tolerance(1e-2).normals();
    let mesh = mesher.mesh(&program).expect("a mesh").mesh;
    let scene = Prepared::new(&mesh);
    let camera = Camera::standard(&mesh, StandardView::Iso, Lens::DEFAULT, 4.0 / 3.0);
    let (width, height) = (1600, 1200);
    let view = camera.and_then(|camera| camera.view(width, height));
    let view = view.expect("a sound view");
    let picture = 4 * width as usize * height as usize;
    // Eight bytes for each pixel of the tiles of 64x64.
    let kept = 2 * 4 * (width.div_ceil(64) * height.div_ceil(64) * 64 * 64) as usize;
    let threads = rayon::ThreadPoolBuilder::new().num_threads(THREADS).build();
    let threads = threads.expect("threads");
    for anti_aliasing in [AntiAliasing::None, AntiAliasing::Msaa4, AntiAliasing::Msaa8] {
        let mut options = RenderOptions::default();
        options.anti_aliasing = anti_aliasing;
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        let mut image = Image::default();
        let mut renderer = Renderer::default();
        let drawn =
            threads.install(|| renderer.draw(&scene, &view, width, height, &options, &mut image));
        drawn.expect("a picture");
        let beside = ALLOCATOR.peak_usage() - before - picture;
        // The samples that a thread works on, and lists of triangles.
        let samples = anti_aliasing.samples().len();
        let at_work = THREADS * samples * 8 * 64 * 64;
        let lists = 2 << 20;
        assert!(
            (kept..kept + at_work + lists).contains(&beside),
            "{anti_aliasing:?}: {beside} beside {kept}"
        );
    }
}
