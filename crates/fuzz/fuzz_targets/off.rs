#![no_main]
//! OFF.

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(mesh) = io::off::read_off(data) {
        assert_eq!(mesh.check().out_of_range_triangles, 0);
    }
});
