//! Mesa's llvmpipe, driven by the Python script that the raster tests use.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use glam::DVec3;
use raster::{Material, RenderOptions, View};

use crate::meshes::Indexed;

/// The times of some frames.
#[derive(Clone, Debug)]
pub struct Frames {
    /// Each frame, from clearing to having finished.
    pub times: Vec<Duration>,
    /// Processor time of a frame, in the mean.
    pub processor: Duration,
}

/// Draws `frames` frames of a mesh under ambient light 0.1 and light 0.9 from `towards`, with 0 or 4 samples
/// a pixel. `python` has moderngl and numpy; `LP_NUM_THREADS` in the
/// environment is the number of llvmpipe's threads.
///
/// # Errors
/// What went wrong, as text.
#[allow(clippy::too_many_arguments, reason = "one call in one benchmark")]
pub fn draw(
    python: &str,
    mesh: &Indexed,
    view: &View,
    (width, height): (u32, u32),
    towards: DVec3,
    samples: u32,
    frames: u32,
) -> Result<Frames, String> {
    let folder = std::env::temp_dir().join(format!("llvmpipe-{}", std::process::id()));
    let text = |error: std::io::Error| error.to_string();
    std::fs::create_dir_all(&folder).map_err(text)?;
    let floats = mesh
        .vertices
        .iter()
        .flatten()
        .flat_map(glam::Vec3::to_array);
    let vertices: Vec<u8> = floats.flat_map(f32::to_le_bytes).collect();
    let indices: Vec<u8> = mesh.indices.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(folder.join("vertices.bin"), vertices).map_err(text)?;
    std::fs::write(folder.join("indices.bin"), indices).map_err(text)?;
    let material = Material::of_color(RenderOptions::default().default_color);
    let list = |values: &[f64]| {
        let mut list = String::from("[");
        for (k, v) in values.iter().enumerate() {
            let _ = write!(list, "{}{v}", if k > 0 { "," } else { "" });
        }
        list + "]"
    };
    let job = format!(
        "{{\"width\":{width},\"height\":{height},\"samples\":{samples},\"world_to_clip\":{},\
         \"viewer\":{},\"towards\":{},\"ambient\":0.1,\"intensity\":0.9,\"diffuse\":{},\
         \"specular\":{},\"shininess\":{}}}",
        list(&view.world_to_clip().to_cols_array()),
        list(&view.centre_of_projection().to_array()),
        list(&towards.normalize().to_array()),
        list(&material.diffuse.as_dvec3().to_array()),
        list(&material.specular.as_dvec3().to_array()),
        material.shininess,
    );
    std::fs::write(folder.join("job.json"), job).map_err(text)?;
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../raster/tests/mesa/llvmpipe.py");
    let output = Command::new(python)
        .arg(script)
        .arg(&folder)
        .arg(frames.to_string())
        .output()
        .map_err(text)?;
    let _ = std::fs::remove_dir_all(&folder);
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    // {"renderer": "llvmpipe ...", "times": [0.1, 0.2], "cpu": 0.3}
    let answer = String::from_utf8_lossy(&output.stdout).into_owned();
    let between = |from: &str, to: char| {
        let rest = answer.split_once(from)?.1;
        Some(rest.split_once(to)?.0.trim())
    };
    let seconds = |v: &str| v.trim().parse().ok().map(Duration::from_secs_f64);
    let times = between("\"times\": [", ']')
        .map(|list| list.split(',').filter_map(seconds).collect())
        .ok_or_else(|| answer.clone())?;
    let processor = between("\"cpu\":", '}')
        .and_then(seconds)
        .unwrap_or_default();
    Ok(Frames {
        times,
        processor: processor / frames.max(1),
    })
}
