//! The bounding box of a solid, from its program alone.
//!
//! First infinity: a point far away is s (±1, u, v) (or with another axis
//! first) with |u|, |v| <= 1, and f / s² of a quadric, f / s of a plane, is a
//! polynomial of second degree in u, v and w = 1/s. Those are quadrics again,
//! on a finite box: the same pruning proves the solid empty there, or finds a
//! direction in which it goes on. Then branch and bound from the finite box
//! that is left, inwards.

use glam::DVec3;

use super::Program;
use super::cell::{Cell, Descend, Descent, Pruner, Visitor, octant_offset};
use super::surface::{Side, Surface};
use crate::error::Error;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least corner.
    pub min: DVec3,
    /// Greatest corner.
    pub max: DVec3,
}

impl Bounds {
    /// The middle.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// The side lengths.
    #[must_use]
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    fn around(center: DVec3, half: DVec3) -> Self {
        Self {
            min: center - half,
            max: center + half,
        }
    }

    fn united(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    fn encloses(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }
}

/// Levels of splitting in the last, finest round: each side of the result is
/// off by at most about 2⁻⁸ of the box.
const FINE_LEVELS: usize = 9;
/// Levels in the rounds before, which only bring the box near.
const COARSE_LEVELS: usize = 5;
/// How often the neighbourhood of infinity is halved before a solid that is
/// still there counts as unbounded.
const INFINITY_LEVELS: usize = 12;

impl Program {
    /// A box that encloses the solid, on each side at most about 1/256 of its
    /// size too large; `None` if the solid is proven empty.
    ///
    /// # Errors
    /// [`Error::Unbounded`] if the solid reaches infinitely far.
    pub fn bounds(&self) -> Result<Option<Bounds>, Error> {
        let root = self.root_cell();
        match root.constant() {
            Some(false) => return Ok(None),
            Some(true) => return Err(unbounded(DVec3::X)),
            None => {}
        }
        // The middle of the anchors: near the solid, wherever that is.
        let first = self.surfaces[0].anchor();
        let (low, high) = self.surfaces.iter().fold((first, first), |(low, high), s| {
            (low.min(s.anchor()), high.max(s.anchor()))
        });
        let origin = 0.5 * low + 0.5 * high;
        let surfaces = self.surfaces_about(origin);
        let guess = surfaces
            .iter()
            .map(|s| s.anchor.abs().max_element() + s.constant.abs().sqrt() + s.extent_of_slope())
            .fold(0.0, f64::max);
        let guess = if guess > 0.0 { 2.0 * guess } else { 1.0 };
        let radius = finite_radius(&surfaces, &root, guess)?;

        let mut descent = Descent::new(&surfaces);
        let mut current = Bounds::around(DVec3::ZERO, DVec3::splat(radius));
        // Each coarse round shrinks the box up to 32-fold; f64 has room for
        // fewer than 300 of them.
        for _ in 0..300 {
            let Some(next) = hull(&mut descent, &root, current, COARSE_LEVELS) else {
                return Ok(None);
            };
            let shrunk = next.size().cmplt(current.size() * 0.7).any();
            current = next;
            if !shrunk {
                break;
            }
        }
        let hull = hull(&mut descent, &root, current, FINE_LEVELS);
        Ok(hull.map(|bounds| Bounds {
            min: bounds.min + origin,
            max: bounds.max + origin,
        }))
    }
}

fn unbounded(direction: DVec3) -> Error {
    Error::Unbounded {
        direction: direction.normalize_or(DVec3::X).to_array(),
    }
}

impl Surface {
    /// How far a quadric's linear part moves its extrema.
    fn extent_of_slope(&self) -> f64 {
        if self.is_plane() {
            0.0
        } else {
            self.linear.abs().max_element()
        }
    }
}

/// A surface near infinity, on one face of the cube of directions: f / s² (or
/// f / s for planes) in the coordinates (u, v, w = 1/s).
struct AtInfinity {
    surface: Surface,
    /// For quadrics whose quadratic form has no negative (positive) values:
    /// where (f - form) / s is positive (negative), so is f, although f / s²
    /// comes to zero at infinity.
    definite: Option<(Side, Surface)>,
}

impl AtInfinity {
    /// `axis` is the coordinate that is ±s; the other two follow cyclically.
    fn new(surface: &Surface, axis: usize, sign: f64) -> Self {
        let (i, j, k) = (axis, (axis + 1) % 3, (axis + 2) % 3);
        let squares = [0, 1, 2].map(|n| surface.quadratic[n]);
        // The coefficient of the product of coordinates a and b.
        let cross = |a: usize, b: usize| match (a.min(b), a.max(b)) {
            (0, 1) => surface.quadratic[3],
            (1, 2) => surface.quadratic[4],
            _ => surface.quadratic[5],
        };
        let (linear, constant) = surface.expanded_about(DVec3::ZERO);
        if surface.is_plane() {
            return Self {
                surface: Surface {
                    anchor: DVec3::ZERO,
                    quadratic: [0.0; 6],
                    linear: DVec3::new(linear[j], linear[k], constant),
                    constant: sign * linear[i],
                },
                definite: None,
            };
        }
        let definite = definiteness(surface).map(|side| {
            let rest = Surface {
                anchor: DVec3::ZERO,
                quadratic: [0.0; 6],
                linear: DVec3::new(linear[j], linear[k], constant),
                constant: sign * linear[i],
            };
            (side, rest)
        });
        Self {
            surface: Surface {
                anchor: DVec3::ZERO,
                quadratic: [
                    squares[j],
                    squares[k],
                    constant,
                    cross(j, k),
                    linear[k],
                    linear[j],
                ],
                linear: DVec3::new(sign * cross(i, j), sign * cross(i, k), sign * linear[i]),
                constant: squares[i],
            },
            definite,
        }
    }

    fn side(&self, center: DVec3, half: DVec3) -> Side {
        let side = self.surface.side_of_box(center, half);
        match &self.definite {
            Some((definite, rest)) if side == Side::Crossing => {
                if rest.side_of_box(center, half) == *definite {
                    *definite
                } else {
                    side
                }
            }
            _ => side,
        }
    }
}

/// The side on which the quadratic form alone never crosses zero: outside if
/// it is positive semidefinite, inside if negative. By the signs of the
/// principal minors, allowing for their rounding.
fn definiteness(surface: &Surface) -> Option<Side> {
    let test = |q: [f64; 6]| {
        let [xx, yy, zz, xy, yz, zx] = q;
        let minor = |a: f64, b: f64, c: f64| a * b - 0.25 * c * c;
        let determinant = xx * minor(yy, zz, yz) - 0.5 * xy * (0.5 * xy * zz - 0.25 * yz * zx)
            + 0.5 * zx * (0.25 * xy * yz - 0.5 * yy * zx);
        let least = xx
            .min(yy)
            .min(zz)
            .min(minor(xx, yy, xy))
            .min(minor(yy, zz, yz))
            .min(minor(zz, xx, zx))
            .min(determinant);
        // Coefficients are at most 1, so their products are this exact.
        least >= -64.0 * f64::EPSILON
    };
    if test(surface.quadratic) {
        Some(Side::Outside)
    } else if test(surface.quadratic.map(|q| -q)) {
        Some(Side::Inside)
    } else {
        None
    }
}

/// A radius around the origin beyond which the solid is empty, at least
/// `guess`.
fn finite_radius(surfaces: &[Surface], root: &Cell, guess: f64) -> Result<f64, Error> {
    let mut radius = guess;
    let mut pruner = Pruner::default();
    let mut sides = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let face: Vec<AtInfinity> = surfaces
                .iter()
                .map(|surface| AtInfinity::new(surface, axis, sign))
                .collect();
            let half_w = 0.5 / guess;
            let center = DVec3::new(0.0, 0.0, half_w);
            let mut pending = vec![(center, DVec3::new(1.0, 1.0, half_w), 0, root.clone())];
            while let Some((center, half, level, parent)) = pending.pop() {
                sides.clear();
                let ids = parent.surfaces.iter();
                sides.extend(ids.map(|&id| face[id as usize].side(center, half)));
                let mut cell = Cell::default();
                parent.restrict_into(&sides, &mut pruner, &mut cell);
                if cell.constant() == Some(false) {
                    continue;
                }
                let nearest_w = center.z - half.z;
                if nearest_w > 0.0 {
                    radius = radius.max(1.0 / nearest_w);
                } else if cell.constant() == Some(true) || level == INFINITY_LEVELS {
                    let mut direction = DVec3::ZERO;
                    direction[axis] = sign;
                    direction[(axis + 1) % 3] = center.x;
                    direction[(axis + 2) % 3] = center.y;
                    return Err(unbounded(direction));
                } else {
                    let half = half * 0.5;
                    for octant in 0..8 {
                        let center = center + octant_offset(octant) * half;
                        pending.push((center, half, level + 1, cell.clone()));
                    }
                }
            }
        }
    }
    Ok(radius)
}

/// The hull of those boxes, `levels` halvings below `start`, that are not
/// proven empty.
fn hull(descent: &mut Descent<'_>, root: &Cell, start: Bounds, levels: usize) -> Option<Bounds> {
    struct Search {
        found: Option<Bounds>,
        levels: usize,
    }
    impl Visitor for Search {
        fn wants(&mut self, center: DVec3, half: DVec3) -> bool {
            let bounds = Bounds::around(center, half);
            self.found.is_none_or(|found| !found.encloses(&bounds))
        }

        fn visit(&mut self, center: DVec3, half: DVec3, level: usize, cell: &Cell) -> Descend {
            match cell.constant() {
                Some(false) => Descend::Stop,
                None if level < self.levels => Descend::Split,
                _ => {
                    let bounds = Bounds::around(center, half);
                    self.found = Some(self.found.map_or(bounds, |found| found.united(bounds)));
                    Descend::Stop
                }
            }
        }
    }
    let mut search = Search {
        found: None,
        levels,
    };
    descent.run(root, start.center(), 0.5 * start.size(), &mut search);
    search.found
}
