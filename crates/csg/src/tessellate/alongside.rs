//! Curves side by side: those that bound one face and are nearer to each other than their
//! chords stray are cut at the same places, so that their chords run side by side, too.
//!
//! Let chords stray from two curves by at most s and t. Where the curves are farther apart
//! than s + t the chords cannot cross. Where they are not, every vertex of the one curve gets
//! its foot on the other one: then the gap between the chords is at each place about the mean
//! of those at their ends. One curve leads, and those beside it have its points in place of
//! their own, as theirs would be as many.

use std::collections::VecDeque;

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::SmallVec;

use super::chains::{Division, divide, farthest};
use super::curves::on_curve;
use super::deviation;
use super::goal::Goal;
use super::half_edges::HalfEdges;
use crate::program::{Surface, SurfaceId};

/// Lets the divisions of chains that run side by side agree.
pub(super) fn align(
    mesh: &HalfEdges<'_>,
    chains: &[Vec<u32>],
    divisions: &mut [Option<Division>],
    goal: &Goal,
) {
    const MOST_ROUNDS: u32 = 4;
    let pairs = neighbours(mesh, chains, divisions);
    if pairs.is_empty() {
        return;
    }
    // Where the vertices of such chains are they stay: between them there is no room.
    let mut lines: FxHashMap<u32, Line<'_>> = FxHashMap::default();
    let mut beside: FxHashMap<u32, SmallVec<[(u32, SurfaceId); 4]>> = FxHashMap::default();
    for (pair, face) in pairs {
        let mut line = |chain: u32| {
            let made = || Line::new(mesh, &chains[chain as usize], goal);
            let known = lines.contains_key(&chain);
            if !known && let Some(line) = made() {
                lines.insert(chain, line);
            }
            lines.contains_key(&chain)
        };
        if pair.map(&mut line) == [true; 2] {
            let [one, other] = pair;
            beside.entry(one).or_default().push((other, face));
            beside.entry(other).or_default().push((one, face));
        }
    }
    let mut order: Vec<u32> = lines.keys().copied().collect();
    let length = |chain: &u32| lines[chain].points.len();
    order.sort_unstable_by_key(|chain| (std::cmp::Reverse(length(chain)), *chain));
    // Those that wait as well, and those whose points are those that they keep.
    let (mut is_met, mut is_done) = (FxHashSet::default(), FxHashSet::default());
    for &leader in &order {
        let mut queue = VecDeque::new();
        queue.extend(is_met.insert(leader).then_some(leader));
        while let Some(chain) = queue.pop_front() {
            let line = &lines[&chain];
            let mut feet = Feet::default();
            for &(other, face) in beside.get(&chain).into_iter().flatten() {
                feet.add(line, &lines[&other], face, is_done.contains(&other));
                queue.extend(is_met.insert(other).then_some(other));
            }
            let led = line.led(feet);
            lines.insert(chain, led);
            is_done.insert(chain);
        }
    }
    // What the tolerance takes besides, on those that are led.
    for _ in 0..MOST_ROUNDS {
        let mut is_whole = true;
        for chain in &order {
            let mut line = lines[chain].fixed();
            let mut feet = Feet::default();
            for &(other, face) in beside.get(chain).into_iter().flatten() {
                feet.add(&line, &lines[&other], face, true);
            }
            feet.led.clear();
            let count = line.points.len();
            line = line.led(feet);
            is_whole &= line.points.len() == count;
            lines.insert(*chain, line);
        }
        if is_whole {
            break;
        }
    }
    for (chain, line) in lines {
        divisions[chain as usize] = Some(line.division());
    }
}

/// Pairs of chains that bound a face on its surface with nothing between them, where other surfaces
/// meet it, and run nearer to each other somewhere than their chords stray.
fn neighbours(
    mesh: &HalfEdges<'_>,
    chains: &[Vec<u32>],
    divisions: &[Option<Division>],
) -> Vec<([u32; 2], SurfaceId)> {
    let mut chains_of: FxHashMap<u32, SmallVec<[u32; 4]>> = FxHashMap::default();
    for (index, chain) in (0u32..).zip(chains) {
        if divisions[index as usize].is_none() {
            continue;
        }
        let last = chain.last().map(|&half| mesh.target(half));
        let vertices = chain.iter().map(|&half| mesh.origin(half)).chain(last);
        for vertex in vertices {
            let known = chains_of.entry(vertex).or_default();
            if known.last() != Some(&index) {
                known.push(index);
            }
        }
    }
    let mut pairs: Vec<([u32; 2], SurfaceId)> = Vec::new();
    for (index, chain) in (0u32..).zip(chains) {
        if divisions[index as usize].is_none() {
            continue;
        }
        for side in chain.iter().flat_map(|&half| [half, mesh.twin(half)]) {
            let face = mesh.surface_id(side);
            let others = chains_of.get(&mesh.apex(side)).into_iter().flatten();
            let others = others.filter(|&&other| other != index);
            let own = beyond(mesh.curve(chain[0]), face);
            // Two of one pair of surfaces part where these do.
            let bounds = |&&other: &&u32| {
                let curve = mesh.curve(chains[other as usize][0]);
                curve.contains(&face) && beyond(curve, face) != own
            };
            pairs.extend(
                others
                    .filter(bounds)
                    .map(|&other| ([index.min(other), index.max(other)], face)),
            );
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs.retain(|&(pair, face)| {
        let [one, other] = pair.map(|chain| chain as usize);
        [[one, other], [other, one]].iter().any(|&[from, to]| {
            let (Some(division), Some(on)) = (&divisions[from], &divisions[to]) else {
                return false;
            };
            let reach = division.deviation + on.deviation;
            let reach = reach.max(sag(&division.points) + sag(&on.points));
            let surface = &mesh.surfaces[beyond(mesh.curve(chains[to][0]), face)];
            let is_near = |&point: &DVec3| is_near(surface, point, reach);
            division.points.iter().any(is_near)
        })
    });
    pairs
}

/// The surface that meets another one in a curve.
fn beyond([one, other]: [SurfaceId; 2], surface: SurfaceId) -> SurfaceId {
    if one == surface { other } else { one }
}

fn is_near(surface: &Surface, point: DVec3, reach: f64) -> bool {
    deviation::first_order(surface, point) <= reach
}

/// How far chords stray from a curve of which these points follow each other, about. Where
/// surfaces meet at a small angle that is more than from these.
fn sag(points: &[DVec3]) -> f64 {
    let sags = points.windows(3).map(|w| {
        let along = w[2] - w[0];
        let off = (w[1] - w[0]).reject_from(along);
        0.25 * off.length()
    });
    sags.filter(|sag| sag.is_finite()).fold(0.0, f64::max)
}

/// A point of a chain that is being cut up.
#[derive(Clone, Copy, Debug)]
struct Point {
    at: DVec3,
    /// Whether it is a vertex of the chain.
    is_vertex: bool,
    /// Whether it stays where it is, as vertices do.
    is_fixed: bool,
}

impl Point {
    fn free(at: DVec3) -> Self {
        Self {
            at,
            is_vertex: false,
            is_fixed: false,
        }
    }
}

/// A chain and the points that cut it up, with its ends.
struct Line<'a> {
    surfaces: [&'a Surface; 2],
    ids: [SurfaceId; 2],
    points: Vec<Point>,
    /// How far its chords stray from the curve, about.
    sag: f64,
    tolerance: f64,
    precision: f64,
}

/// Of a chord: nearer to a vertex than this a foot is needed only where it must be.
const BESIDE_FIXED: f64 = 0.05;

/// Of rounding: what is nearer than this is there.
const SAME: f64 = 16.0;

/// A point next to one of another curve.
#[derive(Clone, Copy, Debug)]
struct Foot {
    /// Counted in chords of the line that it is on.
    place: f64,
    at: DVec3,
    /// From the point that it is next to.
    gap: f64,
    is_of_fixed: bool,
}

#[derive(Default)]
struct Feet {
    all: Vec<Foot>,
    /// Stretches of the line whose own points are replaced.
    led: Vec<[f64; 2]>,
}

impl<'a> Line<'a> {
    /// None if one of the chain's edges cannot be followed.
    fn new(mesh: &HalfEdges<'a>, chain: &[u32], goal: &Goal) -> Option<Self> {
        let fixed = |vertex: u32| Point {
            at: mesh.at(vertex),
            is_vertex: true,
            is_fixed: true,
        };
        let mut points = vec![fixed(mesh.origin(chain[0]))];
        let mut deviation = 0.0f64;
        for &half in chain {
            let division = divide(mesh, &[half], goal, mesh.precision)?;
            deviation = deviation.max(division.deviation);
            points.extend(division.points.iter().map(|&at| Point::free(at)));
            points.push(fixed(mesh.target(half)));
        }
        let ids = mesh.curve(chain[0]);
        let [one, other] = ids.map(|id| goal.tolerance_on(id));
        let all: Vec<DVec3> = points.iter().map(|point| point.at).collect();
        Some(Self {
            surfaces: mesh.curve_surfaces(chain[0]),
            ids,
            points,
            sag: deviation.max(sag(&all)),
            tolerance: one.min(other),
            precision: mesh.precision,
        })
    }

    /// The chord in which a point is next to the line, and after which share of it; from the
    /// one in which the point before was.
    fn place(&self, point: DVec3, before: &mut usize) -> Option<f64> {
        let chords = self.points.len() - 1;
        let share = |chord: usize| {
            let [p, q] = [self.points[chord].at, self.points[chord + 1].at];
            (point - p).dot(q - p) / p.distance_squared(q)
        };
        let off = |chord: usize| {
            let [p, q] = [self.points[chord].at, self.points[chord + 1].at];
            point.distance_squared(p.lerp(q, share(chord).clamp(0.0, 1.0)))
        };
        // Mostly it is next to the last one.
        let mut at = (*before).min(chords - 1);
        let mut least = off(at);
        let is_there = |chord: usize, off: f64| {
            let [p, q] = [self.points[chord].at, self.points[chord + 1].at];
            off <= 0.25 * p.distance_squared(q)
        };
        loop {
            let next = [at.wrapping_sub(1), at + 1];
            let next = next.into_iter().filter(|&chord| chord < chords);
            let best = next.map(|chord| (off(chord), chord));
            match best.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((off, chord)) if off < least => (least, at) = (off, chord),
                _ => break,
            }
        }
        if !is_there(at, least) {
            let all = (0..chords).map(|chord| (off(chord), chord));
            (least, at) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
        }
        *before = at;
        let share = share(at);
        let is_beyond = at == 0 && share < 0.0 || at + 1 == chords && share > 1.0;
        (is_there(at, least) && !is_beyond).then_some(at as f64 + share.clamp(0.0, 1.0))
    }

    /// The line with feet in place of its own points where it is led.
    fn led(&self, feet: Feet) -> Self {
        /// Of a chord: nearer to a foot a point of its own is not needed.
        const BESIDE: f64 = 0.4;
        /// Of a chord: nearer to each other than this two feet are one.
        const ONE: f64 = 0.02;
        let Feet { mut all, led } = feet;
        all.retain(|foot| self.is_needed(foot));
        all.sort_by(|a, b| a.place.total_cmp(&b.place));
        all.dedup_by(|next, kept| {
            let is_one = next.place - kept.place < ONE && !self.keeps_off(next, kept.at);
            if is_one && next.is_of_fixed {
                *kept = *next;
            }
            is_one
        });
        let is_led = |place: f64| led.iter().any(|&[from, to]| from <= place && place <= to);
        // In order, each with its place; those of other lines come with a foot.
        let mut points: Vec<(f64, bool, Point)> = Vec::new();
        for (k, &point) in self.points.iter().enumerate() {
            let place = k as f64;
            if point.is_fixed || !is_led(place) {
                points.push((place, false, point));
            }
        }
        let feet = all.iter();
        points.extend(feet.map(|foot| (foot.place, true, Point::free(foot.at))));
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut led: Vec<Point> = Vec::with_capacity(points.len());
        let mut before: Option<(f64, bool)> = None;
        for (k, &(place, is_foot, point)) in points.iter().enumerate() {
            let next = points
                .get(k + 1)
                .map(|&(place, is_foot, _)| (place, is_foot));
            let mut others = [before, next].into_iter().flatten();
            let is_beside =
                others.any(|(other, is_foot)| is_foot && (other - place).abs() < BESIDE);
            if is_beside && !is_foot && !point.is_fixed {
                continue;
            }
            if let Some(&Point { at, .. }) = led.last() {
                self.fill([at, point.at], 0, &mut led);
            }
            led.push(point);
            before = Some((place, is_foot));
        }
        Self {
            points: led,
            ..*self
        }
    }

    /// The line with all its points to stay.
    fn fixed(&self) -> Self {
        let points = self.points.iter().map(|&point| Point {
            is_fixed: true,
            ..point
        });
        Self {
            points: points.collect(),
            ..*self
        }
    }

    /// Points between two, as many as the tolerance takes.
    fn fill(&self, [from, to]: [DVec3; 2], halvings: u32, points: &mut Vec<Point>) {
        const MOST_HALVINGS: u32 = 4;
        let off = deviation::of_chord(self.surfaces, from, to);
        if off <= self.tolerance || halvings == MOST_HALVINGS {
            return;
        }
        let reach = 0.5 * from.distance(to);
        let middle = on_curve(self.surfaces, from.midpoint(to), reach, self.precision);
        let Some(at) = middle else {
            return;
        };
        self.fill([from, at], halvings + 1, points);
        points.push(Point::free(at));
        self.fill([at, to], halvings + 1, points);
    }

    /// Whether a foot is needed: not so on a straight line, where a chord that stays keeps off by half
    /// of the gap, and mostly not next to a vertex.
    fn is_needed(&self, foot: &Foot) -> bool {
        if self.sag <= SAME * self.precision {
            return false;
        }
        let chord = (foot.place as usize).min(self.points.len() - 2);
        let ends = [self.points[chord], self.points[chord + 1]];
        let [p, q] = ends.map(|end| end.at);
        let off = (foot.at - p).reject_from_normalized((q - p).normalize_or_zero());
        if ends.iter().all(|end| end.is_fixed) && off.length() <= 0.5 * foot.gap {
            return false;
        }
        let mut fixed = ends.iter().filter(|point| point.is_fixed);
        fixed.all(|point| {
            let is_far = point.at.distance(foot.at) > BESIDE_FIXED * self.chord(foot.place);
            is_far || self.keeps_off(foot, point.at)
        })
    }

    /// Whether a chord between a foot's neighbours, of which one is next to it, would come nearer to the
    /// vertex that the foot is next to than half the gap.
    fn keeps_off(&self, foot: &Foot, neighbour: DVec3) -> bool {
        // Next to its ends a parabola strays from its chord by this, of what it does amid them.
        let share = foot.at.distance(neighbour) / self.chord(foot.place);
        4.0 * self.sag * share > 0.5 * foot.gap
    }

    /// The length of the chord at a place.
    fn chord(&self, place: f64) -> f64 {
        let chord = (place as usize).min(self.points.len() - 2);
        let [p, q] = [self.points[chord].at, self.points[chord + 1].at];
        p.distance(q)
    }

    fn division(self) -> Division {
        let ends = self.points.iter().enumerate().skip(1);
        let ends = ends.filter(|(_, point)| point.is_vertex);
        let ends = ends.map(|(index, _)| index as u32).collect();
        let all: Vec<DVec3> = self.points.iter().map(|point| point.at).collect();
        let (first, last) = (all[0], all[all.len() - 1]);
        let points = all[1..all.len() - 1].to_vec();
        let (deviation, farthest) =
            farthest(self.surfaces, [first, last], &points, points.len() + 1);
        Division {
            points,
            ends,
            deviation,
            farthest,
        }
    }
}

impl Feet {
    /// Adds those on a line of the points of another one that bounds the same face; of its
    /// fixed points alone unless it leads.
    fn add(&mut self, line: &Line<'_>, other: &Line<'_>, face: SurfaceId, leads: bool) {
        let surface = beyond(line.ids, face);
        let which = usize::from(line.ids[0] != surface);
        let surface = line.surfaces[which];
        let reach = line.sag + other.sag;
        let mut chord = 0;
        // The stretch that the points before led.
        let mut run: Option<[f64; 2]> = None;
        let points = &other.points;
        for (k, point) in points.iter().enumerate() {
            let foot = is_near(surface, point.at, reach).then(|| {
                let beside = [k.saturating_sub(1), (k + 1).min(points.len() - 1)];
                let lengths = beside.map(|b| points[b].at.distance(point.at));
                let most = 0.5 * lengths[0].max(lengths[1]);
                let at = on_curve(line.surfaces, point.at, most, line.precision)?;
                let gap = at.distance(point.at);
                let place = line.place(at, &mut chord)?;
                // One that is on both curves is a vertex of both.
                (SAME * line.precision < gap && gap <= reach).then_some(Foot {
                    place,
                    at,
                    gap,
                    is_of_fixed: point.is_fixed,
                })
            });
            let Some(Some(foot)) = foot else {
                self.led.extend(run.take());
                continue;
            };
            if leads || foot.is_of_fixed {
                self.all.push(foot);
            }
            if leads {
                run = Some(match run {
                    Some([from, to]) => [from.min(foot.place), to.max(foot.place)],
                    None => [foot.place; 2],
                });
            }
        }
        self.led.extend(run);
    }
}
