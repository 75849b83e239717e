#![no_main]
//! PLY, binary and text.

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(mesh) = io::ply::read_ply(data) {
        assert_eq!(mesh.check().out_of_range_triangles, 0);
    }
});
