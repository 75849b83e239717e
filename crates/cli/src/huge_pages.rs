//! The command's allocator: large blocks on huge pages.
//!
//! A process that has just been started touches all of its memory for the
//! first time, and each fresh page of 4 KiB costs it about a microsecond: a
//! third of the time from a mesh of a million triangles to its picture. A
//! huge page holds 512 of them.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::ptr;

/// Bytes of a huge page.
const PAGE: usize = 2 << 20;
/// Blocks of so many bytes have pages of their own.
const LARGE: usize = PAGE / 2;

/// Maps large blocks by themselves and asks the system to back them by huge
/// pages; leaves all others to the system's allocator.
pub(crate) struct HugePages;

/// Whether a block is large. (None is aligned to more than a page of the
/// least kind, which every mapping is.)
fn is_large(layout: Layout) -> bool {
    layout.size() >= LARGE && layout.align() <= 4096
}

/// Bytes that are mapped for a large block; `None` if there is no such number.
fn mapped(size: usize) -> Option<usize> {
    size.checked_next_multiple_of(PAGE)
}

// SAFETY: what is large is decided by the layout alone, so that a block goes
// back to where it came from. A large block is a private mapping of at least
// its size, aligned to a page, which nothing else refers to.
unsafe impl GlobalAlloc for HugePages {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if is_large(layout) {
            map(layout.size())
        } else {
            // SAFETY: the caller's promises are the system's.
            unsafe { System.alloc(layout) }
        }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if is_large(layout) {
            // Fresh pages are zero.
            map(layout.size())
        } else {
            // SAFETY: the caller's promises are the system's.
            unsafe { System.alloc_zeroed(layout) }
        }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        if !is_large(layout) {
            // SAFETY: the block is the system's.
            return unsafe { System.dealloc(block, layout) };
        }
        if let Some(length) = mapped(layout.size()) {
            // SAFETY: `map` or `realloc` mapped so many bytes here.
            unsafe { libc::munmap(block.cast(), length) };
        }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller promises that the new size is valid, too.
        let new = unsafe { Layout::from_size_align_unchecked(size, layout.align()) };
        match (is_large(layout), is_large(new)) {
            // SAFETY: the block is the system's, and stays so.
            (false, false) => unsafe { System.realloc(block, layout, size) },
            (true, true) => match (mapped(layout.size()), mapped(size)) {
                (Some(old), Some(new)) if old == new => block,
                // SAFETY: `old` bytes are mapped here; moving the pages
                // keeps what is in them.
                (Some(old), Some(new)) => {
                    checked(unsafe { libc::mremap(block.cast(), old, new, libc::MREMAP_MAYMOVE) })
                }
                _ => ptr::null_mut(),
            },
            // SAFETY: a new block of the new size, as much of the old one as
            // fits, and the old one given back.
            _ => unsafe {
                let fresh = self.alloc(new);
                if !fresh.is_null() {
                    ptr::copy_nonoverlapping(block, fresh, layout.size().min(size));
                    self.dealloc(block, layout);
                }
                fresh
            },
        }
    }
}

/// Fresh pages for a large block; null if there are none.
fn map(size: usize) -> *mut u8 {
    let Some(length) = mapped(size) else {
        return ptr::null_mut();
    };
    // SAFETY: a new private mapping touches no other; advice on huge pages
    // changes no contents, and where it is refused nothing is lost.
    unsafe {
        let block = checked(libc::mmap(
            ptr::null_mut(),
            length,
            libc::PROT_READ | libc::PROT_WRITE,
            libc::MAP_PRIVATE | libc::MAP_ANONYMOUS,
            -1,
            0,
        ));
        if !block.is_null() {
            libc::madvise(block.cast(), length, libc::MADV_HUGEPAGE);
        }
        block
    }
}

/// What a failed mapping is called by allocators.
fn checked(block: *mut libc::c_void) -> *mut u8 {
    if block == libc::MAP_FAILED {
        ptr::null_mut()
    } else {
        block.cast()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks of all sizes keep their contents while they grow and shrink
    /// past the limit, and come zeroed where that is asked for.
    #[test]
    fn blocks_keep_their_contents() {
        let sizes = [
            100,
            LARGE - 1,
            LARGE,
            3 * PAGE,
            3 * PAGE + 1,
            PAGE,
            LARGE - 1,
            1,
        ];
        let layout = |size| Layout::from_size_align(size, 64).expect("a layout");
        // SAFETY: every block is used within its size, and given back once.
        unsafe {
            let mut block = HugePages.alloc_zeroed(layout(sizes[0]));
            for pair in sizes.windows(2) {
                let [from, to] = [pair[0], pair[1]];
                for at in [0, from / 2, from - 1] {
                    block.add(at).write((at % 251) as u8 + 1);
                }
                block = HugePages.realloc(block, layout(from), to);
                assert!(!block.is_null() && block.addr() % 64 == 0);
                for at in [0, from / 2, from - 1] {
                    if at < to {
                        assert_eq!(block.add(at).read(), (at % 251) as u8 + 1);
                    }
                }
            }
            HugePages.dealloc(block, layout(1));
            for size in sizes {
                let block = HugePages.alloc_zeroed(layout(size));
                let bytes = std::slice::from_raw_parts_mut(block, size);
                assert!(bytes.iter().all(|b| *b == 0));
                bytes.fill(1);
                HugePages.dealloc(block, layout(size));
            }
        }
    }
}
