//! Random solids.

use std::f64::consts::FRAC_PI_2;

use crate::judge::Random as SplitMix;
use csg::Solid;
use stereotomy::csg;

/// Random numbers and solids.
pub struct Random(SplitMix);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(SplitMix(seed))
    }

    fn below(&mut self, n: u64) -> u64 {
        self.0.below(n as usize) as u64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.unit()
    }

    /// A multiple of 1/4: sizes and places that make faces coincide.
    fn quarters(&mut self, low: i32, high: i32) -> f64 {
        f64::from(low + self.below((high - low + 1) as u64) as i32) / 4.0
    }

    fn leaf(&mut self) -> Solid {
        match self.below(6) {
            0 | 1 => Solid::cuboid([
                self.quarters(2, 6),
                self.quarters(2, 6),
                self.quarters(2, 6),
            ]),
            2 => Solid::sphere(self.quarters(2, 4)),
            3 => {
                let half = self.quarters(1, 4);
                Solid::cylinder(self.quarters(1, 3), -half..half)
            }
            4 => Solid::cone(self.quarters(2, 4), 0.0..self.quarters(2, 6)),
            _ => Solid::frustum(
                self.quarters(1, 2),
                self.quarters(3, 4),
                0.0..self.quarters(2, 4),
            ),
        }
    }

    fn moved(&mut self, solid: &Solid) -> Solid {
        match self.below(6) {
            // On the grid of quarters, where faces meet faces.
            0..=2 => solid.translate([
                self.quarters(-3, 3),
                self.quarters(-3, 3),
                self.quarters(-3, 3),
            ]),
            3 => solid.rotate_x(FRAC_PI_2 * self.below(4) as f64),
            // And anywhere.
            4 => solid
                .rotate_xyz(
                    self.between(-3.0, 3.0),
                    self.between(-3.0, 3.0),
                    self.between(-3.0, 3.0),
                )
                .translate([
                    self.between(-0.5, 0.5),
                    self.between(-0.5, 0.5),
                    self.between(-0.5, 0.5),
                ]),
            _ => solid.scale_xyz([
                self.between(0.6, 1.4),
                self.between(0.6, 1.4),
                -self.between(0.6, 1.4),
            ]),
        }
    }

    /// A solid of about `leaves` primitives.
    pub fn solid(&mut self, leaves: u64) -> Solid {
        if leaves <= 1 {
            let leaf = self.leaf();
            return self.moved(&leaf);
        }
        let first = 1 + self.below(leaves - 1);
        let (left, right) = (self.solid(first), self.solid(leaves - first));
        let combined = match self.below(5) {
            0 | 1 => left | right,
            2 | 3 => left - right,
            _ => left & right,
        };
        if self.below(3) == 0 {
            self.moved(&combined)
        } else {
            combined
        }
    }
}
