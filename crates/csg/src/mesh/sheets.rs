//! Parts of a mesh that cannot run through themselves, so that only pairs of triangles
//! of different ones need to be tested.
//!
//! Seen along an axis, all triangles of a *sheet* are counter-clockwise. So a point lies
//! in as many of them as the sheet's border winds around it, since each triangle's border
//! winds once around the points in it, and what runs along an edge both ways cancels out.
//! If the border falls apart into closed polygons that are simple, seen along the axis,
//! and only one of them is counter-clockwise, then it winds at most once around a point,
//! so no two triangles cover the same one. What they have in common then lies above a part
//! of an edge of both: they touch at most, edge on edge or in a point. (After Volino and
//! Magnenat-Thalmann, *Efficient self-collision detection on smoothly discretized surface
//! animations using geometrical shape regularity*, 1994; here decided exactly.)

use std::ops::Range;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::box_tree::{Bounds, Boxed, along_curve};
use super::contour::{self, Side};
use super::predicates::{flat, flattened, turn};
use super::star::usable;
use super::twins::{NONE, twins};
use crate::mesh::Mesh;

/// The triangles with area of a part of a mesh, sheet by sheet, and along a curve in each.
#[derive(Default)]
struct Part {
    triangles: Vec<u32>,
    /// Of each in turn: see [`Boxed::stands`].
    stands: Vec<u8>,
    sheets: Vec<Sheet>,
}

struct Sheet {
    bounds: Bounds,
    /// Its triangles in the part.
    range: Range<usize>,
}

/// The triangles with area, each with its sheet, in an order in which those that follow
/// each other are near each other.
///
/// For n triangles and m corners of borders n log n + m log m, unless borders are intricate.
pub(super) fn in_sheets(mesh: &Mesh) -> Vec<Boxed> {
    /// Triangles of a part: so many, whatever the number of threads, that borders between
    /// parts are short.
    const SIZE: usize = 1 << 16;
    let count = mesh.triangles.len().min(NONE as usize);
    let parts: Vec<Part> = (0..count.div_ceil(SIZE))
        .into_par_iter()
        .map(|part| {
            let start = part * SIZE;
            Grower::new(mesh, start..count.min(start + SIZE)).grow_all()
        })
        .collect();
    let sheets: Vec<(&Sheet, _)> = parts
        .iter()
        .flat_map(|part| {
            part.sheets.iter().map(move |sheet| {
                let range = sheet.range.clone();
                let stands = part.stands[range.clone()].iter().copied();
                (sheet, part.triangles[range].iter().copied().zip(stands))
            })
        })
        .collect();
    let order = along_curve(sheets.iter().map(|(sheet, _)| sheet.bounds));
    let mut triangles = Vec::with_capacity(count);
    for (number, &sheet) in (0..).zip(&order) {
        let (_, of_sheet) = &sheets[sheet as usize];
        let of_sheet = of_sheet.clone();
        triangles.extend(of_sheet.map(|(index, stands)| (index, stands, number)));
    }
    let boxed = triangles
        .into_par_iter()
        .map(|(index, stands, sheet)| Boxed {
            bounds: Bounds::around(&mesh.corners(index as usize)),
            index,
            sheet,
            stands,
        });
    boxed.collect()
}

/// An axis, and from which end of it a triangle is counter-clockwise.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Facing {
    axis: u8,
    turn: i8,
}

/// Whether a triangle of a mesh has an area.
pub(super) fn has_area(mesh: &Mesh, corners: &[u32; 3]) -> bool {
    Facing::in_mesh(mesh, corners).is_some()
}

impl Facing {
    /// Of a triangle of a mesh, if it has an area and is finite.
    fn in_mesh(mesh: &Mesh, corners: &[u32; 3]) -> Option<Self> {
        if !usable(corners, mesh.positions.len()) {
            return None;
        }
        let corners = corners.map(|vertex| mesh.positions[vertex as usize]);
        let is_finite = corners.iter().all(|corner| corner.is_finite());
        Self::of(corners).filter(|_| is_finite)
    }

    /// Along the axis that a triangle with area faces most.
    fn of(corners: [DVec3; 3]) -> Option<Self> {
        let normal = normal(corners).abs();
        let main = if normal.x > normal.y && normal.x > normal.z {
            0
        } else if normal.y > normal.z {
            1
        } else {
            2
        };
        [main, (main + 1) % 3, (main + 2) % 3]
            .into_iter()
            .map(|axis| Self {
                axis: axis as u8,
                turn: turn(flattened(corners, axis)),
            })
            .find(|facing| facing.turn != 0)
    }

    /// Whether a triangle faces that way, too, and not only just.
    fn fits(self, corners: [DVec3; 3]) -> bool {
        /// Of the normal's largest component.
        const LEAST: f64 = 0.5;
        let normal = normal(corners);
        let along = normal.to_array()[self.axis as usize] * f64::from(self.turn);
        along > LEAST * normal.abs().max_element()
            && turn(flattened(corners, self.axis as usize)) == self.turn
    }
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The sheets of some triangles, one after the other.
struct Grower<'a> {
    mesh: &'a Mesh,
    /// The index of the first one.
    start: usize,
    triangles: &'a [[u32; 3]],
    /// The main facings, if they have an area.
    facings: Vec<Option<Facing>>,
    /// The sheets, or [`NONE`].
    sheets: Vec<u32>,
    /// Of half-edges by their places among these triangles.
    twins: Vec<u32>,
    part: Part,
    /// The triangles of one sheet.
    grown: Vec<u32>,
    /// The half-edges of borders seen.
    is_traced: Vec<bool>,
    /// Buffers.
    boxes: Vec<Bounds>,
    border: Vec<u32>,
    corners: Vec<DVec2>,
    sides: Vec<Side>,
}

impl<'a> Grower<'a> {
    fn new(mesh: &'a Mesh, range: Range<usize>) -> Self {
        let triangles = &mesh.triangles[range.clone()];
        let facings = triangles
            .iter()
            .map(|corners| Facing::in_mesh(mesh, corners));
        let facings: Vec<Option<Facing>> = facings.collect();
        let twins = twins(triangles, |triangle| facings[triangle].is_some());
        Self {
            mesh,
            start: range.start,
            triangles,
            sheets: vec![NONE; triangles.len()],
            is_traced: vec![false; twins.len()],
            facings,
            twins,
            part: Part::default(),
            boxes: Vec::new(),
            grown: Vec::new(),
            border: Vec::new(),
            corners: Vec::new(),
            sides: Vec::new(),
        }
    }

    fn grow_all(mut self) -> Part {
        for seed in 0..self.triangles.len() {
            if let Some(facing) = self.facings[seed]
                && self.sheets[seed] == NONE
            {
                self.grow(seed as u32, facing);
            }
        }
        self.part
    }

    fn corners_of(&self, triangle: u32) -> [DVec3; 3] {
        let [a, b, c] = self.triangles[triangle as usize];
        [a, b, c].map(|vertex| self.mesh.positions[vertex as usize])
    }

    /// The sheet of a triangle, or one for each of its triangles if it may run through
    /// itself.
    fn grow(&mut self, seed: u32, facing: Facing) {
        let sheet = self.part.sheets.len() as u32;
        self.sheets[seed as usize] = sheet;
        self.grown.clear();
        self.grown.push(seed);
        let mut done = 0;
        while let Some(&triangle) = self.grown.get(done) {
            done += 1;
            for half in 3 * triangle as usize..3 * triangle as usize + 3 {
                let twin = self.twins[half];
                if twin == NONE {
                    continue;
                }
                let other = twin / 3;
                if self.sheets[other as usize] == NONE && self.fits(other, facing) {
                    self.sheets[other as usize] = sheet;
                    self.grown.push(other);
                }
            }
        }
        let grown = std::mem::take(&mut self.grown);
        if self.is_simple(&grown, sheet, facing) {
            self.add_sheet(&grown);
        } else {
            grown
                .chunks(1)
                .for_each(|triangle| self.add_sheet(triangle));
        }
        self.grown = grown;
    }

    fn add_sheet(&mut self, triangles: &[u32]) {
        let start = self.part.triangles.len();
        self.boxes.clear();
        for &triangle in triangles {
            let bounds = Bounds::around(&self.corners_of(triangle));
            self.boxes.push(bounds);
        }
        let order = along_curve(self.boxes.iter().copied());
        for &place in &order {
            let triangle = triangles[place as usize];
            self.part.triangles.push(self.start as u32 + triangle);
            self.part.stands.push(self.stands(triangle));
        }
        self.part.sheets.push(Sheet {
            bounds: Bounds::around_all(self.boxes.iter().copied()),
            range: start..start + triangles.len(),
        });
    }

    /// Across which axes a triangle stands on planes: it is in none, and beyond each of its sides
    /// that are in one is a triangle that is. If such a side ran through what lies in the plane, that
    /// one would, too.
    fn stands(&self, triangle: u32) -> u8 {
        let corners = self.corners_of(triangle);
        let in_plane =
            |[a, b, c]: [DVec3; 3], axis: usize| a[axis] == b[axis] && b[axis] == c[axis];
        let stands = |axis: usize| {
            let sides = [(0, 1), (1, 2), (2, 0)].into_iter().enumerate();
            let mut in_one = sides.filter(|&(_, (k, l))| corners[k][axis] == corners[l][axis]);
            !in_plane(corners, axis)
                && in_one.all(|(side, _)| {
                    let twin = self.twins[3 * triangle as usize + side];
                    twin != NONE && in_plane(self.corners_of(twin / 3), axis)
                })
        };
        (0..3).fold(0, |all, axis| all | u8::from(stands(axis)) << axis)
    }

    fn fits(&self, triangle: u32, facing: Facing) -> bool {
        self.facings[triangle as usize] == Some(facing) || facing.fits(self.corners_of(triangle))
    }

    /// Whether the border of the sheet just grown consists of simple polygons, only one of
    /// which is counter-clockwise.
    fn is_simple(&mut self, grown: &[u32], sheet: u32, facing: Facing) -> bool {
        let mut outer = 0;
        for &triangle in grown {
            for half in 3 * triangle..3 * triangle + 3 {
                if self.is_traced[half as usize] || !self.is_border(half, sheet) {
                    continue;
                }
                self.trace(half, sheet);
                match self.count_outer(facing) {
                    Some(count) => outer += count,
                    None => return false,
                }
                if outer > 1 {
                    return false;
                }
            }
        }
        true
    }

    fn is_border(&self, half: u32, sheet: u32) -> bool {
        let twin = self.twins[half as usize];
        twin == NONE || self.sheets[twin as usize / 3] != sheet
    }

    /// The vertices along the border of a sheet.
    fn trace(&mut self, start: u32, sheet: u32) {
        let next = |half: u32| if half % 3 == 2 { half - 2 } else { half + 1 };
        self.border.clear();
        let mut half = start;
        while !self.is_traced[half as usize] {
            self.is_traced[half as usize] = true;
            self.border
                .push(self.triangles[half as usize / 3][half as usize % 3]);
            half = next(half);
            while !self.is_border(half, sheet) {
                half = next(self.twins[half as usize]);
            }
        }
    }

    /// How many polygons that face as the sheet does the border traced falls apart into;
    /// none if it meets itself but at vertices that it passes more than once.
    fn count_outer(&mut self, facing: Facing) -> Option<usize> {
        let border = std::mem::take(&mut self.border);
        let mut outer = 0;
        let mut add = |polygon: &[u32]| {
            outer += usize::from(self.turn(polygon, facing.axis)? == facing.turn);
            Some(())
        };
        let is_simple = add(&border).or_else(|| split(&border, add)).is_some();
        self.border = border;
        is_simple.then_some(outer)
    }

    /// Which way a polygon runs, seen along an axis, if it is simple.
    fn turn(&mut self, polygon: &[u32], axis: u8) -> Option<i8> {
        let positions = polygon.iter().map(|&v| self.mesh.positions[v as usize]);
        self.corners.clear();
        self.corners
            .extend(positions.map(|p| flat(p, axis as usize)));
        contour::orientation(&self.corners, &mut self.sides)
    }
}

/// Cuts a closed line at the vertices that it passes more than once.
fn split(line: &[u32], mut add: impl FnMut(&[u32]) -> Option<()>) -> Option<()> {
    let mut places: FxHashMap<u32, usize> = FxHashMap::default();
    let mut open: Vec<u32> = Vec::new();
    for &vertex in line {
        if let Some(&place) = places.get(&vertex) {
            add(&open[place..])?;
            for vertex in open.drain(place..) {
                places.remove(&vertex);
            }
        }
        places.insert(vertex, open.len());
        open.push(vertex);
    }
    add(&open)
}
