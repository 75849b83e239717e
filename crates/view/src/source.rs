//! What is viewed, and where it comes from.

use std::collections::BTreeMap;
use std::path::Path;

use csg::{Mesh, Solid};
use serde::Serialize;

/// A model that can be made again: of its file, or with other parameters.
pub trait Source {
    /// What it is called: a file's name without its extension, say.
    fn name(&self) -> String;

    /// What may be changed on the page.
    fn parameters(&self) -> Vec<Parameter> {
        Vec::new()
    }

    /// The file that it is read from: it is watched, and the model made again when it
    /// changes.
    fn file(&self) -> Option<&Path> {
        None
    }

    /// Makes the model, with these values of parameters as text by name; those that are not
    /// named have their defaults.
    ///
    /// # Errors
    /// What the page shows in place of the model.
    fn load(&mut self, values: &BTreeMap<String, String>) -> Result<Loaded, Problem>;
}

/// A model as it was made.
#[derive(Debug)]
pub struct Loaded {
    /// The model.
    pub subject: Subject,
    /// What the reader has to say of it.
    pub warnings: Vec<String>,
}

/// What can be looked at.
#[derive(Debug)]
pub enum Subject {
    /// A solid, still to be meshed.
    Solid(Solid),
    /// A mesh, as it was read.
    Mesh(Mesh),
}

/// Why there is no model.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// What is wrong, and how to mend it.
    pub message: String,
    /// Where in the text, if it is a text.
    pub place: Option<TextPlace>,
}

impl Problem {
    /// One without a place.
    pub fn new(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            place: None,
        }
    }
}

/// A place in a text, with the line that stands there.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TextPlace {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The lines around, the first of them with its number.
    pub excerpt: Vec<(usize, String)>,
}

impl TextPlace {
    /// Lines that are shown on either side.
    const AROUND: usize = 2;
    /// Characters of a line that are shown.
    const LONGEST: usize = 200;

    /// The place in this text.
    #[must_use]
    pub fn of(text: &str, line: usize, column: usize) -> Self {
        let first = line.saturating_sub(1 + Self::AROUND);
        let lines = text.lines().enumerate().skip(first);
        let shown = lines.take(line + Self::AROUND - first);
        Self {
            line,
            column,
            excerpt: shown
                .map(|(k, text)| (k + 1, text.chars().take(Self::LONGEST).collect()))
                .collect(),
        }
    }
}

/// What can be changed of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name, by which values are given.
    pub name: String,
    /// What it is, for people.
    pub help: String,
    /// What it is unless given, as text.
    pub default: String,
    /// What values it takes.
    #[serde(flatten)]
    pub kind: ParameterKind,
}

/// What values a parameter takes.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum ParameterKind {
    /// Any number.
    Number,
    /// A whole number.
    Integer,
    /// `true` or `false`.
    Flag,
    /// One of these.
    Choice {
        /// What there is to choose from.
        choices: Vec<String>,
    },
    /// Any text.
    Text,
}
