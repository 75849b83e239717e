//! What is written: shaped, aligned, placed.

use csg::glam::{DVec2, dvec2};
use csg::{FillRule, Profile};
use harfrust::{Buffer, Direction, Language, Script, ShapeOptions, ShaperFont};

use crate::font::{Font, FontError};
use crate::outline::{EM, Glyphs, Outline, PIXEL, UNITS};

/// A curve has at most so many chords.
const MOST_CHORDS: usize = 1000;

/// Where along the line the origin is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HorizontalAlign {
    /// Where the writing starts.
    #[default]
    Left,
    /// In the middle of the width.
    Center,
    /// Where the writing ends.
    Right,
}

/// Which height of the line the origin is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VerticalAlign {
    /// The line that letters stand on.
    #[default]
    Baseline,
    /// The lowest point of any letter, at most the baseline.
    Bottom,
    /// The middle between bottom and top.
    Center,
    /// The highest point of any letter.
    Top,
}

/// What becomes of the curves of outlines: those of TrueType fonts are quadratic, others cubic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Curves {
    /// Quadratic ones stay what they are, parabolas; cubic ones become chords that stray at most by
    /// this from them, as a share of the size.
    Exact(f64),
    /// Chords that stray at most by this from the curve, as a share of the size.
    Within(f64),
    /// So many chords of equal parameter for every curve, at least 1.
    Chords(usize),
}

impl Curves {
    /// Chords of a curve whose second derivative is at most twice `bend` at size
    /// 1: over 1/n of the parameter one strays by at most bend / (4 n²).
    pub(crate) fn chords(self, bend: f64) -> usize {
        match self {
            Self::Chords(count) => count.clamp(1, MOST_CHORDS),
            Self::Exact(share) | Self::Within(share) => {
                let count = (0.25 * bend / share).sqrt().ceil();
                (count as usize).clamp(1, MOST_CHORDS)
            }
        }
    }
}

/// One line of text, and how it is set.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    text: String,
    size: f64,
    spacing: f64,
    metrics: f64,
    horizontal: HorizontalAlign,
    vertical: VerticalAlign,
    direction: Option<String>,
    language: String,
    script: Option<String>,
    curves: Curves,
}

/// Why text cannot be set.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TextError {
    /// A number that must be positive and finite is not.
    #[error("{what} is {value}: it must be positive and finite")]
    NotPositive {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A word that must be one of a few is not.
    #[error("{what} is `{value}`: it must be {asked}")]
    Unknown {
        /// What it should say.
        what: &'static str,
        /// What was given.
        value: String,
        /// What may be given.
        asked: &'static str,
    },
    /// The font cannot be used.
    #[error(transparent)]
    Font(#[from] FontError),
}

impl Text {
    /// Text of size 10 from the origin along x.
    #[must_use]
    pub fn new(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            size: 10.0,
            spacing: 1.0,
            metrics: 1.0,
            horizontal: HorizontalAlign::default(),
            vertical: VerticalAlign::default(),
            direction: None,
            language: "en".to_owned(),
            script: None,
            curves: Curves::Exact(1e-3),
        }
    }

    /// About the height of capitals: the em is 100/72 of it.
    #[must_use]
    pub fn size(mut self, size: f64) -> Self {
        self.size = size;
        self
    }

    /// How far letters are apart, as a share of the font's own distances.
    #[must_use]
    pub fn spacing(mut self, spacing: f64) -> Self {
        self.spacing = spacing;
        self
    }

    /// Shrinks or stretches the font's distances between letters and the heights
    /// and widths that are aligned, but not the letters: OpenSCAD 2021.01 takes
    /// 1000/1024 of them.
    #[must_use]
    pub fn metrics(mut self, share: f64) -> Self {
        self.metrics = share;
        self
    }

    /// Where along the line the origin is.
    #[must_use]
    pub fn horizontal(mut self, align: HorizontalAlign) -> Self {
        self.horizontal = align;
        self
    }

    /// Which height of the line the origin is at.
    #[must_use]
    pub fn vertical(mut self, align: VerticalAlign) -> Self {
        self.vertical = align;
        self
    }

    /// `ltr`, `rtl`, `ttb` or `btt`; that of the script where none is given.
    #[must_use]
    pub fn direction(mut self, direction: impl Into<String>) -> Self {
        self.direction = Some(direction.into());
        self
    }

    /// The language by its tag, such as `en` or `ar`.
    #[must_use]
    pub fn language(mut self, language: impl Into<String>) -> Self {
        self.language = language.into();
        self
    }

    /// The script by its ISO 15924 tag, such as `Latn` or `Arab`; that of the
    /// letters where none is given.
    #[must_use]
    pub fn script(mut self, script: impl Into<String>) -> Self {
        self.script = Some(script.into());
        self
    }

    /// What becomes of curves: where nothing is said quadratic ones stay, and cubic ones are chords within
    /// a thousandth of the size.
    #[must_use]
    pub fn curves(mut self, curves: Curves) -> Self {
        self.curves = curves;
        self
    }

    /// The letters' outlines in a font, united.
    ///
    /// # Errors
    /// [`TextError`] if a number or word is out of range, or the font's outlines
    /// cannot be used.
    pub fn profile(&self, font: &Font) -> Result<Profile, TextError> {
        for (what, value) in [
            ("the size", self.size),
            ("the spacing", self.spacing),
            ("the share of the metrics", self.metrics),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(TextError::NotPositive { what, value });
            }
        }
        if let Curves::Exact(share) | Curves::Within(share) = self.curves
            && !(share > 0.0 && share.is_finite())
        {
            return Err(TextError::NotPositive {
                what: "the tolerance of curves",
                value: share,
            });
        }
        let glyphs = self.placed(font)?;
        let paths = glyphs.iter().flat_map(|(outline, at)| {
            let contours = outline.contours.iter();
            contours.filter_map(|contour| contour.path(|point| self.size * (point + *at)))
        });
        Ok(Profile::paths(paths, FillRule::NonZero))
    }

    /// Characters that the font has no glyph for, each once, in the order of the text: boxes
    /// stand for them in the profile, or whatever else the font has in their place.
    ///
    /// # Errors
    /// [`TextError::Unknown`].
    pub fn missing(&self, font: &Font) -> Result<Vec<char>, TextError> {
        let buffer = self.shaped(font)?;
        let mut starts: Vec<usize> = buffer
            .glyph_infos()
            .iter()
            .filter(|info| info.glyph_id == 0)
            .map(|info| info.cluster as usize)
            .collect();
        starts.sort_unstable();
        let mut missing = Vec::new();
        for start in starts {
            let character = self.text.get(start..).and_then(|rest| rest.chars().next());
            missing.extend(character.filter(|character| !missing.contains(character)));
        }
        Ok(missing)
    }

    /// Outlines and where they go, at size 1.
    fn placed(&self, font: &Font) -> Result<Vec<(Outline, DVec2)>, TextError> {
        let buffer = self.shaped(font)?;
        let is_horizontal = matches!(
            buffer.direction(),
            Direction::LeftToRight | Direction::RightToLeft
        );
        let glyphs = Glyphs::new(font, self.curves)?;
        let mut placed = Vec::with_capacity(buffer.len());
        let mut pen = DVec2::ZERO;
        let (mut ascent, mut descent, mut widest) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (info, position) in buffer.glyph_infos().iter().zip(buffer.glyph_positions()) {
            let outline = glyphs.outline(info.glyph_id);
            if let Some([min, max]) = outline.control_box {
                // Whole pixels, as letters are aligned on a screen.
                let [min, max] =
                    [min.floor(), max.ceil()].map(|p| p * (self.metrics * PIXEL / UNITS));
                ascent = ascent.max(max.y);
                descent = descent.max(-min.y);
                widest = widest.max(max.x - min.x);
            }
            let units = |x: i32, y: i32| dvec2(x.into(), y.into()) * (self.metrics / UNITS);
            let offset = units(position.x_offset, position.y_offset);
            placed.push((outline, pen + offset));
            pen += self.spacing * units(position.x_advance, position.y_advance);
        }
        let width = if is_horizontal {
            pen.x
        } else {
            // A column is as wide as its widest letter, and starts at its top.
            (ascent, descent) = (pen.y, 0.0);
            widest
        };
        let origin = dvec2(
            match self.horizontal {
                HorizontalAlign::Left => 0.0,
                HorizontalAlign::Center => -0.5 * width,
                HorizontalAlign::Right => -width,
            },
            match self.vertical {
                VerticalAlign::Baseline => 0.0,
                VerticalAlign::Bottom => descent,
                VerticalAlign::Center => 0.5 * (descent - ascent),
                VerticalAlign::Top => -ascent,
            },
        );
        for (_, at) in &mut placed {
            *at += origin;
        }
        Ok(placed)
    }

    fn shaped(&self, font: &Font) -> Result<Buffer, TextError> {
        let mut buffer = Buffer::new();
        buffer.push_str(&self.text);
        if let Some(script) = &self.script {
            let script = script.parse::<Script>().map_err(|_| TextError::Unknown {
                what: "the script",
                value: script.clone(),
                asked: "a tag of ISO 15924 such as Latn",
            })?;
            buffer.set_script(Some(script));
        }
        if let Some(direction) = &self.direction {
            let direction = direction.parse::<Direction>();
            let direction = direction.map_err(|_| TextError::Unknown {
                what: "the direction",
                value: self.direction.clone().unwrap_or_default(),
                asked: "ltr, rtl, ttb or btt",
            })?;
            buffer.set_direction(direction);
        }
        buffer.set_language(Language::new(&self.language));
        buffer.guess_segment_properties();
        let shaper = ShaperFont::new(&font.face).with_scale(EM);
        if harfrust::shape(&shaper, &mut buffer, ShapeOptions::new()).is_err() {
            // Of a buffer of characters with a direction: cannot be.
            buffer.clear();
        }
        Ok(buffer)
    }
}
