//! Random solids by classes: how many are right, reported, wrong, slow or refused.

use std::path::PathBuf;
use std::time::Duration;

use rayon::prelude::*;

use super::classes::{Class, primitives};
use super::trial::{self, Outcome};

/// Processor time that is too much for any of them, in seconds.
const SLOW: f64 = 5.0;

/// What to try.
pub struct Trials {
    pub classes: Vec<Class>,
    /// Of the first solid of each class.
    pub seed: u64,
    pub count: u64,
    pub tolerance: f64,
    /// For one solid, judged and all.
    pub limit: Duration,
    /// Where the solids that fail are stored.
    pub write: Option<PathBuf>,
}

/// Prints every failure with its seed, and a table.
pub fn run(trials: &Trials) {
    let rows = trials
        .classes
        .iter()
        .map(|&class| (class, tried(trials, class)));
    let rows: Vec<(Class, Vec<(u64, Outcome)>)> = rows.collect();
    println!();
    println!(
        "| class | tried | reported | of these wrong | silently wrong | slow (> {SLOW} s) | \
         of these no answer | refused, though not empty | surfaces moved | longest |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for (class, outcomes) in &rows {
        let count = |test: &dyn Fn(&Outcome) -> bool| {
            outcomes.iter().filter(|(_, outcome)| test(outcome)).count()
        };
        let longest = outcomes.iter().map(|(_, o)| o.seconds).fold(0.0, f64::max);
        println!(
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {longest:.2} s |",
            format!("{class:?}").to_lowercase(),
            outcomes.len(),
            count(&|o| !o.reported.is_empty()),
            count(&|o| !o.reported.is_empty() && !o.faults.is_empty()),
            count(&|o| o.reported.is_empty() && !o.faults.is_empty()),
            count(&|o| o.seconds > SLOW),
            count(&|o| o.ended),
            count(&|o| !o.ended && o.refused.is_some()),
            count(&|o| o.moved),
        );
    }
}

fn tried(trials: &Trials, class: Class) -> Vec<(u64, Outcome)> {
    (trials.seed..trials.seed + trials.count)
        .into_par_iter()
        .map(|seed| {
            let outcome = trial::apart(class, seed, trials.tolerance, trials.limit);
            let words = words(&outcome);
            if !words.is_empty() {
                let count = primitives(&class.solid(seed));
                println!(
                    "{class:?} {seed} ({count} primitives): {}",
                    words.join("; ")
                );
            }
            if let Some(folder) = &trials.write
                && (!words.is_empty() || outcome.moved)
            {
                trial::write(class, seed, folder);
            }
            (seed, outcome)
        })
        .collect()
}

/// What is to be said of a solid, if anything.
fn words(outcome: &Outcome) -> Vec<String> {
    let mut words = Vec::new();
    if let Some(refused) = &outcome.refused {
        words.push(format!("no mesh: {refused}"));
    }
    let label = if outcome.reported.is_empty() {
        "SILENTLY WRONG"
    } else {
        "wrong"
    };
    words.extend(
        outcome
            .faults
            .iter()
            .map(|fault| format!("{label}: {fault}")),
    );
    words.extend(
        outcome
            .reported
            .iter()
            .map(|what| format!("reported: {what}")),
    );
    if outcome.seconds > SLOW {
        words.push(format!("slow: {:.1} s", outcome.seconds));
    }
    if !words.is_empty() {
        let why = outcome.undecided.iter().map(|what| format!("why: {what}"));
        words.extend(why);
    }
    words
}
