//! Reference scenes with known volumes, shared by examples, tests and
//! benchmarks.
//!
//! Cylinders that go right through are as long as needed rather than
//! infinite, so that every scene can be written as `.csg`; `models/` holds
//! most of them that way.

use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

use csg::Solid;
use csg::glam::{DAffine3, DMat3, DVec3};

/// The unit sphere.
#[must_use]
pub fn sphere() -> Solid {
    Solid::sphere(1.0).named("sphere")
}

/// Volume of [`sphere`].
pub const SPHERE_VOLUME: f64 = 4.0 / 3.0 * PI;

/// A solid around the z axis, and the same around the x and the y axis: by
/// exchange of the axes, which rounds nothing.
fn along_the_axes(along_z: Solid) -> [Solid; 3] {
    let next_axes = DAffine3::from_mat3(DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X));
    let along_x = along_z.affine(next_axes);
    let along_y = along_z.affine(next_axes * next_axes);
    [along_x, along_y, along_z]
}

/// A cube of side 1.5 rounded by the unit sphere, with a bore of radius 0.5
/// along each axis. Genus 5.
#[must_use]
pub fn drilled() -> Solid {
    let blank = (Solid::cube(1.5) & Solid::sphere(1.0)).named("blank");
    let bores = Solid::union(along_the_axes(Solid::cylinder(0.5, -1.0..1.0))).named("bores");
    blank - bores
}

/// Volume of [`drilled`], integrated to 15 digits.
pub const DRILLED_VOLUME: f64 = 0.988_789_557_199_477;

/// The part common to three cylinders of radius 1 along the axes: Steinmetz's
/// tricylinder.
#[must_use]
pub fn tricylinder() -> Solid {
    Solid::intersection(along_the_axes(Solid::cylinder(1.0, -1.5..1.5))).named("tricylinder")
}

/// Volume of [`tricylinder`]: 8 (2 - √2).
pub const TRICYLINDER_VOLUME: f64 = 8.0 * (2.0 - SQRT_2);

/// Menger's sponge: the cube of side 2, and through it for each level k up to
/// `level` and along each axis 9^(k-1) square bars of side 2/3^k.
///
/// Costs about 3/8 · 9^level nodes: level 5 has 22143 bars.
#[must_use]
pub fn menger(level: u32) -> Solid {
    let mut operands = vec![Solid::cube(2.0)];
    let mut tiles = 1;
    for _ in 0..level {
        let tile = 2.0 / f64::from(tiles);
        let bar = Solid::cuboid([tile / 3.0, tile / 3.0, 2.0]);
        let middle = |i: u32| f64::from(2 * i + 1) / f64::from(tiles) - 1.0;
        let mut bars = Vec::new();
        for i in 0..tiles {
            for j in 0..tiles {
                bars.push(bar.translate([middle(i), middle(j), 0.0]));
            }
        }
        operands.extend(along_the_axes(Solid::union(bars)));
        tiles *= 3;
    }
    Solid::difference(operands).named("sponge")
}

/// Volume of [`menger`]: 8 (20/27)^level.
#[must_use]
pub fn menger_volume(level: u32) -> f64 {
    8.0 * (20.0_f64 / 27.0).powi(level as i32)
}

/// The cube of side 2 without `n` small spheres strewn at random, of radius
/// 0.35 n^(-1/3), the same for the same `n` everywhere.
#[must_use]
pub fn cheese(n: u32) -> Solid {
    let hole = Solid::sphere(0.35 * f64::from(n).recip().cbrt());
    let mut random = Pcg64::default();
    let holes = (0..n).map(|_| {
        let [x, y, z] = std::array::from_fn(|_| random.next_unit() * 2.0 - 1.0);
        hole.translate([x, y, z])
    });
    let block = Solid::cube(2.0).named("block");
    Solid::difference(std::iter::once(block).chain(holes))
}

/// Volume of [`cheese`] to nine digits, where it is known.
#[must_use]
pub fn cheese_volume(n: u32) -> Option<f64> {
    match n {
        100 => Some(7.829_200_300_267_373),
        1_000 => Some(7.824_957_977_265_603),
        10_000 => Some(7.824_107_396_939_645),
        100_000 => Some(7.823_133_179_160_428),
        _ => None,
    }
}

/// A box with half sides 1, 0.6 and 0.3, rotated about x by 0.7, then y by
/// 0.5, then z by 0.3.
#[must_use]
pub fn rotated_box() -> Solid {
    let block = Solid::cuboid([2.0, 1.2, 0.6]);
    block.rotate_xyz(0.7, 0.5, 0.3).named("box")
}

/// Volume of [`rotated_box`].
pub const ROTATED_BOX_VOLUME: f64 = 1.44;

/// The unit sphere, hollow, its wall of the given thickness in 0..1.
#[must_use]
pub fn shell(thickness: f64) -> Solid {
    Solid::sphere(1.0).named("outside") - Solid::sphere(1.0 - thickness).named("inside")
}

/// Volume of [`shell`]: 4/3 π (1 - (1 - t)³), without cancellation.
#[must_use]
pub fn shell_volume(thickness: f64) -> f64 {
    let t = thickness;
    SPHERE_VOLUME * t * (3.0 - t * (3.0 - t))
}

/// A flange of radius 1 with a hub, a bore, eight bolt holes and a keyway.
/// Genus 9.
#[must_use]
pub fn flange() -> Solid {
    let disc = Solid::cylinder(1.0, 0.0..0.2).named("disc");
    let hub = Solid::cylinder(0.45, 0.0..0.7).named("hub");
    let bore = Solid::cylinder(0.3, -0.1..0.8).named("bore");
    let bolt = Solid::cylinder(0.08, -0.1..0.8);
    let (far, near) = (0.75, 0.75 * FRAC_1_SQRT_2);
    let eighths = [
        (far, 0.0),
        (near, near),
        (0.0, far),
        (-near, near),
        (-far, 0.0),
        (-near, -near),
        (0.0, -far),
        (near, -near),
    ];
    let bolts = Solid::union(eighths.map(|(x, y)| bolt.translate([x, y, 0.0])));
    let keyway = Solid::cuboid_between([-0.06, 0.0, -0.1], [0.06, 0.38, 0.8]).named("keyway");
    (disc | hub) - Solid::union([bore, bolts.named("bolt holes"), keyway])
}

/// Volume of [`flange`], integrated to 15 digits.
pub const FLANGE_VOLUME: f64 = 0.709_425_518_258_427;

/// O'Neill's PCG64 (XSL-RR 128/64) as `numpy.random.default_rng(1)` starts it.
struct Pcg64 {
    state: u128,
}

impl Default for Pcg64 {
    fn default() -> Self {
        Self {
            state: 207_833_532_711_051_698_738_587_646_355_624_148_094,
        }
    }
}

impl Pcg64 {
    /// The next double in 0..1, from the upper 53 bits.
    fn next_unit(&mut self) -> f64 {
        const MULTIPLIER: u128 = 0x2360_ed05_1fc6_5da4_4385_df64_9fcc_f645;
        const INCREMENT: u128 = 194_290_289_479_364_712_180_083_596_243_593_368_443;
        let next = self.state.wrapping_mul(MULTIPLIER);
        self.state = next.wrapping_add(INCREMENT);
        let folded = (self.state >> 64) as u64 ^ self.state as u64;
        let word = folded.rotate_right((self.state >> 122) as u32);
        (word >> 11) as f64 * (-53.0_f64).exp2()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From numpy 2: `default_rng(1).random((1000, 3))`, rows 0, 1 and 999.
    #[test]
    fn random_numbers_are_those_of_numpy() {
        let mut random = Pcg64::default();
        let numbers: Vec<f64> = (0..3000).map(|_| random.next_unit()).collect();
        let known = [
            0.511_821_624_700_256_7,
            0.950_463_696_325_935_3,
            0.144_159_612_719_633_73,
            0.948_649_447_137_243_9,
            0.311_831_452_010_485_45,
            0.423_326_448_972_575_65,
        ];
        assert_eq!(numbers[..6], known);
        let last = [
            0.542_143_749_584_765,
            0.112_183_459_891_930_9,
            0.004_798_696_269_508_24,
        ];
        assert_eq!(numbers[2997..], last);
    }
}
