//! Several pictures at once: sheets of views, turntables and their files.

use crate::common;
use glam::DVec3;
use raster::{
    Image, Lens, Prepared, ProjectionAngle, RasterError, RenderOptions, StandardView,
    contact_sheet, turntable, turntable_camera, write_apng, write_gif,
};

#[test]
fn turntables_go_once_round_and_read_back() {
    let mesh = common::cuboid(DVec3::new(-1.0, -0.5, 0.0), DVec3::new(1.0, 0.5, 0.6));
    let scene = Prepared::new(&mesh);
    let options = RenderOptions::default();
    let camera = turntable_camera(&mesh, StandardView::Front, Lens::DEFAULT, 1.0).unwrap();
    let frames = turntable(&scene, &camera, 8, 64, 64, &options).unwrap();
    for (k, frame) in frames.iter().enumerate() {
        // Whole in every frame: nothing touches the border.
        let border = (0..64).all(|i| {
            [(i, 0), (i, 63), (0, i), (63, i)]
                .iter()
                .all(|&(x, y)| frame.get(x, y).unwrap()[3] == 0)
        });
        assert!(border, "frame {k}");
    }
    // A box looks the same from opposite sides, as far as coverage goes.
    let covered = |frame: &Image| -> Vec<bool> { frame.pixels.iter().map(|p| p[3] > 0).collect() };
    for k in 0..4 {
        let differing = covered(&frames[k])
            .iter()
            .zip(covered(&frames[k + 4]))
            .filter(|(a, b)| **a != *b)
            .count();
        assert!(differing < 20, "frame {k}: {differing}");
    }
    assert_ne!(covered(&frames[0]), covered(&frames[1]));
    let mut file = Vec::new();
    write_apng(&frames, 10, &mut file).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(file))
        .read_info()
        .unwrap();
    assert_eq!(reader.info().animation_control().unwrap().num_frames, 8);
    for frame in &frames {
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        assert_eq!(bytes, frame.pixels.as_flattened());
    }
    assert!(write_apng(&[], 10, Vec::new()).is_err());
    assert!(
        write_apng(
            &[frames[0].clone(), Image::new(3, 3, [0; 4])],
            10,
            Vec::new()
        )
        .is_err()
    );
}

/// Top over front, front beside right, all to one scale.
#[test]
fn contact_sheets_line_up() {
    let mesh = common::cuboid(DVec3::ZERO, DVec3::new(2.0, 1.0, 0.5));
    let scene = Prepared::new(&mesh);
    let sheet = contact_sheet(
        &mesh,
        &scene,
        Lens::DEFAULT,
        ProjectionAngle::Third,
        400,
        300,
        &RenderOptions::default(),
    )
    .unwrap();
    let extent = |left: u32, top: u32| {
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        // (Above the view's name.)
        for y in top..top + 136 {
            for x in left..left + 200 {
                if sheet.get(x, y).unwrap()[3] > 0 {
                    low = [low[0].min(x), low[1].min(y)];
                    high = [high[0].max(x + 1), high[1].max(y + 1)];
                }
            }
        }
        [high[0] - low[0], high[1] - low[1]]
    };
    let (top, front, right) = (extent(0, 0), extent(0, 150), extent(200, 150));
    let scale = f64::from(top[0]) / 2.0;
    for (size, expected) in [(top, [2.0, 1.0]), (front, [2.0, 0.5]), (right, [1.0, 0.5])] {
        for axis in 0..2 {
            assert!(
                (f64::from(size[axis]) - expected[axis] * scale).abs() <= 1.0,
                "{size:?}"
            );
        }
    }
}

#[test]
fn sheets_put_views_where_the_angle_says() {
    use StandardView::{Front, Iso, Left, Right, Top};
    assert_eq!(ProjectionAngle::Third.views(), [Top, Iso, Front, Right]);
    assert_eq!(ProjectionAngle::First.views(), [Front, Left, Top, Iso]);
}

#[test]
fn gifs_read_back() {
    let frames: Vec<Image> = [[255, 0, 0, 255], [0, 0, 255, 255], [0, 0, 0, 0]]
        .map(|color| Image::new(20, 10, color))
        .to_vec();
    let mut file = Vec::new();
    write_gif(&frames, 15, &mut file).unwrap();
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(&file[..]).unwrap();
    for frame in &frames {
        let found = decoder.read_next_frame().unwrap().unwrap();
        assert_eq!((found.width, found.height), (20, 10));
        assert_eq!(found.buffer[3], frame.pixels[0][3]);
        if frame.pixels[0][3] == 255 {
            assert_eq!(found.buffer[..3], frame.pixels[0][..3]);
        }
    }
    assert!(decoder.read_next_frame().unwrap().is_none());
    assert!(matches!(
        write_gif(&[], 15, Vec::new()),
        Err(RasterError::EmptyImage { .. })
    ));
}
