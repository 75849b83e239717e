//! Large buffers, backed by huge pages where the system has them.
//!
//! A fresh page costs about 2 µs at its first touch, whatever the system
//! does besides clearing it: for a mesh of 56 bytes a surface cell that is a
//! third of the time that meshing takes. A huge page holds 512 of them.
#![allow(unsafe_code)]

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Bytes in a huge page.
const HUGE: usize = 2 << 20;

/// What the allocator puts before a buffer of its own mapping, and more.
const HEADER: usize = 64;

/// Items with which a large buffer fills whole huge pages, at least `len`.
fn whole<T>(len: usize) -> usize {
    ((len * size_of::<T>() + HEADER).next_multiple_of(HUGE) - HEADER) / size_of::<T>()
}

/// Makes room for `len` items altogether in a buffer.
pub(crate) fn reserve<T>(buffer: &mut Vec<T>, len: usize) {
    let is_large = len * size_of::<T>() >= HUGE / 2;
    let wanted = if is_large { whole::<T>(len) } else { len };
    if buffer.capacity() < wanted {
        buffer.reserve_exact(wanted - buffer.len());
        if is_large {
            prefer_huge_pages(buffer.spare_capacity_mut());
        }
    }
}

/// Adds `additional` items to a buffer, which `write` puts into the room that
/// it is given, piece by piece, from whatever threads.
///
/// # Panics
/// If it left some out.
pub(crate) fn extend<T: Copy, R>(
    buffer: &mut Vec<T>,
    additional: usize,
    write: impl FnOnce(Room<'_, T>) -> R,
) -> R {
    buffer.reserve(additional);
    let written = AtomicUsize::new(0);
    let room = Room {
        items: &mut buffer.spare_capacity_mut()[..additional],
        count: 0,
        written: &written,
    };
    let result = write(room);
    assert_eq!(written.into_inner(), additional, "items that nobody wrote");
    // SAFETY: rooms share no items, and each counts those that it wrote, once:
    // all of the additional ones are there.
    unsafe { buffer.set_len(buffer.len() + additional) };
    result
}

/// Memory for items that are yet to be written, in order.
pub(crate) struct Room<'a, T> {
    /// What is left of it.
    items: &'a mut [MaybeUninit<T>],
    /// How many were written.
    count: usize,
    /// The same of all rooms together, of those that are gone.
    written: &'a AtomicUsize,
}

impl<T: Copy> Room<'_, T> {
    /// Takes the room for the next `len` items.
    pub(crate) fn split(&mut self, len: usize) -> Self {
        Self {
            items: self.next(len),
            count: 0,
            written: self.written,
        }
    }

    /// Writes the next items.
    #[inline]
    pub(crate) fn copy(&mut self, items: &[T]) {
        self.next(items.len()).write_copy_of_slice(items);
        self.count += items.len();
    }

    /// Writes the next `2 * count` items, pair by pair.
    #[inline(always)]
    pub(crate) fn pairs(&mut self, count: usize, mut pair: impl FnMut(usize) -> [T; 2]) {
        for (index, slots) in self.next(2 * count).chunks_exact_mut(2).enumerate() {
            let [first, second] = pair(index);
            slots[0].write(first);
            slots[1].write(second);
        }
        self.count += 2 * count;
    }

    /// Writes the next `len` items, all alike.
    #[inline]
    pub(crate) fn fill(&mut self, len: usize, item: T) {
        for slot in self.next(len) {
            slot.write(item);
        }
        self.count += len;
    }
}

impl<'a, T> Room<'a, T> {
    /// Takes the next `len` items.
    #[inline]
    fn next(&mut self, len: usize) -> &'a mut [MaybeUninit<T>] {
        let (next, rest) = std::mem::take(&mut self.items).split_at_mut(len);
        self.items = rest;
        next
    }
}

impl<T> Drop for Room<'_, T> {
    fn drop(&mut self) {
        self.written.fetch_add(self.count, Ordering::Relaxed);
    }
}

/// Gives back the memory behind a buffer's items, but for the rest of the last
/// huge page, which would have to be taken apart.
pub(crate) fn shrink<T>(buffer: &mut Vec<T>) {
    let is_large = buffer.len() * size_of::<T>() >= HUGE / 2;
    buffer.shrink_to(if is_large {
        whole::<T>(buffer.len())
    } else {
        0
    });
}

/// Asks the system to back a buffer, and what shares huge pages with it, by
/// those; and by one where it starts at once, since the allocator has already
/// written there: pages that are in use do not become huge by themselves.
/// Their 511 neighbours would take 0.6 ms, where this takes 0.07; some ms where
/// other programs keep all cores busy, since the system waits for each of them.
#[cfg(target_os = "linux")]
fn prefer_huge_pages<T>(buffer: &[T]) {
    let start = buffer.as_ptr().addr() & !(HUGE - 1);
    let end = (buffer.as_ptr().addr() + size_of_val(buffer)).next_multiple_of(HUGE);
    let advise = |length, advice| {
        // SAFETY: advice on huge pages changes no contents and no protection
        // of any page, whosever it is; addresses without a page are reported
        // as an error, which is of no interest: it was a wish.
        unsafe {
            libc::madvise(std::ptr::with_exposed_provenance_mut(start), length, advice);
        }
    };
    advise(end - start, libc::MADV_HUGEPAGE);
    advise(HUGE, libc::MADV_COLLAPSE);
}

#[cfg(not(target_os = "linux"))]
fn prefer_huge_pages<T>(_: &[T]) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extended_buffers_keep_what_they_hold() {
        let mut buffer: Vec<u32> = Vec::new();
        for additional in [0, 1, 1000, 600_000, 1, 1_400_000] {
            let held = buffer.len() as u32;
            reserve(&mut buffer, 2 * additional);
            extend(&mut buffer, additional, |mut room| {
                let mut first = room.split(additional / 3);
                // In whatever order.
                room.fill(additional - additional / 3, 7);
                first.copy(&vec![5; additional / 3]);
            });
            let (old, new) = buffer.split_at(held as usize);
            assert!((0..held).eq(old.iter().copied()));
            let (first, rest) = new.split_at(additional / 3);
            assert!(first.iter().all(|&item| item == 5) && rest.iter().all(|&item| item == 7));
            (0..).zip(&mut buffer).for_each(|(i, item)| *item = i);
            shrink(&mut buffer);
        }
        assert_eq!(buffer.len(), 2_001_002);
    }

    #[test]
    #[should_panic(expected = "items that nobody wrote")]
    fn items_left_out_are_not_taken_for_written() {
        let mut buffer: Vec<u32> = Vec::new();
        extend(&mut buffer, 3, |mut room| {
            room.split(1);
            room.fill(2, 7);
        });
    }
}
