//! How curves are measured.

use glam::DVec3;

use crate::program::Surface;

/// A curve measured in chords, with the vertices of a chain along it.
pub(super) trait Course {
    /// How many chords it takes, as a real number.
    fn chords(&self) -> f64;

    /// The share of all chords up to each vertex, the first and the last one
    /// included.
    fn shares(&self) -> Vec<f64>;

    /// The points that cut it into so many chords that stray alike; `None` if it
    /// could not be followed.
    fn points(&self, chords: u32) -> Option<Vec<DVec3>>;

    /// Whether all its chords are alike.
    fn is_even(&self) -> bool;

    /// Two surfaces that meet in it, for which a chord's distance is bounded
    /// best.
    fn surfaces(&self) -> [&Surface; 2];
}
