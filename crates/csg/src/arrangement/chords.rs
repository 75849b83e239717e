//! How curves are cut into chords for a mesh of the right topology.

use super::scene::Scene;
use crate::program::Surface;
use crate::undecided::Stop;

/// How long chords are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    /// By how much they turn at most, about, in radians.
    pub turn: f64,
    /// How far those may stray from their curves that go on past sides of blocks.
    pub stray: f64,
}

/// Series of chords, of which the first that will do are taken.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chords {
    /// By how much they turn; by less where faces cannot be cut into triangles so.
    turns: &'static [f64],
    /// Whether the first of them go on past sides of blocks, as far as the tolerance lets them: so
    /// they are no more along narrow faces, where blocks are small, than along others.
    go_on: bool,
}

impl Chords {
    pub const LONG: Self = Self {
        turns: &[0.53, 0.2, 0.06],
        go_on: true,
    };

    /// Where faces are so narrow that long chords are in each other's way.
    pub const SHORT: Self = Self {
        turns: &[0.1, 0.03],
        go_on: false,
    };

    /// And where these are, too.
    pub const SHORTEST: Self = Self {
        turns: &[0.03, 0.01],
        go_on: false,
    };

    /// What comes of the first that will do, for a tolerance; of planes alone there are none.
    pub(super) fn first_of<T>(
        &self,
        scene: &Scene<'_>,
        tolerance: f64,
        mut evaluate: impl FnMut(Option<Chord>) -> Result<T, Stop>,
    ) -> Result<T, Stop> {
        if scene.surfaces.iter().all(Surface::is_plane) {
            return evaluate(None);
        }
        let mut undecided = Stop::Halted;
        let mut strays = self.go_on.then_some(tolerance).into_iter();
        for &turn in self.turns {
            scene.go_on()?;
            let stray = strays.next().unwrap_or(0.0);
            match evaluate(Some(Chord { turn, stray })) {
                Err(stop @ Stop::Undecided(_)) => undecided = stop,
                result => return result,
            }
        }
        Err(undecided)
    }
}
