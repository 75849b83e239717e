#![no_main]
//! OBJ, and its materials.

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(mesh) = io::obj::read_obj(data, |_| Some(data.to_vec())) {
        assert_eq!(mesh.check().out_of_range_triangles, 0);
    }
});
