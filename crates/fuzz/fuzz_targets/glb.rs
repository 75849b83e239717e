#![no_main]
//! GLB.

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(mesh) = io::gltf::read_glb(data) {
        assert_eq!(mesh.check().out_of_range_triangles, 0);
    }
});
