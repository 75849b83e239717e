//! Triangles of polyhedra that cross those of others, cut up along the lines in which they do.
//!
//! Such a line ends where an edge of one polyhedron leads through a triangle of another one.
//! That point is one vertex, named by both, whichever triangles meet there, so that all pieces
//! fit each other to the bit. Told is only what is clear by more than the margin; whatever nearly
//! touches, or is crossed by two others in one point, is left in doubt.

use glam::{DVec3, Vec2Swizzles as _};
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use smallvec::SmallVec;

use super::placed::Region;
use crate::mesh::triangulate::{Named, Scratch, triangulate};
use crate::mesh::{Shells, flat};
use crate::numeric::tolerance::{NEAR, SLANT, WELD};

/// The triangles of all polyhedra, numbered through as in [`Shells`], and their vertices.
pub(super) struct Soup<'a> {
    regions: &'a [&'a Region],
    shells: &'a Shells,
    /// Things nearer to each other touch, as far as any stage can tell.
    margin: f64,
    /// Those that were given, region by region.
    pub points: Vec<DVec3>,
    /// Where those of each region begin.
    first_of: Vec<u32>,
}

impl<'a> Soup<'a> {
    pub fn new(regions: &'a [&'a Region], shells: &'a Shells, margin: f64) -> Self {
        let mut points = Vec::with_capacity(regions.iter().map(|r| r.vertices.len()).sum());
        let mut first_of = Vec::with_capacity(regions.len());
        for region in regions {
            first_of.push(points.len() as u32);
            points.extend_from_slice(&region.vertices);
        }
        Self {
            regions,
            shells,
            margin,
            points,
            first_of,
        }
    }

    /// The region of a triangle, and its number there.
    pub fn place_of(&self, triangle: u32) -> (usize, usize) {
        let region = self.shells.shell_of(triangle);
        let first = self.shells.triangles_of(region).start;
        (region, triangle as usize - first)
    }

    pub fn corners(&self, triangle: u32) -> [u32; 3] {
        let (region, index) = self.place_of(triangle);
        let first = self.first_of[region];
        self.regions[region].triangles[index].map(|vertex| first + vertex)
    }

    fn at(&self, vertex: u32) -> DVec3 {
        self.points[vertex as usize]
    }

    /// What two triangles of different polyhedra have in common.
    fn meeting(&self, pair: [u32; 2]) -> Meeting {
        let corners = pair.map(|triangle| self.corners(triangle));
        let sheets = corners.map(|corners| Sheet::of(corners.map(|vertex| self.at(vertex))));
        let heights = [0, 1].map(|k| {
            let other = &sheets[1 - k];
            corners[k].map(|vertex| other.height(self.at(vertex)))
        });
        let is_apart = |heights: &[f64; 3]| {
            heights.iter().all(|&h| h > self.margin) || heights.iter().all(|&h| h < -self.margin)
        };
        if (0..2).any(|k| !sheets[1 - k].is_narrow && is_apart(&heights[k])) {
            return Meeting::Apart;
        }
        let along = sheets[0].normal.cross(sheets[1].normal);
        let is_clear = |height: &f64| height.abs() > self.margin;
        let is_known = !sheets.iter().any(|sheet| sheet.is_narrow);
        if !(is_known && along.length() >= SLANT && heights.iter().flatten().all(is_clear)) {
            return Meeting::Unclear;
        }
        // The places on the common line of both planes, in order.
        let (along, origin) = (along.normalize(), self.at(corners[0][0]));
        let mut stretches = [[(0.0, End::default()); 2]; 2];
        for k in 0..2 {
            let lone = (0..3).find(|&i| {
                let [here, next, last] = [0, 1, 2].map(|j| heights[k][(i + j) % 3] > 0.0);
                here != next && here != last
            });
            let Some(lone) = lone else {
                return Meeting::Unclear;
            };
            for (place, step) in stretches[k].iter_mut().zip([1, 2]) {
                let ends = [lone, (lone + step) % 3].map(|i| (corners[k][i], heights[k][i]));
                let Some(end) = self.end(ends, pair[1 - k]) else {
                    return Meeting::Unclear;
                };
                *place = (along.dot(end.at - origin), end);
            }
            stretches[k].sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let [one, other] = stretches;
        let is_clear = |a: &(f64, End)| other.iter().all(|b| (a.0 - b.0).abs() > self.margin);
        if !one.iter().all(is_clear) {
            return Meeting::Unclear;
        }
        let low = if one[0].0 > other[0].0 {
            one[0]
        } else {
            other[0]
        };
        let high = if one[1].0 < other[1].0 {
            one[1]
        } else {
            other[1]
        };
        if low.0 < high.0 {
            Meeting::Line([low.1, high.1])
        } else {
            Meeting::Apart
        }
    }

    /// Where an edge, given by its ends and their heights, leads through a triangle's plane, the
    /// same to the bit whichever triangle the edge is of; none if that is at a small angle.
    fn end(&self, mut ends: [(u32, f64); 2], triangle: u32) -> Option<End> {
        ends.sort_unstable_by_key(|&(vertex, _)| vertex);
        let [(from, height), (to, other)] = ends;
        let [start, end] = [from, to].map(|vertex| self.at(vertex));
        let change = height - other;
        let is_steep = change.abs() >= SLANT * start.distance(end);
        is_steep.then(|| End {
            edge: [from, to],
            triangle,
            at: start.lerp(end, height / change),
        })
    }
}

/// The plane of a triangle.
struct Sheet {
    origin: DVec3,
    normal: DVec3,
    /// Whether that is not known well.
    is_narrow: bool,
}

impl Sheet {
    fn of([a, b, c]: [DVec3; 3]) -> Self {
        let normal = (b - a).cross(c - a);
        let longest = [a - b, b - c, c - a].map(DVec3::length_squared);
        let longest = longest.into_iter().fold(0.0, f64::max);
        Self {
            origin: a,
            normal: normal.normalize_or_zero(),
            is_narrow: normal.length() <= SLANT * longest,
        }
    }

    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.origin)
    }
}

/// The end of a line in which two triangles cross: where an edge leads through a triangle.
#[derive(Clone, Copy, Default)]
struct End {
    edge: [u32; 2],
    triangle: u32,
    at: DVec3,
}

enum Meeting {
    Apart,
    Unclear,
    Line([End; 2]),
}

/// A line on a triangle: its ends, and the triangle on the other side of which it is, too.
type Line = ([u32; 2], u32);

/// The triangles that cross others.
pub(super) struct Crossed {
    /// Those that were cut, each with its pieces, in ascending order.
    pub all: Vec<(u32, Vec<[u32; 3]>)>,
    /// The two triangles of every line, by its ends, the lower first.
    pub lines: FxHashMap<[u32; 2], [u32; 2]>,
    /// Triangles of which it was not clear what they have in common with others.
    pub in_doubt: Vec<u32>,
    /// How many vertices were given; the others are ends of lines.
    given: u32,
    ends: Vec<End>,
}

impl Crossed {
    /// Finds all of some polyhedra; the points in which they cross become vertices of the soup.
    /// Takes n log n steps for n triangles, but for those that hundreds of others cross.
    pub fn of(soup: &mut Soup<'_>) -> Self {
        let mut found = Self {
            all: Vec::new(),
            lines: FxHashMap::default(),
            in_doubt: Vec::new(),
            given: soup.points.len() as u32,
            ends: Vec::new(),
        };
        let pairs = soup.shells.pairs();
        let meetings: Vec<Meeting> = pairs.par_iter().map(|&pair| soup.meeting(pair)).collect();
        let mut numbers: FxHashMap<([u32; 2], u32), u32> = FxHashMap::default();
        for (pair, meeting) in pairs.into_iter().zip(meetings) {
            match meeting {
                Meeting::Apart => {}
                Meeting::Unclear => found.in_doubt.extend(pair),
                Meeting::Line(both) => {
                    let mut both = both.map(|end| {
                        *numbers.entry((end.edge, end.triangle)).or_insert_with(|| {
                            soup.points.push(end.at);
                            found.ends.push(end);
                            soup.points.len() as u32 - 1
                        })
                    });
                    both.sort_unstable();
                    found.lines.insert(both, pair);
                }
            }
        }
        found.cut(soup);
        found
    }

    /// Forgets some lines, given by their ends.
    pub fn without(mut self, soup: &Soup<'_>, some: &[[u32; 2]]) -> Self {
        for line in some {
            self.lines.remove(line);
        }
        self.cut(soup);
        self
    }

    /// Cuts all triangles along their lines.
    fn cut(&mut self, soup: &Soup<'_>) {
        let of_both =
            |(&ends, &pair): (&[u32; 2], &[u32; 2])| [0, 1].map(|k| (pair[k], (ends, pair[1 - k])));
        let mut lines: Vec<(u32, Line)> = self.lines.iter().flat_map(of_both).collect();
        lines.sort_unstable();
        let of_triangles: Vec<&[(u32, Line)]> = lines.chunk_by(|a, b| a.0 == b.0).collect();
        let (given, ends) = (self.given, &self.ends[..]);
        let cutter = Cutter { soup, given, ends };
        let cut = of_triangles
            .par_iter()
            .map_init(Scratch::default, |scratch, lines| {
                (lines[0].0, cutter.cut(lines[0].0, lines, scratch))
            });
        let cut: Vec<(u32, Option<Vec<[u32; 3]>>)> = cut.collect();
        self.all.clear();
        for (triangle, pieces) in cut {
            match pieces {
                Some(pieces) => self.all.push((triangle, pieces)),
                None => self.in_doubt.push(triangle),
            }
        }
    }

    /// Where one of two triangles that cross is to be cut by half-spaces, has the other one cut
    /// so, too, if one of them is part of a larger face: where its edges lead through the other
    /// there are no vertices then. Whether there is any such.
    pub fn cut_where_faces_are_one(
        &self,
        is_cut: &mut [bool],
        is_one_of_several: &impl Fn(u32) -> bool,
    ) -> bool {
        let mut has_changed = false;
        for pair in self.lines.values() {
            let [one, other] = pair.map(|triangle| is_cut[triangle as usize]);
            if one != other && pair.iter().any(|&triangle| is_one_of_several(triangle)) {
                for &triangle in pair {
                    is_cut[triangle as usize] = true;
                }
                has_changed = true;
            }
        }
        has_changed
    }
}

/// Cuts up triangles.
struct Cutter<'a> {
    soup: &'a Soup<'a>,
    /// How many points were given; the others are ends of lines.
    given: u32,
    ends: &'a [End],
}

impl Cutter<'_> {
    /// The pieces into which lines cut a triangle; none if some are too near each other.
    fn cut(
        &self,
        triangle: u32,
        lines: &[(u32, Line)],
        scratch: &mut Scratch,
    ) -> Option<Vec<[u32; 3]>> {
        if !self.are_apart(lines) {
            return None;
        }
        let [a, b, c] = self.soup.corners(triangle).map(|v| self.soup.at(v));
        let normal = (b - a).cross(c - a);
        let axis = normal.abs().max_position();
        let name = |&vertex: &u32| {
            let seen = flat(self.soup.at(vertex), axis);
            let is_seen_from_behind = normal[axis] < 0.0;
            (if is_seen_from_behind { seen.yx() } else { seen }, vertex)
        };
        let flat: Vec<Vec<Named>> = self
            .contours(triangle, lines)?
            .iter()
            .map(|contour| contour.iter().map(name).collect())
            .collect();
        let rounding = WELD / NEAR * self.soup.margin;
        triangulate(&flat, rounding, &|| true, scratch)
    }

    /// Whether lines that are of several other polyhedra do not come near each other.
    fn are_apart(&self, lines: &[(u32, Line)]) -> bool {
        /// So many pairs are worth the time. Tunes speed only.
        const MOST_PAIRS: usize = 1 << 16;
        let region = |&(_, (_, other)): &(u32, Line)| self.soup.place_of(other).0;
        let Some(first) = lines.first().map(region) else {
            return true;
        };
        if lines.iter().all(|line| region(line) == first) {
            return true;
        }
        let ends = |&(_, (ends, _)): &(u32, Line)| ends.map(|end| self.soup.at(end));
        let margin = self.soup.margin;
        let is_beyond = |[a, b]: [DVec3; 2], other: [DVec3; 2]| {
            let along = (b - a).normalize_or_zero();
            let off = other.map(|point| (point - a).reject_from_normalized(along));
            // On one side of the line, in the plane of both.
            off.iter().all(|off| off.length() > margin) && off[0].dot(off[1]) > 0.0
        };
        let is_past = |[a, b]: [DVec3; 2], other: [DVec3; 2]| {
            let along = (b - a).normalize_or_zero();
            let [start, end] = [a, b].map(|point| along.dot(point));
            let places = other.map(|point| along.dot(point));
            places.iter().all(|&p| p > end + margin) || places.iter().all(|&p| p < start - margin)
        };
        let are_apart = |a: [DVec3; 2], b: [DVec3; 2]| {
            is_beyond(a, b) || is_beyond(b, a) || is_past(a, b) || is_past(b, a)
        };
        lines.len() * lines.len() <= MOST_PAIRS
            && lines.iter().enumerate().all(|(k, one)| {
                let mut others = lines[..k].iter();
                others
                    .all(|other| region(one) == region(other) || are_apart(ends(one), ends(other)))
            })
    }

    /// The contours of the pieces, counter-clockwise around each and clockwise around holes.
    fn contours(&self, triangle: u32, lines: &[(u32, Line)]) -> Option<Vec<Vec<u32>>> {
        // Where lines lead from their ends.
        let mut beyond: FxHashMap<u32, SmallVec<[u32; 2]>> = FxHashMap::default();
        for &(_, (ends, _)) in lines {
            for k in 0..2 {
                beyond.entry(ends[k]).or_default().push(ends[1 - k]);
            }
        }
        let around = self.around(triangle, &beyond)?;
        let place_of: FxHashMap<u32, usize> = around
            .iter()
            .enumerate()
            .map(|(k, &point)| (point, k))
            .collect();
        let is_whole = |(point, others): (&u32, &SmallVec<[u32; 2]>)| {
            others.len() == if place_of.contains_key(point) { 1 } else { 2 }
        };
        if !beyond.iter().all(is_whole) {
            return None;
        }
        let after = |from: u32, at: u32| {
            let others = &beyond[&at];
            others[usize::from(others[0] == from)]
        };
        let mut is_passed: FxHashSet<u32> = FxHashSet::default();
        let mut is_done = vec![false; around.len()];
        let mut contours = Vec::new();
        for start in 0..around.len() {
            if is_done[start] {
                continue;
            }
            let mut contour = Vec::new();
            let mut at = start;
            loop {
                // Along the side, and over the triangle from where a line begins.
                if std::mem::replace(&mut is_done[at], true) {
                    return None;
                }
                contour.push(around[at]);
                at = (at + 1) % around.len();
                if let Some(others) = beyond.get(&around[at]) {
                    let (mut from, mut to) = (around[at], others[0]);
                    contour.push(from);
                    while !place_of.contains_key(&to) {
                        contour.push(to);
                        is_passed.insert(to);
                        (from, to) = (to, after(from, to));
                    }
                    at = place_of[&to];
                }
                if at == start {
                    break;
                }
            }
            contours.push(contour);
        }
        // Lines that lead back to where they begin.
        for &(_, (ends, _)) in lines {
            if is_passed.contains(&ends[0]) || place_of.contains_key(&ends[0]) {
                continue;
            }
            let (mut from, mut to) = (ends[0], ends[1]);
            let mut contour = vec![from];
            is_passed.insert(from);
            while to != ends[0] {
                contour.push(to);
                is_passed.insert(to);
                (from, to) = (to, after(from, to));
            }
            let back = contour.iter().rev().copied().collect();
            contours.extend([contour, back]);
        }
        Some(contours)
    }

    /// The corners of a triangle and the points on its sides, counter-clockwise; none if some
    /// are near each other.
    fn around(
        &self,
        triangle: u32,
        points: &FxHashMap<u32, SmallVec<[u32; 2]>>,
    ) -> Option<Vec<u32>> {
        let corners = self.soup.corners(triangle);
        let mut around = Vec::with_capacity(3 + points.len());
        for k in 0..3 {
            let [from, to] = [corners[k], corners[(k + 1) % 3]];
            let edge = [from.min(to), from.max(to)];
            let first = around.len();
            around.push(from);
            let is_here = |&point: &u32| self.ends[(point - self.given) as usize].edge == edge;
            around.extend(points.keys().copied().filter(is_here));
            let start = self.soup.at(from);
            let away = |point: u32| self.soup.at(point).distance_squared(start);
            around[first..].sort_unstable_by(|&a, &b| away(a).total_cmp(&away(b)));
        }
        let gap = |k: usize| {
            let ends = [around[k], around[(k + 1) % around.len()]];
            let [a, b] = ends.map(|point| self.soup.at(point));
            a.distance(b)
        };
        let are_apart = (0..around.len()).all(|k| gap(k) > self.soup.margin);
        are_apart.then_some(around)
    }
}
