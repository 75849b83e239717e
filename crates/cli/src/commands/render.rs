//! `render`: draw a picture.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use csg::{Color, Mesh};
use glam::DVec3;
use raster::view_reference::ViewReference;
use raster::{
    AntiAliasing, Camera, Framing, Image, Lens, Prepared, RasterError, Renderer, StandardView,
    clear_view, contact_sheet, integer_depth_png, turntable, turntable_camera, write_apng,
    write_gif,
};

use super::annotate::Annotations;
use super::lighting::Lighting;
use super::looks::Looks;
use super::parse::{color, point};
use super::view_reference::{Reference, least_pixel};
use crate::failure::{Failure, exit_codes};
use crate::input::Subject;
use crate::mesher::{MesherOptions, Product, produce};
use crate::output;
use crate::progress::Progress;

/// Options of `render`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Where to write the picture (.png, or .gif for a turntable), or `-` for standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Width and height in pixels
    #[arg(long, aliases = ["resolution", "imgsize"], value_name = "WxH", default_value = "1024x768")]
    size: Size,
    /// front, back, left, right, top, bottom or iso; or the direction to look
    /// along as X,Y,Z; or eye and target as X,Y,Z:X,Y,Z [default: front for an
    /// oblique projection; else iso, turned where that hides a cut or shows little
    /// but one face]
    #[arg(long, value_name = "VIEW", allow_hyphen_values = true)]
    camera: Option<View>,
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
    #[arg(long, value_name = "DISTANCE")]
    near: Option<f64>,
    /// Distance of the far plane, likewise
    #[arg(long, value_name = "DISTANCE")]
    far: Option<f64>,
    /// Colour behind the model as RRGGBB, sRGB; transparent by default
    #[arg(long, alias = "background-color", value_name = "RRGGBB", value_parser = color)]
    background: Option<Color>,
    #[command(flatten)]
    reference: Reference,
    #[command(flatten)]
    looks: Looks,
    #[command(flatten)]
    lighting: Lighting,
    #[command(flatten)]
    annotations: Annotations,
    #[command(flatten)]
    mesher: MesherOptions,
}

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Size {
    width: u32,
    height: u32,
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

impl Options {
    /// Whether the picture shows no more of a mesh than its faces.
    pub(crate) fn faces_only(&self) -> bool {
        self.looks.faces_only() && !self.annotations.needs_connections()
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
}

impl FromStr for View {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(view) = StandardView::from_name(text) {
            return Ok(Self::Standard(view));
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
                "give one of {names}, a direction like -1,1,-1, or eye and target like 3,-3,2:0,0,0"
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

pub(crate) fn run(
    subject: impl FnOnce() -> Result<Subject, Failure>,
    options: &Options,
) -> Result<(), Failure> {
    let extension = options.output.extension().and_then(|e| e.to_str());
    let is_png = extension.is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let is_animation = options.looks.turntable.is_some() && is_gif(&options.output);
    if !(output::is_stream(&options.output) || is_png || is_animation) {
        let cause = format!(
            "{}: pictures are written as .png, turntables as .gif as well",
            options.output.display()
        );
        return Err(Failure::new(
            exit_codes::USAGE,
            "no such picture format",
            cause,
        ));
    }
    let progress = Progress::new();
    let mut product = {
        let needs = |points: &[DVec3]| quarter_pixel(points, options);
        produce(subject, &options.mesher, false, &needs, &progress)?
    };
    progress.stage("drawing");
    let empty = product.mesh.triangles.is_empty();
    let png = draw(&mut product, options).map_err(|error| {
        let context = "cannot draw the model";
        let failure = Failure::new(exit_codes::MODEL, context, error);
        if empty {
            failure.hint("the mesh is empty: is the solid, or are its parts smaller than a cell?")
        } else {
            failure
        }
    })?;
    progress.stage("writing");
    product.stage("write", |_| output::write_picture(&options.output, &png))?;
    if options.looks.stats {
        if let Some(tolerance) = product.tolerance {
            eprintln!("{:<22}{tolerance:>12.3e}", "tolerance");
        }
        for (stage, seconds) in &product.seconds {
            eprintln!("{:<22}{:>12.1} ms", stage, seconds * 1e3);
        }
    }
    Ok(())
}

/// The lens, and the width of the picture by its height.
fn lens_and_aspect(options: &Options) -> (Lens, f64) {
    // Framing finds the height of parallel projections.
    let lens = match options.projection {
        Projection::Orthographic => Lens::Orthographic { height: 1.0 },
        Projection::Oblique(ratio, degrees) => Lens::Oblique {
            height: 1.0,
            ratio,
            angle: degrees.to_radians(),
        },
        Projection::Perspective if options.orthographic => Lens::Orthographic { height: 1.0 },
        Projection::Perspective => Lens::Perspective {
            fov_y: options.fov.to_radians(),
        },
    };
    let Size { width, height } = options.size;
    (lens, f64::from(width) / f64::from(height))
}

/// Along which the camera looks, and what is upwards.
fn direction(mesh: &Mesh, options: &Options) -> (DVec3, DVec3) {
    if let Some(direction) = options.reference.direction() {
        let up = options.reference.up();
        return (direction, up.unwrap_or_else(|| up_for(direction)));
    }
    let direction = match (options.camera, options.projection) {
        (Some(View::Standard(view)), _) => return view.direction_and_up(),
        (Some(View::Along(direction)), _) => direction,
        (Some(View::FromTo(eye, target)), _) => target - eye,
        (None, Projection::Oblique(..)) => return StandardView::Front.direction_and_up(),
        (None, _) => clear_view(mesh, &options.looks.sections()),
    };
    (direction, options.up.unwrap_or_else(|| up_for(direction)))
}

/// The camera that sees the mesh as the options say.
fn camera(mesh: &Mesh, options: &Options) -> Result<Camera, RasterError> {
    let (lens, aspect) = lens_and_aspect(options);
    let aspect = aspect * options.annotations.share();
    let mesh = &*options.annotations.framed(mesh);
    let (direction, up) = direction(mesh, options);
    let framing = Framing {
        direction,
        up,
        lens,
        aspect,
        shadow: options.looks.casts_shadow(direction),
    };
    let framed = framing.camera(mesh)?;
    let depths = |camera: Camera| Camera {
        near: options.near.unwrap_or(camera.near),
        far: options.far.unwrap_or(camera.far),
        ..camera
    };
    let Some(View::FromTo(eye, target)) = options.camera else {
        return Ok(depths(framed));
    };
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
fn reference(mesh: &Mesh, camera: &Camera, options: &Options) -> Option<ViewReference> {
    let parallel = options.orthographic || options.projection != Projection::Perspective;
    let (_, aspect) = lens_and_aspect(options);
    options.reference.view(mesh, camera, parallel, aspect)
}

/// A quarter of a pixel where points come nearest to the eye.
fn quarter_pixel(points: &[DVec3], options: &Options) -> Option<f64> {
    let mesh = Mesh::new(points.to_vec(), Vec::new());
    let camera = camera(&mesh, options).ok()?;
    let along = (camera.target - camera.eye).try_normalize()?;
    let depths = points.iter().map(|&p| (p - camera.eye).dot(along));
    let nearest = depths.fold(f64::INFINITY, f64::min).max(camera.near);
    let height = options.size.height;
    let pixel = match reference(&mesh, &camera, options) {
        Some(reference) => least_pixel(&reference, height),
        None => camera.pixel_size(nearest, height),
    };
    let extent = |axis: DVec3| {
        let along = points.iter().map(|p| p.dot(axis));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        high - low
    };
    let side = extent(DVec3::X).max(extent(DVec3::Y)).max(extent(DVec3::Z));
    // Nobody waits for a mesh finer than that because the eye is inside.
    let tolerance = (pixel / 4.0).clamp(side * 1e-6, side * 1e-2);
    (tolerance > 0.0).then_some(tolerance)
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
enum Refused {
    #[error(transparent)]
    Raster(#[from] RasterError),
    #[error(
        "colours by deviation and patterns by surface need a solid, and this is a mesh: give a scene"
    )]
    NoSolid,
    #[error("no dimension {0}: give the names of two flat, parallel faces")]
    Dimension(String),
}

impl From<String> for Refused {
    fn from(names: String) -> Self {
        Self::Dimension(names)
    }
}

/// Whether a file's extension is that of a GIF.
fn is_gif(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.is_some_and(|e| e.eq_ignore_ascii_case("gif"))
}

/// The picture as the bytes of a PNG file. A single picture uses up the mesh.
fn draw(product: &mut Product, options: &Options) -> Result<Vec<u8>, Refused> {
    let Size { width, height } = options.size;
    let program = product.program.take();
    if program.is_none() && (options.annotations.needs_solid() || options.lighting.needs_solid()) {
        return Err(Refused::NoSolid);
    }
    let surfaces = program
        .as_ref()
        .map_or(&[][..], |program| program.surfaces());
    // Those of the mesh, before colours take their places.
    let own = product.mesh.surfaces.iter();
    let own: Vec<_> = own
        .filter_map(|own| surfaces.get(own.surface as usize).copied())
        .collect();
    let legend = options.annotations.prepare(&mut product.mesh, surfaces);
    let unit = product.mesh.unit;
    let camera = product.stage("frame", |product| camera(&product.mesh, options))?;
    let looks = &options.looks;
    let mut render = looks.render_options((camera.target - camera.eye).normalize_or_zero());
    if let Some(background) = options.background {
        render.background = background;
    }
    options.lighting.apply(&mut render);
    render.cap_color = options.annotations.cap_color;
    if looks.depth_bits.is_some() {
        // Depths have no mean.
        render.anti_aliasing = AntiAliasing::None;
    }
    let sections = looks.sections();
    let several = looks.sheet.is_some() || looks.turntable.is_some();
    let view = match reference(&product.mesh, &camera, options) {
        Some(reference) => reference.view()?,
        None => camera.view(width, height)?,
    };
    let size = [width, height];
    let dimensions = options.annotations.dimensions(&product.mesh, &view, size)?;
    if let Some(way) = looks.hidden_surface {
        let image = product.stage("draw", |product| {
            way.draw(&product.mesh, &view, [width, height], &render)
        })?;
        return Ok(image.to_png()?);
    }
    let scene = product.stage("prepare", |product| {
        if !sections.is_empty() {
            Prepared::with_sections(&product.mesh, &sections)
        } else if several {
            Ok(Prepared::new(&product.mesh))
        } else {
            let mesh = std::mem::take(&mut product.mesh);
            Ok(Prepared::for_view(mesh, &view, width, height, &render))
        }
    })?;
    let scene = options.lighting.dye(scene, &own, &render);
    let (mesh, (lens, aspect)) = (&product.mesh, lens_and_aspect(options));
    if looks.sheet.is_some() {
        let angle = looks.angle();
        return Ok(contact_sheet(mesh, &scene, lens, angle, width, height, &render)?.to_png()?);
    }
    if let Some(frames) = looks.turntable {
        // At the attitude of the camera, as far away as all sides need.
        let around = turntable_camera(mesh, StandardView::Iso, lens, aspect)?;
        let back = (camera.eye - camera.target).normalize_or_zero();
        let camera = Camera {
            eye: around.target + back * around.eye.distance(around.target),
            up: camera.up,
            ..around
        };
        let frames = turntable(&scene, &camera, frames, width, height, &render)?;
        let mut file = Vec::new();
        if is_gif(&options.output) {
            write_gif(&frames, FRAMES_PER_SECOND, &mut file)?;
        } else {
            write_apng(&frames, FRAMES_PER_SECOND, &mut file)?;
        }
        return Ok(file);
    }
    let mut renderer = Renderer::default();
    let mut image = Image::default();
    let stats = product.stage("draw", |_| {
        renderer.draw_shown(
            &scene,
            &view,
            width,
            height,
            &render,
            looks.show(),
            &mut image,
        )
    })?;
    if looks.stats {
        eprint!("{stats}");
    }
    let (camera, behind) = ((&camera, &view), render.background);
    options.annotations.draw(
        &dimensions,
        legend.as_ref(),
        unit,
        camera,
        behind,
        &mut image,
    );
    if let Some(bits) = looks.depth_bits {
        return Ok(integer_depth_png(
            &renderer.integer_depth_buffer(bits),
            bits,
        )?);
    }
    Ok(product.stage("encode", |_| image.to_png())?)
}

/// Speed of a turntable.
const FRAMES_PER_SECOND: u16 = 15;

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
        for faulty in [
            "",
            "above",
            "0,0,0",
            "1,2",
            "1,2,nan",
            "1,1,1:1,1,1",
            "1,1,1,1,1,1",
            "1,2,3,4",
            "1,2,3,4,5,6,7",
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
