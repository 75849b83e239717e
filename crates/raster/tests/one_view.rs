//! A scene made for one view, or from a mesh that is given away, is drawn as
//! one that was made for all.

use crate::common;
use csg::Mesh;
use glam::DVec3;
use raster::{
    AntiAliasing, Camera, EdgeOptions, Image, Lens, Prepared, RenderOptions, Renderer, StandardView,
};

/// A smooth ball and a box with creases, without normals.
fn subject() -> Mesh {
    let ball = common::icosphere(DVec3::ZERO, 1.0, 4);
    let block = common::cuboid(DVec3::new(0.2, -0.4, -0.3), DVec3::new(1.6, 0.5, 0.4));
    let mut mesh = common::merge(
        common::colored(ball, [0.8, 0.3, 0.2]),
        &common::colored(block, [0.2, 0.4, 0.8]),
    );
    mesh.corner_normals.clear();
    mesh
}

#[test]
fn scenes_for_one_view_look_like_scenes_for_all() {
    let mesh = subject();
    let (width, height) = (160, 120);
    let inside = Camera {
        eye: DVec3::new(-0.2, 0.1, 0.0),
        target: DVec3::X,
        near: 1e-3,
        ..Camera::standard(&mesh, StandardView::Iso, Lens::DEFAULT, 4.0 / 3.0).unwrap()
    };
    let mut cameras = vec![inside];
    for view in StandardView::ALL {
        for lens in [Lens::DEFAULT, Lens::Orthographic { height: 1.0 }] {
            cameras.push(Camera::standard(&mesh, view, lens, 4.0 / 3.0).unwrap());
        }
    }
    let mut modes = vec![RenderOptions::default(); 5];
    modes[1].anti_aliasing = AntiAliasing::Msaa4;
    modes[2].anti_aliasing = AntiAliasing::Supersample(3);
    modes[3].two_sided = true;
    modes[3].cull_back_faces = false;
    modes[4].edges = Some(EdgeOptions::default());
    let all = Prepared::new(&mesh);
    let given = Prepared::from(mesh.clone());
    let mut drawn = 0;
    for camera in &cameras {
        let view = camera.view(width, height).unwrap();
        for options in &modes {
            let one = Prepared::for_view(mesh.clone(), &view, width, height, options);
            let [expected, found, taken] = [&all, &one, &given].map(|scene| {
                let mut image = Image::default();
                Renderer::default()
                    .draw(scene, &view, width, height, options, &mut image)
                    .unwrap();
                image
            });
            assert!(expected == found, "{camera:?} {options:?}");
            assert!(expected == taken, "{camera:?} {options:?}");
            drawn += expected.pixels.iter().filter(|p| p[3] != 0).count();
        }
    }
    assert!(drawn > 100_000, "{drawn}");
}
