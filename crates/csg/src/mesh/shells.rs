//! Closed surfaces of triangles beside each other: which of their triangles are near another
//! one, what is near a box, and what is inside.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::box_tree::{Bounds, BoxTree, Boxed, along_curve};
use super::predicates::{flat, turn};
use crate::elementary;

/// Closed surfaces, numbered, and a tree of the boxes around their triangles.
#[derive(Debug)]
pub(crate) struct Shells {
    /// The corners of all triangles, shell by shell.
    corners: Vec<[DVec3; 3]>,
    /// Where each shell begins, and where the last one ends.
    first_of: Vec<usize>,
    bounds: Vec<Bounds>,
    /// Of the boxes around triangles, and around shells.
    tree: BoxTree,
    shell_tree: BoxTree,
}

/// Where a line crosses a shell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShellCrossing {
    pub shell: u32,
    /// The coordinate along the line.
    pub at: f64,
}

impl Shells {
    /// Of the corners of each shell's triangles, counter-clockwise seen from outside. Boxes
    /// exceed triangles by a margin. Takes n log n steps for n triangles.
    pub fn new<T: IntoIterator<Item = [DVec3; 3]>>(
        shells: impl IntoIterator<Item = T>,
        margin: f64,
    ) -> Self {
        let mut corners = Vec::new();
        let mut first_of = vec![0];
        for shell in shells {
            corners.extend(shell);
            first_of.push(corners.len());
        }
        let boxed = |shell: usize| {
            let own = first_of[shell]..first_of[shell + 1];
            let boxes: Vec<Bounds> = corners[own].iter().map(|c| grown(c, margin)).collect();
            let order = along_curve(boxes.iter().copied());
            (boxes, order)
        };
        let count = first_of.len() - 1;
        let boxed: Vec<_> = (0..count).into_par_iter().map(boxed).collect();
        let around = |(boxes, _): &(Vec<Bounds>, _)| Bounds::around_all(boxes.iter().copied());
        let bounds: Vec<Bounds> = boxed.iter().map(around).collect();
        let mut entries = Vec::with_capacity(corners.len());
        let mut shell_entries = Vec::with_capacity(count);
        for sheet in along_curve(bounds.iter().copied()) {
            shell_entries.push(Boxed {
                bounds: bounds[sheet as usize],
                index: sheet,
                sheet,
                stands: 0,
            });
            let first = first_of[sheet as usize] as u32;
            let (boxes, order) = &boxed[sheet as usize];
            entries.extend(order.iter().map(|&k| Boxed {
                bounds: boxes[k as usize],
                index: first + k,
                sheet,
                stands: 0,
            }));
        }
        Self {
            corners,
            first_of,
            bounds,
            tree: BoxTree::new(entries),
            shell_tree: BoxTree::new(shell_entries),
        }
    }

    /// The box around a triangle, with the margin.
    pub fn box_of(&self, triangle: usize, margin: f64) -> [DVec3; 2] {
        let Bounds { low, high } = grown(&self.corners[triangle], margin);
        [low, high]
    }

    /// The numbers of a shell's triangles.
    pub fn triangles_of(&self, shell: usize) -> std::ops::Range<usize> {
        self.first_of[shell]..self.first_of[shell + 1]
    }

    /// The shell of a triangle.
    pub fn shell_of(&self, triangle: u32) -> usize {
        self.first_of
            .partition_point(|&first| first <= triangle as usize)
            - 1
    }

    /// The triangles of different shells whose boxes overlap, the lower first.
    pub fn pairs(&self) -> Vec<[u32; 2]> {
        if self.bounds.len() < 2 {
            return Vec::new();
        }
        self.tree.pairs(&|_, _| true, &|| ())
    }

    /// Whether a box overlaps that of a triangle of another shell than one, of those that pass
    /// a test.
    pub fn has_other(
        &self,
        shell: u32,
        [low, high]: [DVec3; 2],
        test: impl Fn(u32) -> bool,
    ) -> bool {
        self.bounds.len() > 1
            && self
                .tree
                .any_overlapping(Some(shell), &Bounds { low, high }, &mut { test })
    }

    /// Whether a box overlaps that of a triangle of a shell.
    pub fn meets(&self, shell: u32, [low, high]: [DVec3; 2]) -> bool {
        let own = self.triangles_of(shell as usize);
        let mut is_own = |index: u32| own.contains(&(index as usize));
        self.tree
            .any_overlapping(None, &Bounds { low, high }, &mut is_own)
    }

    /// Tells of all shells that a point off them is inside of.
    pub fn around(&self, point: DVec3, tell: &mut impl FnMut(u32)) {
        let here = Bounds {
            low: point,
            high: point,
        };
        self.shell_tree.overlapping(&here, &mut |shell| {
            if self.contains(shell, point) {
                tell(shell);
            }
        });
    }

    /// Whether a point off a shell is inside of it.
    pub fn contains(&self, shell: u32, point: DVec3) -> bool {
        let bounds = &self.bounds[shell as usize];
        if point.cmplt(bounds.low).any() || point.cmpgt(bounds.high).any() {
            return false;
        }
        let known = (0..3).find_map(|axis| self.count_above(shell, axis, point));
        known.map_or_else(|| self.winding(shell, point) > 0.5, |count| count > 0)
    }

    /// How often a shell is left, less how often it is entered, on the way from a point along
    /// an axis; none where that leads through an edge.
    fn count_above(&self, shell: u32, axis: usize, point: DVec3) -> Option<i32> {
        let own = self.triangles_of(shell as usize);
        self.count_of(|index| own.contains(&(index as usize)), axis, point)
    }

    /// The same of those triangles that pass a test.
    fn count_of(&self, test: impl Fn(u32) -> bool, axis: usize, point: DVec3) -> Option<i32> {
        let mut beyond = point;
        beyond[axis] = f64::INFINITY;
        let way = Bounds {
            low: point,
            high: beyond,
        };
        let mut count = Some(0);
        self.tree.overlapping(&way, &mut |index| {
            if !test(index) {
                return;
            }
            match cross(&self.corners[index as usize], axis, point) {
                Crossed::Edge => count = None,
                Crossed::At(at, step) if at > point[axis] => {
                    count = count.map(|count| count - step);
                }
                Crossed::Beside | Crossed::At(..) => {}
            }
        });
        count
    }

    /// How often a shell winds around a point.
    fn winding(&self, shell: u32, point: DVec3) -> f64 {
        let own = self.corners[self.triangles_of(shell as usize)].iter();
        own.map(|corners| turns(corners, point)).sum()
    }

    /// Whether those triangles that pass a test, of all shells, wind around a point off them.
    pub fn is_within(&self, point: DVec3, test: impl Fn(u32) -> bool) -> bool {
        let told = (0..3).find_map(|axis| self.count_of(&test, axis, point));
        told.map_or_else(
            || {
                let all = (0..).zip(&self.corners);
                let meant = all.filter(|&(index, _)| test(index));
                meant.map(|(_, corners)| turns(corners, point)).sum::<f64>() > 0.5
            },
            |count| count > 0,
        )
    }

    /// Whether all triangles wind not once around what is right before one of them, and once
    /// around what is right behind it.
    pub fn has_outside_before(&self, triangle: u32) -> bool {
        let own = &self.corners[triangle as usize];
        let middle = own.iter().sum::<DVec3>() / 3.0;
        let normal = (own[1] - own[0]).cross(own[2] - own[0]);
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| normal[b].abs().total_cmp(&normal[a].abs()));
        let others = |index: u32| index != triangle;
        let told = axes.into_iter().filter(|&axis| normal[axis] != 0.0);
        let told = told.into_iter().find_map(|axis| {
            let count = self.count_of(others, axis, middle)?;
            Some(count == i32::from(normal[axis] < 0.0))
        });
        told.unwrap_or_else(|| {
            let all = (0..).zip(&self.corners);
            let others = all.filter(|&(index, _)| others(index));
            let turns: f64 = others.map(|(_, corners)| turns(corners, middle)).sum();
            // Midway between both sides.
            (turns - 0.5).abs() < 0.25
        })
    }

    /// Where the line through a point along an axis crosses all shells, shell by shell; what it
    /// meets in edges alone may be missing.
    pub fn along_line(&self, axis: usize, through: DVec3) -> Vec<ShellCrossing> {
        let (mut low, mut high) = (through, through);
        low[axis] = f64::NEG_INFINITY;
        high[axis] = f64::INFINITY;
        let mut found = Vec::new();
        self.tree.overlapping(&Bounds { low, high }, &mut |index| {
            if let Crossed::At(at, _) = cross(&self.corners[index as usize], axis, through) {
                found.push(ShellCrossing {
                    shell: self.shell_of(index) as u32,
                    at,
                });
            }
        });
        found.sort_unstable_by_key(|crossing| crossing.shell);
        found
    }
}

/// The solid angle under which a triangle is seen, of the whole around (A. Van Oosterom,
/// J. Strackee, "The Solid Angle of a Plane Triangle", 1983).
pub(crate) fn turns(corners: &[DVec3; 3], point: DVec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - point);
    let [x, y, z] = [a, b, c].map(DVec3::length);
    let across = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
    elementary::atan2(a.dot(b.cross(c)), across) / TAU
}

fn grown(corners: &[DVec3; 3], by: f64) -> Bounds {
    let Bounds { low, high } = Bounds::around(corners);
    Bounds {
        low: low - by,
        high: high + by,
    }
}

/// What a line does to a triangle.
enum Crossed {
    Beside,
    Edge,
    /// The coordinate along the line, and 1 where that goes in, -1 where it goes out.
    At(f64, i32),
}

/// Where the line through a point along an axis crosses a triangle.
fn cross(corners: &[DVec3; 3], axis: usize, through: DVec3) -> Crossed {
    let [a, b, c] = corners.map(|corner| flat(corner, axis));
    let point = flat(through, axis);
    let turns = [[a, b, point], [b, c, point], [c, a, point]].map(turn);
    let (least, most) = (
        turns.into_iter().min().unwrap_or(0),
        turns.into_iter().max().unwrap_or(0),
    );
    match (least, most) {
        (-1, 1) => Crossed::Beside,
        (-1, -1) | (1, 1) => {
            let area = |p: DVec2, q: DVec2| (p - point).perp_dot(q - point);
            let weights = DVec3::new(area(b, c), area(c, a), area(a, b));
            let heights = DVec3::from_array(corners.map(|corner| corner[axis]));
            let at = (weights / weights.element_sum()).dot(heights);
            Crossed::At(at, i32::from(-least))
        }
        // Seen from its edge, or met there.
        _ => Crossed::Edge,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::boxes;

    fn cuboid(low: DVec3, high: DVec3) -> Vec<[DVec3; 3]> {
        let mesh = boxes::cuboid(low, high);
        (0..mesh.triangles.len()).map(|k| mesh.corners(k)).collect()
    }

    /// Points of a grid, many of which are in line with edges and vertices.
    #[test]
    fn points_are_inside_by_coordinates() {
        let boxes = [[0.0, 1.0], [0.25, 0.75], [2.0, 3.0]];
        let of = |[low, high]: [f64; 2]| cuboid(DVec3::splat(low), DVec3::splat(high));
        let shells = Shells::new(boxes.map(of), 1e-9);
        let mut counts = [0; 3];
        for index in 0..14_usize.pow(3) {
            let at = [index % 14, index / 14 % 14, index / 196].map(|k| 0.25 * k as f64 - 0.125);
            let middle = DVec3::from_array(at);
            // In the middle of cells, and on lines of the grid.
            for point in [middle, middle - DVec3::new(0.125, 0.125, 0.0)] {
                let mut found = Vec::new();
                shells.around(point, &mut |shell| found.push(shell));
                for (shell, [low, high]) in (0..).zip(boxes) {
                    let is_off = |sides: DVec3| sides.abs().min_element() > 1e-6;
                    if is_off(point - low) && is_off(point - high) {
                        let is_inside = point.cmpgt(DVec3::splat(low)).all()
                            && point.cmplt(DVec3::splat(high)).all();
                        assert_eq!(shells.contains(shell, point), is_inside, "{shell} {point}");
                        assert_eq!(found.contains(&shell), is_inside, "{shell} {point}");
                        counts[shell as usize] += usize::from(is_inside);
                    }
                }
            }
        }
        assert!(counts.iter().all(|&count| count > 7), "{counts:?}");
    }

    #[test]
    fn a_point_in_line_with_edges_is_told_by_the_solid_angle() {
        let shells = Shells::new([cuboid(DVec3::splat(-1.0), DVec3::ONE)], 0.0);
        // All three axes lead through diagonals of faces.
        assert!((0..3).all(|axis| shells.count_above(0, axis, DVec3::ZERO).is_none()));
        assert!(shells.contains(0, DVec3::ZERO));
        let outside = shells.winding(0, DVec3::new(1.5, 0.0, 0.0));
        assert!(outside.abs() < 1e-12, "{outside}");
    }

    #[test]
    fn lines_cross_shells_where_these_are() {
        let shells = [
            cuboid(DVec3::ZERO, DVec3::ONE),
            cuboid(DVec3::splat(0.5), DVec3::splat(2.0)),
        ];
        let shells = Shells::new(shells, 0.0);
        for axis in 0..3 {
            let through = DVec3::new(0.61, 0.73, 0.9);
            let found = shells.along_line(axis, through);
            let of = |shell: u32| {
                let own = found.iter().filter(|crossing| crossing.shell == shell);
                let mut places: Vec<f64> = own.map(|crossing| crossing.at).collect();
                places.sort_by(f64::total_cmp);
                places
            };
            for (shell, truth) in [(0, [0.0, 1.0]), (1, [0.5, 2.0])] {
                let places = of(shell);
                assert_eq!(places.len(), 2);
                assert!(
                    (0..2).all(|k| (places[k] - truth[k]).abs() < 1e-12),
                    "{places:?}"
                );
            }
        }
        // Of the faces at the far corner of the one, and at the near corner of the other.
        let pairs = shells.pairs();
        assert!(!pairs.is_empty() && pairs.len() < 144, "{}", pairs.len());
        assert!(
            pairs
                .iter()
                .all(|&[a, b]| shells.shell_of(a) == 0 && shells.shell_of(b) == 1)
        );
    }
}
