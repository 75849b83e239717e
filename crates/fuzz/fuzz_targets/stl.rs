#![no_main]
//! STL, binary and text.

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(mesh) = io::stl::read_stl(data) {
        assert_eq!(mesh.check().out_of_range_triangles, 0);
    }
});
