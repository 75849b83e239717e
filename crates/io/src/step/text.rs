//! The text form of exchange files (ISO 10303-21): numbered entities, numbers and strings.

use std::fmt::{self, Display, Write};

use glam::DVec3;
use rustc_hash::FxHashMap;

/// The number of an entity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Id(u32);

impl Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "#{}", self.0)
    }
}

/// The entities of a file's data section.
#[derive(Debug, Default)]
pub(super) struct Entities {
    text: String,
    count: u32,
    shared: FxHashMap<String, Id>,
}

impl Entities {
    /// Adds an entity.
    pub fn add(&mut self, entity: impl Display) -> Id {
        self.count += 1;
        let id = Id(self.count);
        // (Writing to a string cannot fail.)
        let _ = writeln!(self.text, "{id}={entity};");
        id
    }

    /// Adds an entity, or finds the same one: for geometry, which many may use.
    pub fn share(&mut self, entity: impl Display) -> Id {
        let text = entity.to_string();
        if let Some(&id) = self.shared.get(&text) {
            return id;
        }
        let id = self.add(&text);
        self.shared.insert(text, id);
        id
    }

    pub fn point(&mut self, point: DVec3) -> Id {
        self.share(format_args!(
            "CARTESIAN_POINT('',{})",
            Reals(&point.to_array())
        ))
    }

    /// A direction of unit length.
    pub fn direction(&mut self, direction: DVec3) -> Id {
        // What is less than rounding is none.
        let clean = |x: f64| {
            if x.abs() < 0.25 * f64::EPSILON {
                0.0
            } else {
                x
            }
        };
        let clean = direction.to_array().map(clean);
        self.share(format_args!("DIRECTION('',{})", Reals(&clean)))
    }

    /// Coordinates about a point, by the directions of z and x.
    pub fn placement(&mut self, origin: DVec3, [z, x]: [DVec3; 2]) -> Id {
        let origin = self.point(origin);
        let [z, x] = [z, x].map(|direction| self.direction(direction));
        self.share(format_args!("AXIS2_PLACEMENT_3D('',{origin},{z},{x})"))
    }

    pub fn into_text(self) -> String {
        self.text
    }
}

/// A number: the shortest that reads back to the same bits, with the point that is asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Real(pub f64);

impl Display for Real {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == 0.0 {
            return f.write_str("0.");
        }
        let mut buffer = zmij::Buffer::new();
        let text = buffer.format(self.0);
        match text.split_once('e') {
            Some((digits, exponent)) if digits.contains('.') => write!(f, "{digits}E{exponent}"),
            Some((digits, exponent)) => write!(f, "{digits}.E{exponent}"),
            None => match text.strip_suffix(".0") {
                Some(whole) => write!(f, "{whole}."),
                None => f.write_str(text),
            },
        }
    }
}

/// Numbers as a list.
pub(super) struct Reals<'a>(pub &'a [f64]);

impl Display for Reals<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        list(f, self.0.iter().map(|&number| Real(number)))
    }
}

/// Things as a list.
pub(super) struct List<'a, T>(pub &'a [T]);

impl<T: Display> Display for List<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        list(f, self.0.iter())
    }
}

fn list(f: &mut fmt::Formatter<'_>, items: impl Iterator<Item = impl Display>) -> fmt::Result {
    f.write_char('(')?;
    for (index, item) in items.enumerate() {
        if index > 0 {
            f.write_char(',')?;
        }
        write!(f, "{item}")?;
    }
    f.write_char(')')
}

/// A yes or no.
pub(super) struct Flag(pub bool);

impl Display for Flag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.0 { ".T." } else { ".F." })
    }
}

/// Text in quotes: what is not ASCII as UTF-16 or UTF-32 in hexadecimal digits.
pub(super) struct Quoted<'a>(pub &'a str);

impl Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_char('\'')?;
        for c in self.0.chars() {
            match c {
                '\'' => f.write_str("''")?,
                '\\' => f.write_str("\\\\")?,
                ' '..='~' => f.write_char(c)?,
                _ => match u32::from(c) {
                    code @ 0..=0xffff => write!(f, "\\X2\\{code:04X}\\X0\\")?,
                    code => write!(f, "\\X4\\{code:08X}\\X0\\")?,
                },
            }
        }
        f.write_char('\'')
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_point_and_read_back() {
        for (number, text) in [
            (0.0, "0."),
            (-0.0, "0."),
            (1.0, "1."),
            (-25.4, "-25.4"),
            (0.1 + 0.2, "0.30000000000000004"),
            (1e300, "1.E+300"),
            (-1.5e-9, "-1.5E-9"),
        ] {
            assert_eq!(Real(number).to_string(), text);
            assert_eq!(text.parse::<f64>(), Ok(number));
        }
    }

    #[test]
    fn text_is_quoted() {
        let quoted = |text| Quoted(text).to_string();
        assert_eq!(quoted("it's a \\"), r"'it''s a \\'");
        assert_eq!(quoted("Büchse 🔩"), r"'B\X2\00FC\X0\chse \X4\0001F529\X0\'");
    }

    #[test]
    fn what_is_the_same_is_written_once() {
        let mut entities = Entities::default();
        let one = entities.point(DVec3::X);
        assert_eq!(entities.point(DVec3::X), one);
        assert_ne!(entities.add("CARTESIAN_POINT('',(1.,0.,0.))"), one);
        assert_eq!(entities.into_text().lines().count(), 2);
    }
}
