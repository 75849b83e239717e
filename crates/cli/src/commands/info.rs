//! `info`: what is in a file, without meshing or measuring.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use csg::{Node, Primitive, Program, Solid, SurfaceShape};
use io::MeshFile;
use serde::Serialize;

use super::account::Bounds;
use crate::failure::Failure;
use crate::input::{Input, Subject, Wanted};
use crate::mesher::Unit;
use crate::output::{self, is_stream};

/// Options of `info`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    #[command(flatten)]
    input: Input,
    /// Write it as JSON; `-` writes to standard output, in place of the text
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What is said of a file.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "lowercase")]
pub(super) enum Info {
    /// A scene or model.
    Solid {
        /// Bytes of the file; null on standard input.
        bytes: Option<u64>,
        /// Nodes of the tree by what they are.
        nodes: BTreeMap<&'static str, usize>,
        /// Primitives that the program has.
        primitives: usize,
        /// Distinct surfaces by what they are.
        surfaces: BTreeMap<&'static str, usize>,
        names: Vec<String>,
        /// Within which the solid lies, which may be smaller; null if there is nothing, or no
        /// end.
        within: Option<Bounds>,
    },
    /// A mesh.
    Mesh {
        /// Bytes of the file.
        bytes: Option<u64>,
        vertices: usize,
        triangles: usize,
        /// Meshes in their places (3MF, glTF) or lines `o` (OBJ); one of other formats.
        objects: usize,
        names: Vec<String>,
        /// Different colours.
        colors: usize,
        normals: bool,
        bounds: Option<Bounds>,
        unit: String,
    },
}

pub(crate) fn run(options: &Options) -> Result<(), Failure> {
    let path = options.input.path();
    let info = match options.input.read(Wanted::solid(Unit::Mm))? {
        Subject::Solid(solid, _) => of_solid(path, &solid)?,
        Subject::Mesh(file) => of_mesh(path, &file),
    };
    if let Some(path) = &options.json {
        output::write_json(path, &info)?;
        if is_stream(path) {
            return Ok(());
        }
    }
    output::print(info.to_string().as_bytes())
}

fn bytes(path: &Path) -> Option<u64> {
    std::fs::metadata(path).ok().map(|file| file.len())
}

fn of_solid(path: &Path, solid: &Solid) -> Result<Info, Failure> {
    let program = Program::lower(solid)?;
    let mut nodes = BTreeMap::new();
    count(solid, &mut nodes);
    let mut surfaces: BTreeMap<&str, usize> = BTreeMap::new();
    for surface in program.surfaces() {
        *surfaces.entry(kind(&surface.shape())).or_default() += 1;
    }
    let names = program
        .origins()
        .iter()
        .filter_map(|origin| origin.name.as_deref());
    Ok(Info::Solid {
        bytes: bytes(path),
        nodes,
        primitives: program.origins().len(),
        surfaces,
        names: distinct(names),
        within: program
            .bounds()
            .ok()
            .flatten()
            .map(|bounds| Bounds::new(bounds.min, bounds.max)),
    })
}

fn of_mesh(path: &Path, file: &MeshFile) -> Info {
    let mesh = &file.mesh;
    let colors = mesh.surfaces.iter().filter_map(|surface| surface.color);
    let mut colors: Vec<[u32; 4]> = colors
        .map(|color| {
            let [r, g, b] = color.rgb;
            [r, g, b, color.alpha].map(f32::to_bits)
        })
        .collect();
    colors.sort_unstable();
    colors.dedup();
    Info::Mesh {
        bytes: bytes(path),
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        objects: file.objects.len(),
        names: distinct(
            mesh.surfaces
                .iter()
                .filter_map(|surface| surface.name.as_deref()),
        ),
        colors: colors.len(),
        normals: !mesh.corner_normals.is_empty(),
        bounds: mesh.bounds().map(|(min, max)| Bounds::new(min, max)),
        unit: mesh.unit.symbol().to_owned(),
    }
}

/// Counts the nodes of a tree; what is there in several places is counted in each. (With a
/// stack of its own: trees may be deep.)
fn count(solid: &Solid, nodes: &mut BTreeMap<&'static str, usize>) {
    let mut waiting = vec![solid];
    while let Some(solid) = waiting.pop() {
        let node = solid.node();
        let kind = match node {
            Node::Primitive(Primitive::Empty) => "nothing",
            Node::Primitive(_) => "primitive",
            Node::Union(_) => "union",
            Node::Intersection(_) => "intersection",
            Node::Difference(_) => "difference",
            Node::Transform(..) => "transform",
            Node::Made(made) => made.function,
            Node::Named(..) => "name",
            Node::Colored(..) => "color",
            _ => "other",
        };
        *nodes.entry(kind).or_default() += 1;
        // What a function made of other nodes is one.
        if !matches!(node, Node::Made(_)) {
            waiting.extend(node.operands());
        }
    }
}

fn kind(shape: &SurfaceShape) -> &'static str {
    match shape {
        SurfaceShape::Plane { .. } => "plane",
        SurfaceShape::Sphere { .. } => "sphere",
        SurfaceShape::Cylinder { .. } => "cylinder",
        SurfaceShape::Cone { .. } => "cone",
        _ => "other quadric",
    }
}

fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut names: Vec<String> = names.map(str::to_owned).collect();
    names.sort();
    names.dedup();
    names
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counted = |counts: &BTreeMap<&str, usize>| {
            let counts = counts.iter().map(|(kind, count)| format!("{count} {kind}"));
            let counts: Vec<String> = counts.collect();
            match counts.is_empty() {
                true => "none".to_owned(),
                false => counts.join(", "),
            }
        };
        let named = |names: &[String]| match names {
            [] => "none".to_owned(),
            names if names.len() > 12 => {
                format!("{} and {} more", names[..12].join(", "), names.len() - 12)
            }
            names => names.join(", "),
        };
        match self {
            Self::Solid {
                bytes,
                nodes,
                primitives,
                surfaces,
                names,
                within,
            } => {
                writeln!(f, "kind        solid")?;
                if let Some(bytes) = bytes {
                    writeln!(f, "bytes       {bytes}")?;
                }
                writeln!(f, "nodes       {}", counted(nodes))?;
                writeln!(f, "primitives  {primitives}")?;
                writeln!(f, "surfaces    {}", counted(surfaces))?;
                writeln!(f, "names       {}", named(names))?;
                match within {
                    Some(bounds) => writeln!(f, "{bounds}"),
                    None => writeln!(f, "bounds      none: it is empty, or has no end"),
                }
            }
            Self::Mesh {
                bytes,
                vertices,
                triangles,
                objects,
                names,
                colors,
                normals,
                bounds,
                unit,
            } => {
                writeln!(f, "kind        mesh")?;
                if let Some(bytes) = bytes {
                    writeln!(f, "bytes       {bytes}")?;
                }
                writeln!(f, "vertices    {vertices}")?;
                writeln!(f, "triangles   {triangles}")?;
                writeln!(f, "objects     {objects}")?;
                writeln!(f, "names       {}", named(names))?;
                writeln!(f, "colors      {colors}")?;
                writeln!(f, "normals     {}", if *normals { "yes" } else { "no" })?;
                if let Some(bounds) = bounds {
                    writeln!(f, "{bounds}")?;
                }
                writeln!(f, "unit        {unit}")
            }
        }
    }
}
