//! The curves of two quadrics, from the quadrics of their pencil: the
//! combinations of both, which all meet in the same curves.
//!
//! Among them there always is one with lines on it ([`rulings`](super::rulings)):
//! a cone or cylinder, found where the determinant of the 4 by 4 matrix is 0;
//! else a one-sheet hyperboloid or hyperbolic paraboloid. Where the two touch in
//! a point and cross around it, one of them is a cone with its apex there, or a
//! pair of planes (Farouki, Neff and O'Connor, *Automatic Parsing of Degenerate
//! Quadric-Surface Intersections*, 1989). Where they have a conic in common, one is
//! a pair of planes, and where they touch all along it, a plane counted twice: then
//! two or three of the roots of the determinant are one, and rounding parts them,
//! but not those of its derivatives.

mod conics;
mod contact;
mod cubic;
mod lines;
mod planes;

use crate::elementary;
use std::f64::consts::TAU;

use glam::{DMat4, DVec3, DVec4};
use smallvec::{SmallVec, smallvec};

use super::curve::{Branch, Branches, Curve};
use super::intersection::{Nearness, Unknown};
use super::roots::{Roots, Tolerance};
use super::rulings::{Lines, OnLines, Part, Rulings, form, matrix};
use super::trig::{BEGIN, Trig};
use crate::numeric::jacobi;
use crate::numeric::tolerance::{
    AT_INFINITY, CANCELLED, MULTIPLE_ROOT, NEAR, NO_VALUE, POLYNOMIAL, TOUCHING, VALUE,
};
use crate::program::Surface;

/// Two quadrics, and the combinations of them.
struct Pencil<'a> {
    surfaces: [&'a Surface; 2],
    /// Of the coordinates in which all coefficients are of like size.
    origin: DVec3,
    unit: f64,
    matrices: [DMat4; 2],
    /// By how much entries of the second one may be off, of its largest: more than rounding if
    /// it is what is left between surfaces that are nearly one.
    blur: f64,
    nearness: Nearness,
    /// Whether a contact is known already. About a place at which the surfaces nearly touch, in the
    /// unit of their curve, the second matrix is not of the second surface, but of the pencil's
    /// quadric with no gradient there.
    is_about_contact: bool,
}

/// Angles whose cosine and sine are factors of singular matrices.
struct Singular {
    angles: Vec<f64>,
    /// Where several may coincide.
    multiple: Vec<f64>,
}

/// What a quadric of the pencil is good for.
enum Carrier {
    /// It has lines through one point, which may be at infinity.
    Cone(Lines),
    /// It has two families of lines.
    Hyperboloid(Lines),
    /// It has no points, so that the two surfaces have none in common.
    Empty,
    /// It has one point alone, at which the surfaces may touch, or it is a pair
    /// of planes, or nothing is sure.
    Other,
}

/// The curves of two quadrics.
pub(super) fn curves(a: &Surface, b: &Surface, nearness: Nearness) -> Result<Branches, Unknown> {
    let pencil = Pencil::of([a, b], nearness);
    if let Some(lines) = pencil.common_vertex() {
        return Ok(lines);
    }
    if let Some(known) = pencil.along_ruling() {
        return known;
    }
    pencil.by_members()
}

impl<'a> Pencil<'a> {
    /// The curves by that quadric of the pencil on which they are known best.
    fn by_members(&self) -> Result<Branches, Unknown> {
        let [a, b] = self.surfaces;
        let mut hyperboloids: SmallVec<[(Lines, DMat4); 2]> = SmallVec::new();
        let mut consider = |[x, y]: [f64; 2]| -> Option<Result<Branches, Unknown>> {
            let other = self.combined([-y, x]);
            match carrier(&self.combined([x, y]), self.nothing(NO_VALUE, [x, y])) {
                Carrier::Cone(lines) => {
                    let known = self.on_cone(&lines, &other);
                    (!matches!(known, Err(Unknown::NoForm))).then_some(known)
                }
                Carrier::Hyperboloid(lines) => {
                    hyperboloids.push((lines, other));
                    None
                }
                Carrier::Empty => Some(Ok(Branches::new())),
                Carrier::Other => None,
            }
        };
        // Conics first, which are the simplest curves.
        let Singular {
            mut angles,
            multiple,
        } = self.singular_members();
        for &angle in &multiple {
            if let Some(known) = self.on_planes(angle) {
                return known;
            }
        }
        // Then the surfaces themselves, which are known best; of these the one whose
        // apex is nearer to the other one: there the other's lines tell little of it, or nothing.
        let off = |apex: DVec3, other: &Surface| {
            other.value(apex).abs() / other.gradient(apex).length().max(f64::MIN_POSITIVE)
        };
        let [of_a, of_b] = [(a, b), (b, a)].map(|(cone, other)| {
            let apex = cone.apex();
            apex.map_or(f64::INFINITY, |apex| off(apex, other))
        });
        let mut own = [[1.0, 0.0], [0.0, 1.0]];
        if of_b < of_a {
            own.swap(0, 1);
        }
        for own in own {
            if let Some(known) = consider(own) {
                return known;
            }
        }
        for &angle in &angles {
            let (sin, cos) = elementary::sin_cos(angle);
            if let Some(known) = consider([cos, sin]) {
                return known;
            }
        }
        for singular in multiple.iter().flat_map(|&angle| self.singular_near(angle)) {
            if let Some(known) = consider(singular) {
                return known;
            }
        }
        // Those whose apex is a contact, at infinity: in others these are found before.
        for &angle in &multiple {
            let (sin, cos) = elementary::sin_cos(angle);
            if let Some(known) = consider([cos, sin]) {
                return known;
            }
        }
        angles.sort_by(f64::total_cmp);
        let first = angles.first().copied().unwrap_or(0.0);
        angles.push(first + 0.5 * TAU);
        for between in angles.windows(2) {
            let (sin, cos) = elementary::sin_cos(0.5 * (between[0] + between[1]));
            if let Some(known) = consider([cos, sin]) {
                return known;
            }
        }
        let on_hyperboloid = |(lines, other): (Lines, DMat4)| self.on_lines(&lines, &other).ok();
        let known = hyperboloids.into_iter().find_map(on_hyperboloid);
        known.ok_or(Unknown::NoForm)
    }

    fn of(surfaces: [&'a Surface; 2], nearness: Nearness) -> Self {
        let [a, b] = surfaces;
        let origin = 0.5 * (a.anchor + b.anchor);
        let size = surfaces.map(|s| {
            let value = s.value(origin).abs().sqrt();
            value.max(s.gradient(origin).length())
        });
        let unit = size[0].max(size[1]).max(a.anchor.distance(b.anchor));
        // Two cones of one apex look the same at any scale: that of the scene will do.
        let unit = if unit > nearness.near {
            unit
        } else {
            nearness.scene()
        };
        let [one, other] = surfaces.map(|s| matrix(s, origin, unit));
        let (other, blur) = what_differs(&one, other);
        Self {
            surfaces,
            origin,
            unit,
            matrices: [one, other],
            blur,
            nearness,
            is_about_contact: false,
        }
    }

    /// Below which share of the largest a value of a combination is nothing.
    fn nothing(&self, share: f64, [_, y]: [f64; 2]) -> f64 {
        share.max(self.blur * y.abs())
    }

    fn combined(&self, [x, y]: [f64; 2]) -> DMat4 {
        x * self.matrices[0] + y * self.matrices[1]
    }

    /// The quadrics of the pencil whose matrices are singular.
    fn singular_members(&self) -> Singular {
        // Of degree four in the cosine and the sine of an angle, and the same at
        // the opposite one: of degree two in those of its double.
        let determinant = |doubled: f64| {
            let (sin, cos) = elementary::sin_cos(0.5 * doubled);
            self.combined([cos, sin]).determinant()
        };
        let trig = Trig::through(determinant);
        let mut roots = Roots::default();
        trig.roots(POLYNOMIAL * trig.magnitude(), &mut roots);
        let half = |doubled: f64| 0.5 * doubled;
        Singular {
            multiple: multiple_roots(&trig).into_iter().map(half).collect(),
            angles: roots.simple.into_iter().map(half).collect(),
        }
    }

    /// The factors of singular matrices next to an angle at which roots of the determinant are
    /// nearly one: so they are of surfaces of one shape but for little, such as balls that
    /// were turned by rounded numbers. By steps of Rayleigh's quotient iteration.
    fn singular_near(&self, angle: f64) -> SmallVec<[[f64; 2]; 4]> {
        const STEPS: u32 = 4;
        /// How far from the angle, in radians, and how small eigenvalues are there.
        const NEARLY: f64 = 1e-4;
        let (sin, cos) = elementary::sin_cos(angle);
        let eigenvectors = |factors: [f64; 2]| {
            let (values, vectors) = jacobi(self.combined(factors).to_cols_array_2d());
            (values, vectors.map(DVec4::from_array))
        };
        let (values, vectors) = eigenvectors([cos, sin]);
        let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let small = values.iter().zip(vectors);
        let small = small.filter(|(value, _)| value.abs() <= NEARLY * largest);
        let singular = small.filter_map(|(_, mut null)| {
            let mut factors = [cos, sin];
            for _ in 0..STEPS {
                let [x, y] = self.matrices.map(|matrix| null.dot(matrix * null));
                let length = elementary::hypot(x, y);
                // A vector on both surfaces tells nothing.
                if length <= CANCELLED {
                    return None;
                }
                let sign = (y * cos - x * sin).signum();
                factors = [sign * y / length, -sign * x / length];
                if (factors[0] - cos).abs().max((factors[1] - sin).abs()) > NEARLY {
                    return None;
                }
                let along = |v: &DVec4| v.dot(null).abs();
                let (_, vectors) = eigenvectors(factors);
                let same = vectors.into_iter();
                let same = same.max_by(|p, q| along(p).total_cmp(&along(q)));
                null = same.unwrap_or(null);
            }
            Some(factors)
        });
        singular.collect()
    }

    /// The lines in which two cones of one apex meet: then all quadrics of the pencil
    /// are such, and the determinant, being 0 of each, tells nothing.
    fn common_vertex(&self) -> Option<Branches> {
        let [Some(one), Some(other)] = self.surfaces.map(Surface::apex) else {
            return None;
        };
        if one.distance(other) > self.nearness.near {
            return None;
        }
        let Carrier::Cone(lines) = carrier(&self.matrices[0], NO_VALUE) else {
            return None;
        };
        Some(self.through_vertex(&lines, &self.matrices[1]))
    }

    /// The curves of two cones or cylinders that touch each other along a line: then all
    /// quadrics of the pencil have a vertex on it, and the determinant, being 0 of each, tells
    /// nothing. One of them is the plane in which both touch, and another plane.
    fn along_ruling(&self) -> Option<Result<Branches, Unknown>> {
        let [Carrier::Cone(one), Carrier::Cone(other)] = [[1.0, 0.0], [0.0, 1.0]]
            .map(|own| carrier(&self.combined(own), self.nothing(NO_VALUE, own)))
        else {
            return None;
        };
        let vertices = [one.q[0], other.q[0]];
        let [a, b] = &self.matrices;
        let polars = [*b * vertices[0], *a * vertices[1]];
        let is_on = |vertex: DVec4, polar: DVec4| {
            let slope = polar.truncate().length();
            let off = self.nearness.near / self.unit * vertex.w.abs();
            slope > TOUCHING && vertex.dot(polar).abs() <= (2.0 * off * slope).max(NO_VALUE)
        };
        if !(0..2).all(|k| is_on(vertices[k], polars[k])) {
            return None;
        }
        let [plane, same] = polars.map(DVec4::normalize);
        if (plane - plane.dot(same).signum() * same).length() > TOUCHING {
            return None;
        }
        // Of a direction in that plane, off the line: there both are double lines, so that one
        // of the pencil vanishes on all of it.
        let aside = across([plane, vertices[0], vertices[1]]);
        let [x, y] = [a, b].map(|matrix| aside.dot(*matrix * aside));
        let length = elementary::hypot(x, y);
        let member = self.combined([y / length, -x / length]);
        let polar = member * plane;
        let rest = 2.0 * polar - plane.dot(polar) * plane;
        let is_plane = |vector: DVec4| vector.is_finite() && vector.length() > CANCELLED;
        is_plane(rest).then(|| self.in_planes(&[plane, rest]))
    }

    /// A point in space.
    fn place(&self, point: DVec4) -> DVec3 {
        self.origin + self.unit / point.w * point.truncate()
    }

    /// The curves on a cone or cylinder.
    fn on_cone(&self, lines: &Lines, other: &DMat4) -> Result<Branches, Unknown> {
        let vertex = lines.q[0];
        let polar = *other * vertex;
        let at_vertex = vertex.dot(polar);
        let size = largest_entry(other);
        let is_finite = vertex.w.abs() > AT_INFINITY;
        // Half the gradient, and how far the vertex is from the other surface.
        let slope = polar.truncate().length();
        let is_on = if is_finite {
            let off = (self.nearness.near / self.unit * vertex.w).abs();
            at_vertex.abs()
                <= (2.0 * off * slope)
                    .max(off * off * size)
                    .max(NO_VALUE * size)
        } else {
            at_vertex.abs() <= NO_VALUE * size
        };
        if !is_on {
            return self.on_lines(lines, other);
        }
        let form = lines.form(other);
        if form.b.magnitude() <= CANCELLED * size {
            return Ok(self.through_vertex(lines, other));
        }
        let mut branches = Branches::new();
        for (lines, until) in spread(lines, |_| true) {
            let form = lines.form(other);
            // Where the curve passes through the vertex.
            let mut roots = Roots::default();
            let nothing = CANCELLED * form.b.magnitude();
            match until {
                Some(until) => {
                    let everywhere = Tolerance::everywhere(nothing);
                    form.b.roots_on([-until, until], &everywhere, &mut roots);
                }
                None => form.b.roots(nothing, &mut roots),
            }
            let has_line = |angle: &&f64| {
                let square = lines.point(**angle).length_squared();
                form.a.value(**angle).abs() <= NEAR * size * square
            };
            let angles = roots.simple.iter().chain(&roots.touching);
            let in_both: SmallVec<[f64; 2]> = angles.filter(has_line).copied().collect();
            match in_both[..] {
                [] => {}
                [angle] => return self.beside_line([vertex, lines.point(angle)]),
                _ => return Err(Unknown::NoForm),
            }
            let mut nodes: SmallVec<[f64; 2]> = SmallVec::new();
            if is_finite {
                let places = roots.simple.iter().chain(&roots.touching);
                nodes.extend(places.map(|angle| angle - BEGIN));
            }
            let curve = self.rulings(&lines, &form, (Part::Once, until));
            branches.extend(curve.parts().into_iter().map(|piece| Branch {
                nodes: within(&nodes, piece.between),
                curve: Curve::Rulings(Box::new(piece)),
            }));
        }
        Ok(branches)
    }

    /// The lines that two cones or cylinders of one vertex have in common.
    fn through_vertex(&self, lines: &Lines, other: &DMat4) -> Branches {
        let vertex = lines.q[0];
        let is_finite = vertex.w.abs() > AT_INFINITY;
        // How near the other one is where it touches; apexes may be near each other alone.
        let touch = if is_finite {
            self.nearness.near
        } else {
            self.nearness.touch
        };
        let size = largest_entry(other);
        // Where a point p is off by a distance, its value is off by that times w |(M p)'|, twice.
        let off = |weight: f64, slope: f64, length: f64| {
            2.0 * touch / self.unit * weight * slope + POLYNOMIAL * size * length * length
        };
        let longest: f64 = lines.p.iter().map(|v| v.length()).sum();
        let tolerance = Tolerance {
            at: |angle: f64| {
                let point = lines.point(angle);
                let slope = (*other * point).truncate().length();
                off(point.w.abs(), slope, point.length())
            },
            most: off(longest, 4.0 * size * longest, longest),
        };
        let mut roots = Roots::default();
        lines.form(other).a.roots_within(&tolerance, &mut roots);
        // Where they touch, along one line.
        roots.simple.retain(|t| !roots.touching.contains(t));
        let mut branches = Branches::new();
        for angle in roots.simple.iter().chain(&roots.touching) {
            let point = lines.point(*angle);
            if is_finite {
                let away = point - point.w / vertex.w * vertex;
                branches.push(Branch {
                    curve: Curve::Line {
                        point: self.place(vertex),
                        direction: away.truncate().normalize_or_zero(),
                    },
                    nodes: smallvec![0.0],
                });
            } else if point.w != 0.0 {
                branches.push(Branch::new(Curve::Line {
                    point: self.place(point),
                    direction: vertex.truncate().normalize_or_zero(),
                }));
            }
        }
        branches
    }

    fn rulings(
        &self,
        lines: &Lines,
        on_lines: &OnLines,
        (part, until): (Part, Option<f64>),
    ) -> Rulings {
        Rulings {
            origin: self.origin,
            unit: self.unit,
            lines: lines.clone(),
            on_lines: on_lines.clone(),
            part,
            between: None,
            until,
        }
    }
}

/// Lines on which curves are told best: those of a quadric, or, if it is two planes but for
/// little and the curves lie in these, those of each plane, and up to which angle they are.
/// Digits depend on it alone.
fn spread(lines: &Lines, is_on: impl Fn(&Lines) -> bool) -> SmallVec<[(Lines, Option<f64>); 2]> {
    let planes = lines.of_two_planes();
    let planes = planes.filter(|planes| planes.iter().any(|(lines, _)| is_on(lines)));
    match planes {
        Some(planes) => {
            let planes = planes.into_iter();
            planes.map(|(lines, until)| (lines, Some(until))).collect()
        }
        None => smallvec![(lines.clone(), None)],
    }
}

/// The angles that are on a piece of a curve, turned by whole turns to where it is.
fn within(angles: &[f64], between: Option<(f64, f64)>) -> SmallVec<[f64; 2]> {
    let (from, to) = between.unwrap_or((0.0, TAU));
    let places = angles
        .iter()
        .map(|angle| from + (angle - from).rem_euclid(TAU));
    places.filter(|&place| place < to).collect()
}

fn largest_entry(matrix: &DMat4) -> f64 {
    let entries = matrix.to_cols_array();
    entries
        .iter()
        .fold(0.0, |most, entry| most.max(entry.abs()))
}

/// What is at right angles to three vectors.
fn across([p, q, r]: [DVec4; 3]) -> DVec4 {
    let minor = |but: usize| {
        let rest = |v: DVec4| DVec3::from_array([1, 2, 3].map(|k| v[(but + k) % 4]));
        let sign = [1.0, -1.0][but % 2];
        sign * rest(p).dot(rest(q).cross(rest(r)))
    };
    DVec4::from_array([0, 1, 2, 3].map(minor)).normalize_or_zero()
}

/// Where a polynomial of degree two may have roots of multiplicity four, three and
/// two: there its third, second or first derivative has a simple one, which alone
/// is known to the last digits.
fn multiple_roots(trig: &Trig) -> SmallVec<[f64; 4]> {
    let first = trig.derivative();
    let second = first.derivative();
    let third = second.derivative();
    let mut found = SmallVec::new();
    for derivative in [third, second, first] {
        let mut roots = Roots::default();
        derivative.roots(POLYNOMIAL * derivative.magnitude(), &mut roots);
        let is_root = |t: &f64| trig.value(*t).abs() <= MULTIPLE_ROOT * trig.magnitude();
        found.extend(roots.simple.into_iter().filter(is_root));
    }
    found
}

/// Another basis of the pencil of two matrices, if these are the same but for little: in place
/// of the second one what it differs by, and by how much that is off.
fn what_differs(one: &DMat4, other: DMat4) -> (DMat4, f64) {
    /// Of the second one, what differs. Digits depend on it alone.
    const LITTLE: f64 = 1e-3;
    let dot = |p: &DMat4, q: &DMat4| -> f64 {
        let [p, q] = [p, q].map(DMat4::to_cols_array);
        p.iter().zip(q).map(|(p, q)| p * q).sum()
    };
    let rest = other - dot(one, &other) / dot(one, one) * *one;
    let share = (dot(&rest, &rest) / dot(&other, &other)).sqrt();
    if share.is_nan() || share >= LITTLE || share <= VALUE {
        return (other, 0.0);
    }
    (rest * dot(&rest, &rest).sqrt().recip(), VALUE / share)
}

/// What a quadric has, given by its matrix, of which values are nothing below a share of the
/// largest.
fn carrier(matrix: &DMat4, nothing: f64) -> Carrier {
    let (values, vectors) = jacobi(matrix.to_cols_array_2d());
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let of_sign = |sign: f64| -> SmallVec<[DVec4; 4]> {
        let own = |(value, vector): (&f64, &[f64; 4])| {
            (sign * value > nothing * largest)
                .then(|| DVec4::from_array(*vector) / value.abs().sqrt())
        };
        values.iter().zip(&vectors).filter_map(own).collect()
    };
    let (mut plus, mut minus) = (of_sign(1.0), of_sign(-1.0));
    // Of a pair of planes but for little the first vector of either is short.
    for vectors in [&mut plus, &mut minus] {
        vectors.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    }
    let none = DVec4::ZERO;
    match (plus.as_slice(), minus.as_slice()) {
        (&[x, y], &[one]) | (&[one], &[x, y]) => {
            let is_null = |&k: &usize| values[k].abs() <= nothing * largest;
            let Some(null) = (0..4).find(is_null) else {
                return Carrier::Other;
            };
            Carrier::Cone(Lines {
                p: [one, x, y],
                q: [DVec4::from_array(vectors[null]), none, none],
            })
        }
        (&[x, y], &[z, w]) => Carrier::Hyperboloid(Lines {
            p: [z, x, y],
            q: [w, y, -x],
        }),
        ([_, _, _, _], []) | ([], [_, _, _, _]) => Carrier::Empty,
        _ => Carrier::Other,
    }
}
