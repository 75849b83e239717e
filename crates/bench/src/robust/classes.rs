//! Random solids of the classes on which meshers fail: each puts surfaces where they
//! nearly coincide, touch or run beside each other, on purpose.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use csg::{Primitive, Solid};
use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::features::features;
use crate::judge::Random;
use crate::random_tree::{Position, random_tree};

/// What the parts of a random solid are to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Class {
    /// Of up to 40 primitives on a lattice, of few sizes, with shared transforms.
    Special,
    /// Of up to 8 at round places and angles.
    Aligned,
    /// Anywhere, of any size, with repeated holes.
    General,
    /// On a grid of quarters, turned by right angles and mirrored.
    Grid,
    /// The same, but sizes, places and angles are off by 1e-6 to 1e-13.
    Nudged,
    /// Leaves united with a twin off by 1e-11 to 1e-15, or mapped there and back.
    Twins,
    /// Balls, rods and cones that touch, cut and united with boxes.
    Packed,
    /// Needles, sheets and flat ellipsoids, a hundred to ten thousand times as long as
    /// thick.
    Thin,
    /// At round places and angles, repeated around axes, each placed by matrices of six digits,
    /// as OpenSCAD writes them.
    Written,
    /// Countersinks, round ends, bosses and other features that touch on purpose, repeated around
    /// axes and mirrored, half of them placed by matrices of six digits.
    Features,
}

impl Class {
    /// The same solid for the same seed.
    pub fn solid(self, seed: u64) -> Solid {
        let mut random = Random(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ self as u64);
        match self {
            Self::Special => random_tree(seed, Position::Special),
            Self::Aligned => random_tree(seed, Position::Aligned),
            Self::General => general(&mut random),
            Self::Grid => on_grid(&mut random, &mut |_| 0.0),
            Self::Nudged => on_grid(&mut random, &mut nudge),
            Self::Twins => twins(&mut random),
            Self::Packed => packed(&mut random),
            Self::Thin => thin(&mut random),
            Self::Written => written(&mut random),
            Self::Features => features(&mut random),
        }
    }
}

/// Half of the time nothing, else up to 1e-6, and down to 1e-13.
fn nudge(random: &mut Random) -> f64 {
    if random.below(2) == 0 {
        return 0.0;
    }
    signed_power(random, -13.0, -6.0)
}

/// Ten to some power, of either sign.
fn signed_power(random: &mut Random, low: f64, high: f64) -> f64 {
    let size = 10f64.powf(between(random, low, high));
    if random.below(2) == 0 { size } else { -size }
}

fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit()
}

fn point(random: &mut Random, reach: f64) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| between(random, -reach, reach)))
}

fn turn(random: &mut Random) -> DQuat {
    let axis = point(random, 1.0).try_normalize().unwrap_or(DVec3::Z);
    DQuat::from_axis_angle(axis, between(random, 0.0, TAU))
}

/// One operation after another, in any order: mostly unions, then differences.
pub(super) fn combined(random: &mut Random, mut parts: Vec<Solid>) -> Solid {
    while parts.len() > 1 {
        let one = parts.swap_remove(random.below(parts.len()));
        let other = parts.swap_remove(random.below(parts.len()));
        parts.push(match random.below(8) {
            0..4 => one | other,
            4..7 => one - other,
            _ => one & other,
        });
    }
    parts.pop().unwrap_or_else(Solid::empty)
}

/// A primitive of sizes from the source.
fn leaf(random: &mut Random, size: &mut dyn FnMut(&mut Random) -> f64) -> Solid {
    let [a, b, c] = [(); 3].map(|()| size(random));
    match random.below(9) {
        0..3 => Solid::cuboid([a, b, c]),
        3 => Solid::sphere(a),
        4 | 5 => Solid::cylinder(a, -b..c),
        6 => Solid::cone(a, -b..c),
        7 => Solid::frustum(a, b, 0.0..c),
        _ => Solid::ellipsoid([a, b, c]),
    }
}

fn general(random: &mut Random) -> Solid {
    let size = &mut |random: &mut Random| between(random, 0.2, 1.2);
    let mut parts: Vec<Solid> = (0..2 + random.below(7))
        .map(|_| {
            let leaf = leaf(random, size);
            leaf.rotate_by(turn(random)).translate(point(random, 1.0))
        })
        .collect();
    if random.below(3) == 0 {
        // A plate with holes around or along it.
        let radius = between(random, 0.03, 0.12);
        let hole = Solid::cylinder(radius, -2.0..2.0);
        let count = 3 + random.below(10);
        let is_round = random.below(2) == 0;
        let holes = (0..count).map(|i| {
            let share = i as f64 / count as f64;
            if is_round {
                hole.translate([0.7, 0.0, 0.0]).rotate_z(TAU * share)
            } else {
                hole.translate([2.0 * share - 0.9, 0.1, 0.0])
            }
        });
        let plate = Solid::cuboid([2.2, 2.1, between(random, 0.1, 0.8)]);
        let drilled = plate - Solid::union(holes);
        parts.push(drilled.rotate_by(turn(random)));
    }
    combined(random, parts)
}

/// Of quarters and right angles, each off by what the source says.
fn on_grid(random: &mut Random, off: &mut dyn FnMut(&mut Random) -> f64) -> Solid {
    let parts = (0..2 + random.below(7)).map(|_| on_grid_leaf(random, off));
    let parts = parts.collect();
    combined(random, parts)
}

fn on_grid_leaf(random: &mut Random, off: &mut dyn FnMut(&mut Random) -> f64) -> Solid {
    let mut size = |random: &mut Random| 0.25 * (1 + random.below(6)) as f64 + off(random);
    let mut solid = leaf(random, &mut size);
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let angle = FRAC_PI_2 * random.below(4) as f64 + off(random);
        solid = solid.rotate_by(DQuat::from_axis_angle(axis, angle));
    }
    if random.below(4) == 0 {
        solid = solid.mirror([0.0; 3], [DVec3::X, DVec3::Y, DVec3::Z][random.below(3)]);
    }
    let place = [(); 3].map(|()| 0.25 * (random.below(9) as f64 - 4.0) + off(random));
    solid.translate(place)
}

fn twins(random: &mut Random) -> Solid {
    let parts = (0..1 + random.below(5)).map(|_| {
        let leaf = on_grid_leaf(random, &mut |_| 0.0);
        let tiny = signed_power(random, -15.0, -11.0);
        let twin = match random.below(4) {
            0 => leaf.scale(1.0 + tiny),
            1 => leaf.translate(tiny * point(random, 1.0)),
            2 => leaf.rotate_about_axis([0.3, 0.5, 0.8], tiny),
            _ => {
                // There and back.
                let (turn, by) = (turn(random), point(random, 100.0));
                leaf.rotate_by(turn)
                    .translate(by)
                    .translate(-by)
                    .rotate_by(turn.inverse())
            }
        };
        match random.below(6) {
            0 => twin,
            1 => leaf - twin,
            _ => leaf | twin,
        }
    });
    let parts = parts.collect();
    combined(random, parts)
}

fn packed(random: &mut Random) -> Solid {
    let r = 0.25 * (1 + random.below(3)) as f64;
    let touching = match random.below(6) {
        0 => balls(random, r),
        1 => rods(random, r),
        2 => crossing_rods(random, r),
        3 => cones_on_a_ruling(random),
        4 => cones_about_an_apex(random),
        _ => row(random, r),
    };
    let mut solid = Solid::union(touching);
    for _ in 0..random.below(4) {
        let size = &mut |random: &mut Random| 0.25 * (1 + random.below(8)) as f64;
        let [a, b, c] = [(); 3].map(|()| size(random));
        let place = [(); 3].map(|()| 0.25 * (random.below(9) as f64 - 4.0));
        let block = Solid::cuboid([a, b, c]).translate(place);
        solid = match random.below(5) {
            0 | 1 => solid | block,
            2 => solid & block,
            _ => solid - block,
        };
    }
    if random.below(3) == 0 {
        solid = solid.rotate_by(turn(random));
    }
    solid
}

/// Cubic or close-packed.
fn balls(random: &mut Random, r: f64) -> Vec<Solid> {
    let close = [
        [2.0 * r, 0.0, 0.0],
        [r, 3f64.sqrt() * r, 0.0],
        [r, r / 3f64.sqrt(), (8.0f64 / 3.0).sqrt() * r],
    ];
    let cubic = [
        [2.0 * r, 0.0, 0.0],
        [0.0, 2.0 * r, 0.0],
        [0.0, 0.0, 2.0 * r],
    ];
    let steps = [close, cubic][random.below(2)].map(DVec3::from_array);
    let counts = [(); 3].map(|()| 1 + random.below(3));
    let mut balls = Vec::new();
    for i in 0..counts[0] {
        for j in 0..counts[1] {
            for k in 0..counts[2] {
                let place = steps[0] * i as f64 + steps[1] * j as f64 + steps[2] * k as f64;
                balls.push(Solid::sphere(r).translate(place - DVec3::splat(r)));
            }
        }
    }
    balls
}

/// Side by side, of one radius or two.
fn rods(random: &mut Random, r: f64) -> Vec<Solid> {
    let other = [r, 0.5 * r][random.below(2)];
    let mut x = -1.0;
    (0..2 + random.below(4))
        .map(|i| {
            let radius = [r, other][i % 2];
            x += if i == 0 { 0.0 } else { r + other };
            let low = -0.25 * (1 + random.below(4)) as f64;
            let rod = Solid::cylinder(radius, low..low + 0.25 * (2 + random.below(4)) as f64);
            rod.translate([x, 0.0, 0.0])
        })
        .collect()
}

/// Layers, each across the one below and touching it.
fn crossing_rods(random: &mut Random, r: f64) -> Vec<Solid> {
    let angle = [FRAC_PI_2, PI / 3.0, 1.0][random.below(3)];
    let mut rods = Vec::new();
    for layer in 0..2 + random.below(2) {
        for i in 0..1 + random.below(3) {
            let rod = Solid::cylinder(r, -1.25..1.25).rotate_x(FRAC_PI_2);
            let place = [2.0 * r * i as f64 - r, 0.0, 2.0 * r * layer as f64 - r];
            rods.push(rod.translate(place).rotate_z(angle * layer as f64));
        }
    }
    rods
}

/// Of one angle with parallel axes, their apexes along one ruling: each touches the next
/// from within.
fn cones_on_a_ruling(random: &mut Random) -> Vec<Solid> {
    let slope = [0.5, 1.0, 0.75][random.below(3)];
    (0..2 + random.below(3))
        .map(|_| {
            let height = 0.25 * (2 + random.below(5)) as f64;
            let along = 0.25 * random.below(5) as f64;
            let cone = Solid::frustum(slope * height, 0.0, -height..0.0);
            cone.translate([-slope * along, 0.0, -along])
        })
        .collect()
}

/// With one apex, each touching the next from outside along a ruling.
fn cones_about_an_apex(random: &mut Random) -> Vec<Solid> {
    let mut angle: f64 = 0.0;
    let mut before = 0.0;
    (0..2 + random.below(3))
        .map(|i| {
            let half = [PI / 6.0, PI / 8.0, 0.4][random.below(3)];
            angle += if i == 0 { 0.0 } else { before + half };
            before = half;
            let height = 0.25 * (2 + random.below(4)) as f64;
            let cone = Solid::frustum(height * half.tan(), 0.0, -height..0.0);
            cone.rotate_y(angle)
        })
        .collect()
}

/// Things of any kind in a row, each touching the next and the ground.
fn row(random: &mut Random, r: f64) -> Vec<Solid> {
    let mut things = Vec::new();
    let mut x = -1.0;
    for _ in 0..2 + random.below(5) {
        x += r;
        let half = r * [1.0, 0.5][random.below(2)];
        let thing = match random.below(5) {
            0 => Solid::sphere(r),
            1 => Solid::cylinder(r, -r..half),
            2 => Solid::cylinder(r, -half..half).rotate_x(FRAC_PI_2),
            3 => Solid::frustum(r, 0.0, -r..half),
            _ => Solid::cuboid([2.0 * r, 2.0 * half, 2.0 * r]),
        };
        things.push(thing.translate([x, 0.0, 0.0]));
        x += r;
    }
    if random.below(2) == 0 {
        let ground = Solid::cuboid([2.0 * r + x + 1.0, 2.0, 0.25]);
        things.push(ground.translate([0.5 * (x - 1.0), 0.0, -r - 0.125]));
    }
    things
}

fn thin(random: &mut Random) -> Solid {
    let parts = (0..1 + random.below(4)).map(|_| {
        let aspect = 10f64.powf(between(random, 2.0, 4.0));
        let long = between(random, 0.5, 2.0);
        let short = long / aspect;
        // A needle is thin twice, a sheet once.
        let middle = [short, long * between(random, 0.3, 1.0)][random.below(2)];
        let thin = match random.below(6) {
            0 => Solid::cuboid([2.0 * long, 2.0 * middle, 2.0 * short]),
            1 => Solid::cylinder(short, -long..long),
            2 => Solid::cylinder(long, -short..short),
            3 => Solid::cone(short, 0.0..long),
            4 => Solid::ellipsoid([long, middle, short]),
            _ => Solid::sphere(1.0)
                .affine(DAffine3::from_mat3(sheared(random, [long, middle, short]))),
        };
        thin.rotate_by(turn(random)).translate(point(random, 0.5))
    });
    let mut parts: Vec<Solid> = parts.collect();
    if random.below(2) == 0 {
        let size = &mut |random: &mut Random| between(random, 0.3, 0.8);
        let block = leaf(random, size);
        parts.push(block.translate(point(random, 0.5)));
    }
    combined(random, parts)
}

/// Sizes along the axes, and a shear of one by another.
fn sheared(random: &mut Random, sizes: [f64; 3]) -> DMat3 {
    let by = between(random, -1.0, 1.0);
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.0, 1.0, by), DVec3::Z);
    shear * DMat3::from_diagonal(DVec3::from_array(sizes))
}

fn written(random: &mut Random) -> Solid {
    let axis = |random: &mut Random| [DVec3::X, DVec3::Y, DVec3::Z][random.below(3)];
    let parts = (0..1 + random.below(4)).map(|_| {
        let size = &mut |random: &mut Random| 0.25 * (1 + random.below(6)) as f64;
        let leaf = leaf(random, size);
        let turn = DQuat::from_axis_angle(axis(random), PI / 12.0 * random.below(24) as f64);
        let place = [(); 3].map(|()| 0.25 * (random.below(5) as f64 - 2.0));
        let placed = DAffine3::from_rotation_translation(turn, place.into());
        let leaf = leaf.affine(in_six_digits(placed));
        let count = [1, 1, 2, 3, 4, 5, 6, 8][random.below(8)];
        let axis = axis(random);
        Solid::union((0..count).map(|k| {
            let turn = DQuat::from_axis_angle(axis, TAU * f64::from(k) / f64::from(count));
            leaf.affine(in_six_digits(DAffine3::from_quat(turn)))
        }))
    });
    let parts = parts.collect();
    let mut solid = combined(random, parts);
    for _ in 0..random.below(3) {
        let placed = DAffine3::from_rotation_translation(turn(random), point(random, 50.0));
        solid = solid.affine(in_six_digits(placed));
    }
    solid
}

pub(super) fn in_six_digits(map: DAffine3) -> DAffine3 {
    let numbers = map.to_cols_array().map(|number| {
        let written = format!("{number:.5e}");
        written.parse().unwrap_or(number)
    });
    DAffine3::from_cols_array(&numbers)
}

/// How many primitives a solid has.
pub fn primitives(solid: &Solid) -> usize {
    match solid.node() {
        csg::Node::Primitive(Primitive::Empty) => 0,
        csg::Node::Primitive(_) => 1,
        node => node.operands().iter().map(primitives).sum(),
    }
}
