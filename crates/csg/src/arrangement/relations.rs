//! What the surfaces of a scene have in common, two of them or three, each decided once:
//! whatever block, chord or boundary asks is told the same, and only the first that asks
//! waits for it.

use std::hash::{BuildHasher, Hash};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use rustc_hash::{FxBuildHasher, FxHashMap};

use super::ball::Touching;
use super::curve::{Branch, Meets};
use super::intersection::Unknown;
use super::piece::CurveId;
use super::roots::Roots;
use crate::program::SurfaceId;

/// The curves of two surfaces, or why they are not known.
pub(super) type Common = Result<Arc<[Branch]>, Arc<Unknown>>;

/// What has been asked for so far.
#[derive(Default)]
pub(super) struct Relations {
    /// By the first of the curves.
    pub pairs: Table<CurveId, Common>,
    /// By three surfaces, ascending.
    pub triples: Table<[SurfaceId; 3], Arc<[Touching]>>,
    /// The same of where they cross at small sines.
    pub crossings: Table<[SurfaceId; 3], Arc<[DVec3]>>,
    /// By a curve and a third surface.
    pub meetings: Table<(CurveId, SurfaceId), Arc<Meeting>>,
}

/// Where a surface meets all of a curve.
pub(super) struct Meeting {
    pub meets: Meets,
    pub roots: Roots,
}

/// A map that several threads fill, in parts so that they seldom wait for each other.
pub(super) struct Table<K, V>([Mutex<FxHashMap<K, V>>; PARTS]);

/// Tunes speed only.
const PARTS: usize = 64;

impl<K, V> Default for Table<K, V> {
    fn default() -> Self {
        Self(std::array::from_fn(|_| Mutex::default()))
    }
}

impl<K: Copy + Eq + Hash, V: Clone> Table<K, V> {
    /// What is known, or else what is decided now. Two threads may decide at once, and
    /// alike.
    pub fn get(&self, key: K, decide: impl FnOnce() -> V) -> V {
        let known = self.part(key).get(&key).cloned();
        known.unwrap_or_else(|| {
            let decided = decide();
            self.part(key).entry(key).or_insert(decided).clone()
        })
    }

    fn part(&self, key: K) -> MutexGuard<'_, FxHashMap<K, V>> {
        // The lower bits are the map's own.
        let part = FxBuildHasher.hash_one(key) >> 40;
        let part = &self.0[part as usize % PARTS];
        part.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
