//! Where the solid touches itself: edges of several faces that join the same two
//! places. They are the same in all of these faces, and cut together, at the same
//! point: else the faces would run through each other.

use rustc_hash::FxHashMap;

/// Edges, by their ends in ascending order, that join the same two places as
/// others.
#[derive(Clone, Debug, Default)]
pub(super) struct Contacts {
    /// Of each edge its place in the list.
    pub place_of: FxHashMap<[u32; 2], u32>,
    /// For each two places all edges that join them, in ascending order.
    pub edges: Vec<Vec<[u32; 2]>>,
}

impl Contacts {
    pub fn is_empty(&self) -> bool {
        self.edges.is_empty()
    }

    /// All edges that join the same two places as one, itself among them; none if
    /// no other does.
    pub fn alike(&self, ends: [u32; 2]) -> &[[u32; 2]] {
        let place = self.place_of.get(&ends);
        place.map_or(&[], |&place| &self.edges[place as usize])
    }

    /// Sees to it that both parts of an edge that is cut stay as they are, too.
    pub fn cut(&mut self, ends: [u32; 2], vertex: u32) {
        if let Some(&place) = self.place_of.get(&ends) {
            let parts = ends.map(|end| ([end.min(vertex), end.max(vertex)], place));
            self.place_of.extend(parts);
        }
    }
}
