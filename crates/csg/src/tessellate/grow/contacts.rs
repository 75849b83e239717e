//! Cuts up the edges along which the solid touches itself.
//!
//! Next to a curve along which two surfaces touch, these part with the square of
//! the distance x from it, and a chord of length h strays by the square of h. So
//! there the chords must be no longer than the triangles next to them are high.

use super::Grower;
use crate::tessellate::half_edges::Kind;
use crate::tessellate::side::{Side, halved};

impl Grower<'_, '_> {
    /// Cuts the edges along curves on which the solid touches itself until they are
    /// clearly nearer to these than the tolerance.
    pub(in super::super) fn cut_contacts(&mut self) {
        /// Halves an edge as often.
        const MOST_ROUNDS: u32 = 24;
        /// Of the tolerance: chords are shorter than the sides of triangles next to
        /// them.
        const NEAR: f64 = 0.5;
        for _ in 0..MOST_ROUNDS {
            let mut sides = Vec::new();
            for edges in &self.mesh.contacts.edges {
                let half = edges.first().and_then(|&ends| self.mesh.between(ends));
                let halved = half.and_then(|half| halved(self.mesh, half, self.precision));
                let (Some((off, side)), Some(curve)) = (halved, self.mesh.contact_curve(edges))
                else {
                    continue;
                };
                let [a, b] = curve.map(|surface| self.goal.tolerance_on(surface));
                if off > NEAR * a.min(b) {
                    let kind = Kind::Corner;
                    sides.extend(edges.iter().map(|&ends| Side { ends, kind, ..side }));
                }
            }
            if sides.is_empty() {
                break;
            }
            for side in &sides {
                self.cut_side(side);
            }
            self.flip();
            self.free_stuck();
            self.mesh.fix_contacts();
        }
    }
}
