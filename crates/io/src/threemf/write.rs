//! Writing 3MF.
//!
//! The mesh becomes one object, because each object must be closed by itself,
//! which the parts of one name are not; colours are kept for each triangle.

use std::io::{self, Write};

use csg::{LengthUnit, Mesh};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::parts::{DEFAULT_COLOR, Parts, hex};
use crate::rows::{push_f64, push_index, write_rows};
use crate::{Error, MeshFormat};

const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
"#;
const RELATIONSHIPS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
"#;

/// Meshes of so many triangles are compressed as fast as can be.
const MANY: usize = 500_000;

/// Writes a 3MF file, with the mesh's unit and the colours of its triangles
/// (as base materials); names, normals and surfaces are lost.
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
    zip.finish().map_err(io::Error::from)?;
    Ok(())
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
        out.write_all(
            b"</basematerials>\n<object id=\"2\" type=\"model\" pid=\"1\" pindex=\"0\">",
        )?;
    } else {
        out.write_all(b"<object id=\"2\" type=\"model\">")?;
    }
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
    for part in &parts.parts {
        for &triangle in &part.triangles {
            colors[triangle as usize] = part.color as u32;
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
    out.write_all(
        b"</triangles>\n</mesh></object>\n</resources>\n\
          <build><item objectid=\"2\"/></build>\n</model>\n",
    )
}
