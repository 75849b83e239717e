//! Colours by how far triangles are from the surfaces they stand for.

use csg::{Mesh, Surface};
use glam::DVec3;

use crate::color_map::{Legend, by_value, corners, keep_feature_edges};

/// Gives a mesh colours that tell how far its triangles are from the surfaces
/// that they lie on, of which these are the
/// [program](csg::Program::surfaces)'s, and returns what they stand for. Of each
/// triangle its middle and those of its sides are looked at, where the distance
/// from surfaces that are curved alike all over is greatest. Triangles without a
/// surface keep none. O(n).
pub fn color_by_deviation(mesh: &mut Mesh, surfaces: &[Surface]) -> Legend {
    keep_feature_edges(mesh);
    by_value(mesh, "deviation", None, |mesh, triangle| {
        let own = *mesh.triangle_surfaces.get(triangle)?;
        let own = mesh.surfaces.get(own as usize)?.surface;
        let surface = surfaces.get(own as usize)?;
        let [a, b, c] = corners(mesh, triangle)?;
        let middles = [a + b, b + c, c + a].map(|sum| sum / 2.0);
        let middles = middles.into_iter().chain([(a + b + c) / 3.0]);
        middles.map(|p| distance(surface, p)).reduce(f64::max)
    })
}

/// How far a point near a surface is from it: to where steps along the gradient
/// (Newton's) lead, which is nearest for planes, spheres and round cylinders, and
/// for others but for terms of third order.
fn distance(surface: &Surface, point: DVec3) -> f64 {
    /// Each step doubles the digits.
    const STEPS: usize = 6;
    let mut foot = point;
    for _ in 0..STEPS {
        let gradient = surface.gradient(foot);
        let step = gradient * (surface.value(foot) / gradient.length_squared());
        if !step.is_finite() {
            break;
        }
        foot -= step;
    }
    point.distance(foot)
}
