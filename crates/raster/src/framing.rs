//! Standard views and automatic framing.

use glam::{DVec3, DVec4};

use crate::camera::{Camera, Frame, Lens};
use crate::ground::SHADOW_SPREAD;
use crate::prepared::{combine_finite, finite_bounds};
use crate::{Mesh, RasterError};

/// The standard views of mechanical drawing (third-angle names), Z up: the
/// front looks along +Y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StandardView {
    /// From -Y.
    Front,
    /// From +Y.
    Back,
    /// From -X.
    Left,
    /// From +X.
    Right,
    /// From +Z, with +Y upwards in the picture.
    Top,
    /// From -Z, with -Y upwards in the picture.
    Bottom,
    /// Isometric, from (1, -1, 1): the three axes are drawn alike.
    #[default]
    Iso,
}

impl StandardView {
    /// All of them, in the order of declaration.
    pub const ALL: [Self; 7] = [
        Self::Front,
        Self::Back,
        Self::Left,
        Self::Right,
        Self::Top,
        Self::Bottom,
        Self::Iso,
    ];

    /// The name used on the command line: the variant in lower case.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Back => "back",
            Self::Left => "left",
            Self::Right => "right",
            Self::Top => "top",
            Self::Bottom => "bottom",
            Self::Iso => "iso",
        }
    }

    /// The view of that name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|view| view.name() == name)
    }

    /// The unit direction the camera looks along, and its up vector.
    #[must_use]
    pub fn direction_and_up(self) -> (DVec3, DVec3) {
        match self {
            Self::Front => (DVec3::Y, DVec3::Z),
            Self::Back => (DVec3::NEG_Y, DVec3::Z),
            Self::Left => (DVec3::X, DVec3::Z),
            Self::Right => (DVec3::NEG_X, DVec3::Z),
            Self::Top => (DVec3::NEG_Z, DVec3::Y),
            Self::Bottom => (DVec3::Z, DVec3::NEG_Y),
            Self::Iso => (DVec3::new(-1.0, 1.0, -1.0).normalize(), DVec3::Z),
        }
    }
}

/// The share of the picture's height or width that a framed model may fill.
const FILL: f64 = 0.9;

/// How a camera is put so that it sees the whole of a model, as large as
/// possible with a margin of 5% on the tightest sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framing {
    /// Along which the camera looks; any length but zero.
    pub direction: DVec3,
    /// Upwards in the picture; not along `direction`.
    pub up: DVec3,
    /// How it projects. The height of a parallel lens is replaced by the
    /// fitting one.
    pub lens: Lens,
    /// Width of the picture by its height.
    pub aspect: f64,
    /// Whether the soft shadow on the ground
    /// ([`RenderOptions::ground_shadow`](crate::RenderOptions)) is seen whole
    /// as well.
    pub shadow: bool,
}

/// What is framed: points, and their shadows.
struct Subject<'a> {
    points: &'a [DVec3],
    centre: DVec3,
    /// The ground's height, and how far a shadow spreads there.
    ground: Option<(f64, f64)>,
}

impl Subject<'_> {
    /// How far the subject reaches from its centre along some directions, of
    /// any length.
    fn reach(&self, directions: [DVec3; 4]) -> DVec4 {
        let along = |p: DVec3| DVec4::from_array(directions.map(|d| d.dot(p - self.centre)));
        let reach = |p: DVec3| match self.ground {
            Some((height, spread)) => {
                let around = directions.map(|d| d.truncate().length() * spread);
                let shadow = along(p.truncate().extend(height)) + DVec4::from_array(around);
                along(p).max(shadow)
            }
            None => along(p),
        };
        combine_finite(self.points, reach, DVec4::max).unwrap_or_default()
    }

    /// The radius of a sphere around the centre that holds all; of a single
    /// point, as if it had a size.
    fn radius(&self) -> f64 {
        let squared = |p: DVec3| match self.ground {
            Some((height, spread)) => {
                let shadow = (p.truncate() - self.centre.truncate()).length() + spread;
                let below = height - self.centre.z;
                let squared = shadow * shadow + below * below;
                squared.max(p.distance_squared(self.centre))
            }
            None => p.distance_squared(self.centre),
        };
        let square = combine_finite(self.points, squared, f64::max);
        let radius = square.unwrap_or_default().sqrt();
        if radius > 0.0 {
            radius
        } else {
            self.centre.length().max(1.0) * 1e-3
        }
    }
}

impl Framing {
    /// The camera that sees the whole of `mesh`. Near and far enclose a sphere
    /// around it. O(vertices).
    ///
    /// # Errors
    /// [`RasterError::NothingToFrame`] for a mesh without finite vertices;
    /// [`RasterError::UpAlongView`] if `direction` is zero or along `up`.
    pub fn camera(&self, mesh: &Mesh) -> Result<Camera, RasterError> {
        self.camera_for(&mesh.positions)
    }

    /// The same of points.
    pub(crate) fn camera_for(&self, points: &[DVec3]) -> Result<Camera, RasterError> {
        let Self {
            direction,
            up,
            lens,
            aspect,
            shadow,
        } = *self;
        let frame = Frame::right_handed(direction, up);
        if !(frame.u.is_finite() && frame.v.is_finite() && frame.n.is_finite()) {
            return Err(RasterError::UpAlongView { up, direction });
        }
        let (low, high) = finite_bounds(points).ok_or(RasterError::NothingToFrame)?;
        let spread = (high - low).max_element() * SHADOW_SPREAD;
        let subject = Subject {
            points,
            centre: low + (high - low) / 2.0,
            ground: shadow.then_some((low.z, spread)),
        };
        let (centre, radius) = (subject.centre, subject.radius());
        let Frame { u, v, n } = frame;
        let (target, distance, lens) = match lens {
            Lens::Perspective { fov_y } => {
                // Each side of the frustum is pushed outward until it touches
                // the subject; the eye then is where opposite sides meet.
                let tan_y = (fov_y / 2.0).tan() * FILL;
                let tan_x = tan_y * aspect;
                let (x, y) = (n * tan_x, n * tan_y);
                let reach = subject.reach([u + x, x - u, v + y, y - v]);
                let distance = ((reach[0] + reach[1]) / (2.0 * tan_x))
                    .max((reach[2] + reach[3]) / (2.0 * tan_y))
                    .max(radius * 1e-3);
                let shift = u * ((reach[0] - reach[1]) / 2.0) + v * ((reach[2] - reach[3]) / 2.0);
                (centre + shift, distance, lens)
            }
            Lens::Orthographic { .. } | Lens::Oblique { .. } => {
                let (x, y) = match lens {
                    Lens::Oblique { ratio, angle, .. } => {
                        (u - n * (ratio * angle.cos()), v - n * (ratio * angle.sin()))
                    }
                    _ => (u, v),
                };
                let reach = subject.reach([x, -x, y, -y]);
                let (width, tall) = (reach[0] + reach[1], reach[2] + reach[3]);
                let height = (tall.max(width / aspect) / FILL).max(radius * 1e-3);
                let lens = match lens {
                    Lens::Oblique { ratio, angle, .. } => Lens::Oblique {
                        height,
                        ratio,
                        angle,
                    },
                    _ => Lens::Orthographic { height },
                };
                let shift = u * ((reach[0] - reach[1]) / 2.0) + v * ((reach[2] - reach[3]) / 2.0);
                (centre + shift, 3.0 * radius, lens)
            }
        };
        let eye = target + n * distance;
        // The bounding sphere, seen along the view.
        let depth = (centre - eye).dot(-n);
        let far = depth + radius * 1.01;
        let near = (depth - radius * 1.01).max(far * 1e-3);
        Ok(Camera {
            eye,
            target,
            up,
            lens,
            near,
            far,
        })
    }
}

impl Camera {
    /// A camera that looks along `direction` and sees the whole of `mesh`: see
    /// [`Framing`].
    ///
    /// # Errors
    /// Those of [`Framing::camera`].
    pub fn framing(
        mesh: &Mesh,
        direction: DVec3,
        up: DVec3,
        lens: Lens,
        aspect: f64,
    ) -> Result<Self, RasterError> {
        let framing = Framing {
            direction,
            up,
            lens,
            aspect,
            shadow: false,
        };
        framing.camera(mesh)
    }

    /// [`Camera::framing`] along a standard view.
    ///
    /// # Errors
    /// [`RasterError::NothingToFrame`] for a mesh without finite vertices.
    pub fn standard(
        mesh: &Mesh,
        view: StandardView,
        lens: Lens,
        aspect: f64,
    ) -> Result<Self, RasterError> {
        let (direction, up) = view.direction_and_up();
        Self::framing(mesh, direction, up, lens, aspect)
    }

    /// The side of a pixel of a picture so many pixels high, in model units,
    /// at that distance from the eye along the view.
    #[must_use]
    pub fn pixel_size(&self, distance: f64, height: u32) -> f64 {
        let window = match self.lens {
            Lens::Perspective { fov_y } => 2.0 * (fov_y / 2.0).tan() * distance,
            Lens::Orthographic { height } | Lens::Oblique { height, .. } => height,
        };
        window / f64::from(height.max(1))
    }
}
