//! The page of `csg view` without a server: scenes are read, meshed and measured by the page
//! itself, as WebAssembly in a worker.
//!
//! [`Playground::answer`] is all there is; `build.sh` makes it a module with the functions of
//! [`Exports`](#exports), and puts the page beside it.
//!
//! # What a scene is written in
//! `.csg` alone. A script language beside it would be welcome if it were small: rhai 1.27 by
//! itself, without modules and as small as its features and the compiler make it
//! (`opt-level = "s"`, stripped), is a module of 2.16 MB, 0.32 MB by brotli. That would nearly
//! double a module of 2.4 MB (0.54 MB by brotli) whose every visitor loads it, and its numbers
//! are of two kinds, so that `sphere(2)` and `sphere(2.0)` are different functions. Python and
//! Rust have all of the modelling functions, and `csg view` shows models written in Rust, with
//! their parameters as sliders.
//!
//! # Exports
//! `reserve(length)` gives the address of a question of so many bytes, JSON as in [`Question`];
//! `ask()` answers it: 1, or 0 if it could not; `answer()` and `answer_length()` tell where the
//! bytes of the answer are, or the text that says why there is none. While a scene is made, the
//! import `host.published(address, length)` is called with what is to be drawn, first coarse,
//! then fine.

use csg::CancelToken;
use io::scene::{self, ReadOptions};
use serde::Deserialize;
use view::{Loaded, Pick, Problem, Settings, Shown, Subject, TextPlace, stages};

/// What may be asked.
#[derive(Debug, Deserialize)]
#[serde(tag = "ask", rename_all = "lowercase")]
pub enum Question {
    /// Read and mesh a scene; the answer is what is wrong with it (`view::Problem`), or null.
    Make {
        /// Its text.
        text: String,
    },
    /// Measures and report of what is shown.
    Account,
    /// What there is to say of a face, an edge or a vertex.
    Describe {
        /// Which.
        pick: Pick,
    },
    /// Distances and angles of two of them.
    Between {
        /// Which.
        picks: [Pick; 2],
    },
    /// The file of a format.
    File {
        /// Its extension.
        format: String,
    },
}

/// What is shown, and how often something else was before.
#[derive(Debug, Default)]
pub struct Playground {
    shown: Option<Shown>,
    revision: u64,
}

impl Playground {
    /// Answers a question; `publish` is handed what is to be drawn of a scene that is made.
    ///
    /// # Errors
    /// Why there is no answer, for people.
    pub fn answer(
        &mut self,
        question: &[u8],
        publish: &mut dyn FnMut(&[u8]),
    ) -> Result<Vec<u8>, String> {
        let question: Question = serde_json::from_slice(question).map_err(|e| e.to_string())?;
        let nothing = || "there is no such thing".to_owned();
        let shown = || {
            self.shown
                .as_ref()
                .ok_or_else(|| "nothing is shown yet".to_owned())
        };
        match question {
            Question::Make { text } => json(&self.make(&text, publish).err()),
            Question::Account => json(&shown()?.account()),
            Question::Describe { pick } => json(&shown()?.describe(pick).ok_or_else(nothing)?),
            Question::Between { picks } => json(&shown()?.between(picks).ok_or_else(nothing)?),
            Question::File { format } => shown()?.export(&format),
        }
    }

    fn make(&mut self, text: &str, publish: &mut dyn FnMut(&[u8])) -> Result<(), Problem> {
        let scene = scene::read(text, &ReadOptions::default()).map_err(|error| Problem {
            message: error.to_string(),
            place: error
                .place()
                .map(|place| TextPlace::of(text, place.line, place.column)),
        })?;
        let loaded = Loaded {
            subject: Subject::Solid(scene.solid),
            warnings: scene.warnings.iter().map(ToString::to_string).collect(),
        };
        let made = stages(
            "model",
            loaded,
            &Settings::default(),
            &CancelToken::new(),
            |mut shown| {
                self.revision += 1;
                shown.revision = self.revision;
                publish(&shown.pack());
                self.shown = Some(shown);
            },
        );
        // (Nobody cancels.)
        made.map_err(|problem| problem.unwrap_or_else(|| Problem::new("cancelled")))
    }
}

fn json(value: &impl serde::Serialize) -> Result<Vec<u8>, String> {
    serde_json::to_vec(value).map_err(|error| error.to_string())
}

#[cfg(target_family = "wasm")]
mod exports;
