//! What is wrong with a mesh, told from its program alone and not by the
//! mesher's word. The benchmarks use it as well.

use std::collections::HashSet;

use csg::program::Surface;
use csg::{Mesh, Program};
use glam::DVec3;
use stereotomy::csg;

/// Defects of a mesh against its program; lengths relative to the scene.
#[derive(Debug, Default)]
pub struct Measures {
    /// The largest distance of a vertex from a surface that one of its
    /// triangles claims, to first order.
    pub miss: f64,
    /// Triangles against the outward gradient of their surface.
    pub folded: usize,
    /// Triangles less high than rounding.
    pub without_area: usize,
    /// Triangles on the same three points as another.
    pub duplicates: usize,
    /// Of each defect, the first place.
    pub places: Vec<(&'static str, DVec3)>,
}

impl Measures {
    fn add(&mut self, what: &'static str, place: DVec3) {
        match what {
            "folded" => self.folded += 1,
            "without area" => self.without_area += 1,
            _ => self.duplicates += 1,
        }
        if self.places.iter().all(|(known, _)| *known != what) {
            self.places.push((what, place));
        }
    }
}

/// The length of a mesh's diagonal.
pub fn size(mesh: &Mesh) -> f64 {
    mesh.bounds().map_or(0.0, |(low, high)| low.distance(high))
}

/// The largest distance, in model units and to first order, of a vertex from
/// a surface that one of its triangles claims.
pub fn largest_miss(program: &Program, mesh: &Mesh) -> f64 {
    let mut largest = 0.0f64;
    for (triangle, &entry) in mesh.triangles.iter().zip(&mesh.triangle_surfaces) {
        let surface = &program.surfaces()[mesh.surfaces[entry as usize].surface as usize];
        for &vertex in triangle {
            let p = mesh.positions[vertex as usize];
            let value = surface.value(p).abs();
            if value > 0.0 {
                largest = largest.max(value / surface.gradient(p).length());
            }
        }
    }
    largest
}

/// Measures a mesh.
pub fn measure(program: &Program, mesh: &Mesh) -> Measures {
    let size = size(mesh);
    let mut measures = Measures {
        miss: largest_miss(program, mesh) / size,
        ..Measures::default()
    };
    let sides = Sides::of(program, mesh);
    let mut seen = HashSet::new();
    for index in 0..mesh.triangles.len() {
        let corners = mesh.corners(index);
        let [a, b, c] = corners;
        let centroid = (a + b + c) / 3.0;
        let normal = (b - a).cross(c - a);
        let longest = [b - a, c - b, a - c]
            .map(DVec3::length)
            .into_iter()
            .fold(0.0, f64::max);
        if normal.length() <= 1e-13 * size * longest {
            measures.add("without area", centroid);
        } else if sides.is_folded(index, normal) {
            measures.add("folded", centroid);
        }
        let mut points = corners.map(|p| (p + 0.0).to_array().map(f64::to_bits));
        points.sort_unstable();
        if !seen.insert(points) {
            measures.add("duplicate", centroid);
        }
    }
    measures
}

/// On which side of its surfaces the solid lies, by asking the program on both
/// sides of some triangles.
struct Sides<'a> {
    program: &'a Program,
    mesh: &'a Mesh,
    step: f64,
    /// Of each of the mesh's surfaces, whether the gradient points out of the
    /// solid (1) or into it (-1) or, on different triangles, both, or neither can
    /// be told (0).
    outward: Vec<f64>,
}

impl<'a> Sides<'a> {
    fn of(program: &'a Program, mesh: &'a Mesh) -> Self {
        let mut sides = Self {
            program,
            mesh,
            step: 1e-8 * size(mesh),
            outward: Vec::new(),
        };
        let mut triangles = vec![Vec::new(); mesh.surfaces.len()];
        for (index, &entry) in mesh.triangle_surfaces.iter().enumerate() {
            triangles[entry as usize].push(index);
        }
        let ask = |triangles: &Vec<usize>| {
            const ASKED: usize = 9;
            let asked = triangles
                .iter()
                .step_by(triangles.len().div_ceil(ASKED).max(1));
            let sides: Vec<f64> = asked.map(|&index| sides.ask(index)).collect();
            match [1.0, -1.0].map(|side| sides.contains(&side)) {
                [true, false] => 1.0,
                [false, true] => -1.0,
                _ => 0.0,
            }
        };
        let outward = triangles.iter().map(ask).collect();
        sides.outward = outward;
        sides
    }

    fn surface(&self, triangle: usize) -> &Surface {
        let entry = self.mesh.triangle_surfaces[triangle] as usize;
        &self.program.surfaces()[self.mesh.surfaces[entry].surface as usize]
    }

    /// Whether the gradient of a triangle's surface points out of the solid (1) or
    /// into it (-1) next to its centroid, or else to a point beside it; 0 if that
    /// can be told at none of them.
    fn ask(&self, triangle: usize) -> f64 {
        let corners = self.mesh.corners(triangle);
        let centroid = corners.iter().sum::<DVec3>() / 3.0;
        let beside = corners.map(|corner| centroid.lerp(corner, 0.3));
        let mut sides = [centroid].into_iter().chain(beside);
        let told = sides.find_map(|on| self.side(self.surface(triangle), on));
        told.unwrap_or(0.0)
    }

    /// The same next to a point; none beyond an edge, and where another surface is
    /// nearer than the step.
    fn side(&self, surface: &Surface, mut on: DVec3) -> Option<f64> {
        for _ in 0..3 {
            let gradient = surface.gradient(on);
            on -= surface.value(on) * gradient / gradient.length_squared();
        }
        let is_near = |other: &Surface| {
            !std::ptr::eq(other, surface)
                && other.value(on).abs() <= 2.0 * self.step * other.gradient(on).length()
        };
        if self.program.surfaces().iter().any(is_near) {
            return None;
        }
        let out = surface.gradient(on).normalize_or_zero() * self.step;
        let inside = |point| self.program.contains(point);
        match (inside(on - out), inside(on + out)) {
            (true, false) => Some(1.0),
            (false, true) => Some(-1.0),
            _ => None,
        }
    }

    /// Whether a triangle of the given normal faces into the solid. One whose
    /// centroid lies beyond an edge is judged by most of its surface.
    fn is_folded(&self, triangle: usize, normal: DVec3) -> bool {
        let centroid = self.mesh.corners(triangle).iter().sum::<DVec3>() / 3.0;
        let facing = self.surface(triangle).gradient(centroid).dot(normal);
        let usual = self.outward[self.mesh.triangle_surfaces[triangle] as usize];
        let against = facing * usual < 0.0;
        // Whoever seems folded may be where the solid is on the other side.
        (against || usual == 0.0) && {
            let own = self.ask(triangle);
            own * facing < 0.0 || (own == 0.0 && against)
        }
    }
}
