//! Feature edges, silhouettes and wireframe, drawn over shading.

use std::collections::HashMap;

use csg::Color;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::frame::FrameMatrix;
use crate::image::Image;
use crate::line::project_polyline;
use crate::normals::CREASE_ANGLE;
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::silhouette::silhouettes;
use crate::visible::{Drawn, LineLayers};

/// What happens to the hidden parts of edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HiddenEdges {
    /// They are left out.
    #[default]
    Omit,
    /// They are drawn dashed and lighter.
    Dash,
}

/// The widest line, in pixels.
pub const MAX_LINE_WIDTH: f64 = 256.0;

/// Which edges are drawn over the picture, and how.
///
/// ```
/// use raster::{EdgeOptions, HiddenEdges, RenderOptions};
/// let edges = EdgeOptions::default().hidden(HiddenEdges::Dash).width(2.0);
/// assert!(edges.features && edges.silhouettes);
/// let options = RenderOptions::default().edges(Some(edges));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct EdgeOptions {
    /// Feature edges: the mesh's own, or else where two faces meet at more
    /// than 30 degrees or lie on different surfaces.
    pub features: bool,
    /// Where a smooth surface turns away from the viewer.
    pub silhouettes: bool,
    /// Every edge of every triangle.
    pub wireframe: bool,
    /// Every vertex, as a dot of three times the line width.
    pub points: bool,
    /// What happens to hidden parts.
    pub hidden: HiddenEdges,
    /// Line width in pixels, above 0 and up to [`MAX_LINE_WIDTH`].
    pub width: f64,
    /// Colour of the lines.
    pub color: Color,
}

impl Default for EdgeOptions {
    fn default() -> Self {
        Self {
            features: true,
            silhouettes: true,
            wireframe: false,
            points: false,
            hidden: HiddenEdges::Omit,
            width: 1.2,
            color: Color::from_linear([0.01; 3]),
        }
    }
}

impl EdgeOptions {
    /// Sets whether feature edges are drawn.
    #[must_use]
    pub fn features(mut self, drawn: bool) -> Self {
        self.features = drawn;
        self
    }

    /// Sets whether silhouettes are drawn.
    #[must_use]
    pub fn silhouettes(mut self, drawn: bool) -> Self {
        self.silhouettes = drawn;
        self
    }

    /// Sets whether every edge of every triangle is drawn.
    #[must_use]
    pub fn wireframe(mut self, drawn: bool) -> Self {
        self.wireframe = drawn;
        self
    }

    /// Sets whether vertices are drawn.
    #[must_use]
    pub fn points(mut self, drawn: bool) -> Self {
        self.points = drawn;
        self
    }

    /// Sets what happens to hidden parts.
    #[must_use]
    pub fn hidden(mut self, hidden: HiddenEdges) -> Self {
        self.hidden = hidden;
        self
    }

    /// Sets the width of lines in pixels, above 0 and up to [`MAX_LINE_WIDTH`].
    #[must_use]
    pub fn width(mut self, pixels: f64) -> Self {
        self.width = pixels;
        self
    }

    /// Sets the colour of lines.
    #[must_use]
    pub fn color(mut self, color: Color) -> Self {
        self.color = color;
        self
    }
}

/// Opacity of hidden edges relative to visible ones.
const HIDDEN_OPACITY: f32 = 0.45;

/// Draws the edges of a scene over its picture.
pub(crate) fn draw_edges(
    renderer: &Renderer,
    scene: &Prepared,
    matrix: &FrameMatrix,
    options: &EdgeOptions,
    image: &mut Image,
) {
    let dashed = options.hidden == HiddenEdges::Dash;
    let mut lines = Lines {
        layers: LineLayers::new(image.width, image.height, dashed),
        frame: Drawn {
            renderer,
            scene,
            matrix,
        },
    };
    let width = options.width;
    if options.features {
        lines.draw(scene.feature_edges(), width, |line| line.iter().copied());
    }
    if options.silhouettes {
        let silhouettes = silhouettes(scene, matrix);
        lines.draw(&silhouettes, width, |ends| ends.iter().copied());
    }
    if options.wireframe {
        let triangles = &scene.triangles[..scene.kept_triangles];
        lines.draw(triangles, width, |&[a, b, c]| [a, b, c, a].into_iter());
    }
    if options.points {
        let vertices: Vec<_> = (0..scene.kept_vertices as u32).collect();
        lines.draw(&vertices, width * 3.0, |&v| [v, v].into_iter());
    }
    let mut layers = lines.layers;
    if let Some(hidden) = &mut layers.hidden {
        hidden.thin();
        let faint = options
            .color
            .with_alpha(options.color.alpha * HIDDEN_OPACITY);
        hidden.composite(image, faint);
    }
    layers.visible.composite(image, options.color);
}

/// Lines of a scene over a frame of it.
struct Lines<'a> {
    layers: LineLayers,
    frame: Drawn<'a>,
}

impl Lines<'_> {
    /// Draws polylines through vertices, of one width.
    fn draw<'l, L: Sync, V: Iterator<Item = u32>>(
        &mut self,
        lines: &'l [L],
        width: f64,
        vertices: impl Fn(&'l L) -> V + Sync,
    ) {
        /// Lines that are kept in the window's coordinates at a time.
        const AT_ONCE: usize = 1 << 16;
        let Drawn { scene, matrix, .. } = self.frame;
        let project = |line: &'l L| {
            let points = vertices(line).filter_map(|vertex| scene.position(vertex));
            project_polyline(matrix, points)
        };
        for lines in lines.chunks(AT_ONCE) {
            let lines = lines.par_iter().with_min_len(64);
            let segments: Vec<_> = lines.flat_map_iter(project).collect();
            self.layers.draw(self.frame, &segments, width);
        }
    }
}

/// For each vertex the first one at the same position.
fn weld(scene: &Prepared) -> Vec<u32> {
    let mut first_at: HashMap<[u64; 3], u32> = HashMap::new();
    (0..scene.positions.len() as u32)
        .map(|index| {
            // Adding zero makes -0 and 0 the same.
            let p = scene.position(index).unwrap_or_default() + DVec3::ZERO;
            let key = p.to_array().map(f64::to_bits);
            *first_at.entry(key).or_insert(index)
        })
        .collect()
}

/// Facets of one body are taken for one surface where they meet at less than this angle, 20
/// degrees: by no more do meshes turn along an edge that are made without other wishes.
const FACET_ANGLE: f64 = std::f64::consts::PI / 9.0;

/// The feature edges of a mesh that brings none, each as a polyline of two
/// vertices: edges that do not join exactly two triangles; and those that join
/// two surfaces, or two triangles more than [`CREASE_ANGLE`] apart, unless
/// these have the same normals there, or ones within [`FACET_ANGLE`] on surfaces of one body
/// ([`csg::MeshSurface::body`]): facets of something twisted, say. Vertices at the same position
/// count as one. O(n log n).
pub(crate) fn find_feature_edges(scene: &Prepared) -> Vec<Vec<u32>> {
    let welded = weld(scene);
    let mut edges: Vec<[u32; 3]> = Vec::with_capacity(scene.triangles.len() * 3);
    let kept = scene.triangles.iter().take(scene.kept_triangles);
    for (index, triangle) in kept.enumerate() {
        if scene.corners(index).is_none() {
            continue;
        }
        let [a, b, c] = triangle.map(|v| welded[v as usize]);
        for (i, j) in [(a, b), (b, c), (c, a)] {
            if i != j {
                edges.push([i.min(j), i.max(j), index as u32]);
            }
        }
    }
    edges.sort_unstable();
    let normal = |triangle: u32| {
        let [a, b, c] = scene.corners(triangle as usize).unwrap_or_default();
        (b - a).cross(c - a).normalize_or_zero()
    };
    let surface = |triangle: u32| scene.triangle_surfaces.get(triangle as usize);
    // Triangles turn by what chords leave over: that surfaces are tangent, or
    // that there is but one, normals at the corners tell.
    let smooth = |triangle: u32, ends: [u32; 2]| {
        let normals = scene.corner_normals(triangle as usize)?;
        let corners = scene.triangles[triangle as usize].map(|v| welded[v as usize]);
        let at = |end: u32| corners.iter().position(|&corner| corner == end);
        let [a, b] = [normals[at(ends[0])?], normals[at(ends[1])?]].map(Vec3::as_dvec3);
        (a.is_normalized() && b.is_normalized()).then_some([a, b])
    };
    let body = |triangle: u32| {
        let body = scene.bodies.get(*surface(triangle)? as usize);
        body.filter(|&&body| body != 0)
    };
    let crease = CREASE_ANGLE.cos();
    edges
        .chunk_by(|a, b| a[..2] == b[..2])
        .filter(|group| match **group {
            [[i, j, s], [_, _, t]] => {
                let faces = normal(s).dot(normal(t));
                if surface(s) == surface(t) && faces >= crease {
                    return false;
                }
                let cosine = match smooth(s, [i, j]).zip(smooth(t, [i, j])) {
                    Some(([a, b], [c, d])) => a.dot(c).min(b.dot(d)),
                    None => faces,
                };
                let are_facets = body(s).is_some() && body(s) == body(t);
                let same = if are_facets {
                    FACET_ANGLE.cos()
                } else {
                    1.0 - 1e-6
                };
                cosine < same
            }
            _ => true,
        })
        .filter_map(|group| group.first().map(|&[i, j, _]| vec![i, j]))
        .collect()
}
