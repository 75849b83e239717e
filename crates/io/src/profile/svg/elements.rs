//! Shapes by their attributes.

use std::f64::consts::{FRAC_PI_2, SQRT_2};

use glam::{DAffine2, DVec2};
use roxmltree::Node;
use svgtypes::NumberListParser;

use super::super::curves::{Outline, Side};
use super::path::{SubPath, sub_paths};
use super::{MOST_SIDES, Reader};
use crate::Error;

/// What an element is, in its own coordinates.
pub(super) enum Shape {
    Nothing,
    /// It has a stroke alone.
    Line,
    /// The image of the disc of radius 1.
    Disc(DAffine2),
    Contours(Vec<SubPath>),
}

impl Reader<'_, '_> {
    pub(super) fn read_shape(&self, node: Node<'_, '_>) -> Result<Shape, Error> {
        match node.tag_name().name() {
            "path" => {
                let data = node.attribute("d").unwrap_or("");
                // (OpenSCAD's chords are those of each arc.)
                let joins = self.options.fineness.is_none();
                let paths = sub_paths(data, self.budget.min(MOST_SIDES), joins);
                let paths = paths.map_err(|problem| self.fault(node, &problem))?;
                Ok(if paths.is_empty() {
                    Shape::Nothing
                } else {
                    Shape::Contours(paths)
                })
            }
            "rect" => self.rect(node),
            "circle" => {
                let radius = self.size(node, "r", 2)?.unwrap_or(0.0);
                self.disc(node, DVec2::splat(radius))
            }
            "ellipse" => {
                let (x, y) = (self.size(node, "rx", 0)?, self.size(node, "ry", 1)?);
                let radii = DVec2::new(x.or(y).unwrap_or(0.0), y.or(x).unwrap_or(0.0));
                self.disc(node, radii)
            }
            "line" => Ok(Shape::Line),
            name => self.polygon(node, name == "polyline"),
        }
    }

    fn disc(&self, node: Node<'_, '_>, radii: DVec2) -> Result<Shape, Error> {
        let [x, y] = [self.length(node, "cx", 0)?, self.length(node, "cy", 1)?];
        if radii.min_element() <= 0.0 {
            return Ok(Shape::Nothing);
        }
        let center = DVec2::new(x.unwrap_or(0.0), y.unwrap_or(0.0));
        let grown = DAffine2::from_scale(radii);
        Ok(Shape::Disc(DAffine2::from_translation(center) * grown))
    }

    /// A length that must not be negative.
    fn size(&self, node: Node<'_, '_>, key: &str, axis: usize) -> Result<Option<f64>, Error> {
        let length = self.length(node, key, axis)?;
        match length {
            Some(length) if length < 0.0 => {
                Err(self.fault(node, &format!("its {key} is negative: {length}")))
            }
            _ => Ok(length),
        }
    }

    fn rect(&self, node: Node<'_, '_>) -> Result<Shape, Error> {
        /// The bulge of a quarter of a circle.
        const QUARTER: f64 = SQRT_2 - 1.0;
        let [x, y] = [self.length(node, "x", 0)?, self.length(node, "y", 1)?];
        let [width, height] = [self.size(node, "width", 0)?, self.size(node, "height", 1)?];
        let (rx, ry) = (self.size(node, "rx", 0)?, self.size(node, "ry", 1)?);
        let low = DVec2::new(x.unwrap_or(0.0), y.unwrap_or(0.0));
        let size = DVec2::new(width.unwrap_or(0.0), height.unwrap_or(0.0));
        if size.min_element() <= 0.0 {
            return Ok(Shape::Nothing);
        }
        let high = low + size;
        let radii = DVec2::new(rx.or(ry).unwrap_or(0.0), ry.or(rx).unwrap_or(0.0));
        let radii = radii.min(0.5 * size);
        let corners = [
            low,
            DVec2::new(high.x, low.y),
            high,
            DVec2::new(low.x, high.y),
        ];
        if radii.min_element() <= 0.0 {
            let outline = Outline::polygon(&corners);
            return Ok(Shape::Contours(vec![SubPath::closed(outline)]));
        }
        // Along x, then towards greater y, as in the standard.
        let along = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
        let mut outline = Outline::from(low + radii * DVec2::X);
        for k in 0..4 {
            let (corner, come, go) = (corners[(k + 1) % 4], along[k], along[(k + 1) % 4]);
            let from = corner - radii * come;
            if outline.end() != from {
                outline.push(Side::Line, from);
            }
            let end = corner + radii * go;
            let side = if radii.x == radii.y {
                Side::Arc { bulge: QUARTER }
            } else {
                Side::Ellipse {
                    center: corner + radii * (go - come),
                    axes: [-radii * go, radii * come],
                    from: 0.0,
                    sweep: FRAC_PI_2,
                }
            };
            outline.push(side, end);
        }
        Ok(Shape::Contours(vec![SubPath::closed(outline)]))
    }

    fn polygon(&self, node: Node<'_, '_>, is_open: bool) -> Result<Shape, Error> {
        let text = node.attribute("points").unwrap_or("");
        let numbers = NumberListParser::from(text).collect::<Result<Vec<f64>, _>>();
        let numbers = numbers.map_err(|e| self.fault(node, &format!("its points: {e}")))?;
        if !numbers.len().is_multiple_of(2) {
            return Err(self.fault(node, "its points: the last one has no y"));
        }
        let points = numbers
            .chunks_exact(2)
            .map(|pair| DVec2::new(pair[0], pair[1]));
        let points: Vec<DVec2> = points.collect();
        if points.len() < 2 {
            return Ok(Shape::Nothing);
        }
        let mut outline = Outline::polygon(&points);
        if is_open {
            outline.sides.pop();
        }
        Ok(Shape::Contours(vec![SubPath::of(outline)]))
    }
}
