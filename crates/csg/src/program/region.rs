//! A closed polyhedron of many faces as a formula that is pruned to few of them at once:
//! space is halved until few faces are in each box, and in the box these are combined by
//! a tree of their planes (W. C. Thibault, B. F. Naylor, "Set operations on polyhedra
//! using binary space partitioning trees", 1987). A tree over all of space would be as
//! deep as a convex polyhedron has faces.
//!
//! The planes that halve space are literals, too: "below it and in what is below it, or
//! above it and in what is above it" has one value on both sides of it.

use glam::DVec3;
use smallvec::SmallVec;

use crate::numeric::tolerance::COORDINATE;
use crate::solid::partition::{Facet, Tree};

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
    /// Of the faces of a closed polyhedron, as convex facets of any number.
    pub fn new(facets: Vec<Facet>) -> Self {
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [min, max] = facets.iter().fold(none, |[min, max], facet| {
            let [low, high] = bounds(&facet.points);
            [min.min(low), max.max(high)]
        });
        let longest = (max - min).max_element();
        let (low, high) = (min - BELOW * longest, max + ABOVE * longest);
        let far = min.abs().max(max.abs()).max_element();
        let off = facets.iter().flat_map(|facet| {
            let plane = facet.plane;
            let corners = facet.whole.iter();
            corners.map(move |&p| (plane.normal.dot(p) - plane.offset).abs())
        });
        let cutter = Cutter {
            slack: 4.0 * off.fold(COORDINATE * (far + longest), f64::max),
        };
        let root = cutter.halve(facets, [low, high], 0, 0);
        Self {
            low,
            high,
            slack: cutter.slack,
            root,
        }
    }
}

struct Cutter {
    /// Points nearer to a plane are on it: as far as corners are off the planes of their
    /// own faces, and some more.
    slack: f64,
}

impl Cutter {
    fn halve(&self, facets: Vec<Facet>, [low, high]: [DVec3; 2], cuts: u32, vain: u32) -> Halved {
        if is_few(&facets) || cuts == MOST_CUTS || vain == MOST_VAIN_CUTS {
            return Halved::Faces(self.tree(facets, 0.5 * (low + high)));
        }
        let middle = 0.5 * (low + high);
        let axis = best_axis(&facets, middle, high - low);
        let at = middle[axis];
        let whole = facets.len();
        let mut parts = [Vec::new(), Vec::new()];
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
            facets.iter().any(|facet| facet.points.iter().any(beyond))
        });
        let constants = [0, 1].map(|half| {
            let [low, high] = halves[half];
            (!is_in[half]).then(|| is_inside(&facets, 0.5 * (low + high)))
        });
        for facet in facets {
            part(facet, axis, at, &mut parts);
        }
        let vain = |part: &[Facet]| {
            if 10 * part.len() > 9 * whole {
                vain + 1
            } else {
                0
            }
        };
        let [below, above] = parts;
        let vains = [vain(&below), vain(&above)];
        let halve = |part: Vec<Facet>, half: usize| match constants[half] {
            Some(constant) => Halved::Constant(constant),
            None => self.halve(part, halves[half], cuts + 1, vains[half]),
        };
        let (below, above) = if whole > AT_ONCE {
            rayon::join(|| halve(below, 0), || halve(above, 1))
        } else {
            (halve(below, 0), halve(above, 1))
        };
        Halved::Cut(axis, at, Box::new([below, above]))
    }

    /// The tree of facets, about a point near them.
    fn tree(&self, mut facets: Vec<Facet>, center: DVec3) -> Tree {
        for facet in &mut facets {
            facet.plane.offset -= facet.plane.normal.dot(center);
            for point in facet.points.iter_mut().chain(&mut facet.whole) {
                *point -= center;
            }
        }
        Tree::of(facets, self.slack)
    }
}

fn bounds(points: &[DVec3]) -> [DVec3; 2] {
    let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    points
        .iter()
        .fold(none, |[low, high], &p| [low.min(p), high.max(p)])
}

/// Whether facets are on few planes.
fn is_few(facets: &[Facet]) -> bool {
    let mut faces: SmallVec<[u32; FEW_FACES]> = SmallVec::new();
    facets.iter().all(|facet| {
        faces.contains(&facet.face) || {
            faces.push(facet.face);
            faces.len() <= FEW_FACES
        }
    })
}

/// The axis across which a cut in the middle leaves fewest facets on both sides; of those
/// that are about as good the one along which the box is longest.
fn best_axis(facets: &[Facet], middle: DVec3, size: DVec3) -> usize {
    let mut counts = [0_usize; 3];
    for facet in facets {
        let [low, high] = bounds(&facet.points);
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
fn part(facet: Facet, axis: usize, at: f64, parts: &mut [Vec<Facet>; 2]) {
    let [low, high] = bounds(&facet.points);
    if high[axis] <= at {
        parts[0].push(facet);
        return;
    }
    if low[axis] >= at {
        parts[1].push(facet);
        return;
    }
    for (part, sign) in parts.iter_mut().zip([1.0, -1.0]) {
        let mut points = SmallVec::new();
        let following = facet.points.iter().cycle().skip(1);
        for (&p, &q) in facet.points.iter().zip(following) {
            let [to_p, to_q] = [p, q].map(|point| sign * (point[axis] - at));
            if to_p <= 0.0 {
                points.push(p);
            }
            if (to_p < 0.0 && to_q > 0.0) || (to_p > 0.0 && to_q < 0.0) {
                let mut crossing = p.lerp(q, to_p / (to_p - to_q));
                crossing[axis] = at;
                points.push(crossing);
            }
        }
        if points.len() >= 3 {
            part.push(Facet {
                points,
                whole: facet.whole.clone(),
                ..facet
            });
        }
    }
}

/// Whether a point of a box, off all faces, is inside, by the facets in the box: by the
/// side of the first that is met on the way to the middle of one of them.
fn is_inside(facets: &[Facet], point: DVec3) -> bool {
    /// How many are aimed at.
    const AIMS: usize = 8;
    /// A facet met at less than this share of the way apart from another may be its
    /// neighbour, met at their edge.
    const CLEARLY: f64 = 1e-6;
    let mut best: Option<(f64, bool)> = None;
    for aim in facets.iter().step_by(facets.len().div_ceil(AIMS)) {
        let target = aim.points.iter().sum::<DVec3>() / aim.points.len() as f64;
        let way = target - point;
        let mut hits: SmallVec<[(f64, f64); 8]> = SmallVec::new();
        for facet in facets {
            let slope = facet.plane.normal.dot(way);
            let to_plane = facet.plane.normal.dot(facet.points[0] - point);
            let share = to_plane / slope;
            if slope != 0.0
                && (0.0..=1.0 + CLEARLY).contains(&share)
                && holds(facet, point + share * way)
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
    best.is_some_and(|(_, is_inside)| is_inside)
}

/// Whether a point of the plane of a facet is in it, or on its rim but for rounding.
fn holds(facet: &Facet, point: DVec3) -> bool {
    let normal = facet.plane.normal;
    let following = facet.points.iter().cycle().skip(1);
    facet.points.iter().zip(following).all(|(&p, &q)| {
        let side = q - p;
        let off = normal.cross(side).dot(point - p);
        off >= -1e-9 * side.length() * ((point - p).length() + side.length())
    })
}
