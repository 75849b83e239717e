#![no_main]
//! 3MF.

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(mesh) = io::threemf::read_3mf(data) {
        assert_eq!(mesh.check().out_of_range_triangles, 0);
    }
});
