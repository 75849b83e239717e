//! Pictures in memory.

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
