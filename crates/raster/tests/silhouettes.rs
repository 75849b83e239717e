//! Silhouettes of smooth surfaces, against where geometry says they are.

use csg::Mesh;
use glam::{DVec2, DVec3};
use raster::{Camera, EdgeOptions, Image, Lens, Prepared, RenderOptions, Renderer, Viewport};

const SIZE: u32 = 200;

/// A cone over a regular polygon, with the cone's own normals: at the apex
/// that of the middle of each triangle. `rows` of triangles up to the apex.
fn cone(sides: u32, rows: u32, radius: f64, height: f64) -> Mesh {
    let angle = |k: f64| std::f64::consts::TAU * k / f64::from(sides);
    let normal = |k: f64| {
        let (sin, cos) = angle(k).sin_cos();
        DVec3::new(cos * height, sin * height, radius)
            .normalize()
            .as_vec3()
    };
    let mut mesh = Mesh::default();
    for row in 0..rows {
        let share = 1.0 - f64::from(row) / f64::from(rows);
        for k in 0..sides {
            let around = DVec2::from_angle(angle(f64::from(k))) * radius * share;
            mesh.positions.push(around.extend(height * (1.0 - share)));
        }
    }
    let apex = mesh.positions.len() as u32;
    mesh.positions.push(DVec3::new(0.0, 0.0, height));
    for k in 0..sides {
        let [a, b] = [f64::from(k), f64::from(k + 1)].map(normal);
        let next = (k + 1) % sides;
        for row in 0..rows - 1 {
            let [p, q] = [k + row * sides, next + row * sides];
            let [r, s] = [p + sides, q + sides];
            mesh.triangles.extend([[p, q, s], [p, s, r]]);
            mesh.corner_normals.extend([[a, b, b], [a, b, a]]);
        }
        let top = (rows - 1) * sides;
        mesh.triangles.push([k + top, next + top, apex]);
        mesh.corner_normals.push([a, b, normal(f64::from(k) + 0.5)]);
    }
    mesh
}

/// Both silhouettes of a cone run along a ruling from the rim to the apex, for
/// a viewer at many places around it.
#[test]
fn silhouettes_of_a_cone_reach_its_apex() {
    let (radius, height) = (1.0, 2.0);
    for (sides, rows) in [(12, 1), (30, 1), (30, 4)] {
        let mesh = cone(sides, rows, radius, height);
        let scene = Prepared::new(&mesh);
        for turn in 0..17 {
            let around = DVec2::from_angle(0.37 * f64::from(turn)) * 6.0;
            let eye = around.extend(f64::from(turn % 5) * 0.6);
            let camera = Camera {
                eye,
                target: DVec3::new(0.0, 0.0, 1.0),
                up: DVec3::Z,
                lens: Lens::DEFAULT,
                near: 1.0,
                far: 20.0,
            };
            let view = camera.view(SIZE, SIZE).unwrap();
            let mut options = RenderOptions::default();
            let mut edges = EdgeOptions::default();
            (edges.features, edges.width) = (false, 2.0);
            options.edges = Some(edges);
            let mut image = Image::default();
            Renderer::default()
                .draw(&scene, &view, SIZE, SIZE, &options, &mut image)
                .unwrap();
            // The rulings whose normal is at right angles to the view from the
            // apex, and so from all of the ruling: cos(a - b) = s.
            let apex = DVec3::new(0.0, 0.0, height);
            let to_eye = eye - apex;
            let sine = -radius * to_eye.z / (height * to_eye.truncate().length());
            let toward = to_eye.y.atan2(to_eye.x);
            for side in [-1.0, 1.0] {
                let angle = toward + side * sine.acos();
                let foot = (DVec2::from_angle(angle) * radius).extend(0.0);
                let viewport = Viewport::of_image(SIZE, SIZE);
                let gaps = (3..=47).filter(|&k| {
                    let p = foot.lerp(apex, f64::from(k) / 50.0);
                    let at = viewport.project(&view, p).unwrap();
                    // A triangle's width beside it, for silhouettes of meshes
                    // are those of their interpolated normals.
                    let reach = (0.8 / f64::from(sides) * 50.0 * (1.0 - f64::from(k) / 50.0)).ceil()
                        as i32
                        + 2;
                    !near_line(&image, at.truncate(), reach)
                });
                let gaps: Vec<i32> = gaps.collect();
                assert!(gaps.is_empty(), "{sides} {rows} {turn} {side}: {gaps:?}");
            }
        }
    }
}

/// Whether a dark pixel is within `reach` of a position.
fn near_line(image: &Image, at: DVec2, reach: i32) -> bool {
    let range = -reach..=reach;
    range.clone().any(|dy| {
        range.clone().any(|dx| {
            let (x, y) = (at.x as i32 + dx, at.y as i32 + dy);
            let pixel = image.get(x as u32, y as u32);
            pixel.is_some_and(|p| p[3] > 100 && p[0] < 60 && p[2] < 60)
        })
    })
}
