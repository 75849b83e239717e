//! Random solids that are hard on a mesher: primitives of every kind, with shared
//! transforms, coincident faces and contacts, or in general position.

use csg::Solid;
use glam::{DAffine3, DVec3, EulerRot};

/// How primitives lie to each other.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Position {
    /// Placements are shared and on a lattice, sizes few: faces and axes
    /// coincide, and surfaces touch.
    Special,
    /// Anywhere, of any size.
    General,
    /// A few of them as people put them together: sizes and places are multiples of
    /// a quarter, and axes turned by multiples of 15 degrees, mostly not at all.
    Aligned,
}

/// A bounded solid of up to 40 primitives; the same for the same seed.
pub fn random_tree(seed: u64, position: Position) -> Solid {
    let mut random = Random {
        state: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d,
        position,
    };
    let shared: Vec<DAffine3> = (0..3).map(|_| placement(&mut random)).collect();
    let primitives = match position {
        Position::Aligned => 2 + random.below(7),
        Position::Special | Position::General => 1 + random.below(40),
    };
    let body = tree(&mut random, primitives, &shared);
    Solid::cuboid([4.0, 4.0, 4.0]) & body
}

fn tree(random: &mut Random, primitives: u32, shared: &[DAffine3]) -> Solid {
    if primitives == 1 {
        let place = match random.below(4) {
            _ if random.position != Position::Special => placement(random),
            0 => placement(random),
            1 => DAffine3::from_translation(lattice_point(random)),
            n => shared[(n as usize + random.below(2) as usize) % shared.len()],
        };
        return primitive(random).affine(place);
    }
    let left = 1 + random.below(primitives - 1);
    let a = tree(random, left, shared);
    let b = tree(random, primitives - left, shared);
    match random.below(8) {
        0..4 => a | b,
        4..7 => a - b,
        _ => a & b,
    }
}

fn size(random: &mut Random) -> f64 {
    match random.position {
        Position::Special | Position::Aligned => 0.25 * f64::from(1 + random.below(5)),
        Position::General => 0.25 + random.unit(),
    }
}

fn lattice_point(random: &mut Random) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| 0.25 * (f64::from(random.below(9)) - 4.0)))
}

fn place(random: &mut Random) -> DVec3 {
    match random.position {
        Position::Special | Position::Aligned => lattice_point(random),
        Position::General => DVec3::from_array([(); 3].map(|()| 2.0 * random.unit() - 1.0)),
    }
}

fn placement(random: &mut Random) -> DAffine3 {
    let [x, y, z] = [(); 3].map(|()| angle(random));
    let turn = glam::DQuat::from_euler(EulerRot::ZYX, z, y, x);
    DAffine3::from_rotation_translation(turn, place(random))
}

fn angle(random: &mut Random) -> f64 {
    match random.position {
        Position::Aligned => match random.below(4) {
            0 => (15.0 * f64::from(random.below(24))).to_radians(),
            1 => (90.0 * f64::from(random.below(4))).to_radians(),
            _ => 0.0,
        },
        Position::Special | Position::General => random.unit() * std::f64::consts::TAU,
    }
}

fn primitive(random: &mut Random) -> Solid {
    let r = size(random);
    let height = -size(random)..size(random);
    match random.below(9) {
        0 | 1 => Solid::cube(2.0 * r),
        2 => Solid::cuboid([r, size(random), size(random)]),
        3 => Solid::sphere(r),
        4 => Solid::cylinder(r, height),
        5 => Solid::cone(r, height),
        6 => Solid::frustum(r, size(random), height),
        7 => Solid::ellipsoid([r, size(random), size(random)]),
        _ => {
            let corners = 3 + random.below(5);
            let polygon = (0..corners).map(|i| {
                let angle = f64::from(i) / f64::from(corners) * std::f64::consts::TAU;
                [r * angle.cos(), r * angle.sin()]
            });
            Solid::prism(polygon, height)
        }
    }
}

/// Steele, Lea and Flood's SplitMix64 (2014).
struct Random {
    state: u64,
    position: Position,
}

impl Random {
    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// 0 to `end` - 1.
    fn below(&mut self, end: u32) -> u32 {
        (((self.next() >> 32) * u64::from(end)) >> 32) as u32
    }

    /// 0 to 1.
    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 * (-53.0_f64).exp2()
    }
}
