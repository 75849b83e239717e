//! Writing 3MF.
//!
//! Bodies become objects, which must be closed by themselves: one object for those whose faces
//! have the same names in common. Names around these become objects that have them as
//! components. Colours are kept for each triangle.

use std::io::{self, Write};

use csg::{LengthUnit, Mesh};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::parts::{DEFAULT_COLOR, Group, Part, Parts, hex};
use crate::rows::{push_f64, push_index, write_rows};
use crate::tree::tree;
use crate::{Error, MeshFormat};

const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/><Default Extension="config" ContentType="text/xml"/></Types>
"#;
const RELATIONSHIPS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"#;

/// Meshes of so many triangles are compressed as fast as can be.
const MANY: usize = 500_000;

/// Writes a 3MF file, with the mesh's unit and the colours of its triangles
/// (as base materials), and a named object for each part; names of faces within them, normals and
/// surfaces are lost.
///
/// `PrusaSlicer` knows no base materials: where parts differ in colour the file tells it, in an entry
/// of its own, to print each colour with another extruder, numbered as colours appear among the
/// parts. (A body of several colours goes by the one that [`super::read_3mf`] gives its object.)
/// Version 2.5.0 was seen to take names, unit and extruders, and to print all with one where a
/// printer has no more; it lowers each object onto its bed, so what stands above others comes down.
///
/// # Errors
/// An empty or invalid mesh; failed writing.
pub fn write_3mf(mesh: &Mesh, out: &mut impl Write) -> Result<(), Error> {
    let parts = Parts::of(mesh, MeshFormat::ThreeMf)?;
    let mut zip = ZipWriter::new_stream(FailOnce { out, failed: false });
    // Small files are for sending, large ones for being written at all.
    let level = if mesh.triangles.len() < MANY { 9 } else { 1 };
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(level))
        .large_file(mesh.triangles.len() > 10_000_000);
    for (name, content) in [
        ("[Content_Types].xml", CONTENT_TYPES),
        ("_rels/.rels", RELATIONSHIPS),
    ] {
        zip.start_file(name, options).map_err(io::Error::from)?;
        zip.write_all(content.as_bytes())?;
    }
    zip.start_file("3D/3dmodel.model", options)
        .map_err(io::Error::from)?;
    write_model(mesh, &parts, &mut zip)?;
    if let Some(extruders) = extruders(&parts) {
        zip.start_file(FOR_PRUSA, options)
            .map_err(io::Error::from)?;
        write_for_prusa(&parts, &extruders, &mut zip)?;
    }
    zip.finish().map_err(io::Error::from)?;
    Ok(())
}

/// Where `PrusaSlicer` looks for what it knows of objects.
const FOR_PRUSA: &str = "Metadata/Slic3r_PE_model.config";

/// The extruder of each part, from 1; none if one is enough.
fn extruders(parts: &Parts<'_>) -> Option<Vec<usize>> {
    let mut colors: Vec<usize> = Vec::new();
    let extruders = parts.parts.iter().map(|part| {
        let color = color_of(part);
        let known = colors.iter().position(|&known| known == color);
        1 + known.unwrap_or_else(|| {
            colors.push(color);
            colors.len() - 1
        })
    });
    let extruders: Vec<usize> = extruders.collect();
    (colors.len() > 1).then_some(extruders)
}

/// The colour that stands for a part.
fn color_of(part: &Part<'_>) -> usize {
    part.groups.first().map_or(0, |group| group.color)
}

fn write_for_prusa(parts: &Parts<'_>, extruders: &[usize], out: &mut impl Write) -> io::Result<()> {
    out.write_all(b"<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<config>\n")?;
    for (index, (part, extruder)) in parts.parts.iter().zip(extruders).enumerate() {
        let triangles = part.groups.iter().map(|group| group.triangles.len());
        let last = triangles.sum::<usize>().saturating_sub(1);
        let name = |of: &str| {
            let name = part.names.last().map(|name| escaped(name));
            name.map_or_else(String::new, |name| {
                format!("<metadata type=\"{of}\" key=\"name\" value=\"{name}\"/>")
            })
        };
        writeln!(
            out,
            "<object id=\"{}\">{}<metadata type=\"object\" key=\"extruder\" value=\"{extruder}\"/>\
             <volume firstid=\"0\" lastid=\"{last}\">{}\
             <metadata type=\"volume\" key=\"volume_type\" value=\"ModelPart\"/></volume></object>",
            FIRST + index,
            name("object"),
            name("volume"),
        )?;
    }
    out.write_all(b"</config>\n")
}

/// A stream that fails once and then takes everything: an archive that is
/// dropped unfinished tries to finish itself, and would print that it cannot.
struct FailOnce<W> {
    out: W,
    failed: bool,
}

impl<W: Write> Write for FailOnce<W> {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        if self.failed {
            return Ok(data.len());
        }
        let written = self.out.write(data);
        self.failed = written
            .as_ref()
            .is_err_and(|error| error.kind() != io::ErrorKind::Interrupted);
        written
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.failed {
            return Ok(());
        }
        self.out.flush()
    }
}

fn write_model(mesh: &Mesh, parts: &Parts<'_>, out: &mut impl Write) -> io::Result<()> {
    write!(
        out,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <model unit=\"{}\" xml:lang=\"en\" \
         xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n\
         <metadata name=\"Application\">stereotomy</metadata>\n<resources>\n",
        match mesh.unit {
            LengthUnit::Micrometre => "micron",
            LengthUnit::Millimetre => "millimeter",
            LengthUnit::Centimetre => "centimeter",
            LengthUnit::Metre => "meter",
            LengthUnit::Inch => "inch",
            LengthUnit::Foot => "foot",
        }
    )?;
    let colored = parts.has_colors();
    if colored {
        out.write_all(b"<basematerials id=\"1\">")?;
        for (index, color) in parts.colors.iter().enumerate() {
            write!(
                out,
                "<base name=\"{}\" displaycolor=\"{}\"/>",
                parts.color_name(index),
                hex(color.unwrap_or(DEFAULT_COLOR))
            )?;
        }
        out.write_all(b"</basematerials>\n")?;
    }
    for (index, part) in parts.parts.iter().enumerate() {
        let name = attribute(part.names.last());
        write!(out, "<object id=\"{}\" type=\"model\"{name}", FIRST + index)?;
        if colored {
            write!(out, " pid=\"1\" pindex=\"{}\"", color_of(part))?;
        }
        out.write_all(b">")?;
        if parts.parts.len() == 1 {
            write_mesh(mesh, &part.groups, colored, out)?;
        } else {
            let (alone, groups) = alone(mesh, part);
            write_mesh(&alone, &groups, colored, out)?;
        }
        out.write_all(b"</object>\n")?;
    }
    let built = write_components(parts, out)?;
    out.write_all(b"</resources>\n<build>")?;
    for id in built {
        write!(out, "<item objectid=\"{id}\"/>")?;
    }
    out.write_all(b"</build>\n</model>\n")
}

/// The number of the first part's object; the others' follow it.
const FIRST: usize = 2;

/// An object for each name around other parts. Returns the numbers of the objects that are in no
/// other.
fn write_components(parts: &Parts<'_>, out: &mut impl Write) -> io::Result<Vec<usize>> {
    let tree = tree(parts.parts.iter().map(|part| &part.names[..]));
    let mut objects = vec![0; tree.len()];
    let mut next = FIRST + parts.parts.len();
    // What is within others comes after them there, and before them here.
    for (index, branch) in tree.iter().enumerate().skip(1).rev() {
        let own = branch.part.map(|part| FIRST + part);
        objects[index] = match own.filter(|_| branch.inner.is_empty()) {
            Some(own) => own,
            None => {
                let name = attribute(Some(&branch.name));
                write!(
                    out,
                    "<object id=\"{next}\" type=\"model\"{name}><components>"
                )?;
                let inner = branch.inner.iter().map(|&inner| objects[inner]);
                for id in own.into_iter().chain(inner) {
                    write!(out, "<component objectid=\"{id}\"/>")?;
                }
                out.write_all(b"</components></object>\n")?;
                next += 1;
                next - 1
            }
        };
    }
    let own = tree[0].part.map(|part| FIRST + part);
    let inner = tree[0].inner.iter().map(|&inner| objects[inner]);
    Ok(own.into_iter().chain(inner).collect())
}

/// The mesh of a part alone, and its groups.
fn alone<'a>(mesh: &Mesh, part: &Part<'a>) -> (Mesh, Vec<Group<'a>>) {
    let mut number = vec![u32::MAX; mesh.positions.len()];
    let mut alone = Mesh::default();
    let mut groups = Vec::new();
    for group in &part.groups {
        let first = alone.triangles.len() as u32;
        for &triangle in &group.triangles {
            let corners = mesh.triangles[triangle as usize].map(|vertex| {
                let number = &mut number[vertex as usize];
                if *number == u32::MAX {
                    *number = alone.positions.len() as u32;
                    alone.positions.push(mesh.positions[vertex as usize]);
                }
                *number
            });
            alone.triangles.push(corners);
        }
        groups.push(Group {
            names: group.names.clone(),
            color: group.color,
            triangles: (first..alone.triangles.len() as u32).collect(),
        });
    }
    (alone, groups)
}

/// A name as an attribute; nothing for none.
fn attribute(name: Option<&&str>) -> String {
    name.map_or_else(String::new, |name| format!(" name=\"{}\"", escaped(name)))
}

/// A name within an attribute. XML has no place for control characters.
fn escaped(name: &str) -> String {
    let clean = |c: char| if c.is_control() { '_' } else { c };
    let name: String = name.chars().map(clean).collect();
    quick_xml::escape::escape(&name).into_owned()
}

fn write_mesh(
    mesh: &Mesh,
    groups: &[Group<'_>],
    colored: bool,
    out: &mut impl Write,
) -> io::Result<()> {
    out.write_all(b"<mesh>\n<vertices>\n")?;
    write_rows(out, mesh.positions.len(), |row, text| {
        let place = mesh.positions[row];
        for (before, coordinate) in [
            (&b"<vertex x=\""[..], place.x),
            (b"\" y=\"", place.y),
            (b"\" z=\"", place.z),
        ] {
            text.extend_from_slice(before);
            push_f64(text, coordinate);
        }
        text.extend_from_slice(b"\"/>\n");
    })?;
    out.write_all(b"</vertices>\n<triangles>\n")?;
    let mut colors = vec![0u32; mesh.triangles.len()];
    for group in groups {
        for &triangle in &group.triangles {
            colors[triangle as usize] = group.color as u32;
        }
    }
    write_rows(out, mesh.triangles.len(), |row, text| {
        let names = [&b"<triangle v1=\""[..], b"\" v2=\"", b"\" v3=\""];
        for (before, vertex) in names.into_iter().zip(mesh.triangles[row]) {
            text.extend_from_slice(before);
            push_index(text, u64::from(vertex));
        }
        if colored {
            text.extend_from_slice(b"\" pid=\"1\" p1=\"");
            push_index(text, u64::from(colors[row]));
        }
        text.extend_from_slice(b"\"/>\n");
    })?;
    out.write_all(b"</triangles>\n</mesh>")
}
