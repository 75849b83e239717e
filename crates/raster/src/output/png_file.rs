//! PNG encoding.

use std::io::Write;
use std::path::Path;

use crate::RasterError;
use crate::buffers::Buffer;
use crate::image::{Image, common_size};

impl Image {
    /// Writes the picture as an sRGB PNG with an alpha channel, compressed
    /// for speed.
    ///
    /// # Errors
    /// [`RasterError::EmptyImage`] without pixels; [`RasterError::Png`] if
    /// the writer fails.
    pub fn write_png(&self, writer: impl Write) -> Result<(), RasterError> {
        let encoder = encoder(writer, self.width, self.height)?;
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

/// An encoder of sRGB with alpha, for speed.
fn encoder<'a, W: Write>(
    writer: W,
    width: u32,
    height: u32,
) -> Result<png::Encoder<'a, W>, RasterError> {
    if width == 0 || height == 0 {
        return Err(RasterError::EmptyImage { width, height });
    }
    let mut encoder = png::Encoder::new(writer, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::Fast);
    Ok(encoder)
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
    let (width, height) = common_size(frames)?;
    let mut encoder = encoder(writer, width, height)?;
    encoder.set_animated(frames.len() as u32, 0)?;
    encoder.set_frame_delay(1, frames_per_second.max(1))?;
    let mut writer = encoder.write_header()?;
    for frame in frames {
        writer.write_image_data(frame.pixels.as_flattened())?;
    }
    writer.finish()?;
    Ok(())
}

/// Depths of so many bits as the bytes of a grey PNG of 16 bits, or of 8 where
/// these are enough: the numbers themselves, the upper 16 of more.
///
/// # Errors
/// [`RasterError::EmptyImage`] without pixels.
pub fn integer_depth_png(depths: &Buffer<u32>, bits: u32) -> Result<Vec<u8>, RasterError> {
    let (width, height) = (depths.width, depths.height);
    if width == 0 || height == 0 {
        return Err(RasterError::EmptyImage { width, height });
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    let deep = bits > 8;
    encoder.set_depth(if deep {
        png::BitDepth::Sixteen
    } else {
        png::BitDepth::Eight
    });
    let bytes: Vec<u8> = if deep {
        let upper = |&v: &u32| (v >> bits.saturating_sub(16).min(16)) as u16;
        depths
            .values
            .iter()
            .flat_map(|v| upper(v).to_be_bytes())
            .collect()
    } else {
        depths.values.iter().map(|&v| v as u8).collect()
    };
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}
