//! Numbers with bounds on their errors.

/// A number that is known to within a bound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounded {
    /// The number.
    pub value: f64,
    /// It is off by no more: by what refining it once more changed, and rounding.
    pub error: f64,
}

impl Bounded {
    /// The least that it may be.
    #[must_use]
    pub fn lower(&self) -> f64 {
        self.value - self.error
    }

    /// The most that it may be.
    #[must_use]
    pub fn upper(&self) -> f64 {
        self.value + self.error
    }
}
