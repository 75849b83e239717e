//! Finding the vertex at exactly a given place.

use glam::DVec3;

/// A hash table of vertex numbers, keyed by the vertices' places, which stay
/// with their owner: four bytes an entry, where a map of places to numbers
/// takes 32 and most of a reader's time.
#[derive(Default)]
pub(crate) struct Weld {
    /// A power of two of vertex numbers, probed one after another.
    slots: Vec<u32>,
    count: usize,
}

/// An empty slot.
const FREE: u32 = u32::MAX;

impl Weld {
    /// Makes room for that many vertices.
    pub(crate) fn reserve(&mut self, vertices: usize, places: &[DVec3]) {
        let needed = (2 * vertices).next_power_of_two();
        if needed <= self.slots.len() {
            return;
        }
        let old = std::mem::replace(&mut self.slots, vec![FREE; needed]);
        for vertex in old.into_iter().filter(|&vertex| vertex != FREE) {
            let slot = self.slot(places[vertex as usize], places);
            self.slots[slot] = vertex;
        }
    }

    /// The vertex at this place, or else `new`, which from now on is there.
    pub(crate) fn find_or_insert(&mut self, place: DVec3, new: u32, places: &[DVec3]) -> u32 {
        if 2 * self.count >= self.slots.len() {
            self.reserve((2 * self.count).max(512), places);
        }
        let slot = self.slot(place, places);
        if self.slots[slot] == FREE {
            self.slots[slot] = new;
            self.count += 1;
        }
        self.slots[slot]
    }

    /// The slot of the vertex at this place, or the free one for it.
    fn slot(&self, place: DVec3, places: &[DVec3]) -> usize {
        // Odd multipliers; the high bits are the well mixed ones. (0 and -0
        // are the same place.)
        let [x, y, z] = place.to_array().map(|x| (x + 0.0).to_bits());
        let mixed = x.wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ y.rotate_left(21).wrapping_mul(0xd1b5_4a32_d192_ed03)
            ^ z.rotate_left(42).wrapping_mul(0x8cb9_2ba7_2f3d_8dd7);
        let hash = (mixed ^ (mixed >> 32)).wrapping_mul(0xaef1_7502_108e_f2d9);
        let mut slot = (hash >> (64 - self.slots.len().ilog2())) as usize;
        while self.slots[slot] != FREE && places[self.slots[slot] as usize] != place {
            slot = (slot + 1) % self.slots.len();
        }
        slot
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn agrees_with_a_map_also_where_many_places_are_alike() {
        let mut weld = Weld::default();
        let mut places = Vec::new();
        let mut map: HashMap<[u64; 3], u32> = HashMap::new();
        for i in 0..40_000u32 {
            let [x, y, z] = [i % 7, i % 33, i / 100 % 200].map(f64::from);
            let place = DVec3::new(-x / 3.0, y * 1e-300, f64::from(z as f32 / 3.0));
            let key = place.to_array().map(|x| (x + 0.0).to_bits());
            let expected = *map.entry(key).or_insert(places.len() as u32);
            let found = weld.find_or_insert(place, places.len() as u32, &places);
            assert_eq!(found, expected);
            if found as usize == places.len() {
                places.push(place);
            }
        }
        assert!(places.len() > 10_000);
        assert_eq!(weld.find_or_insert(DVec3::ZERO, 7, &places), 0);
        assert_eq!(weld.find_or_insert(-DVec3::ZERO, 7, &places), 0);
    }
}
