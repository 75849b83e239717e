//! What is shown as a file.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use csg::BoundaryOptions;
use io::step::{StepOptions, write_step};
use io::{gltf, obj, off, ply, stl, threemf};

use crate::shown::Shown;

/// The formats of [`Shown::export`] by their extensions.
pub const FORMATS: [&str; 9] = [
    "step", "glb", "gltf", "3mf", "stl", "obj", "ply", "off", "csg",
];

impl Shown {
    /// The file of a format: the solid itself as STEP or `.csg`, the mesh that is shown
    /// otherwise. glTF holds its data itself, OBJ has no materials.
    ///
    /// # Errors
    /// For people: no such format, or a model that the format cannot hold.
    pub fn export(&self, format: &str) -> Result<Vec<u8>, String> {
        let mut out = Vec::new();
        let no_solid = || format!("a mesh cannot be a .{format} file, which holds solids");
        let mesh = &self.mesh;
        match format {
            "step" => {
                let program = self.program.as_ref().ok_or_else(no_solid)?;
                let brep = program.boundary(&BoundaryOptions::new().cut_at_seams());
                let brep = brep.map_err(|error| error.to_string())?;
                let options = StepOptions::default().name(&self.name).unit(self.unit);
                write_step(&brep, &options, &mut out).map_err(|error| error.to_string())?;
                return Ok(out);
            }
            "csg" => {
                let solid = self.solid.as_ref().ok_or_else(no_solid)?;
                let text = io::scene::write(solid).map_err(|error| error.to_string())?;
                return Ok(text.into_bytes());
            }
            "glb" => gltf::write_glb(mesh, &mut out),
            "gltf" => {
                let mut data = Vec::new();
                gltf::write_gltf(mesh, "", &mut out, &mut data).and_then(|()| {
                    let data = STANDARD.encode(&data);
                    let data = format!("data:application/octet-stream;base64,{data}");
                    out.clear();
                    gltf::write_gltf(mesh, &data, &mut out, &mut std::io::sink())
                })
            }
            "obj" => obj::write_obj(mesh, None, &mut out),
            "stl" => stl::write_stl(mesh, &mut out),
            "ply" => ply::write_ply(mesh, &mut out),
            "off" => off::write_off(mesh, &mut out),
            "3mf" => threemf::write_3mf(mesh, &mut out),
            _ => {
                let known = FORMATS.join(", .");
                return Err(format!("no format .{format}: there are .{known}"));
            }
        }
        .map_err(|error| error.to_string())?;
        Ok(out)
    }
}
