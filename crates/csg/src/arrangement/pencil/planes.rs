//! Quadrics of a pencil that are pairs of planes: in them the curves are conics.

use crate::elementary;
use glam::{DMat4, DVec3, DVec4};
use smallvec::SmallVec;

use super::Pencil;
use super::conics::conics;
use crate::arrangement::conic::FAR;
use crate::arrangement::curve::Branches;
use crate::arrangement::intersection::{Unknown, line};
use crate::numeric::jacobi;
use crate::numeric::tolerance::{AT_INFINITY, CANCELLED};
use crate::program::Surface;

impl Pencil<'_> {
    /// The curves in a quadric of the pencil that is a pair of planes, if it is:
    /// of real ones, or of complex ones, which have a line in common that may meet
    /// the surfaces in two contacts.
    pub(super) fn on_planes(&self, angle: f64) -> Option<Result<Branches, Unknown>> {
        /// The same of a pair of planes before its angle is refined.
        const NEARLY: f64 = 1e-4;
        let (sin, cos) = elementary::sin_cos(angle);
        let (values, vectors) = eigenvectors(&self.combined([cos, sin]));
        if values[2].abs() > NEARLY * values[0].abs() {
            return None;
        }
        // The one that vanishes on the eigenvectors of the values next to 0: a step of
        // Rayleigh's quotient iteration.
        let [x, y] = self.matrices.map(|matrix| {
            let on = |v: DVec4| v.dot(matrix * v);
            on(vectors[2]) + on(vectors[3])
        });
        let length = elementary::hypot(x, y);
        let factors = match length > NEARLY {
            true => [y / length, -x / length],
            false => [cos, sin],
        };
        let (values, vectors) = eigenvectors(&self.combined(factors));
        let nothing = self.nothing(CANCELLED, factors);
        let is_null = |value: f64| value.abs() <= nothing * values[0].abs();
        if !is_null(values[2]) {
            return None;
        }
        let [p, q] = [0, 1].map(|k| values[k].abs().sqrt() * vectors[k]);
        if is_null(values[1]) {
            return Some(self.in_planes(&[p]));
        }
        if values[0] * values[1] < 0.0 {
            return Some(self.in_planes(&[p + q, p - q]));
        }
        let [x, y] = [vectors[2], vectors[3]];
        let matrix = self.matrices[0];
        let [xx, xy, yy] = [x.dot(matrix * x), x.dot(matrix * y), y.dot(matrix * y)];
        // xx c² + 2 xy c s + yy s² = 0: (xx + yy) / 2 + r cos(2 t - phase).
        let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let (radius, phase) = (elementary::hypot(half, xy), elementary::atan2(xy, half));
        if mean.abs().max(radius) <= CANCELLED {
            return Some(Err(Unknown::NoForm));
        }
        if mean.abs() > radius {
            return Some(Ok(Branches::new()));
        }
        let swing = elementary::acos(-mean / radius);
        let at = |doubled: f64| {
            let (sin, cos) = elementary::sin_cos(0.5 * doubled);
            self.place(cos * x + sin * y)
        };
        let contacts = [phase + swing, phase - swing].map(at);
        let contacts = contacts.into_iter().filter(|at| at.is_finite()).collect();
        Some(Err(Unknown::Touch(contacts)))
    }

    /// The conics in planes, with nodes where these meet.
    pub(super) fn in_planes(&self, planes: &[DVec4]) -> Result<Branches, Unknown> {
        let plane = |&vector: &DVec4| {
            let normal = vector.truncate();
            let square = normal.length_squared();
            // Not at infinity.
            (square > AT_INFINITY * AT_INFINITY * vector.length_squared()).then(|| {
                Surface::plane(
                    self.origin - self.unit * vector.w / square * normal,
                    normal / square.sqrt(),
                )
            })
        };
        let planes: SmallVec<[Surface; 2]> = planes.iter().filter_map(plane).collect();
        let quadric = self.surfaces[0];
        let mut nodes: SmallVec<[DVec3; 2]> = SmallVec::new();
        if let [p, q] = planes.as_slice()
            && let Some(line) = line(p, q)
        {
            let start = line.at(0.0);
            let direction = line.direction(0.0);
            let a = 0.5 * quadric.curvature_along(direction);
            let vertex = -0.5 * quadric.gradient(start).dot(direction) / a;
            // About where the line runs along the quadric, for the sake of digits. One of the
            // planes touches the quadric if the line does.
            let middle = line.at(vertex);
            let lowest = quadric.value(middle);
            let half = (-lowest / a).sqrt();
            let touches = lowest.abs() <= self.nearness.touch * quadric.gradient(middle).length();
            let places: &[f64] = if touches { &[0.0] } else { &[half, -half] };
            let places = places.iter().map(|off| middle + off * direction);
            let far = FAR * self.nearness.scene();
            nodes.extend(places.filter(|node| node.length() <= far));
        }
        conics(&planes, &nodes, quadric, self.nearness)
    }
}

/// The eigenvalues of a symmetric matrix from the largest to the least, and their
/// eigenvectors.
fn eigenvectors(matrix: &DMat4) -> ([f64; 4], [DVec4; 4]) {
    let (values, vectors) = jacobi(matrix.to_cols_array_2d());
    let mut order = [0, 1, 2, 3];
    order.sort_by(|&i, &j| values[j].abs().total_cmp(&values[i].abs()));
    (
        order.map(|k| values[k]),
        order.map(|k| DVec4::from_array(vectors[k])),
    )
}
