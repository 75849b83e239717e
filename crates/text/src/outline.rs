//! Outlines of glyphs.

use csg::Path;
use csg::glam::DVec2;
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{
    DrawSettings, Engine, HintingInstance, HintingOptions, OutlineGlyphCollection, OutlinePen,
    Target,
};
use skrifa::raw::TableProvider;
use skrifa::raw::tables::head::Flags;
use skrifa::{FontRef, GlyphId};

use crate::font::{Font, FontError};
use crate::layout::Curves;

/// Units in a length of 1 at size 1.
pub(crate) const UNITS: f64 = 1e5;
/// The em in units: a size of 1e5 in points of 1/72 inch at 100 dots per inch,
/// rounded. OpenSCAD asks FreeType for that, with units of 1/64 pixel.
pub(crate) const EM: i32 = 138_889;
/// Units in a pixel.
pub(crate) const PIXEL: f64 = 64.0;

/// The glyphs of a font, drawn one by one.
pub(crate) struct Glyphs<'a> {
    glyphs: OutlineGlyphCollection<'a>,
    hinting: HintingInstance,
    curves: Curves,
}

/// A glyph's contours at size 1, and the box of their points and control points
/// in pixels.
#[derive(Default)]
pub(crate) struct Outline {
    pub contours: Vec<Contour>,
    pub control_box: Option<[DVec2; 2]>,
}

/// A closed contour, from its start by sides to points, some of which are parabolas with that control
/// point.
#[derive(Default)]
pub(crate) struct Contour {
    start: DVec2,
    sides: Vec<(Option<DVec2>, DVec2)>,
}

impl Contour {
    /// The image under a map; none of a point.
    pub(crate) fn path(&self, map: impl Fn(DVec2) -> DVec2) -> Option<Path> {
        let path = self
            .sides
            .iter()
            .fold(
                Path::from(map(self.start)),
                |path, &(control, end)| match control {
                    Some(control) => path.quadratic_to(map(control), map(end)),
                    None => path.line_to(map(end)),
                },
            );
        let is_curved = self.sides.iter().any(|(control, _)| control.is_some());
        let sides = self.sides.iter().filter(|(_, end)| *end != self.start);
        (sides.count() > if is_curved { 0 } else { 1 }).then_some(path)
    }
}

impl<'a> Glyphs<'a> {
    pub(crate) fn new(font: &'a Font, curves: Curves) -> Result<Self, FontError> {
        let unusable = || FontError::NotAFont {
            name: font.family().to_owned(),
        };
        let reference = FontRef::from_index(&font.bytes, font.index).map_err(|_| unusable())?;
        let glyphs = OutlineGlyphCollection::new(&reference);
        let options = HintingOptions {
            engine: Engine::AutoFallback,
            target: Target::default(),
        };
        // FreeType rounds to whole pixels where a font asks for it, even if its
        // instructions then do nothing.
        let pixels = EM as f32 / PIXEL as f32;
        let whole = reference.head().is_ok_and(|head| {
            let flags = head.flags();
            flags.contains(Flags::FORCE_INTEGER_PPEM)
        });
        let size = Size::new(if whole { pixels.round() } else { pixels });
        let hinting = HintingInstance::new(&glyphs, size, LocationRef::default(), options);
        Ok(Self {
            glyphs,
            hinting: hinting.map_err(|_| unusable())?,
            curves,
        })
    }

    /// The outline of a glyph; empty if the font has none for it.
    pub(crate) fn outline(&self, glyph: u32) -> Outline {
        let mut pen = Pen {
            curves: self.curves,
            outline: Outline::default(),
        };
        if let Some(glyph) = self.glyphs.get(GlyphId::new(glyph)) {
            let settings = DrawSettings::hinted(&self.hinting, false);
            if glyph.draw(settings, &mut pen).is_err() {
                return Outline::default();
            }
        }
        pen.outline
    }
}

struct Pen {
    curves: Curves,
    outline: Outline,
}

impl Pen {
    fn point(&mut self, x: f32, y: f32) -> DVec2 {
        let pixels = DVec2::new(x.into(), y.into());
        let [min, max] = self.outline.control_box.unwrap_or([pixels; 2]);
        self.outline.control_box = Some([min.min(pixels), max.max(pixels)]);
        pixels * (PIXEL / UNITS)
    }

    fn start(&self) -> DVec2 {
        let last = self.outline.contours.last();
        last.map_or(DVec2::ZERO, |contour| {
            contour.sides.last().map_or(contour.start, |&(_, end)| end)
        })
    }

    fn push(&mut self, control: Option<DVec2>, end: DVec2) {
        if let Some(contour) = self.outline.contours.last_mut() {
            contour.sides.push((control, end));
        }
    }
}

impl OutlinePen for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let start = self.point(x, y);
        self.outline.contours.push(Contour {
            start,
            ..Contour::default()
        });
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let end = self.point(x, y);
        self.push(None, end);
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        let (start, control, end) = (self.start(), self.point(cx, cy), self.point(x, y));
        if let Curves::Exact(_) = self.curves {
            return self.push(Some(control), end);
        }
        let bend = (start - 2.0 * control + end).length();
        let chords = self.curves.chords(bend);
        for k in 1..=chords {
            let t = k as f64 / chords as f64;
            let s = 1.0 - t;
            self.push(None, s * s * start + 2.0 * s * t * control + t * t * end);
        }
    }

    fn curve_to(&mut self, ax: f32, ay: f32, bx: f32, by: f32, x: f32, y: f32) {
        let start = self.start();
        let (a, b, end) = (self.point(ax, ay), self.point(bx, by), self.point(x, y));
        let bend = (start - 2.0 * a + b)
            .length()
            .max((a - 2.0 * b + end).length());
        let chords = self.curves.chords(3.0 * bend);
        for k in 1..=chords {
            let t = k as f64 / chords as f64;
            let s = 1.0 - t;
            let inner = 3.0 * s * t * (s * a + t * b);
            self.push(None, s * s * s * start + inner + t * t * t * end);
        }
    }

    fn close(&mut self) {}
}
