//! Lights, and what of them arrives at a point.

use glam::{DVec3, Vec3};

use crate::camera::View;
use crate::shade::Incident;

/// A light source. Intensities are linear, per channel, not attenuated with
/// distance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Light {
    /// From everywhere: the Ia of the model.
    Ambient {
        /// Intensity per channel.
        intensity: Vec3,
    },
    /// From infinitely far away.
    Directional {
        /// Direction towards the light, in world coordinates; of any length but
        /// zero, for no light comes from nowhere.
        towards: DVec3,
        /// Intensity per channel.
        intensity: Vec3,
    },
    /// From a point.
    Point {
        /// Position in world coordinates.
        position: DVec3,
        /// Intensity per channel.
        intensity: Vec3,
    },
    /// From a sky above and a ground below, which fill half of what a surface
    /// sees each: ambient light that depends on the normal. A surface whose
    /// normal is at an angle t to `up` receives the share (1 + cos t) / 2 of the
    /// sky's light and the rest of the ground's, which is exact for two
    /// uniform half-spheres.
    Environment {
        /// Upwards, in world coordinates; of any length but zero.
        up: DVec3,
        /// The sky's light per channel.
        sky: Vec3,
        /// The ground's light per channel.
        ground: Vec3,
    },
    /// From the viewer, whatever the view.
    Head {
        /// Intensity per channel.
        intensity: Vec3,
    },
    /// From a direction fixed to the camera.
    Camera {
        /// Direction towards the light, in eye coordinates (x right, y up, z
        /// towards the viewer); of any length but zero.
        towards: DVec3,
        /// Intensity per channel.
        intensity: Vec3,
    },
}

impl Light {
    /// Three lights fixed to the camera, and some from everywhere: a key light
    /// over the viewer's left shoulder, a weak fill from the right, and a rim
    /// light from behind and above that tells dark sides from dark backgrounds.
    #[must_use]
    pub fn default_rig() -> Vec<Self> {
        let camera = |towards: DVec3, intensity: f32| Self::Camera {
            towards,
            intensity: Vec3::splat(intensity),
        };
        vec![
            Self::Ambient {
                intensity: Vec3::splat(0.16),
            },
            camera(DVec3::new(-0.6, 0.9, 1.0), 0.72),
            camera(DVec3::new(1.0, 0.15, 0.7), 0.2),
            camera(DVec3::new(0.4, 0.9, -0.6), 0.25),
        ]
    }
}

/// Where the light of a source comes from, in the world as a view sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Source {
    /// Everywhere.
    Everywhere,
    /// Half of it from the side of this unit direction, with the light given,
    /// and half from the other.
    Halves(DVec3, Vec3),
    /// The unit direction towards it.
    Direction(DVec3),
    Position(DVec3),
    Viewer,
}

impl Light {
    /// Where its light comes from; `None` without a direction.
    pub(crate) fn source(&self, view: &View) -> Option<Source> {
        let direction = |towards: DVec3| towards.try_normalize().map(Source::Direction);
        match *self {
            Self::Ambient { .. } => Some(Source::Everywhere),
            Self::Environment { up, sky, .. } => {
                up.try_normalize().map(|up| Source::Halves(up, sky))
            }
            Self::Directional { towards, .. } => direction(towards),
            Self::Camera { towards, .. } => {
                direction(view.world_to_eye().inverse().transform_vector3(towards))
            }
            Self::Point { position, .. } => Some(Source::Position(position)),
            Self::Head { .. } => Some(Source::Viewer),
        }
    }

    /// Its intensity per channel; of an environment that of the ground.
    #[must_use]
    pub fn intensity(&self) -> Vec3 {
        match *self {
            Self::Ambient { intensity }
            | Self::Directional { intensity, .. }
            | Self::Camera { intensity, .. }
            | Self::Point { intensity, .. }
            | Self::Head { intensity } => intensity,
            Self::Environment { ground, .. } => ground,
        }
    }
}

impl Source {
    /// Its light at a point, given unit normal and direction to the viewer.
    pub fn at(self, point: DVec3, normal: Vec3, viewer: Vec3, intensity: Vec3) -> Incident {
        let towards = match self {
            Self::Halves(up, sky) => {
                let share = (1.0 + normal.dot(up.as_vec3())) / 2.0;
                return Incident {
                    towards: Vec3::ZERO,
                    intensity: intensity.lerp(sky, share),
                };
            }
            Self::Everywhere => Vec3::ZERO,
            Self::Direction(towards) => towards.as_vec3(),
            Self::Position(position) => (position - point).normalize_or_zero().as_vec3(),
            Self::Viewer => viewer,
        };
        Incident { towards, intensity }
    }
}
