//! What is left out because the picture does not need it, by its counts.

use crate::common;
use csg::Mesh;
use glam::DVec3;
use raster::{AntiAliasing, Camera, Image, Lens, Prepared, RenderOptions, Renderer, Stats};

const SIZE: u32 = 256;

fn camera() -> Camera {
    Camera {
        eye: DVec3::new(0.0, -4.0, 0.0),
        target: DVec3::ZERO,
        up: DVec3::Z,
        lens: Lens::Perspective { fov_y: 0.6 },
        near: 0.1,
        far: 50.0,
    }
}

fn stats(mesh: &Mesh, camera: &Camera, options: &RenderOptions) -> Stats {
    let view = camera.view(SIZE, SIZE).unwrap();
    let (mut renderer, mut image) = (Renderer::default(), Image::default());
    let scene = Prepared::new(mesh);
    let stats = renderer.draw(&scene, &view, SIZE, SIZE, options, &mut image);
    let stats = stats.unwrap();
    let seen = image.pixels.iter().filter(|p| p[3] > 0).count();
    assert_eq!(stats.pixels_shaded, seen as u64);
    assert_eq!(stats.triangles, mesh.triangles.len() as u64);
    stats
}

/// Of a ball, what turns away is left out whole, or before it is set up.
#[test]
fn what_turns_away_is_left_out() {
    let ball = common::icosphere(DVec3::ZERO, 1.0, 5);
    let stats = stats(&ball, &camera(), &RenderOptions::default());
    assert_eq!((stats.clusters_outside, stats.triangles_clipped), (0, 0));
    assert!(stats.clusters_facing_away * 3 > stats.clusters, "{stats}");
    let drawn = stats.triangles_tiny + stats.triangles_set_up;
    let looked_at = stats.triangles_facing_away + stats.triangles_without_sample + drawn;
    assert_eq!(stats.triangles_looked_at, looked_at, "{stats}");
    // From this near, less than half of it is in front of its horizon.
    assert!(drawn * 2 < stats.triangles, "{stats}");
    assert!(
        stats.triangles_looked_at * 3 < stats.triangles * 2,
        "{stats}"
    );
}

/// What lies beside or behind the picture is left out whole; what reaches over
/// its sides is not clipped there.
#[test]
fn the_guard_band_spares_the_sides_clipping() {
    let ball = common::icosphere(DVec3::ZERO, 1.0, 5);
    let near = Camera {
        eye: DVec3::new(0.0, -1.3, 0.0),
        ..camera()
    };
    for anti_aliasing in [AntiAliasing::None, AntiAliasing::Msaa4] {
        let mut options = RenderOptions::default();
        options.anti_aliasing = anti_aliasing;
        let within = stats(&ball, &near, &options);
        assert_eq!(within.pixels_shaded, u64::from(SIZE * SIZE));
        assert_eq!(within.triangles_clipped, 0, "{within}");
        assert!(within.clusters_outside > 0, "{within}");
        let away = Camera {
            target: DVec3::new(0.0, -9.0, 0.0),
            ..near
        };
        let away = stats(&ball, &away, &options);
        assert_eq!(away.clusters_outside, away.clusters, "{away}");
        assert_eq!(
            (away.triangles_looked_at, away.tiles_empty),
            (0, away.tiles)
        );
    }
    // The near plane does clip.
    let inside = Camera {
        eye: DVec3::new(0.0, 0.95, 0.0),
        target: DVec3::new(1.0, 0.95, 0.0),
        ..camera()
    };
    let mut options = RenderOptions::default();
    options.cull_back_faces = false;
    let inside = stats(&common::icosphere(DVec3::ZERO, 1.0, 2), &inside, &options);
    assert!(inside.triangles_clipped > 0, "{inside}");
}

/// Behind a wall, hierarchical depth leaves clusters out whole.
#[test]
fn what_is_hidden_is_left_out() {
    let wall = common::cuboid(DVec3::new(-3.0, -2.0, -3.0), DVec3::new(3.0, -1.9, 3.0));
    let mut mesh = wall;
    for k in 0..60 {
        let at = DVec3::new(f64::from(k % 5) - 2.0, f64::from(k / 5) * 0.3, 0.0);
        mesh = common::merge(mesh, &common::icosphere(at * 0.2, 0.2, 4));
    }
    let stats = stats(&mesh, &camera(), &RenderOptions::default());
    assert!(stats.clusters > 1_000, "{stats}");
    let left = stats.clusters - stats.clusters_facing_away - stats.clusters_hidden;
    // The first batch is taken before anything is drawn.
    assert!(left * 4 < stats.clusters, "{stats}");
    assert!(stats.clusters_hidden * 4 > stats.clusters, "{stats}");
}
