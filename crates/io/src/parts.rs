//! A mesh as files want it: checked, and sorted into parts of one name and
//! one colour.

use csg::{Color, Mesh, MeshSurface};
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;

use crate::{Error, MeshFormat};

/// Triangles of one name and one colour.
pub(crate) struct Part<'a> {
    /// The name, if any.
    pub name: Option<&'a str>,
    /// Index into [`Parts::colors`].
    pub color: usize,
    /// Indices of the triangles, ascending.
    pub triangles: Vec<u32>,
}

/// All triangles of a mesh, part by part.
pub(crate) struct Parts<'a> {
    /// Parts of one name stand together; otherwise in the order of first
    /// appearance, but the unnamed first.
    pub parts: Vec<Part<'a>>,
    /// The distinct colours, `None` for triangles without.
    pub colors: Vec<Option<Color>>,
}

impl<'a> Parts<'a> {
    /// Checks the mesh and sorts its triangles.
    pub(crate) fn of(mesh: &'a Mesh, format: MeshFormat) -> Result<Self, Error> {
        check(mesh, format)?;
        let mut names: FxHashMap<Option<&str>, usize> = FxHashMap::default();
        names.insert(None, 0);
        let mut color_slots: FxHashMap<Option<ColorBits>, usize> = FxHashMap::default();
        let mut colors = Vec::new();
        let mut slots: FxHashMap<(usize, usize), usize> = FxHashMap::default();
        let mut found: Vec<(usize, Part<'a>)> = Vec::new();
        // The part of each surface, once it has been met; the last entry is
        // that of triangles without provenance.
        let mut of_surface = vec![usize::MAX; mesh.surfaces.len() + 1];
        for index in 0..mesh.triangles.len() {
            let surface = match mesh.triangle_surfaces.get(index) {
                Some(&surface) => (surface as usize).min(mesh.surfaces.len()),
                None => mesh.surfaces.len(),
            };
            if of_surface[surface] == usize::MAX {
                let entry: Option<&MeshSurface> = mesh.surfaces.get(surface);
                let name = entry.and_then(|e| e.name.as_deref());
                let count = names.len();
                let name_slot = *names.entry(name).or_insert(count);
                let color = entry.and_then(|e| e.color).map(in_gamut);
                let color_slot = *color_slots.entry(color.map(color_bits)).or_insert_with(|| {
                    colors.push(color);
                    colors.len() - 1
                });
                of_surface[surface] = *slots.entry((name_slot, color_slot)).or_insert_with(|| {
                    let part = Part {
                        name,
                        color: color_slot,
                        triangles: Vec::new(),
                    };
                    found.push((name_slot, part));
                    found.len() - 1
                });
            }
            found[of_surface[surface]].1.triangles.push(index as u32);
        }
        found.sort_by_key(|&(name, _)| name);
        Ok(Self {
            parts: found.into_iter().map(|(_, part)| part).collect(),
            colors,
        })
    }

    /// Whether any triangle has a colour.
    pub(crate) fn has_colors(&self) -> bool {
        self.colors.iter().any(Option::is_some)
    }

    /// A name for each colour that differs from all others: its place and its
    /// sRGB digits, or "default" for the triangles without a colour.
    pub(crate) fn color_name(&self, index: usize) -> String {
        match self.colors[index] {
            Some(color) => format!("color{index}-{}", &hex(color)[1..]),
            None => DEFAULT_MATERIAL.to_owned(),
        }
    }
}

/// A colour as something that can be a key.
pub(crate) type ColorBits = [u32; 4];

pub(crate) fn color_bits(color: Color) -> ColorBits {
    let [r, g, b] = color.rgb;
    [r, g, b, color.alpha].map(f32::to_bits)
}

/// The material of triangles without a colour.
pub(crate) const DEFAULT_MATERIAL: &str = "default";

/// What is shown where nobody chose a colour: a light grey.
pub(crate) const DEFAULT_COLOR: Color = Color::from_linear([0.6, 0.6, 0.6]);

/// The colour's sRGB digits as `#RRGGBB`, or `#RRGGBBAA` unless opaque.
pub(crate) fn hex(color: Color) -> String {
    let [r, g, b] = color.to_srgb().map(byte);
    match byte(color.alpha) {
        255 => format!("#{r:02X}{g:02X}{b:02X}"),
        a => format!("#{r:02X}{g:02X}{b:02X}{a:02X}"),
    }
}

/// A component in 0..=1 as a byte.
pub(crate) fn byte(component: f32) -> u8 {
    (component * 255.0).round() as u8
}

/// The colour with every component forced into 0..=1 (NaN becomes 0).
pub(crate) fn in_gamut(color: Color) -> Color {
    let clamp = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    Color {
        rgb: color.rgb.map(clamp),
        alpha: clamp(color.alpha),
    }
}

/// Refuses what no file should hold.
fn check(mesh: &Mesh, format: MeshFormat) -> Result<(), Error> {
    let invalid = |problem: String| Err(Error::InvalidMesh { problem });
    if mesh.triangles.is_empty() {
        return Err(Error::EmptyMesh);
    }
    if u32::try_from(mesh.triangles.len()).is_err() {
        return Err(Error::DoesNotFit {
            format,
            problem: "it has more than 2^32 triangles; mesh it coarser or in parts".to_owned(),
        });
    }
    for (what, length) in [
        ("triangle_surfaces", mesh.triangle_surfaces.len()),
        ("corner_normals", mesh.corner_normals.len()),
    ] {
        if length != 0 && length != mesh.triangles.len() {
            return invalid(format!(
                "{what} has {length} entries for {} triangles; it must be empty or as long",
                mesh.triangles.len()
            ));
        }
    }
    check_finite(&mesh.positions)?;
    let in_range = |t: &[u32; 3]| t.iter().all(|&v| (v as usize) < mesh.positions.len());
    if let Some(index) = mesh.triangles.iter().position(|t| !in_range(t)) {
        return invalid(format!(
            "triangle {index} names the vertices {:?}, but there are only {}",
            mesh.triangles[index],
            mesh.positions.len()
        ));
    }
    Ok(())
}

/// Refuses places that are none.
pub(crate) fn check_finite(positions: &[DVec3]) -> Result<(), Error> {
    match positions.iter().position(|p| !p.is_finite()) {
        None => Ok(()),
        Some(vertex) => Err(Error::InvalidMesh {
            problem: format!(
                "vertex {vertex} is at {}; every coordinate must be finite",
                positions[vertex]
            ),
        }),
    }
}

/// The unit normal of a triangle; zero if it has none.
pub(crate) fn face_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    // Edges scaled to about 1, so that their product neither over- nor underflows.
    let (u, v) = (b - a, c - a);
    let size = u.abs().max(v.abs()).max_element();
    if size > 0.0 && size.is_finite() {
        (u / size).cross(v / size).normalize_or_zero()
    } else {
        DVec3::ZERO
    }
}

/// The normals at the corners of a triangle, each of unit length: those of
/// the mesh, else the face's, else +Z. `None` if the mesh has no normals.
pub(crate) fn unit_normals(mesh: &Mesh, triangle: usize) -> Option<[Vec3; 3]> {
    let normals = mesh.corner_normals.get(triangle)?;
    Some(normals.map(|normal| {
        let unit = normal.as_dvec3().normalize_or_zero();
        if unit != DVec3::ZERO {
            return unit.as_vec3();
        }
        match face_normal(mesh.corners(triangle)) {
            DVec3::ZERO => Vec3::Z,
            face => face.as_vec3(),
        }
    }))
}
