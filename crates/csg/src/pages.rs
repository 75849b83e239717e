//! Large buffers, backed by huge pages where the system has them.
//!
//! A fresh page costs about 2 µs at its first touch, whatever the system
//! does besides clearing it: for a mesh of 56 bytes a surface cell that is a
//! third of the time that meshing takes. A huge page holds 512 of them.
#![allow(unsafe_code)]

use bytemuck::Zeroable;

/// Bytes in a huge page.
const HUGE: usize = 2 << 20;

/// What the allocator puts before a buffer of its own mapping, and more.
const HEADER: usize = 64;

/// `len` zeroes. What comes from the system untouched stays so.
pub(crate) fn zeroed<T: Zeroable>(len: usize) -> Vec<T> {
    let bytes = len * size_of::<T>();
    if bytes < HUGE / 2 {
        return bytemuck::zeroed_vec(len);
    }
    // A mapping of whole huge pages is aligned to them by the system.
    let whole = (bytes + HEADER).next_multiple_of(HUGE) - HEADER;
    let mut buffer = bytemuck::zeroed_vec(whole / size_of::<T>());
    prefer_huge_pages(&buffer);
    buffer.truncate(len);
    buffer
}

/// Asks the system to back a buffer, and what shares huge pages with it, by
/// those.
#[cfg(target_os = "linux")]
fn prefer_huge_pages<T>(buffer: &[T]) {
    let start = buffer.as_ptr().addr() & !(HUGE - 1);
    let end = (buffer.as_ptr().addr() + size_of_val(buffer)).next_multiple_of(HUGE);
    // SAFETY: advice on huge pages changes no contents and no protection of
    // any page, whosever it is; addresses without a page are reported as an
    // error, which is of no interest: it was a wish.
    unsafe {
        libc::madvise(
            std::ptr::with_exposed_provenance_mut(start),
            end - start,
            libc::MADV_HUGEPAGE,
        );
    }
}

#[cfg(not(target_os = "linux"))]
fn prefer_huge_pages<T>(_: &[T]) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buffers_are_as_long_as_asked_and_zero() {
        for len in [0, 1, 1000, 43_690, 87_381, 87_382, 300_000] {
            let buffer: Vec<[u32; 3]> = zeroed(len);
            assert_eq!(buffer.len(), len);
            assert!(buffer.iter().all(|item| *item == [0; 3]));
        }
    }
}
