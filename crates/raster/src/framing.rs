//! Standard views and automatic framing.

use glam::{DVec3, DVec4};

use crate::camera::{Camera, Frame, Lens};
use crate::scene::{combine_finite, finite_bounds};
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

impl Camera {
    /// A camera that looks along `direction` and sees the whole of `mesh` as
    /// large as possible, with a margin of 5% on the tightest sides. The
    /// height of a parallel lens is replaced by the fitting one. Near and far
    /// enclose the mesh's bounding sphere. O(vertices).
    ///
    /// # Errors
    /// [`RasterError::NothingToFrame`] for a mesh without finite vertices;
    /// [`RasterError::SingularView`] if `direction` is zero or along `up`.
    pub fn framing(
        mesh: &Mesh,
        direction: DVec3,
        up: DVec3,
        lens: Lens,
        aspect: f64,
    ) -> Result<Self, RasterError> {
        let frame = Frame::right_handed(direction, up);
        if !(frame.u.is_finite() && frame.v.is_finite() && frame.n.is_finite()) {
            return Err(RasterError::SingularView);
        }
        let points = &mesh.positions;
        let (low, high) = finite_bounds(points).ok_or(RasterError::NothingToFrame)?;
        let centre = low + (high - low) / 2.0;
        let square = combine_finite(points, |p| p.distance_squared(centre), f64::max);
        let radius = square.unwrap_or_default().sqrt();
        // A single point is framed as if it had a size.
        let radius = if radius > 0.0 {
            radius
        } else {
            centre.length().max(1.0) * 1e-3
        };
        let local = |p: DVec3| {
            let d = p - centre;
            DVec3::new(d.dot(frame.u), d.dot(frame.v), d.dot(frame.n))
        };
        let (target, distance, lens) = match lens {
            Lens::Perspective { fov_y } => {
                // Each side of the frustum is pushed outward until it touches
                // the mesh; the eye then is where opposite sides meet.
                let tan_y = (fov_y / 2.0).tan() * FILL;
                let tan_x = tan_y * aspect;
                let tangents = DVec4::new(tan_x, tan_x, tan_y, tan_y);
                let reach = |p| {
                    let q = local(p);
                    DVec4::new(q.x, -q.x, q.y, -q.y) + tangents * q.z
                };
                let reach = combine_finite(points, reach, DVec4::max).unwrap_or_default();
                let distance = ((reach[0] + reach[1]) / (2.0 * tan_x))
                    .max((reach[2] + reach[3]) / (2.0 * tan_y))
                    .max(radius * 1e-3);
                let shift = frame.u * ((reach[0] - reach[1]) / 2.0)
                    + frame.v * ((reach[2] - reach[3]) / 2.0);
                (centre + shift, distance, lens)
            }
            Lens::Orthographic { .. } | Lens::Oblique { .. } => {
                let skew = match lens {
                    Lens::Oblique { ratio, angle, .. } => {
                        (ratio * angle.cos(), ratio * angle.sin())
                    }
                    _ => (0.0, 0.0),
                };
                let drawn = |p| {
                    let q = local(p);
                    let drawn = DVec3::new(q.x - q.z * skew.0, q.y - q.z * skew.1, q.z);
                    (drawn, drawn)
                };
                let wider = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
                let (low, high) = combine_finite(points, drawn, wider).unwrap_or_default();
                let size = high - low;
                let height = (size.y.max(size.x / aspect) / FILL).max(radius * 1e-3);
                let middle = (low + high) / 2.0;
                let lens = match lens {
                    Lens::Oblique { ratio, angle, .. } => Lens::Oblique {
                        height,
                        ratio,
                        angle,
                    },
                    _ => Lens::Orthographic { height },
                };
                (
                    centre + frame.u * middle.x + frame.v * middle.y,
                    3.0 * radius,
                    lens,
                )
            }
        };
        let eye = target + frame.n * distance;
        // The bounding sphere, seen along the view.
        let depth = (centre - eye).dot(-frame.n);
        let far = depth + radius * 1.01;
        let near = (depth - radius * 1.01).max(far * 1e-3);
        Ok(Self {
            eye,
            target,
            up,
            lens,
            near,
            far,
        })
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
}
