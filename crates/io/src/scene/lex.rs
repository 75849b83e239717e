//! Tokens of the scene text.

use super::error::{Place, SceneError};

/// A token; texts are slices of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Token<'a> {
    /// A name such as `cube`, `size` or `$fn`.
    Name(&'a str),
    /// A number, also `inf`, `-inf`, `nan` and `-nan`.
    Number(f64),
    /// A text between quotes, these left out and escapes as they stand.
    String(&'a str),
    /// One of `( ) [ ] { } , ; = % #`.
    Mark(char),
    /// The end of the text.
    End,
}

impl std::fmt::Display for Token<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Name(name) => write!(f, "`{name}`"),
            Self::Number(number) => write!(f, "the number {number}"),
            Self::String(_) => f.write_str("a string"),
            Self::Mark(mark) => write!(f, "`{mark}`"),
            Self::End => f.write_str("the end of the text"),
        }
    }
}

/// Reads tokens off a text, one ahead.
pub(super) struct Lexer<'a> {
    text: &'a str,
    /// Where the next token starts, and where it ends.
    start: usize,
    end: usize,
    next: Token<'a>,
}

impl<'a> Lexer<'a> {
    pub(super) fn new(text: &'a str) -> Result<Self, SceneError> {
        let mut lexer = Self {
            text,
            start: 0,
            end: 0,
            next: Token::End,
        };
        lexer.advance()?;
        Ok(lexer)
    }

    /// The next token, left where it is.
    pub(super) fn peek(&self) -> Token<'a> {
        self.next
    }

    /// The byte offset of the next token.
    pub(super) fn offset(&self) -> usize {
        self.start
    }

    /// Takes the next token.
    pub(super) fn take(&mut self) -> Result<Token<'a>, SceneError> {
        let taken = self.next;
        self.advance()?;
        Ok(taken)
    }

    /// Takes the next token if it is this mark.
    pub(super) fn take_mark(&mut self, mark: char) -> Result<bool, SceneError> {
        let is_it = self.next == Token::Mark(mark);
        if is_it {
            self.advance()?;
        }
        Ok(is_it)
    }

    /// Takes the next token, which must be this mark.
    pub(super) fn expect_mark(&mut self, mark: char) -> Result<(), SceneError> {
        if self.take_mark(mark)? {
            Ok(())
        } else {
            Err(self.unexpected(&format!("`{mark}`")))
        }
    }

    /// The error that something else than the next token should be here.
    pub(super) fn unexpected(&self, wanted: &str) -> SceneError {
        self.error(self.start, format!("found {}, not {wanted}", self.next))
    }

    /// A syntax error at a byte offset.
    pub(super) fn error(&self, offset: usize, problem: String) -> SceneError {
        SceneError::Syntax {
            place: Place::of(self.text, offset),
            problem,
        }
    }

    fn advance(&mut self) -> Result<(), SceneError> {
        self.skip_space()?;
        let rest = &self.text[self.start..];
        let Some(first) = rest.chars().next() else {
            self.next = Token::End;
            return Ok(());
        };
        let (token, length) = match first {
            '(' | ')' | '[' | ']' | '{' | '}' | ',' | ';' | '=' | '%' | '#' => {
                (Token::Mark(first), 1)
            }
            '"' => {
                let length = self.string_length(rest)?;
                (Token::String(&rest[1..length - 1]), length)
            }
            '$' | '_' | 'a'..='z' | 'A'..='Z' => {
                let word = &rest[..1 + span(&rest[1..], |c| c == '_' || c.is_ascii_alphanumeric())];
                let token = match word {
                    "inf" => Token::Number(f64::INFINITY),
                    "nan" => Token::Number(f64::NAN),
                    _ => Token::Name(word),
                };
                (token, word.len())
            }
            '0'..='9' | '.' | '+' | '-' => self.number(rest)?,
            '*' | '!' => {
                let problem = format!(
                    "`{first}` does not occur in an evaluated tree: export the model as .csg again"
                );
                return Err(self.error(self.start, problem));
            }
            _ => {
                let problem = format!("{first:?} is not part of a scene");
                return Err(self.error(self.start, problem));
            }
        };
        self.next = token;
        self.end = self.start + length;
        Ok(())
    }

    /// Moves to the next token, over white space and comments.
    fn skip_space(&mut self) -> Result<(), SceneError> {
        self.start = self.end;
        loop {
            let rest = &self.text[self.start..];
            self.start += span(rest, char::is_whitespace);
            let rest = &self.text[self.start..];
            if rest.starts_with("//") {
                self.start += span(rest, |c| c != '\n');
            } else if let Some(comment) = rest.strip_prefix("/*") {
                let Some(length) = comment.find("*/") else {
                    return Err(self.error(self.start, "a comment without its `*/`".into()));
                };
                self.start += length + 4;
            } else {
                self.end = self.start;
                return Ok(());
            }
        }
    }

    /// The length of the string that `rest` starts with, quotes included.
    fn string_length(&self, rest: &str) -> Result<usize, SceneError> {
        let mut escaped = false;
        for (i, byte) in rest.bytes().enumerate().skip(1) {
            match byte {
                _ if escaped => escaped = false,
                b'\\' => escaped = true,
                b'"' => return Ok(i + 1),
                _ => {}
            }
        }
        Err(self.error(self.start, "a string without its closing quote".into()))
    }

    /// The number that `rest` starts with, and its length.
    fn number(&self, rest: &str) -> Result<(Token<'a>, usize), SceneError> {
        let mut previous = 'e';
        let length = span(rest, |c| {
            let sign = matches!(c, '+' | '-') && matches!(previous, 'e' | 'E');
            previous = c;
            sign || c == '.' || c.is_ascii_alphanumeric()
        });
        let word = &rest[..length];
        match word.parse() {
            Ok(number) => Ok((Token::Number(number), length)),
            Err(_) => Err(self.error(self.start, format!("{word:?} is not a number"))),
        }
    }
}

/// What a string means: OpenSCAD writes quotes, backslashes, tabs and ends of
/// lines with a backslash before them; its language has characters by their numbers, too, of two,
/// four or six hexadecimal digits after `\x`, `\u` and `\U`.
pub(super) fn unescaped(text: &str) -> String {
    let mut meant = String::with_capacity(text.len());
    let mut characters = text.chars();
    while let Some(character) = characters.next() {
        match character {
            '\\' => match characters.next() {
                Some('n') => meant.push('\n'),
                Some('t') => meant.push('\t'),
                Some('r') => meant.push('\r'),
                Some(kind @ ('x' | 'u' | 'U')) => {
                    let digits = match kind {
                        'x' => 2,
                        'u' => 4,
                        _ => 6,
                    };
                    let rest = characters.as_str();
                    let number = rest.get(..digits).filter(|digits| is_hexadecimal(digits));
                    let number = number.and_then(|digits| u32::from_str_radix(digits, 16).ok());
                    match number.and_then(char::from_u32) {
                        Some(character) => {
                            meant.push(character);
                            characters = rest[digits..].chars();
                        }
                        None => meant.push(kind),
                    }
                }
                Some(other) => meant.push(other),
                None => {}
            },
            other => meant.push(other),
        }
    }
    meant
}

fn is_hexadecimal(text: &str) -> bool {
    text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// The length in bytes of the characters at the start that satisfy `is_in`.
fn span(text: &str, mut is_in: impl FnMut(char) -> bool) -> usize {
    text.find(|c| !is_in(c)).unwrap_or(text.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Vec<Token<'_>> {
        let mut lexer = Lexer::new(text).expect("a first token");
        let mut all = Vec::new();
        while lexer.peek() != Token::End {
            all.push(lexer.take().expect("a token"));
        }
        all
    }

    #[test]
    fn numbers_of_every_kind() {
        let text = "1 -2.5 .5 5. 1e-07 1E+3 -0 +4 inf -inf 0.1000000000000000055511151231257827";
        let wanted = [
            1.0,
            -2.5,
            0.5,
            5.0,
            1e-7,
            1e3,
            -0.0,
            4.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            0.1,
        ];
        let found = tokens(text);
        assert_eq!(found.len(), wanted.len());
        for (found, wanted) in found.iter().zip(wanted) {
            assert!(
                matches!(found, Token::Number(n) if n.to_bits() == wanted.to_bits()),
                "{found} is not {wanted}"
            );
        }
        for nan in ["nan", "-nan"] {
            assert!(matches!(tokens(nan)[..], [Token::Number(n)] if n.is_nan()));
        }
    }

    #[test]
    fn escapes_mean_what_they_stand_for() {
        assert_eq!(unescaped(r#"a\"b\\c\nd\te"#), "a\"b\\c\nd\te");
        assert_eq!(unescaped(r"\x41\u00c4\U01F600z"), "A\u{c4}\u{1f600}z");
        assert_eq!(
            unescaped(r"\u00g4 \x4 \ud800 \u+123"),
            "u00g4 x4 ud800 u+123"
        );
    }

    #[test]
    fn strings_comments_and_places() {
        assert_eq!(
            tokens("a = \"x \\\" ]\n\" // b\n/* c\n */ ,"),
            [
                Token::Name("a"),
                Token::Mark('='),
                Token::String("x \\\" ]\n"),
                Token::Mark(',')
            ]
        );
        for (text, line, column) in [
            ("\n  \"open", 2, 3),
            ("a\n/* open", 2, 1),
            ("é €", 1, 1),
            ("1..2", 1, 1),
            ("x !", 1, 3),
        ] {
            let error = Lexer::new(text).and_then(|mut lexer| {
                while lexer.take()? != Token::End {}
                Ok(())
            });
            let place = error.expect_err(text).place().cloned().expect("a place");
            assert_eq!((place.line, place.column), (line, column), "{text:?}");
        }
    }
}
