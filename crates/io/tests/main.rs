//! All integration tests of the crate, as one program: many would be linked many times.

mod atomic;
mod common;
mod damaged_files;
mod drawings;
mod dxf_files;
#[path = "../../../tests/every_file.rs"]
mod every_file;
mod flat_files;
mod gltf;
mod gltf_validator;
mod instances;
mod obj;
mod objects;
mod other_formats;
mod parts;
#[path = "../../../tests/manifold3d/python.rs"]
mod python;
mod scene_files;
mod scene_read;
mod scene_shapes;
mod scene_text;
mod scene_write;
mod shards;
mod step_written;
mod svg_files;
mod threemf;
mod untrusted_files;

#[test]
fn every_file_is_a_module() {
    every_file::is_a_module(env!("CARGO_MANIFEST_DIR"), include_str!("main.rs"));
}
