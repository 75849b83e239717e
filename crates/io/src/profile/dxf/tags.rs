//! Pairs of lines: a group code, and its value.

use super::fault;
use crate::Error;

/// A group code and its value.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tag<'a> {
    pub(super) code: i32,
    pub(super) value: &'a str,
    /// Of the value.
    pub(super) line: usize,
}

impl Tag<'_> {
    pub(super) fn number(&self) -> Result<f64, Error> {
        let number = self
            .value
            .parse::<f64>()
            .ok()
            .filter(|number| number.is_finite());
        number.ok_or_else(|| {
            let Self { code, value, line } = self;
            fault(
                *line,
                format!("{value:?} is not a number, as group {code} has"),
            )
        })
    }

    pub(super) fn whole(&self) -> Result<i64, Error> {
        // (Some programs write a point and zeros.)
        Ok(self.number()? as i64)
    }
}

pub(super) struct Tags<'a> {
    lines: std::str::Lines<'a>,
    line: usize,
    ahead: Option<Tag<'a>>,
}

impl<'a> Tags<'a> {
    pub(super) fn of(text: &'a str) -> Self {
        Self {
            lines: text.strip_prefix('\u{feff}').unwrap_or(text).lines(),
            line: 0,
            ahead: None,
        }
    }

    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// The next one but for comments.
    pub(super) fn next(&mut self) -> Result<Option<Tag<'a>>, Error> {
        if let Some(tag) = self.ahead.take() {
            return Ok(Some(tag));
        }
        loop {
            let Some(code) = self.lines.next() else {
                return Ok(None);
            };
            self.line += 1;
            let Some(value) = self.lines.next() else {
                // (Empty lines at the end are not missed.)
                if code.trim().is_empty() {
                    return Ok(None);
                }
                return Err(fault(
                    self.line,
                    "a group code has no value: the file is cut off",
                ));
            };
            self.line += 1;
            let Ok(code) = code.trim().parse::<i32>() else {
                let problem = format!(
                    "{:?} is not a group code",
                    code.trim().chars().take(40).collect::<String>()
                );
                return Err(fault(self.line - 1, problem));
            };
            if code != 999 {
                let value = value.trim();
                let line = self.line;
                return Ok(Some(Tag { code, value, line }));
            }
        }
    }

    /// Puts one back.
    pub(super) fn back(&mut self, tag: Tag<'a>) {
        self.ahead = Some(tag);
    }
}
