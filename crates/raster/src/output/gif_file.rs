//! Animated GIF.

use std::io::Write;

use crate::RasterError;
use crate::image::{Image, common_size};

/// Writes pictures of one size as an animated GIF that repeats for ever, each in
/// its own 256 colours. Pixels that are less than half opaque are transparent.
///
/// # Errors
/// [`RasterError::EmptyImage`] without frames or pixels, or if the frames
/// differ in size or are too large for the format; [`RasterError::Gif`] if the
/// writer fails.
pub fn write_gif(
    frames: &[Image],
    frames_per_second: u16,
    writer: impl Write,
) -> Result<(), RasterError> {
    let (width, height) = common_size(frames)?;
    let (Ok(w), Ok(h)) = (u16::try_from(width), u16::try_from(height)) else {
        return Err(RasterError::EmptyImage { width, height });
    };
    let mut encoder = gif::Encoder::new(writer, w, h, &[])?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    for frame in frames {
        let mut pixels = frame.pixels.clone();
        for pixel in &mut pixels {
            pixel[3] = if pixel[3] < 128 { 0 } else { 255 };
        }
        let mut encoded = gif::Frame::from_rgba_speed(w, h, pixels.as_flattened_mut(), 10);
        encoded.delay = 100 / frames_per_second.max(1);
        encoded.dispose = gif::DisposalMethod::Background;
        encoder.write_frame(&encoded)?;
    }
    Ok(())
}
