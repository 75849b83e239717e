//! Bodies of a solid that are the same but for where they are, given the same triangles.

use std::sync::Arc;

use csg::brep::{CurveShape, Face, Shell};
use csg::{Bounds, Brep, Color, Mesh, Surface, SurfaceShape};
use glam::{DMat3, DQuat, DVec3};
use rustc_hash::FxHashMap;

use crate::repeats::{OF_COORDINATES, OF_SIZE, connected};

/// Intervals of an edge between the points by which edges with the same faces are told apart.
const INTERVALS: u32 = 8;

/// How many motions are tried for two bodies.
const TRIED: usize = 256;

/// Bodies of more marks are left as they are: all are compared with all.
const MOST_MARKS: usize = 2048;

/// A box of triangles is taken for that of the nearest body on the same surfaces if any other one's is
/// so many times as far from it.
const NEARER: f64 = 8.0;

/// Gives connected parts of a mesh that are the same in the solid, but for where they are and how they
/// are turned, the same triangles, so that [`crate::WriteOptions::instances`] finds them; says how
/// many parts have those of another one now.
///
/// `brep` is the boundary of the program of which the mesh was made, not cut at seams. Two of its
/// shells are the same if one rotation and one translation take surfaces, edges and corners of the
/// one to those of the other, within a 2^-36th of the coordinate that is farthest from 0 and a 2^-22th
/// of their own size, with the same names and colours. The triangles of the first one are then
/// moved to the place of the other, so that the mesh deviates from the solid as far as before, but
/// for so much. Mirrored ones are others. Surfaces of a mesh that was made of moved ones
/// ([`csg::Report::moved`]) are not the boundary's: such a mesh is not for this.
///
/// The mesh is left as it is where triangles that were moved would run through others: those of
/// bodies that are nearer to each other than the mesh is to them.
pub fn share_triangles(mesh: &mut Mesh, brep: &Brep) -> usize {
    if brep.moved().is_some() || brep.is_cut_at_seams() || mesh.triangle_surfaces.is_empty() {
        return 0;
    }
    let all = mesh.positions.iter();
    let largest = all.fold(0.0_f64, |size, place| size.max(place.abs().max_element()));
    let mut kinds: FxHashMap<[usize; 3], Vec<Body>> = FxHashMap::default();
    let mut copies = Vec::new();
    let all = bodies(mesh, brep).into_iter();
    for body in all.filter(|body| body.marks.len() <= MOST_MARKS) {
        let rounding = (OF_COORDINATES * largest).min(OF_SIZE * body.radius);
        let counts = [body.sides.len(), body.rims.len(), body.marks.len()];
        let known = kinds.entry(counts).or_default();
        let same = known.iter().find_map(|first| {
            let (motion, images) = first.motion_to(&body, rounding)?;
            let looks = first.looks_in(&body, &images, mesh)?;
            Some((first.triangles.clone(), motion, looks))
        });
        match same {
            Some((triangles, motion, looks)) => copies.push(Copy {
                of: triangles,
                instead_of: body.triangles,
                motion,
                looks,
            }),
            None => known.push(body),
        }
    }
    if copies.is_empty() {
        return 0;
    }
    let shared = with_copies(mesh, &copies);
    let crossings = shared.self_intersections().len();
    if crossings > 0 && crossings > mesh.self_intersections().len() {
        return 0;
    }
    *mesh = shared;
    copies.len()
}

/// What faces are told apart by, where they lie on one surface.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Look {
    name: Option<Arc<str>>,
    parts: Arc<[Arc<str>]>,
    color: Option<[u32; 4]>,
}

impl Look {
    fn new(name: &Option<Arc<str>>, parts: &Arc<[Arc<str>]>, color: Option<Color>) -> Self {
        let bits = |color: Color| [color.rgb[0], color.rgb[1], color.rgb[2], color.alpha];
        Self {
            name: name.clone(),
            parts: parts.clone(),
            color: color.map(|color| bits(color).map(f32::to_bits)),
        }
    }
}

/// A surface with the solid on one side.
struct Side {
    /// Its number in the program.
    index: usize,
    surface: Surface,
    is_along_gradient: bool,
    look: Look,
}

impl Side {
    fn of(face: Face<'_>) -> Self {
        let origin = face.origin();
        Self {
            index: face.surface_index(),
            surface: face.surface(),
            is_along_gradient: face.is_along_gradient(),
            look: Look::new(&origin.name, &origin.parts, origin.color),
        }
    }

    /// Above 0 outside.
    fn value(&self, place: DVec3) -> f64 {
        let value = self.surface.value(place);
        if self.is_along_gradient {
            value
        } else {
            -value
        }
    }

    /// Whether it becomes the other one: the values at enough places are the same but for a factor.
    fn becomes(&self, other: &Self, motion: &Motion, places: &[DVec3], rounding: f64) -> bool {
        if self.look != other.look || self.surface.is_plane() != other.surface.is_plane() {
            return false;
        }
        let (mut product, mut square) = (0.0, 0.0);
        for &place in places {
            let value = self.value(place);
            product += value * other.value(motion.apply(place));
            square += value * value;
        }
        let factor = product / square;
        factor > 0.0
            && places.iter().all(|&place| {
                let image = motion.apply(place);
                let off = (other.value(image) - factor * self.value(place)).abs();
                off <= rounding * other.surface.gradient(image).length()
            })
    }
}

/// A piece of a curve between two sides.
struct Rim {
    /// On the left of it, and on the right.
    sides: [usize; 2],
    /// From end to end.
    points: Vec<DVec3>,
    is_closed: bool,
}

impl Rim {
    /// Whether it becomes the other one, of the same surfaces: the ends do, and the middle is where that
    /// of the other one is, nearer than its ends are.
    fn becomes(&self, other: &[DVec3], motion: &Motion, rounding: f64) -> bool {
        let moved: Vec<DVec3> = self.points.iter().map(|&p| motion.apply(p)).collect();
        let ends = [0, INTERVALS as usize];
        let near = |k: usize| moved[k].distance(other[k]) <= rounding;
        (self.is_closed || ends.into_iter().all(near))
            && is_beside(&moved, other)
            && is_beside(other, &moved)
    }
}

/// Whether each point is nearer to one of the others than neighbours among these are to each other.
fn is_beside(points: &[DVec3], others: &[DVec3]) -> bool {
    let gaps = others.windows(2).map(|ends| ends[0].distance(ends[1]));
    let widest = gaps.fold(0.0, f64::max);
    let near = |point: &DVec3| others.iter().any(|other| point.distance(*other) <= widest);
    points.iter().all(near)
}

/// A rotation about the origin, then a translation.
struct Motion {
    rotation: DMat3,
    translation: DVec3,
}

impl Motion {
    fn apply(&self, place: DVec3) -> DVec3 {
        self.rotation * place + self.translation
    }
}

/// A shell of the solid, with its triangles.
struct Body {
    triangles: Vec<u32>,
    sides: Vec<Side>,
    rims: Vec<Rim>,
    /// Places that turn with it, by what they are: corners, centres, ends of axes.
    marks: Vec<(Mark, DVec3)>,
    /// The middle of the marks.
    centre: DVec3,
    /// How far the farthest one is from there; and the box's corners, or that one.
    reach: f64,
    radius: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Mark {
    Corner,
    /// Of a closed conic, and of a surface.
    Centre,
    /// Of a closed conic: at right angles to its plane, and in it.
    Pole,
    End,
    /// Of a surface: the place of its axis that is nearest to the middle of the others, and on both
    /// sides of that.
    Foot,
    Axis,
}

/// A body to be given the triangles of another.
struct Copy {
    of: Vec<u32>,
    instead_of: Vec<u32>,
    motion: Motion,
    /// Of the first one's surfaces those of this one, by their places in the mesh's list.
    looks: FxHashMap<u32, u32>,
}

fn mean(marks: &[(Mark, DVec3)]) -> DVec3 {
    let sum: DVec3 = marks.iter().map(|&(_, place)| place).sum();
    sum / marks.len().max(1) as f64
}

impl Body {
    fn new(shell: Shell<'_>, triangles: Vec<u32>, bounds: Bounds) -> Self {
        let mut body = Self {
            triangles,
            sides: Vec::new(),
            rims: Vec::new(),
            marks: Vec::new(),
            centre: DVec3::ZERO,
            reach: 0.0,
            radius: 0.0,
        };
        let mut numbers: FxHashMap<(usize, bool, Look), usize> = FxHashMap::default();
        let mut number = |face: Face<'_>| {
            let side = Side::of(face);
            let key = (side.index, side.is_along_gradient, side.look.clone());
            *numbers.entry(key).or_insert_with(|| {
                body.sides.push(side);
                body.sides.len() - 1
            })
        };
        let mut corners = FxHashMap::default();
        for face in shell.faces() {
            number(face);
            for coedge in face.loops().flat_map(|around| around.coedges()) {
                if !coedge.is_forward() {
                    continue;
                }
                let edge = coedge.edge();
                for vertex in edge.vertices().into_iter().flatten() {
                    corners.insert(vertex.id(), vertex.point());
                }
                let is_closed = edge.vertices().is_none();
                if is_closed && let Some(axes) = edge.curve().half_axes() {
                    let CurveShape::Ellipse { center, .. } = edge.curve() else {
                        continue;
                    };
                    let pole = axes.long.cross(axes.short) / axes.short.length();
                    body.marks.push((Mark::Centre, center));
                    let ends = [pole, -pole].map(|arm| (Mark::Pole, center + arm));
                    body.marks.extend(ends);
                    if !axes.is_circle {
                        let ends = [axes.long, -axes.long].map(|arm| (Mark::End, center + arm));
                        body.marks.extend(ends);
                    }
                }
                let [from, to] = edge.range();
                let step = (to - from) / f64::from(INTERVALS);
                body.rims.push(Rim {
                    sides: edge.faces().map(&mut number),
                    points: (0..=INTERVALS)
                        .map(|k| edge.at(from + f64::from(k) * step))
                        .collect(),
                    is_closed,
                });
            }
        }
        let mut corners: Vec<_> = corners.into_iter().collect();
        corners.sort_by_key(|(id, _)| *id);
        let corners = corners.into_iter().map(|(_, place)| (Mark::Corner, place));
        body.marks.extend(corners);
        body.mark_surfaces();
        let farthest = |size: f64, place: DVec3| size.max(place.distance(body.centre));
        let marks = body.marks.iter().map(|&(_, place)| place);
        body.reach = marks.fold(0.0, farthest);
        body.radius = [bounds.min, bounds.max]
            .into_iter()
            .fold(body.reach, farthest);
        body
    }

    /// Centres of surfaces, and their axes.
    fn mark_surfaces(&mut self) {
        let mut axes = Vec::new();
        for side in &self.sides {
            match side.surface.shape() {
                SurfaceShape::Sphere { center, .. } => self.marks.push((Mark::Centre, center)),
                SurfaceShape::Ellipsoid { placement, .. }
                | SurfaceShape::EllipticCone { placement, .. }
                | SurfaceShape::HyperboloidOneSheet { placement, .. }
                | SurfaceShape::HyperboloidTwoSheets { placement, .. }
                | SurfaceShape::EllipticParaboloid { placement, .. } => {
                    self.marks.push((Mark::Centre, placement.origin));
                    axes.push((placement.origin, placement.axes[2]));
                }
                SurfaceShape::Cylinder { point, axis, .. }
                | SurfaceShape::Cone { point, axis, .. } => axes.push((point, axis)),
                SurfaceShape::EllipticCylinder { placement, .. } => {
                    axes.push((placement.origin, placement.axes[2]));
                }
                _ => {}
            }
        }
        let first = axes.first().map_or(DVec3::ZERO, |&(point, _)| point);
        self.centre = if self.marks.is_empty() {
            first
        } else {
            mean(&self.marks)
        };
        let farthest =
            |size: f64, &(_, place): &(Mark, DVec3)| size.max(place.distance(self.centre));
        let size = self.marks.iter().fold(0.0, farthest);
        for (point, axis) in axes {
            let foot = point + (self.centre - point).dot(axis) * axis;
            self.marks.push((Mark::Foot, foot));
            let ends = [size * axis, -size * axis].map(|arm| (Mark::Axis, foot + arm));
            self.marks.extend(ends);
        }
    }

    /// Places at which a quadric is known by its values.
    fn places(&self) -> Vec<DVec3> {
        let cube = (0..27).map(|k| DVec3::new((k % 3) as f64, (k / 3 % 3) as f64, (k / 9) as f64));
        // (None of them are at the middle, nor lie about it evenly.)
        cube.map(|p| self.centre + self.radius * (p - 0.9))
            .collect()
    }

    /// The motion that takes it to the other one, and the side that each of its sides becomes.
    fn motion_to(&self, other: &Self, rounding: f64) -> Option<(Motion, Vec<usize>)> {
        if (self.reach - other.reach).abs() > 2.0 * rounding {
            return None;
        }
        // Of what no mark turns, such as balls, sizes are compared at once.
        let is_point = self.reach <= 2.0 * rounding;
        if is_point && (self.radius - other.radius).abs() > 1e-6 * self.radius {
            return None;
        }
        let places = self.places();
        let fits = |rotation: &DMat3| {
            let motion = Motion {
                rotation: *rotation,
                translation: other.centre - *rotation * self.centre,
            };
            if !self.marks_fit(other, &motion, rounding) {
                return None;
            }
            let images = self.matched(other, &motion, &places, rounding)?;
            Some((motion, images))
        };
        // Balls are not turned without need.
        fits(&DMat3::IDENTITY).or_else(|| self.turns(other, rounding).iter().find_map(fits))
    }

    /// Rotations that take two of its marks to marks of the other one.
    fn turns(&self, other: &Self, rounding: f64) -> Vec<DMat3> {
        let arms = |body: &Self| -> Vec<(Mark, DVec3)> {
            let arm = |&(mark, place): &(Mark, DVec3)| (mark, place - body.centre);
            body.marks.iter().map(arm).collect()
        };
        let (own, others) = (arms(self), arms(other));
        let farthest = |length: &dyn Fn(DVec3) -> f64| {
            let farther =
                |a: &&(Mark, DVec3), b: &&(Mark, DVec3)| length(a.1).total_cmp(&length(b.1));
            own.iter().max_by(farther).copied()
        };
        let Some((mark, arm)) = farthest(&DVec3::length) else {
            return Vec::new();
        };
        if arm.length() <= 2.0 * rounding {
            return Vec::new();
        }
        let axis = arm.normalize();
        let Some((mark_beside, beside)) = farthest(&|other: DVec3| other.cross(axis).length())
        else {
            return Vec::new();
        };
        let alike = |mark: Mark, arm: DVec3| {
            let same = move |other: &&(Mark, DVec3)| {
                other.0 == mark && (other.1.length() - arm.length()).abs() <= 2.0 * rounding
            };
            others.iter().filter(same).map(|&(_, arm)| arm)
        };
        let frame = |axis: DVec3, arm: DVec3| {
            let side = axis.cross(arm).try_normalize()?;
            Some(DMat3::from_cols(axis, side, axis.cross(side)))
        };
        let is_line = beside.cross(axis).length() <= 1e-6 * self.radius;
        let mut found = Vec::new();
        for other_arm in alike(mark, arm) {
            let other_axis = other_arm.normalize();
            if is_line {
                found.push(DMat3::from_quat(DQuat::from_rotation_arc(axis, other_axis)));
            } else {
                let turns = alike(mark_beside, beside)
                    .filter(|other| {
                        (other.dot(other_arm) - beside.dot(arm)).abs()
                            <= 8.0 * rounding * self.radius
                    })
                    .filter_map(|other| {
                        Some(frame(other_axis, other)? * frame(axis, beside)?.transpose())
                    });
                found.extend(turns);
            }
            if found.len() > TRIED {
                break;
            }
        }
        found
    }

    /// Whether each mark comes to one of the other's.
    fn marks_fit(&self, other: &Self, motion: &Motion, rounding: f64) -> bool {
        self.marks.iter().all(|&(mark, place)| {
            let image = motion.apply(place);
            let near =
                |&(of, place): &(Mark, DVec3)| of == mark && place.distance(image) <= rounding;
            other.marks.iter().any(near)
        })
    }

    /// The other's side that each becomes, if all sides and rims have one of their own.
    fn matched(
        &self,
        other: &Self,
        motion: &Motion,
        places: &[DVec3],
        rounding: f64,
    ) -> Option<Vec<usize>> {
        let mut is_taken = vec![false; other.sides.len()];
        let mut images = Vec::new();
        for side in &self.sides {
            let image = (0..other.sides.len()).find(|&k| {
                !is_taken[k] && side.becomes(&other.sides[k], motion, places, rounding)
            })?;
            is_taken[image] = true;
            images.push(image);
        }
        let mut rims: FxHashMap<[usize; 2], Vec<(usize, Vec<DVec3>)>> = FxHashMap::default();
        for (k, rim) in other.rims.iter().enumerate() {
            let [left, right] = rim.sides;
            let back = rim.points.iter().rev().copied().collect();
            rims.entry([left, right])
                .or_default()
                .push((k, rim.points.clone()));
            rims.entry([right, left]).or_default().push((k, back));
        }
        let mut is_taken = vec![false; other.rims.len()];
        for rim in &self.rims {
            let alike = rims.get(&rim.sides.map(|side| images[side]))?;
            let (image, _) = alike.iter().find(|(k, points)| {
                !is_taken[*k]
                    && other.rims[*k].is_closed == rim.is_closed
                    && rim.becomes(points, motion, rounding)
            })?;
            is_taken[*image] = true;
        }
        Some(images)
    }

    /// Of its surfaces those of the other one, by their places in the mesh's list.
    fn looks_in(&self, other: &Self, images: &[usize], mesh: &Mesh) -> Option<FxHashMap<u32, u32>> {
        let key = |entry: u32| {
            let of = mesh.surfaces.get(entry as usize)?;
            Some((
                of.surface as usize,
                Look::new(&of.name, &of.parts, of.color),
            ))
        };
        let mut entries = FxHashMap::default();
        for &triangle in &other.triangles {
            let entry = mesh.triangle_surfaces[triangle as usize];
            entries.insert(key(entry)?, entry);
        }
        let mut looks = FxHashMap::default();
        for &triangle in &self.triangles {
            let entry = mesh.triangle_surfaces[triangle as usize];
            if looks.contains_key(&entry) {
                continue;
            }
            let (index, look) = key(entry)?;
            let mut own = self.sides.iter().zip(images);
            let (_, &image) = own.find(|(side, _)| side.index == index && side.look == look)?;
            let image = &other.sides[image];
            looks.insert(entry, *entries.get(&(image.index, image.look.clone()))?);
        }
        Some(looks)
    }
}

/// The shells of the boundary with the parts of the mesh that are theirs: on the same surfaces, in a box that
/// is nearest to the shell's by far.
fn bodies(mesh: &Mesh, brep: &Brep) -> Vec<Body> {
    let parts = connected(mesh);
    let surface = |triangle: u32| {
        let entry = mesh.triangle_surfaces[triangle as usize];
        (mesh.surfaces.get(entry as usize)).map_or(usize::MAX, |of| of.surface as usize)
    };
    let distinct = |mut all: Vec<usize>| {
        all.sort_unstable();
        all.dedup();
        all
    };
    let mut of_surfaces: FxHashMap<Vec<usize>, Vec<(usize, [DVec3; 2])>> = FxHashMap::default();
    for (index, part) in parts.iter().enumerate() {
        let corners = part
            .iter()
            .flat_map(|&triangle| mesh.corners(triangle as usize));
        let around = corners.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| {
            [low.min(p), high.max(p)]
        });
        let key = distinct(part.iter().map(|&triangle| surface(triangle)).collect());
        of_surfaces.entry(key).or_default().push((index, around));
    }
    let mut shells_of: Vec<Vec<(Shell<'_>, Bounds)>> = vec![Vec::new(); parts.len()];
    for shell in brep.shells() {
        let key = distinct(shell.faces().map(|face| face.surface_index()).collect());
        let bounds = shell.faces().filter_map(|face| face.bounds());
        let Some(bounds) = bounds.reduce(|a, b| Bounds {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
        }) else {
            continue;
        };
        let Some(alike) = of_surfaces.get(&key) else {
            continue;
        };
        let mut off: Vec<(f64, usize)> = alike
            .iter()
            .map(|&(part, [low, high])| {
                let off = (low - bounds.min).abs().max((high - bounds.max).abs());
                (off.max_element(), part)
            })
            .collect();
        off.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_near = off[0].0 <= 0.125 * bounds.size().max_element();
        if is_near && off.get(1).is_none_or(|next| next.0 > NEARER * off[0].0) {
            shells_of[off[0].1].push((shell, bounds));
        }
    }
    let mut bodies = Vec::new();
    for (triangles, shells) in parts.into_iter().zip(shells_of) {
        if let [(shell, bounds)] = shells[..] {
            bodies.push(Body::new(shell, triangles, bounds));
        }
    }
    bodies
}

/// The mesh with triangles of bodies in place of those of others, at the end.
fn with_copies(mesh: &Mesh, copies: &[Copy]) -> Mesh {
    let mut is_left_out = vec![false; mesh.triangles.len()];
    let mut is_vertex_left_out = vec![false; mesh.positions.len()];
    for &triangle in copies.iter().flat_map(|copy| &copy.instead_of) {
        is_left_out[triangle as usize] = true;
        for vertex in mesh.triangles[triangle as usize] {
            is_vertex_left_out[vertex as usize] = true;
        }
    }
    let mut shared = Mesh {
        surfaces: mesh.surfaces.clone(),
        unit: mesh.unit,
        ..Mesh::default()
    };
    let mut kept = vec![u32::MAX; mesh.positions.len()];
    for (vertex, &place) in mesh.positions.iter().enumerate() {
        if !is_vertex_left_out[vertex] {
            kept[vertex] = shared.positions.len() as u32;
            shared.positions.push(place);
        }
    }
    for triangle in (0..mesh.triangles.len()).filter(|&triangle| !is_left_out[triangle]) {
        let corners = mesh.triangles[triangle].map(|vertex| kept[vertex as usize]);
        shared.triangles.push(corners);
        shared
            .triangle_surfaces
            .push(mesh.triangle_surfaces[triangle]);
        shared
            .corner_normals
            .extend(mesh.corner_normals.get(triangle));
    }
    let mut edges_at: FxHashMap<u32, Vec<&[u32]>> = FxHashMap::default();
    for edge in &mesh.feature_edges {
        let Some(&first) = edge.first() else { continue };
        if !is_vertex_left_out[first as usize] {
            let edge = edge.iter().map(|&vertex| kept[vertex as usize]);
            shared.feature_edges.push(edge.collect());
        }
        edges_at.entry(first).or_default().push(edge);
    }
    for copy in copies {
        let mut moved: FxHashMap<u32, u32> = FxHashMap::default();
        let mut order = Vec::new();
        for &triangle in &copy.of {
            let corners = mesh.triangles[triangle as usize].map(|vertex| {
                *moved.entry(vertex).or_insert_with(|| {
                    let place = mesh.positions[vertex as usize];
                    shared.positions.push(copy.motion.apply(place));
                    order.push(vertex);
                    shared.positions.len() as u32 - 1
                })
            });
            shared.triangles.push(corners);
            let entry = mesh.triangle_surfaces[triangle as usize];
            shared.triangle_surfaces.push(copy.looks[&entry]);
            if let Some(normals) = mesh.corner_normals.get(triangle as usize) {
                let turned = normals.map(|n| (copy.motion.rotation * n.as_dvec3()).as_vec3());
                shared.corner_normals.push(turned);
            }
        }
        for edge in order
            .iter()
            .filter_map(|vertex| edges_at.get(vertex))
            .flatten()
        {
            let edge = edge.iter().map(|vertex| moved[vertex]);
            shared.feature_edges.push(edge.collect());
        }
    }
    shared
}
