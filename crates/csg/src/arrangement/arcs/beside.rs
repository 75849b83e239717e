//! How other surfaces lie to a curve, by boxes around it: most are on one side of all of it, and
//! along most curves there can be no edge.

use glam::DVec3;
use smallvec::SmallVec;

use crate::arrangement::arc::Arc;
use crate::arrangement::ids::Position;
use crate::program::{Bounds, Formula, Side, Surface, SurfaceId};

/// Of a curve along which edges may lie, so many parts are looked at, each with every sign of both
/// of its surfaces. Tunes speed only.
const PARTS: u32 = 8;

/// If no more surfaces, its own counted, may cross it, parts are not worth it. Tunes speed only.
const FEW: usize = 6;

/// Where parts begin, of one: as sides of blocks do, next to no place where a model has a corner.
const BEGIN: f64 = 0.043_769_410_125_095;

/// Values that hold in boxes, two bits each: whether the value is true all over it, and whether
/// it may be true anywhere. One for each part, four times: both surfaces of the curve are outside
/// in the first quarter, the first one is inside in the second, the second one in the third,
/// both in the fourth.
const ALL_OVER: u64 = 0x5555_5555_5555_5555;
const QUARTER: u32 = 2 * PARTS;
const QUARTERS: u64 = 0x0001_0001_0001_0001;

/// Those of the curve's own surfaces.
const OWN: [u64; 2] = [0xFFFF_0000_FFFF_0000, 0xFFFF_FFFF_0000_0000];

/// How surfaces lie to a curve.
#[derive(Default)]
pub(super) struct Beside {
    /// For each position of the cell its side of the box around the curve.
    pub sides: Vec<Side>,
    /// For each position whether points are inside of it, in boxes.
    inside: Vec<u64>,
    gates: Vec<u64>,
}

/// The values in boxes on one side.
fn inside(side: Side) -> u64 {
    match side {
        Side::Inside => !0,
        Side::Crossing => !ALL_OVER,
        Side::Outside => 0,
    }
}

impl Beside {
    /// In which parts edges may lie along the curve, two bits each: not where other surfaces are
    /// all told, or do not matter, and the solid is the same on both sides of one of the curve's
    /// own, if that is not what parts faces that look different.
    fn has_edges(&mut self, formula: &Formula, part_looks: [bool; 2]) -> u64 {
        let literals = formula.literals();
        let inside = &self.inside;
        let values = formula.evaluate_words(&mut self.gates, |literal, position| {
            let word = inside[position as usize];
            if literals[literal as usize].outside {
                // That none is inside all over is that some may be outside.
                (word >> 1 & ALL_OVER) | (word & ALL_OVER) << 1
            } else {
                word
            }
        });
        let quarters = [0, 1, 2, 3].map(|k| values >> (k * QUARTER));
        let [neither, first, second, both] = quarters;
        let either = |bits: u64| (bits | bits >> 1) & ALL_OVER;
        let by_first = either((neither ^ first) | (second ^ both));
        let by_second = either((neither ^ second) | (first ^ both));
        let untold = quarters.map(|bits| (bits ^ bits >> 1) & ALL_OVER);
        let untold = untold.into_iter().fold(0, |any, bits| any | bits);
        let [first, second] = part_looks.map(|parts| if parts { ALL_OVER } else { 0 });
        let told = (by_first & (by_second | first)) | (by_second & second);
        (untold | told) & ((1 << QUARTER) - 1)
    }

    /// Finds how the cell's surfaces lie to a curve within the block, and the part of it beyond
    /// which no edges may lie along it; none if there may be none at all. Its surfaces may have faces
    /// of different looks, or not.
    pub fn look(
        &mut self,
        arc: &Arc<'_>,
        range: [f64; 2],
        has_looks: impl Fn(Position) -> bool,
    ) -> Option<[f64; 2]> {
        let whole = box_around(arc, range)?;
        self.sides.clear();
        self.inside.clear();
        for id in arc.block.cell.ids() {
            let own = arc.id.surfaces().position(|own| own == id);
            let side = own.map_or_else(|| side_of(arc, id, whole), |_| Side::Crossing);
            self.sides.push(side);
            self.inside
                .push(own.map_or_else(|| inside(side), |own| OWN[own]));
        }
        if arc.edge.is_some() {
            return Some(range);
        }
        let place = |id: SurfaceId| arc.block.position_of(id);
        let part_looks = match arc.id.second() {
            // Seams part a face that is on both sides of them.
            None => [true, false],
            Some(second) => [arc.id.first, second].map(|id| place(id).is_some_and(&has_looks)),
        };
        if self.has_edges(&arc.block.cell.formula, part_looks) == 0 {
            return None;
        }
        // (Other curves may run beside a surface for long, and are looked at as a whole.)
        let crossing = self.sides.iter().filter(|&&side| side == Side::Crossing);
        if crossing.count() > FEW && arc.curve.is_polynomial() {
            self.shorten(arc, range, part_looks)
        } else {
            Some(range)
        }
    }

    /// The part beyond which no edges may lie along a curve, found in ever shorter parts.
    fn shorten(
        &mut self,
        arc: &Arc<'_>,
        whole: [f64; 2],
        part_looks: [bool; 2],
    ) -> Option<[f64; 2]> {
        let cell = &arc.block.cell;
        let others = arc
            .block
            .surfaces()
            .map(|(position, id)| (position.index(), id));
        let crossing = others.filter(|&(index, id)| {
            self.sides[index] == Side::Crossing && arc.id.surfaces().all(|own| own != id)
        });
        let positions: SmallVec<[(usize, SurfaceId); 16]> = crossing.collect();
        let is_clear = |t: f64| {
            let mut others = positions.iter().map(|&(_, id)| arc.scene.surface(id));
            others.all(|surface| is_clear_of(arc, surface, t, whole))
        };
        let mut range = whole;
        loop {
            let at = |part: u32| match part {
                0 => range[0],
                PARTS => range[1],
                _ => {
                    let share = (f64::from(part) + BEGIN) / f64::from(PARTS);
                    range[0] + share * (range[1] - range[0])
                }
            };
            let mut within = 0;
            for part in 0..PARTS {
                let Some(around) = box_around(arc, [at(part), at(part + 1)]) else {
                    continue;
                };
                let bits = (3 * QUARTERS) << (2 * part);
                within |= bits;
                for &(index, id) in &positions {
                    if self.sides[index] == Side::Crossing {
                        let word = &mut self.inside[index];
                        *word = *word & !bits | inside(side_of(arc, id, around)) & bits;
                    }
                }
            }
            let parts = self.has_edges(&cell.formula, part_looks) & within;
            if parts == 0 {
                return None;
            }
            let mut first = parts.trailing_zeros() / 2;
            let mut last = (u64::BITS - 1 - parts.leading_zeros()) / 2;
            while first > 0 && !is_clear(at(first)) {
                first -= 1;
            }
            while last + 1 < PARTS && !is_clear(at(last + 1)) {
                last += 1;
            }
            let bits = (1 << (2 * (last + 1))) - (1 << (2 * first));
            for &(index, _) in &positions {
                let (side, word) = (&mut self.sides[index], &mut self.inside[index]);
                let mut told = [Side::Inside, Side::Outside].into_iter();
                let told = told.find(|&told| (*word ^ inside(told)) & bits == 0);
                *side = told.unwrap_or(Side::Crossing);
                *word = inside(*side);
            }
            range = [at(first), at(last + 1)];
            if last - first >= PARTS / 2 {
                return Some(range);
            }
        }
    }
}

/// Centre and half extents of the box around a curve between two places, as far as it is in the
/// block.
fn box_around(arc: &Arc<'_>, range: [f64; 2]) -> Option<[DVec3; 2]> {
    let near = arc.scene.near;
    let block = Bounds {
        min: arc.block.low,
        max: arc.block.high,
    };
    let bounds = arc.curve.bounds(range).grown(near);
    let bounds = bounds.intersected(block.grown(near));
    let is_empty = bounds.min.cmpgt(bounds.max).any();
    (!is_empty).then(|| [bounds.center(), 0.5 * bounds.size()])
}

fn side_of(arc: &Arc<'_>, id: SurfaceId, [center, half]: [DVec3; 2]) -> Side {
    arc.scene.surface(id).side_of_box(center, half)
}

/// Whether a surface is not so near to a place of a curve that it may cross or touch it there, or is
/// through all of it.
fn is_clear_of(arc: &Arc<'_>, surface: &Surface, place: f64, [start, end]: [f64; 2]) -> bool {
    let is_near = |t: f64| {
        let at = arc.curve.at(t);
        surface.value(at).abs() <= arc.scene.near * surface.gradient(at).length()
    };
    !is_near(place) || [start, 0.5 * (start + end), end].into_iter().all(is_near)
}
