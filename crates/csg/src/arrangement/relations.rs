//! What the surfaces of a scene have in common, two of them or three, each decided once:
//! whatever block, chord or boundary asks is told the same, and only the first that asks
//! waits for it.

use std::hash::BuildHasher;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rustc_hash::{FxBuildHasher, FxHashMap};

use super::curve::{Branch, Curve};
use super::intersection::Unknown;
use super::pairs::curves;
use super::piece::CurveId;
use super::scene::Scene;
use super::triple::{Ball, contacts};

/// The curves of two surfaces, or why they are not known.
pub(super) type Common = Result<Arc<[Branch]>, Arc<Unknown>>;

/// What has been asked for so far.
#[derive(Default)]
pub(super) struct Relations {
    /// By the numbers of two surfaces, or one and [`super::piece::NOTHING`], and a seam.
    pairs: Table<Common>,
    /// By three surfaces, ascending.
    triples: Table<Arc<[Ball]>>,
}

impl Scene<'_> {
    /// The curves common to two surfaces, by number, or, if the second is
    /// [`super::piece::NOTHING`], to the first and one of its seams.
    pub fn common(&self, [first, second]: [u32; 2], seam: u16) -> Common {
        let decide = || {
            let one = &self.surfaces[first as usize];
            let other = self.surfaces.get(second as usize).or_else(|| {
                let frame = self.frames[first as usize].as_ref()?;
                frame.seams.get(seam as usize)
            });
            let other = other.ok_or_else(|| Arc::new(Unknown::NoForm))?;
            let common = curves(one, other, self.near).map_err(Arc::new)?;
            Ok(common.into_iter().collect())
        };
        let key = [first, second, u32::from(seam)];
        self.relations.pairs.get(key, decide)
    }

    /// A curve by its name; none would be a mistake.
    pub fn curve(&self, id: CurveId) -> Option<Curve> {
        let common = self.common(id.surfaces, id.seam).ok()?;
        let branch = common.get(id.branch as usize)?;
        Some(branch.curve.clone())
    }

    /// Where three surfaces touch: in each ball is one point of all three, its centre. The
    /// same in whatever order they are named.
    pub fn contacts(&self, mut ids: [u32; 3]) -> Arc<[Ball]> {
        ids.sort_unstable();
        let decide = || contacts(self, ids).into_iter().collect();
        self.relations.triples.get(ids, decide)
    }
}

/// A map that several threads fill, in parts so that they seldom wait for each other.
struct Table<V>([Mutex<FxHashMap<[u32; 3], V>>; PARTS]);

/// Tunes speed only.
const PARTS: usize = 64;

impl<V> Default for Table<V> {
    fn default() -> Self {
        Self(std::array::from_fn(|_| Mutex::default()))
    }
}

impl<V: Clone> Table<V> {
    /// What is known, or else what is decided now. Two threads may decide at once, and
    /// alike.
    fn get(&self, key: [u32; 3], decide: impl FnOnce() -> V) -> V {
        let known = self.part(key).get(&key).cloned();
        known.unwrap_or_else(|| {
            let decided = decide();
            self.part(key).entry(key).or_insert(decided).clone()
        })
    }

    fn part(&self, key: [u32; 3]) -> MutexGuard<'_, FxHashMap<[u32; 3], V>> {
        // The lower bits are the map's own.
        let part = FxBuildHasher.hash_one(key) >> 40;
        let part = &self.0[part as usize % PARTS];
        part.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
