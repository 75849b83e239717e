//! Which faces meet along a curve: the formula on the sectors around it.

use glam::DVec3;
use smallvec::SmallVec;

use super::block::Block;
use super::ids::Position;
use super::piece::{CurveId, Piece, Side};
use super::scene::Scene;

/// Half a plane that ends in a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct HalfPlane {
    pub position: Position,
    /// Whether it is the half beyond which, turning counter-clockwise about the line,
    /// the plane's inside lies.
    pub is_inner: bool,
}

impl HalfPlane {
    /// The outer and the inner half of a plane.
    pub fn both(position: Position) -> [Self; 2] {
        [false, true].map(|is_inner| Self { position, is_inner })
    }

    /// The halves of two planes, counter-clockwise about the cross product of their normals.
    pub fn of_pair(pair: [Position; 2]) -> [Self; 4] {
        let [[a, b], [c, d]] = pair.map(Self::both);
        [a, c, b, d]
    }
}

/// The two faces at every solid wedge around a curve: mostly one wedge.
pub(super) type Wedges = SmallVec<[[Side; 2]; 2]>;

/// A place on a curve, and the point there.
pub(super) type Place = (f64, DVec3);

/// Adds a piece for each wedge.
pub(super) fn emit(
    wedges: &Wedges,
    curve: CurveId,
    [from, to]: [Place; 2],
    goes_on: [bool; 2],
    pieces: &mut Vec<Piece>,
) {
    pieces.extend(wedges.iter().map(|&sides| Piece {
        from: from.1,
        to: to.1,
        sides,
        curve,
        places: [from.0, to.0],
        goes_on,
    }));
}

/// What lies around one curve, and along it. Holds scratch memory.
#[derive(Default)]
pub(super) struct Sectors {
    /// For each position in the cell: whether all its literals look alike, and
    /// the look of the first.
    looks: Vec<Option<(bool, u32)>>,
    /// The half-planes around the curve, counter-clockwise about its direction.
    pub around: SmallVec<[HalfPlane; 8]>,
    /// Where other surfaces cross the curve, in order; none where the formula does not
    /// change.
    pub crossings: Vec<(f64, Option<Position>)>,
    /// Per position the signs (1: inside) before the first crossing.
    pub inside: Vec<bool>,
    /// Per position the signs on all stretches and in all sectors, a bit each.
    words: Vec<u64>,
    gates: Vec<u64>,
    /// How many stretches are evaluated at once: more than one where the
    /// half-planes are in the same order on all.
    at_once: usize,
    /// The first of those that were, and their values.
    evaluated: Option<(usize, u64)>,
}

impl Sectors {
    /// Forgets another block.
    pub fn enter(&mut self, scene: &Scene<'_>, block: &Block) {
        self.looks.clear();
        self.looks.resize(block.cell.surfaces.len(), None);
        for literal in block.cell.formula.literals() {
            let look = scene.looks[literal.origin as usize];
            let known = &mut self.looks[Position(literal.surface).index()];
            let (alike, first) = known.get_or_insert((true, look));
            *alike &= *first == look;
        }
    }

    /// Whether the faces on a surface may differ in looks.
    pub fn has_looks(&self, position: Position) -> bool {
        self.looks[position.index()].is_some_and(|(alike, _)| !alike)
    }

    /// Sets the order of the half-planes around a whole curve; empty if it may
    /// differ from stretch to stretch.
    pub fn order_is(&mut self, around: &[HalfPlane]) {
        self.around.clear();
        self.around.extend_from_slice(around);
        self.at_once = 64_usize.checked_div(around.len()).unwrap_or(1);
        self.evaluated = None;
    }

    /// Whether the half-planes are in the same order all along the curve.
    pub fn is_in_order(&self) -> bool {
        self.at_once > 1
    }

    /// The solid's values on a stretch and others, as [`Self::evaluate`] finds
    /// them, and which of these the stretch is.
    pub fn values(&mut self, block: &Block, stretch: usize) -> (u64, usize) {
        let place = stretch % self.at_once;
        let first = stretch - place;
        let known = self.evaluated.filter(|known| known.0 == first);
        let (_, values) = known.unwrap_or_else(|| {
            let count = self.at_once.min(self.crossings.len() + 1 - first);
            (first, self.evaluate(block, first, count))
        });
        self.evaluated = Some((first, values));
        (values, place)
    }

    /// The solid's values on `count` stretches from `first` on, the sectors of
    /// each in succession, a bit each. Sector k comes before half-plane k.
    pub fn evaluate(&mut self, block: &Block, first: usize, count: usize) -> u64 {
        let sectors = self.around.len();
        let low_bits = |n: usize| if n >= 64 { u64::MAX } else { (1 << n) - 1 };
        self.words.clear();
        self.words
            .extend(self.inside.iter().map(|&i| if i { u64::MAX } else { 0 }));
        for (rank, &(_, position)) in self.crossings.iter().enumerate() {
            let Some(position) = position else {
                continue;
            };
            // Crossed before stretch rank + 1.
            let kept = (rank + 1).saturating_sub(first).min(count) * sectors;
            self.words[position.index()] ^= !low_bits(kept);
        }
        let one_of_each = (0..count).fold(0, |word, k| word | 1u64 << (k * sectors));
        for (k, &half_plane) in self.around.iter().enumerate() {
            // Inside from beyond the inner half up to the outer half.
            if half_plane.is_inner {
                continue;
            }
            let [_, inner] = HalfPlane::both(half_plane.position);
            let inner = self.around.iter().position(|&h| h == inner);
            let inner = inner.unwrap_or(0);
            let is_inside = |sector: usize| {
                if inner < k {
                    inner < sector && sector <= k
                } else {
                    sector <= k || sector > inner
                }
            };
            let word = (0..sectors)
                .filter(|&sector| is_inside(sector))
                .fold(0, |word, sector| word | one_of_each << sector);
            self.words[half_plane.position.index()] = word;
        }
        let words = &self.words;
        block
            .cell
            .formula
            .evaluate_words(&mut self.gates, |_, position| words[position as usize])
    }

    /// The faces of the solid wedges on one of the stretches just evaluated, of
    /// the values that were found, given the patch on which each half-plane lies
    /// there.
    pub fn wedges(
        &mut self,
        block: &Block,
        scene: &Scene<'_>,
        values: u64,
        stretch: usize,
        patch: impl Fn(HalfPlane) -> u8,
    ) -> Wedges {
        let sectors = self.around.len();
        let first_bit = stretch * sectors;
        let mut wedges = Wedges::new();
        let is_solid = |sector: usize| values >> (first_bit + sector % sectors) & 1 == 1;
        for start in 0..sectors {
            // Half-plane k lies between sectors k and k + 1.
            if is_solid(start) || !is_solid(start + 1) {
                continue;
            }
            let length = (1..sectors).find(|&n| !is_solid(start + 1 + n));
            let end = (start + length.unwrap_or(0)) % sectors;
            let [first, last] = [end, start].map(|k| {
                let half_plane = self.around[k];
                Side {
                    plane: block.id(half_plane.position),
                    look: self.look(scene, block, k, first_bit),
                    along_normal: half_plane.is_inner != (k == end),
                    patch: patch(half_plane),
                }
            });
            wedges.push([first, last]);
        }
        // A face that goes on straight has no edge there, unless others touch.
        if wedges.len() == 1 && wedges[0][0] == wedges[0][1] {
            wedges.clear();
        }
        wedges
    }

    /// The look of half-plane `k` on the stretch whose sectors begin with a bit:
    /// with the literals on its plane
    /// toggled one after another, the last first, that of the one at which the
    /// solid changes. Literals that do not matter there have no say, so that
    /// blocks agree whatever they were pruned of.
    fn look(&mut self, scene: &Scene<'_>, block: &Block, k: usize, first_bit: usize) -> u32 {
        let HalfPlane { position, is_inner } = self.around[k];
        let (alike, first) = self.looks[position.index()].unwrap_or_default();
        if alike {
            return first;
        }
        // The signs in the sector on the plane's inner side.
        let sectors = self.around.len();
        let inner = if is_inner {
            first_bit + (k + 1) % sectors
        } else {
            first_bit + k
        };
        let literals = block.cell.formula.literals();
        let own = || {
            (0u32..)
                .zip(literals)
                .filter(|(_, l)| Position(l.surface) == position)
        };
        let words = &self.words;
        // Assignment j toggles the j-th literal and all after it.
        let result = block.cell.formula.evaluate_words(&mut self.gates, |i, s| {
            let inside = 0u64.wrapping_sub(words[s as usize] >> inner & 1);
            if Position(s) != position {
                return inside;
            }
            match own().position(|(o, _)| o == i) {
                Some(j) if j < 63 => inside ^ ((2 << j) - 1),
                _ => inside,
            }
        });
        let none = result >> 63 & 1;
        let changes = |&(j, _): &(usize, _)| result >> j & 1 != none;
        let decisive = own().take(63).enumerate().filter(changes).last();
        decisive.map_or(first, |(_, (_, literal))| {
            scene.looks[literal.origin as usize]
        })
    }
}
