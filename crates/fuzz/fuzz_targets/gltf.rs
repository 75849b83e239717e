#![no_main]
//! glTF, its data being the document itself.

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(mesh) = io::gltf::read_gltf(data, |_| Ok(data.to_vec())) {
        assert_eq!(mesh.check().out_of_range_triangles, 0);
    }
});
