//! Surfaces by number.

use std::ops::Index;

use super::Surface;

/// A surface of a program, by its number in the list of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct SurfaceId(pub u32);

impl SurfaceId {
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Index<SurfaceId> for [Surface] {
    type Output = Surface;

    #[inline]
    fn index(&self, id: SurfaceId) -> &Surface {
        &self[id.index()]
    }
}
