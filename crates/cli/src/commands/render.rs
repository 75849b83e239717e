//! `render`: draw a picture.

use std::convert::Infallible;
use std::path::{Path, PathBuf};

use csg::Color;
use glam::DVec3;
use raster::{
    AntiAliasing, Camera, Image, Prepared, RasterError, Renderer, StandardView, contact_sheet,
    integer_depth_png, turntable, turntable_camera, write_apng, write_gif,
};

use super::annotate::Annotations;
use super::lighting::Lighting;
use super::looks::Looks;
use super::parse::{color, scheme};
use super::viewing::{Size, Viewing};
use crate::failure::{Failure, exit_codes};
use crate::input::Reader;
use crate::mesher::{MesherOptions, Product, produce};
use crate::output;
use crate::progress::Progress;

/// Options of `render`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Where to write the picture (.png, or .gif for a turntable), or `-` for standard output
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    viewing: Viewing,
    /// Colour behind the model by name or as #RRGGBB, sRGB; transparent by default
    #[arg(long, alias = "background-color", value_name = "COLOR", value_parser = color)]
    background: Option<Color>,
    // (Said what to give in its place, who knows OpenSCAD's command line.)
    #[arg(long = "colorscheme", hide = true, value_parser = scheme)]
    _scheme: Option<Infallible>,
    #[command(flatten)]
    looks: Looks,
    #[command(flatten)]
    lighting: Lighting,
    #[command(flatten)]
    annotations: Annotations,
    #[command(flatten)]
    pub(crate) mesher: MesherOptions,
}

impl Options {
    /// Whether the picture shows no more of a mesh than its faces.
    pub(crate) fn faces_only(&self) -> bool {
        self.looks.faces_only() && !self.annotations.needs_connections()
    }
}

pub(crate) fn run(
    subject: Reader<'_>,
    options: &Options,
    progress: &Progress,
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
    output::check_folders([options.output.as_path()])?;
    let mut product = {
        let (looks, annotations) = (&options.looks, &options.annotations);
        let needs = |points: &[DVec3]| options.viewing.quarter_pixel(points, looks, annotations);
        produce(subject, &options.mesher, false, &needs, progress)?
    };
    progress.stage("drawing");
    if product.mesh.triangles.is_empty() {
        let context = "there is nothing to draw";
        return Err(Failure::new(
            exit_codes::MODEL,
            context,
            "the mesh is empty",
        ));
    }
    let png = draw(&mut product, options)
        .map_err(|error| Failure::new(exit_codes::MODEL, "cannot draw the model", error))?;
    progress.stage("writing");
    product.stage("write", |_| output::write_picture(&options.output, &png))?;
    if options.looks.stats {
        if let Some(tolerance) = product.tolerance {
            say!("{:<22}{tolerance:>12.3e}", "tolerance");
        }
        for (stage, seconds) in &product.seconds {
            say!("{:<22}{:>12.1} ms", stage, seconds * 1e3);
        }
    }
    Ok(())
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
    let Size { width, height } = options.viewing.size;
    let program = product.program.take();
    if program.is_none() && (options.annotations.needs_solid() || options.lighting.needs_solid()) {
        return Err(Refused::NoSolid);
    }
    let surfaces = program
        .as_ref()
        .map_or(&[][..], |program| program.carriers());
    // Those of the mesh, before colours take their places.
    let own = product.mesh.surfaces.iter();
    let own: Vec<_> = own
        .filter_map(|own| surfaces.get(own.surface as usize).copied())
        .collect();
    let legend = options.annotations.prepare(&mut product.mesh, surfaces);
    let unit = product.mesh.unit;
    let (looks, annotations) = (&options.looks, &options.annotations);
    let camera = product.stage("frame", |product| {
        options.viewing.camera(&product.mesh, looks, annotations)
    })?;
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
    let view = match options.viewing.reference(&product.mesh, &camera) {
        Some(reference) => reference.view()?,
        None => camera.view(width, height)?,
    };
    let size = [width, height];
    let deviation = product.report.as_ref().and_then(|report| report.deviation);
    let measured = (&product.mesh, deviation.unwrap_or(0.0));
    let dimensions = annotations.dimensions(measured, &view, size)?;
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
    let (mesh, (lens, aspect)) = (&product.mesh, options.viewing.lens_and_aspect());
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
        say!("{}", stats.to_string().trim_end());
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
