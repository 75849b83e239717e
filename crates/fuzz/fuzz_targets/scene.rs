#![no_main]
//! Scenes (.csg), read.

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let _ = io::scene::read_bytes(data, &io::scene::ReadOptions::default());
});
