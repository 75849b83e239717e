//! A mesh as files want it: checked, and sorted into parts, and these into groups of faces of
//! one name and one colour.

use csg::mesh::Components;
use csg::{Color, Mesh, MeshSurface};
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;

use crate::bodies;
use crate::{Error, MeshFormat};

/// Bodies whose faces have these names around them all.
pub(crate) struct Part<'a> {
    /// The outermost first; empty where they have none in common.
    pub names: Names<'a>,
    /// Those without other names first.
    pub groups: Vec<Group<'a>>,
}

/// Names one within the other, the outermost first.
pub(crate) type Names<'a> = Vec<&'a str>;

/// Triangles of one part, one name and one colour.
pub(crate) struct Group<'a> {
    /// All names around them, those of the part among them.
    pub names: Names<'a>,
    /// Index into [`Parts::colors`].
    pub color: usize,
    /// Indices of the triangles, ascending.
    pub triangles: Vec<u32>,
}

/// All triangles of a mesh, part by part.
pub(crate) struct Parts<'a> {
    /// In the order of first appearance, but one without names first.
    pub parts: Vec<Part<'a>>,
    /// The distinct colours, `None` for triangles without.
    pub colors: Vec<Option<Color>>,
}

impl<'a> Parts<'a> {
    /// Checks the mesh and sorts its triangles.
    pub(crate) fn of(mesh: &'a Mesh, format: MeshFormat) -> Result<Self, Error> {
        check(mesh, format)?;
        let mut looks = Looks::of(mesh);
        let part_of = looks.parts(mesh);
        let mut slots: FxHashMap<(usize, usize), usize> = FxHashMap::default();
        let mut found: Vec<(usize, usize, Group<'a>)> = Vec::new();
        let mut last: Option<((usize, usize), usize)> = None;
        for index in 0..mesh.triangles.len() {
            let look = looks.of_surface[surface(mesh, index)];
            let key = (part_of(index), look);
            let slot = match last {
                Some((known, slot)) if known == key => slot,
                _ => *slots.entry(key).or_insert_with(|| {
                    let (names, color) = looks.looks[look];
                    let group = Group {
                        names: looks.names[names].clone(),
                        color,
                        triangles: Vec::new(),
                    };
                    found.push((key.0, names, group));
                    found.len() - 1
                }),
            };
            last = Some((key, slot));
            found[slot].2.triangles.push(index as u32);
        }
        // Names are numbered as they appear, none being 0.
        found.sort_by_key(|&(part, names, _)| (part, names != part, names));
        let mut parts: Vec<(usize, Part<'a>)> = Vec::new();
        for (part, _, group) in found {
            match parts.last_mut() {
                Some((last, to)) if *last == part => to.groups.push(group),
                _ => {
                    let names = looks.names[part].clone();
                    let groups = vec![group];
                    parts.push((part, Part { names, groups }));
                }
            }
        }
        Ok(Self {
            parts: parts.into_iter().map(|(_, part)| part).collect(),
            colors: looks.colors,
        })
    }

    /// All groups of all parts.
    pub(crate) fn groups(&self) -> impl Iterator<Item = &Group<'a>> {
        self.parts.iter().flat_map(|part| &part.groups)
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

/// The surface of a triangle; one beyond all others stands for none.
fn surface(mesh: &Mesh, triangle: usize) -> usize {
    let of_triangle = mesh.triangle_surfaces.get(triangle);
    of_triangle.map_or(mesh.surfaces.len(), |&surface| {
        (surface as usize).min(mesh.surfaces.len())
    })
}

/// The distinct names and colours of a mesh's triangles.
struct Looks<'a> {
    /// Numbered as they appear, none being 0.
    names: Vec<Names<'a>>,
    colors: Vec<Option<Color>>,
    /// Names and colour.
    looks: Vec<(usize, usize)>,
    /// For each surface, and for none, its look; of surfaces without triangles it is 0.
    of_surface: Vec<usize>,
}

impl<'a> Looks<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        let mut all_names = vec![Vec::new()];
        let mut names: FxHashMap<Names<'a>, usize> = FxHashMap::default();
        names.insert(Vec::new(), 0);
        let (mut colors, mut looks) = (Vec::new(), Vec::new());
        let mut color_slots: FxHashMap<Option<ColorBits>, usize> = FxHashMap::default();
        let mut slots: FxHashMap<(usize, usize), usize> = FxHashMap::default();
        let mut of_surface = vec![usize::MAX; mesh.surfaces.len() + 1];
        for index in 0..mesh.triangles.len() {
            let surface = surface(mesh, index);
            if of_surface[surface] != usize::MAX {
                continue;
            }
            let entry: Option<&MeshSurface> = mesh.surfaces.get(surface);
            let of_entry: Names<'a> = entry.map_or(Vec::new(), |entry| {
                let names = entry.parts.iter().chain(&entry.name);
                names.map(AsRef::as_ref).collect()
            });
            let name = *names.entry(of_entry).or_insert_with_key(|names| {
                all_names.push(names.clone());
                all_names.len() - 1
            });
            let color = entry.and_then(|e| e.color).map(in_gamut);
            let color = *color_slots.entry(color.map(color_bits)).or_insert_with(|| {
                colors.push(color);
                colors.len() - 1
            });
            of_surface[surface] = *slots.entry((name, color)).or_insert_with(|| {
                looks.push((name, color));
                looks.len() - 1
            });
        }
        Self {
            names: all_names,
            colors,
            looks,
            of_surface,
        }
    }

    /// For each triangle the number of its part's names: those that the faces of its body
    /// have in common.
    fn parts(&mut self, mesh: &Mesh) -> impl Fn(usize) -> usize + use<> {
        let mut used = self.looks.iter().map(|look| look.0);
        let first = used.next().unwrap_or_default();
        let is_one = used.all(|names| names == first);
        let of_bodies = (!is_one).then(|| self.names_of_bodies(mesh));
        move |triangle| match &of_bodies {
            None => first,
            // (A triangle of no area is part of no body.)
            Some((components, names)) => {
                components.of_triangles[triangle].map_or(0, |body| names[body as usize])
            }
        }
    }

    /// The components of a mesh, and the names that the faces of each have in common, of the
    /// wall of a void those of the body around it.
    fn names_of_bodies(&mut self, mesh: &Mesh) -> (Components, Vec<usize>) {
        let components = mesh.components();
        let mut common: Vec<Option<usize>> = vec![None; components.count];
        let mut known: FxHashMap<(usize, usize), usize> = FxHashMap::default();
        for (index, component) in components.of_triangles.iter().enumerate() {
            let Some(component) = component else { continue };
            let (names, _) = self.looks[self.of_surface[surface(mesh, index)]];
            let common = &mut common[*component as usize];
            *common = Some(match *common {
                None => names,
                Some(before) if before == names || before == 0 => before,
                Some(before) => *known
                    .entry((before, names))
                    .or_insert_with(|| self.common(before, names)),
            });
        }
        let names: Vec<usize> = common.into_iter().map(Option::unwrap_or_default).collect();
        if names.iter().all(|&of| of == names[0]) {
            return (components, names);
        }
        let owners = bodies::owners(mesh, &components, |a, b| names[a] != names[b]);
        let names = owners.into_iter().map(|owner| names[owner]).collect();
        (components, names)
    }

    /// What two lists of names begin with both.
    fn common(&mut self, one: usize, other: usize) -> usize {
        let pairs = self.names[one].iter().zip(&self.names[other]);
        let count = pairs.take_while(|(a, b)| a == b).count();
        let common = &self.names[one][..count];
        if let Some(known) = self.names.iter().position(|names| names == common) {
            return known;
        }
        self.names.push(common.to_vec());
        self.names.len() - 1
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
