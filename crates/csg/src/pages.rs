//! Large buffers, backed by huge pages where the system has them.
//!
//! A fresh page costs about 2 µs at its first touch, whatever the system
//! does besides clearing it: for a mesh of 56 bytes a surface cell that is a
//! third of the time that meshing takes. A huge page holds 512 of them.
#![allow(unsafe_code)]

use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicUsize, Ordering};

use bytemuck::Zeroable;

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
pub(crate) fn extend<T: Zeroable, R>(
    buffer: &mut Vec<T>,
    additional: usize,
    write: impl FnOnce(Room<'_, T>) -> R,
) -> R {
    buffer.reserve(additional);
    let written = AtomicUsize::new(0);
    let room = Room {
        items: &mut buffer.spare_capacity_mut()[..additional],
        written: &written,
    };
    let result = write(room);
    assert_eq!(written.into_inner(), additional, "items that nobody wrote");
    // SAFETY: `Room::zeroed` counts what it writes, and takes the room, so
    // that no item is counted twice: all of the additional ones are there.
    unsafe { buffer.set_len(buffer.len() + additional) };
    result
}

/// Memory for items that are yet to be written.
pub(crate) struct Room<'a, T> {
    items: &'a mut [MaybeUninit<T>],
    written: &'a AtomicUsize,
}

impl<'a, T: Zeroable> Room<'a, T> {
    /// Room for the first `len` items, and the rest.
    pub(crate) fn split_at(self, len: usize) -> (Self, Self) {
        let written = self.written;
        let (first, rest) = self.items.split_at_mut(len);
        let of = |items| Self { items, written };
        (of(first), of(rest))
    }

    /// The items, all zeroes.
    pub(crate) fn zeroed(self) -> &'a mut [T] {
        for item in &mut *self.items {
            item.write(T::zeroed());
        }
        self.written.fetch_add(self.items.len(), Ordering::Relaxed);
        // SAFETY: all of them were just written.
        unsafe { self.items.assume_init_mut() }
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
/// Their 511 neighbours would take 1.2 ms, where this takes 0.15.
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
            extend(&mut buffer, additional, |room| {
                let (first, rest) = room.split_at(additional / 3);
                // In whatever order.
                rest.zeroed().fill(7);
                assert!(first.zeroed().iter().all(|&item| item == 0));
            });
            let (old, new) = buffer.split_at(held as usize);
            assert!((0..held).eq(old.iter().copied()));
            let (first, rest) = new.split_at(additional / 3);
            assert!(first.iter().all(|&item| item == 0) && rest.iter().all(|&item| item == 7));
            (0..).zip(&mut buffer).for_each(|(i, item)| *item = i);
            shrink(&mut buffer);
        }
        assert_eq!(buffer.len(), 2_001_002);
    }

    #[test]
    #[should_panic(expected = "items that nobody wrote")]
    fn items_left_out_are_not_taken_for_written() {
        let mut buffer: Vec<u32> = Vec::new();
        extend(&mut buffer, 3, |room| {
            room.split_at(1).1.zeroed();
        });
    }
}
