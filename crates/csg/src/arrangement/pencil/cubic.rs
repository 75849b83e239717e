//! Quadrics that have a line in common: they meet else in a twisted cubic.

use glam::{DMat4, DVec3, DVec4};
use smallvec::{SmallVec, smallvec};

use super::{Pencil, across, within};
use crate::arrangement::curve::{Branch, Branches, Curve};
use crate::arrangement::intersection::Unknown;
use crate::arrangement::roots::Roots;
use crate::arrangement::rulings::{Lines, Part, Round};
use crate::arrangement::trig::BEGIN;
use crate::elementary;
use crate::numeric::tolerance::{AT_INFINITY, CANCELLED};
use std::f64::consts::PI;

impl Pencil<'_> {
    /// The line through two points that is on both quadrics, and the cubic.
    ///
    /// The line is on all quadrics of the pencil, so that those of them that are not singular have
    /// two families of lines. Those of the other family meet it, in q, and besides one point of
    /// the cubic each. They go from q(φ) to p(φ) on another line of its family, in the plane
    /// through it at the angle φ: all of them for φ from 0 to π.
    pub(super) fn beside_line(&self, points: [DVec4; 2]) -> Result<Branches, Unknown> {
        let start = points[0].normalize();
        let end = (points[1] - points[1].dot(start) * start).normalize();
        let (member, other) = self.farthest_from_singular();
        let lines = other_family(&member, [start, end]);
        let lines = by_planes(&member, &lines, [start, end])?;
        let form = lines.form(&other);
        if form.b.magnitude() <= CANCELLED {
            return Err(Unknown::NoForm);
        }
        // There the cubic meets the line.
        let mut roots = Roots::default();
        form.b.roots(CANCELLED * form.b.magnitude(), &mut roots);
        let angles = roots.simple.iter().chain(&roots.touching);
        let nodes: SmallVec<[f64; 4]> = angles.map(|angle| angle - BEGIN).collect();
        let cubic = self.rulings(&lines, &form, (Part::Once, None)).parts();
        // At infinity once or three times, and all of it twice for a whole turn.
        if cubic.len() % 4 != 2 {
            return Err(Unknown::NoForm);
        }
        let half = cubic.len() / 2;
        let mut branches: Branches = cubic
            .into_iter()
            .take(half)
            .map(|piece| Branch {
                nodes: within(&nodes, piece.between),
                curve: Curve::Rulings(Box::new(piece)),
            })
            .collect();
        if let Some((point, direction)) = finite([start, end]) {
            let line = Curve::Line {
                point: self.place(point),
                direction,
            };
            let mut places: SmallVec<[f64; 2]> = smallvec![];
            for node in within(&nodes, Some((0.0, PI))) {
                let (sin, cos) = elementary::sin_cos(node + BEGIN);
                let at = cos * lines.q[1] + sin * lines.q[2];
                if at.w.abs() > AT_INFINITY {
                    places.extend(line.place(self.place(at)));
                }
            }
            branches.push(Branch {
                curve: line,
                nodes: places,
            });
        }
        Ok(branches)
    }

    /// Of some quadrics of the pencil the one with the largest determinant, and another one.
    fn farthest_from_singular(&self) -> (DMat4, DMat4) {
        const SAMPLES: u32 = 16;
        let member = |k: u32| {
            let (sin, cos) = elementary::sin_cos(PI * f64::from(k) / f64::from(SAMPLES));
            (self.combined([cos, sin]), self.combined([-sin, cos]))
        };
        let size = |(matrix, _): &(DMat4, DMat4)| matrix.determinant().abs();
        let members = (0..SAMPLES).map(member);
        let largest = members.reduce(|a, b| if size(&b) > size(&a) { b } else { a });
        largest.unwrap_or_else(|| member(0))
    }
}

/// The lines on a quadric that meet one of its lines, given by two of its points.
fn other_family(quadric: &DMat4, line: [DVec4; 2]) -> Lines {
    let polars = line.map(|point| *quadric * point);
    // In the tangent plane of each of the two points a point that is not on the line, brought
    // onto the quadric along it.
    let [b, d] = [0, 1].map(|k| {
        let aside = across([polars[k], line[0], line[1]]);
        let square = aside.dot(*quadric * aside);
        aside - 0.5 * square / aside.dot(polars[1 - k]) * line[1 - k]
    });
    // Of the line through the second of them and its point that where the line through the first
    // meets it that does not meet the given one.
    let across = b.dot(polars[1]);
    let d = d - b.dot(*quadric * d) / across * line[1];
    let factor = -across / d.dot(polars[0]);
    Lines {
        p: [DVec4::ZERO, b, factor * d],
        q: [DVec4::ZERO, line[0], line[1]],
    }
}

/// The point of a line that is nearest to the origin, and its direction; none of a line at
/// infinity.
fn finite([start, end]: [DVec4; 2]) -> Option<(DVec4, DVec3)> {
    let point = start.w * start + end.w * end;
    let direction = (end.w * start - start.w * end).truncate();
    (point.w > AT_INFINITY).then(|| (point, direction.normalize_or_zero()))
}

/// The same lines of a quadric, each by the angle of the plane through it and the given line.
fn by_planes(quadric: &DMat4, lines: &Lines, line: [DVec4; 2]) -> Result<Lines, Unknown> {
    // The tangent plane where it meets the given line, from which a normal in space tells its
    // angle.
    let (_, direction) = finite(line).ok_or(Unknown::NoForm)?;
    let (x, y) = direction.any_orthonormal_pair();
    let normals = line.map(|point| (*quadric * point).truncate());
    let [a, b] = normals.map(|normal| [normal.dot(x), normal.dot(y)]);
    let determinant = a[0] * b[1] - a[1] * b[0];
    // The inverse of the map from an angle on the line to that of the plane.
    let turned = |&[one, start, end]: &Round| {
        [
            one,
            (b[1] * start - a[1] * end) / determinant,
            (a[0] * end - b[0] * start) / determinant,
        ]
    };
    let lines = Lines {
        p: turned(&lines.p),
        q: turned(&lines.q),
    };
    let is_finite = lines.p.iter().all(|vector| vector.is_finite());
    if is_finite {
        Ok(lines)
    } else {
        Err(Unknown::NoForm)
    }
}
