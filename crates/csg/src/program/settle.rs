//! Surfaces that nearly coincide, made one: what differs by more than rounding, but
//! by less than can be told apart where a solid's boundary is evaluated, is decided
//! here, once, and for the whole solid.
//!
//! [`Program::lower`] unites what is the same surface but for the rounding of its
//! own arithmetic. What an author rounded, such as a radius of 0.3333333333 beside
//! one of a third, it leaves apart. Two such surfaces bound a wall or a gap too thin
//! for the arithmetic of what comes later, whose stages would have to decide one
//! after another whether it is there.

use glam::DVec3;

use super::lower::simplified;
use super::{Program, Surface, eigen_symmetric};
use crate::error::Error;

/// A program whose nearly coincident surfaces are one.
#[derive(Clone, Debug)]
pub(crate) struct Settled {
    pub program: Program,
    /// How many surfaces were replaced by another one.
    pub merged: usize,
    /// Bound on how far any of them is from the one in its place, where the solid is.
    pub moved: f64,
    /// A point near the surface that was moved farthest.
    pub place: DVec3,
}

impl Program {
    /// The program with one surface, the first, in place of each chain of surfaces
    /// every one of which is within a distance of the next, in the ball about
    /// `origin` that holds the solid. None if there are no such chains. A chain
    /// longer than `most` stays as it is.
    ///
    /// Surfaces keep their numbers. Takes n log n steps for n surfaces.
    pub(crate) fn settled(
        &self,
        (origin, reach): (DVec3, f64),
        within: f64,
        most: f64,
    ) -> Result<Option<Settled>, Error> {
        self.united(self.surfaces.clone(), (origin, reach), within, most)
    }

    /// The program with the places, directions and sizes of all surfaces rounded to
    /// decimals, none of which moves a surface farther than `most` where the solid is,
    /// and those that then coincide made one. None if that changes nothing.
    ///
    /// What an author meant to touch, meet or be in line and missed by less, then does,
    /// or else, if it takes more digits to say, clearly does not.
    pub(crate) fn rounded(
        &self,
        (origin, reach): (DVec3, f64),
        most: f64,
    ) -> Result<Option<Settled>, Error> {
        /// Of what surfaces may move: for place, direction and size together.
        const SHARE: f64 = 0.2;
        let step = Decimal::below(SHARE * most);
        let turn = Decimal::below(SHARE * most / reach);
        let round = |surface: &Surface| {
            let rounded = surface.rounded((origin, reach), step, turn)?;
            let [one, other] = [surface, &rounded].map(|s| s.relative_to(origin));
            (one.apart(&other, reach) <= most).then_some(rounded)
        };
        let surfaces = self.surfaces.iter();
        let surfaces = surfaces.map(|s| round(s).unwrap_or(*s)).collect();
        self.united(surfaces, (origin, reach), 1e-3 * step.step(), most)
    }

    /// The program with every surface moved on its own, by up to `most` where the solid
    /// is, and a fifth of that at least: what touches or meets by chance, more than two
    /// surfaces in a curve or three in a point, then clearly does or does not. What is
    /// one surface stays one. The same moves in every run.
    pub(crate) fn stirred(
        &self,
        (origin, reach): (DVec3, f64),
        most: f64,
    ) -> Result<Option<Settled>, Error> {
        let stir = |(index, surface): (u64, &Surface)| {
            let number = |k: u64| {
                // The finaliser of SplitMix64.
                let mut x = (4 * index + k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                2.0 * ((x ^ (x >> 31)) >> 11) as f64 * (-53.0_f64).exp2() - 1.0
            };
            let direction = DVec3::new(number(0), number(1), number(2));
            let distance = (0.6 + 0.4 * number(3)) * most;
            let step = if surface.is_plane() {
                direction.x.signum() * distance * surface.linear
            } else {
                distance * direction.normalize_or_zero()
            };
            Surface {
                anchor: surface.anchor + step,
                ..*surface
            }
        };
        let surfaces = (0..).zip(&self.surfaces).map(stir).collect();
        let stirred = self.united(surfaces, (origin, reach), 0.0, f64::INFINITY)?;
        // What is moved as a whole is nowhere moved farther.
        Ok(stirred.map(|stirred| Settled {
            moved: most,
            ..stirred
        }))
    }

    /// The program with other surfaces in place of its own, and those that nearly
    /// coincide made one.
    fn united(
        &self,
        surfaces: Vec<Surface>,
        (origin, reach): (DVec3, f64),
        within: f64,
        most: f64,
    ) -> Result<Option<Settled>, Error> {
        let about = |s: &Surface| s.relative_to(origin);
        let before: Vec<Surface> = self.surfaces.iter().map(about).collect();
        let after: Vec<Surface> = surfaces.iter().map(about).collect();
        let chains = Chains::of(&after, reach, within);
        let mut in_place: Vec<(u32, bool)> = (0..surfaces.len() as u32)
            .map(|index| (index, false))
            .collect();
        let mut merged = 0;
        for chain in chains.longer_than_one() {
            let first = chain[0];
            let one = &after[first as usize];
            let off = |&other: &u32| one.apart(&before[other as usize], reach);
            if chain.iter().map(off).fold(0.0, f64::max) > most {
                continue;
            }
            for &other in &chain[1..] {
                let is_flipped = !one.is_aligned(&after[other as usize]);
                in_place[other as usize] = (first, is_flipped);
            }
            merged += chain.len() - 1;
        }
        let off = |(surface, &(now, _)): (&Surface, &(u32, bool))| {
            (surface.apart(&after[now as usize], reach), surface.anchor)
        };
        let moves = before.iter().zip(&in_place).map(off);
        let (moved, place) = moves.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        if moved == 0.0 && merged == 0 {
            return Ok(None);
        }
        let mut formula = self.formula.clone();
        for literal in &mut formula.literals {
            let (surface, is_flipped) = in_place[literal.surface as usize];
            literal.surface = surface;
            literal.outside ^= is_flipped;
        }
        Ok(Some(Settled {
            program: Self {
                surfaces,
                formula: simplified(&formula)?,
                origins: self.origins.clone(),
            },
            merged,
            moved,
            place: place + origin,
        }))
    }
}

/// How many decimals numbers are rounded to.
#[derive(Clone, Copy, Debug)]
struct Decimal {
    /// The power of ten.
    per_unit: f64,
}

impl Decimal {
    /// So few that rounding changes a number by no more than a distance.
    fn below(distance: f64) -> Self {
        let digits = (-(2.0 * distance).log10()).ceil();
        Self {
            per_unit: 10f64.powf(digits),
        }
    }

    fn step(self) -> f64 {
        1.0 / self.per_unit
    }

    /// A number rounded, the same for all that round to it.
    fn round(self, value: f64) -> f64 {
        let rounded = (value * self.per_unit).round() / self.per_unit;
        if rounded.is_finite() { rounded } else { value }
    }

    fn round_all(self, point: DVec3) -> DVec3 {
        point.map(|value| self.round(value))
    }
}

/// Which surfaces are linked, by the first of each chain found so far.
struct Chains {
    parent: Vec<u32>,
}

impl Chains {
    fn of(surfaces: &[Surface], reach: f64, within: f64) -> Self {
        /// Where surfaces are evaluated to be sorted, in reaches: no surface of a
        /// symmetric model is at the same distance as another one's mirror image.
        const PROBE: DVec3 = DVec3::new(0.302_775_638, 0.414_213_562, -0.236_067_978);
        let mut chains = Self {
            parent: (0..surfaces.len() as u32).collect(),
        };
        let probe = reach * PROBE;
        let mut by_value: Vec<(bool, f64, u32)> = (0..)
            .zip(surfaces)
            .map(|(index, surface)| (surface.is_plane(), surface.value(probe).abs(), index))
            .collect();
        by_value.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        for (rank, &(is_plane, value, index)) in by_value.iter().enumerate() {
            let one = &surfaces[index as usize];
            // By how much values differ there at most, to first order and twice.
            let slope = if is_plane {
                1.0
            } else {
                one.gradient(probe).length() + 6.0 * (one.anchor.length() + reach)
            };
            let most = 2.0 * within * slope;
            let close = by_value[rank + 1..]
                .iter()
                .take_while(|other| other.0 == is_plane && other.1 - value <= most);
            for &(_, _, other) in close {
                if one.apart(&surfaces[other as usize], reach) <= within {
                    chains.link(index, other);
                }
            }
        }
        chains
    }

    fn first(&mut self, mut index: u32) -> u32 {
        while self.parent[index as usize] != index {
            let above = self.parent[self.parent[index as usize] as usize];
            self.parent[index as usize] = above;
            index = above;
        }
        index
    }

    fn link(&mut self, a: u32, b: u32) {
        let [a, b] = [self.first(a), self.first(b)];
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// The chains of several surfaces, ascending.
    fn longer_than_one(mut self) -> Vec<Vec<u32>> {
        let count = self.parent.len() as u32;
        let mut pairs: Vec<(u32, u32)> = (0..count).map(|k| (self.first(k), k)).collect();
        pairs.sort_unstable();
        let chains = pairs.chunk_by(|a, b| a.0 == b.0).filter(|c| c.len() > 1);
        chains
            .map(|c| c.iter().map(|pair| pair.1).collect())
            .collect()
    }
}

impl Surface {
    /// This surface with its place and sizes rounded to one number of decimals, and its
    /// directions to another; none where it has no such numbers.
    fn rounded(&self, (origin, reach): (DVec3, f64), step: Decimal, turn: Decimal) -> Option<Self> {
        /// Eigenvalues nearer to each other, of the largest, are the same.
        const SAME: f64 = 1e-9;
        let direction = |axis: DVec3| turn.round_all(axis).normalize_or_zero();
        if self.is_plane() {
            // Turned about the point nearest to the solid's middle.
            let foot = origin - self.value(origin) * self.linear;
            let linear = direction(self.linear);
            let anchor = step.round(linear.dot(foot)) * linear;
            return Some(Self {
                anchor,
                linear,
                ..*self
            });
        }
        let (values, axes) = eigen_symmetric(self.quadratic);
        let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let is_same = |a: f64, b: f64| (a - b).abs() <= SAME * largest;
        let is_none = |value: f64| is_same(value, 0.0);
        let is_central = self.linear == DVec3::ZERO;
        if !is_central {
            let anchor = step.round_all(self.anchor);
            return Some(Self { anchor, ..*self });
        }
        // The last two may be the same, and the first one differs from them.
        let odd = (0..3).find(|&k| is_same(values[(k + 1) % 3], values[(k + 2) % 3]));
        let order = odd.map_or([0, 1, 2], |k| [k, (k + 1) % 3, (k + 2) % 3]);
        let values = order.map(|k| values[k]);
        let mut axes = order.map(|k| axes.col(k));
        // The point of an axis nearest to the solid's middle, whatever it was made from.
        let mut anchor = self.anchor;
        for (value, axis) in values.iter().zip(axes) {
            if is_none(*value) {
                anchor += (origin - anchor).dot(axis) * axis;
            }
        }
        let anchor = step.round_all(anchor);
        axes[0] = direction(axes[0]);
        axes[1] = if odd.is_some() {
            axes[0].any_orthonormal_vector()
        } else {
            direction(axes[1])
                .reject_from_normalized(axes[0])
                .normalize_or_zero()
        };
        axes[2] = axes[0].cross(axes[1]);
        // Squares of sizes, which are lengths, or of slopes if they go through a point.
        let unit = if self.constant == 0.0 {
            largest
        } else {
            self.constant.abs()
        };
        let decimals = if self.constant == 0.0 { turn } else { step };
        let square = |value: f64| {
            if is_none(value) {
                return 0.0;
            }
            let size = (unit / value.abs()).sqrt();
            let rounded = decimals.round(size);
            // Larger than the scene, it need not be in the same decimals.
            let size = if rounded > 0.0 && size <= 1e3 * reach {
                rounded
            } else {
                size
            };
            value.signum() / (size * size)
        };
        let squares = [square(values[0]), square(values[1]), square(values[2])];
        let squares = match odd {
            Some(_) => [squares[0], squares[1], squares[1]],
            None => squares,
        };
        // Of directions at right angles: twice the first is what the others leave.
        let mut form = [0.0; 6];
        let rest = if odd.is_some() { squares[1] } else { 0.0 };
        for (square, axis) in squares.iter().zip(axes) {
            let [x, y, z] = axis.to_array();
            let weight = square - rest;
            let terms = [x * x, y * y, z * z, 2.0 * x * y, 2.0 * y * z, 2.0 * z * x];
            for (sum, term) in form.iter_mut().zip(terms) {
                *sum += weight * term;
            }
        }
        for sum in &mut form[..3] {
            *sum += rest;
        }
        let size = form.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        let constant = if self.constant == 0.0 {
            0.0
        } else {
            self.constant.signum() / size
        };
        let rounded = Self {
            anchor,
            quadratic: form.map(|c| c / size),
            linear: DVec3::ZERO,
            constant,
        };
        let is_finite = rounded.quadratic.iter().all(|c| c.is_finite()) && constant.is_finite();
        (is_finite && size > 0.0).then_some(rounded)
    }

    /// Whether both half-spaces, of surfaces that nearly coincide, are on one side.
    fn is_aligned(&self, other: &Self) -> bool {
        let terms = |s: &Self| {
            if s.is_plane() {
                [s.linear.x, s.linear.y, s.linear.z, 0.0, 0.0, 0.0]
            } else {
                s.quadratic
            }
        };
        let products = terms(self).into_iter().zip(terms(other));
        products.map(|(a, b)| a * b).sum::<f64>() > 0.0
    }

    /// Bound, to first order, on the distance between this surface and another one of
    /// its kind, within a ball about the origin; infinite if they are not alike.
    ///
    /// If f is this one's function and D its difference to a multiple of the other
    /// one's, points of the other one are off this one by |D| / |∇f|.
    fn apart(&self, other: &Self, reach: f64) -> f64 {
        /// An eigenvalue below this share of the largest is none: only how large a
        /// gradient is depends on it.
        const NONE: f64 = 1e-10;
        if self.is_plane() != other.is_plane() {
            return f64::INFINITY;
        }
        let sign = if self.is_aligned(other) { 1.0 } else { -1.0 };
        if self.is_plane() {
            let offset = self.linear.dot(other.anchor - self.anchor).abs();
            let turn = (self.linear - sign * other.linear).length();
            return offset + turn * (reach + other.anchor.length());
        }
        let dot = |p: &[f64; 6], q: &[f64; 6]| -> f64 { p.iter().zip(q).map(|(p, q)| p * q).sum() };
        let factor =
            dot(&self.quadratic, &other.quadratic) / dot(&other.quadratic, &other.quadratic);
        let rest: [f64; 6] =
            std::array::from_fn(|k| self.quadratic[k] - factor * other.quadratic[k]);
        let form = dot(&rest, &rest).sqrt();
        let (linear, constant) = other.expanded_about(self.anchor);
        let linear = (self.linear - factor * linear).length();
        let constant = (self.constant - factor * constant).abs();
        let reach = reach + self.anchor.length();
        let (values, axes) = eigen_symmetric(self.quadratic);
        let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let is_none = |value: f64| value.abs() <= NONE * largest;
        let least = values.iter().filter(|&&v| !is_none(v));
        let least = least.fold(f64::INFINITY, |m, v| m.min(v.abs()));
        if self.apex().is_some() {
            // Both gradient and difference grow with the distance from the apex.
            return (form * reach + linear) / (2.0 * least) + (constant / least).sqrt();
        }
        let along = |k: usize| self.linear.dot(axes.col(k)).abs();
        let slope = (0..3).filter(|&k| is_none(values[k])).map(along);
        // On Σ v x² = c the square of the gradient is 4 Σ v² x², at least 4 |v c|.
        let gradient = slope
            .fold(0.0, f64::max)
            .max(2.0 * (least * self.constant.abs()).sqrt());
        ((form * reach + linear) * reach + constant) / gradient
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::evaluation::random_quadric;
    use crate::random::Random;
    use crate::solid::Solid;

    const BALL: (DVec3, f64) = (DVec3::ZERO, 2.0);

    fn lowered(solid: &Solid) -> Program {
        Program::lower(solid).expect("a valid solid")
    }

    fn number(random: &mut Random, low: f64, high: f64) -> f64 {
        low + (high - low) * random.unit()
    }

    fn turn(random: &mut Random) -> DQuat {
        let mut angle = || number(random, 0.0, 6.0);
        DQuat::from_euler(glam::EulerRot::XYZ, angle(), angle(), angle())
    }

    #[test]
    fn twins_are_one_if_they_are_nearer_than_what_is_asked() {
        type Shape = fn(f64) -> Solid;
        let shapes: [Shape; 4] = [
            |by| Solid::sphere(0.7 + by),
            |by| Solid::infinite_cylinder(0.7 + by),
            |by| Solid::ellipsoid([0.7 + by, 0.5 + by, 0.9 + by]),
            |by| Solid::half_space([0.0, 0.0, 1.0], by),
        ];
        let mut random = Random(5);
        for (k, shape) in shapes.iter().enumerate() {
            for power in 4..13 {
                let by = 10f64.powi(-power);
                let place = turn(&mut random);
                let move_by = DVec3::new(0.3, -0.2, 0.1);
                let place = glam::DAffine3::from_rotation_translation(place, move_by);
                let pose = |s: Solid| s.affine(place);
                let twins = lowered(&(pose(shape(0.0)) | pose(shape(by))));
                let far = twins.settled(BALL, 0.5 * by, 1.0).expect("room");
                assert!(far.is_none(), "{k}: {by} {far:?}");
                let near = twins.settled(BALL, 40.0 * by, 1.0).expect("room");
                let near = near.unwrap_or_else(|| panic!("{k}: {by} apart"));
                assert_eq!(
                    (near.merged, near.program.formula().literals().len()),
                    (1, 1)
                );
                assert!(
                    0.9 * by < near.moved && near.moved < 40.0 * by,
                    "{k}: {near:?}"
                );
            }
        }
    }

    #[test]
    fn complements_that_nearly_touch_fill_space() {
        let up = Solid::half_space([0.0, 0.0, 1.0], 0.1);
        let down = Solid::half_space([0.0, 1e-12, -1.0], -0.1 - 1e-12);
        let settled = lowered(&(up | down)).settled(BALL, 1e-11, 1e-3);
        let settled = settled.expect("room").expect("twins");
        assert!(settled.program.contains(DVec3::ZERO));
        assert_eq!(settled.program.root_cell().constant(), Some(true));
    }

    #[test]
    fn a_chain_is_one_surface_unless_it_is_too_long() {
        let chain = |step: f64| {
            let planes = (0..1000).map(|k| Solid::half_space([0.0, 0.0, 1.0], step * f64::from(k)));
            lowered(&planes.reduce(|a, b| a | b).expect("some"))
        };
        let settled = chain(1e-12).settled(BALL, 2e-12, 1e-8).expect("room");
        let settled = settled.expect("a chain");
        assert_eq!(settled.merged, 999);
        assert!((settled.moved - 999e-12).abs() < 1e-15, "{}", settled.moved);
        assert!(
            chain(1e-10)
                .settled(BALL, 2e-10, 1e-8)
                .expect("room")
                .is_none()
        );
    }

    /// Points of a surface in the ball, from random ones along its gradient.
    fn points(surface: &Surface, random: &mut Random) -> Vec<DVec3> {
        let on = |_| {
            let mut at =
                BALL.1 * (2.0 * DVec3::new(random.unit(), random.unit(), random.unit()) - 1.0);
            for _ in 0..30 {
                let gradient = surface.gradient(at);
                at -= surface.value(at) / gradient.length_squared() * gradient;
            }
            (at.length() < BALL.1 && surface.value(at).abs() < 1e-14).then_some(at)
        };
        (0..40).filter_map(on).collect()
    }

    #[test]
    fn nothing_is_rounded_or_stirred_farther_than_said() {
        let mut random = Random(9);
        let mut checked = 0;
        for case in 0..200 {
            let surface = random_quadric(&mut random);
            let most = 10f64.powf(number(&mut random, -6.0, -2.0));
            let program = Program {
                surfaces: vec![surface],
                ..lowered(&Solid::sphere(1.0))
            };
            for settled in [program.rounded(BALL, most), program.stirred(BALL, most)] {
                let Some(settled) = settled.expect("room") else {
                    continue;
                };
                let moved = settled.program.surfaces()[0];
                for at in points(&moved, &mut random) {
                    let gradient = surface.gradient(at).length();
                    if gradient < 0.1 {
                        continue;
                    }
                    let off = surface.value(at).abs() / gradient;
                    assert!(off <= 1.1 * most, "{case}: {off} for {most}");
                    checked += 1;
                }
            }
        }
        assert!(checked > 1000, "{checked}");
    }

    #[test]
    fn numbers_that_miss_round_ones_by_little_become_these() {
        let mut random = Random(2);
        for _ in 0..100 {
            let mut off = || 1e-9 * (2.0 * random.unit() - 1.0);
            let miss = |exact: f64, off: f64| exact + off;
            let posts = [
                Solid::infinite_cylinder(miss(0.25, off()))
                    .rotate_x(miss(std::f64::consts::FRAC_PI_2, off()))
                    .translate([miss(0.5, off()), 0.0, miss(-0.75, off())]),
                Solid::infinite_cylinder(miss(0.25, off()))
                    .rotate_x(miss(std::f64::consts::FRAC_PI_2, off()))
                    .translate([miss(0.5, off()), 0.0, miss(-0.75, off())]),
                Solid::infinite_cylinder(0.25)
                    .rotate_x(std::f64::consts::FRAC_PI_2)
                    .translate([0.5, 0.0, -0.75]),
            ];
            let [a, b, c] = posts;
            let rounded = lowered(&(a | b | c)).rounded(BALL, 1e-5).expect("room");
            let rounded = rounded.expect("twins");
            assert_eq!(rounded.program.formula().literals().len(), 1);
            let [surface] = [rounded.program.surfaces()[0]];
            assert_eq!(surface.anchor, DVec3::new(0.5, 0.0, -0.75));
            assert!((surface.constant + 0.0625).abs() < 1e-15, "{surface:?}");
        }
    }
}
