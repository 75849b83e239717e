//! Making a slab.

use std::hash::Hasher;
use std::ops::Range;

use glam::{DVec3, UVec3};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use siphasher::sip::SipHasher13;

use super::super::assembly::Assembly;
use super::super::cleanup;
use super::super::lattice::{CELLS, Lattice};
use super::super::part::{Fallback, FallbackKind, Part};
use super::super::scene::Scene;
use super::super::stitch::{Directory, Stitcher};
use super::super::walk::{self, Wanted};
use super::super::{
    TableOfSurfaces, least_area, merging_tolerance, reaches, scene, stitched_part, walked_part,
};
use super::{FurtherTriangle, Slab, SlabBody, SlabEntry, SlabGroup, SlabHead, key};
use crate::error::Error;
use crate::mesh::LengthUnit;
use crate::program::{Operand, Program};
use crate::report::PLACES_PER_FALLBACK;
use crate::task::Task;

/// The slab `part` of `of`, from 0; in the local frame, about the task's origin.
pub(crate) fn cut(
    task: &Task<'_>,
    unit: LengthUnit,
    (part, of): (u32, u32),
) -> Result<Slab, Error> {
    let arch = pulp::Arch::new();
    let reaches = reaches(task);
    let scene = scene(task, &reaches)?;
    let bricks = u128::from(walk::count(&scene.lattice));
    let start = |part: u32| (bricks * u128::from(part) / u128::from(of)) as u64;
    let own = start(part)..start(part + 1);
    let mut walked = Walked::of(task, &scene, &own)?;
    let mut surfaces = TableOfSurfaces::default();
    surfaces.enter(task, &mut walked.parts[..walked.own]);
    let entries = entries_of(surfaces, task.program);
    let mut directory = Directory::default();
    directory.extend(&walked.parts);
    if directory.vertices >= 1 << 31 {
        return Err(Error::TooLarge {
            what: "vertices in one slab",
            limit: 1 << 31,
        });
    }
    let least_area = least_area(task);
    let stitcher = Stitcher {
        parts: &walked.parts,
        directory: &directory,
        surfaces: &task.surfaces,
        least_area,
    };
    let own_parts = &walked.parts[..walked.own];
    let mut assembly = Assembly::default();
    assembly.add(own_parts, 0, 1.0, |part, out| {
        stitched_part(arch, &stitcher, part, out)
    });
    let assembled = assembly.finish();

    let vertices = assembled.positions.len();
    let foreign = Foreign::of(&assembled.triangles, vertices, &stitcher);
    let regular = assembled.triangles.len() - assembled.further.len();
    let mut triangles = assembled.triangles;
    triangles
        .par_iter_mut()
        .for_each(|corners| *corners = corners.map(|corner| foreign.local(corner)));
    let body = SlabBody {
        groups: groups_of(own_parts),
        further: further_of(&triangles[regular..], &assembled.further, own_parts),
        entries,
        imports: foreign.places,
    };
    let made = Made {
        body: &body,
        positions: &assembled.positions,
        triangles: &triangles[..regular],
    };
    let bad = made.still_bad(assembled.bad, task, least_area);
    let head = SlabHead {
        part,
        of,
        bounds: Some(task.bounds()),
        cell_size: task.cell,
        origin: task.origin,
        least_area,
        tolerance: merging_tolerance(&scene),
        vertices: vertices as u32,
        triangles: regular as u32,
        further: body.further.len() as u32,
        colored: made.colored(),
        exports: exports(&scene.lattice, own_parts, &own),
        blocks: blocks_of(own_parts),
        bad: with_blocks(bad, own_parts),
        fallbacks: told(
            own_parts.iter().flat_map(|part| &part.fallbacks),
            task.origin,
        ),
        cells_visited: walked.count(|part| part.bricks_sampled) * (CELLS * CELLS * CELLS) as u64,
        cells_pruned: walked.cells_pruned + walked.count(|part| part.cells_pruned),
        surface_cells: walked.count(|part| part.surface_cells),
        ..nothing(fingerprint(task.program, Some(&scene)), unit)
    };
    triangles.truncate(regular);
    Ok(Slab {
        head,
        body,
        positions: assembled.positions,
        triangles,
    })
}

/// What was found in a slab's bricks, and in those before them whose vertices its polygons name.
struct Walked {
    /// The slab's own first.
    parts: Vec<Part>,
    own: usize,
    /// Cells that no brick was made for.
    cells_pruned: u64,
}

impl Walked {
    fn of(task: &Task<'_>, scene: &Scene<'_>, own: &Range<u64>) -> Result<Self, Error> {
        let arch = pulp::Arch::new();
        let walk = |wanted: &Wanted| {
            let (blocks, pruned) = walk::blocks(scene, &task.program.root_cell(), wanted);
            let progress = task.control.stage(blocks.len() as u64, 0.0, 1.0);
            let parts = blocks.par_iter().with_max_len(1).map(|block| {
                let part = walked_part(arch, (scene, wanted), block, Vec::new(), task);
                progress.add(1);
                part
            });
            let parts: Vec<Part> = parts.collect();
            task.control.check()?;
            Ok::<_, Error>((parts, pruned))
        };
        let (mut parts, cells_pruned) = walk(&Wanted::range(own.clone()))?;
        let own_parts = parts.len();
        let before = bricks_before(&scene.lattice, &parts, own);
        if !before.is_empty() {
            parts.append(&mut walk(&before)?.0);
        }
        Ok(Self {
            parts,
            own: own_parts,
            cells_pruned,
        })
    }

    /// A count over the slab's own parts.
    fn count(&self, of: impl Fn(&Part) -> u64) -> u64 {
        self.parts[..self.own].iter().map(of).sum()
    }
}

fn entries_of(surfaces: TableOfSurfaces, program: &Program) -> Vec<SlabEntry> {
    let entries = surfaces.surfaces.into_iter().map(|entry| SlabEntry {
        surface: entry.surface,
        primitive: entry.primitive,
        body: entry.body,
        name: entry.name,
        parts: entry.parts,
        color: entry.color,
        shape: program.surfaces()[entry.surface as usize],
    });
    entries.collect()
}

/// Which surfaces the triangles lie on, but for those that come last.
fn groups_of(parts: &[Part]) -> Vec<SlabGroup> {
    let groups = parts.iter().flat_map(|part| &part.groups);
    joined(groups.map(|own| SlabGroup {
        entry: own.entry,
        reversed: own.reversed,
        triangles: 2 * own.count,
    }))
}

/// The triangles that come last; each is of a group of a part.
fn further_of(
    triangles: &[[u32; 3]],
    groups: &[(usize, u32)],
    parts: &[Part],
) -> Vec<FurtherTriangle> {
    let further = triangles.iter().zip(groups);
    let further = further.map(|(&corners, &(part, group))| {
        let group = &parts[part].groups[group as usize];
        FurtherTriangle {
            corners,
            entry: group.entry,
            reversed: group.reversed,
        }
    });
    further.collect()
}

/// Each part's first brick, and whether something had to be settled for in it.
fn blocks_of(parts: &[Part]) -> Vec<(u64, bool)> {
    let blocks = parts.iter();
    let blocks = blocks.map(|part| (part.first, !part.fallbacks.is_empty()));
    blocks.collect()
}

/// Triangles, each with the block that it is of; those that come last are of none.
fn with_blocks(triangles: Vec<u32>, parts: &[Part]) -> Vec<(u32, Option<u32>)> {
    let ends = parts.iter().scan(0, |end, part| {
        *end += 2 * part.polygons.len() as u32;
        Some(*end)
    });
    let ends: Vec<u32> = ends.collect();
    let triangles = triangles.into_iter().map(|triangle| {
        let block = ends.partition_point(|&end| end <= triangle);
        (triangle, (block < ends.len()).then_some(block as u32))
    });
    triangles.collect()
}

/// A slab's triangles with what they lie on.
struct Made<'a> {
    body: &'a SlabBody,
    positions: &'a [DVec3],
    /// But for those that come last.
    triangles: &'a [[u32; 3]],
}

impl Made<'_> {
    /// Those of some triangles that are bad where their corners are now.
    fn still_bad(&self, bad: Vec<u32>, task: &Task<'_>, least_area: f64) -> Vec<u32> {
        let SlabBody {
            entries,
            groups,
            imports,
            further,
        } = self.body;
        let ends = groups.iter().scan(0, |end, group| {
            *end += group.triangles;
            Some(*end)
        });
        let ends: Vec<u32> = ends.collect();
        let place = |vertex: u32| match self.positions.get(vertex as usize) {
            Some(&place) => place,
            None => imports[vertex as usize - self.positions.len()].1,
        };
        let is_bad = |&triangle: &u32| {
            let at = triangle as usize;
            let (corners, entry, reversed) = match self.triangles.get(at) {
                Some(&corners) => {
                    let group = &groups[ends.partition_point(|&end| end <= triangle)];
                    (corners, group.entry, group.reversed)
                }
                None => {
                    let further = &further[at - self.triangles.len()];
                    (further.corners, further.entry, further.reversed)
                }
            };
            let surface = &task.surfaces[entries[entry as usize].surface as usize];
            cleanup::is_bad(corners.map(place), (surface, reversed), least_area)
        };
        bad.into_iter().filter(is_bad).collect()
    }

    /// How many triangles have a colour.
    fn colored(&self) -> u64 {
        let is_colored = |entry: u32| self.body.entries[entry as usize].color.is_some();
        let groups = self.body.groups.iter();
        let colored = groups.filter(|group| is_colored(group.entry));
        let colored: u64 = colored.map(|group| u64::from(group.triangles)).sum();
        let further = self.body.further.iter();
        colored + further.filter(|t| is_colored(t.entry)).count() as u64
    }
}

/// A slab of a solid that is empty.
pub(crate) fn empty(program: &Program, unit: LengthUnit, (part, of): (u32, u32)) -> Slab {
    Slab {
        head: SlabHead {
            part,
            of,
            ..nothing(fingerprint(program, None), unit)
        },
        body: SlabBody::default(),
        positions: Vec::new(),
        triangles: Vec::new(),
    }
}

fn nothing(fingerprint: u64, unit: LengthUnit) -> SlabHead {
    SlabHead {
        fingerprint,
        part: 0,
        of: 1,
        unit,
        bounds: None,
        cell_size: 0.0,
        origin: DVec3::ZERO,
        least_area: 0.0,
        tolerance: 0.0,
        vertices: 0,
        triangles: 0,
        further: 0,
        colored: 0,
        exports: Vec::new(),
        blocks: Vec::new(),
        bad: Vec::new(),
        fallbacks: Vec::new(),
        cells_visited: 0,
        cells_pruned: 0,
        surface_cells: 0,
    }
}

/// Groups one after another that are alike as one.
fn joined(groups: impl Iterator<Item = SlabGroup>) -> Vec<SlabGroup> {
    let mut joined: Vec<SlabGroup> = Vec::new();
    for group in groups {
        match joined.last_mut() {
            Some(last) if (last.entry, last.reversed) == (group.entry, group.reversed) => {
                last.triangles += group.triangles;
            }
            _ => joined.push(group),
        }
    }
    joined
}

/// The bricks before those of the parts, along one axis or several, whose
/// vertices their polygons name, and that are not among the slab's own.
fn bricks_before(lattice: &Lattice, parts: &[Part], own: &Range<u64>) -> Wanted {
    let named = parts.par_iter().flat_map_iter(|part| {
        part.bricks.iter().flat_map(move |brick| {
            let polygons = brick.polygons.start as usize..brick.polygons.end as usize;
            let mut sets = [false; 8];
            for code in &part.polygons[polygons] {
                let on_first = (0..3).filter(|&axis| {
                    // The cells around an edge are before it along the other axes.
                    axis != code.axis() && code.sample() >> (4 * axis) & 15 == 0
                });
                sets[on_first.fold(0, |set, axis| set | 1 << axis)] = true;
            }
            (1..8u32).filter_map(move |offset| {
                let is_named = (1..8u32).any(|set| sets[set as usize] && offset & !set == 0);
                let steps = UVec3::new(offset & 1, offset >> 1 & 1, offset >> 2);
                (is_named && steps.cmple(brick.position).all())
                    .then(|| walk::number_of(lattice, brick.position - steps))
            })
        })
    });
    let named: FxHashSet<u64> = named.filter(|number| !own.contains(number)).collect();
    let mut named: Vec<u64> = named.into_iter().collect();
    named.sort_unstable();
    Wanted::each(named)
}

/// The vertices that other slabs may name: those next to bricks of theirs.
fn exports(lattice: &Lattice, parts: &[Part], own: &Range<u64>) -> Vec<(u64, u32)> {
    let mut exports = Vec::new();
    let mut base = 0;
    for part in parts {
        for brick in &part.bricks {
            // By the axes along which a vertex is in the last layer.
            let mut may_be_named = [false; 8];
            for offset in 1..8u32 {
                let steps = UVec3::new(offset & 1, offset >> 1 & 1, offset >> 2);
                let next = brick.position + steps;
                if next.cmplt(lattice.bricks).all()
                    && !own.contains(&walk::number_of(lattice, next))
                {
                    for (layers, may) in (0u32..).zip(&mut may_be_named) {
                        *may |= offset & !layers == 0;
                    }
                }
            }
            if may_be_named[7] {
                let first = base + brick.vertices.start;
                key::for_each_vertex(part, brick, |vertex, key, layers| {
                    if may_be_named[layers as usize] {
                        exports.push((key, first + vertex));
                    }
                });
            }
        }
        base += part.vertices.len() as u32;
    }
    exports
}

/// The vertices of other slabs that triangles name.
struct Foreign {
    vertices: u32,
    /// Keys and places, in ascending order of the vertices.
    places: Vec<(u64, DVec3)>,
    /// By vertex its place in the list, counted on from the slab's own.
    numbers: FxHashMap<u32, u32>,
}

impl Foreign {
    fn of(triangles: &[[u32; 3]], vertices: usize, stitcher: &Stitcher<'_>) -> Self {
        let vertices = vertices as u32;
        let corners = triangles.par_iter().flat_map_iter(|corners| *corners);
        let named: FxHashSet<u32> = corners.filter(|&corner| corner >= vertices).collect();
        let mut numbers = FxHashMap::default();
        let mut places = Vec::with_capacity(named.len());
        let bases = &stitcher.directory.vertex_base;
        for (part, &base) in stitcher.parts.iter().zip(bases) {
            if base < vertices || part.vertices.is_empty() {
                continue;
            }
            for brick in &part.bricks {
                let first = brick.vertices.start;
                key::for_each_vertex(part, brick, |vertex, key, _| {
                    let own = first + vertex;
                    if named.contains(&(base + own)) {
                        numbers.insert(base + own, vertices + places.len() as u32);
                        places.push((key, part.vertices[own as usize]));
                    }
                });
            }
        }
        Self {
            vertices,
            places,
            numbers,
        }
    }

    /// What a vertex is called in the slab.
    fn local(&self, vertex: u32) -> u32 {
        if vertex < self.vertices {
            vertex
        } else {
            self.numbers[&vertex]
        }
    }
}

/// Where the mesher had to make do, each kind once.
fn told<'a>(
    fallbacks: impl Iterator<Item = &'a Fallback>,
    origin: DVec3,
) -> Vec<(FallbackKind, u64, Vec<DVec3>)> {
    let mut told: Vec<(FallbackKind, u64, Vec<DVec3>)> = Vec::new();
    for fallback in fallbacks {
        let known = told.iter().position(|&(kind, ..)| kind == fallback.kind);
        let at = known.unwrap_or_else(|| {
            told.push((fallback.kind, 0, Vec::new()));
            told.len() - 1
        });
        let (_, count, places) = &mut told[at];
        *count += 1;
        if places.len() < PLACES_PER_FALLBACK {
            places.push(fallback.place + origin);
        }
    }
    told
}

/// What tells one mesh from others: the program, and where the samples are.
fn fingerprint(program: &Program, scene: Option<&Scene<'_>>) -> u64 {
    let mut hasher = SipHasher13::new();
    let numbers = |hasher: &mut SipHasher13, numbers: &[f64]| {
        numbers.iter().for_each(|x| hasher.write_u64(x.to_bits()));
    };
    for surface in program.surfaces() {
        numbers(&mut hasher, &surface.anchor.to_array());
        numbers(&mut hasher, &surface.quadratic);
        numbers(&mut hasher, &surface.linear.to_array());
        numbers(&mut hasher, &[surface.constant]);
    }
    let formula = program.formula();
    for literal in formula.literals() {
        hasher.write_u32(literal.surface);
        hasher.write_u32(literal.origin);
        hasher.write_u8(literal.outside.into());
    }
    for origin in program.origins() {
        hasher.write(origin.name.as_deref().unwrap_or_default().as_bytes());
        let color = origin
            .color
            .map(|color| [color.rgb[0], color.rgb[1], color.rgb[2], color.alpha]);
        for component in color.into_iter().flatten() {
            hasher.write_u32(component.to_bits());
        }
        hasher.write_u8(0xff);
    }
    let operand = |hasher: &mut SipHasher13, operand: Operand| {
        let (kind, index) = match operand {
            Operand::Constant(value) => (0, value.into()),
            Operand::Literal(index) => (1, index),
            Operand::Gate(index) => (2, index),
        };
        hasher.write_u8(kind);
        hasher.write_u32(index);
    };
    for gate in formula.gates() {
        hasher.write_u8(gate.operation.absorbing().into());
        for &of in formula.operands_of(gate) {
            operand(&mut hasher, of);
        }
    }
    operand(&mut hasher, formula.root());
    if let Some(Scene { lattice, .. }) = scene {
        let first = [0, 1, 2].map(|axis| lattice.coordinate(axis, 0));
        numbers(&mut hasher, &first);
        numbers(&mut hasher, &[lattice.step]);
        for bricks in lattice.bricks.to_array() {
            hasher.write_u32(bricks);
        }
    }
    hasher.finish()
}
