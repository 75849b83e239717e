//! The tour's pictures, which show every mode, against those kept in `docs/`,
//! which the crate's page shows.
//!
//! STEREOTOMY_BLESS=1 draws them anew, to be looked at before they are kept.

#[path = "../examples/tour/pictures.rs"]
mod pictures;

use std::path::{Path, PathBuf};

use raster::Image;

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("docs")
        .join(name)
}

/// How many times as large as it could be, a picture is on the page.
const SCALE: u32 = 2;

/// Keeps the pictures.
fn bless(pictures: &[(&str, Image)]) {
    for (name, image) in pictures {
        image.save(path(name).with_extension("png")).unwrap();
    }
}

#[test]
fn pictures_are_as_they_were() {
    let pictures = pictures::all(SCALE).unwrap();
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
