//! Options of where a picture is seen from, and how.

use std::str::FromStr;

use csg::Mesh;
use glam::{DMat3, DVec3};
use raster::view_reference::ViewReference;
use raster::{Camera, Framing, Lens, RasterError, StandardView, clear_view};

use super::annotate::Annotations;
use super::looks::Looks;
use super::parse::{depth, numbers, point};
use super::view_reference::{Reference, least_pixel};

/// Size of the picture, camera and projection.
#[derive(Debug, clap::Args)]
pub(super) struct Viewing {
    /// Width and height in pixels
    #[arg(long, aliases = ["resolution", "imgsize"], value_name = "WxH", default_value = "1024x768")]
    pub(super) size: Size,
    /// front, back, left, right, top, bottom or iso; or the direction to look
    /// along as X,Y,Z; or eye and target as X,Y,Z:X,Y,Z, or OpenSCAD's six or seven
    /// numbers: eye and target, or target, rotation in degrees and distance [default: front for an
    /// oblique projection; else iso, turned where that hides a cut or shows little
    /// but one face]
    #[arg(long, value_name = "VIEW", allow_hyphen_values = true)]
    camera: Option<View>,
    /// Move an eye that --camera gives along its direction and to the side until all of the model
    /// is in the picture, as for directions, which always show all of it
    #[arg(long)]
    viewall: bool,
    /// Look at the middle of the model from the same side and distance, in place of the target that
    /// --camera gives
    #[arg(long)]
    autocenter: bool,
    /// Vertical field of view in degrees
    #[arg(long, alias = "camera-view-angle", value_name = "DEGREES", default_value_t = 30.0,
          value_parser = field_of_view)]
    fov: f64,
    /// Parallel instead of perspective projection
    #[arg(long, alias = "camera-orthographic", conflicts_with = "fov")]
    orthographic: bool,
    /// perspective, ortho, cavalier or cabinet; or RATIO,DEGREES for any other
    /// oblique projection: depth is drawn at that part of its length, receding
    /// at that angle from the picture's x axis
    #[arg(long, value_name = "KIND", default_value = "perspective", conflicts_with_all = ["orthographic", "fov"])]
    projection: Projection,
    /// What is upwards in the picture, unless a standard view says so [default:
    /// Z, or Y for a view along Z]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = vector)]
    up: Option<DVec3>,
    /// Distance of the near plane from the eye: what is nearer is not drawn
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, value_parser = depth)]
    near: Option<f64>,
    /// Distance of the far plane, likewise
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, value_parser = depth)]
    far: Option<f64>,
    #[command(flatten)]
    reference: Reference,
}

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Size {
    pub(super) width: u32,
    pub(super) height: u32,
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Like 1024x768, or 1024,768 as OpenSCAD and f3d have it.
        let parts = text.split_once(['x', ',']);
        let sides = parts.and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
        match sides {
            Some((width, height))
                if (1..=raster::MAX_SIZE).contains(&width)
                    && (1..=raster::MAX_SIZE).contains(&height) =>
            {
                Ok(Self { width, height })
            }
            _ => Err(format!(
                "give width and height from 1 to {}, like 1024x768",
                raster::MAX_SIZE
            )),
        }
    }
}

/// How the camera projects.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Projection {
    Perspective,
    Orthographic,
    /// Ratio and angle in degrees.
    Oblique(f64, f64),
}

impl FromStr for Projection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let oblique = |text: &str| {
            let (ratio, degrees) = text.split_once(',')?;
            let (ratio, degrees): (f64, f64) = (ratio.parse().ok()?, degrees.parse().ok()?);
            let sound = (0.0..=10.0).contains(&ratio) && degrees.is_finite();
            sound.then_some(Self::Oblique(ratio, degrees))
        };
        match text {
            "perspective" | "p" => Ok(Self::Perspective),
            "ortho" | "orthographic" | "o" => Ok(Self::Orthographic),
            "cavalier" => Ok(Self::Oblique(1.0, 45.0)),
            "cabinet" => Ok(Self::Oblique(0.5, 45.0)),
            _ => oblique(text).ok_or_else(|| {
                "give perspective, ortho, cavalier, cabinet, or ratio and angle like 0.5,30".into()
            }),
        }
    }
}

/// Where the camera is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum View {
    Standard(StandardView),
    Along(DVec3),
    FromTo(DVec3, DVec3),
    /// Eye, target, and what is upwards.
    Turned(DVec3, DVec3, DVec3),
}

impl View {
    /// Eye and target, if they were given.
    fn ends(self) -> Option<(DVec3, DVec3)> {
        match self {
            Self::FromTo(eye, target) | Self::Turned(eye, target, _) => Some((eye, target)),
            Self::Standard(_) | Self::Along(_) => None,
        }
    }

    /// As OpenSCAD has it: a camera that looks down on the target from a distance, Y upwards,
    /// and is then turned about X, Y and Z.
    fn gimbal(target: DVec3, degrees: DVec3, distance: f64) -> Option<Self> {
        let [x, y, z] = degrees.to_array().map(f64::to_radians);
        let turn =
            DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
        let back = distance * turn.z_axis;
        (distance > 0.0).then_some(Self::Turned(target + back, target, turn.y_axis))
    }
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(view) = StandardView::from_name(text) {
            return Ok(Self::Standard(view));
        }
        if let Some([x, y, z, a, b, c, distance]) = numbers(text) {
            let (target, turn) = (DVec3::new(x, y, z), DVec3::new(a, b, c));
            let fault = "the seventh number is the camera's distance: give one above 0";
            return Self::gimbal(target, turn, distance).ok_or_else(|| fault.into());
        }
        // Eye and target also as six numbers, as OpenSCAD has them.
        let third_comma = text.match_indices(',').nth(2).map(|(at, _)| at);
        let halves = third_comma.map(|at| (&text[..at], &text[at + 1..]));
        let view = match text.split_once(':').or(halves) {
            Some((eye, target)) => point(eye)
                .zip(point(target))
                .and_then(|(eye, target)| (eye != target).then_some(Self::FromTo(eye, target))),
            None => point(text)
                .filter(|direction| *direction != DVec3::ZERO)
                .map(Self::Along),
        };
        view.ok_or_else(|| {
            let names = StandardView::ALL.map(StandardView::name).join(", ");
            format!(
                "give one of {names}, a direction like -1,1,-1, eye and target like \
                 3,-3,2:0,0,0, or OpenSCAD's numbers: six, eye and target like 3,-3,2,0,0,0, \
                 or seven, target, rotation in degrees and distance like 0,0,0,55,0,25,140"
            )
        })
    }
}

fn vector(text: &str) -> Result<DVec3, String> {
    let vector = point(text).filter(|vector| *vector != DVec3::ZERO);
    vector.ok_or_else(|| "give a direction like 0,0,1".into())
}

fn field_of_view(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => Err("give an angle between 0 and 180 degrees".into()),
    }
}

impl Viewing {
    /// The lens, and the width of the picture by its height.
    pub(super) fn lens_and_aspect(&self) -> (Lens, f64) {
        // Framing finds the height of parallel projections.
        let lens = match self.projection {
            Projection::Orthographic => Lens::Orthographic { height: 1.0 },
            Projection::Oblique(ratio, degrees) => Lens::Oblique {
                height: 1.0,
                ratio,
                angle: degrees.to_radians(),
            },
            Projection::Perspective if self.orthographic => Lens::Orthographic { height: 1.0 },
            Projection::Perspective => Lens::Perspective {
                fov_y: self.fov.to_radians(),
            },
        };
        let Size { width, height } = self.size;
        (lens, f64::from(width) / f64::from(height))
    }

    /// Along which the camera looks, and what is upwards.
    fn direction(&self, mesh: &Mesh, looks: &Looks) -> (DVec3, DVec3) {
        if let Some(direction) = self.reference.direction() {
            let up = self.reference.up();
            return (direction, up.unwrap_or_else(|| up_for(direction)));
        }
        let direction = match (self.camera, self.projection) {
            (Some(View::Standard(view)), _) => return view.direction_and_up(),
            (Some(View::Along(direction)), _) => direction,
            (Some(View::FromTo(eye, target)), _) => target - eye,
            (Some(View::Turned(eye, target, up)), _) => return (target - eye, up),
            (None, Projection::Oblique(..)) => return StandardView::Front.direction_and_up(),
            (None, _) => clear_view(mesh, &looks.sections()),
        };
        (direction, self.up.unwrap_or_else(|| up_for(direction)))
    }

    /// The camera that sees the mesh as the options say.
    pub(super) fn camera(
        &self,
        mesh: &Mesh,
        looks: &Looks,
        annotations: &Annotations,
    ) -> Result<Camera, RasterError> {
        let (lens, aspect) = self.lens_and_aspect();
        let aspect = aspect * annotations.share();
        let mesh = &*annotations.framed(mesh);
        let (direction, up) = self.direction(mesh, looks);
        let framing = Framing {
            direction,
            up,
            lens,
            aspect,
            shadow: looks.casts_shadow(direction),
        };
        let framed = framing.camera(mesh)?;
        let depths = |camera: Camera| Camera {
            near: self.near.unwrap_or(camera.near),
            far: self.far.unwrap_or(camera.far),
            ..camera
        };
        let ends = self.camera.and_then(View::ends);
        let Some((mut eye, mut target)) = ends.filter(|_| !self.viewall) else {
            return Ok(depths(framed));
        };
        if self.autocenter
            && let Some((low, high)) = mesh.bounds()
        {
            let middle = low.midpoint(high);
            eye += middle - target;
            target = middle;
        }
        // The same depths, seen from the eye that was asked for.
        let moved = (framed.eye - eye).dot(direction.normalize());
        let far = (framed.far + moved).max(f64::MIN_POSITIVE);
        let near = (framed.near + moved).max(far * 1e-3);
        Ok(depths(Camera {
            eye,
            target,
            near,
            far,
            ..framed
        }))
    }

    /// The view reference that is asked for, if one is.
    pub(super) fn reference(&self, mesh: &Mesh, camera: &Camera) -> Option<ViewReference> {
        let parallel = self.orthographic || self.projection != Projection::Perspective;
        let (_, aspect) = self.lens_and_aspect();
        self.reference.view(mesh, camera, parallel, aspect)
    }

    /// A quarter of a pixel where points come nearest to the eye.
    pub(super) fn quarter_pixel(
        &self,
        points: &[DVec3],
        looks: &Looks,
        annotations: &Annotations,
    ) -> Option<f64> {
        let mesh = Mesh::new(points.to_vec(), Vec::new());
        let camera = self.camera(&mesh, looks, annotations).ok()?;
        let along = (camera.target - camera.eye).try_normalize()?;
        let depths = points.iter().map(|&p| (p - camera.eye).dot(along));
        let nearest = depths.fold(f64::INFINITY, f64::min).max(camera.near);
        let height = self.size.height;
        let pixel = match self.reference(&mesh, &camera) {
            Some(reference) => least_pixel(&reference, height),
            None => camera.pixel_size(nearest, height),
        };
        let (low, high) = mesh.bounds()?;
        let side = (high - low).max_element();
        // Nobody waits for a mesh finer than that because the eye is inside.
        let tolerance = (pixel / 4.0).clamp(side * 1e-6, side * 1e-2);
        (tolerance > 0.0).then_some(tolerance)
    }
}

/// Z is up in the picture unless the view is along it.
fn up_for(direction: DVec3) -> DVec3 {
    if direction.truncate() == glam::DVec2::ZERO {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(
            "64x48".parse(),
            Ok(Size {
                width: 64,
                height: 48
            })
        );
        assert_eq!("64,48".parse(), "64x48".parse::<Size>());
        for faulty in ["", "64", "64x", "0x48", "-1x3", "64x48x2", "99999x1"] {
            assert!(faulty.parse::<Size>().is_err(), "{faulty}");
        }
    }

    #[test]
    fn views() {
        assert_eq!("top".parse(), Ok(View::Standard(StandardView::Top)));
        assert_eq!(
            "-1,1,-1".parse(),
            Ok(View::Along(DVec3::new(-1.0, 1.0, -1.0)))
        );
        let eye = DVec3::new(3.0, -3.0, 2.0);
        for text in ["3,-3,2:0,0,0", "3,-3,2,0,0,0"] {
            assert_eq!(text.parse(), Ok(View::FromTo(eye, DVec3::ZERO)));
        }
        // From above, from the front, and OpenSCAD's own first view.
        for (text, eye, up) in [
            ("1,2,3,0,0,0,10", DVec3::new(1.0, 2.0, 13.0), DVec3::Y),
            ("1,2,3,90,0,0,10", DVec3::new(1.0, -8.0, 3.0), DVec3::Z),
            ("0,0,0,90,0,90,5", DVec3::new(5.0, 0.0, 0.0), DVec3::Z),
        ] {
            let Ok(View::Turned(found, _, upwards)) = text.parse() else {
                panic!("{text}");
            };
            assert!(
                found.distance(eye) < 1e-12 && upwards.distance(up) < 1e-12,
                "{text}: {found}"
            );
        }
        for faulty in [
            "",
            "above",
            "0,0,0",
            "1,2",
            "1,2,nan",
            "1,1,1:1,1,1",
            "1,1,1,1,1,1",
            "1,2,3,4",
            "1,2,3,4,5,6,0",
            "1,2,3,4,5,6,7,8",
            "1,2,3:4,5",
        ] {
            assert!(faulty.parse::<View>().is_err(), "{faulty}");
        }
    }

    #[test]
    fn projections() {
        assert_eq!("ortho".parse(), Ok(Projection::Orthographic));
        assert_eq!("p".parse(), Ok(Projection::Perspective));
        assert_eq!("cabinet".parse(), Ok(Projection::Oblique(0.5, 45.0)));
        assert_eq!("0.7,-30".parse(), Ok(Projection::Oblique(0.7, -30.0)));
        for faulty in ["", "fisheye", "1", "-1,30", "1,x", "nan,1", "1,inf"] {
            assert!(faulty.parse::<Projection>().is_err(), "{faulty}");
        }
    }
}
