//! Putting slabs together: one at a time in memory, and for each vertex that
//! another one names some bytes.
//!
//! What slabs name of each other is found by keys ([`slabs`]); what a whole mesh
//! is cleaned of, from the triangles around it ([`tidy`]). As the mesher closes
//! the gaps with what comes last, so does the merger: the order is the same.

mod slabs;
mod tidy;

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use self::slabs::Slabs;
use self::tidy::Edits;
use crate::error::Error;
use crate::finish;
use crate::mesh::{LengthUnit, Mesh, MeshSurface};
use crate::program::Surface;
use crate::report::Report;
use crate::surface_nets::slab::{FallbackKind, SlabEntry, SlabSource};

/// The slabs of one mesh put together: vertex for vertex and triangle for
/// triangle the mesh that [`Mesher::mesh`](crate::Mesher::mesh) makes of the
/// whole, to the bit, whatever the number of slabs.
///
/// It comes piece by piece, so that it need not fit into memory: first
/// [`Self::positions`] of every piece, then [`Self::triangles`]. What is held
/// is a slab at a time, and of all of them what they share: some 40 bytes for
/// each vertex in the last cells of a slab, and the triangles around those
/// without area, which are taken out here.
///
/// ```
/// use csg::{Merger, Mesher, Program, Solid};
///
/// let program = Program::lower(&(Solid::cube(1.5) & Solid::sphere(1.0)))?;
/// let mesher = Mesher::new().cells(64);
/// // Each by itself: in other threads, other processes, on other machines.
/// let slabs = (0..5).map(|part| mesher.slab(&program, part, 5));
/// let merger = Merger::new(slabs.collect::<Result<_, _>>()?)?;
/// let mesh = mesher.mesh(&program)?.mesh;
/// assert!(merger.mesh()? == mesh);
/// # Ok::<(), csg::Error>(())
/// ```
#[derive(Debug)]
pub struct Merger<S> {
    slabs: Slabs<S>,
    edits: Edits,
    report: Report,
}

/// A piece of a merged mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MergedTriangles {
    /// By the places of their corners among all vertices.
    pub triangles: Vec<[u32; 3]>,
    /// What each lies on, by its place in [`Self::table`].
    pub surfaces: Vec<u32>,
    /// What triangles of the piece lie on, and some that have none left.
    pub table: Vec<MeshSurface>,
    /// Where the corners are, in model units; empty unless asked for.
    pub corners: Vec<[DVec3; 3]>,
}

impl<S: SlabSource> Merger<S> {
    /// Puts slabs together, in whatever order they are given.
    ///
    /// # Errors
    /// [`Error::Slab`], with the name of the slab, if one is missing, there
    /// twice, of another mesh or damaged; [`Error::TooLarge`] if the vertices or
    /// triangles outnumber an index.
    pub fn new(slabs: Vec<S>) -> Result<Self, Error> {
        let slabs = Slabs::of(slabs)?;
        let edits = Edits::of(&slabs)?;
        let report = told(&slabs, &edits);
        Ok(Self {
            slabs,
            edits,
            report,
        })
    }

    /// How many vertices the mesh has.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.slabs.vertices() as usize - self.edits.merged
    }

    /// How many triangles the mesh has.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        (self.slabs.all_triangles() - self.edits.removed) as usize
    }

    /// Whether any triangle of the mesh has a colour.
    #[must_use]
    pub fn has_colors(&self) -> bool {
        let colored: u64 = self.slabs.heads().map(|head| head.colored).sum();
        colored > self.edits.removed_colored
    }

    /// The unit of the positions.
    #[must_use]
    pub fn unit(&self) -> LengthUnit {
        self.slabs.first().unit
    }

    /// What was done for the mesh, and what could not be done: as of a mesh made as a whole,
    /// but for its check and the times.
    #[must_use]
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// How many pieces the mesh comes in: one for each slab, and one more.
    #[must_use]
    pub fn pieces(&self) -> usize {
        self.slabs.len() + 1
    }

    /// The vertices of a piece, in model units.
    ///
    /// # Errors
    /// [`Error::Slab`] if the slab cannot be read; [`Error::InvalidOption`] for a piece that there
    /// is not.
    pub fn positions(&self, piece: usize) -> Result<Vec<DVec3>, Error> {
        self.check_piece(piece)?;
        if piece == self.slabs.len() {
            return Ok(Vec::new());
        }
        let mut positions = self.slabs.local_positions(piece)?.into_owned();
        let vertices = self.slabs.vertices_of(piece);
        let base = vertices.start;
        for &(vertex, place) in within(&self.edits.filled, |&(vertex, _)| vertex, &vertices) {
            positions[(vertex - base) as usize] = place;
        }
        positions.truncate(self.vertex_count().saturating_sub(base as usize));
        let origin = self.slabs.first().origin;
        if origin != DVec3::ZERO {
            positions.par_iter_mut().for_each(|p| *p += origin);
        }
        Ok(positions)
    }

    /// The triangles of a piece, and where their corners are, if that is asked for.
    ///
    /// # Errors
    /// [`Error::Slab`] if the slab cannot be read, or names vertices that no other one has;
    /// [`Error::InvalidOption`] for a piece that there is not.
    pub fn triangles(&self, piece: usize, with_corners: bool) -> Result<MergedTriangles, Error> {
        self.check_piece(piece)?;
        let mut made = match piece == self.slabs.len() {
            true => self.last_piece(),
            false => self.piece(piece, with_corners)?,
        };
        let first = self.slabs.first_triangle(piece);
        let count = self.triangle_count().saturating_sub(first as usize);
        made.triangles.truncate(count);
        made.surfaces.truncate(count);
        made.corners.truncate(count);
        let numbers = first..first + made.triangles.len() as u64;
        let altered = within(&self.edits.altered, |&(triangle, _)| triangle, &numbers);
        let moved = within(&self.edits.moved, |&(to, _)| to, &numbers);
        for &(number, corners) in altered {
            made.put((number - first) as usize, corners, self);
        }
        for (to, triangle) in moved {
            let at = (to - first) as usize;
            made.put(at, triangle.corners, self);
            made.surfaces[at] = made.table.len() as u32;
            made.table.push(triangle.entry.mesh_surface());
        }
        let kept = self.vertex_count() as u32;
        let renamed = &self.edits.renamed;
        made.triangles.par_iter_mut().for_each(|corners| {
            for corner in corners {
                if *corner >= kept {
                    *corner = renamed.get(corner).copied().unwrap_or(*corner);
                }
            }
        });
        let origin = self.slabs.first().origin;
        if origin != DVec3::ZERO {
            let corners = made.corners.par_iter_mut();
            corners.for_each(|corners| *corners = corners.map(|p| p + origin));
        }
        Ok(made)
    }

    /// The whole mesh in memory.
    ///
    /// # Errors
    /// [`Error::Slab`] if a slab cannot be read.
    pub fn mesh(&self) -> Result<Mesh, Error> {
        Ok(self.mesh_and_shapes()?.0)
    }

    /// The same with [`Mesh::corner_normals`].
    ///
    /// # Errors
    /// [`Error::Slab`] if a slab cannot be read.
    pub fn mesh_with_normals(&self) -> Result<Mesh, Error> {
        let (mut mesh, shapes) = self.mesh_and_shapes()?;
        let surface = |triangle: usize| shapes.get(mesh.triangle_surfaces[triangle] as usize);
        mesh.corner_normals = finish::corner_normals(&mesh, surface);
        Ok(mesh)
    }

    fn mesh_and_shapes(&self) -> Result<(Mesh, Vec<Surface>), Error> {
        let mut mesh = Mesh {
            unit: self.unit(),
            ..Mesh::default()
        };
        let mut shapes = Vec::new();
        let mut index: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        // All first: the last triangles may take places among others.
        for slab in 0..self.slabs.len() {
            for entry in &self.slabs.open(slab)?.body.entries {
                index
                    .entry((entry.surface, entry.primitive))
                    .or_insert_with(|| {
                        mesh.surfaces.push(entry.mesh_surface());
                        shapes.push(entry.shape);
                        shapes.len() as u32 - 1
                    });
            }
        }
        for piece in 0..self.pieces() {
            mesh.positions.append(&mut self.positions(piece)?);
            let mut made = self.triangles(piece, false)?;
            mesh.triangles.append(&mut made.triangles);
            let table = made.table.iter();
            let table: Vec<u32> = table
                .map(|entry| index[&(entry.surface, entry.primitive)])
                .collect();
            let surfaces = made.surfaces.iter().map(|&entry| table[entry as usize]);
            mesh.triangle_surfaces.extend(surfaces);
        }
        Ok((mesh, shapes))
    }

    fn check_piece(&self, piece: usize) -> Result<(), Error> {
        if piece < self.pieces() {
            return Ok(());
        }
        Err(Error::InvalidOption(format!(
            "piece {piece} of a mesh: there are {}, counted from 0",
            self.pieces()
        )))
    }

    /// The triangles of a slab, nothing edited.
    fn piece(&self, slab: usize, with_corners: bool) -> Result<MergedTriangles, Error> {
        let opened = self.slabs.open(slab)?;
        let triangles = self.slabs.global_triangles(slab, &opened)?;
        let mut surfaces = Vec::with_capacity(triangles.len());
        for group in &opened.body.groups {
            surfaces.resize(surfaces.len() + group.triangles as usize, group.entry);
        }
        let mut corners = Vec::new();
        if with_corners {
            let positions = self.slabs.local_positions(slab)?;
            let base = self.slabs.vertices_of(slab).start;
            let imports = opened.imports.iter().zip(&opened.body.imports);
            let imports: FxHashMap<u32, DVec3> = imports
                .map(|(&vertex, &(_, place))| (vertex, place))
                .collect();
            let place = |vertex: u32| match positions.get(vertex.wrapping_sub(base) as usize) {
                Some(&place) => place,
                None => imports[&vertex],
            };
            corners = triangles
                .par_iter()
                .map(|triangle| triangle.map(place))
                .collect();
        }
        let entries = &opened.body.entries;
        Ok(MergedTriangles {
            triangles,
            surfaces,
            table: entries.iter().map(SlabEntry::mesh_surface).collect(),
            corners,
        })
    }

    /// The triangles after those of all slabs, nothing edited.
    fn last_piece(&self) -> MergedTriangles {
        let mut made = MergedTriangles::default();
        for (at, triangle) in (0..).zip(&self.slabs.further) {
            made.triangles.push(triangle.corners);
            made.corners
                .push(triangle.corners.map(|v| self.edits.place(v)));
            made.surfaces.push(at);
            made.table.push(triangle.entry.mesh_surface());
        }
        made
    }
}

impl MergedTriangles {
    fn put<S>(&mut self, at: usize, corners: [u32; 3], merger: &Merger<S>) {
        self.triangles[at] = corners;
        if let Some(places) = self.corners.get_mut(at) {
            *places = corners.map(|v| merger.edits.place(v));
        }
    }
}

/// Those of some items, which stand in the order of their numbers, whose number is in a range.
fn within<'a, T, N: Copy + Ord>(
    items: &'a [T],
    number: impl Fn(&T) -> N,
    range: &Range<N>,
) -> &'a [T] {
    let from = items.partition_point(|item| number(item) < range.start);
    let to = items.partition_point(|item| number(item) < range.end);
    &items[from..to.max(from)]
}

/// What was done for the whole mesh.
fn told<S: SlabSource>(slabs: &Slabs<S>, edits: &Edits) -> Report {
    let first = slabs.first();
    let mut report = Report {
        method: "exact",
        bounds: first.bounds,
        cell_size: first.cell_size,
        ..Report::default()
    };
    let degenerate = (FallbackKind::Degenerate, edits.left, edits.left_at.clone());
    let heads = slabs.heads();
    let told = heads.clone().flat_map(|head| &head.fallbacks);
    for (kind, count, places) in std::iter::once(&degenerate).chain(told) {
        report.add_fallbacks(kind.describe(), *count as usize, places);
    }
    for head in heads {
        report.cells_visited += head.cells_visited;
        report.cells_pruned += head.cells_pruned;
        report.surface_cells += head.surface_cells;
    }
    report
}
