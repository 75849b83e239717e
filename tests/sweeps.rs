//! How much of a long sweep is tried.

/// One in so many of a sweep's cases, as a step between them or a divisor of how many are drawn; 1, for
/// all of them, with `STEREOTOMY_SWEEPS=whole`, as `.ci/run` has it. A step that has no divisor in
/// common with the periods of the kinds of cases leaves every kind in: 5 and 7 where there are four
/// grids, or one in three is turned.
///
/// # Panics
/// If the variable is anything else.
pub fn one_in(many: usize) -> usize {
    match std::env::var("STEREOTOMY_SWEEPS") {
        Err(std::env::VarError::NotPresent) => many,
        Ok(asked) if asked == "whole" => 1,
        asked => panic!("STEREOTOMY_SWEEPS is {asked:?}: set it to `whole`, or not at all"),
    }
}
