//! All integration tests of the crate, as one program: many would be linked many times.

mod balls;
mod draft;
#[path = "../../../tests/every_file.rs"]
mod every_file;
mod exact;

mod hulls_of_discs;
#[path = "import_order/main.rs"]
mod import_order;
mod measured;
mod mesh_check;
mod mesh_intersect;
mod mesh_measure;
mod mesh_sheets;
mod parabolas;
mod polyhedra;
mod profiles;
mod program;
mod quadrics;
mod queries;
#[path = "../src/random.rs"]
#[allow(dead_code, reason = "shared")]
mod random;
mod ready_made;
#[path = "regions/main.rs"]
mod regions;
mod sections;
mod shapes;
mod slabs;
#[path = "../../../tests/sweeps.rs"]
mod sweeps;
mod theory;

#[test]
fn every_file_is_a_module() {
    every_file::is_a_module(env!("CARGO_MANIFEST_DIR"), include_str!("main.rs"));
}
