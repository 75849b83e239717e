//! Pictures in memory.

use csg::Color;
use rayon::prelude::*;

use crate::RasterError;
use crate::blend::under;

/// A picture: sRGB-encoded red, green and blue with straight opacity, 8 bits
/// each, row by row from the top.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// `width * height` pixels, the top row first.
    pub pixels: Vec<[u8; 4]>,
}

impl Image {
    /// A picture of one colour.
    #[must_use]
    pub fn new(width: u32, height: u32, colour: [u8; 4]) -> Self {
        Self {
            width,
            height,
            pixels: vec![colour; width as usize * height as usize],
        }
    }

    /// The pixel in column `x` and row `y` from the top, if it is inside.
    #[must_use]
    pub fn get(&self, x: u32, y: u32) -> Option<[u8; 4]> {
        if x >= self.width {
            return None;
        }
        let index = y as usize * self.width as usize + x as usize;
        self.pixels.get(index).copied()
    }
}

impl Image {
    /// The picture at 1/n of its size like [`Image::shrink`], but averaged as
    /// it is encoded: for pictures whose bytes are no light.
    #[must_use]
    pub fn shrink_encoded(&self, n: u32) -> Self {
        let n = n.max(1);
        let (width, height) = (self.width / n, self.height / n);
        let mut small = Self::new(width, height, [0; 4]);
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0u32; 4];
                for (dx, dy) in (0..n * n).map(|k| (k % n, k / n)) {
                    let [r, g, b, a] = self.get(x * n + dx, y * n + dy).unwrap_or_default();
                    for (sum, channel) in sum.iter_mut().zip([r, g, b]) {
                        *sum += u32::from(channel) * u32::from(a);
                    }
                    sum[3] += u32::from(a);
                }
                let [r, g, b] = [sum[0], sum[1], sum[2]].map(|c| {
                    let mean = (c + sum[3] / 2).checked_div(sum[3]);
                    mean.unwrap_or_default() as u8
                });
                let index = y as usize * width as usize + x as usize;
                small.pixels[index] = [r, g, b, ((sum[3] + n * n / 2) / (n * n)) as u8];
            }
        }
        small
    }

    /// Puts a colour behind the picture.
    pub(crate) fn put_behind(&mut self, color: Color) {
        let encoded = crate::resolve::encode(color);
        let pixels = self.pixels.par_iter_mut().with_min_len(1 << 14);
        pixels.for_each(|pixel| match pixel[3] {
            255 => {}
            0 => *pixel = encoded,
            _ => *pixel = under(*pixel, color, color.alpha),
        });
    }

    /// The picture at 1/n of its size: squares of n x n pixels averaged in
    /// linear light, weighted by opacity. A remainder at the right and bottom
    /// is dropped.
    #[must_use]
    pub fn shrink(&self, n: u32) -> Self {
        let n = n.max(1);
        let mut linear = [0f32; 256];
        for (encoded, value) in linear.iter_mut().enumerate() {
            *value = csg::color::srgb_to_linear(encoded as f32 / 255.0);
        }
        let (width, height) = (self.width / n, self.height / n);
        let mut pixels = vec![[0; 4]; width as usize * height as usize];
        if pixels.is_empty() {
            return Self {
                width,
                height,
                pixels,
            };
        }
        let stride = self.width as usize;
        let step = n as usize;
        pixels
            .par_chunks_mut(width as usize)
            .enumerate()
            .for_each(|(y, row)| {
                for (x, pixel) in row.iter_mut().enumerate() {
                    let mut sum = [0f32; 4];
                    for from in (0..step).map(|dy| (y * step + dy) * stride + x * step) {
                        for &[r, g, b, a] in &self.pixels[from..from + step] {
                            let weight = f32::from(a);
                            sum[0] += linear[r as usize] * weight;
                            sum[1] += linear[g as usize] * weight;
                            sum[2] += linear[b as usize] * weight;
                            sum[3] += weight;
                        }
                    }
                    let divisor = if sum[3] > 0.0 { sum[3] } else { 1.0 };
                    let [r, g, b] = [sum[0], sum[1], sum[2]].map(|c| {
                        let encoded = csg::color::linear_to_srgb(c / divisor);
                        (encoded.clamp(0.0, 1.0) * 255.0).round() as u8
                    });
                    *pixel = [r, g, b, (sum[3] / (n * n) as f32).round() as u8];
                }
            });
        Self {
            width,
            height,
            pixels,
        }
    }
}

/// The size that all pictures have.
///
/// # Errors
/// [`RasterError::EmptyImage`] without pictures or pixels, or if they differ in
/// size.
pub(crate) fn common_size(images: &[Image]) -> Result<(u32, u32), RasterError> {
    let size = |image: &Image| (image.width, image.height);
    let (width, height) = images.first().map_or((0, 0), size);
    let alike = images.iter().all(|image| size(image) == (width, height));
    if width == 0 || height == 0 || !alike {
        return Err(RasterError::EmptyImage { width, height });
    }
    Ok((width, height))
}
