//! The draft: surface nets (Gibson 1998, here of the crate
//! fast-surface-nets) on sparse bricks.
//!
//! Boxes of bricks are pruned and split until a box is decided or is a single
//! brick, which is sampled and meshed with one sample of apron on its lower
//! sides. Each sign change on a lattice edge gives one quadrilateral in one
//! brick, whose corners are the vertices of the four cells around the edge;
//! those that lie in a lower neighbour are looked up there by their cell. So
//! bricks join without seams: the surface is closed, whatever the solid.

mod attribution;
mod field;
mod lattice;

use crate::clock::Instant;

use fast_surface_nets::ndshape::ConstShape3u32;
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use glam::{DVec3, IVec3, Vec3};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use self::attribution::Attribution;
use self::field::{Field, ROW, Scratch, distance};
use self::lattice::Lattice;
use crate::control::Stage;
use crate::error::Error;
use crate::mesh::{Mesh, MeshSurface};
use crate::program::{Cell, Pruner};
use crate::report::Report;
use crate::task::Task;

/// Cells along the side of a brick: with the apron its samples fill rows of
/// [`ROW`].
const SIDE: i32 = ROW as i32 - 2;
type Samples = ConstShape3u32<{ ROW as u32 }, { ROW as u32 }, { ROW as u32 }>;

/// About what is held at a time for each vertex and what becomes of it.
const BYTES_PER_VERTEX: usize = 300;

/// Meshes the task's program on its lattice.
pub(crate) fn mesh(task: &Task, report: &mut Report) -> Result<Mesh, Error> {
    let start = Instant::now();
    let lattice = &Lattice::new(task.size, task.cell);
    let first = lattice.first.map(|i| i.div_euclid(SIDE));
    let end = lattice.end.map(|i| (i - 1).div_euclid(SIDE) + 1);
    let volume = |low: IVec3, high: IVec3| (high - low).as_u64vec3().element_product();
    let bricks = volume(first, end);
    let stage = task.control.stage(bricks, 0.0, 0.9);
    let walk = Walk {
        task,
        lattice,
        stage: &stage,
        first,
        end,
    };
    let mut patches = Vec::new();
    walk.region(first, end, &task.program.root_cell(), &mut patches)?;
    let start = report.end_stage("sample", start);

    let brick_cells = (SIDE as u64).pow(3);
    report.cells_visited = patches.len() as u64 * brick_cells;
    report.cells_pruned = (bricks - patches.len() as u64) * brick_cells;
    patches.retain(|patch| !patch.cells.is_empty());
    report.surface_cells = patches.iter().map(|p| p.positions.len() as u64).sum();
    for patch in &patches {
        for place in &patch.unclear {
            report.add_fallback("triangle between surfaces", *place + task.origin);
        }
    }
    let mesh = join(task, &patches)?;
    report.end_stage("join", start);
    Ok(mesh)
}

/// What one brick contributes.
#[derive(Default)]
struct Patch {
    brick: IVec3,
    /// The local cells that have a vertex, ascending, apron included; local
    /// vertices are numbered in this order.
    cells: Vec<u16>,
    /// The local vertices that are the brick's own.
    own: Vec<u16>,
    /// Positions of its own vertices, relative to the task's origin.
    positions: Vec<DVec3>,
    /// Triangles between local vertices.
    triangles: Vec<[u16; 3]>,
    /// For each triangle: surface, primitive.
    surfaces: Vec<(u32, u32)>,
    normals: Vec<[Vec3; 3]>,
    /// The largest distance of a vertex from the surface of a triangle at it.
    distance: f64,
    /// Triangles that no single surface accounts for.
    unclear: Vec<DVec3>,
}

/// The recursion over boxes of bricks.
struct Walk<'a> {
    task: &'a Task<'a>,
    lattice: &'a Lattice,
    stage: &'a Stage<'a>,
    /// All bricks.
    first: IVec3,
    end: IVec3,
}

/// Scratch memory of one thread's work on a brick.
#[derive(Default)]
struct Workspace {
    field: Scratch,
    nets: SurfaceNetsBuffer,
}

impl Walk<'_> {
    /// Appends the patches of the bricks from `low` to before `high`, in an
    /// order that depends on nothing but the lattice. `parent` is a pruned
    /// cell that holds for the whole region.
    fn region(
        &self,
        low: IVec3,
        high: IVec3,
        parent: &Cell,
        patches: &mut Vec<Patch>,
    ) -> Result<(), Error> {
        self.task.control.check()?;
        let size = high - low;
        // The samples of all bricks in the region, aprons included.
        let (center, half) = self.lattice.box_around(low * SIDE - 1, high * SIDE);
        let mut cell = Cell::default();
        parent.prune_into(
            &self.task.surfaces,
            center,
            half,
            &mut Pruner::default(),
            &mut cell,
        );
        if cell.constant().is_some() {
            self.stage.add(size.as_u64vec3().element_product());
            let at_border = low.cmple(self.first).any() || high.cmpge(self.end).any();
            return if cell.constant() == Some(true) && at_border {
                Err(self.reaches_out(center))
            } else {
                Ok(())
            };
        }
        if size.max_element() == 1 {
            let patch = self.brick(low, &cell)?;
            let bytes = BYTES_PER_VERTEX * patch.positions.len();
            self.task
                .control
                .spend((SIDE as u64).pow(3), bytes as u64)?;
            patches.push(patch);
            self.stage.add(1);
            return Ok(());
        }
        let middle = low + (size + 1) / 2;
        let octants: Vec<(IVec3, IVec3)> = (0..8)
            .map(|octant| {
                let upper = IVec3::new(octant & 1, octant >> 1 & 1, octant >> 2).cmpeq(IVec3::ONE);
                (
                    IVec3::select(upper, middle, low),
                    IVec3::select(upper, high, middle),
                )
            })
            .filter(|(low, high)| low.cmplt(*high).all())
            .collect();
        let parts: Vec<Vec<Patch>> = octants
            .into_par_iter()
            .map(|(low, high)| {
                let mut patches = Vec::new();
                self.region(low, high, &cell, &mut patches)?;
                Ok(patches)
            })
            .collect::<Result<_, Error>>()?;
        patches.extend(parts.into_iter().flatten());
        Ok(())
    }

    fn brick(&self, brick: IVec3, cell: &Cell) -> Result<Patch, Error> {
        let lattice = self.lattice;
        let field = Field {
            all: &self.task.surfaces,
            cell,
            unit: lattice.cell,
        };
        let mut work = Workspace::default();
        let base = brick * SIDE - 1;
        let at = |x: usize, y: usize, z: usize| {
            lattice.point(base + IVec3::new(x as i32, y as i32, z as i32))
        };
        let x: [f64; ROW] = std::array::from_fn(|i| at(i, 0, 0).x);
        let mut samples = vec![[0.0f32; ROW]; ROW * ROW];
        let (mut inside, mut outside) = (false, false);
        for (index, row) in samples.iter_mut().enumerate() {
            let point = at(0, index % ROW, index / ROW);
            field.fill_row(&x, point.y, point.z, &mut work.field, row);
            inside |= row.iter().any(|&value| value < 0.0);
            outside |= row.iter().any(|&value| value >= 0.0);
        }
        let mut patch = Patch {
            brick,
            ..Patch::default()
        };
        if inside {
            let at_low = brick.cmple(self.first);
            let at_high = (brick + 1).cmpge(self.end);
            let last = ROW - 1;
            for (index, &value) in samples.as_flattened().iter().enumerate() {
                let local = [index % ROW, index / ROW % ROW, index / (ROW * ROW)];
                let at_border = (0..3).any(|axis| {
                    at_low.test(axis) && local[axis] == 0
                        || at_high.test(axis) && local[axis] == last
                });
                if at_border && value < 0.0 {
                    return Err(self.reaches_out(at(local[0], local[1], local[2])));
                }
            }
        }
        if inside && outside {
            let last = ROW as u32 - 1;
            surface_nets(
                samples.as_flattened(),
                &Samples {},
                [0; 3],
                [last; 3],
                &mut work.nets,
            );
            self.collect(&work.nets, base, cell, &mut patch);
        }
        Ok(patch)
    }

    /// The error for a solid that is not where the caller said.
    fn reaches_out(&self, place: DVec3) -> Error {
        Error::InvalidOption(format!(
            "the solid reaches out of the given bounds near {}: give larger ones, or none",
            place + self.task.origin
        ))
    }

    /// Takes over what surface nets made of a brick whose local sample 0 is
    /// the global sample `base`.
    fn collect(&self, nets: &SurfaceNetsBuffer, base: IVec3, cell: &Cell, patch: &mut Patch) {
        let lattice = self.lattice;
        let positions: Vec<DVec3> = nets
            .positions
            .iter()
            .map(|&local| lattice.point(base) + Vec3::from(local).as_dvec3() * lattice.cell)
            .collect();
        for (vertex, (&stride, point)) in nets
            .surface_strides
            .iter()
            .zip(&nets.surface_points)
            .enumerate()
        {
            patch.cells.push(stride as u16);
            if !point.contains(&0) {
                patch.own.push(vertex as u16);
                patch.positions.push(positions[vertex]);
            }
        }
        let mut attribution = Attribution::new(&self.task.surfaces, cell, lattice.cell);
        for corners in nets.indices.chunks_exact(3) {
            let corners = [corners[0], corners[1], corners[2]];
            let points = corners.map(|vertex| positions[vertex as usize]);
            let Some(found) = attribution.of(points) else {
                continue;
            };
            if !found.clear {
                patch
                    .unclear
                    .push((points[0] + points[1] + points[2]) / 3.0);
            }
            patch.triangles.push(corners.map(|vertex| vertex as u16));
            patch.surfaces.push((found.surface, found.primitive));
            patch.normals.push(found.normals);
            let surface = &self.task.surfaces[found.surface as usize];
            for point in points {
                patch.distance = patch.distance.max(distance(surface, point));
            }
        }
    }
}

/// Welds the patches into one mesh: numbers their own vertices one patch
/// after another and looks the others up where they belong.
fn join(task: &Task, patches: &[Patch]) -> Result<Mesh, Error> {
    let total: usize = patches.iter().map(|patch| patch.positions.len()).sum();
    if total > u32::MAX as usize {
        return Err(Error::TooLarge {
            what: "vertices of the mesh",
            limit: u64::from(u32::MAX),
        });
    }
    let mut first_vertex = Vec::with_capacity(patches.len());
    let mut count = 0u32;
    for patch in patches {
        first_vertex.push(count);
        count += patch.positions.len() as u32;
    }
    let index_of: FxHashMap<IVec3, usize> = patches
        .iter()
        .enumerate()
        .map(|(index, patch)| (patch.brick, index))
        .collect();
    let used: FxHashSet<(u32, u32)> = patches
        .par_iter()
        .map(|patch| patch.surfaces.iter().copied().collect())
        .reduce(FxHashSet::default, |mut all: FxHashSet<_>, more| {
            all.extend(more);
            all
        });
    let mut used: Vec<(u32, u32)> = used.into_iter().collect();
    used.sort_unstable();
    let slot: FxHashMap<(u32, u32), u32> = used.iter().copied().zip(0..).collect();

    // The global index of a local vertex of a patch.
    let resolve = |index: usize, vertex: u16| {
        let patch = &patches[index];
        let code = i32::from(patch.cells[vertex as usize]);
        let row = ROW as i32;
        let local = IVec3::new(code % row, code / row % row, code / (row * row));
        let below = local.cmpeq(IVec3::ZERO);
        let owner = if below.any() {
            index_of[&(patch.brick - IVec3::select(below, IVec3::ONE, IVec3::ZERO))]
        } else {
            index
        };
        let there = IVec3::select(below, IVec3::splat(SIDE), local);
        let code = (there.x + (there.y + there.z * row) * row) as u16;
        let patch = &patches[owner];
        let own = patch
            .own
            .partition_point(|&vertex| patch.cells[vertex as usize] < code);
        first_vertex[owner] + own as u32
    };
    let triangles: Vec<Vec<[u32; 3]>> = patches
        .par_iter()
        .enumerate()
        .map(|(index, patch)| {
            let global: Vec<u32> = (0..patch.cells.len())
                .map(|vertex| resolve(index, vertex as u16))
                .collect();
            patch
                .triangles
                .iter()
                .map(|corners| corners.map(|vertex| global[vertex as usize]))
                .collect()
        })
        .collect();
    let origins = task.program.origins();
    Ok(Mesh {
        positions: patches
            .iter()
            .flat_map(|patch| patch.positions.iter().map(|p| *p + task.origin))
            .collect(),
        triangles: triangles.into_iter().flatten().collect(),
        triangle_surfaces: patches
            .iter()
            .flat_map(|patch| patch.surfaces.iter().map(|key| slot[key]))
            .collect(),
        surfaces: used
            .iter()
            .map(|&(surface, primitive)| {
                let origin = &origins[primitive as usize];
                MeshSurface {
                    surface,
                    primitive,
                    body: origin.body,
                    name: origin.name.clone(),
                    parts: origin.parts.clone(),
                    color: origin.color,
                }
            })
            .collect(),
        corner_normals: patches
            .iter()
            .flat_map(|patch| patch.normals.iter().copied())
            .collect(),
        ..Mesh::default()
    })
}
