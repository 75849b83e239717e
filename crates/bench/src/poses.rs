//! Where scenes are put: at home, rotated, far away, tiny and huge.

use csg::Solid;
use glam::{DMat3, DVec3};

/// A rotation about x, y and z in turn, a factor, and an offset, in this
/// order.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// What tables call it.
    pub name: &'static str,
    pub turned: bool,
    pub scale: f64,
    pub offset: DVec3,
}

const HOME: Pose = Pose {
    name: "home",
    turned: false,
    scale: 1.0,
    offset: DVec3::ZERO,
};

/// All of them.
pub const POSES: [Pose; 5] = [
    HOME,
    Pose {
        name: "turned",
        turned: true,
        ..HOME
    },
    Pose {
        name: "far",
        offset: DVec3::splat(1e6),
        ..HOME
    },
    Pose {
        name: "tiny",
        scale: 1e-6,
        ..HOME
    },
    Pose {
        name: "huge",
        scale: 1e6,
        ..HOME
    },
];

const ANGLES: [f64; 3] = [0.3, 0.5, 0.7];

/// The pose of a name, for the command line.
pub fn pose(name: &str) -> Result<Pose, String> {
    let known = POSES.map(|pose| pose.name).join(", ");
    let found = POSES.into_iter().find(|pose| pose.name == name);
    found.ok_or_else(|| format!("no such pose; there are {known}"))
}

impl Pose {
    /// The solid in this pose, untouched as far as that goes.
    pub fn of(self, solid: &Solid) -> Solid {
        let mut solid = solid.clone();
        if self.turned {
            solid = solid.rotate_xyz(ANGLES[0], ANGLES[1], ANGLES[2]);
        }
        if self.scale != 1.0 {
            solid = solid.scale(self.scale);
        }
        if self.offset != DVec3::ZERO {
            solid = solid.translate(self.offset);
        }
        solid
    }

    /// Where a point of the solid at home is.
    pub fn at(self, point: DVec3) -> DVec3 {
        let [x, y, z] = ANGLES;
        let turn =
            DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
        let turned = if self.turned { turn * point } else { point };
        self.scale * turned + self.offset
    }

    /// How far coordinates may be off besides: four machine epsilons of the
    /// distance from the origin.
    pub fn rounding(self) -> f64 {
        4.0 * f64::EPSILON * self.offset.length()
    }
}
