//! `text`: OpenSCAD's rules for what it says, and the profile of it.

use text::{Curves, Font, Fonts, HorizontalAlign, Text, TextError, VerticalAlign};

use super::build::{Builder, is_size};
use super::error::SceneError;
use super::parse::{NodeText, Value};
use super::pieces::Piece;
use super::values;

/// More letters than this make more corners than a profile may have.
const MOST_LETTERS: usize = 10_000;

/// What OpenSCAD 2021.01 takes for 1 where letters are placed, not drawn.
const METRICS: f64 = 1000.0 / 1024.0;

impl Builder<'_> {
    pub(super) fn lettering(&mut self, node: &NodeText<'_>) -> Result<Piece, SceneError> {
        let keys = [
            "text",
            "size",
            "spacing",
            "font",
            "direction",
            "language",
            "script",
            "halign",
            "valign",
            "$fn",
            "$fa",
            "$fs",
        ];
        let [
            text,
            size,
            spacing,
            font,
            direction,
            language,
            script,
            halign,
            valign,
            fn_,
            fa,
            fs,
        ] = self.arguments(node, &keys)?;
        let word = |key, value: Option<&Value>, default: &str| match value {
            None => Ok(default.to_owned()),
            Some(value) => values::text(value)
                .map(str::to_owned)
                .ok_or_else(|| self.fault(node, &format!("`{key}` must be a string"))),
        };
        let written = word("text", text, "")?;
        let font = word("font", font, "")?;
        let direction = word("direction", direction, "ltr")?;
        let language = word("language", language, "en")?;
        let script = word("script", script, "Latn")?;
        let halign = word("halign", halign, "left")?;
        let valign = word("valign", valign, "baseline")?;
        let or = |key, value: Option<&Value>, default| match value {
            None => Ok(default),
            Some(_) => self.number(node, key, value),
        };
        let size = or("size", size, 10.0)?;
        let spacing = or("spacing", spacing, 1.0)?;
        let fineness = self.fineness(node, [fn_, fa, fs])?;
        if !is_size(size) {
            return Ok(self.empty(node, "the size"));
        }
        if !is_size(spacing) {
            return Ok(self.empty(node, "the spacing"));
        }
        if written.chars().count() > MOST_LETTERS {
            let problem = format!("more than {MOST_LETTERS} letters cannot be read");
            return Err(self.fault(node, &problem));
        }
        let curves = if self.is_faceted() || fineness.is_polygon() {
            let fragments = fineness.fragments(size);
            Curves::Chords(((fragments / 8.0).floor() as usize + 1).max(2))
        } else {
            Curves::Exact(self.within().map_or(1e-3, |within| within / size))
        };
        let horizontal = match halign.as_str() {
            "center" => HorizontalAlign::Center,
            "right" => HorizontalAlign::Right,
            other => {
                if other != "left" {
                    self.warn(node, format!("`halign` is {other:?}: read as \"left\""));
                }
                HorizontalAlign::Left
            }
        };
        let vertical = match valign.as_str() {
            "bottom" => VerticalAlign::Bottom,
            "center" => VerticalAlign::Center,
            "top" => VerticalAlign::Top,
            other => {
                if other != "baseline" {
                    self.warn(node, format!("`valign` is {other:?}: read as \"baseline\""));
                }
                VerticalAlign::Baseline
            }
        };
        let font = self.font(node, &font)?;
        if let Curves::Exact(share) = curves
            && font.has_cubic_curves()
        {
            self.strayed(share * size);
        }
        let text = Text::new(written)
            .size(size)
            .spacing(spacing)
            .metrics(METRICS)
            .horizontal(horizontal)
            .vertical(vertical)
            .direction(direction)
            .language(language)
            .script(script)
            .curves(curves);
        let set = || Ok::<_, TextError>((text.profile(&font)?, text.missing(&font)?));
        let (profile, missing) = set().map_err(|e| self.fault(node, &e.to_string()))?;
        if !missing.is_empty() {
            self.warn(node, font.lacking(&missing));
        }
        self.flat(node, profile)
    }

    /// The font of a name, or Liberation Sans and a warning.
    fn font(&mut self, node: &NodeText<'_>, name: &str) -> Result<Font, SceneError> {
        let fonts = match self.fonts.take() {
            Some(fonts) => fonts,
            None => {
                let mut fonts = Fonts::installed();
                for file in &self.options.fonts {
                    fonts
                        .add_file(file)
                        .map_err(|e| self.fault(node, &e.to_string()))?;
                }
                fonts
            }
        };
        let found = fonts.find(name).or_else(|missing| {
            let instead = fonts
                .find("")
                .map_err(|e| self.fault(node, &e.to_string()))?;
            self.warn(node, format!("{missing}: Liberation Sans is taken"));
            Ok(instead)
        });
        self.fonts = Some(fonts);
        found
    }
}
