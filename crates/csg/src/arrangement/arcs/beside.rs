//! How other surfaces lie to a curve, by boxes around it: most are on one side of all of it, and
//! around most curves the solid is constant.

use crate::arrangement::arc::Arc;
use crate::arrangement::curve::Curve;
use crate::program::{Bounds, Formula, Side};

/// Of a curve around all of which it may change whether a point is in the solid, so many parts are
/// looked at. Tunes speed only.
const PARTS: u32 = 8;

/// Values that hold in boxes, two bits for each of up to 32: whether the value is true all over
/// it, and whether it may be true anywhere.
const ALL_OVER: u64 = 0x5555_5555_5555_5555;

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
    /// Which boxes the formula may vary in.
    fn varies(&mut self, formula: &Formula) -> u64 {
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
        (values ^ values >> 1) & ALL_OVER
    }

    /// Finds how the cell's surfaces lie to a curve within the block, and the part of it beyond
    /// which the solid is constant around it; none if it is so around all of it.
    pub fn look(&mut self, arc: &Arc<'_>, [start, end]: [f64; 2]) -> Option<[f64; 2]> {
        let Arc { scene, block, .. } = *arc;
        let within = Bounds {
            min: block.low - scene.near,
            max: block.high + scene.near,
        };
        // None of it is in the block if there is no box.
        let around = |range: [f64; 2]| {
            let bounds = arc.curve.bounds(range).grown(scene.near);
            let bounds = bounds.intersected(within);
            let is_empty = bounds.min.cmpgt(bounds.max).any();
            (!is_empty).then(|| (bounds.center(), 0.5 * bounds.size()))
        };
        let own = |id| arc.id.surfaces().any(|own| own == id);
        let side_of = |id, (center, half)| scene.surface(id).side_of_box(center, half);
        let whole = around([start, end])?;
        let ids = block.cell.ids();
        self.sides.clear();
        self.sides.extend(ids.map(|id| {
            if own(id) {
                Side::Crossing
            } else {
                side_of(id, whole)
            }
        }));
        if arc.edge.is_some() {
            return Some([start, end]);
        }
        let sides = self.sides.iter();
        self.inside.clear();
        self.inside.extend(sides.map(|&side| inside(side)));
        let formula = &block.cell.formula;
        if self.varies(formula) == 0 {
            return None;
        }
        if matches!(arc.curve, Curve::Rulings(_)) {
            return Some([start, end]);
        }
        let at = |part: u32| match part {
            0 => start,
            PARTS => end,
            _ => start + (f64::from(part) + 0.0437) / f64::from(PARTS) * (end - start),
        };
        let mut within = 0;
        for part in 0..PARTS {
            let Some(around) = around([at(part), at(part + 1)]) else {
                continue;
            };
            let bits = 3 << (2 * part);
            within |= bits;
            for (position, id) in block.surfaces() {
                let index = position.index();
                if self.sides[index] == Side::Crossing && !own(id) {
                    let word = &mut self.inside[index];
                    *word = *word & !bits | inside(side_of(id, around)) & bits;
                }
            }
        }
        let parts = self.varies(formula) & within;
        if parts == 0 {
            return None;
        }
        if arc.curve.is_line() {
            return Some([start, end]);
        }
        let first = parts.trailing_zeros() / 2;
        let last = (u64::BITS - 1 - parts.leading_zeros()) / 2;
        let bits = (!0 << (2 * first)) & (!0 >> (u64::BITS - 2 - 2 * last));
        for (side, word) in self.sides.iter_mut().zip(&self.inside) {
            for whole in [Side::Inside, Side::Outside] {
                if (word ^ inside(whole)) & bits == 0 {
                    *side = whole;
                }
            }
        }
        Some([at(first), at(last + 1)])
    }
}
