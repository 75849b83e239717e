//! The small triangles of faces.

use glam::DVec3;

/// Marks vertices on the sides of large triangles: the rest is their number in
/// [`Fine::points`].
pub(super) const ON_SIDE: u32 = 1 << 31;

/// Marks vertices inside of large triangles: the rest is their number in
/// [`Subdivision::inner`].
pub(super) const INNER: u32 = 1 << 30;

/// The small triangles of faces.
#[derive(Default)]
pub(super) struct Fine {
    /// Those on sides, not all of which are in use.
    pub points: Vec<DVec3>,
    pub subdivisions: Vec<Subdivision>,
}

/// A large triangle and its small ones.
#[derive(Default)]
pub(super) struct Subdivision {
    /// Its number in the half-edge mesh.
    pub large: u32,
    pub inner: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// The largest bound of a small triangle's distance; infinite if one is
    /// folded.
    pub deviation: f64,
    pub farthest: DVec3,
    pub is_folded: bool,
    /// Whether it is not what it should be by now.
    pub is_stale: bool,
}
