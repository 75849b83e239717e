//! Lengths, view boxes, and where the page lies.

use std::str::FromStr;

use glam::{DAffine2, DMat2, DVec2};
use roxmltree::Node;
use svgtypes::{Align, AspectRatio, Length, LengthUnit, ViewBox};

use super::super::ProfileOptions;
use super::Reader;
use crate::Error;

const MILLIMETRES: f64 = 25.4;

/// A view box, and how it is put where it is seen.
pub(super) struct View {
    low: DVec2,
    pub(super) size: DVec2,
    ratio: AspectRatio,
}

impl View {
    /// That of an element, if it has one.
    pub(super) fn of(node: Node<'_, '_>) -> Result<Option<Self>, String> {
        let Some(text) = node.attribute("viewBox") else {
            return Ok(None);
        };
        let view = ViewBox::from_str(text).map_err(|e| format!("its viewBox: {e}"))?;
        let ratio = match node.attribute("preserveAspectRatio") {
            Some(text) => {
                AspectRatio::from_str(text).map_err(|e| format!("its preserveAspectRatio: {e}"))?
            }
            None => AspectRatio::default(),
        };
        Ok(Some(Self {
            low: DVec2::new(view.x, view.y),
            size: DVec2::new(view.w, view.h),
            ratio,
        }))
    }

    /// The map of the view box to a rectangle of a size, from its corner.
    pub(super) fn fitted(&self, size: DVec2) -> DAffine2 {
        let mut scale = size / self.size;
        let mut offset = DVec2::ZERO;
        if self.ratio.align != Align::None {
            let one = if self.ratio.slice {
                scale.max_element()
            } else {
                scale.min_element()
            };
            scale = DVec2::splat(one);
            // Half steps from least to greatest.
            let (x, y) = match self.ratio.align {
                Align::None | Align::XMinYMin => (0.0, 0.0),
                Align::XMidYMin => (0.5, 0.0),
                Align::XMaxYMin => (1.0, 0.0),
                Align::XMinYMid => (0.0, 0.5),
                Align::XMidYMid => (0.5, 0.5),
                Align::XMaxYMid => (1.0, 0.5),
                Align::XMinYMax => (0.0, 1.0),
                Align::XMidYMax => (0.5, 1.0),
                Align::XMaxYMax => (1.0, 1.0),
            };
            offset = DVec2::new(x, y) * (size - scale * self.size);
        }
        DAffine2 {
            matrix2: DMat2::from_diagonal(scale),
            translation: offset - scale * self.low,
        }
    }
}

/// A length of the page in millimetres, as OpenSCAD has it: `whole` is the view box's.
fn millimetres(length: Option<Length>, whole: Option<f64>, dpi: f64) -> Option<f64> {
    let share = |share: f64| whole.map(|whole| MILLIMETRES * share * whole / dpi);
    let Some(Length { number, unit }) = length else {
        return share(1.0);
    };
    let per_inch = match unit {
        LengthUnit::None => dpi,
        LengthUnit::Px => 96.0,
        LengthUnit::Pt => 72.0,
        LengthUnit::Pc => 6.0,
        LengthUnit::In => 1.0,
        LengthUnit::Cm => return Some(10.0 * number),
        LengthUnit::Mm => return Some(number),
        LengthUnit::Percent => return share(number / 100.0),
        LengthUnit::Em | LengthUnit::Ex => return None,
    };
    Some(MILLIMETRES * number / per_inch)
}

impl Reader<'_, '_> {
    /// The map from the document to the result, and what percentages are of.
    pub(super) fn page(&mut self, root: Node<'_, '_>) -> Result<(DAffine2, DVec2), Error> {
        let ProfileOptions { dpi, .. } = *self.options;
        let view = View::of(root).map_err(|problem| self.fault(root, &problem))?;
        let mut size = DVec2::ZERO;
        for (axis, key) in ["width", "height"].into_iter().enumerate() {
            let text = root.attribute(key).filter(|text| text.trim() != "auto");
            let length = text.map(|text| self.parsed(root, key, text)).transpose()?;
            let whole = view.as_ref().map(|view| view.size[axis]);
            size[axis] = match millimetres(length, whole, dpi) {
                Some(size) => size,
                None if text.is_some() && view.is_some() => {
                    let problem = format!("its {key} is in a unit of fonts: give it in mm");
                    return Err(self.fault(root, &problem));
                }
                None => 0.0,
            };
        }
        let flipped = DAffine2 {
            matrix2: DMat2::from_diagonal(DVec2::new(1.0, -1.0)),
            translation: DVec2::new(0.0, size.y),
        };
        let Some(view) = view else {
            self.warn(root, "without a viewBox a unit is taken for a millimetre, as OpenSCAD does, not for 1/96 inch");
            return Ok((flipped, size));
        };
        if size.min_element() <= 0.0 {
            return Err(self.fault(root, "its width and height must be above 0"));
        }
        Ok((flipped * view.fitted(size), view.size))
    }

    fn parsed(&self, node: Node<'_, '_>, key: &str, text: &str) -> Result<Length, Error> {
        Length::from_str(text.trim())
            .map_err(|e| self.fault(node, &format!("its {key}, {text:?}, is not a length: {e}")))
    }

    /// An attribute that is a length, in units of the element; percentages are of the page's
    /// width (axis 0), height (1) or diagonal over √2 (2).
    pub(super) fn length(
        &self,
        node: Node<'_, '_>,
        key: &str,
        axis: usize,
    ) -> Result<Option<f64>, Error> {
        let Some(text) = node.attribute(key).filter(|text| text.trim() != "auto") else {
            return Ok(None);
        };
        let Length { number, unit } = self.parsed(node, key, text)?;
        let whole = match axis {
            0 => self.reference.x,
            1 => self.reference.y,
            _ => self.reference.length() / std::f64::consts::SQRT_2,
        };
        let per_inch = match unit {
            LengthUnit::None | LengthUnit::Px => return Ok(Some(number)),
            LengthUnit::Percent => return Ok(Some(number / 100.0 * whole)),
            LengthUnit::Pt => 72.0,
            LengthUnit::Pc => 6.0,
            LengthUnit::In => 1.0,
            LengthUnit::Cm => 2.54,
            LengthUnit::Mm => MILLIMETRES,
            LengthUnit::Em | LengthUnit::Ex => {
                let problem = format!("its {key} is in a unit of fonts: give it without one");
                return Err(self.fault(node, &problem));
            }
        };
        Ok(Some(96.0 * number / per_inch))
    }
}
