//! Options for what is written into a picture: dimensions, a scale, legends.

use std::borrow::Cow;
use std::str::FromStr;

use csg::{LengthUnit, Mesh, Surface};
use glam::DVec3;
use raster::{
    Camera, ColorBy, Dimension, Image, Legend, View, color_by_deviation, draw_dimensions,
    draw_legend, draw_scale_bar, exploded, ink_on,
};

use super::parse::color;

/// Options for lettering and colours that tell something.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Dimensions and colour maps")]
pub(super) struct Annotations {
    /// Draw dimensions: of the bounding box, or between two flat faces by the
    /// names of their surfaces
    #[arg(long, value_name = "bbox|NAME:NAME", conflicts_with_all = ["show", "sheet", "turntable"])]
    dimension: Vec<Measured>,
    /// Draw a bar that tells the scale, of parallel projections or at the model's
    /// middle
    #[arg(long, conflicts_with_all = ["show", "sheet", "turntable"])]
    scale_bar: bool,
    /// Let colours tell something about the faces, with a legend
    #[arg(long, value_enum, value_name = "WHAT")]
    color_by: Option<Told>,
    /// Move connected parts apart by this share of their distance from the middle
    #[arg(long, value_name = "FACTOR", value_parser = factor)]
    explode: Option<f64>,
    /// Colour of cut faces
    #[arg(long, value_name = "COLOR", value_parser = color)]
    pub(super) cap_color: Option<csg::Color>,
}

/// What is measured.
#[derive(Clone, Debug, PartialEq)]
enum Measured {
    Box,
    Between(String, String),
}

impl FromStr for Measured {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some((one, other)) if !one.is_empty() && !other.is_empty() => {
                Ok(Self::Between(one.into(), other.into()))
            }
            None if text == "bbox" => Ok(Self::Box),
            _ => Err("give bbox, or two names like top:bottom".into()),
        }
    }
}

/// What colours tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Told {
    /// The surface
    Surface,
    /// The connected part
    Part,
    /// How far a face leans, in degrees
    Draft,
    /// How much normals turn
    Curvature,
    /// How thick the solid is behind the face
    Thickness,
    /// How far a triangle is from the surface of the solid that it stands for
    Deviation,
}

impl Told {
    fn apply(self, mesh: &mut Mesh, surfaces: &[Surface]) -> Legend {
        let told = match self {
            Self::Surface => ColorBy::Surface,
            Self::Part => ColorBy::Part,
            Self::Draft => ColorBy::Draft,
            Self::Curvature => ColorBy::Curvature,
            Self::Thickness => ColorBy::Thickness,
            Self::Deviation => return color_by_deviation(mesh, surfaces),
        };
        told.apply(mesh)
    }
}

fn factor(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(factor) if (0.0..=100.0).contains(&factor) => Ok(factor),
        _ => Err("give a factor from 0 to 100".into()),
    }
}

impl Annotations {
    /// Whether a mesh is needed whose triangles are connected.
    pub(super) fn needs_connections(&self) -> bool {
        self.explode.is_some() || self.color_by.is_some()
    }

    /// What a camera must see: the model, or the box around it with room for its
    /// dimensions.
    pub(super) fn framed<'a>(&self, mesh: &'a Mesh) -> Cow<'a, Mesh> {
        /// By how much larger than the box.
        const ROOM: f64 = 1.2;
        if self.dimension.is_empty() {
            return Cow::Borrowed(mesh);
        }
        let (low, high) = mesh.bounds().unwrap_or_default();
        let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
        let corner = |k: usize| {
            let sign = |axis: usize| if k >> axis & 1 == 0 { -ROOM } else { ROOM };
            middle + half * DVec3::new(sign(0), sign(1), sign(2))
        };
        let points = mesh.positions.iter().copied();
        let points = points.chain((0..8).map(corner)).collect();
        Cow::Owned(Mesh::new(points, mesh.triangles.clone()))
    }

    /// The part of the picture's width that the model may take beside a legend.
    pub(super) fn share(&self) -> f64 {
        if self.color_by.is_some() { 0.68 } else { 1.0 }
    }

    /// Colours faces and moves parts apart, as the options say; the surfaces are
    /// those of the solid, if the mesh was made from one.
    pub(super) fn prepare(&self, mesh: &mut Mesh, surfaces: &[Surface]) -> Option<Legend> {
        let legend = self.color_by.map(|told| told.apply(mesh, surfaces));
        if let Some(factor) = self.explode {
            *mesh = exploded(mesh, factor);
        }
        legend
    }

    /// Whether colours tell something that only a solid knows.
    pub(super) fn needs_solid(&self) -> bool {
        self.color_by == Some(Told::Deviation)
    }

    /// The dimensions of a mesh as a view shows it; or the names that are not
    /// those of two parallel flat faces. The mesh is within `deviation` of the model.
    pub(super) fn dimensions(
        &self,
        (mesh, deviation): (&Mesh, f64),
        view: &View,
        [width, height]: [u32; 2],
    ) -> Result<Vec<Dimension>, String> {
        let mut found = Vec::new();
        for measured in &self.dimension {
            match measured {
                Measured::Box => {
                    let (low, high) = mesh.bounds().unwrap_or_default();
                    let mut sides = Dimension::of_box(low, high, view, width, height);
                    sides.iter_mut().for_each(|side| side.error = deviation);
                    found.append(&mut sides);
                }
                Measured::Between(one, other) => {
                    let between = Dimension::between(mesh, one, other);
                    found.push(between.ok_or_else(|| format!("{one}:{other}"))?);
                }
            }
        }
        Ok(found)
    }

    /// Draws what is written over the picture.
    pub(super) fn draw(
        &self,
        dimensions: &[Dimension],
        legend: Option<&Legend>,
        unit: LengthUnit,
        (camera, view): (&Camera, &View),
        background: csg::Color,
        image: &mut Image,
    ) {
        let ink = ink_on(background);
        draw_dimensions(dimensions, unit.symbol(), view, ink, image);
        if self.scale_bar {
            let pixel = camera.pixel_size(camera.eye.distance(camera.target), image.height);
            draw_scale_bar(pixel, unit.symbol(), ink, image);
        }
        if let Some(legend) = legend {
            draw_legend(legend, ink, image);
        }
    }
}
