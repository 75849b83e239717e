//! What is named by its place in a list.

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub(crate) struct $name(pub u32);

        impl $name {
            #[inline]
            pub fn index(self) -> usize {
                self.0 as usize
            }

            /// Those of a list that is so long.
            pub fn all(count: usize) -> impl DoubleEndedIterator<Item = Self> + Clone {
                (0..count as u32).map(Self)
            }
        }
    )*};
}

ids! {
    /// A surface of a block, among those that matter in it: literals of the block's formula
    /// name it so.
    Position
    /// A half-edge of a boundary.
    HalfEdgeId
    /// A vertex of a boundary.
    VertexId
    /// A face of a boundary: a patch of a surface, which may have several parts.
    FaceId
}
