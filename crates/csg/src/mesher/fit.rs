//! What fits a limit: sizes are made larger until it does.

use crate::error::Error;
use crate::limits::{Limit, LimitReached};

/// Of a size that fits and one that does not, a factor of two apart, the mean is
/// tried so many times.
pub(super) const HALVINGS: u32 = 3;

/// Whether a limit other than that of time was reached: then less fits.
pub(super) fn is_too_much(error: &Error) -> Option<LimitReached> {
    match error {
        Error::LimitReached(reached) if !matches!(reached.limit, Limit::Time(_)) => Some(*reached),
        _ => None,
    }
}

/// What `work` makes of the size asked for, or, where that takes more than a
/// limit allows, of about the least size up to `most` that does not: found by
/// doubling, and then by so many halvings of the last factor. And if it is
/// another one, the limit that was reached.
///
/// # Errors
/// Those of `work`; that for the size asked for if even `most` takes too much.
pub(super) fn fit<T>(
    asked: f64,
    most: f64,
    halvings: u32,
    mut work: impl FnMut(f64) -> Result<T, Error>,
) -> Result<(T, Option<LimitReached>), Error> {
    let error = match work(asked) {
        Ok(made) => return Ok((made, None)),
        Err(error) => error,
    };
    let Some(reached) = is_too_much(&error) else {
        return Err(error);
    };
    let mut try_size = |size: f64| match work(size) {
        Err(error) if is_too_much(&error).is_some() => Ok(None),
        result => result.map(Some),
    };
    let mut too_small = asked;
    let (mut best, mut kept) = loop {
        if too_small >= most {
            return Err(error);
        }
        let size = (2.0 * too_small).min(most);
        match try_size(size)? {
            Some(made) => break (made, size),
            None => too_small = size,
        }
    };
    for _ in 0..halvings {
        let size = (too_small * kept).sqrt();
        match try_size(size)? {
            Some(made) => (best, kept) = (made, size),
            None => too_small = size,
        }
    }
    let reached = LimitReached {
        kept: Some(kept),
        ..reached
    };
    Ok((best, Some(reached)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Demand;

    fn reached(limit: Limit) -> Error {
        Error::LimitReached(LimitReached {
            limit,
            demand: Demand::ExactBoundary,
            kept: None,
        })
    }

    #[test]
    fn the_least_size_that_fits_is_found_to_a_tenth() {
        for least in [1.0, 1.3, 3.0, 50.0, 999.0] {
            let work = |size: f64| {
                if size >= least {
                    Ok(size)
                } else {
                    Err(reached(Limit::Cells(1)))
                }
            };
            let (made, reached) = fit(1.0, 1000.0, HALVINGS, work).expect("a size");
            assert!((least..1.1 * least).contains(&made), "{least}: {made}");
            assert_eq!(reached.is_some(), least > 1.0);
            assert!(reached.is_none_or(|r| r.kept == Some(made)));
            assert!(fit(1.0, 0.9 * least, 0, work).is_err() || least == 1.0);
        }
    }

    #[test]
    fn other_errors_end_the_search() {
        for error in [reached(Limit::Time(Default::default())), Error::Cancelled] {
            let mut calls = 0;
            let result = fit(1.0, 8.0, HALVINGS, |_| {
                calls += 1;
                Err::<(), _>(error.clone())
            });
            assert_eq!((result, calls), (Err(error), 1));
        }
    }
}
