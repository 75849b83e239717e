//! The tour's pictures, which show every mode, against those kept in `docs/`,
//! which the crate's page shows.
//!
//! STEREOTOMY_BLESS=1 draws them anew, to be looked at before they are kept.

mod common;
#[path = "../examples/tour/pictures.rs"]
mod pictures;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use raster::Image;

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .join(name)
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let word =
            chunk.iter().fold(0u32, |word, b| word << 8 | u32::from(*b)) << (8 * (3 - chunk.len()));
        for k in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * k)) as usize & 63];
            text.push(if k <= chunk.len() {
                char::from(digit)
            } else {
                '='
            });
        }
    }
    text
}

/// Keeps the pictures, and for the crate's page as link definitions.
fn bless(pictures: &[(&str, Image)]) {
    let mut links = String::new();
    for (name, image) in pictures {
        let file = image.to_png().unwrap();
        std::fs::write(path(name).with_extension("png"), &file).unwrap();
        let _ = writeln!(links, "[{name}]: data:image/png;base64,{}", base64(&file));
    }
    std::fs::write(path("pictures.md"), links).unwrap();
}

#[test]
fn pictures_are_as_they_were() {
    let pictures = pictures::all(1).unwrap();
    if std::env::var_os("STEREOTOMY_BLESS").is_some() {
        bless(&pictures);
    }
    for (name, image) in &pictures {
        let file = std::fs::File::open(path(name).with_extension("png")).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(file))
            .read_info()
            .unwrap();
        let mut kept = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut kept).unwrap();
        let drawn = image.pixels.as_flattened();
        assert_eq!(drawn.len(), kept.len(), "{name}");
        // The standard library's powers may differ in the last bit from one
        // platform to another.
        let worst = drawn.iter().zip(&kept).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(worst <= Some(1), "{name} differs by {worst:?} of 255");
    }
}
