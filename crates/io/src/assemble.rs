//! What readers build a mesh with.

use std::ops::Range;
use std::sync::Arc;

use csg::{Color, LengthUnit, Mesh, MeshSurface};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::parts::{ColorBits, color_bits, in_gamut};
use crate::weld::split;
use crate::{Error, MeshFormat};

/// Collects vertices and triangles into a mesh.
pub(crate) struct Assembler {
    mesh: Mesh,
    /// Surfaces by names, one within the other, and colour.
    parts: FxHashMap<(Vec<Arc<str>>, Option<ColorBits>), u32>,
    /// The surface of triangles, and the first triangle of each run of it.
    runs: Vec<(u32, usize)>,
    /// Whether every triangle so far came with normals.
    has_normals: bool,
    /// The first triangle of each object.
    objects: Vec<usize>,
}

/// A mesh as a file has it.
pub(crate) struct Assembled {
    pub(crate) mesh: Mesh,
    /// The first triangle of each object that has any, in ascending order; of formats without
    /// objects none.
    pub(crate) objects: Vec<usize>,
}

impl From<Mesh> for Assembled {
    fn from(mesh: Mesh) -> Self {
        let objects = Vec::new();
        Self { mesh, objects }
    }
}

impl Assembler {
    pub(crate) fn new(unit: LengthUnit) -> Self {
        Self {
            mesh: Mesh {
                unit,
                ..Mesh::default()
            },
            parts: FxHashMap::default(),
            runs: Vec::new(),
            has_normals: true,
            objects: Vec::new(),
        }
    }

    /// The triangles that follow are those of another object.
    pub(crate) fn begin_object(&mut self) {
        self.objects.push(self.mesh.triangles.len());
    }

    /// The same for all objects, by their first triangles in ascending order.
    pub(crate) fn begin_objects(&mut self, firsts: Vec<usize>) {
        self.objects = firsts;
    }

    /// Adds finite vertices, not too many.
    pub(crate) fn add_vertices(&mut self, places: Vec<DVec3>) {
        if self.mesh.positions.is_empty() {
            self.mesh.positions = places;
        } else {
            self.mesh.positions.extend(places);
        }
    }

    /// A new vertex, wherever others are; `None` if its place is not finite or
    /// there are too many.
    pub(crate) fn vertex(&mut self, place: DVec3) -> Option<u32> {
        let vertex = u32::try_from(self.mesh.positions.len()).ok()?;
        place.is_finite().then(|| {
            self.mesh.positions.push(place);
            vertex
        })
    }

    /// Forgets all vertices but the first ones.
    pub(crate) fn keep_vertices(&mut self, count: usize) {
        self.mesh.positions.truncate(count);
    }

    /// How many vertices there are.
    pub(crate) fn vertex_count(&self) -> usize {
        self.mesh.positions.len()
    }

    /// The triangles that follow have these names around them, the outermost first, and this
    /// colour.
    pub(crate) fn begin_part(&mut self, names: &[&str], color: Option<Color>) {
        self.begin_part_at(self.mesh.triangles.len(), names, color);
    }

    /// [`Self::begin_part`], for the triangles from this one on.
    fn begin_part_at(&mut self, first: usize, names: &[&str], color: Option<Color>) {
        let names: Vec<Arc<str>> = names.iter().map(|&name| Arc::from(name)).collect();
        let color = color.map(in_gamut);
        let bits = color.map(color_bits);
        let surfaces = &mut self.mesh.surfaces;
        let part = *self
            .parts
            .entry((names, bits))
            .or_insert_with_key(|(names, _)| {
                let index = surfaces.len() as u32;
                surfaces.push(MeshSurface {
                    surface: index,
                    primitive: index,
                    body: 0,
                    name: names.last().cloned(),
                    parts: names[..names.len().saturating_sub(1)].into(),
                    color,
                });
                index
            });
        if self.runs.last().is_none_or(|run| run.0 != part) {
            self.runs.push((part, first));
        }
    }

    /// Adds a triangle to the current part; it vanishes if two of its vertices
    /// are one.
    pub(crate) fn triangle(&mut self, corners: [u32; 3], normals: Option<[Vec3; 3]>) {
        if self.runs.is_empty() {
            self.begin_part(&[], None);
        }
        self.mesh.triangles.push(corners);
        match normals {
            Some(normals) if self.has_normals => self.mesh.corner_normals.push(normals),
            _ => self.has_normals = false,
        }
    }

    /// The first triangles, all at once: so many in each block, whose part,
    /// corners and (where `with_normals`) normals are filled in parallel.
    ///
    /// # Errors
    /// That of the first block whose `fill` fails.
    pub(crate) fn all_triangles<'a, E: Send>(
        &mut self,
        lengths: &[usize],
        with_normals: bool,
        part: impl Fn(usize) -> (Vec<&'a str>, Option<Color>),
        fill: impl Fn(usize, &mut [[u32; 3]], &mut [[Vec3; 3]]) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        let mut first = 0;
        for (block, length) in lengths.iter().enumerate() {
            let (names, color) = part(block);
            self.begin_part_at(first, &names, color);
            first += length;
        }
        self.has_normals = with_normals;
        let mesh = &mut self.mesh;
        mesh.triangles = vec![[0; 3]; first];
        // (Zeros from the system, which the threads touch first.)
        mesh.corner_normals = bytemuck::zeroed_vec(if with_normals { first } else { 0 });
        let normals = lengths.iter().map(|&n| if with_normals { n } else { 0 });
        split(&mut mesh.triangles, lengths.iter().copied())
            .into_par_iter()
            .zip(split(&mut mesh.corner_normals, normals))
            .enumerate()
            .map(|(block, (triangles, normals))| fill(block, triangles, normals))
            // (Not straight into a `Result`, which would keep any error.)
            .collect::<Vec<_>>()
            .into_iter()
            .collect()
    }

    /// The mesh: with normals if all triangles have them, with surfaces if
    /// any of them has a name or a colour.
    pub(crate) fn finish(self) -> Assembled {
        let mut mesh = self.mesh;
        if !self.has_normals {
            mesh.corner_normals.clear();
        }
        let tells = |s: &MeshSurface| s.name.is_some() || s.color.is_some();
        if mesh.surfaces.iter().any(tells) {
            let count = mesh.triangles.len();
            let ends = self.runs.iter().skip(1).map(|run| run.1);
            for (&(part, _), end) in self.runs.iter().zip(ends.chain([count])) {
                mesh.triangle_surfaces.resize(end, part);
            }
        } else {
            mesh.surfaces.clear();
        }
        let objects = remaining(&mesh, self.objects);
        drop_vanished(&mut mesh);
        Assembled { mesh, objects }
    }
}

/// The mesh that was read from `data`, unless there is nothing in it: a file
/// of another kind, or of zeros, is no empty solid.
///
/// # Errors
/// No triangle with three corners.
pub(crate) fn with_triangles(
    read: impl Into<Assembled>,
    format: MeshFormat,
    data: &[u8],
) -> Result<Assembled, Error> {
    let read = read.into();
    if !read.mesh.triangles.is_empty() {
        return Ok(read);
    }
    let (place, problem) = if data.is_empty() {
        ("byte 0".to_owned(), "it is empty".to_owned())
    } else {
        let problem = format!(
            "there is no triangle with three corners; is this a whole {format} file, \
             and one of faces?"
        );
        (format!("bytes 0 to {}", data.len()), problem)
    };
    Err(Error::Malformed {
        format,
        place,
        problem,
    })
}

/// Whether two vertices of a triangle are one.
fn vanished(&[a, b, c]: &[u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// The first triangle of each object, in ascending order, once those that vanish are left out,
/// and objects with them that have no others.
fn remaining(mesh: &Mesh, firsts: Vec<usize>) -> Vec<usize> {
    let mut kept = 0;
    let mut at = 0;
    let mut remaining = Vec::new();
    let ends = firsts.iter().skip(1).copied();
    let ends: Vec<usize> = ends.chain([mesh.triangles.len()]).collect();
    for (first, end) in firsts.into_iter().zip(ends) {
        let count = |range: Range<usize>| {
            let triangles = mesh.triangles[range].par_iter();
            triangles.filter(|triangle| !vanished(triangle)).count()
        };
        kept += count(at..first);
        let own = count(first..end);
        if own > 0 {
            remaining.push(kept);
        }
        kept += own;
        at = end;
    }
    remaining
}

/// Leaves out the triangles two of whose vertices are one.
pub(crate) fn drop_vanished(mesh: &mut Mesh) {
    if !mesh.triangles.par_iter().any(vanished) {
        return;
    }
    let mut keep = mesh.triangles.iter().map(|t| !vanished(t));
    mesh.triangle_surfaces
        .retain(|_| keep.next().unwrap_or(true));
    let mut keep = mesh.triangles.iter().map(|t| !vanished(t));
    mesh.corner_normals.retain(|_| keep.next().unwrap_or(true));
    mesh.triangles.retain(|t| !vanished(t));
}
