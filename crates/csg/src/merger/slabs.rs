//! The slabs of one mesh, all there and in order, and what each calls the
//! vertices of others.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::error::Error;
use crate::surface_nets::slab::{SlabBody, SlabEntry, SlabHead, SlabSource};

/// The slabs of one mesh, in order.
#[derive(Debug)]
pub(super) struct Slabs<S> {
    slabs: Vec<S>,
    /// By slab its first vertex and first triangle, and of all how many there are.
    vertex_bases: Vec<u32>,
    triangle_bases: Vec<u64>,
    /// The triangles that come after those of all slabs.
    pub further: Vec<OwnedTriangle>,
    /// The vertices that several slabs name, by their keys.
    exports: FxHashMap<u64, u32>,
}

/// A triangle by itself.
#[derive(Clone, Debug)]
pub(super) struct OwnedTriangle {
    pub corners: [u32; 3],
    pub entry: Arc<SlabEntry>,
    pub reversed: bool,
}

/// What is to be known of a slab to go through its triangles.
pub(super) struct Opened<'a> {
    pub body: Cow<'a, SlabBody>,
    /// By their numbers in the whole mesh.
    pub imports: Vec<u32>,
}

fn faulty(source: &impl SlabSource, problem: impl Into<String>) -> Error {
    Error::Slab {
        slab: source.name(),
        problem: problem.into(),
    }
}

impl<S: SlabSource> Slabs<S> {
    /// Slabs in whatever order.
    pub fn of(mut slabs: Vec<S>) -> Result<Self, Error> {
        check_whole(&mut slabs)?;
        let (mut vertex_bases, mut triangle_bases) = (vec![0u32], vec![0u64]);
        let mut further = 0;
        for slab in &slabs {
            let head = slab.head();
            check_head(slab)?;
            let vertices = vertex_bases[vertex_bases.len() - 1].checked_add(head.vertices);
            vertex_bases.push(vertices.filter(|&count| count < u32::MAX).ok_or(
                Error::TooLarge {
                    what: "vertices in one mesh",
                    limit: u32::MAX.into(),
                },
            )?);
            triangle_bases
                .push(triangle_bases[triangle_bases.len() - 1] + u64::from(head.triangles));
            further += u64::from(head.further);
        }
        if triangle_bases[slabs.len()] + further >= u32::MAX.into() {
            return Err(Error::TooLarge {
                what: "triangles in one mesh",
                limit: u32::MAX.into(),
            });
        }
        let mut exports = FxHashMap::default();
        for (slab, &base) in slabs.iter().zip(&vertex_bases) {
            for &(key, vertex) in &slab.head().exports {
                if exports.insert(key, base + vertex).is_some() {
                    return Err(faulty(slab, "another slab has a vertex in the same place"));
                }
            }
        }
        let mut slabs = Self {
            slabs,
            vertex_bases,
            triangle_bases,
            further: Vec::new(),
            exports,
        };
        slabs.further = slabs.further_triangles()?;
        Ok(slabs)
    }

    pub fn len(&self) -> usize {
        self.slabs.len()
    }

    /// What all have in common is told by the first, too.
    pub fn first(&self) -> &SlabHead {
        self.slabs[0].head()
    }

    pub fn heads(&self) -> impl Iterator<Item = &SlabHead> + Clone {
        self.slabs.iter().map(SlabSource::head)
    }

    /// How many vertices there are.
    pub fn vertices(&self) -> u32 {
        self.vertex_bases[self.slabs.len()]
    }

    pub fn all_triangles(&self) -> u64 {
        self.first_triangle(self.slabs.len()) + self.further.len() as u64
    }

    /// The first triangle of a piece, before any was removed.
    pub fn first_triangle(&self, piece: usize) -> u64 {
        self.triangle_bases[piece]
    }

    /// The vertices of a slab, by their numbers in the whole mesh.
    pub fn vertices_of(&self, slab: usize) -> Range<u32> {
        self.vertex_bases[slab]..self.vertex_bases[slab + 1]
    }

    pub fn local_positions(&self, slab: usize) -> Result<Cow<'_, [DVec3]>, Error> {
        let source = &self.slabs[slab];
        let positions = source.positions()?;
        if positions.len() != source.head().vertices() {
            return Err(faulty(
                source,
                "it has another number of vertices than it says",
            ));
        }
        Ok(positions)
    }

    pub fn open(&self, slab: usize) -> Result<Opened<'_>, Error> {
        let source = &self.slabs[slab];
        let (head, body) = (source.head(), source.body()?);
        let corners = u64::from(head.vertices) + body.imports.len() as u64;
        let triangles: u64 = body
            .groups
            .iter()
            .map(|group| u64::from(group.triangles))
            .sum();
        let is_entry = |entry: u32| (entry as usize) < body.entries.len();
        if triangles != head.triangles.into()
            || body.further.len() != head.further as usize
            || !body.groups.iter().all(|group| is_entry(group.entry))
            || !body.further.iter().all(|triangle| {
                is_entry(triangle.entry) && triangle.corners.iter().all(|&v| u64::from(v) < corners)
            })
        {
            return Err(faulty(
                source,
                "its triangles are not those that it tells of",
            ));
        }
        let import = |&(key, _): &(u64, DVec3)| {
            let found = self.exports.get(&key).copied();
            found.ok_or_else(|| faulty(source, "it names a vertex that no slab has"))
        };
        let imports = body
            .imports
            .iter()
            .map(import)
            .collect::<Result<_, Error>>()?;
        Ok(Opened { body, imports })
    }

    /// The triangles of a slab but for the further ones, by the numbers of their
    /// corners in the whole mesh.
    pub fn global_triangles(
        &self,
        slab: usize,
        opened: &Opened<'_>,
    ) -> Result<Vec<[u32; 3]>, Error> {
        let source = &self.slabs[slab];
        let mut triangles = source.triangles()?.into_owned();
        let own = source.head().vertices;
        let corners = u64::from(own) + opened.imports.len() as u64;
        let is_known = |triangle: &[u32; 3]| triangle.iter().all(|&v| u64::from(v) < corners);
        if triangles.len() != source.head().triangles() || !triangles.par_iter().all(is_known) {
            return Err(faulty(
                source,
                "its triangles name vertices that are not there",
            ));
        }
        triangles
            .par_iter_mut()
            .for_each(|corners| *corners = corners.map(|v| self.global(slab, opened, v)));
        Ok(triangles)
    }

    /// The number in the whole mesh of what a slab calls `vertex`.
    fn global(&self, slab: usize, opened: &Opened<'_>, vertex: u32) -> u32 {
        let own = self.slabs[slab].head().vertices;
        match vertex.checked_sub(own) {
            None => self.vertex_bases[slab] + vertex,
            Some(import) => opened.imports[import as usize],
        }
    }

    fn further_triangles(&self) -> Result<Vec<OwnedTriangle>, Error> {
        let mut further = Vec::new();
        for slab in 0..self.slabs.len() {
            if self.slabs[slab].head().further == 0 {
                continue;
            }
            let opened = self.open(slab)?;
            further.extend(opened.body.further.iter().map(|triangle| OwnedTriangle {
                corners: triangle.corners.map(|v| self.global(slab, &opened, v)),
                entry: Arc::new(opened.body.entries[triangle.entry as usize].clone()),
                reversed: triangle.reversed,
            }));
        }
        Ok(further)
    }
}

/// Sorts slabs, and sees to it that they are all there, once, and of one mesh.
fn check_whole<S: SlabSource>(slabs: &mut [S]) -> Result<(), Error> {
    slabs.sort_by_key(|slab| slab.head().part);
    let Some(first) = slabs.first() else {
        return Err(Error::InvalidOption(
            "no slabs to put together: give all of one mesh".into(),
        ));
    };
    let of = first.head().of;
    let is_same = |head: &SlabHead| {
        let same = |head: &SlabHead| {
            let [a, b, c] = head.origin.to_array().map(f64::to_bits);
            (head.fingerprint, head.of, head.unit, [a, b, c])
        };
        same(head) == same(first.head())
    };
    if let Some(other) = slabs.iter().find(|slab| !is_same(slab.head())) {
        let problem = format!(
            "it is of another mesh than {}: of another model, other cells, another unit or another number of slabs",
            first.name()
        );
        return Err(faulty(other, problem));
    }
    for (at, slab) in (0..).zip(&*slabs) {
        let part = slab.head().part;
        if part > at {
            return Err(faulty(first, missing(at, of)));
        }
        if part < at {
            let twin = &slabs[at as usize - 1];
            let problem = format!("it is slab {} of {of}, as is {}", part + 1, twin.name());
            return Err(faulty(slab, problem));
        }
    }
    match slabs.len() as u32 {
        there if there < of => Err(faulty(first, missing(there, of))),
        _ => Ok(()),
    }
}

fn missing(part: u32, of: u32) -> String {
    format!("it is one of {of} slabs, and slab {} is missing", part + 1)
}

fn check_head(slab: &impl SlabSource) -> Result<(), Error> {
    let head = slab.head();
    let all = u64::from(head.triangles) + u64::from(head.further);
    let is_sound = head
        .exports
        .iter()
        .all(|&(_, vertex)| vertex < head.vertices)
        && head.bad.iter().all(|&(triangle, block)| {
            u64::from(triangle) < all && block.is_none_or(|b| (b as usize) < head.blocks.len())
        });
    if is_sound {
        Ok(())
    } else {
        Err(faulty(
            slab,
            "it tells of vertices or triangles that are not there",
        ))
    }
}
