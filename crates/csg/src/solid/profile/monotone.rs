//! A simple polygon as a monotone formula over the half-planes of its sides,
//! each used once: D. Dobkin, L. Guibas, J. Hershberger, J. Snoeyink, "An
//! efficient algorithm for finding the CSG representation of a simple polygon",
//! Computer Graphics 22 (4), 1988.
//!
//! Cut at its least and greatest corner, the polygon is the intersection of
//! what lies to the left of two chains, whose ends go on to infinity along
//! their first and last sides. A chain is cut at a corner of its convex hull:
//! the two sides there, prolonged, meet nothing else, so both parts are simple
//! again. Left of the chain is left of both parts where that corner is convex,
//! and left of either where it is not.
//!
//! Corners are sought along the whole chain at every cut, which is quadratic in
//! the number of corners at worst.

use glam::DVec2;
use robust::{Coord, orient2d};

use super::plane_set::{Leaf, PlaneSet};
use crate::numeric::tolerance::IN_PROFILE;

/// Twice the area of the triangle, its sign exact: positive if a, b, c turn
/// counter-clockwise.
pub(super) fn orient(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|DVec2 { x, y }| Coord { x, y });
    orient2d(a, b, c)
}

/// The inside of a simple polygon, counter-clockwise. Corners that are straight within rounding
/// are passed over: which sides of them meet others, prolonged, would be left to rounding.
pub(super) fn inside(corners: &[DVec2]) -> PlaneSet {
    let far = |most: f64, corner: &DVec2| corner.abs().max_element().max(most);
    let slack = IN_PROFILE * corners.iter().fold(0.0, far);
    let corners = &turning(corners, slack)[..];
    let chains = Chains { corners, slack };
    let by_place = |a: &usize, b: &usize| {
        let (a, b) = (corners[*a], corners[*b]);
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
    };
    let count = corners.len();
    let least = (0..count).min_by(by_place);
    let greatest = (0..count).max_by(by_place);
    let (Some(least), Some(greatest)) = (least, greatest) else {
        return PlaneSet::EMPTY;
    };
    let turning = least + (greatest + count - least) % count;
    let mut set = PlaneSet::EMPTY;
    let mut tasks = vec![
        Task::Combine(true),
        Task::Chain(turning, least + count),
        Task::Chain(least, turning),
    ];
    while let Some(task) = tasks.pop() {
        match task {
            Task::Combine(both) => set.push_pair(both),
            Task::Chain(first, end) if end - first <= 1 => set.push(Leaf::HalfPlane {
                from: chains.at(first),
                to: chains.at(end),
            }),
            Task::Chain(first, end) => {
                let corner = chains.hull_corner(first, end);
                let [a, b, c] = [corner - 1, corner, corner + 1].map(|k| chains.at(k));
                tasks.push(Task::Combine(orient(a, b, c) > 0.0));
                tasks.push(Task::Chain(corner, end));
                tasks.push(Task::Chain(first, corner));
            }
        }
    }
    set
}

/// The corners that are off the line between the one before that is kept and the next one.
fn turning(corners: &[DVec2], slack: f64) -> Vec<DVec2> {
    let mut kept: Vec<DVec2> = Vec::with_capacity(corners.len());
    for (k, &corner) in corners.iter().enumerate() {
        let before = kept.last().or(corners.last()).copied();
        let next = match corners.get(k + 1) {
            Some(&next) => next,
            None => kept.first().copied().unwrap_or(corner),
        };
        let is_straight = before.is_some_and(|before| {
            let along = next - before;
            let off = along.perp_dot(corner - before).abs();
            off <= slack * along.length()
        });
        if !is_straight {
            kept.push(corner);
        }
    }
    kept
}

enum Task {
    /// The sides from one corner to another, as a chain.
    Chain(usize, usize),
    /// Both of the last two values, or either.
    Combine(bool),
}

struct Chains<'a> {
    corners: &'a [DVec2],
    /// Corners that are so far apart across a line are on it alike.
    slack: f64,
}

impl Chains<'_> {
    fn at(&self, index: usize) -> DVec2 {
        self.corners[index % self.corners.len()]
    }

    fn direction(&self, from: usize, to: usize) -> DVec2 {
        (self.at(to) - self.at(from)).normalize_or_zero()
    }

    /// The inner corner of a chain of at least two sides that is the furthest
    /// against both its ends, and of several such the furthest across.
    fn hull_corner(&self, first: usize, end: usize) -> usize {
        let start = self.direction(first + 1, first);
        let finish = self.direction(end - 1, end);
        let sum = start + finish;
        // The ends point opposite ways: the corners furthest off their line.
        let opposite = sum.length_squared() < IN_PROFILE * IN_PROFILE;
        let outward = if opposite { start.perp() } else { -sum };
        let base = self.at(first + 1);
        let key = |k: usize, sign: f64| {
            let offset = self.at(k) - base;
            (sign * outward.dot(offset), outward.perp_dot(offset))
        };
        let furthest = |sign: f64| {
            let keys = || (first + 1..end).map(|k| (key(k, sign), k));
            let most = keys().fold(f64::NEG_INFINITY, |most, (key, _)| most.max(key.0));
            keys()
                .filter(|(key, _)| key.0 >= most - self.slack * outward.length())
                .max_by(|(a, _), (b, _)| a.1.total_cmp(&b.1))
        };
        let one = furthest(1.0);
        let other = if opposite { furthest(-1.0) } else { None };
        let best = match (one, other) {
            (Some(one), Some(other)) if other.0.0 > one.0.0 + self.slack => Some(other),
            (one, _) => one,
        };
        best.map_or(first + 1, |(_, k)| k)
    }
}
