//! From the contours of patches to faces, loops, edges and vertices.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::data::{
    Brep, CoedgeData, CoedgeId, EdgeData, EdgeId, FaceData, FaceId, LoopData, LoopId, Patch,
    ShellData, ShellId, Stretch, VertexId,
};
use super::loops::{Links, Loops};
use super::patches::{Curves, Region, regions};
use super::seams::Seams;
use super::slits;
use crate::arrangement::{Arrangement, CurveId, HalfEdgeId};
use crate::numeric::Groups;
use crate::undecided::{Undecided, Why};

/// No vertex, edge or face.
const NONE: u32 = u32::MAX;

/// Whether a half-edge bounds a face: the surface, its look or the side of it that is solid
/// changes there, or faces are to be cut at seams.
fn is_edge(all: &Arrangement, half: HalfEdgeId, seams: Option<&Seams>) -> bool {
    let half_edge = all.at(half);
    let look = |half: HalfEdgeId| {
        let side = all.side(half);
        (side.plane, side.along_normal, side.look)
    };
    look(half) != look(half_edge.twin)
        || half_edge.curve.is_seam() && seams.is_some_and(|seams| seams.has(all, half_edge))
}

/// Adds the boundary of an arrangement to an empty one.
pub(super) fn build(
    mut brep: Brep,
    mut all: Arrangement,
    cut_at_seams: bool,
) -> Result<Brep, Undecided> {
    let curves = curves(&all)?;
    let regions = regions(&all, &brep.surfaces, &curves)?;
    let seams = cut_at_seams.then(|| Seams::new(&all, &brep.surfaces));
    if cut_at_seams {
        let is_edge: Vec<bool> = all
            .halves()
            .map(|half| is_edge(&all, half, seams.as_ref()))
            .collect();
        let is_edge = |half: HalfEdgeId| is_edge[half.index()];
        let face_of = faces_of(&all, &regions, is_edge);
        let face_of = |half: HalfEdgeId| is_edge(half).then(|| face_of[half.index()]);
        slits::close(&mut all, &curves, brep.size, face_of);
    }
    let is_edge = |half| is_edge(&all, half, seams.as_ref());
    let faces = Faces::new(&all, regions, is_edge)?;
    let links = Links::new(&all, is_edge, cut_at_seams);
    let chains = links.edges(&all);
    let mut vertex_of = vec![NONE; all.points.len()];
    let mut coedge_of = vec![NONE; all.half_edges.len()];
    brep.number_coedges(&faces, &links, &mut coedge_of);
    for chain in &chains {
        let mut places = chain.half_edges.iter().map(|&half| all.at(half).places);
        let start = places.clone().next().map_or(0.0, |[from, _]| from);
        let end = start + places.by_ref().map(|[from, to]| to - from).sum::<f64>();
        let (first, last) = (
            chain.half_edges[0],
            chain.half_edges[chain.half_edges.len() - 1],
        );
        let ends = [first, all.at(last).twin];
        let mut coedges = ends.map(|half| CoedgeId::new(coedge_of[half.index()] as usize));
        let mut vertices = (!chain.is_ring).then(|| {
            ends.map(|half| {
                let point = all.at(half).from.index();
                let vertex = &mut vertex_of[point];
                if *vertex == NONE {
                    *vertex = brep.points.len() as u32;
                    brep.points.push(all.points[point]);
                }
                VertexId::new(*vertex as usize)
            })
        });
        if end < start {
            coedges.reverse();
            if let Some(vertices) = &mut vertices {
                vertices.reverse();
            }
        }
        let edge = EdgeId::new(brep.edges.len());
        for coedge in coedges {
            brep.coedges[coedge.index()].edge = edge;
        }
        brep.edges.push(EdgeData {
            curve: curves.of_half_edge[first.index()],
            range: [start.min(end), start.max(end)],
            coedges,
            vertices,
        });
    }
    brep.add_patches(&all, &faces, &curves);
    brep.curves = curves.all;
    brep.meridians = seams
        .as_ref()
        .map_or_else(Vec::new, |seams| seams.meridians(&all));
    brep.frames = all.frames;
    Ok(brep)
}

/// The curves of all half-edges.
fn curves(all: &Arrangement) -> Result<Curves, Undecided> {
    let mut number: FxHashMap<CurveId, u32> = FxHashMap::default();
    let mut curves = Curves {
        of_half_edge: Vec::with_capacity(all.half_edges.len()),
        all: Vec::new(),
    };
    for half_edge in &all.half_edges {
        let id = match number.get(&half_edge.curve) {
            Some(&id) => id,
            None => {
                let curve = all.curves.get(&half_edge.curve).ok_or(Undecided {
                    why: Why::Curve,
                    place: all.points[half_edge.from.index()],
                })?;
                curves.all.push(curve.clone());
                let id = curves.all.len() as u32 - 1;
                number.insert(half_edge.curve, id);
                id
            }
        };
        curves.of_half_edge.push(id);
    }
    Ok(curves)
}

/// For each half-edge its region.
fn regions_of(all: &Arrangement, regions: &[Region]) -> Vec<u32> {
    let mut region_of = vec![NONE; all.half_edges.len()];
    for (index, region) in (0u32..).zip(regions) {
        for &half in region.contours.iter().flatten() {
            region_of[half.index()] = index;
        }
    }
    region_of
}

/// For each half-edge its face, named by one of its regions.
fn faces_of(
    all: &Arrangement,
    regions: &[Region],
    is_edge: impl Fn(HalfEdgeId) -> bool,
) -> Vec<u32> {
    let mut of_half = regions_of(all, regions);
    let mut faces = Groups::new(regions.len());
    for half in all.halves().filter(|&half| !is_edge(half)) {
        faces.join([half, all.at(half).twin].map(|half| of_half[half.index()]));
    }
    for region in &mut of_half {
        *region = faces.first(*region);
    }
    of_half
}

/// The parts of patches put together to faces, and these to shells.
struct Faces {
    /// In the order of shells and faces.
    regions: Vec<Region>,
    /// For each region its face, ascending.
    face_of: Vec<u32>,
    /// For each face its shell, ascending.
    shell_of: Vec<u32>,
    /// For each shell how many handles it has.
    genus: Vec<u32>,
}

impl Faces {
    fn new(
        all: &Arrangement,
        regions: Vec<Region>,
        is_edge: impl Fn(HalfEdgeId) -> bool,
    ) -> Result<Self, Undecided> {
        let region_of = regions_of(all, &regions);
        let mut faces = Groups::new(regions.len());
        let mut shells = Groups::new(regions.len());
        for half in all.halves() {
            let pair = [half, all.at(half).twin].map(|half| region_of[half.index()]);
            shells.join(pair);
            if !is_edge(half) {
                faces.join(pair);
            }
        }
        let keys = (0u32..).zip(&regions);
        let keys = keys.map(|(region, _)| [shells.first(region), faces.first(region)]);
        let keys: Vec<[u32; 2]> = keys.collect();
        let mut order: Vec<usize> = (0..regions.len()).collect();
        order.sort_by_key(|&region| keys[region]);
        let (mut face_of, mut shell_of) = (Vec::new(), Vec::<u32>::new());
        let mut last: Option<[u32; 2]> = None;
        for key in order.iter().map(|&region| keys[region]) {
            if last != Some(key) {
                let is_same_shell = last.is_some_and(|last| last[0] == key[0]);
                let before = shell_of.last().map_or(0, |&shell| shell + 1);
                shell_of.push(before - u32::from(is_same_shell));
            }
            face_of.push(shell_of.len() as u32 - 1);
            last = Some(key);
        }
        let mut regions: Vec<Option<Region>> = regions.into_iter().map(Some).collect();
        let regions = order.iter().filter_map(|&region| regions[region].take());
        let mut all_faces = Self {
            regions: regions.collect(),
            face_of,
            shell_of,
            genus: Vec::new(),
        };
        all_faces.count_handles(all)?;
        Ok(all_faces)
    }

    /// By Euler's formula, V - E + F = 2 - 2 genus, where a patch with holes counts as one
    /// that was cut open.
    fn count_handles(&mut self, all: &Arrangement) -> Result<(), Undecided> {
        let shells = self.shell_of.last().map_or(0, |&last| last as usize + 1);
        let mut sums = vec![0i64; shells];
        let mut is_seen = vec![false; all.points.len()];
        let mut place = vec![DVec3::ZERO; shells];
        for (region, &face) in self.regions.iter().zip(&self.face_of) {
            let shell = self.shell_of[face as usize] as usize;
            sums[shell] += 2 * (2 - region.contours.len() as i64);
            for &half in region.contours.iter().flatten() {
                sums[shell] -= 1;
                let vertex = all.at(half).from.index();
                place[shell] = all.points[vertex];
                if !std::mem::replace(&mut is_seen[vertex], true) {
                    sums[shell] += 2;
                }
            }
        }
        for (&twice, &place) in sums.iter().zip(&place) {
            let twice_genus = 4 - twice;
            if twice_genus < 0 || twice_genus % 4 != 0 {
                return Err(Undecided {
                    why: Why::Contour,
                    place,
                });
            }
            self.genus.push((twice_genus / 4) as u32);
        }
        Ok(())
    }
}

impl Brep {
    /// Adds faces, loops and coedges, whose edges are not known yet.
    fn number_coedges(&mut self, faces: &Faces, links: &Links, coedge_of: &mut [u32]) {
        let mut loops = Loops::new(links);
        for (index, region) in faces.regions.iter().enumerate() {
            let face = faces.face_of[index];
            if self.faces.len() as u32 == face {
                let shell = faces.shell_of[face as usize];
                if self.shells.len() as u32 == shell {
                    self.shells.push(ShellData {
                        faces: (face, 0),
                        genus: faces.genus[shell as usize],
                    });
                }
                self.faces.push(FaceData {
                    side: region.side,
                    shell: ShellId::new(shell as usize),
                    loops: (self.loops.len() as u32, 0),
                    patches: (index as u32, 0),
                });
                if let Some(shell) = self.shells.last_mut() {
                    shell.faces.1 += 1;
                }
            }
            let face_data = &mut self.faces[face as usize];
            face_data.patches.1 += 1;
            for &half in region.contours.iter().flatten() {
                let Some(around) = loops.from(half) else {
                    continue;
                };
                let first = self.coedges.len() as u32;
                for edge in &around {
                    for &half in edge {
                        coedge_of[half.index()] = self.coedges.len() as u32;
                    }
                    self.coedges.push(CoedgeData {
                        edge: EdgeId::new(NONE as usize),
                        face_loop: LoopId::new(self.loops.len()),
                    });
                }
                self.loops.push(LoopData {
                    face: FaceId::new(face as usize),
                    coedges: (first, around.len() as u32),
                });
                face_data.loops.1 += 1;
            }
        }
    }

    fn add_patches(&mut self, all: &Arrangement, faces: &Faces, curves: &Curves) {
        for region in &faces.regions {
            let stretches = region.contours.iter();
            let stretches = stretches.flat_map(|contour| stretches_of(all, curves, contour));
            self.patches.push(Patch {
                side: region.side,
                stretches: stretches.collect(),
            });
        }
    }
}

/// The pieces of curves around a contour; pieces that go on and on are one.
fn stretches_of(all: &Arrangement, curves: &Curves, contour: &[HalfEdgeId]) -> Vec<Stretch> {
    let mut stretches: Vec<Stretch> = Vec::new();
    for &half in contour {
        let half_edge = all.at(half);
        let id = curves.of_half_edge[half.index()];
        let curve = &curves.all[id as usize];
        let [start, end] = all.chord(half_edge);
        let [from, to] = half_edge.places;
        let off = |place: f64, point: DVec3| curve.at(place).distance(point);
        let gap = off(from, start).max(off(to, end));
        match stretches.last_mut() {
            // To the bit: only chords of one stretch are.
            Some(last) if last.curve == id && last.places[1] == from => {
                last.places[1] = to;
                last.gap = last.gap.max(gap);
            }
            _ => stretches.push(Stretch {
                curve: id,
                places: [from, to],
                gap,
            }),
        }
    }
    stretches
}
