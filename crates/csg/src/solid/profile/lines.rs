//! The lines that sides of outlines lie on.

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::{Profile, Shape, Step};
use crate::mesh::box_tree::{Bounds, BoxTree};
use crate::numeric::tolerance::IN_PROFILE;

/// For straight sides of an outline that are pieces of longer ones: these. Where a piece is short its
/// ends tell its direction badly.
#[derive(Debug, Default)]
pub(crate) struct Lines(FxHashMap<[u64; 4], [DVec2; 2]>);

impl Lines {
    fn key(from: DVec2, to: DVec2) -> [u64; 4] {
        [from.x, from.y, to.x, to.y].map(f64::to_bits)
    }

    pub(super) fn insert(&mut self, [from, to]: [DVec2; 2], line: [DVec2; 2]) {
        self.0.insert(Self::key(from, to), line);
    }

    /// Two points on the line from one corner to the next, which follow each other as these do.
    pub(crate) fn of(&self, from: DVec2, to: DVec2) -> [DVec2; 2] {
        let known = self.0.get(&Self::key(from, to)).copied();
        let back = || self.0.get(&Self::key(to, from)).map(|&[a, b]| [b, a]);
        known.or_else(back).unwrap_or([from, to])
    }
}

impl Profile {
    /// What the sides of its contours are pieces of, if it has no arcs.
    pub(crate) fn lines(&self, contours: &[Vec<DVec2>]) -> Lines {
        let given = self.straight_sides();
        let points = given.iter().flatten();
        let reach = points.fold(0.0_f64, |most, p| p.abs().max_element().max(most));
        let slack = IN_PROFILE * reach;
        let boxes = given.iter().map(|&[a, b]| Bounds {
            low: (a.min(b) - slack).extend(0.0),
            high: (a.max(b) + slack).extend(0.0),
        });
        let boxes: Vec<Bounds> = boxes.collect();
        let tree = BoxTree::numbered(&boxes);
        let mut lines = Lines::default();
        for contour in contours {
            for (&from, &to) in contour.iter().zip(contour.iter().cycle().skip(1)) {
                let own = from.distance(to);
                let mut longest: Option<([DVec2; 2], f64)> = None;
                let look = |index: u32| {
                    let [a, b] = given[index as usize];
                    let length = a.distance(b);
                    let across = (b - a).perp() / length;
                    let is_on = |p: DVec2| (p - a).dot(across).abs() <= slack;
                    let is_longer = longest.is_none_or(|(_, most)| length > most);
                    if length > own + slack && is_longer && is_on(from) && is_on(to) {
                        longest = Some(([a, b], length));
                    }
                    false
                };
                let [low, high] = [from.min(to), from.max(to)].map(|corner| corner.extend(0.0));
                tree.any_overlapping(None, &Bounds { low, high }, &mut { look });
                if let Some(([a, b], _)) = longest {
                    let is_same_way = (b - a).dot(to - from) > 0.0;
                    lines.insert([from, to], if is_same_way { [a, b] } else { [b, a] });
                }
            }
        }
        lines
    }

    /// The sides of all its leaves, as if there were no arcs.
    fn straight_sides(&self) -> Vec<[DVec2; 2]> {
        let mut sides = Vec::new();
        for step in &self.steps {
            let Step::Shape(Shape::Contours(contours, _), map) = step else {
                continue;
            };
            for contour in contours.iter() {
                let corners = contour
                    .iter()
                    .map(|corner| map.transform_point2(corner.point));
                let next = corners.clone().cycle().skip(1);
                sides.extend(
                    corners
                        .zip(next)
                        .filter(|(a, b)| a != b)
                        .map(<[DVec2; 2]>::from),
                );
            }
        }
        sides
    }
}
