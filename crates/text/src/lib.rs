//! Lettering: text in a font as a profile to be extruded or cut.
//!
//! Shaping (kerning, ligatures, direction) is HarfBuzz's, by `harfrust`;
//! outlines are those of the font's glyphs, by `skrifa`, with the font's own
//! instructions carried out at 2170 pixels per em. That, the scale and the
//! alignment are what OpenSCAD's `text()` does, so that both draw the same
//! letters.
//!
//! ```no_run
//! use csg::Solid;
//! use text::{Font, HorizontalAlign, Text};
//!
//! let font = Font::find("Liberation Sans:style=Bold")?;
//! let label = Text::new("Stereotomy")
//!     .size(8.0)
//!     .horizontal(HorizontalAlign::Center)
//!     .profile(&font)?;
//! let raised = Solid::extrude(&label, 0.0..1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod font;
mod layout;
mod outline;

pub use font::{Font, FontError, Fonts};
pub use layout::{Curves, HorizontalAlign, Text, TextError, VerticalAlign};
