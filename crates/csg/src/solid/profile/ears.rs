//! Polygons cut into triangles.

use glam::DVec2;

use super::Profile;
use super::monotone::orient;

impl Profile {
    /// Triangles that make up a simple counter-clockwise polygon, by cutting
    /// off ears (G. H. Meisters, "Polygons have ears", 1975): corner indices.
    /// Quadratic in the number of corners, cubic at worst.
    pub(crate) fn ears(points: &[DVec2]) -> Vec<[usize; 3]> {
        let mut rest: Vec<usize> = (0..points.len()).collect();
        let mut triangles = Vec::with_capacity(points.len());
        while rest.len() > 3 {
            let count = rest.len();
            let corners = |k: usize| [(k + count - 1) % count, k, (k + 1) % count].map(|k| rest[k]);
            let turn = |k: usize| {
                let [a, b, c] = corners(k).map(|i| points[i]);
                orient(a, b, c)
            };
            let is_ear = |&k: &usize| {
                let triangle = corners(k);
                let [a, b, c] = triangle.map(|i| points[i]);
                turn(k) > 0.0
                    && rest.iter().filter(|i| !triangle.contains(i)).all(|&i| {
                        let p = points[i];
                        p == a
                            || p == b
                            || p == c
                            || orient(a, b, p) < 0.0
                            || orient(b, c, p) < 0.0
                            || orient(c, a, p) < 0.0
                    })
            };
            // A straight corner, or whatever is left of a polygon that is not simple.
            let ear = (0..count)
                .find(is_ear)
                .or_else(|| (0..count).find(|&k| turn(k) == 0.0))
                .unwrap_or(0);
            triangles.push(corners(ear));
            rest.remove(ear);
        }
        if let [a, b, c] = rest[..] {
            triangles.push([a, b, c]);
        }
        triangles
    }
}
