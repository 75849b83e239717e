//! A closed polyhedron of many faces as a formula that is pruned to few of them at once:
//! space is halved until few faces are in each box, and in the box these are combined by
//! a tree of their planes (W. C. Thibault, B. F. Naylor, "Set operations on polyhedra
//! using binary space partitioning trees", 1987). A tree over all of space would be as
//! deep as a convex polyhedron has faces.
//!
//! The planes that halve space are literals, too: "below it and in what is below it, or
//! above it and in what is above it" has one value on both sides of it.

use std::sync::OnceLock;

use glam::DVec3;
use smallvec::SmallVec;

use crate::mesh::shells::Shells;
use crate::numeric::tolerance::COORDINATE;
use crate::solid::Plane;
use crate::solid::partition::{Facet, Part, Tree};

/// So few faces in a box are not worth another cut. Tunes speed only.
const FEW_FACES: usize = 8;

/// A box is cut no further after so many cuts that took next to no face away: all pass
/// near one point.
const MOST_VAIN_CUTS: u32 = 6;

/// No box is smaller than this share of the polyhedron, by halvings.
const MOST_CUTS: u32 = 100;

/// The box around all exceeds the polyhedron by these shares of its longest side:
/// irrational, so that no cut meets faces and vertices, which lie at round coordinates.
const BELOW: DVec3 = DVec3::new(
    0.010_327_955_589_886,
    0.011_237_243_569_579,
    0.012_249_489_742_783,
);
const ABOVE: DVec3 = DVec3::new(
    0.013_166_247_903_554,
    0.010_961_481_396_815,
    0.011_789_083_458_003,
);

/// Of boxes with more faces both halves are worked on at once. Tunes speed only.
const AT_ONCE: usize = 4000;

/// A box, halved.
pub(super) enum Halved {
    /// No face is in it.
    Constant(bool),
    /// The tree of the faces in it.
    Faces(Tree),
    /// By a plane across an axis, at a coordinate: what is below it, and what is above.
    Cut(usize, f64, Box<[Self; 2]>),
}

/// The box around a polyhedron, halved.
pub(super) struct Partition {
    pub low: DVec3,
    pub high: DVec3,
    /// Points nearer to a plane were taken to be on it.
    pub slack: f64,
    pub root: Halved,
}

impl Partition {
    /// Of the faces of a closed polyhedron, as triangles of any number. It is empty in
    /// boxes in which parts of them are not needed.
    pub fn new(
        facets: Vec<Facet>,
        is_needed: &(dyn Fn(&[Part], [DVec3; 2]) -> bool + Sync),
    ) -> Self {
        let bounds: Vec<[DVec3; 2]> = facets.iter().map(|f| bounds(&f.corners)).collect();
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [min, max] = bounds.iter().fold(none, |[min, max], [low, high]| {
            [min.min(*low), max.max(*high)]
        });
        let longest = (max - min).max_element();
        let (low, high) = (min - BELOW * longest, max + ABOVE * longest);
        let far = min.abs().max(max.abs()).max_element();
        let off = facets.iter().flat_map(|facet| {
            let plane = facet.plane;
            let corners = facet.corners.iter();
            corners.map(move |&p| (plane.normal.dot(p) - plane.offset).abs())
        });
        let slack = 4.0 * off.fold(COORDINATE * (far + longest), f64::max);
        let parts = (0..facets.len() as u32).map(Part::all_of).collect();
        let cutter = Cutter {
            facets,
            bounds,
            slack,
            is_needed,
            shells: OnceLock::new(),
        };
        let root = cutter.halve(parts, [low, high], 0, 0);
        Self {
            low,
            high,
            slack,
            root,
        }
    }
}

struct Cutter<'a> {
    facets: Vec<Facet>,
    /// The box around each.
    bounds: Vec<[DVec3; 2]>,
    /// Points nearer to a plane are on it: as far as corners are off the planes of their
    /// own faces, and some more.
    slack: f64,
    is_needed: &'a (dyn Fn(&[Part], [DVec3; 2]) -> bool + Sync),
    /// All of them, for where those in a box do not tell.
    shells: OnceLock<Shells>,
}

impl Cutter<'_> {
    fn halve(&self, parts: Vec<Part>, [low, high]: [DVec3; 2], cuts: u32, vain: u32) -> Halved {
        if !(self.is_needed)(&parts, [low, high]) {
            return Halved::Constant(false);
        }
        if self.is_few(&parts) || cuts == MOST_CUTS || vain == MOST_VAIN_CUTS {
            return Halved::Faces(self.tree(&parts, 0.5 * (low + high)));
        }
        let middle = 0.5 * (low + high);
        let axis = self.best_axis(&parts, middle, high - low);
        let at = middle[axis];
        let whole = parts.len();
        // What an empty half is, before its faces are gone.
        let halves = [0, 1].map(|half| {
            let (mut low, mut high) = (low, high);
            if half == 0 {
                high[axis] = at;
            } else {
                low[axis] = at;
            }
            [low, high]
        });
        let is_in = [-1.0, 1.0].map(|sign| {
            let beyond = |p: &DVec3| sign * (p[axis] - at) > 0.0;
            parts
                .iter()
                .any(|part| part.corners(&self.facets).iter().any(beyond))
        });
        let constants = [0, 1].map(|half| {
            let [low, high] = halves[half];
            (!is_in[half]).then(|| self.is_inside(&parts, 0.5 * (low + high)))
        });
        // (Hardly ever more than half of them are on one side.)
        let mut sides = [(); 2].map(|()| Vec::with_capacity(whole / 2 + whole / 8));
        for part in parts {
            self.part(part, axis, at, &mut sides);
        }
        let vain = |side: &[Part]| {
            if 10 * side.len() > 9 * whole {
                vain + 1
            } else {
                0
            }
        };
        let [below, above] = sides;
        let vains = [vain(&below), vain(&above)];
        let halve = |side: Vec<Part>, half: usize| match constants[half] {
            Some(constant) => Halved::Constant(constant),
            None => self.halve(side, halves[half], cuts + 1, vains[half]),
        };
        let (below, above) = if whole > AT_ONCE {
            rayon::join(|| halve(below, 0), || halve(above, 1))
        } else {
            (halve(below, 0), halve(above, 1))
        };
        Halved::Cut(axis, at, Box::new([below, above]))
    }

    fn bounds(&self, part: &Part) -> [DVec3; 2] {
        if part.is_whole() {
            return self.bounds[part.facet as usize];
        }
        bounds(part.corners(&self.facets))
    }

    /// The tree of facets, about a point near them.
    fn tree(&self, parts: &[Part], center: DVec3) -> Tree {
        let facets = parts.iter().map(|part| {
            let mut facet = self.facets[part.facet as usize].clone();
            facet.plane.offset -= facet.plane.normal.dot(center);
            for corner in &mut facet.corners {
                *corner -= center;
            }
            facet
        });
        let facets: Vec<Facet> = facets.collect();
        let parts = (0..).zip(parts).map(|(k, part)| part.moved(k, -center));
        let is_inside = |plane: &Plane, point: DVec3| {
            let plane = Plane {
                normal: plane.normal,
                offset: plane.offset + plane.normal.dot(center),
            };
            self.is_within(point + center, |facet| facet.is_off(&plane, self.slack))
        };
        Tree::of_parts(&facets, parts.collect(), self.slack, &is_inside)
    }

    /// Whether a point off those facets that pass a test is inside of them all.
    fn is_within(&self, point: DVec3, test: impl Fn(&Facet) -> bool) -> bool {
        let shells = self.shells.get_or_init(|| {
            let corners = self.facets.iter().flat_map(Facet::triangles);
            Shells::new([corners], 0.0)
        });
        shells.is_within(point, |index| test(&self.facets[index as usize]))
    }

    /// Whether facets are on few planes.
    fn is_few(&self, parts: &[Part]) -> bool {
        let mut faces: SmallVec<[u32; FEW_FACES]> = SmallVec::new();
        parts.iter().all(|part| {
            let face = self.facets[part.facet as usize].face;
            faces.contains(&face) || {
                faces.push(face);
                faces.len() <= FEW_FACES
            }
        })
    }

    /// The axis across which a cut in the middle leaves fewest facets on both sides; of those
    /// that are about as good the one along which the box is longest.
    fn best_axis(&self, parts: &[Part], middle: DVec3, size: DVec3) -> usize {
        let mut counts = [0_usize; 3];
        for part in parts {
            let [low, high] = self.bounds(part);
            for (axis, count) in counts.iter_mut().enumerate() {
                *count +=
                    usize::from(low[axis] < middle[axis]) + usize::from(high[axis] > middle[axis]);
            }
        }
        let least = counts.into_iter().min().unwrap_or(0);
        let is_good = |axis: &usize| 10 * counts[*axis] <= 11 * least + 20;
        let good = (0..3).filter(is_good);
        good.max_by(|&a, &b| size[a].total_cmp(&size[b]))
            .unwrap_or(0)
    }

    /// Adds what of a facet is below a coordinate along an axis, and what is above.
    fn part(&self, part: Part, axis: usize, at: f64, sides: &mut [Vec<Part>; 2]) {
        let [low, high] = self.bounds(&part);
        if high[axis] <= at {
            sides[0].push(part);
            return;
        }
        if low[axis] >= at {
            sides[1].push(part);
            return;
        }
        let corners = part.corners(&self.facets);
        for (side, sign) in sides.iter_mut().zip([1.0, -1.0]) {
            let mut left: SmallVec<[DVec3; 8]> = SmallVec::new();
            let following = corners.iter().cycle().skip(1);
            for (&p, &q) in corners.iter().zip(following) {
                let [to_p, to_q] = [p, q].map(|point| sign * (point[axis] - at));
                if to_p <= 0.0 {
                    left.push(p);
                }
                if (to_p < 0.0 && to_q > 0.0) || (to_p > 0.0 && to_q < 0.0) {
                    let mut crossing = p.lerp(q, to_p / (to_p - to_q));
                    crossing[axis] = at;
                    left.push(crossing);
                }
            }
            if left.len() >= 3 {
                side.push(part.cut(&left));
            }
        }
    }

    /// Whether a point of a box, off all faces, is inside, by the facets in the box: by the
    /// side of the first that is met on the way to the middle of one of them; by all facets where
    /// two are met there that look opposite ways.
    fn is_inside(&self, parts: &[Part], point: DVec3) -> bool {
        /// How many are aimed at.
        const AIMS: usize = 8;
        /// A facet met at less than this share of the way apart from another may be its
        /// neighbour, met at their edge.
        const CLEARLY: f64 = 1e-6;
        let mut best: Option<(f64, bool)> = None;
        for aim in parts.iter().step_by(parts.len().div_ceil(AIMS)) {
            let corners = aim.corners(&self.facets);
            let target = corners.iter().sum::<DVec3>() / corners.len() as f64;
            let way = target - point;
            let mut hits: SmallVec<[(f64, f64); 8]> = SmallVec::new();
            for part in parts {
                let normal = self.facets[part.facet as usize].plane.normal;
                let corners = part.corners(&self.facets);
                let slope = normal.dot(way);
                let to_plane = normal.dot(corners[0] - point);
                let share = to_plane / slope;
                if slope != 0.0
                    && (0.0..=1.0 + CLEARLY).contains(&share)
                    && holds(normal, corners, point + share * way)
                {
                    hits.push((share, slope));
                }
            }
            hits.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            let Some(&(share, slope)) = hits.first() else {
                continue;
            };
            let near = hits.iter().take_while(|hit| hit.0 - share <= CLEARLY);
            let is_clear = near.clone().all(|hit| (hit.1 > 0.0) == (slope > 0.0));
            let steepness = if is_clear {
                slope.abs() / way.length()
            } else {
                0.0
            };
            if best.is_none_or(|(best, _)| steepness > best) {
                best = Some((steepness, slope > 0.0));
            }
        }
        match best {
            Some((steepness, is_inside)) if steepness > 0.0 => is_inside,
            _ => self.is_within(point, |_| true),
        }
    }
}

fn bounds(points: &[DVec3]) -> [DVec3; 2] {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    points
        .iter()
        .fold(none, |[low, high], &p| [low.min(p), high.max(p)])
}

/// Whether a point of the plane of a facet is in it, or on its rim but for rounding.
fn holds(normal: DVec3, corners: &[DVec3], point: DVec3) -> bool {
    let following = corners.iter().cycle().skip(1);
    corners.iter().zip(following).all(|(&p, &q)| {
        let side = q - p;
        let off = normal.cross(side).dot(point - p);
        off >= -1e-9 * side.length() * ((point - p).length() + side.length())
    })
}
