//! What is told of a drawing beside its shape.

use std::collections::HashMap;

/// More kinds of warnings than this help nobody.
const MOST: usize = 100;

/// Warnings, each once, with how often and where it is first.
#[derive(Default)]
pub(super) struct Warnings {
    of_problem: HashMap<String, usize>,
    all: Vec<(String, String, usize)>,
}

impl Warnings {
    /// The place is asked for only once.
    pub(super) fn add(&mut self, place: impl FnOnce() -> String, problem: String) {
        match self.of_problem.get(&problem) {
            Some(&k) => self.all[k].2 += 1,
            None if self.all.len() < MOST => {
                self.of_problem.insert(problem.clone(), self.all.len());
                self.all.push((place(), problem, 1));
            }
            None => {}
        }
    }

    pub(super) fn told(self) -> Vec<String> {
        let told = |(place, problem, count): (String, String, usize)| match count {
            1 => format!("{place}: {problem}"),
            _ => format!("{place}, and {} more: {problem}", count - 1),
        };
        self.all.into_iter().map(told).collect()
    }
}
