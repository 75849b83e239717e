//! Random solids of up to 40 primitives: coincident faces, shared transforms,
//! thin walls, rotations, and every kind of surface.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use crate::judge::Random as SplitMix;
use csg::{Plane, Solid};
use glam::{DAffine3, DQuat, DVec3};
use stereotomy::csg;

/// Random numbers and solids.
pub struct Random(SplitMix);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(SplitMix(seed))
    }

    pub fn below(&mut self, count: u64) -> u64 {
        self.0.below(count as usize) as u64
    }

    /// A number in 0..1.
    pub fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A multiple of 1/4: sizes and places that make faces coincide.
    fn quarters(&mut self, low: u64, high: u64) -> f64 {
        (low + self.below(high - low + 1)) as f64 / 4.0
    }

    /// Such a place, on either side of the origin.
    fn place(&mut self) -> DVec3 {
        DVec3::from_array([(); 3].map(|()| self.quarters(0, 6) - 0.75))
    }

    fn leaf(&mut self) -> Solid {
        let radius = self.quarters(1, 3);
        let height = self.quarters(1, 5);
        match self.below(14) {
            0..=2 => Solid::cuboid([radius, height, self.quarters(1, 6)]),
            3 => Solid::sphere(radius),
            4 => Solid::ellipsoid([radius, height, self.between(0.2, 1.0)]),
            5 | 6 => Solid::cylinder(radius, 0.0..height),
            7 => Solid::elliptic_cylinder([radius, self.between(0.2, 1.0)], -height..height),
            8 => Solid::cone(radius, 0.0..height),
            9 => Solid::frustum(radius, self.quarters(1, 4), -height..0.0),
            10 => {
                let corners = 3 + self.below(5);
                let polygon = (0..corners).map(|i| {
                    let angle = TAU * i as f64 / corners as f64;
                    [radius * angle.cos(), radius * angle.sin()]
                });
                Solid::prism(polygon.collect::<Vec<_>>(), 0.0..height)
            }
            // Thinner than any cell.
            11 => {
                let thickness = 10f64.powf(self.between(-5.0, -1.0));
                Solid::cuboid([2.0 * radius, height, thickness])
            }
            12 => {
                let waist = Solid::hyperboloid_one_sheet([0.5 * radius, 0.25, 0.5]);
                waist & Solid::cuboid([1.5; 3])
            }
            _ => {
                let shell = self.between(1e-3, 0.2);
                Solid::sphere(radius) - Solid::sphere(radius * (1.0 - shell))
            }
        }
    }

    fn map(&mut self) -> DAffine3 {
        match self.below(8) {
            0..=3 => DAffine3::from_translation(self.place()),
            4 => DAffine3::from_rotation_x(FRAC_PI_2 * self.below(4) as f64),
            5 => DAffine3::from_rotation_z(FRAC_PI_4 * self.below(8) as f64),
            6 => {
                let axis = DVec3::new(self.unit(), self.unit(), self.unit() + 0.1);
                let turn = DQuat::from_axis_angle(axis.normalize(), self.between(0.0, TAU));
                DAffine3::from_rotation_translation(turn, 0.5 * self.place())
            }
            _ => DAffine3::from_scale(DVec3::new(
                self.between(0.6, 1.4),
                self.between(0.6, 1.4),
                -self.between(0.6, 1.4),
            )),
        }
    }

    /// A leaf bounded by planes.
    fn flat_leaf(&mut self) -> Solid {
        let [width, height] = [self.quarters(1, 5), self.quarters(1, 5)];
        match self.below(8) {
            0..=2 => Solid::cuboid([width, height, self.quarters(1, 6)]),
            3 | 4 => {
                let corners = 3 + self.below(9);
                let polygon = (0..corners).map(|i| {
                    let angle = TAU * i as f64 / corners as f64;
                    [width * angle.cos(), width * angle.sin()]
                });
                Solid::prism(polygon.collect::<Vec<_>>(), 0.0..height)
            }
            // Thin, down to what rounding leaves.
            5 => {
                let thickness = 10f64.powf(self.between(-8.0, -1.0));
                Solid::cuboid([width, height, thickness])
            }
            // A pyramid: all sides through one point.
            6 => {
                let sides = 3 + self.below(9);
                let side = |i| {
                    let angle = TAU * i as f64 / sides as f64;
                    Plane::through(DVec3::Z, [angle.cos(), angle.sin(), 1.0])
                };
                let base = Plane::through([0.0, 0.0, -0.25], -DVec3::Z);
                Solid::convex_polyhedron((0..sides).map(side).chain([base]))
            }
            // As its faces fall.
            _ => {
                let faces = 4 + self.below(12);
                let random = (0..faces).map(|_| Plane {
                    normal: DVec3::from_array([(); 3].map(|()| self.between(-1.0, 1.0))),
                    offset: self.between(0.1, 0.6),
                });
                let faces: Vec<Plane> = random.collect();
                Solid::convex_polyhedron(faces) & Solid::cuboid([1.5; 3])
            }
        }
    }

    /// A bounded solid of 1 to 40 primitives.
    pub fn solid(&mut self) -> Solid {
        self.solid_of(Self::leaf)
    }

    /// The same with planes alone.
    pub fn polyhedron(&mut self) -> Solid {
        self.solid_of(Self::flat_leaf)
    }

    fn solid_of(&mut self, leaf: fn(&mut Self) -> Solid) -> Solid {
        // Few of many primitives: they cost the most.
        let most = 1 + self.below(37);
        let leaves = 1 + self.below(4) + self.below(most);
        // Maps and parts that several operands share.
        let maps = [self.map(), self.map()];
        let mut parts: Vec<Solid> = Vec::new();
        for _ in 0..leaves {
            let leaf = match self.below(5) {
                0 if !parts.is_empty() => {
                    let index = self.below(parts.len() as u64) as usize;
                    parts[index].clone()
                }
                _ => leaf(self),
            };
            let map = match self.below(3) {
                0 => maps[self.below(2) as usize],
                _ => self.map(),
            };
            parts.push(leaf.affine(map));
        }
        while parts.len() > 1 {
            let first = parts.swap_remove(self.below(parts.len() as u64) as usize);
            let index = self.below(parts.len() as u64) as usize;
            let second = &parts[index];
            let combined = match self.below(8) {
                0..=3 => first | second,
                4 | 5 => first - second,
                6 => second - first,
                _ => first & second,
            };
            let map = self.below(6) == 0;
            parts[index] = if map {
                combined.affine(maps[0])
            } else {
                combined
            };
        }
        parts.remove(0)
    }
}
