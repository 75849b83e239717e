//! Solids without children.

use csg::{Made, Node, NodeFault, PolyhedronFault, Solid};
use glam::DVec3;

use super::build::{Builder, is_size};
use super::error::SceneError;
use super::facets;
use super::parse::{Kind, NodeText, Value};
use super::pieces::Piece;
use super::values::{array, list, number, sizes};

impl Builder<'_> {
    pub(super) fn leaf(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        match node.kind {
            Kind::Cube => self.cube(node),
            Kind::Sphere => self.sphere(node),
            Kind::Polyhedron => self.polyhedron(node),
            Kind::Circle => self.circle(node),
            Kind::Square => self.square(node),
            Kind::Polygon => self.polygon(node),
            Kind::Text => self.lettering(node),
            Kind::Import => self.import(node),
            Kind::Surface => self.surface(node),
            _ => self.cylinder(node),
        }
    }

    fn polyhedron(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let keys = ["points", "faces", "triangles", "convexity"];
        let [points, faces, triangles, _] = self.arguments(node, &keys)?;
        let points = points.and_then(|value| list(value, |item| array(item, number)));
        let Some(points) = points else {
            return Err(self.fault(node, "it needs `points = [[x, y, z], ..]`"));
        };
        let index = |item: &Value| {
            let index = number(item)?;
            (0.0..u32::MAX.into())
                .contains(&index)
                .then_some(index as u32)
        };
        let faces = faces.or(triangles);
        let faces = faces.and_then(|value| list(value, |face| list(face, index)));
        let Some(mut faces) = faces else {
            return Err(self.fault(node, "it needs `faces = [[0, 1, 2], ..]`"));
        };
        self.facets(node, faces.len() as f64, faces.len() as f64)?;
        // Clockwise seen from outside.
        for face in &mut faces {
            face.reverse();
        }
        if points.is_empty() || faces.is_empty() {
            return Ok(self.nothing(node, "it has no faces"));
        }
        let points: Vec<DVec3> = points.into_iter().map(DVec3::from_array).collect();
        let mut solid = Solid::polyhedron(points.iter().copied(), &faces);
        if matches!(polyhedron_fault(&solid), Some(PolyhedronFault::Open { .. })) {
            solid = Solid::polyhedron(points.iter().copied().map(on_grid), &faces);
        }
        if matches!(polyhedron_fault(&solid), Some(PolyhedronFault::InsideOut)) {
            self.warn(node, "its faces are inside out: they are turned".to_owned());
            for face in &mut faces {
                face.reverse();
            }
            solid = Solid::polyhedron(points, faces);
        }
        self.made(node, solid)
    }

    fn cube(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let [size, center] = self.arguments(node, &["size", "center"])?;
        let Some(size) = size.and_then(sizes) else {
            return Err(self.fault(node, "it needs `size = [x, y, z]`"));
        };
        let center = self.flag(node, "center", center)?;
        if !size.iter().all(|&side| is_size(side)) {
            return Ok(self.empty(node, "a side"));
        }
        let size = DVec3::from_array(size);
        Ok(Piece::Solid(if center {
            Solid::cuboid(size)
        } else {
            Solid::cuboid_between(DVec3::ZERO, size)
        }))
    }

    fn sphere(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let [fn_, fa, fs, radius, diameter] =
            self.arguments(node, &["$fn", "$fa", "$fs", "r", "d"])?;
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        let radius = match self.radius(node, ["r", "d"], [radius, diameter])? {
            Some(radius) => radius,
            None => self.number(node, "r", None)?,
        };
        if !is_size(radius) {
            return Ok(self.empty(node, "the radius"));
        }
        if !(self.is_faceted() || fineness.is_polygon()) {
            return Ok(Piece::Solid(Solid::sphere(radius)));
        }
        let fragments = self.fragments(&fineness, radius);
        let facets = fragments * (0.5 * fragments).ceil();
        let fragments = self.facets(node, fragments, facets)?;
        let planes = facets::sphere(radius, fragments);
        Ok(Piece::Solid(Solid::convex_polyhedron(planes)))
    }

    fn cylinder(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let keys = [
            "$fn", "$fa", "$fs", "h", "r1", "r2", "center", "r", "d", "d1", "d2",
        ];
        let [fn_, fa, fs, height, r1, r2, center, r, d, d1, d2] = self.arguments(node, &keys)?;
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        let height = self.number(node, "h", height)?;
        let both = self.radius(node, ["r", "d"], [r, d])?;
        let end =
            |[r, d]: [&'static str; 2], given| match self.radius(node, [r, d], given)?.or(both) {
                Some(radius) => Ok(radius),
                None => self.number(node, r, None),
            };
        let bottom = end(["r1", "d1"], [r1, d1])?;
        let top = end(["r2", "d2"], [r2, d2])?;
        let center = self.flag(node, "center", center)?;
        if !is_size(height) {
            return Ok(self.empty(node, "the height"));
        }
        let widest = bottom.max(top);
        if !(is_size(widest) && bottom >= 0.0 && top >= 0.0) {
            return Ok(self.empty(node, "a radius"));
        }
        let z = if center {
            -0.5 * height..0.5 * height
        } else {
            0.0..height
        };
        if self.is_faceted() || fineness.is_polygon() {
            let fragments = self.fragments(&fineness, widest);
            let fragments = self.facets(node, fragments, fragments)?;
            let solid = facets::cylinder(bottom, top, z, fragments);
            return Ok(Piece::Solid(solid));
        }
        Ok(Piece::Solid(if bottom == top {
            Solid::cylinder(bottom, z)
        } else {
            Solid::frustum(bottom, top, z)
        }))
    }
}

/// What is wrong with a polyhedron's faces.
fn polyhedron_fault(solid: &Solid) -> Option<&PolyhedronFault> {
    match solid.node() {
        Node::Made(Made {
            solid: Err(NodeFault::Polyhedron(fault)),
            ..
        }) => Some(fault),
        _ => None,
    }
}

/// The nearest point of the grid on which OpenSCAD's vertices are one.
fn on_grid(point: DVec3) -> DVec3 {
    const PER_UNIT: f64 = (1 << 20) as f64;
    (point * PER_UNIT).round() / PER_UNIT
}
