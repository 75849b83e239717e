//! Why a command ended early: message, cause, hint and exit code.

use std::error::Error;
use std::fmt;

/// The exit codes of every command.
pub mod exit_codes {
    /// Done.
    pub const SUCCESS: u8 = 0;
    /// What was compared differs.
    pub const DIFFERENT: u8 = 1;
    /// The command line does not make sense, or an option is out of range.
    pub const USAGE: u8 = 2;
    /// The input cannot be read, or is not what its name says.
    pub const INPUT: u8 = 3;
    /// The model is faulty: a bad argument of a node, no bounds, or nothing that could be written or
    /// drawn. (What is empty is measured and compared all the same.)
    pub const MODEL: u8 = 4;
    /// The output cannot be written.
    pub const OUTPUT: u8 = 5;
    /// The model is right but too large for this program, or for the limits
    /// that were given.
    pub const TOO_LARGE: u8 = 6;
    /// Ctrl-C was pressed.
    pub const INTERRUPTED: u8 = 130;
}

/// The table of [`exit_codes`] for `--help`.
pub(crate) const EXIT_CODES_HELP: &str = "\
Exit codes:
  0  done
  1  what was compared differs
  2  the command line does not make sense, or an option is out of range
  3  the input cannot be read, or is not what its name says
  4  the model is faulty: a bad argument of a node, no bounds, or nothing to write or draw
  5  the output cannot be written
  6  the model is too large for this program, or for the limits given
130  stopped by Ctrl-C";

/// An error on its way to the user.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) code: u8,
    /// What could not be done.
    context: String,
    /// Why not; says how to mend it where that depends on the cause.
    cause: Box<dyn Error>,
    hint: Option<&'static str>,
}

impl Failure {
    pub(crate) fn new(
        code: u8,
        context: impl Into<String>,
        cause: impl Into<Box<dyn Error>>,
    ) -> Self {
        Self {
            code,
            context: context.into(),
            cause: cause.into(),
            hint: None,
        }
    }

    pub(crate) fn hint(self, hint: &'static str) -> Self {
        Self {
            hint: Some(hint),
            ..self
        }
    }

    /// What went wrong as one text, without "error".
    #[cfg(feature = "view")]
    pub(crate) fn reason(&self) -> String {
        let text = self.to_string();
        text.strip_prefix("error: ").unwrap_or(&text).to_owned()
    }

    pub(crate) fn input(name: &str, cause: impl Into<Box<dyn Error>>) -> Self {
        Self::new(exit_codes::INPUT, format!("cannot read {name}"), cause)
    }

    pub(crate) fn output(name: &str, cause: impl Into<Box<dyn Error>>) -> Self {
        let cause = cause.into();
        let code = if is_of_nothing(&*cause) {
            exit_codes::MODEL
        } else {
            exit_codes::OUTPUT
        };
        Self::new(code, format!("cannot write {name}"), cause)
    }
}

/// Whether an error says that there is nothing to write.
fn is_of_nothing(error: &(dyn Error + 'static)) -> bool {
    let mut error = error.downcast_ref::<io::Error>();
    while let Some(io::Error::InFile { source, .. }) = error {
        error = Some(source);
    }
    matches!(
        error,
        Some(io::Error::EmptyMesh | io::Error::EmptySolid | io::Error::EmptyDrawing)
    )
}

impl From<csg::Error> for Failure {
    fn from(error: csg::Error) -> Self {
        let (code, context) = match &error {
            csg::Error::InvalidOption(_) => (exit_codes::USAGE, "an option is out of range"),
            csg::Error::TooLarge { .. } => (exit_codes::TOO_LARGE, "the model is too large"),
            csg::Error::LimitReached(_) => (exit_codes::TOO_LARGE, "a limit was reached"),
            csg::Error::Unbounded { .. } => (exit_codes::MODEL, "the model has no end"),
            _ => (exit_codes::MODEL, "the model is faulty"),
        };
        let hint = match &error {
            csg::Error::TooLarge { .. } => Some("fewer cells (--cells) make a smaller mesh"),
            csg::Error::LimitReached(_) => {
                Some("--partial writes what fits the limits, if anything does")
            }
            csg::Error::Unbounded { .. } => {
                Some("one unbounded operand of a union makes the whole unbounded")
            }
            _ => None,
        };
        Self {
            hint,
            ..Self::new(code, context, error)
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "error: {}", self.context)?;
        let mut cause: Option<&dyn Error> = Some(&*self.cause);
        let mut said = String::new();
        while let Some(error) = cause {
            let message = error.to_string();
            // Many errors repeat the message of the one below.
            if !said.contains(&message) {
                write!(f, "\n  cause: {message}")?;
                said = message;
            }
            cause = error.source();
        }
        if let Some(hint) = self.hint {
            write!(f, "\n  hint: {hint}")?;
        }
        Ok(())
    }
}
