//! Surfaces that nearly coincide, made one: what differs by more than rounding, but
//! by less than can be told apart where a solid's boundary is evaluated, is decided
//! here, once, and for the whole solid.
//!
//! [`Program::lower`] unites what is the same surface but for the rounding of its
//! own arithmetic. What an author rounded, such as a radius of 0.3333333333 beside
//! one of a third, it leaves apart. Two such surfaces bound a wall or a gap too thin
//! for the arithmetic of what comes later, whose stages would have to decide one
//! after another whether it is there.

mod aligned;
mod chains;
mod distance;
mod element;
mod rounding;

use crate::elementary;
use std::sync::Arc;

use glam::DVec3;

use self::chains::Chains;
use self::rounding::Decimal;
use super::lower::{avalanche, simplified};
use super::lowered::Lowered;
use super::{Program, Surface, SurfaceId};
use crate::error::Error;

/// A program some of whose surfaces were moved, or replaced by others next to them.
#[derive(Clone, Debug)]
pub(crate) struct Settled {
    pub program: Program,
    /// How many surfaces were replaced by another one.
    pub merged: usize,
    /// Bound on how far any surface was moved, where the solid is.
    pub moved: f64,
    /// The same of each surface, by its number: of those that it is in place of.
    pub moves: Vec<f64>,
    /// The sum of how far those were off that were replaced by another one: what was between them
    /// is lost, or new.
    pub between: f64,
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
    pub(crate) fn merged(
        &self,
        (origin, reach): (DVec3, f64),
        within: f64,
        most: f64,
    ) -> Result<Option<Settled>, Error> {
        self.united(self.surfaces().to_vec(), (origin, reach), within, most)
    }

    /// The program with its surfaces moved, by no more than `within` where the solid is, until
    /// those touch, are flush or in line that miss it by less; then those that nearly coincide
    /// made one as by [`merged`](Self::merged). None if that changes nothing, or would move one
    /// farther than `most`.
    pub(crate) fn aligned(
        &self,
        (origin, reach): (DVec3, f64),
        (within, same): (f64, f64),
        most: f64,
    ) -> Result<Option<Settled>, Error> {
        let about = |s: &Surface| s.relative_to(origin);
        let before: Vec<Surface> = self.surfaces().iter().map(about).collect();
        let is_fixed = |index: usize| self.is_given(SurfaceId(index as u32));
        let Some(after) = aligned::aligned(&before, is_fixed, reach, (within, most)) else {
            return Ok(None);
        };
        let place =
            |((surface, before), after): ((&Surface, &Surface), Surface)| match after == *before {
                true => *surface,
                false => after.relative_to(-origin),
            };
        let surfaces = self.surfaces().iter().zip(&before).zip(after).map(place);
        self.united(surfaces.collect(), (origin, reach), same, most)
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
        /// Of what surfaces may move, by which a coordinate changes: three of a place and
        /// three of a direction, at right angles, and a size make (2 √3 + 1) / 5 < 1.
        const SHARE: f64 = 0.2;
        /// Of the last decimal: what is the same in decimals differs by rounding alone.
        const SAME_DECIMALS: f64 = 1e-3;
        let step = Decimal::below(SHARE * most);
        let turn = Decimal::below(SHARE * most / reach);
        let round = |index: u32, surface: &Surface| {
            if self.is_given(SurfaceId(index)) {
                return None;
            }
            let rounded = surface.rounded((origin, reach), step, turn)?;
            let [one, other] = [surface, &rounded].map(|s| s.relative_to(origin));
            (one.distance_bound(&other, reach) <= most).then_some(rounded)
        };
        let surfaces = (0..).zip(self.surfaces());
        let surfaces = surfaces.map(|(k, s)| round(k, s).unwrap_or(*s)).collect();
        self.united(surfaces, (origin, reach), SAME_DECIMALS * step.step(), most)
    }

    /// The program with every surface that is meant moved on its own, by up to `most` where
    /// the solid is, and a fifth of that at least: what touches or meets by chance, more than
    /// two surfaces in a curve or three in a point, then clearly does or does not. What is
    /// one surface stays one, and curved surfaces that nearly coincide move together: walls
    /// and gaps between them that are thinner than the moves stay. The same moves in every run. None if no surface is
    /// meant.
    pub(crate) fn perturbed(
        &self,
        (origin, reach): (DVec3, f64),
        most: f64,
        is_meant: impl Fn(&Surface) -> bool,
    ) -> Result<Option<Settled>, Error> {
        /// Of the moves: what is nearer is a wall or a gap that is meant.
        const TOGETHER: f64 = 8.0;
        let about: Vec<Surface> = self
            .surfaces()
            .iter()
            .map(|s| s.relative_to(origin))
            .collect();
        let chains = Chains::of(&about, reach, TOGETHER * most);
        let mut leaders: Vec<usize> = (0..about.len()).collect();
        for chain in chains.longer_than_one() {
            for &other in chain.iter().filter(|&&k| !about[k as usize].is_plane()) {
                leaders[other as usize] = chain[0] as usize;
            }
        }
        let perturb = |(index, surface): (usize, &Surface)| {
            let leader = leaders[index];
            if !is_meant(surface) && !is_meant(&self.surfaces()[leader]) {
                return *surface;
            }
            let number = |k: u64| {
                let bits =
                    avalanche((4 * leader as u64 + k + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
                2.0 * (bits >> 11) as f64 * elementary::exp2(-53.0_f64) - 1.0
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
        let surfaces = (0..).zip(self.surfaces()).map(perturb).collect();
        let perturbed = self.united(surfaces, (origin, reach), 0.0, f64::INFINITY)?;
        // What is moved as a whole is nowhere moved farther.
        Ok(perturbed.map(|perturbed| Settled {
            moved: most,
            moves: perturbed.moves.iter().map(|by| by.min(most)).collect(),
            ..perturbed
        }))
    }

    /// Whether a surface carries faces whose vertices were given: it stays where these are.
    fn is_given(&self, surface: SurfaceId) -> bool {
        let given = self.given();
        given.is_some_and(|given| given.has_faces(surface) || given.is_cut(surface))
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
        let before: Vec<Surface> = self.surfaces().iter().map(about).collect();
        let after: Vec<Surface> = surfaces.iter().map(about).collect();
        let chains = Chains::of(&after, reach, within);
        let mut in_place: Vec<(u32, bool)> = (0..surfaces.len() as u32)
            .map(|index| (index, false))
            .collect();
        let mut merged = 0;
        for chain in chains.longer_than_one() {
            let first = chain[0];
            let one = &after[first as usize];
            let off = |&other: &u32| one.distance_bound(&before[other as usize], reach);
            if chain.iter().map(off).fold(0.0, f64::max) > most {
                continue;
            }
            for &other in &chain[1..] {
                let is_flipped = !one.is_aligned(&after[other as usize]);
                in_place[other as usize] = (first, is_flipped);
            }
            merged += chain.len() - 1;
        }
        let mut moves = vec![0.0; surfaces.len()];
        let (mut moved, mut between, mut place) = (0.0, 0.0, DVec3::ZERO);
        for ((own, surface), &(index, _)) in (0..).zip(&before).zip(&in_place) {
            let now = &after[index as usize];
            // Most are where they were.
            if surface == now {
                continue;
            }
            let off = surface.distance_bound(now, reach);
            let of_this = &mut moves[index as usize];
            *of_this = off.max(*of_this);
            between += if index == own { 0.0 } else { off };
            if off >= moved {
                (moved, place) = (off, surface.anchor);
            }
        }
        if moved == 0.0 && merged == 0 {
            return Ok(None);
        }
        let mut formula = self.formula().clone();
        let literals = formula.literals.iter_mut();
        let is_changed: Vec<bool> = literals
            .map(|literal| {
                let before = literal.surface;
                let (surface, is_flipped) = in_place[before as usize];
                literal.surface = surface;
                literal.outside ^= is_flipped;
                surface != before
            })
            .collect();
        // Edges and vertices of faces that were moved are elsewhere.
        let is_in_place = |id: u32| {
            let id = id as usize;
            surfaces[id] == self.surfaces()[id]
        };
        let mut ids = 0..surfaces.len() as u32;
        let are_in_place = ids.all(|id| !self.is_given(SurfaceId(id)) || is_in_place(id));
        let given = self.given().filter(|_| are_in_place);
        let given = given.map(|given| {
            let in_place = |id: SurfaceId| SurfaceId(in_place[id.index()].0);
            given.renumbered(in_place, &surfaces, moved)
        });
        Ok(Some(Settled {
            program: Self::of(Lowered {
                surfaces,
                formula: simplified(&formula, &is_changed)?,
                origins: self.origins().to_vec(),
                reach: self.reach().grown(moved),
                given: given.map(Arc::new),
            }),
            merged,
            moved,
            moves,
            between,
            place: place + origin,
        }))
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::arrangement::random_quadric;
    use crate::random::Random;
    use crate::solid::Solid;
    use crate::surface::SurfaceShape;

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
                let far = twins.merged(BALL, 0.5 * by, 1.0).expect("room");
                assert!(far.is_none(), "{k}: {by} {far:?}");
                let near = twins.merged(BALL, 40.0 * by, 1.0).expect("room");
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

    /// A ball in a round hole of its radius, between a plane that both touch and one through its
    /// centre, each of which misses by as little.
    #[test]
    fn what_misses_by_little_is_moved_until_it_does_not() {
        let mut random = Random(7);
        for case in 0..200 {
            let miss = 10f64.powi(-7 - case % 6);
            let place = turn(&mut random);
            let place =
                glam::DAffine3::from_rotation_translation(place, DVec3::new(0.3, -0.2, 0.1));
            let mut off = || miss * (2.0 * random.unit() - 1.0);
            let solid = Solid::infinite_cylinder(0.5 + off())
                .rotate_x(off())
                .translate([off(), off(), 0.0])
                | Solid::sphere(0.5 + off()).translate([off(), off(), 0.3 + off()])
                | Solid::half_space([1.0, off(), off()], 0.5 + off())
                | Solid::half_space([off(), off(), 1.0], 0.3 + off());
            let before = lowered(&solid.affine(place));
            let aligned = before.aligned(BALL, (10.0 * miss, 0.0), 100.0 * miss);
            let aligned = aligned.expect("room").expect("misses");
            assert!(aligned.moved < 60.0 * miss, "{case}: {}", aligned.moved);
            let shapes = aligned.program.surfaces().iter().map(Surface::shape);
            let (mut rod, mut ball, mut planes) = (None, None, Vec::new());
            for shape in shapes {
                match shape {
                    SurfaceShape::Cylinder {
                        point,
                        axis,
                        radius,
                    } => rod = Some((point, axis, radius)),
                    SurfaceShape::Sphere { center, radius } => ball = Some((center, radius)),
                    SurfaceShape::Plane { point, normal } => planes.push((point, normal)),
                    other => panic!("{other:?}"),
                }
            }
            let (point, axis, radius) = rod.expect("a cylinder");
            let (center, of_ball) = ball.expect("a sphere");
            let mut values = vec![
                (center - point).reject_from(axis).length(),
                radius - of_ball,
            ];
            for (on, normal) in planes {
                let along = normal.dot(axis).abs();
                let height = (on - center).dot(normal);
                let touches = if along > 0.5 { 0.0 } else { of_ball };
                values.push(height.abs() - touches);
                values.push(along.min(1.0 - along));
            }
            let left = values
                .iter()
                .fold(0.0f64, |most, value| most.max(value.abs()));
            assert!(left < 2e-14, "{case}: {values:?}");
        }
    }

    /// Balls in the corners of an icosahedron and rods along its edges, nearly round all of them,
    /// whose directions do not fit the places: each rod ends in two balls once all is moved.
    #[test]
    fn frames_of_rods_that_miss_their_balls_are_turned_until_they_do_not() {
        const MISS: f64 = 1e-6;
        let mut random = Random(3);
        let mut off = || MISS * (2.0 * random.unit() - 1.0);
        let golden = 0.5 * (1.0 + 5f64.sqrt());
        let corners = (0..3).flat_map(|axis| {
            [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)].map(|(a, b)| {
                let mut corner = [0.0; 3];
                corner[axis] = a;
                corner[(axis + 1) % 3] = b * golden;
                0.9 * DVec3::from(corner)
            })
        });
        let corners: Vec<DVec3> = corners.collect();
        let mut askew = |solid: Solid, at: DVec3, turned: DQuat| {
            let mut place = glam::DAffine3::from_rotation_translation(turned, at);
            let numbers = &mut place.matrix3;
            for column in [
                &mut numbers.x_axis,
                &mut numbers.y_axis,
                &mut numbers.z_axis,
            ] {
                *column += DVec3::new(off(), off(), off());
            }
            place.translation += DVec3::new(off(), off(), off());
            solid.affine(place)
        };
        let mut parts: Vec<Solid> = Vec::new();
        for (k, &one) in corners.iter().enumerate() {
            parts.push(askew(Solid::sphere(0.2), one, DQuat::IDENTITY));
            for &other in corners[..k].iter().filter(|c| c.distance(one) < 1.9) {
                let along = DQuat::from_rotation_arc(DVec3::Z, (other - one).normalize());
                parts.push(askew(Solid::infinite_cylinder(0.2), one, along));
            }
        }
        assert_eq!(parts.len(), 42);
        let before = lowered(&parts.into_iter().reduce(|a, b| a | b).expect("some"));
        let aligned = before.aligned(BALL, (10.0 * MISS, 0.0), 100.0 * MISS);
        let aligned = aligned.expect("room").expect("misses");
        assert!(aligned.moved < 10.0 * MISS, "{}", aligned.moved);
        let shapes: Vec<SurfaceShape> = aligned
            .program
            .surfaces()
            .iter()
            .map(Surface::shape)
            .collect();
        let balls: Vec<(DVec3, f64)> = shapes
            .iter()
            .filter_map(|shape| match *shape {
                SurfaceShape::Sphere { center, radius } => Some((center, radius)),
                _ => None,
            })
            .collect();
        assert_eq!(balls.len(), 12);
        let mut rods = 0;
        for shape in &shapes {
            if let SurfaceShape::Cylinder {
                point,
                axis,
                radius,
            } = *shape
            {
                let miss = |&(center, size): &(DVec3, f64)| {
                    (center - point)
                        .reject_from(axis)
                        .length()
                        .max((size - radius).abs())
                };
                let mut misses: Vec<f64> = balls.iter().map(miss).collect();
                misses.sort_by(f64::total_cmp);
                assert!(misses[1] < 2e-14 && misses[2] > 0.1, "{misses:?}");
                rods += 1;
            }
        }
        assert_eq!(rods, 30);
    }

    #[test]
    fn complements_that_nearly_touch_fill_space() {
        let up = Solid::half_space([0.0, 0.0, 1.0], 0.1);
        let down = Solid::half_space([0.0, 1e-12, -1.0], -0.1 - 1e-12);
        let settled = lowered(&(up | down)).merged(BALL, 1e-11, 1e-3);
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
        let settled = chain(1e-12).merged(BALL, 2e-12, 1e-8).expect("room");
        let settled = settled.expect("a chain");
        assert_eq!(settled.merged, 999);
        assert!((settled.moved - 999e-12).abs() < 1e-15, "{}", settled.moved);
        assert!(
            chain(1e-10)
                .merged(BALL, 2e-10, 1e-8)
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
    fn nothing_is_rounded_or_perturbed_farther_than_said() {
        let mut random = Random(9);
        let mut checked = 0;
        for case in 0..200 {
            let surface = random_quadric(&mut random);
            let most = 10f64.powf(number(&mut random, -6.0, -2.0));
            let program = Program::of(Lowered {
                surfaces: vec![surface],
                ..lowered(&Solid::sphere(1.0)).lowered().clone()
            });
            for settled in [
                program.rounded(BALL, most),
                program.perturbed(BALL, most, |_| true),
            ] {
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
    fn thin_walls_move_as_a_whole() {
        let pose = |s: Solid| s.rotate_x(0.4).rotate_z(1.1).translate([0.2, -0.1, 0.3]);
        let wall = |by: f64| {
            let walls = [
                Solid::sphere(0.7) - Solid::sphere(0.7 - by),
                Solid::infinite_cylinder(0.6) - Solid::infinite_cylinder(0.6 - by),
                Solid::ellipsoid([0.4, 0.3, 0.5])
                    - Solid::ellipsoid([0.4, 0.3, 0.5]).scale(1.0 - by),
            ];
            lowered(&pose(walls.into_iter().reduce(|a, b| a | b).expect("some")))
        };
        for power in 4..12 {
            let by = 10f64.powi(-power);
            let before = wall(by);
            let after = before
                .perturbed(BALL, 1e-3, |_| true)
                .expect("room")
                .expect("moved");
            for (pair, moved) in before
                .surfaces()
                .chunks(2)
                .zip(after.program.surfaces().chunks(2))
            {
                assert!(moved[0].anchor.distance(pair[0].anchor) > 1e-4);
                let [was, is] = [pair, moved].map(|p| p[1].anchor - p[0].anchor);
                assert!(is.distance(was) < 1e-15, "{by}: {was} {is}");
            }
        }
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
