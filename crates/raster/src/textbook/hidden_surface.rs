//! Hidden surfaces, three ways behind one interface: the painter's algorithm,
//! the depth buffer that replaces it, and one row of it at a time.

use crate::fixed::FixedPoint;

/// A triangle ready to be filled by the reference pipeline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowTriangle {
    /// Corners in 1/256 pixel, y downwards.
    pub corners: [FixedPoint; 3],
    /// Window depth of the corners, 0 near to 1 far.
    pub depth: [f64; 3],
    /// 1/w of the corners, for perspective-correct interpolation.
    pub inverse_w: [f64; 3],
    /// For each corner, its weights in the mesh's triangle.
    pub weights: [[f64; 3]; 3],
    /// Number of the mesh's triangle.
    pub triangle: u32,
}

/// A way to find out which surface a pixel shows.
pub trait HiddenSurface {
    /// Brings the triangles into the order in which they are to be filled.
    fn sort(&self, triangles: &mut [WindowTriangle]);

    /// Whether a fragment replaces what is at a pixel (its index in the
    /// picture), given its window depth.
    fn accepts(&mut self, pixel: usize, depth: f64) -> bool;

    /// Whether the picture is drawn row by row, all triangles in each, instead
    /// of triangle by triangle.
    fn is_by_rows(&self) -> bool {
        false
    }

    /// Called before a row is drawn, where pictures are drawn row by row.
    fn begin_row(&mut self) {}
}

/// Sorts triangles by the depth of their centroids and paints them back to
/// front, each over what is there: no memory per pixel, O(n log n). Wrong for
/// triangles that cut each other, overlap in a circle, or are large beside
/// small ones.
#[derive(Clone, Copy, Debug, Default)]
pub struct Painter;

impl HiddenSurface for Painter {
    fn sort(&self, triangles: &mut [WindowTriangle]) {
        let depth = |t: &WindowTriangle| t.depth.iter().sum::<f64>();
        triangles.sort_by(|a, b| depth(b).total_cmp(&depth(a)));
    }

    fn accepts(&mut self, _pixel: usize, _depth: f64) -> bool {
        true
    }
}

/// Keeps the depth of what each pixel shows, and replaces it only by what is
/// nearer: right for any triangles in any order, O(fragments); equal depths
/// show what was drawn first (Catmull, 1974).
#[derive(Clone, Debug)]
pub struct DepthBuffer {
    depth: Vec<f64>,
}

impl DepthBuffer {
    /// A buffer for a picture of so many pixels, all infinitely far.
    #[must_use]
    pub fn new(pixels: usize) -> Self {
        Self {
            depth: vec![f64::INFINITY; pixels],
        }
    }

    /// The depths kept, infinite where nothing was drawn.
    #[must_use]
    pub fn depths(&self) -> &[f64] {
        &self.depth
    }
}

impl HiddenSurface for DepthBuffer {
    fn sort(&self, _triangles: &mut [WindowTriangle]) {}

    fn accepts(&mut self, pixel: usize, depth: f64) -> bool {
        match self.depth.get_mut(pixel) {
            Some(kept) if depth < *kept => {
                *kept = depth;
                true
            }
            _ => false,
        }
    }
}

/// A depth buffer of a single row, used again for each: the scan-line z-buffer,
/// O(width) memory. Triangles wait in a table until the row where they begin,
/// and are active until the one where they end (Wylie, Romney, Evans, Erdahl,
/// 1967; Foley et al., 15.6).
#[derive(Clone, Debug)]
pub struct ScanLine {
    depth: Vec<f64>,
}

impl ScanLine {
    /// For pictures so many pixels wide.
    #[must_use]
    pub fn new(width: u32) -> Self {
        Self {
            depth: vec![f64::INFINITY; width as usize],
        }
    }
}

impl HiddenSurface for ScanLine {
    fn sort(&self, _triangles: &mut [WindowTriangle]) {}

    fn accepts(&mut self, pixel: usize, depth: f64) -> bool {
        let column = pixel % self.depth.len().max(1);
        match self.depth.get_mut(column) {
            Some(kept) if depth < *kept => {
                *kept = depth;
                true
            }
            _ => false,
        }
    }

    fn is_by_rows(&self) -> bool {
        true
    }

    fn begin_row(&mut self) {
        self.depth.fill(f64::INFINITY);
    }
}
