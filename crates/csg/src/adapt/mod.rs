//! Adaptive meshing: cells as large as the solid is simple, every crossing of
//! every edge, and a surface that is manifold across cells of all sizes.
//!
//! 1. An octree is split until the program, pruned to a cell, is simple there
//!    ([`settle`], [`build`]).
//! 2. Every edge that no cell splits carries all changes of the solid along it
//!    in order ([`probe`]), so that two sheets closer than a cell stay two.
//! 3. Around every face the changes are paired by the surfaces they lie on
//!    ([`pairing`]); around every cell the pairs close to loops, and dually
//!    every loop is a vertex and every change a polygon ([`complex`]).
//! 4. Every vertex is placed on all the surfaces of its polygons. Cells where
//!    that cannot be are split again.

mod build;
mod complex;
#[cfg(test)]
mod complex_tests;
mod pairing;
mod probe;
mod settle;
mod touch;
mod tree;

use crate::clock::Instant;
use crate::elementary;

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use self::build::Grower;
use self::complex::{Complex, Corner, Cut, Edge, Transition};
use self::pairing::Geometric;
use self::probe::{Change, Probe, Scene};
use self::settle::{CORNER_SLACK, Expected, constraints_of, passage, vertex};
use self::tree::{MOST_LEVELS, ROOT_BITS};
use crate::error::Error;
use crate::mesh::Mesh;
use crate::numeric::tolerance::{COORDINATE, ON_SURFACE};
use crate::program::{Surface, SurfaceId};
use crate::report::Report;
use crate::surface::solve;
use crate::task::Task;

/// The root cell exceeds the solid's longest side by this share, and its
/// middle is off the solid's by these shares: irrational and different along
/// the axes, so that faces of models, which lie at round coordinates and often
/// symmetrically, meet no corner of a cell.
const ROOT: f64 = 1.190_983_005_625_053;
const SHIFT: DVec3 = DVec3::new(
    0.038_196_601_125_011,
    0.041_421_356_237_310,
    0.030_277_563_773_199,
);

/// Cells in which no vertex was found are split at most this often.
const ROUNDS: usize = 12;

/// In cells that may not be split a corner may lie outside by so many half
/// sides.
const LAST_SLACK: f64 = 3.0;

/// What is reported of vertices that should be elsewhere.
const UNSOUND: &str =
    "surfaces of a vertex without a common point near its cell, or a feature smaller than it";

/// What is reported of parts of the boundary that no cell shows.
const HIDDEN: &str = "part of the boundary that no edge of a cell shows: smaller than the smallest";

/// What is known of every loop's vertex.
struct Placed {
    position: DVec3,
    /// Whether it lies on all its surfaces and the solid changes there.
    is_sound: bool,
}

/// All changes of the solid on the edges of a tree.
#[derive(Default)]
struct Crossings {
    edges: Vec<Edge>,
    transitions: Vec<Transition>,
    changes: Vec<Change>,
    axes: Vec<u8>,
}

impl Crossings {
    fn find(scene: &Scene<'_>, grower: &Grower<'_, '_>, probe: &mut Probe) -> Self {
        let mut all = Self::default();
        grower.tree.for_each_edge(|leaf| {
            let cells = leaf.cells.map(|cell| &grower.leaves[cell as usize].cell);
            // All four tell the same; the shortest tells it first.
            let Some(cell) = cells.into_iter().min_by_key(|cell| cell.surfaces.len()) else {
                return;
            };
            let mut end = leaf.start;
            end[leaf.axis] += leaf.length;
            let first = all.changes.len();
            let ends = [scene.point(leaf.start), scene.point(end)];
            probe.changes_along(scene, cell, leaf.axis, ends, &mut all.changes);
            let count = all.changes.len() - first;
            if count == 0 {
                return;
            }
            let edge = all.edges.len() as u32;
            for change in &all.changes[first..] {
                all.transitions.push(Transition {
                    edge,
                    enters: change.enters,
                });
                all.axes.push(leaf.axis as u8);
            }
            all.edges.push(Edge {
                axis: leaf.axis,
                cells: leaf.cells,
                small: leaf.small,
                start: leaf.start,
                first: first as u32,
                count: count as u32,
            });
        });
        all
    }
}

/// A mesh of the solid with as few cells as its shape permits, in the local
/// frame. No cell is split that is smaller than the task's.
pub(crate) fn mesh(task: &Task<'_>, report: &mut Report) -> Result<Mesh, Error> {
    let start = Instant::now();
    let longest = task.size.max_element();
    let side = ROOT * longest;
    let scene = Scene {
        surfaces: &task.surfaces,
        origins: task.program.origins(),
        first: SHIFT * longest - 0.5 * side,
        unit: side / f64::from(1u32 << ROOT_BITS),
        tolerance: ON_SURFACE * longest + COORDINATE * task.origin.length(),
    };
    let levels = elementary::log2(side / task.cell)
        .ceil()
        .clamp(1.0, f64::from(MOST_LEVELS));
    let mut grower = Grower::new(&scene, levels as u32, task.control);
    grower.grow(&task.program.root_cell())?;
    let start = report.end_stage("cells", start);
    let mut probe = Probe::default();
    let mut complex = Complex::default();
    let mut crossings;
    let mut placed;
    let mut round = 0;
    loop {
        task.control.check()?;
        crossings = Crossings::find(&scene, &grower, &mut probe);
        let mut pairing = Geometric {
            scene: &scene,
            probe: &mut probe,
            changes: &crossings.changes,
            axes: &crossings.axes,
            cell: |leaf: u32| &grower.leaves[leaf as usize].cell,
        };
        complex.build(&crossings.edges, &crossings.transitions, None, &mut pairing);
        placed = place(&scene, &grower, &complex, &crossings, &mut probe);
        let mut unsound: Vec<usize> = complex
            .loops
            .iter()
            .zip(&placed)
            .filter(|(_, placed)| !placed.is_sound)
            .map(|(of, _)| of.cell as usize)
            .filter(|&leaf| grower.leaves[leaf].place.level < grower.most_levels)
            .collect();
        unsound.sort_unstable();
        unsound.dedup();
        round += 1;
        if unsound.is_empty() || round > ROUNDS {
            break;
        }
        for leaf in unsound {
            grower.split_leaf(leaf)?;
        }
    }
    report.cells_visited = grower.visited;
    report.cells_pruned = grower.pruned;
    report.surface_cells = grower.leaves.len() as u64;
    let start = report.end_stage("vertices", start);
    let (mesh, strays) = assemble(task, &scene, &mut complex, &crossings, &placed);
    let unsound = placed.iter().filter(|p| !p.is_sound).map(|p| p.position);
    for place in unsound.chain(strays) {
        report.add_fallback(UNSOUND, place + task.origin);
    }
    for place in &grower.hidden {
        report.add_fallback(HIDDEN, *place + task.origin);
    }
    report.end_stage("triangles", start);
    Ok(mesh)
}

/// The vertices of all loops.
fn place(
    scene: &Scene<'_>,
    grower: &Grower<'_, '_>,
    complex: &Complex,
    crossings: &Crossings,
    probe: &mut Probe,
) -> Vec<Placed> {
    let mut placed = Vec::with_capacity(complex.loops.len());
    for of in &complex.loops {
        let leaf = &grower.leaves[of.cell as usize];
        let (surfaces, start) =
            constraints_of(scene, complex.transitions_of(of), &crossings.changes);
        let half = 0.5 * scene.unit * f64::from(leaf.place.size());
        let middle = scene.point(leaf.place.corner) + half;
        let surface = |id: u32| &scene.surfaces[id as usize];
        // A loop on one surface passes a star by, but around a cone's apex.
        let at_star = surfaces.len() > 1 || surface(surfaces[0]).apex().is_some();
        if let Some(star) = leaf.star.filter(|_| at_star) {
            placed.push(Placed {
                position: star,
                is_sound: true,
            });
            continue;
        }
        // The last cells take what is near: their neighbours are as small.
        let is_last = leaf.place.level >= grower.most_levels;
        let about = Expected {
            start,
            middle,
            half,
            corner_slack: if is_last { LAST_SLACK } else { CORNER_SLACK },
        };
        let found = vertex(scene, probe, &leaf.cell, &surfaces, about);
        placed.push(Placed {
            position: found.unwrap_or(start),
            is_sound: found.is_some(),
        });
    }
    placed
}

/// The mesh: triangles of all polygons, with the points of transitions and
/// arcs that are vertices; and those of them that are not on their surfaces.
fn assemble(
    task: &Task<'_>,
    scene: &Scene<'_>,
    complex: &mut Complex,
    crossings: &Crossings,
    placed: &[Placed],
) -> (Mesh, Vec<DVec3>) {
    let mut positions: Vec<DVec3> = placed.iter().map(|p| p.position).collect();
    let mut more: FxHashMap<Corner, u32> = FxHashMap::default();
    let mut entries: FxHashMap<(u32, u32), u32> = FxHashMap::default();
    let mut mesh = Mesh::default();
    let mut strays = Vec::new();
    let changes = &crossings.changes;
    let faces = Faces {
        scene,
        crossings,
        placed,
    };
    faces.unfold(complex);
    complex.triangles(
        &crossings.edges,
        &crossings.transitions,
        |transition, loops, safe| faces.cut(transition, loops, safe),
        |transition, corners| {
            let change = &changes[transition as usize];
            let entry = *entries
                .entry((change.surface, change.origin))
                .or_insert_with(|| {
                    mesh.surfaces
                        .push(task.mesh_surface(SurfaceId(change.surface), change.origin));
                    mesh.surfaces.len() as u32 - 1
                });
            mesh.triangles.push(corners.map(|corner| {
                if let Corner::Loop(index) = corner {
                    return index;
                }
                *more.entry(corner).or_insert_with(|| {
                    let place = faces.position(complex, corner);
                    let on = faces.surfaces_at(complex, corner);
                    if solve::residual(on.into_iter(), place) > scene.tolerance {
                        strays.push(place);
                    }
                    positions.push(place);
                    positions.len() as u32 - 1
                })
            }));
            mesh.triangle_surfaces.push(entry);
        },
    );
    mesh.positions = positions;
    (mesh, strays)
}

/// Where polygons are, and which way they face.
struct Faces<'a> {
    scene: &'a Scene<'a>,
    crossings: &'a Crossings,
    placed: &'a [Placed],
}

impl Faces<'_> {
    fn surface(&self, transition: u32) -> &Surface {
        let change = &self.crossings.changes[transition as usize];
        &self.scene.surfaces[change.surface as usize]
    }

    /// The outward direction at a transition.
    fn outward(&self, transition: u32) -> DVec3 {
        let change = &self.crossings.changes[transition as usize];
        let axis = usize::from(self.crossings.axes[transition as usize]);
        let gradient = self.surface(transition).gradient(change.point);
        if (gradient[axis] > 0.0) == change.enters {
            -gradient
        } else {
            gradient
        }
    }

    /// How a quadrilateral is cut: along the safe diagonal that folds nothing
    /// and is nearer to the surface.
    fn cut(&self, transition: u32, loops: [u32; 4], safe: [bool; 2]) -> Cut {
        let outward = self.outward(transition);
        let [a, b, c, d] = loops.map(|l| self.placed[l as usize].position);
        let folds = |p, q, r| is_folded([p, q, r], outward);
        let first = safe[0] && !folds(a, b, c) && !folds(a, c, d);
        let second = safe[1] && !folds(b, c, d) && !folds(b, d, a);
        let off = |p: DVec3| self.surface(transition).value(p).abs();
        match (first, second) {
            (false, false) => Cut::Middle,
            (true, false) => Cut::First,
            (true, true) if off(0.5 * (a + c)) <= off(0.5 * (b + d)) => Cut::First,
            (_, true) => Cut::Second,
        }
    }

    /// Keeps the points of all polygons that fold otherwise.
    fn unfold(&self, complex: &mut Complex) {
        let Crossings {
            edges, transitions, ..
        } = self.crossings;
        for (at, transition) in (0u32..).zip(transitions) {
            let edge = &edges[transition.edge as usize];
            let (corners, safe) = complex.polygon(edge, at, transition.enters);
            let kept = complex.is_kept(at);
            let is_quadrilateral_without_fold = match corners.as_slice() {
                &[
                    Corner::Loop(a),
                    Corner::Loop(b),
                    Corner::Loop(c),
                    Corner::Loop(d),
                ] if !kept => self.cut(at, [a, b, c, d], safe) != Cut::Middle,
                _ => false,
            };
            if is_quadrilateral_without_fold {
                continue;
            }
            let outward = self.outward(at);
            let places: SmallVec<[DVec3; 8]> = corners
                .iter()
                .map(|&corner| self.position(complex, corner))
                .collect();
            let folds = if let (&[a, b, c], false) = (places.as_slice(), kept) {
                is_folded([a, b, c], outward)
            } else {
                let middle = self.position(complex, Corner::Transition(at));
                (0..places.len()).any(|k| {
                    is_folded([middle, places[k], places[(k + 1) % places.len()]], outward)
                })
            };
            if folds {
                complex.keep(at);
            }
        }
    }

    /// The surfaces of the polygons at the point of a transition or an arc.
    fn surfaces_at(&self, complex: &Complex, corner: Corner) -> SmallVec<[&Surface; 2]> {
        match corner {
            Corner::Arc(arc) => {
                let arc = complex.arcs[arc as usize];
                let both = [self.surface(arc.from), self.surface(arc.to)];
                let few = if std::ptr::eq(both[0], both[1]) { 1 } else { 2 };
                both[..few].into()
            }
            Corner::Transition(at) => std::iter::once(self.surface(at)).collect(),
            Corner::Loop(_) => SmallVec::new(),
        }
    }

    /// Where a corner lies.
    fn position(&self, complex: &Complex, corner: Corner) -> DVec3 {
        let changes = &self.crossings.changes;
        match corner {
            Corner::Loop(index) => self.placed[index as usize].position,
            Corner::Arc(arc) => {
                let arc = complex.arcs[arc as usize];
                let (from, to) = (&changes[arc.from as usize], &changes[arc.to as usize]);
                let place = passage(self.scene, from, to, arc.normal);
                // To rounding on both surfaces, if need be off the face.
                let both = self.surfaces_at(complex, corner);
                let reach = (from.point - to.point).length();
                solve::common_point(&both, place, reach).point
            }
            Corner::Transition(at) => {
                let point = changes[at as usize].point;
                let reach = 1e3 * self.scene.tolerance.max(f64::MIN_POSITIVE);
                solve::common_point(&[self.surface(at)], point, reach).point
            }
        }
    }
}

/// Whether a triangle faces away from a direction.
fn is_folded([p, q, r]: [DVec3; 3], outward: DVec3) -> bool {
    (q - p).cross(r - p).dot(outward) <= 0.0
}
