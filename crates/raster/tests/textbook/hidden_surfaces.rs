//! Hidden surfaces, scan lines and wireframes.

use super::common;
use csg::Mesh;
use glam::DVec3;
use raster::hidden_surface::{DepthBuffer, Painter, ScanLine};
use raster::scanline::scan_convert;
use raster::{
    Camera, Image, Lens, RenderOptions, View, Viewport, render_reference, wireframe_reference,
};

/// Values at (60, 60, 0), (60, 60, 0) and (255, 255, 0), and depths, along the
/// edges and then along the row.
#[test]
fn scan_lines_interpolate_linearly() {
    let corner = |x: i32, y: i32| [x * 256, y * 256];
    let corners = [corner(20, 0), corner(0, 40), corner(40, 40)];
    let values = [[255.0, 1.0], [60.0, 3.0], [60.0, 7.0]];
    let mut rows = 0;
    scan_convert(corners, values, 64, 64, |span| {
        let y = f64::from(span.y) + 0.5;
        let edge = |from: f64, to: f64| (to - from) * y / 40.0 + from;
        let (xa, xb) = (edge(20.0, 0.0), edge(20.0, 40.0));
        let (za, zb) = (edge(1.0, 3.0), edge(1.0, 7.0));
        for x in span.start..span.end {
            let centre = f64::from(x) + 0.5;
            let z = (zb - za) * (centre - xa) / (xb - xa) + za;
            let at = |k: usize| span.values[k] + span.step[k] * f64::from(x - span.start);
            assert!((at(0) - edge(255.0, 60.0)).abs() < 1e-9 && (at(1) - z).abs() < 1e-9);
        }
        rows += 1;
    });
    // (The first row's sample is beside the tip.)
    assert_eq!(rows, 39);
}

/// Two plates through each other.
fn crossing_plates() -> (Mesh, View) {
    let plate = |slope: f64| {
        let corner = |x: f64, y: f64| DVec3::new(x, y, slope * x);
        let corners = vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])
    };
    let mesh = common::merge(
        common::colored(plate(0.5), [1.0, 0.0, 0.0]),
        &common::colored(plate(-0.5), [0.0, 1.0, 0.0]),
    );
    let camera = Camera::looking_at(DVec3::Z * 6.0, DVec3::ZERO)
        .lens(Lens::Orthographic { height: 2.2 })
        .depths(1.0, 12.0);
    (mesh, camera.view(64, 64).unwrap())
}

/// Where parts cut each other the painter fails; depth buffers do not, of the
/// whole picture or of a row.
#[test]
fn the_painter_fails_and_depth_buffers_do_not() {
    let (mesh, view) = crossing_plates();
    let options = RenderOptions::default();
    let red_right = |image: &Image| image.get(48, 40).unwrap()[0] > image.get(48, 40).unwrap()[1];
    let green_left = |image: &Image| image.get(16, 40).unwrap()[1] > image.get(16, 40).unwrap()[0];
    let buffered = render_reference(
        &mesh,
        &view,
        64,
        64,
        &options,
        &mut DepthBuffer::new(64 * 64),
    )
    .unwrap();
    let by_rows = render_reference(&mesh, &view, 64, 64, &options, &mut ScanLine::new(64)).unwrap();
    let painted = render_reference(&mesh, &view, 64, 64, &options, &mut Painter).unwrap();
    assert!(red_right(&buffered) && green_left(&buffered));
    assert_eq!(buffered, by_rows);
    assert_ne!(painted, buffered);
}

#[test]
fn scan_line_buffers_draw_what_depth_buffers_draw() {
    let mesh = common::merge(
        common::icosphere(DVec3::new(0.2, 0.0, 0.0), 0.9, 3),
        &common::cuboid(DVec3::splat(-0.7), DVec3::splat(0.5)),
    );
    let camera = Camera::looking_at(DVec3::new(2.0, -3.0, 1.4), DVec3::ZERO);
    let (width, height) = (90, 70);
    let view = camera.view(width, height).unwrap();
    let options = RenderOptions::default();
    let pixels = (width * height) as usize;
    let whole = render_reference(
        &mesh,
        &view,
        width,
        height,
        &options,
        &mut DepthBuffer::new(pixels),
    );
    let rows = render_reference(
        &mesh,
        &view,
        width,
        height,
        &options,
        &mut ScanLine::new(width),
    );
    assert_eq!(whole.unwrap(), rows.unwrap());
}

/// Every pixel that an edge goes through is drawn, nothing elsewhere; edges
/// leave the window and pass behind the eye.
#[test]
fn wireframes_are_clipped() {
    let mesh = common::cuboid(DVec3::splat(-1.0), DVec3::ONE);
    let (ink, paper) = (
        csg::Color::from_srgb([0.0; 3]),
        csg::Color::from_srgb([1.0; 3]),
    );
    for eye in [
        DVec3::new(3.0, -4.0, 2.0),
        DVec3::new(0.5, -1.2, 0.3),
        DVec3::new(0.2, 0.1, 0.3),
    ] {
        let camera = Camera::looking_at(eye, DVec3::new(0.9, 0.9, 0.1)).depths(0.1, 20.0);
        let view = camera.view(64, 48).unwrap();
        let image = wireframe_reference(&mesh, &view, 64, 48, ink, paper).unwrap();
        let viewport = Viewport::of_image(64, 48);
        let mut near = vec![false; 64 * 48];
        for [a, b, c] in &mesh.triangles {
            for (i, j) in [(a, b), (b, c), (c, a)] {
                let [from, to] = [i, j].map(|&v| mesh.positions[v as usize]);
                for k in 0..=40_000 {
                    let p = from.lerp(to, f64::from(k) / 40_000.0);
                    let Some(at) = viewport.project(&view, p).filter(|p| p.z >= 0.0) else {
                        continue;
                    };
                    for (dx, dy) in (0..9).map(|k| (k % 3 - 1, k / 3 - 1)) {
                        let (x, y) = (at.x.floor() as i64 + dx, at.y.floor() as i64 + dy);
                        if (0..64).contains(&x) && (0..48).contains(&y) {
                            near[(y * 64 + x) as usize] = true;
                        }
                    }
                }
            }
        }
        let drawn: Vec<bool> = image.pixels.iter().map(|p| p[0] == 0).collect();
        assert!(drawn.iter().filter(|d| **d).count() > 20, "{eye}");
        assert!(
            drawn
                .iter()
                .zip(&near)
                .all(|(&drawn, &near)| !drawn || near),
            "{eye}"
        );
    }
}
