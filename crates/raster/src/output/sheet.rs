//! Sheets of standard views.

use csg::{Color, Mesh};
use glam::DVec2;

use crate::camera::{Camera, Lens};
use crate::framing::StandardView;
use crate::image::Image;
use crate::lettering::Lettering;
use crate::options::RenderOptions;
use crate::pipeline::Renderer;
use crate::prepared::Prepared;
use crate::{MAX_SIZE, RasterError};

/// Where views are put on a sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProjectionAngle {
    /// What is seen from above is put above, from the right to the right: as
    /// if the views were drawn on glass around the part.
    #[default]
    Third,
    /// What is seen from above is put below, from the left to the right: as if
    /// the part threw its shadow on walls behind.
    First,
}

impl ProjectionAngle {
    /// The views of a sheet, row by row.
    #[must_use]
    pub fn views(self) -> [StandardView; 4] {
        use StandardView::{Front, Iso, Left, Right, Top};
        match self {
            Self::Third => [Top, Iso, Front, Right],
            Self::First => [Front, Left, Top, Iso],
        }
    }
}

/// Four views of a mesh on one sheet of `width` x `height` pixels, each with its
/// name: front, top, one side and iso, where an angle of projection puts them;
/// the three orthographic ones to one scale.
///
/// # Errors
/// Those of [`Camera::standard`] and [`Renderer::draw`].
pub fn contact_sheet(
    mesh: &Mesh,
    scene: &Prepared,
    lens: Lens,
    angle: ProjectionAngle,
    width: u32,
    height: u32,
    options: &RenderOptions,
) -> Result<Image, RasterError> {
    if width.max(height) > MAX_SIZE {
        return Err(RasterError::SizeTooLarge { width, height });
    }
    let (w, h) = (width / 2, height / 2);
    let aspect = f64::from(w.max(1)) / f64::from(h.max(1));
    let views = angle.views();
    let mut cameras = Vec::new();
    for view in views {
        let is_iso = view == StandardView::Iso;
        let own = if is_iso {
            lens
        } else {
            Lens::Orthographic { height: 1.0 }
        };
        cameras.push(Camera::standard(mesh, view, own, aspect)?);
    }
    let flat = |k: &usize| views[*k] != StandardView::Iso;
    let tallest = (0..4)
        .filter(flat)
        .fold(0.0f64, |most, k| match cameras[k].lens {
            Lens::Orthographic { height } => most.max(height),
            _ => most,
        });
    for k in (0..4).filter(flat) {
        cameras[k].lens = Lens::Orthographic { height: tallest };
    }
    let mut sheet = Image::new(width, height, crate::resolve::encode(options.background));
    let mut renderer = Renderer::default();
    let text = (f64::from(w.min(h)) / 30.0).clamp(6.0, 40.0);
    for (k, (camera, view)) in cameras.iter().zip(views).enumerate() {
        let mut image = Image::default();
        renderer.draw(scene, &camera.view(w, h)?, w, h, options, &mut image)?;
        let label = Lettering {
            text: view.name(),
            at: DVec2::new(text, f64::from(h) - text),
            height: text,
            color: ink_on(options.background),
        };
        label.draw(&mut image);
        let (x, y) = (k as u32 % 2 * (width - w), k as u32 / 2 * (height - h));
        sheet.paste(&image, x, y);
    }
    Ok(sheet)
}

/// A colour for lettering on a background: black, or white on dark ones.
#[must_use]
pub fn ink_on(background: Color) -> Color {
    let [r, g, b] = background.rgb;
    let dark = background.alpha > 0.5 && 0.21 * r + 0.72 * g + 0.07 * b < 0.18;
    Color::from_linear([if dark { 0.8 } else { 0.03 }; 3])
}

impl Image {
    /// Copies a picture into this one, its top left corner at (`x`, `y`);
    /// what does not fit is left out.
    pub fn paste(&mut self, other: &Self, x: u32, y: u32) {
        let columns = other.width.min(self.width.saturating_sub(x)) as usize;
        let rows = other.height.min(self.height.saturating_sub(y)) as usize;
        for row in 0..rows {
            let from = row * other.width as usize;
            let to = (row + y as usize) * self.width as usize + x as usize;
            self.pixels[to..to + columns].copy_from_slice(&other.pixels[from..from + columns]);
        }
    }
}
