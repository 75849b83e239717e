//! Polygons with holes cut into triangles, every vertex kept.
//!
//! Holes are joined to the contour around them by bridges (Eberly,
//! *Triangulation by Ear Clipping*, 2002), then ears are clipped. Corners on
//! straight stretches of a contour are corners of triangles, but no triangle is
//! flat: they belong to neighbours whose edges end there.

mod contours;
mod obstacles;
mod strips;

use glam::DVec2;

pub(crate) use self::contours::{Named, is_surrounded};
use self::contours::{Region, bounds, leftmost, rounding_of_area, signed_area};
use self::obstacles::{Corner, Obstacles};
use self::strips::Strips;
use super::flat::flip_flat;
use super::predicates::orient;

/// Memory that is used again for every face.
#[derive(Default)]
pub(crate) struct Scratch {
    corners: Vec<Corner>,
    strips: Strips,
    obstacles: Obstacles,
}

/// Cuts the regions bounded by `contours`, counter-clockwise around regions and
/// clockwise around holes, into counter-clockwise triangles of names. None if
/// no triangulation without flat triangles was found, or the caller does not
/// want to go on; distances below `tolerance` are rounding. Time is quadratic
/// in the number of corners at worst, rather linear mostly.
pub(crate) fn triangulate(
    contours: &[Vec<Named>],
    tolerance: f64,
    go_on: &impl Fn() -> bool,
    scratch: &mut Scratch,
) -> Option<Vec<[u32; 3]>> {
    let mut regions: Vec<Region<'_>> = Vec::new();
    let mut holes: Vec<&[Named]> = Vec::new();
    for outer in contours {
        let area = signed_area(outer);
        // A slit may have either sign.
        if area > rounding_of_area(outer) {
            regions.push(Region {
                outer,
                bounds: bounds(outer.iter().map(|p| p.0)),
                area,
                holes: Vec::new(),
            });
        } else {
            holes.push(outer);
        }
    }
    for hole in holes {
        let around = match regions.as_mut_slice() {
            [only] => only,
            many => many
                .iter_mut()
                .filter(|region| region.holds(hole))
                .min_by(|a, b| a.area.total_cmp(&b.area))?,
        };
        around.holes.push(hole);
    }
    let corners = contours.iter().map(Vec::len).sum::<usize>() + 2 * contours.len();
    let mut triangles = Vec::with_capacity(corners);
    for region in regions {
        let mut work = Clipper::new(&region, tolerance, scratch);
        let holes = region.holes.iter().map(|&hole| (leftmost(hole).0.x, hole));
        let mut holes: Vec<(f64, &[Named])> = holes.collect();
        holes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut left = region.area;
        for (_, hole) in holes {
            left += signed_area(hole);
            go_on().then_some(())?;
            work.bridge(hole)?;
        }
        let first = triangles.len();
        let clipped = work.clip(&mut triangles, go_on)?;
        // Whatever went wrong, triangles that overlap have too much area.
        let count = (triangles.len() - first) as f64;
        let rounding = 8.0 * f64::EPSILON * count * work.extent().length_squared();
        if (clipped - left).abs() > rounding {
            return None;
        }
        if work.has_flat {
            let points = work.corners.iter().map(|c| (c.name, c.point));
            let contours = region.holes.iter().chain([&region.outer]);
            flip_flat(
                &mut triangles[first..],
                points,
                contours.copied(),
                tolerance,
            );
        }
    }
    Some(triangles)
}

/// The longest side of a triangle.
fn longest([a, b, c]: [DVec2; 3]) -> f64 {
    let sides = [b - a, c - b, a - c].map(DVec2::length_squared);
    sides[0].max(sides[1]).max(sides[2]).sqrt()
}

/// How much is held against an ear.
#[derive(Clone, Copy, PartialEq)]
enum Care {
    /// Neither flat, nor does anything touch its diagonal.
    Full,
    /// Positive area, and nothing in it or on its diagonal. Of a polygon that does not cross
    /// itself there is always such an ear.
    Exact,
    /// Positive area, and nothing inside but for rounding.
    Some,
}

struct Clipper<'a> {
    corners: &'a mut Vec<Corner>,
    strips: &'a mut Strips,
    obstacles: &'a mut Obstacles,
    tolerance: f64,
    /// Whether there was no better ear than a flat one.
    has_flat: bool,
}

impl<'a> Clipper<'a> {
    /// With the outer contour alone, but memory for the holes.
    fn new(region: &Region<'_>, tolerance: f64, scratch: &'a mut Scratch) -> Self {
        let Scratch {
            corners,
            strips,
            obstacles,
        } = scratch;
        let in_holes = region.holes.iter().map(|hole| hole.len() + 2);
        let count = region.outer.len() + in_holes.sum::<usize>();
        corners.clear();
        corners.reserve(count);
        strips.part(region, count);
        let mut work = Self {
            corners,
            strips,
            obstacles,
            tolerance,
            has_flat: false,
        };
        work.add_ring(region.outer);
        work
    }

    /// Finds the edge from a corner in the strips that it passes through.
    fn enter_strips(&mut self, corner: u32) {
        let ends = [corner, self.at(corner).next].map(|k| self.point(k).y);
        self.strips.add(corner, ends);
    }

    fn at(&self, corner: u32) -> &Corner {
        &self.corners[corner as usize]
    }

    fn point(&self, corner: u32) -> DVec2 {
        self.at(corner).point
    }

    fn extent(&self) -> DVec2 {
        let [least, most] = bounds(self.corners.iter().map(|c| c.point));
        most - least
    }

    fn add_ring(&mut self, ring: &[Named]) -> u32 {
        let first = self.corners.len() as u32;
        let count = ring.len() as u32;
        for (k, &(point, name)) in (0u32..).zip(ring) {
            self.corners.push(Corner {
                point,
                name,
                previous: first + (k + count - 1) % count,
                next: first + (k + 1) % count,
            });
        }
        for corner in first..first + count {
            self.enter_strips(corner);
        }
        first
    }

    fn join(&mut self, a: u32, b: u32) {
        self.corners[a as usize].next = b;
        self.corners[b as usize].previous = a;
    }

    /// Whether a direction from a corner points into the polygon.
    fn opens_towards(&self, corner: u32, target: DVec2) -> bool {
        let here = self.point(corner);
        let (before, after) = (
            self.point(self.at(corner).previous),
            self.point(self.at(corner).next),
        );
        if orient(before, here, after) > 0.0 {
            orient(here, after, target) >= 0.0 && orient(before, here, target) >= 0.0
        } else {
            orient(here, after, target) >= 0.0 || orient(before, here, target) >= 0.0
        }
    }

    /// Joins a hole to the ring of corner 0 by a bridge from its leftmost
    /// corner. The holes must come from left to right.
    fn bridge(&mut self, hole: &[Named]) -> Option<()> {
        let here = leftmost(hole).0;
        // The nearest edge that a ray to the left hits: it goes down.
        let mut nearest = f64::NEG_INFINITY;
        let mut best = None;
        for &at in self.strips.between([here.y; 2]) {
            let corner = *self.at(at);
            let (p, q) = (corner.point, self.point(corner.next));
            if p.y >= here.y && here.y >= q.y && p.y != q.y {
                let x = p.x + (here.y - p.y) * (q.x - p.x) / (q.y - p.y);
                if x <= here.x && x > nearest {
                    nearest = x;
                    best = Some(if p.x < q.x { at } else { corner.next });
                }
            }
        }
        let best = best?;
        // Its left end is seen from the hole, unless corners lie in between:
        // then the one with the least slope is.
        let end = self.point(best);
        let hit = DVec2::new(nearest, here.y);
        let triangle = if here.y < end.y {
            [here, end, hit]
        } else {
            [hit, end, here]
        };
        let mut lowest: Option<u32> = None;
        let sign = if here.y < end.y { 1.0 } else { -1.0 };
        for &at in self.strips.between([here.y, end.y]) {
            let p = self.point(at);
            let is_between = end.x <= p.x && p.x < here.x && {
                let [a, b, c] = triangle;
                orient(a, b, p) >= 0.0 && orient(b, c, p) >= 0.0 && orient(c, a, p) >= 0.0
            };
            let is_lower = |known: u32| {
                let known = self.point(known);
                let under = sign * orient(here, known, p);
                under > 0.0 || under == 0.0 && p.x > known.x
            };
            if is_between && lowest.is_none_or(is_lower) && self.opens_towards(at, here) {
                lowest = Some(at);
            }
        }
        let best = lowest.unwrap_or(best);
        // Of a slit's two corners there the one that the bridge comes from.
        let ring = self.add_ring(hole);
        let mut corners = (ring..).take(hole.len());
        let tip =
            corners.find(|&k| self.point(k) == here && self.opens_towards(k, here - DVec2::X))?;
        // Both ends twice: once on the way there, once on the way back.
        let (after, before) = (self.at(best).next, self.at(tip).previous);
        let twins = [*self.at(tip), *self.at(best)].map(|corner| {
            self.corners.push(corner);
            self.corners.len() as u32 - 1
        });
        self.join(best, tip);
        self.join(before, twins[0]);
        self.join(twins[0], twins[1]);
        self.join(twins[1], after);
        for corner in [best, twins[0], twins[1]] {
            self.enter_strips(corner);
        }
        Some(())
    }

    /// Clips ears until nothing is left; the area of all triangles.
    fn clip(&mut self, triangles: &mut Vec<[u32; 3]>, go_on: &impl Fn() -> bool) -> Option<f64> {
        let mut left = self.corners.len();
        self.obstacles.find(self.corners, self.tolerance);
        let mut at = 0;
        let mut vain = 0;
        let mut care = Care::Full;
        let mut area = 0.0;
        loop {
            let Corner { previous, next, .. } = *self.at(at);
            let [a, b, c] = [previous, at, next].map(|k| self.point(k));
            if left == 3 || self.is_ear(at, care) {
                let doubled = orient(a, b, c);
                area += 0.5 * doubled;
                if doubled <= 0.0 {
                    return None;
                }
                self.has_flat |= doubled <= self.tolerance * longest([a, b, c]);
                go_on().then_some(())?;
                triangles.push([previous, at, next].map(|k| self.at(k).name));
                if left == 3 {
                    return Some(area);
                }
                self.join(previous, next);
                self.obstacles.remove(at);
                left -= 1;
                // Not the next one: that makes fans.
                at = self.at(next).next;
                vain = 0;
                care = Care::Full;
                continue;
            }
            at = next;
            vain += 1;
            if vain > left {
                care = match care {
                    Care::Full => Care::Exact,
                    Care::Exact => Care::Some,
                    Care::Some => return None,
                };
                vain = 0;
            }
        }
    }

    fn is_ear(&self, corner: u32, care: Care) -> bool {
        let Corner { previous, next, .. } = *self.at(corner);
        let [a, b, c] = [previous, corner, next].map(|k| self.point(k));
        let area = orient(a, b, c);
        let flat = self.tolerance * longest([a, b, c]);
        let least = if care == Care::Full { flat } else { 0.0 };
        if area <= least {
            return false;
        }
        let is_in = |p: DVec2| {
            let beyond = orient(c, a, p);
            let mut aside = [(a, b), (b, c)].into_iter().map(|(a, b)| orient(a, b, p));
            match care {
                Care::Full => beyond >= -flat && aside.all(|v| v > 0.0),
                Care::Exact => beyond >= 0.0 && aside.all(|v| v >= 0.0),
                Care::Some => beyond >= flat && aside.all(|v| v > flat),
            }
        };
        let blocks = |p: DVec2| p != a && p != b && p != c && is_in(p);
        !self
            .obstacles
            .any_in(a.min(b).min(c), a.max(b).max(c), |k| {
                k != previous && k != corner && k != next && blocks(self.point(k))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points named by their number.
    fn named<const N: usize>(first: u32, points: [[f64; 2]; N]) -> Vec<Named> {
        points.into_iter().map(DVec2::from).zip(first..).collect()
    }

    fn square(half: f64) -> Vec<Named> {
        named(
            0,
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|p| p.map(|v| v * half)),
        )
    }

    /// The triangles' area, after each side of a contour was found to be one of a
    /// triangle.
    fn area(contours: &[Vec<Named>]) -> f64 {
        let triangles =
            triangulate(contours, 1e-12, &|| true, &mut Scratch::default()).expect("triangles");
        let points: Vec<Named> = contours.concat();
        let at = |name: u32| points.iter().find(|p| p.1 == name).expect("known").0;
        for contour in contours {
            for (a, b) in contour.iter().zip(contour.iter().cycle().skip(1)) {
                let has = |&[p, q, r]: &[u32; 3]| [[p, q], [q, r], [r, p]].contains(&[a.1, b.1]);
                assert_eq!(
                    triangles.iter().filter(|t| has(t)).count(),
                    1,
                    "{a:?} {b:?}"
                );
            }
        }
        let areas = triangles.iter().map(|t| {
            let [a, b, c] = t.map(at);
            0.5 * (b - a).perp_dot(c - a)
        });
        areas.sum()
    }

    /// There and back again along a bend, by the same corners.
    #[test]
    fn slits_are_holes_whatever_the_sign_of_their_area() {
        let mut signs = [0; 2];
        for k in 0..60 {
            let along = DVec2::from_angle(0.1 * f64::from(k));
            let at = |t: f64| (t * along + 0.3 * t * t * along.perp()).to_array();
            let slit = [0.0, 0.1, 0.23, 0.5, 0.7, 0.5, 0.23, 0.1].map(at);
            let contours = [square(2.0), named(4, slit)];
            let own = signed_area(&contours[1]);
            signs[0] += usize::from(own > 0.0);
            signs[1] += usize::from(own < 0.0);
            let found = area(&contours);
            assert!((found - 16.0).abs() < 1e-12, "{k}: {found}");
        }
        assert!(signs.iter().all(|&count| count > 2), "{signs:?}");
    }

    /// Down one side and up the other, with a corner in the middle of each.
    #[test]
    fn slits_may_be_kinked_by_rounding() {
        let kink = f64::EPSILON;
        for (top, middle, bottom) in [
            (0.5, 0.5, 0.5),
            (0.5, 0.5, 0.5 + kink),
            (0.5 + kink, 0.5, 0.5),
            (0.5 + kink, 0.5, 0.5 + kink),
            (0.5, 0.5 + kink, 0.5),
        ] {
            let slit = [[top, 0.3], [middle, 0.0], [bottom, -0.3], [middle, 0.0]];
            for turns in 0..4 {
                let mut slit = slit;
                slit.rotate_left(turns);
                let found = area(&[square(2.0), named(4, slit)]);
                assert!(
                    (found - 16.0).abs() < 1e-12,
                    "{top} {middle} {bottom}: {found}"
                );
            }
        }
    }

    /// A square and the holes in a Sierpinski carpet, turned and moved: whole rows of corners
    /// are in line but for rounding.
    fn carpet(levels: u32, angle: f64) -> Vec<Vec<Named>> {
        let turn = DVec2::from_angle(angle);
        let mut contours: Vec<Vec<Named>> = Vec::new();
        let mut add = |middle: DVec2, corners: [[f64; 2]; 4]| {
            let first = 4 * contours.len() as u32;
            let place = |p: [f64; 2]| turn.rotate(middle + DVec2::from(p)) + 37.0 * turn;
            contours.push(corners.into_iter().map(place).zip(first..).collect());
        };
        add(
            DVec2::ZERO,
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]],
        );
        let mut cells = vec![DVec2::ZERO];
        let mut size = 2.0;
        for _ in 0..levels {
            let h = size / 6.0;
            size /= 3.0;
            let mut smaller = Vec::new();
            for cell in cells {
                add(cell, [[-h, -h], [-h, h], [h, h], [h, -h]]);
                for (i, j) in (-1..=1).flat_map(|i| (-1..=1).map(move |j| (i, j))) {
                    if (i, j) != (0, 0) {
                        smaller.push(cell + size * DVec2::new(f64::from(i), f64::from(j)));
                    }
                }
            }
            cells = smaller;
        }
        contours
    }

    #[test]
    fn corners_in_line_but_for_rounding_make_no_flat_triangles() {
        const TOLERANCE: f64 = 1e-12;
        let mut count = 0;
        for k in 0..200 {
            let contours = carpet(3, 0.001 + 0.0314 * f64::from(k));
            let found = triangulate(&contours, TOLERANCE, &|| true, &mut Scratch::default());
            let triangles = found.unwrap_or_else(|| panic!("{k}"));
            let points = contours.concat();
            let corners = |t: &[u32; 3]| t.map(|name| points[name as usize].0);
            let height = |t: &[u32; 3]| {
                let [a, b, c] = corners(t);
                orient(a, b, c) / longest([a, b, c])
            };
            assert!(triangles.iter().all(|t| height(t) > TOLERANCE), "{k}");
            let area: f64 = triangles
                .iter()
                .map(corners)
                .map(|[a, b, c]| orient(a, b, c))
                .sum();
            let wanted = 4.0 * (8.0f64 / 9.0).powi(3);
            assert!((0.5 * area - wanted).abs() < 1e-12, "{k}: {area}");
            count += triangles.len();
        }
        assert_eq!(count, 200 * (74 * 4 - 2 + 2 * 73));
    }

    #[test]
    fn islands_may_fill_the_hole_around_them() {
        // The hole with a corner more, which the island has not.
        let island = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let hole = [
            [-1.0, -1.0],
            [-1.0, 1.0],
            [1.0, 1.0],
            [1.0, 0.25],
            [1.0, -1.0],
        ];
        for turns in 0..4 {
            let [mut island, mut hole] = [island.to_vec(), hole.to_vec()];
            island.rotate_left(turns);
            hole.rotate_left(turns);
            let corners = |first, corners: &[[f64; 2]]| -> Vec<Named> {
                (first..)
                    .zip(corners)
                    .map(|(name, &p)| (p.into(), name))
                    .collect()
            };
            let found = area(&[square(2.0), corners(4, &hole), corners(9, &island)]);
            assert!((found - 16.0).abs() < 1e-12, "{turns}: {found}");
        }
    }

    #[test]
    fn islands_may_touch_the_hole_around_them() {
        let hole = [
            [-1.0, 0.0],
            [-1.0, 1.0],
            [1.0, 1.0],
            [1.0, 0.0],
            [1.0, -1.0],
            [-1.0, -1.0],
        ];
        let island = [[-1.0, 0.0], [0.0, -0.5], [1.0, 0.0], [0.0, 0.5]];
        for turns in 0..6 {
            let mut hole = hole;
            hole.rotate_left(turns);
            let found = area(&[square(2.0), named(4, hole), named(10, island)]);
            assert!((found - 13.0).abs() < 1e-12, "{turns}: {found}");
        }
    }
}
