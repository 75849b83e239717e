//! PNG encoding.

use std::io::Write;
use std::path::Path;

use crate::{Image, RasterError};

impl Image {
    /// Writes the picture as an sRGB PNG with an alpha channel, compressed
    /// for speed.
    ///
    /// # Errors
    /// [`RasterError::EmptyImage`] without pixels; [`RasterError::Png`] if
    /// the writer fails.
    pub fn write_png(&self, writer: impl Write) -> Result<(), RasterError> {
        if self.width == 0 || self.height == 0 {
            return Err(RasterError::EmptyImage {
                width: self.width,
                height: self.height,
            });
        }
        let mut encoder = png::Encoder::new(writer, self.width, self.height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(())
    }

    /// Writes the picture as a PNG file.
    ///
    /// # Errors
    /// As [`Image::write_png`]; [`RasterError::File`] if there can be no such
    /// file.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), RasterError> {
        let bytes = self.to_png()?;
        std::fs::write(path, bytes)?;
        Ok(())
    }

    /// The picture as the bytes of a PNG file (see [`Image::write_png`]).
    ///
    /// # Errors
    /// As [`Image::write_png`].
    pub fn to_png(&self) -> Result<Vec<u8>, RasterError> {
        let mut bytes = Vec::new();
        self.write_png(&mut bytes)?;
        Ok(bytes)
    }
}

/// Writes pictures of one size as an animated PNG that repeats for ever.
///
/// # Errors
/// [`RasterError::EmptyImage`] without frames or pixels, or if the frames
/// differ in size; [`RasterError::Png`] if the writer fails.
pub fn write_apng(
    frames: &[Image],
    frames_per_second: u16,
    writer: impl Write,
) -> Result<(), RasterError> {
    let (width, height) = frames.first().map_or((0, 0), |f| (f.width, f.height));
    let alike = frames
        .iter()
        .all(|f| (f.width, f.height) == (width, height));
    if width == 0 || height == 0 || !alike {
        return Err(RasterError::EmptyImage { width, height });
    }
    let mut encoder = png::Encoder::new(writer, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_animated(frames.len() as u32, 0)?;
    encoder.set_frame_delay(1, frames_per_second.max(1))?;
    let mut writer = encoder.write_header()?;
    for frame in frames {
        writer.write_image_data(frame.pixels.as_flattened())?;
    }
    writer.finish()?;
    Ok(())
}
