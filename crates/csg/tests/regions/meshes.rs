//! Closed meshes of many triangles.

use std::collections::HashMap;

use csg::Mesh;
use csg::glam::{DQuat, DVec3, EulerRot, dvec3};

/// A ball of 20 · 4^n triangles whose vertices are rounded as STL files round them.
pub fn ball(n: u32, radius: f64) -> Mesh {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut points: Vec<DVec3> = Vec::new();
    for (a, b) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        points.extend([dvec3(0.0, a, b), dvec3(a, b, 0.0), dvec3(b, 0.0, a)]);
    }
    let mut faces: Vec<[u32; 3]> = Vec::new();
    let near = |a: DVec3, b: DVec3| (a.distance(b) - 2.0).abs() < 1e-9;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [p, q, r] = [a, b, c].map(|k: u32| points[k as usize]);
                if near(p, q) && near(q, r) && near(r, p) {
                    let outward = (q - p).cross(r - p).dot(p) > 0.0;
                    faces.push(if outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..n {
        let mut middle: HashMap<[u32; 2], u32> = HashMap::new();
        let mut finer = Vec::with_capacity(4 * faces.len());
        for &[a, b, c] in &faces {
            let [d, e, f] = [[a, b], [b, c], [c, a]].map(|[p, q]| {
                *middle.entry([p.min(q), p.max(q)]).or_insert_with(|| {
                    points.push(points[p as usize] + points[q as usize]);
                    points.len() as u32 - 1
                })
            });
            finer.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        faces = finer;
        for point in &mut points {
            *point = point.normalize();
        }
    }
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, 0.5, 0.7);
    let points = points.iter().map(|p| {
        let point = turn * (radius * p.normalize());
        point.as_vec3().as_dvec3()
    });
    Mesh::new(points.collect(), faces)
}

/// A star-shaped body: the ball's vertices at other distances, by `height` of the direction.
pub fn star(n: u32, height: impl Fn(DVec3) -> f64) -> Mesh {
    let mut mesh = ball(n, 1.0);
    for point in &mut mesh.positions {
        let direction = point.normalize();
        *point = (height(direction) * direction).as_vec3().as_dvec3();
    }
    mesh
}

/// A cube from -1 to 1, turned and rounded to single precision, so that no face is quite
/// flat, of n² squares a side.
pub fn rounded_cube(n: u32, turn: DQuat) -> Mesh {
    let mut numbers: HashMap<[i64; 3], u32> = HashMap::new();
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [0, n] {
            let mut vertex = |i: u32, j: u32| {
                let mut place = [0; 3];
                place[axis] = i64::from(side);
                place[(axis + 1) % 3] = i64::from(i);
                place[(axis + 2) % 3] = i64::from(j);
                *numbers.entry(place).or_insert_with(|| {
                    let at = place.map(|k| 2.0 * k as f64 / f64::from(n) - 1.0);
                    positions.push((turn * DVec3::from(at)).as_vec3().as_dvec3());
                    positions.len() as u32 - 1
                })
            };
            for i in 0..n {
                for j in 0..n {
                    let [a, b, c, d] =
                        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| vertex(i + x, j + y));
                    let halves = [[a, b, c], [a, c, d]];
                    triangles.extend(
                        halves.map(|[p, q, r]| if side == 0 { [p, r, q] } else { [p, q, r] }),
                    );
                }
            }
        }
    }
    Mesh::new(positions, triangles)
}
