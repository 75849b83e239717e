//! Random parts of features whose surfaces touch on purpose, as engineers place them.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, TAU};

use csg::Solid;
use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::classes::{combined, in_six_digits};
use crate::judge::Random;

/// Of up to three features at round places and angles, one in three repeated around an axis, one in
/// four mirrored; half of the solids are placed by matrices of six digits, half are cut by a block.
pub(super) fn features(random: &mut Random) -> Solid {
    let is_written = random.below(2) == 0;
    let place = |solid: &Solid, map: DAffine3| {
        solid.affine(if is_written { in_six_digits(map) } else { map })
    };
    let parts = (0..1 + random.below(3)).map(|_| {
        let one = place(&feature(random), placed(random));
        let axis = [DVec3::X, DVec3::Y, DVec3::Z][random.below(3)];
        match random.below(12) {
            0..4 => {
                let count = [2, 3, 4, 6][random.below(4)];
                Solid::union((0..count).map(|k| {
                    let angle = TAU * f64::from(k) / f64::from(count);
                    place(&one, DAffine3::from_axis_angle(axis, angle))
                }))
            }
            4..7 => {
                let mirror = DMat3::from_diagonal(DVec3::ONE - 2.0 * axis);
                one.clone() | one.affine(DAffine3::from_mat3(mirror))
            }
            _ => one,
        }
    });
    let parts = parts.collect();
    let solid = combined(random, parts);
    if random.below(2) == 0 {
        return solid;
    }
    let sides = [(); 3].map(|()| [0.5, 1.0, 2.0][random.below(3)]);
    let at = [(); 3].map(|()| [0.0, 0.25, 0.5, 1.0][random.below(4)]);
    let turn = DQuat::from_rotation_z([0.0, FRAC_PI_4][random.below(2)]);
    let block = Solid::cuboid(sides);
    let block = place(&block, DAffine3::from_rotation_translation(turn, at.into()));
    if random.below(2) == 0 {
        solid - block
    } else {
        solid & block
    }
}

fn placed(random: &mut Random) -> DAffine3 {
    let at = [(); 3].map(|()| [-1.0, -0.5, -0.25, 0.0, 0.25, 0.5, 1.0][random.below(7)]);
    let turn = match random.below(5) {
        0 => DQuat::IDENTITY,
        1 => DQuat::from_rotation_x(FRAC_PI_2),
        2 => DQuat::from_rotation_y(FRAC_PI_2),
        3 => DQuat::from_rotation_y(FRAC_PI_4),
        _ => DQuat::from_rotation_z(FRAC_PI_6) * DQuat::from_rotation_x(FRAC_PI_4),
    };
    DAffine3::from_rotation_translation(turn, at.into())
}

fn feature(random: &mut Random) -> Solid {
    let r = [0.25, 0.5, 0.75, 1.0][random.below(4)];
    let h = [0.5, 1.0, 1.5][random.below(3)];
    let rod = Solid::cylinder(r, 0.0..h);
    let ball = Solid::sphere(r);
    let across = |solid: Solid| solid.rotate_x(FRAC_PI_2);
    match random.below(12) {
        // A countersink of half a right angle.
        0 => rod | Solid::frustum(r, 2.0 * r, h..h + r),
        // A round end.
        1 => rod | ball.translate([0.0, 0.0, h]),
        2 => Solid::cone(r, 0.0..h),
        // A boss with a round end on a foot.
        3 => {
            let half = 0.5 * r;
            let foot = Solid::frustum(r, half, 0.0..half);
            let boss = Solid::cylinder(half, half..half + h);
            foot | boss | Solid::sphere(half).translate([0.0, 0.0, half + h])
        }
        // A ball that touches a cone all around.
        4 => {
            let radius = 0.5 * r;
            let center = radius * (1.0 + (h / r).powi(2)).sqrt();
            let cone = Solid::frustum(0.0, r, 0.0..h);
            cone | Solid::sphere(radius).translate([0.0, 0.0, center])
        }
        // Pipes of one radius.
        5 => {
            let pipe = Solid::cylinder(r, -0.5 * h..0.5 * h);
            pipe.clone() | across(pipe)
        }
        // A block whose side is rounded, with a ball at its corner.
        6 => {
            let block = Solid::cuboid([2.0 * r, 2.0 * r, h]);
            let round = Solid::cylinder(r, -0.5 * h..0.5 * h).translate([r, 0.0, 0.0]);
            block | round | ball.translate([r, 0.0, 0.5 * h])
        }
        // Side by side.
        7 => rod.clone() | rod.translate([2.0 * r, 0.0, 0.0]),
        // A dumbbell whose balls touch.
        8 => {
            let bar = Solid::cylinder(0.5 * r, 0.0..2.0 * r).rotate_y(FRAC_PI_2);
            ball.clone() | ball.translate([2.0 * r, 0.0, 0.0]) | bar
        }
        // A rounded edge.
        9 => {
            let round = across(Solid::cylinder(0.5 * h, -1.0..1.0));
            Solid::cuboid([2.0, 2.0, h]) | round.translate([1.0, 0.0, 0.0])
        }
        // An hourglass.
        10 => Solid::frustum(r, 0.5 * r, 0.0..h) | Solid::frustum(0.5 * r, r, h..2.0 * h),
        // A bulge of right angles.
        _ => Solid::frustum(r, r + h, 0.0..h) | Solid::frustum(r + h, r, h..2.0 * h),
    }
}
