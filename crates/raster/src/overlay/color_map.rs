//! Colours that tell a number or a name, and their legend.

use csg::{Color, Mesh, MeshSurface};
use glam::{DVec2, DVec3, Vec3};

use crate::dimension::written;
use crate::image::Image;
use crate::lettering::Lettering;
use crate::prepared::Prepared;
use crate::refine::{Piece, range, refine};
use crate::resolve::encode;
use crate::thickness::{INSET, Inside};

/// What colours tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColorBy {
    /// The surface that a triangle lies on.
    Surface,
    /// The connected part that it belongs to.
    Part,
    /// How far, in degrees, a face leans from upright, outwards: 90 faces up, 0
    /// is a wall, -90 faces down.
    Draft,
    /// How much, in 1 / length, normals turn along a triangle's sides.
    Curvature,
    /// How far it is straight inwards to where the solid ends: told at points, not
    /// of whole triangles.
    Thickness,
}

/// Steps of a colour map.
const STEPS: usize = 64;

/// A legend: what the colours of a mesh stand for.
#[derive(Clone, Debug, PartialEq)]
pub enum Legend {
    /// From the least to the greatest number, in some unit.
    Range {
        /// The least number.
        low: f64,
        /// The greatest.
        high: f64,
        /// What is told, and its unit.
        title: String,
    },
    /// Names and colours.
    Names(Vec<(String, Color)>),
}

/// A colour for a share in 0..=1: dark blue over green to yellow, of even steps
/// to the eye and in grey (five points of viridis; Smith, van der Walt, 2015).
#[must_use]
pub fn ramp(share: f64) -> Color {
    const POINTS: [[f32; 3]; 5] = [
        [0.267, 0.005, 0.329],
        [0.230, 0.322, 0.546],
        [0.128, 0.567, 0.551],
        [0.369, 0.789, 0.383],
        [0.993, 0.906, 0.144],
    ];
    let at = share.clamp(0.0, 1.0) * 4.0;
    let k = (at as usize).min(3);
    let t = (at - k as f64) as f32;
    Color::from_srgb([0, 1, 2].map(|c| POINTS[k][c] + (POINTS[k + 1][c] - POINTS[k][c]) * t))
}

/// The colour of the k-th name: hues a golden angle apart.
#[must_use]
pub fn name_color(number: usize) -> Color {
    let hue = (number as f32 * 0.618_034 + 0.58).fract() * 6.0;
    let wave = |shift: f32| {
        let distance = ((hue + shift).rem_euclid(6.0) - 3.0).abs() - 1.0;
        0.35 + 0.5 * distance.clamp(0.0, 1.0)
    };
    Color::from_srgb([wave(0.0), wave(4.0), wave(2.0)])
}

impl ColorBy {
    /// Gives a mesh colours that tell what is asked for, and returns what they
    /// stand for. O(n) for n triangles; thickness O(n log n), or more where
    /// triangles lie together, and n counts the parts that triangles are divided
    /// into, so that each has one colour.
    pub fn apply(self, mesh: &mut Mesh) -> Legend {
        keep_feature_edges(mesh);
        match self {
            Self::Surface => by_surface(mesh),
            Self::Part => {
                let parts = connected_parts(mesh);
                by_number(mesh, &parts, |k| format!("part {}", k + 1))
            }
            Self::Draft => by_value(mesh, "draft (°)", Some([-90.0, 90.0]), |mesh, t| {
                Some(unit_normal(mesh, t)?.z.clamp(-1.0, 1.0).asin().to_degrees())
            }),
            Self::Curvature => by_value(mesh, "curvature", None, curvature),
            Self::Thickness => {
                let rays = Inside::new(mesh);
                let value = |piece: &Piece, corner, at| rays.thickness(piece, corner, at);
                let pieces = refine(mesh, 1.0 / (STEPS - 1) as f64, value);
                let [low, high] = range(&pieces);
                // At the edge of a wedge it is 0.
                let low = if low < high * 2.0 * INSET { 0.0 } else { low };
                by_value(mesh, "thickness", Some([low, high]), |_, t| {
                    pieces[t].mean()
                })
            }
        }
    }
}

/// Gives a mesh its feature edges, if it has none yet: where colours change there
/// need not be one.
pub(crate) fn keep_feature_edges(mesh: &mut Mesh) {
    if mesh.feature_edges.is_empty() {
        mesh.feature_edges = Prepared::new(mesh).feature_edges().to_vec();
    }
}

fn by_surface(mesh: &mut Mesh) -> Legend {
    if mesh.triangle_surfaces.len() != mesh.triangles.len() {
        return Legend::Names(Vec::new());
    }
    let mut names = Vec::new();
    for (number, surface) in mesh.surfaces.iter_mut().enumerate() {
        let color = name_color(number);
        surface.color = Some(color);
        if let Some(name) = &surface.name
            && !names.iter().any(|(known, _)| known == &**name)
        {
            names.push((name.to_string(), color));
        }
    }
    Legend::Names(names)
}

/// The number of each triangle's connected part, in the order of their first
/// triangles.
pub(crate) fn connected_parts(mesh: &Mesh) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    let known = |t: &[u32; 3]| t.iter().all(|&v| (v as usize) < mesh.positions.len());
    for &[a, b, c] in mesh.triangles.iter().filter(|t| known(t)) {
        for other in [b, c] {
            let (one, other) = (root(&mut parent, a), root(&mut parent, other));
            parent[one.max(other) as usize] = one.min(other);
        }
    }
    let mut numbers = std::collections::HashMap::new();
    let triangles = mesh.triangles.iter();
    triangles
        .map(|t| {
            let next = numbers.len() as u32;
            let key = if known(t) {
                root(&mut parent, t[0])
            } else {
                u32::MAX
            };
            *numbers.entry(key).or_insert(next)
        })
        .collect()
}

fn by_number(mesh: &mut Mesh, numbers: &[u32], name: impl Fn(usize) -> String) -> Legend {
    let count = numbers.iter().max().map_or(0, |&last| last as usize + 1);
    let entries: Vec<_> = (0..count).map(|k| (name(k), name_color(k))).collect();
    let colored = entries.iter().map(|(_, color)| MeshSurface {
        color: Some(*color),
        ..MeshSurface::default()
    });
    mesh.surfaces = colored.collect();
    mesh.triangle_surfaces = numbers.to_vec();
    Legend::Names(entries)
}

pub(crate) fn by_value(
    mesh: &mut Mesh,
    title: &str,
    range: Option<[f64; 2]>,
    value: impl Fn(&Mesh, usize) -> Option<f64>,
) -> Legend {
    let values: Vec<_> = (0..mesh.triangles.len()).map(|t| value(mesh, t)).collect();
    let known = || values.iter().flatten().copied().filter(|v| v.is_finite());
    let low = known().fold(f64::INFINITY, f64::min);
    let high = known().fold(f64::NEG_INFINITY, f64::max);
    let [low, high] = range.unwrap_or(if low <= high { [low, high] } else { [0.0, 0.0] });
    let step = |value: f64| {
        let share = if high > low {
            (value - low) / (high - low)
        } else {
            0.0
        };
        (share * (STEPS - 1) as f64)
            .round()
            .clamp(0.0, (STEPS - 1) as f64) as u32
    };
    // Triangles of which nothing is known have no surface.
    let surfaces = values.iter().map(|value| value.map_or(STEPS as u32, step));
    mesh.triangle_surfaces = surfaces.collect();
    mesh.surfaces = (0..STEPS)
        .map(|k| MeshSurface {
            color: Some(ramp(k as f64 / (STEPS - 1) as f64)),
            ..MeshSurface::default()
        })
        .collect();
    Legend::Range {
        low,
        high,
        title: title.into(),
    }
}

pub(crate) fn corners(mesh: &Mesh, triangle: usize) -> Option<[DVec3; 3]> {
    let at = |v: u32| mesh.positions.get(v as usize).copied();
    let [a, b, c] = *mesh.triangles.get(triangle)?;
    Some([at(a)?, at(b)?, at(c)?])
}

fn unit_normal(mesh: &Mesh, triangle: usize) -> Option<DVec3> {
    let [a, b, c] = corners(mesh, triangle)?;
    (b - a).cross(c - a).try_normalize()
}

/// The greatest change of normals along a triangle's sides, by their length.
fn curvature(mesh: &Mesh, triangle: usize) -> Option<f64> {
    let corners = corners(mesh, triangle)?;
    let normals = mesh.corner_normals.get(triangle)?.map(Vec3::as_dvec3);
    let change = |i: usize, j: usize| {
        let length = corners[i].distance(corners[j]);
        (length > 0.0).then(|| normals[i].distance(normals[j]) / length)
    };
    let sides = [change(0, 1), change(1, 2), change(2, 0)];
    sides.into_iter().flatten().reduce(f64::max)
}

/// Draws a legend at the picture's right border.
pub fn draw_legend(legend: &Legend, color: Color, image: &mut Image) {
    let (width, height) = (f64::from(image.width), f64::from(image.height));
    let text = (width.min(height) / 50.0).clamp(7.0, 36.0);
    let write = |image: &mut Image, label: &str, at: DVec2| {
        Lettering {
            text: label,
            at,
            height: text,
            color,
        }
        .draw(image);
    };
    let left = width - text * 11.0;
    match legend {
        Legend::Range { low, high, title } => {
            let (top, bottom) = (height * 0.2, height * 0.8);
            for y in top as u32..bottom as u32 {
                let share = (bottom - f64::from(y)) / (bottom - top);
                fill(image, [left, f64::from(y)], [text * 1.5, 1.0], ramp(share));
            }
            write(image, title, DVec2::new(left, top - text * 1.5));
            for (k, value) in [*high, low.midpoint(*high), *low].into_iter().enumerate() {
                let y = top + (bottom - top) * k as f64 / 2.0;
                let at = DVec2::new(left + text * 2.2, y + text / 2.0);
                write(image, &written(value), at);
            }
        }
        Legend::Names(names) => {
            let most = ((height * 0.8 / (text * 2.0)) as usize).max(1);
            let top = (height - names.len().min(most) as f64 * text * 2.0) / 2.0;
            for (k, (name, own)) in names.iter().take(most).enumerate() {
                let y = top + k as f64 * text * 2.0;
                fill(image, [left, y], [text * 1.4; 2], *own);
                write(image, name, DVec2::new(left + text * 2.2, y + text * 1.2));
            }
        }
    }
}

fn fill(image: &mut Image, [left, top]: [f64; 2], [width, height]: [f64; 2], color: Color) {
    let pixel = encode(color);
    let (right, bottom) = ((left + width) as u32, (top + height) as u32);
    for y in top.max(0.0) as u32..bottom.min(image.height) {
        for x in left.max(0.0) as u32..right.min(image.width) {
            let at = y as usize * image.width as usize + x as usize;
            image.pixels[at] = pixel;
        }
    }
}
