//! How far a chord strays from the curve in which two surfaces meet.

use crate::elementary;
use glam::DVec3;
use smallvec::SmallVec;

use super::{hessian_norm, of_triangle, shrunk};
use crate::numeric::tolerance::TOUCHING;
use crate::program::Surface;
use crate::surface::round::{LEAST_ASPECT, Round};

/// A bound of this share of a chord or more tells hardly more than that its points are
/// near its ends.
const HARDLY: f64 = 0.125;

/// A bound of the distance of any point of the chord to the curve in which two
/// surfaces meet; of ends on both.
///
/// With the equations scaled to unit gradients at the middle of a part of the
/// chord, J their Jacobian there and F their values, |J⁺ F| is the distance to
/// first order; along the path x' = -J(x)⁺ F the Jacobian changes by at most E,
/// which lengthens the path by at most 1 / (1 - |J⁺| E): along the chord as the
/// gradients do, at a constant rate, and L · (distance from the chord) besides. Where both
/// gradients grow or shrink alike, as along a ruling of two cones with one apex, J is only
/// scaled, which makes the path no longer than that: such a share of the change is not enlarged
/// by |J⁺|. Near a point where the surfaces touch that proves nothing, but a part of the
/// chord is at most as far from the curve as from the chord's end. Where they touch at both
/// ends, and so all along the curve, one surface goes on where the other ends: then it is the
/// distance to the surfaces, near which the true boundary is to second order.
#[must_use]
pub(crate) fn of_chord(surfaces: [&Surface; 2], p: DVec3, q: DVec3) -> f64 {
    let off_plane = |plane: &Surface| plane.value(p).abs().max(plane.value(q).abs());
    let [a, b] = surfaces;
    if a.is_plane() && b.is_plane() {
        return off_plane(a).max(off_plane(b));
    }
    let [plane, surface] = if a.is_plane() { [a, b] } else { [b, a] };
    let mut by_centre = f64::INFINITY;
    if plane.is_plane() {
        let (bound, turns_fast) = of_chord_in_plane(plane, surface, p, q);
        if turns_fast {
            by_centre = from_centre(plane, surface, p, q) + off_plane(plane);
        }
        if bound < f64::INFINITY {
            return by_centre.min(bound + off_plane(plane));
        }
    }
    by_centre.min(across_curve(surfaces, p, q))
}

/// The same by the surfaces on both sides of the curve.
fn across_curve(surfaces: [&Surface; 2], p: DVec3, q: DVec3) -> f64 {
    let touch = |at: DVec3| {
        let [a, b] = surfaces.map(|s| s.gradient(at).normalize_or_zero());
        a.cross(b).length() <= TOUCHING
    };
    if touch(p) && touch(q) {
        let bounds = surfaces.map(|s| of_triangle(s, [p, q, q]));
        return bounds[0].max(bounds[1]);
    }
    let chord = Chord::new(surfaces, p, q);
    let bound = chord.proven();
    if bound < HARDLY * p.distance(q) {
        return bound;
    }
    let rounds = surfaces.into_iter().filter_map(Round::standard);
    rounds.fold(bound, |bound, round| {
        bound.min(round_bound(&round, surfaces, [p, q]))
    })
}

/// The same in coordinates in which one of the surfaces is round.
fn round_bound(round: &Round, surfaces: [&Surface; 2], ends: [DVec3; 2]) -> f64 {
    let images = surfaces.map(|s| round.image(s));
    let [p, q] = ends.map(|end| round.place(end));
    round.longest() * Chord::new(images.each_ref(), p, q).proven()
}

/// The same in a plane, to which the chord and the way from it are held: there
/// it is the distance to a conic. Along the chord f = 4 m λ μ plus what it is at
/// the ends, with m = f in its middle, λ + μ = 1 and the slope s λ + t μ at least
/// (√s λ + √t μ)² >= 4 √(s t) λ μ. And whether the gradient turns so fast that this is
/// far too large.
fn of_chord_in_plane(plane: &Surface, surface: &Surface, p: DVec3, q: DVec3) -> (f64, bool) {
    let gradients = [p, q].map(|at| {
        let gradient = surface.gradient(at);
        let along = gradient - gradient.dot(plane.linear) * plane.linear;
        let is_parallel = along.length() <= TOUCHING * gradient.length();
        if is_parallel { DVec3::ZERO } else { along }
    });
    let mean = (gradients[0] + gradients[1]).normalize_or_zero();
    let slopes = gradients.map(|gradient| gradient.dot(mean));
    let bend = 0.125 * surface.curvature_along(q - p);
    let middle = bend.abs();
    let at_ends = surface.value(p).abs().max(surface.value(q).abs());
    // f is less than 0 in between if it bends upward.
    let [least, greatest] = Bends::within(plane, surface).extremes();
    let shrinkage = if bend > 0.0 { -least } else { greatest }.max(0.0);
    let bound = shrunk(|distance| {
        let [s, t] = slopes.map(|slope| slope - shrinkage * distance);
        if s.min(t) <= 0.0 {
            return f64::INFINITY;
        }
        middle / (s * t).sqrt() + at_ends / s.min(t)
    });
    let steepest = gradients[0]
        .length_squared()
        .max(gradients[1].length_squared());
    let least = slopes[0].min(slopes[1]).max(0.0);
    (bound, 4.0 * least * least < steepest)
}

/// The second derivatives of f in a plane, along two directions at right angles.
struct Bends {
    u: DVec3,
    v: DVec3,
    uu: f64,
    vv: f64,
    uv: f64,
}

impl Bends {
    fn within(plane: &Surface, surface: &Surface) -> Self {
        let (u, v) = plane.linear.any_orthonormal_pair();
        let [uu, vv, both] = [u, v, u + v].map(|d| surface.curvature_along(d));
        let uv = 0.5 * (both - uu - vv);
        Self { u, v, uu, vv, uv }
    }

    /// The least and the greatest along any direction.
    fn extremes(&self) -> [f64; 2] {
        let mean = 0.5 * (self.uu + self.vv);
        let swing = elementary::hypot(0.5 * (self.uu - self.vv), self.uv);
        [mean - swing, mean + swing]
    }
}

/// A bound for a chord of a long ellipse in a plane, on the rays from its centre: at its
/// ends the gradient turns too fast. A point of the chord is at a share s of the way to
/// the ellipse, 1 - s² = f / f(centre). Infinite for other conics.
fn from_centre(plane: &Surface, surface: &Surface, p: DVec3, q: DVec3) -> f64 {
    let Bends { u, v, uu, vv, uv } = Bends::within(plane, surface);
    let determinant = uu * vv - uv * uv;
    // The sum of a half axis by the other one and the reverse.
    if (uu + vv).abs() < LEAST_ASPECT * determinant.max(0.0).sqrt() {
        return f64::INFINITY;
    }
    let gradient = surface.gradient(p);
    let (x, y) = (gradient.dot(u), gradient.dot(v));
    let center = p - ((x * vv - y * uv) * u + (y * uu - x * uv) * v) / determinant;
    let depth = surface.value(center).abs();
    let at_ends = surface.value(p).abs().max(surface.value(q).abs());
    let off = 0.125 * surface.curvature_along(q - p).abs() + at_ends;
    if determinant <= 0.0 || off >= depth || !center.is_finite() {
        return f64::INFINITY;
    }
    let farthest = p.distance(center).max(q.distance(center));
    (1.0 / (1.0 - off / depth).sqrt() - 1.0) * farthest
}

/// A chord under examination.
struct Chord<'a> {
    surfaces: [&'a Surface; 2],
    p: DVec3,
    along: DVec3,
    /// f and g in the middle; at share t of the chord they are 4t(1 - t) of
    /// that.
    at_middle: [f64; 2],
    /// By how much the gradients change along the chord, at a constant rate.
    turns: [DVec3; 2],
}

impl<'a> Chord<'a> {
    fn new(surfaces: [&'a Surface; 2], p: DVec3, q: DVec3) -> Self {
        Self {
            surfaces,
            p,
            along: q - p,
            at_middle: surfaces.map(|s| s.value(0.5 * (p + q))),
            turns: surfaces.map(|s| s.gradient(q) - s.gradient(p)),
        }
    }

    /// A bound for all of it.
    fn proven(&self) -> f64 {
        let (bound, first_order) = self.bound(0.0, 1.0);
        if bound <= 1.02 * first_order {
            return bound;
        }
        bound.min(self.bound_by_halves(first_order))
    }

    /// A bound for the part between two shares of the chord, and the distance
    /// to first order.
    fn bound(&self, from: f64, to: f64) -> (f64, f64) {
        let middle = self.p + 0.5 * (from + to) * self.along;
        let gradients = self.surfaces.map(|s| s.gradient(middle));
        let lengths = gradients.map(DVec3::length);
        let cosine = gradients[0].dot(gradients[1]) / (lengths[0] * lengths[1]);
        let [r1, r2] = [0, 1].map(|i| self.at_middle[i] / lengths[i]);
        let [l1, l2] = [0, 1].map(|i| hessian_norm(self.surfaces[i]) / lengths[i]);
        let nearest_half = 0.5f64.clamp(from, to);
        let weight = 4.0 * nearest_half * (1.0 - nearest_half);
        let first_order = weight
            * ((r1 * r1 - 2.0 * cosine * r1 * r2 + r2 * r2) / (1.0 - cosine * cosine)).sqrt();
        if first_order.is_nan() {
            return (f64::INFINITY, 0.0);
        }
        // |J⁺| times the change of J per length, and from the middle to an end: of all of it, or
        // of what is left beside a common factor, and that.
        let inverse = 1.0 / (1.0 - cosine.abs()).sqrt();
        let rate = inverse * elementary::hypot(l1, l2);
        let units = [0, 1].map(|i| gradients[i] / lengths[i]);
        let turns = [0, 1].map(|i| 0.5 * (to - from) * self.turns[i] / lengths[i]);
        let factor = 0.5 * (turns[0].dot(units[0]) + turns[1].dot(units[1]));
        let beside = |factor: f64| {
            let [t1, t2] = [0, 1].map(|i| (turns[i] - factor * units[i]).length());
            factor.abs() + inverse * elementary::hypot(t1, t2)
        };
        let at_end = beside(0.0).min(beside(factor));
        let is_whole = from == 0.0 && to == 1.0;
        let longer = |distance: f64| {
            let room = 1.0 - rate * distance;
            let slope = at_end / room;
            if room <= 0.0 || slope >= 1.0 {
                f64::INFINITY
            } else if is_whole {
                // Away from the middle F shrinks as 1 - u² while J changes by
                // slope u: the greatest of (1 - u²) / (1 - slope u).
                first_order * 2.0 / (1.0 + (1.0 - slope * slope).sqrt()) / room
            } else {
                first_order / (1.0 - slope) / room
            }
        };
        // A distance that the map shrinks is a bound, and so is its image.
        let mut bound = 1.25 * longer(1.25 * first_order);
        if bound == f64::INFINITY || longer(bound) > bound {
            return (f64::INFINITY, first_order);
        }
        for _ in 0..3 {
            bound = longer(bound);
        }
        (bound, first_order)
    }

    /// The same by parts, the worst of which is halved until it is within
    /// `enough`: towards an end where the surfaces touch they become ever
    /// smaller.
    fn bound_by_halves(&self, enough: f64) -> f64 {
        const MOST_PARTS: usize = 64;
        let length = self.along.length();
        let part = |from: f64, to: f64| {
            let (bound, _) = self.bound(from, to);
            // No farther than from the chord's ends.
            let bound = bound.min(to * length).min((1.0 - from) * length);
            (bound, from, to)
        };
        let mut parts: SmallVec<[(f64, f64, f64); MOST_PARTS]> = SmallVec::new();
        parts.push(part(0.0, 1.0));
        loop {
            let worst = parts.iter_mut().max_by(|a, b| a.0.total_cmp(&b.0));
            let Some(worst) = worst else {
                return f64::INFINITY;
            };
            let (bound, from, to) = *worst;
            let middle = 0.5 * (from + to);
            *worst = part(from, middle);
            if bound <= 1.02 * enough || parts.len() == MOST_PARTS {
                return bound;
            }
            parts.push(part(middle, to));
        }
    }
}
