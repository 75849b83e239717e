//! Patterns on surfaces, by the place of a point or by parameters of its
//! surface.

use csg::Color;
use glam::{DVec3, Vec3};

/// Which numbers of a point a pattern goes by.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Mapping {
    /// Its coordinates, as if cut from one block (solid texture; Peachey,
    /// *Solid texturing of complex surfaces*, SIGGRAPH 1985).
    Position,
    /// The parameters of a cylinder about an upward axis: the angle in parts
    /// of a turn, and the height over `centre`.
    Cylinder {
        /// A point of the axis.
        centre: DVec3,
    },
    /// The parameters of a sphere: longitude in parts of a turn, and latitude
    /// in parts of half a turn from the lower pole.
    Sphere {
        /// The centre.
        centre: DVec3,
    },
}

/// A checker: squares (or cubes) of two colours in turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Which numbers it goes by.
    pub mapping: Mapping,
    /// A square's side in each of them.
    pub size: DVec3,
    /// The colours of even and odd squares.
    pub colors: [Color; 2],
}

impl Texture {
    /// Cubes of a side length, by position.
    #[must_use]
    pub fn checker(side: f64, colors: [Color; 2]) -> Self {
        Self {
            mapping: Mapping::Position,
            size: DVec3::splat(side),
            colors,
        }
    }

    /// Squares around an upward cylinder: so many in a turn, and their height.
    #[must_use]
    pub fn cylinder(centre: DVec3, around: u32, height: f64, colors: [Color; 2]) -> Self {
        Self {
            mapping: Mapping::Cylinder { centre },
            size: DVec3::new(1.0 / f64::from(around.max(1)), height, 1.0),
            colors,
        }
    }

    /// Squares on a sphere: so many along the equator and from pole to pole.
    #[must_use]
    pub fn sphere(centre: DVec3, around: u32, up: u32, colors: [Color; 2]) -> Self {
        let size = [around, up].map(|n| 1.0 / f64::from(n.max(1)));
        Self {
            mapping: Mapping::Sphere { centre },
            size: DVec3::new(size[0], size[1], 1.0),
            colors,
        }
    }

    /// The parameters of a point, in squares.
    #[must_use]
    pub fn parameters(&self, point: DVec3) -> DVec3 {
        let turn = |p: DVec3| p.y.atan2(p.x) / std::f64::consts::TAU + 0.5;
        let raw = match self.mapping {
            Mapping::Position => point,
            Mapping::Cylinder { centre } => {
                let p = point - centre;
                DVec3::new(turn(p), p.z, 0.0)
            }
            Mapping::Sphere { centre } => {
                let p = point - centre;
                let latitude = p.z.atan2(p.truncate().length()) / std::f64::consts::PI + 0.5;
                DVec3::new(turn(p), latitude, 0.0)
            }
        };
        raw / self.size
    }

    /// The linear colour at a point.
    #[must_use]
    pub fn color(&self, point: DVec3) -> Vec3 {
        /// Faces exactly between two cubes belong to one of them, rounding or
        /// not.
        const ASIDE: f64 = 1e-6;
        let squares = (self.parameters(point) + ASIDE).floor();
        let odd = squares.element_sum().rem_euclid(2.0) >= 1.0;
        Vec3::from_array(self.colors[usize::from(odd)].rgb)
    }
}
