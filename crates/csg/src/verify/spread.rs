//! Points spread evenly.

use glam::DVec3;

/// Points of the unit cube, each far from those before (Roberts's additive recurrence,
/// *The Unreasonable Effectiveness of Quasirandom Sequences*, 2018).
pub(super) struct Spread(DVec3);

impl Default for Spread {
    fn default() -> Self {
        Self(DVec3::splat(0.5))
    }
}

impl Spread {
    pub fn next(&mut self) -> DVec3 {
        /// Powers of 1 / g, where g⁴ = g + 1.
        const STEP: DVec3 = DVec3::new(
            0.819_172_513_396_164_4,
            0.671_043_606_703_789_2,
            0.549_700_477_901_970_1,
        );
        self.0 = (self.0 + STEP).fract();
        self.0
    }
}
