//! `import` and `surface`: solids and flat shapes from files beside the scene.

use std::path::{Path, PathBuf};

use csg::Solid;
use glam::{DVec2, DVec3};

use super::build::{Builder, is_size};
use super::error::{Place, SceneError};
use super::parse::{NodeText, Value};
use super::pieces::Piece;
use super::relief::{self, Heights, Picture};
use super::values;
use crate::contents::{Contents, is_outside};
use crate::profile::{self, ProfileOptions};
use crate::{ReadOptions, read_mesh_file, read_profile_with, unit_ratio};

/// The most bytes of a height map: far more than a solid can be made of.
const MOST_BYTES: u64 = 1 << 20;

/// Of `import`.
const KEYS: [&str; 12] = [
    "file",
    "layer",
    "origin",
    "scale",
    "convexity",
    "$fn",
    "$fa",
    "$fs",
    "timestamp",
    "center",
    "dpi",
    "id",
];

impl Builder<'_> {
    pub(super) fn import(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let [file, ..] = self.arguments(node, &KEYS)?;
        let path = self.file(node, file)?;
        if profile::is_flat(&path) {
            return self.import_flat(node, &path);
        }
        let files = ReadOptions::default().any_folder(self.options.any_folder);
        let read = read_mesh_file(&path, &files).map_err(|e| self.fault(node, &e.to_string()))?;
        let name = path.display();
        for warning in &read.warnings {
            self.warn(node, format!("{name}: {warning}"));
        }
        let (own, unit) = (read.mesh.unit, self.options.unit);
        if read.has_unit && own != unit {
            let times = unit_ratio(own, unit);
            self.warn(
                node,
                format!(
                    "the lengths of {name} are converted from {} to {}: {times} times as many",
                    own.symbol(),
                    unit.symbol()
                ),
            );
        }
        let read = read.in_unit(unit);
        let count = read.mesh.triangles.len() as f64;
        self.facets(node, count, count)?;
        let fault = |builder: &Self, faults| SceneError::NotASolid {
            place: Place::of(builder.tree.text, node.offset),
            node: node.name.to_owned(),
            file: path.clone(),
            faults,
        };
        if self.options.repair {
            let (solid, repairs) = read.repaired().map_err(|faults| fault(self, faults))?;
            if !repairs.is_empty() {
                self.warn(node, format!("{name} was repaired: {repairs}"));
            }
            return self.made(node, solid);
        }
        let solid = match read.solid() {
            Err(faults) if faults.inside_out => {
                let problem = format!("the faces of {name} are inside out: they are turned");
                self.warn(node, problem);
                read.turned().solid()
            }
            other => other,
        };
        let solid = solid.map_err(|faults| fault(self, faults))?;
        self.made(node, solid)
    }

    /// A drawing, as OpenSCAD reads it but for arcs, which stay.
    fn import_flat(&mut self, node: &NodeText<'_>, path: &Path) -> Result<Piece, SceneError> {
        let values = self.arguments(node, &KEYS)?;
        let [_, layer, origin, scale, _, fn_, fa, fs, _, center, dpi, id] = values;
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        let mut options = ProfileOptions::default();
        for (key, value, to) in [
            ("layer", layer, &mut options.layer),
            ("id", id, &mut options.id),
        ] {
            *to = match value {
                None | Some(Value::Undefined) => None,
                Some(value) => match values::text(value) {
                    Some(text) => Some(text.to_owned()),
                    None => return Err(self.fault(node, &format!("`{key}` must be a text"))),
                },
            };
        }
        options.center = self.flag(node, "center", center)?;
        for (key, value, to) in [
            ("scale", scale, &mut options.scale),
            ("dpi", dpi, &mut options.dpi),
        ] {
            if value.is_some() {
                *to = self.number(node, key, value)?;
            }
            if !is_size(*to) {
                let problem = format!("`{key}` must be above 0 and finite");
                return Err(self.fault(node, &problem));
            }
        }
        if let Some(value) = origin {
            let point = values::array(value, values::number).map(DVec2::from_array);
            options.origin = point
                .filter(|point| point.is_finite())
                .ok_or_else(|| self.fault(node, "`origin` must be [x, y]"))?;
        }
        let is_svg = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("svg"));
        if is_svg && (options.scale != 1.0 || options.origin != DVec2::ZERO) {
            let problem = "`scale` and `origin` are for .dxf files alone, as in OpenSCAD";
            self.warn(node, problem.to_owned());
        }
        if self.is_faceted() || fineness.is_polygon() {
            options.fineness = Some(fineness);
        }
        options.tolerance = self.within();
        let read = read_profile_with(path, &options);
        let read = read.map_err(|e| self.fault(node, &e.to_string()))?;
        if let Some(strays) = read.strays {
            self.strayed(strays);
        }
        for warning in read.warnings {
            self.warn(node, format!("{}: {warning}", path.display()));
        }
        let sides = read.sides as f64;
        self.facets(node, sides, sides)?;
        self.flat(node, read.profile)
    }

    pub(super) fn surface(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let keys = ["file", "center", "invert", "convexity", "timestamp"];
        let [file, center, invert, ..] = self.arguments(node, &keys)?;
        let center = self.flag(node, "center", center)?;
        let invert = self.flag(node, "invert", invert)?;
        let path = self.file(node, file)?;
        let fault = |problem: &str| self.fault(node, &format!("{}: {problem}", path.display()));
        let about = std::fs::metadata(&path).map_err(|e| fault(&e.to_string()))?;
        if about.len() > MOST_BYTES {
            return Err(fault("it is too large to be made into a solid"));
        }
        let data = Contents::of(&path).map_err(|e| fault(&e.to_string()))?;
        let picture = Picture::of(&data).map_err(|problem| fault(&problem))?;
        let heights = match picture {
            Some(picture) => picture.heights(invert),
            None => Heights::of_text(&data),
        };
        let heights = heights.map_err(|problem| fault(&problem))?;
        let [columns, rows] = heights.size();
        if rows < 2 || columns < 2 {
            return Ok(self.nothing(node, "it has fewer than two rows or columns"));
        }
        let facets = relief::facets([columns, rows]);
        self.facets(node, facets, facets)?;
        let (points, faces) = heights.relief();
        let offset = if center {
            -0.5 * DVec3::new((columns - 1) as f64, (rows - 1) as f64, 0.0)
        } else {
            DVec3::ZERO
        };
        let points = points.into_iter().map(|point| point + offset);
        self.made(node, Solid::polyhedron(points, faces))
    }

    /// The file that a node names, beside or below the scene unless others are
    /// allowed.
    fn file(&self, node: &NodeText<'_>, file: Option<&Value>) -> Result<PathBuf, SceneError> {
        let Some(file) = file.and_then(values::text).filter(|file| !file.is_empty()) else {
            return Err(self.fault(node, "it needs the name of a `file`"));
        };
        let Some(folder) = &self.options.folder else {
            let problem = format!(
                "`{file}` is looked for beside the scene, but this scene is not read from a file"
            );
            return Err(self.fault(node, &problem));
        };
        let refused = |e: std::io::Error| self.fault(node, &format!("{file}: {e}"));
        // (A scene in the current folder has an empty one.)
        let folder = PathBuf::from(".").join(folder);
        let folder = folder.canonicalize().map_err(refused)?;
        let path = folder.join(file);
        if !self.options.any_folder && is_outside(&path, &folder) {
            return Err(SceneError::OtherFolder {
                place: Place::of(self.tree.text, node.offset),
                node: node.name.to_owned(),
                file: file.to_owned(),
            });
        }
        path.canonicalize().map_err(refused)
    }
}
