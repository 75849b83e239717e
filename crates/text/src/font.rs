//! Fonts, by name or from a file.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use fontdb::{Database, Family, Query, Style, Weight};
use harfrust::font::Blob;
use skrifa::FontRef;
use skrifa::outline::{OutlineGlyphCollection, OutlineGlyphFormat};

/// The family that is meant where none is named.
const DEFAULT_FAMILY: &str = "Liberation Sans";

/// A font face: a file's bytes, and which of its faces.
#[derive(Clone)]
pub struct Font {
    pub(crate) bytes: Blob,
    pub(crate) index: u32,
    /// The same face as the shaper reads it.
    pub(crate) face: harfrust::Font,
    family: String,
}

/// Why there is no such font.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FontError {
    /// No font of the family is installed.
    #[error(
        "no font of the family `{family}` is installed: install it (Debian has Liberation Sans in `fonts-liberation`), name another one, or give a font file"
    )]
    NotFound {
        /// The family.
        family: String,
    },
    /// The file cannot be read.
    #[error("{}: {source}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The bytes are not a font.
    #[error("{name} is no TrueType or OpenType font")]
    NotAFont {
        /// The file or family.
        name: String,
    },
}

impl Font {
    /// The installed font that fits a name: [`Fonts::find`].
    ///
    /// # Errors
    /// [`FontError::NotFound`] if the family is not installed.
    pub fn find(name: &str) -> Result<Self, FontError> {
        Fonts::installed().find(name)
    }

    /// The first face of a font file.
    ///
    /// # Errors
    /// [`FontError::Io`] and [`FontError::NotAFont`].
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, FontError> {
        let path = path.as_ref();
        Self::of_bytes(read(path)?, 0, &path.display().to_string())
    }

    /// Whether its outlines have cubic curves, as those of PostScript have: TrueType's are quadratic.
    #[must_use]
    pub fn has_cubic_curves(&self) -> bool {
        let reference = FontRef::from_index(&self.bytes, self.index);
        let format = reference
            .ok()
            .and_then(|font| OutlineGlyphCollection::new(&font).format());
        !matches!(format, None | Some(OutlineGlyphFormat::Glyf))
    }

    fn of_bytes(bytes: Vec<u8>, index: u32, name: &str) -> Result<Self, FontError> {
        let bytes = Blob::from(bytes);
        let family = name.to_owned();
        match harfrust::Font::new(bytes.clone(), index) {
            Some(face) => Ok(Self {
                bytes,
                index,
                face,
                family,
            }),
            None => Err(FontError::NotAFont { name: family }),
        }
    }

    /// What is to be said of characters that the font has no glyph for ([`Text::missing`]).
    ///
    /// [`Text::missing`]: crate::Text::missing
    #[must_use]
    pub fn lacking(&self, characters: &[char]) -> String {
        /// More are counted.
        const MOST_NAMED: usize = 8;
        let named = characters.iter().take(MOST_NAMED);
        let named = named.map(|&c| format!("{c:?} (U+{:04X})", u32::from(c)));
        let named: Vec<String> = named.collect();
        let more = match characters.len().saturating_sub(MOST_NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let (family, named) = (&self.family, named.join(", "));
        format!(
            "the font {family} has no glyph for {named}{more}, and boxes stand for them: name a \
             font that has them"
        )
    }

    /// The family's name, or that of the file.
    #[must_use]
    pub fn family(&self) -> &str {
        &self.family
    }
}

/// Fonts by name: those installed, and files given beside them.
#[derive(Clone, Debug)]
pub struct Fonts {
    database: Database,
}

impl Fonts {
    /// The fonts where the system keeps them; it is looked through once for the
    /// whole program.
    #[must_use]
    pub fn installed() -> Self {
        static INSTALLED: OnceLock<Database> = OnceLock::new();
        let database = INSTALLED.get_or_init(|| {
            let mut database = Database::new();
            database.load_system_fonts();
            database
        });
        Self {
            database: database.clone(),
        }
    }

    /// Adds all faces of a font file.
    ///
    /// # Errors
    /// [`FontError::Io`] and [`FontError::NotAFont`].
    pub fn add_file(&mut self, path: impl AsRef<Path>) -> Result<(), FontError> {
        let path = path.as_ref();
        let bytes = read(path)?;
        let before = self.database.len();
        self.database.load_font_data(bytes);
        if self.database.len() > before {
            Ok(())
        } else {
            Err(FontError::NotAFont {
                name: path.display().to_string(),
            })
        }
    }

    /// The font that fits a name such as `Liberation Sans` or `Liberation
    /// Sans:style=Bold Italic`: the family, then what `style=` says of weight and
    /// slant. An empty name means Liberation Sans.
    ///
    /// # Errors
    /// [`FontError::NotFound`] if the family is not there.
    pub fn find(&self, name: &str) -> Result<Font, FontError> {
        let (family, weight, style) = parsed(name);
        let not_found = || FontError::NotFound {
            family: family.to_owned(),
        };
        let lowercase = family.to_lowercase();
        let known = self.database.faces().find_map(|face| {
            let mut names = face.families.iter().map(|(name, _)| name);
            names.find(|name| name.to_lowercase() == lowercase)
        });
        let known = known.ok_or_else(not_found)?;
        let query = Query {
            families: &[Family::Name(known)],
            weight,
            style,
            ..Query::default()
        };
        let id = self.database.query(&query).ok_or_else(not_found)?;
        let copied = |bytes: &[u8], index| (bytes.to_vec(), index);
        let face = self.database.with_face_data(id, copied);
        let (bytes, index) = face.ok_or_else(not_found)?;
        Font::of_bytes(bytes, index, known)
    }
}

fn read(path: &Path) -> Result<Vec<u8>, FontError> {
    std::fs::read(path).map_err(|source| FontError::Io {
        path: path.to_owned(),
        source,
    })
}

impl std::fmt::Debug for Font {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Font")
            .field("family", &self.family)
            .finish()
    }
}

/// Family, weight and slant of a name in fontconfig's way of writing.
fn parsed(name: &str) -> (&str, Weight, Style) {
    let mut parts = name.split(':');
    let family = parts.next().unwrap_or_default().trim();
    let family = if family.is_empty() {
        DEFAULT_FAMILY
    } else {
        family
    };
    let (mut weight, mut slant) = (Weight::NORMAL, Style::Normal);
    let styles = parts.filter_map(|part| part.trim().strip_prefix("style="));
    for word in styles.flat_map(str::split_whitespace) {
        match word.to_lowercase().as_str() {
            "thin" => weight = Weight::THIN,
            "extralight" => weight = Weight::EXTRA_LIGHT,
            "light" => weight = Weight::LIGHT,
            "medium" => weight = Weight::MEDIUM,
            "semibold" | "demibold" => weight = Weight::SEMIBOLD,
            "bold" => weight = Weight::BOLD,
            "extrabold" => weight = Weight::EXTRA_BOLD,
            "black" | "heavy" => weight = Weight::BLACK,
            "italic" => slant = Style::Italic,
            "oblique" => slant = Style::Oblique,
            _ => {}
        }
    }
    (family, weight, slant)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_taken_apart() {
        let regular = (DEFAULT_FAMILY, Weight::NORMAL, Style::Normal);
        assert_eq!(parsed(""), regular);
        assert_eq!(parsed("Liberation Sans:style=Regular"), regular);
        let bold = parsed("DejaVu Serif:style=bold Italic");
        assert_eq!(bold, ("DejaVu Serif", Weight::BOLD, Style::Italic));
    }

    #[test]
    fn fonts_that_are_not_there_are_named() {
        let error = Font::find("No Such Family:style=Bold").expect_err("not there");
        let text = error.to_string();
        assert!(text.contains("`No Such Family`") && text.contains("fonts-liberation"));
        let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
        let error = Font::from_file(manifest).expect_err("no font");
        assert!(error.to_string().contains("Cargo.toml is no TrueType"));
        assert!(Font::from_file("no/such/file.ttf").is_err());
    }
}
