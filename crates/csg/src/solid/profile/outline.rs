//! The outline of a set of points that contours of lines and arcs enclose.
//!
//! All sides are cut where they meet, and arcs also where they turn back in x. A piece
//! bounds the set if that is on one side of it alone: how often the contours wind around
//! the points above a piece is counted along the ray from its middle upwards, and below it
//! what the pieces there themselves say less. Pieces that lie on each other are one. What
//! rounding leaves open shows in points that more pieces lead to than from: then there is
//! no outline, rather than a wrong one.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DAffine2, DVec2, DVec3};
use smallvec::SmallVec;

use super::lines::Lines;
use super::polygon::cleaned;
use super::side::{Course, Side, find_pair, sides, slack};
use super::{Bend, Combination, Contour, Corner, FillRule, Profile, Shape, Step};
use crate::elementary;
use crate::mesh::box_tree::{Bounds, BoxTree};
use crate::numeric::Welder;
use crate::numeric::tolerance::IN_PROFILE;

/// The most pieces of sides, and places where these meet: a few seconds' work.
const MOST_PIECES: usize = 200_000;

/// Of the slack within which sides meet, how far apart points are that are one: of a place
/// where several meet each pair tells a point twice the slack from it at most.
const ONE_POINT: f64 = 4.0;

/// Of that slack, how far apart the middles are of pieces that lie on each other: their ends are
/// one point each, and so nearly are their lines or circles.
const ONE_MIDDLE: f64 = 4.0 * ONE_POINT;

/// The contours around the points of a set, which lies on their left; contours may touch.
/// The set is of those points of which `is_in` says so of how often each of `groups` groups
/// of contours winds around them. `None` if rounding leaves open what meets, or of more than
/// 200,000 pieces.
pub(super) fn outline(
    contours: &[(usize, Contour)],
    groups: usize,
    is_in: impl Fn(&[i64]) -> bool,
) -> Option<(Vec<Contour>, Lines)> {
    let pieces = Pieces::of(contours)?;
    let kept = pieces.bounding(groups, is_in);
    let mut lines = Lines::default();
    let contours = pieces.joined(&kept, &mut lines)?;
    Some((contours, lines))
}

impl Profile {
    /// The contours around the profile, which lies on their left. `None` if it has ellipses or
    /// parabolas, or if rounding leaves open what meets.
    pub(super) fn outline(&self) -> Option<Vec<Contour>> {
        let mut contours = Vec::new();
        let mut groups = 0;
        for step in &self.steps {
            if let Step::Shape(shape, map) = step {
                contours.extend(shape.mapped(map)?.into_iter().map(|c| (groups, c)));
                groups += 1;
            }
        }
        outline(&contours, groups, |windings| self.is_around(windings)).map(|(outline, _)| outline)
    }

    /// The least and the greatest coordinates, to rounding; none of a profile without points.
    /// `None` if [`Self::outline`] is.
    pub(super) fn exact_bounds(&self) -> Option<Option<(DVec2, DVec2)>> {
        let contours = self.outline()?;
        let sides = contours.iter().flat_map(|contour| sides(contour));
        Some(
            sides
                .map(|side| (side.min, side.max))
                .reduce(|(min, max), (low, high)| (min.min(low), max.max(high))),
        )
    }

    /// The same profile with its Booleans carried out, lines and arcs as such, as far as rounding
    /// leaves nothing open and there are no ellipses or parabolas.
    pub(crate) fn resolved(self) -> Self {
        match self.outline() {
            Some(contours) => Self::within(contours),
            None => self,
        }
    }

    /// What contours enclose that have it on their left.
    pub(crate) fn within(contours: Vec<Contour>) -> Self {
        let shape = Shape::Contours(contours.into(), FillRule::NonZero);
        Self::shape(shape, DAffine2::IDENTITY)
    }

    /// Whether points are in the profile around which the contours of its leaves wind so often.
    fn is_around(&self, windings: &[i64]) -> bool {
        let mut windings = windings.iter();
        let leaf = |shape: &Shape, _: &DAffine2| {
            let winding = windings.next().copied().unwrap_or(0);
            Ok(match shape {
                Shape::Disc => winding != 0,
                Shape::Contours(_, rule) => rule.is_inside(winding),
            })
        };
        let combine = |combination, operands: Vec<bool>| {
            Ok(match combination {
                Combination::Union => operands.contains(&true),
                Combination::Intersection => !operands.is_empty() && !operands.contains(&false),
                Combination::Difference => {
                    operands.first() == Some(&true) && !operands[1..].contains(&true)
                }
            })
        };
        self.fold(leaf, combine) == Ok(Some(true))
    }
}

impl Shape {
    /// The images of its contours under a map; `None` if these have parabolas, or arcs that become elliptic.
    fn mapped(&self, map: &DAffine2) -> Option<Vec<Contour>> {
        let disc = || {
            let corner = |point| Corner::arc(point, 1.0);
            vec![vec![corner(DVec2::X), corner(DVec2::NEG_X)]]
        };
        let contours = match self {
            Self::Disc => disc(),
            Self::Contours(contours, _) => contours.to_vec(),
        };
        let (x, y) = (map.matrix2.x_axis, map.matrix2.y_axis);
        let keeps_circles = [x.perp(), -x.perp()]
            .iter()
            .any(|across| y.abs_diff_eq(*across, IN_PROFILE * x.length()));
        let is_told = |corner: &Corner| match corner.bend {
            Bend::Straight => true,
            Bend::Arc(_) => keeps_circles,
            Bend::Parabola { .. } => false,
        };
        if !contours.iter().flatten().all(is_told) {
            return None;
        }
        let turn = map.matrix2.determinant().signum();
        let mapped = |corner: &Corner| {
            Corner::arc(map.transform_point2(corner.point), turn * corner.bulge())
        };
        let images = contours.iter().map(|contour| {
            let image: Contour = contour.iter().map(mapped).collect();
            cleaned(&image).ok()
        });
        Some(
            images
                .collect::<Option<Vec<_>>>()?
                .into_iter()
                .flatten()
                .collect(),
        )
    }
}

/// A part of a side that neither meets others nor turns back in x.
struct Piece {
    /// Its ends, the left one first, or the lower one if it is upright.
    ends: [u32; 2],
    side: usize,
    /// Whether the side runs from the first end to the other.
    is_forward: bool,
    /// Where it lies on its side, rising.
    shares: [f64; 2],
    /// Whether it is on the upper half of its circle.
    is_upper: bool,
}

/// Pieces that lie on each other.
struct Stack {
    /// One of them.
    piece: usize,
    /// How often more the contours of groups wind around points on the left of it, seen from
    /// its first end to the other, than around those on its right.
    windings: SmallVec<[(usize, i64); 1]>,
    middle: DVec2,
}

struct Pieces {
    sides: Vec<Side>,
    points: Vec<DVec2>,
    /// The points with one x where this is the same within rounding: what is upright is exactly
    /// so.
    aligned: Vec<DVec2>,
    pieces: Vec<Piece>,
    stacks: Vec<Stack>,
    slack: f64,
}

/// A piece of the outline, which has the set on its left.
#[derive(Clone, Copy)]
struct Stride {
    piece: usize,
    ends: [u32; 2],
}

impl Pieces {
    fn of(contours: &[(usize, Contour)]) -> Option<Self> {
        let mut all = Vec::new();
        let mut group_of = Vec::new();
        for (group, contour) in contours {
            all.extend(sides(contour));
            group_of.resize(all.len(), *group);
        }
        let slack = slack(all.iter());
        let mut pieces = Self {
            points: Vec::new(),
            aligned: Vec::new(),
            pieces: Vec::new(),
            stacks: Vec::new(),
            slack,
            sides: all,
        };
        pieces.cut()?;
        pieces.stack(&group_of);
        Some(pieces)
    }

    /// Makes pieces of the sides.
    fn cut(&mut self) -> Option<()> {
        let mut welder = Welder::new(ONE_POINT * self.slack);
        let mut number = |point: DVec2| welder.number(point.extend(0.0));
        let mut cuts: Vec<Vec<(f64, u32)>> = Vec::with_capacity(self.sides.len());
        for side in &self.sides {
            cuts.push(vec![(0.0, number(side.from)), (1.0, number(side.to))]);
        }
        for (k, j, point) in meetings(&self.sides, self.slack)? {
            let vertex = number(point);
            for side in [k, j] {
                cuts[side].push((self.sides[side].share(point), vertex));
            }
        }
        for (side, cuts) in self.sides.iter().zip(&mut cuts) {
            for share in side.turns() {
                cuts.push((share, number(side.at(share))));
            }
            cuts.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        self.points = welder.points.iter().map(|p| p.truncate()).collect();
        self.aligned = aligned(&self.points, ONE_POINT * self.slack);
        for (side, cuts) in cuts.iter().enumerate() {
            for pair in cuts.windows(2) {
                let [(first, from), (last, to)] = [pair[0], pair[1]];
                if from == to {
                    continue;
                }
                let [a, b] = [from, to].map(|end| self.aligned[end as usize]);
                let is_forward = (a.x, a.y) < (b.x, b.y);
                self.pieces.push(Piece {
                    ends: if is_forward { [from, to] } else { [to, from] },
                    side,
                    is_forward,
                    shares: [first, last],
                    is_upper: self.sides[side].arc.is_some_and(|arc| {
                        let middle = arc.at(0.5 * (first + last));
                        middle.y > arc.center.y
                    }),
                });
            }
        }
        (self.pieces.len() <= MOST_PIECES).then_some(())
    }

    /// Puts pieces together that lie on each other.
    fn stack(&mut self, group_of: &[usize]) {
        let mut order: Vec<usize> = (0..self.pieces.len()).collect();
        order.sort_by_key(|&k| (self.pieces[k].ends, k));
        for k in order {
            let piece = &self.pieces[k];
            let middle = self.middle(k);
            let ends = |stack: &&mut Stack| self.pieces[stack.piece].ends == piece.ends;
            let open = self.stacks.iter_mut().rev().take_while(ends);
            let same = open.into_iter().find(|stack| {
                // Where both are upright, or as high at the same x.
                stack.middle.distance(middle) <= ONE_MIDDLE * self.slack
            });
            let winding = (group_of[piece.side], if piece.is_forward { 1 } else { -1 });
            match same {
                Some(stack) => stack.windings.push(winding),
                None => self.stacks.push(Stack {
                    piece: k,
                    windings: SmallVec::from_elem(winding, 1),
                    middle,
                }),
            }
        }
    }

    fn ends(&self, piece: usize) -> [DVec2; 2] {
        self.pieces[piece]
            .ends
            .map(|end| self.aligned[end as usize])
    }

    /// A point between the ends of a piece: where x is between theirs.
    fn middle(&self, piece: usize) -> DVec2 {
        let [a, b] = self.ends(piece);
        let middle = a.midpoint(b);
        if a.x < b.x {
            DVec2::new(middle.x, self.height(piece, middle.x))
        } else {
            middle
        }
    }

    /// Where a piece that is not upright is over x.
    fn height(&self, piece: usize, x: f64) -> f64 {
        let [a, b] = self.ends(piece);
        let (low, high) = (a.y.min(b.y), a.y.max(b.y));
        let y = match &self.sides[self.pieces[piece].side].arc {
            None => a.y + (x - a.x) * ((b.y - a.y) / (b.x - a.x)),
            Some(arc) => {
                let across = x - arc.center.x;
                let up = (arc.radius * arc.radius - across * across).max(0.0).sqrt();
                let upper = self.pieces[piece].is_upper;
                // Over its ends an arc has no point that is beyond both, but where it bulges.
                let y = arc.center.y + if upper { up } else { -up };
                return if upper { y.max(low) } else { y.min(high) };
            }
        };
        y.clamp(low, high)
    }

    /// A box around a piece.
    fn around(&self, piece: usize) -> Bounds {
        let [a, b] = self.ends(piece);
        let side = &self.sides[self.pieces[piece].side];
        let (low, high) = if side.arc.is_some() {
            (side.min.y, side.max.y)
        } else {
            (a.y, a.y)
        };
        Bounds {
            low: DVec3::new(a.x, low.min(a.y).min(b.y) - self.slack, 0.0),
            high: DVec3::new(b.x, high.max(a.y).max(b.y) + self.slack, 0.0),
        }
    }

    /// The pieces with the set on one side alone.
    fn bounding(&self, groups: usize, is_in: impl Fn(&[i64]) -> bool) -> Vec<Stride> {
        let boxes: Vec<Bounds> = self.stacks.iter().map(|s| self.around(s.piece)).collect();
        let tree = BoxTree::numbered(&boxes);
        let mut kept = Vec::new();
        let mut windings = vec![0; groups];
        for (k, stack) in self.stacks.iter().enumerate() {
            let [a, b] = self.ends(stack.piece);
            let is_upright = a.x == b.x;
            // Above it; or, if it is upright, on its left.
            windings.fill(0);
            let above = Bounds {
                low: stack.middle.extend(0.0),
                high: DVec3::new(stack.middle.x, f64::INFINITY, 0.0),
            };
            tree.overlapping(&above, &mut |other| {
                let above = &self.stacks[other as usize];
                let [from, to] = self.ends(above.piece);
                let is_over = if is_upright {
                    from.x < stack.middle.x && stack.middle.x <= to.x
                } else {
                    from.x <= stack.middle.x && stack.middle.x < to.x
                };
                if is_over
                    && other as usize != k
                    && self.height(above.piece, stack.middle.x) > stack.middle.y
                {
                    // Below a piece that runs to the right is its right.
                    for &(group, winding) in &above.windings {
                        windings[group] -= winding;
                    }
                }
            });
            let left = is_in(&windings);
            for &(group, winding) in &stack.windings {
                windings[group] -= winding;
            }
            let right = is_in(&windings);
            if left != right {
                let [from, to] = self.pieces[stack.piece].ends;
                kept.push(Stride {
                    piece: stack.piece,
                    ends: if left { [from, to] } else { [to, from] },
                });
            }
        }
        kept
    }

    /// The contours that pieces make up, if as many lead to every point as from it.
    fn joined(&self, kept: &[Stride], lines: &mut Lines) -> Option<Vec<Contour>> {
        let mut leaving: Vec<SmallVec<[usize; 1]>> = vec![SmallVec::new(); self.points.len()];
        for (k, step) in kept.iter().enumerate() {
            leaving[step.ends[0] as usize].push(k);
        }
        // Where contours touch their sides end: what is nearer there is told by corners.
        let touches: Vec<bool> = leaving.iter().map(|steps| steps.len() > 1).collect();
        let mut contours = Vec::new();
        let mut is_used = vec![false; kept.len()];
        for first in 0..kept.len() {
            // The way so far, from which what comes back to it is split off.
            let mut way: Vec<Stride> = Vec::new();
            let mut next = (!is_used[first]).then_some(first);
            while let Some(at) = next {
                is_used[at] = true;
                let step = kept[at];
                way.push(step);
                let end = step.ends[1];
                if let Some(from) = way.iter().position(|before| before.ends[0] == end) {
                    contours.push(self.contour(&way.split_off(from), &touches, lines));
                    if way.is_empty() {
                        break;
                    }
                }
                let leaving = &mut leaving[end as usize];
                leaving.retain(|&mut step| !is_used[step]);
                let turn = |&next: &usize| self.turn(&step, &kept[next]);
                let by_turn = |a: &&usize, b: &&usize| turn(a).total_cmp(&turn(b));
                next = Some(*leaving.iter().max_by(by_turn)?);
            }
        }
        Some(contours)
    }

    /// How far to the left the way turns from one step to the next, in radians; and a little
    /// more or less if that bends away to the left or right.
    fn turn(&self, arriving: &Stride, leaving: &Stride) -> f64 {
        let before = self.course(arriving, arriving.ends[1]);
        let after = self.course(leaving, leaving.ends[0]);
        let bend = elementary::atan(after.bend * self.slack / IN_PROFILE) / FRAC_PI_2;
        before.turn_to(&after) + IN_PROFILE * bend
    }

    /// The course of a step at one of its ends.
    fn course(&self, step: &Stride, end: u32) -> Course {
        let piece = &self.pieces[step.piece];
        let along = self.runs_along(step);
        let is_first = (end == step.ends[0]) == along;
        let course = self.sides[piece.side].course(piece.shares[usize::from(!is_first)]);
        if along { course } else { course.reversed() }
    }

    /// Whether a step runs as the side does of which it is a piece.
    fn runs_along(&self, step: &Stride) -> bool {
        let piece = &self.pieces[step.piece];
        (step.ends == piece.ends) == piece.is_forward
    }

    /// The corners of steps that follow each other, those on one line or circle as one side but
    /// where contours touch.
    fn contour(&self, steps: &[Stride], touches: &[bool], lines: &mut Lines) -> Contour {
        /// Of an arc: the centre of one that is nearly whole depends on rounding.
        const MOST: f64 = 1.5 * PI;
        let sweep = |step: &Stride| {
            let piece = &self.pieces[step.piece];
            let part = piece.shares[1] - piece.shares[0];
            let arc = self.sides[piece.side].arc.as_ref();
            let whole = arc.map_or(0.0, |arc| arc.sweep * part);
            if self.runs_along(step) { whole } else { -whole }
        };
        let goes_on = |k: usize| {
            let [before, here] = [(k + steps.len() - 1) % steps.len(), k].map(|k| &steps[k]);
            if touches[here.ends[0] as usize] {
                return false;
            }
            let [one, other] = [before, here].map(|step| self.pieces[step.piece].side);
            one == other
                || match [one, other].map(|side| &self.sides[side].arc) {
                    [Some(a), Some(b)] => {
                        a.center.distance(b.center).max((a.radius - b.radius).abs()) <= self.slack
                            && sweep(before) * sweep(here) > 0.0
                    }
                    _ => false,
                }
        };
        let Some(start) = (0..steps.len()).find(|&k| !goes_on(k)) else {
            return self.circle(steps.iter().map(sweep).sum(), &steps[0]);
        };
        let mut corners: Vec<(DVec2, f64)> = Vec::new();
        let mut of_side: Vec<&Stride> = Vec::new();
        for k in start..start + steps.len() {
            let k = k % steps.len();
            let more = sweep(&steps[k]);
            match corners.last_mut() {
                Some((_, sum)) if goes_on(k) && (*sum + more).abs() <= MOST => *sum += more,
                _ => {
                    corners.push((self.points[steps[k].ends[0] as usize], more));
                    of_side.push(&steps[k]);
                }
            }
        }
        for (k, &step) in of_side.iter().enumerate() {
            let side = &self.sides[self.pieces[step.piece].side];
            let [from, to] = [k, (k + 1) % corners.len()].map(|k| corners[k].0);
            if side.arc.is_none() {
                let line = match self.runs_along(step) {
                    true => [side.from, side.to],
                    false => [side.to, side.from],
                };
                lines.insert([from, to], line);
            }
        }
        let corner = |(point, sweep)| Corner::arc(point, elementary::tan(0.25 * sweep));
        corners.into_iter().map(corner).collect()
    }

    /// The whole circle of which a step is a part.
    fn circle(&self, sweep: f64, step: &Stride) -> Contour {
        let Some(arc) = &self.sides[self.pieces[step.piece].side].arc else {
            return Contour::new();
        };
        let corner =
            |across: f64| Corner::arc(arc.center + across * arc.radius * DVec2::X, sweep.signum());
        vec![corner(1.0), corner(-1.0)]
    }
}

/// The points with the least x of those that follow each other by less than a distance.
fn aligned(points: &[DVec2], distance: f64) -> Vec<DVec2> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].x.total_cmp(&points[b].x));
    let mut aligned = points.to_vec();
    for pair in order.windows(2) {
        let [before, here] = [pair[0], pair[1]];
        if points[here].x - points[before].x <= distance {
            aligned[here].x = aligned[before].x;
        }
    }
    aligned
}

/// Where two of the sides meet, and which these are; neighbours in their corner, too. `None` if
/// there are too many such places.
fn meetings(sides: &[Side], slack: f64) -> Option<Vec<(usize, usize, DVec2)>> {
    let mut found = Vec::new();
    let too_many = find_pair(sides, slack, |k, j| {
        let points = sides[k].meet(&sides[j], slack);
        found.extend(points.into_iter().map(|point| (k, j, point)));
        (found.len() > MOST_PIECES).then_some(())
    });
    too_many.is_none().then_some(found)
}
