//! Finding the vertices at exactly the same places.
//!
//! Places come in blocks. Each block is welded by itself, in a table that
//! stays in the cache; neighbours in a file are mostly neighbours in space,
//! so that few doubles are left. Those are found in tables that share the
//! places out by their hashes. Both steps run in parallel, and vertices are
//! numbered in the order of their first appearance, whatever the number of
//! threads.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Places per block: the tables of a block fit the second level cache.
pub(crate) const BLOCK: usize = 3 << 12;

/// Bits of a key that number a place within its block.
const PLACE_BITS: u32 = 14;

/// Welds the places of all blocks: returns the distinct ones in the order of
/// first appearance, and puts into `numbers` which of them each place is.
/// `lengths` says how many there are in each block, at most [`BLOCK`]; `fill`
/// appends those of one block (all of them finite), and reports what is wrong
/// with them.
///
/// `Ok(None)` if there are too many to number.
///
/// # Errors
/// That of the first block whose `fill` fails.
pub(crate) fn weld<P: Place, E: Send>(
    numbers: &mut [u32],
    lengths: &[usize],
    fill: impl Fn(usize, &mut Vec<P>) -> Result<(), E> + Sync,
) -> Result<Option<Vec<DVec3>>, E> {
    if lengths.len() >= 1 << (32 - PLACE_BITS) {
        return Ok(None);
    }
    let blocks: Result<Vec<Block<P>>, E> = split(numbers, lengths.iter().copied())
        .into_par_iter()
        .enumerate()
        .map_init(Scratch::<P>::default, |scratch, (index, numbers)| {
            scratch.places.clear();
            fill(index, &mut scratch.places)?;
            Ok(scratch.weld(numbers))
        })
        // (Not straight into a `Result`, which would keep any error.)
        .collect::<Vec<_>>()
        .into_iter()
        .collect();
    let blocks = blocks?;
    let place = |key: u32| blocks[(key >> PLACE_BITS) as usize].place(key);

    // Doubles between blocks, as pairs of keys, the earlier one first. The
    // low bits of hashes share them out, the high bits find their slots.
    let shares = rayon::current_num_threads().next_power_of_two();
    let doubles: Vec<Vec<(u32, u32)>> = (0..shares)
        .into_par_iter()
        .map(|share| {
            let mut table = Table::default();
            let mut doubles = Vec::new();
            let hashes: usize = blocks.iter().map(|block| block.hashes.len()).sum();
            table.reserve(hashes / shares + hashes / 16, |key| {
                blocks[(key >> PLACE_BITS) as usize].hash(key)
            });
            let mut own: Vec<(u64, u32)> = Vec::new();
            for (block, first) in blocks.iter().zip((0u32..).step_by(1 << PLACE_BITS)) {
                // (Picked out first: a branch that nobody foresees would keep
                // the processor from looking up several at once.)
                own.resize(block.hashes.len(), (0, 0));
                let mut count = 0;
                for (&hash, key) in block.hashes.iter().zip(first..) {
                    own[count] = (hash, key);
                    count += usize::from(hash as usize % shares == share);
                }
                for &(hash, key) in &own[..count] {
                    let at = place(key);
                    let same = |other: u32| place(other) == at;
                    let hash_of = |key: u32| blocks[(key >> PLACE_BITS) as usize].hash(key);
                    let found = table.find_or_insert(hash, key, same, hash_of);
                    if found != key {
                        doubles.push((found, key));
                    }
                }
            }
            doubles
        })
        .collect();

    let mut own: Vec<usize> = blocks.iter().map(|block| block.places.len()).collect();
    let starts = running_sum(&own);
    let index = |key: u32| {
        let within = key as usize % (1 << PLACE_BITS);
        starts[(key >> PLACE_BITS) as usize] + within
    };
    // The vertex of each block's place; doubles come last.
    const DOUBLE: u32 = u32::MAX;
    let mut vertices = vec![0u32; blocks.iter().map(|block| block.places.len()).sum()];
    for &(_, key) in doubles.iter().flatten() {
        vertices[index(key)] = DOUBLE;
        own[(key >> PLACE_BITS) as usize] -= 1;
    }
    let total: usize = own.iter().sum();
    if total >= DOUBLE as usize {
        return Ok(None);
    }
    // (Zeros from the system, which the threads touch first; `vec!` would write
    // them here.)
    let mut positions: Vec<DVec3> = bytemuck::zeroed_vec(total);
    split(&mut positions, own.iter().copied())
        .into_par_iter()
        .zip(split(&mut vertices, blocks.iter().map(|b| b.places.len())))
        .zip(&blocks)
        .zip(running_sum(&own))
        .for_each(|(((positions, vertices), block), first)| {
            let mut count = 0;
            for (vertex, &place) in vertices.iter_mut().zip(&block.places) {
                if *vertex != DOUBLE {
                    *vertex = (first + count) as u32;
                    positions[count] = place.position();
                    count += 1;
                }
            }
        });
    for &(earlier, later) in doubles.iter().flatten() {
        vertices[index(later)] = vertices[index(earlier)];
    }
    split(numbers, lengths.iter().copied())
        .into_par_iter()
        .zip(&starts)
        .for_each(|(numbers, &start)| {
            for number in numbers {
                *number = vertices[start + *number as usize];
            }
        });
    Ok(Some(positions))
}

/// Cuts a slice into pieces of the given lengths.
pub(crate) fn split<T>(mut rest: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    let cut = |length| rest.split_off_mut(..length).unwrap_or_default();
    lengths.map(cut).collect()
}

/// The sums of the lengths before each.
fn running_sum(lengths: &[usize]) -> Vec<usize> {
    lengths
        .iter()
        .scan(0, |sum, length| {
            let before = *sum;
            *sum += length;
            Some(before)
        })
        .collect()
}

/// A place in single or in double precision, as files have it: half the bytes
/// are half the time.
pub(crate) trait Place: Copy + Default + PartialEq + Send + Sync {
    /// Bits that are equal where places are. (0 and -0 are the same place.)
    fn bits(self) -> [u64; 3];
    fn position(self) -> DVec3;
}

impl Place for Vec3 {
    fn bits(self) -> [u64; 3] {
        self.to_array().map(|x| u64::from((x + 0.0).to_bits()))
    }

    fn position(self) -> DVec3 {
        self.as_dvec3()
    }
}

impl Place for DVec3 {
    fn bits(self) -> [u64; 3] {
        self.to_array().map(|x| (x + 0.0).to_bits())
    }

    fn position(self) -> DVec3 {
        self
    }
}

/// The distinct places of one block, in the order of first appearance.
struct Block<P> {
    places: Vec<P>,
    hashes: Vec<u64>,
}

impl<P: Place> Block<P> {
    fn place(&self, key: u32) -> P {
        self.places[key as usize % (1 << PLACE_BITS)]
    }

    fn hash(&self, key: u32) -> u64 {
        self.hashes[key as usize % (1 << PLACE_BITS)]
    }
}

/// What a thread needs to weld a block.
#[derive(Default)]
struct Scratch<P> {
    places: Vec<P>,
    table: Table,
}

impl<P: Place> Scratch<P> {
    fn weld(&mut self, numbers: &mut [u32]) -> Block<P> {
        self.table.clear();
        self.table.reserve(BLOCK / 4, |_| 0);
        let mut block = Block {
            places: Vec::with_capacity(self.places.len() / 4),
            hashes: Vec::with_capacity(self.places.len() / 4),
        };
        for (number, &place) in numbers.iter_mut().zip(&self.places) {
            let hash = hash(place);
            let new = block.places.len() as u32;
            let same = |other: u32| block.places[other as usize] == place;
            let hash_of = |other: u32| block.hashes[other as usize];
            *number = self.table.find_or_insert(hash, new, same, hash_of);
            if *number == new {
                block.places.push(place);
                block.hashes.push(hash);
            }
        }
        block
    }
}

/// A well mixed number for each place.
fn hash(place: impl Place) -> u64 {
    let [x, y, z] = place.bits();
    // Odd multipliers.
    let mixed = x.wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ y.rotate_left(21).wrapping_mul(0xd1b5_4a32_d192_ed03)
        ^ z.rotate_left(42).wrapping_mul(0x8cb9_2ba7_2f3d_8dd7);
    let mixed = (mixed ^ (mixed >> 32)).wrapping_mul(0xaef1_7502_108e_f2d9);
    mixed ^ (mixed >> 29)
}

/// A hash table of keys, whose places stay with their owner: four bytes an
/// entry, where a map of places to numbers takes 32 and most of a reader's
/// time.
#[derive(Default)]
struct Table {
    /// A power of two of keys, probed one after another.
    slots: Vec<u32>,
    count: usize,
}

/// An empty slot.
const FREE: u32 = u32::MAX;

impl Table {
    fn clear(&mut self) {
        self.slots.fill(FREE);
        self.count = 0;
    }

    /// Makes room for that many keys; `hash_of` is asked for those inside.
    fn reserve(&mut self, keys: usize, hash_of: impl Fn(u32) -> u64) {
        let needed = (2 * keys).max(512).next_power_of_two();
        if needed <= self.slots.len() {
            return;
        }
        let old = std::mem::replace(&mut self.slots, vec![FREE; needed]);
        for key in old.into_iter().filter(|&key| key != FREE) {
            let slot = self.slot(hash_of(key), |_| false);
            self.slots[slot] = key;
        }
    }

    /// The key for which `same` holds, or else `new`, which goes in.
    fn find_or_insert(
        &mut self,
        hash: u64,
        new: u32,
        same: impl Fn(u32) -> bool,
        hash_of: impl Fn(u32) -> u64,
    ) -> u32 {
        if 2 * self.count >= self.slots.len() {
            self.reserve(2 * self.count, hash_of);
        }
        let slot = self.slot(hash, same);
        if self.slots[slot] == FREE {
            self.slots[slot] = new;
            self.count += 1;
        }
        self.slots[slot]
    }

    /// The slot of the key for which `same` holds, or the free one for it.
    fn slot(&self, hash: u64, same: impl Fn(u32) -> bool) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = (hash >> 32) as usize & mask;
        while self.slots[slot] != FREE && !same(self.slots[slot]) {
            slot = (slot + 1) & mask;
        }
        slot
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;
    use std::convert::Infallible;

    use super::*;

    /// The distinct places, and which of them each place is.
    fn welded(places: &[DVec3], length: usize) -> (Vec<DVec3>, Vec<u32>) {
        let lengths: Vec<usize> = places.chunks(length).map(<[DVec3]>::len).collect();
        let fill = |block: usize, to: &mut Vec<DVec3>| {
            to.extend(&places[block * length..][..lengths[block]]);
            Ok::<(), Infallible>(())
        };
        let mut numbers = vec![0; places.len()];
        let Ok(distinct) = weld(&mut numbers, &lengths, fill);
        (distinct.expect("not too many"), numbers)
    }

    #[test]
    fn agrees_with_a_map_also_where_many_places_are_alike() {
        let places: Vec<DVec3> = (0..40_000u32)
            .map(|i| {
                let [x, y, z] = [i % 7, i % 33, i / 100 % 200].map(f64::from);
                DVec3::new(-x / 3.0, y * 1e-300, f64::from(z as f32 / 3.0))
            })
            .collect();
        let mut map: HashMap<[u64; 3], u32> = HashMap::new();
        let mut positions = Vec::new();
        let numbers: Vec<u32> = places
            .iter()
            .map(|place| {
                let key = place.to_array().map(|x| (x + 0.0).to_bits());
                *map.entry(key).or_insert_with(|| {
                    positions.push(*place);
                    positions.len() as u32 - 1
                })
            })
            .collect();
        assert!(positions.len() > 10_000);
        for length in [1, 100, BLOCK] {
            let found = welded(&places, length);
            assert_eq!(found.0, positions, "{length}");
            assert_eq!(found.1, numbers, "{length}");
        }
    }

    #[test]
    fn both_zeros_are_one_place() {
        let found = welded(&[DVec3::ZERO, DVec3::ONE, -DVec3::ZERO], 1);
        assert_eq!(found.0, [DVec3::ZERO, DVec3::ONE]);
        assert_eq!(found.1, [0, 1, 0]);
    }

    #[test]
    fn the_first_error_counts() {
        let fill = |block: usize, to: &mut Vec<DVec3>| {
            to.push(DVec3::ZERO);
            if block % 3 == 2 { Err(block) } else { Ok(()) }
        };
        assert_eq!(weld(&mut [0; 100], &[1; 100], fill).err(), Some(2));
    }
}
