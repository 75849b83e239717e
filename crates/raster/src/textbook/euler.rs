//! Euler angles: rotations about three axes in turn, in every order.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

/// The axes of three rotations; the matrix is the product in the order of the
/// name, so that the last one acts first: `Yxz` is Ry(a) Rx(b) Rz(c).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say all")]
pub enum EulerOrder {
    Xyz,
    Xzy,
    Yxz,
    Yzx,
    Zxy,
    Zyx,
    Xyx,
    Xzx,
    Yxy,
    Yzy,
    Zxz,
    Zyz,
}

/// What is kept at zero where the first and the last rotation turn about the
/// same axis (gimbal lock), so that only their sum or difference counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GimbalLock {
    /// The last angle: all of it is in the first.
    #[default]
    LastIsZero,
    /// The first angle, as some texts have it (h = 0).
    FirstIsZero,
}

impl EulerOrder {
    /// All twelve.
    pub const ALL: [Self; 12] = [
        Self::Xyz,
        Self::Xzy,
        Self::Yxz,
        Self::Yzx,
        Self::Zxy,
        Self::Zyx,
        Self::Xyx,
        Self::Xzx,
        Self::Yxy,
        Self::Yzy,
        Self::Zxz,
        Self::Zyz,
    ];

    /// The numbers of the axes.
    #[must_use]
    pub const fn axes(self) -> [usize; 3] {
        match self {
            Self::Xyz => [0, 1, 2],
            Self::Xzy => [0, 2, 1],
            Self::Yxz => [1, 0, 2],
            Self::Yzx => [1, 2, 0],
            Self::Zxy => [2, 0, 1],
            Self::Zyx => [2, 1, 0],
            Self::Xyx => [0, 1, 0],
            Self::Xzx => [0, 2, 0],
            Self::Yxy => [1, 0, 1],
            Self::Yzy => [1, 2, 1],
            Self::Zxz => [2, 0, 2],
            Self::Zyz => [2, 1, 2],
        }
    }

    /// The rotation by three angles in radians.
    #[must_use]
    pub fn to_matrix(self, angles: [f64; 3]) -> DMat3 {
        let turn = |k: usize| DMat3::from_axis_angle(DVec3::AXES[self.axes()[k]], angles[k]);
        turn(0) * turn(1) * turn(2)
    }

    /// The angles of a rotation, in radians: the middle one in -pi/2..=pi/2, or
    /// in 0..=pi where the first and the last axis are the same.
    #[must_use]
    pub fn from_matrix(self, m: DMat3, lock: GimbalLock) -> [f64; 3] {
        let [i, j, last] = self.axes();
        let proper = i == last;
        let k = 3 - i - j;
        // 1 where i, j, k are in cyclic order.
        let s = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
        let at = |row: usize, column: usize| m.col(column)[row];
        let (middle, size) = if proper {
            let sine = at(i, j).hypot(at(i, k));
            (sine.atan2(at(i, i)), sine)
        } else {
            let cosine = at(i, i).hypot(at(i, j));
            ((s * at(i, k)).atan2(cosine), cosine)
        };
        if size < 1e-9 {
            let one = match lock {
                GimbalLock::LastIsZero => (s * at(k, j)).atan2(at(j, j)),
                GimbalLock::FirstIsZero if proper => (-s * at(j, k)).atan2(at(j, j)),
                GimbalLock::FirstIsZero => (s * at(j, i)).atan2(at(j, j)),
            };
            let middle = match (proper, middle > PI / 2.0, middle > 0.0) {
                (true, true, _) => PI,
                (true, ..) => 0.0,
                (false, _, true) => PI / 2.0,
                (false, ..) => -PI / 2.0,
            };
            return match lock {
                GimbalLock::LastIsZero => [one, middle, 0.0],
                GimbalLock::FirstIsZero => [0.0, middle, one],
            };
        }
        if proper {
            [
                at(j, i).atan2(-s * at(k, i)),
                middle,
                at(i, j).atan2(s * at(i, k)),
            ]
        } else {
            [
                (-s * at(j, k)).atan2(at(k, k)),
                middle,
                (-s * at(i, j)).atan2(at(i, i)),
            ]
        }
    }
}
