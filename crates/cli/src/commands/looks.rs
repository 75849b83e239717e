//! What a picture looks like: the options of `render` beyond its camera.

use csg::{Color, Mesh};
use glam::DVec3;
use raster::hidden_surface::{DepthBuffer, HiddenSurface, Painter, ScanLine};
use raster::{
    AntiAliasing, EdgeOptions, HiddenEdges, Image, Interpolation, ProjectionAngle, RasterError,
    RenderOptions, SectionPlane, View, render_reference, wireframe_reference,
};

use super::parse::{WrittenPlane, plane, whole};

/// Options for looks.
#[derive(Debug, clap::Args)]
pub(super) struct Looks {
    /// Where the light is reckoned: once a triangle, at its corners, or at
    /// every pixel
    #[arg(long, value_enum, default_value_t = Shading::Phong)]
    shading: Shading,
    /// How edges are smoothed
    #[arg(long, value_enum, default_value_t = Smoothing::Msaa4)]
    anti_aliasing: Smoothing,
    /// Faces alone, without the edges, the occlusion and the shadow that pictures
    /// have unless it is given; those that are asked for as well are drawn
    #[arg(long)]
    plain: bool,
    /// Draw feature edges and silhouettes over the shading
    #[arg(long)]
    edges: bool,
    /// Draw hidden edges too, dashed
    #[arg(long)]
    hidden_edges: bool,
    /// Draw the edges of all triangles
    #[arg(long)]
    wireframe: bool,
    /// Draw all vertices
    #[arg(long)]
    points: bool,
    /// Width of edges in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1.2, value_parser = width)]
    line_width: f64,
    /// Cut away the side that a normal points to, and cap the cut: x, y or z
    /// with a position, like y=0 or -y=0, or NX,NY,NZ:PX,PY,PZ; up to four
    #[arg(long, value_name = "PLANE", allow_hyphen_values = true, value_parser = plane)]
    section: Vec<WrittenPlane>,
    /// Darken where surroundings hide light
    #[arg(long)]
    ambient_occlusion: bool,
    /// Cast a soft shadow on the ground
    #[arg(long)]
    shadow: bool,
    /// Draw the axes in the lower left corner
    #[arg(long, alias = "axis")]
    axes: bool,
    /// Draw faces seen from behind as well, lit from their side
    #[arg(long)]
    two_sided: bool,
    /// What the picture shows
    #[arg(long, value_enum, default_value_t = Show::Color)]
    show: Show,
    /// Find hidden surfaces slowly and by the book, to show how: faces alone
    #[arg(long, value_enum, value_name = "WAY", conflicts_with_all = ["show", "section", "sheet", "turntable"])]
    pub(super) hidden_surface: Option<HiddenSurfaces>,
    /// With `--show depth`: the depth buffer's integers, of so many bits, as a grey
    /// PNG; 0 is near
    #[arg(long, value_name = "BITS", requires = "show",
          value_parser = whole::<u32>(1..=16))]
    pub(super) depth_bits: Option<u32>,
    /// Four views on one sheet instead of one, as the angle of projection puts
    /// them
    #[arg(long, value_enum, value_name = "ANGLE", num_args = 0..=1, default_missing_value = "third",
          conflicts_with_all = ["turntable", "show"])]
    pub(super) sheet: Option<Angle>,
    /// Go once round the model in so many frames, as an animated PNG or GIF
    #[arg(long, value_name = "FRAMES", conflicts_with = "show",
          value_parser = whole::<u32>(1..=1000))]
    pub(super) turntable: Option<u32>,
    /// Say on standard error what was drawn and what was left out
    #[arg(long)]
    pub(super) stats: bool,
}

/// Where the light is reckoned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Shading {
    /// Once a triangle
    Flat,
    /// At the corners of each triangle
    Gouraud,
    /// At every pixel
    Phong,
}

/// How edges are smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Smoothing {
    /// One sample a pixel
    None,
    /// Four samples a pixel
    Msaa4,
    /// Eight samples a pixel
    Msaa8,
    /// Drawn at twice the size each way
    Supersample2,
    /// Drawn at four times the size each way
    Supersample4,
}

/// Where views are put on a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Angle {
    /// What is seen from the right on the right, from above above
    Third,
    /// What is seen from the left on the right, from above below
    First,
}

/// Ways to find hidden surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum HiddenSurfaces {
    /// A depth buffer
    Zbuffer,
    /// Triangles from far to near, each over the others: wrong where they cut
    /// each other
    Painter,
    /// A depth buffer of one row at a time
    Scanline,
    /// Not at all: edges alone, clipped by outcodes (Cohen–Sutherland)
    Wireframe,
}

impl HiddenSurfaces {
    /// Draws a mesh, smoothed by drawing it larger as far as the options ask.
    pub(super) fn draw(
        self,
        mesh: &Mesh,
        view: &View,
        [width, height]: [u32; 2],
        options: &RenderOptions,
    ) -> Result<Image, RasterError> {
        let scale = match options.anti_aliasing {
            AntiAliasing::None => 1,
            AntiAliasing::Supersample(n) => n,
            _ => 2,
        };
        let [w, h] = [width, height].map(|side| side.saturating_mul(scale));
        let reference =
            |way: &mut dyn HiddenSurface| render_reference(mesh, view, w, h, options, way);
        let image = match self {
            Self::Zbuffer => {
                let pixels = w.min(raster::MAX_SIZE) as usize * h.min(raster::MAX_SIZE) as usize;
                reference(&mut DepthBuffer::new(pixels))
            }
            Self::Painter => reference(&mut Painter),
            Self::Scanline => reference(&mut ScanLine::new(w)),
            Self::Wireframe => {
                let color = Color::from_linear([0.01; 3]);
                wireframe_reference(mesh, view, w, h, color, options.background)
            }
        };
        Ok(image?.shrink(scale))
    }
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Show {
    /// The model
    Color,
    /// Its distance: near white, far dark
    Depth,
    /// Its normals, as red, green and blue
    Normals,
    /// Its surfaces, each in a colour
    Surfaces,
    /// How open it is to light from everywhere
    Occlusion,
}

fn width(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(pixels) if pixels > 0.0 && pixels <= 100.0 => Ok(pixels),
        _ => Err("give a width from 0 to 100 pixels".into()),
    }
}

impl Looks {
    /// The renderer's options.
    pub(super) fn render_options(&self, direction: DVec3) -> RenderOptions {
        let mut options = RenderOptions::default();
        options.interpolation = match self.shading {
            Shading::Flat => Interpolation::Flat,
            Shading::Gouraud => Interpolation::Gouraud,
            Shading::Phong => Interpolation::Phong,
        };
        options.anti_aliasing = match self.anti_aliasing {
            Smoothing::None => AntiAliasing::None,
            Smoothing::Msaa4 => AntiAliasing::Msaa4,
            Smoothing::Msaa8 => AntiAliasing::Msaa8,
            Smoothing::Supersample2 => AntiAliasing::Supersample(2),
            Smoothing::Supersample4 => AntiAliasing::Supersample(4),
        };
        if self.draws_edges() {
            let lines = self.edges || self.hidden_edges || !self.plain;
            let hidden = if self.hidden_edges {
                HiddenEdges::Dash
            } else {
                HiddenEdges::Omit
            };
            let edges = EdgeOptions::default()
                .features(lines)
                .silhouettes(lines)
                .wireframe(self.wireframe)
                .points(self.points)
                .hidden(hidden)
                .width(self.line_width);
            options.edges = Some(edges);
        }
        options.ambient_occlusion = self.ambient_occlusion || !self.plain;
        options.ground_shadow = self.casts_shadow(direction);
        options.triad = self.axes;
        options.two_sided = self.two_sided;
        options.cull_back_faces = !self.two_sided;
        options
    }

    /// Whether nothing is asked for that takes a mesh whose triangles are
    /// connected: no edges, and no cuts.
    pub(super) fn faces_only(&self) -> bool {
        !self.draws_edges() && self.section.is_empty()
    }

    fn draws_edges(&self) -> bool {
        !self.plain || self.edges || self.hidden_edges || self.wireframe || self.points
    }

    /// Whether there is a shadow for a camera that looks along a direction: one
    /// is seen from above.
    pub(super) fn casts_shadow(&self, direction: DVec3) -> bool {
        self.shadow || (!self.plain && direction.normalize_or_zero().z < -0.05)
    }

    /// Where views are put on a sheet.
    pub(super) fn angle(&self) -> ProjectionAngle {
        match self.sheet {
            Some(Angle::First) => ProjectionAngle::First,
            _ => ProjectionAngle::Third,
        }
    }

    /// What the picture shows.
    pub(super) fn show(&self) -> raster::Show {
        match self.show {
            Show::Color => raster::Show::Color,
            Show::Depth => raster::Show::Depth,
            Show::Normals => raster::Show::Normals,
            Show::Surfaces => raster::Show::Surfaces,
            Show::Occlusion => raster::Show::Occlusion,
        }
    }

    /// The planes that cut the model.
    pub(super) fn sections(&self) -> Vec<SectionPlane> {
        let section = |plane: &WrittenPlane| SectionPlane {
            normal: plane.normal,
            point: plane.point,
        };
        self.section.iter().map(section).collect()
    }
}
