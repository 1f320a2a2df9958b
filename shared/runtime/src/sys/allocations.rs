//! Counts what a thread allocates, and what of it the system's memory had to give: the proof that a
//! loop that flies takes none.
//!
//! The transport makes a handle of 48 bytes for every sample that it sends and drops it at once.
//! Blocks of that size come from a few that the thread keeps for itself, so that a send costs no
//! visit to the system's allocator.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::thread::LocalKey;

/// Sizes of the blocks that a thread keeps: above 32 and up to 64 bytes.
const KEPT_MIN: usize = 33;
const KEPT_MAX: usize = 64;
/// What such a block really is.
const KEPT: Layout = match Layout::from_size_align(KEPT_MAX, 16) {
    Ok(layout) => layout,
    Err(_) => unreachable!(),
};
/// Two loans at a time, and their clones.
const KEPT_COUNT: usize = 4;

thread_local! {
    // const: the counter itself must not allocate when a thread first touches it.
    static COUNT: Cell<u64> = const { Cell::new(0) };
    static TAKEN: Cell<u64> = const { Cell::new(0) };
    static SPARE: [Cell<*mut u8>; KEPT_COUNT] = const { [const { Cell::new(core::ptr::null_mut()) }; KEPT_COUNT] };
}

/// The system's allocator with a counter a thread; a binary installs it with `#[global_allocator]`.
pub struct CountingAllocator;

/// Allocations and reallocations of this thread so far; 0 for ever where [`CountingAllocator`] is
/// not installed.
#[must_use]
pub fn allocations() -> u64 {
    COUNT.with(Cell::get)
}

/// Those of [`allocations`] that the thread had no block of its own for.
#[must_use]
pub fn allocations_of_system() -> u64 {
    TAKEN.with(Cell::get)
}

fn count(of: &'static LocalKey<Cell<u64>>) {
    // A thread that is being torn down still frees and allocates; it is no longer counted.
    let _ = of.try_with(|count| count.set(count.get() + 1));
}

/// Decided by the layout alone, so that a block is given back the way it came, on any thread.
fn is_kept(layout: &Layout) -> bool {
    (KEPT_MIN..=KEPT_MAX).contains(&layout.size()) && layout.align() <= KEPT.align()
}

fn take_spare() -> Option<*mut u8> {
    let take = |spare: &[Cell<*mut u8>; KEPT_COUNT]| {
        let place = spare.iter().find(|place| !place.get().is_null())?;
        Some(place.replace(core::ptr::null_mut()))
    };
    SPARE.try_with(take).ok().flatten()
}

/// Whether there was room for it.
fn keep_spare(pointer: *mut u8) -> bool {
    let keep = |spare: &[Cell<*mut u8>; KEPT_COUNT]| {
        let free = spare.iter().find(|place| place.get().is_null());
        free.inspect(|place| place.set(pointer)).is_some()
    };
    SPARE.try_with(keep).unwrap_or(false)
}

// SAFETY: a kept block is 64 bytes of `System`, aligned to 16, which serves every layout of
// `is_kept`; it is in one place at a time: with the program, or in one thread's `SPARE`. Every
// other call goes unchanged to `System`, which keeps the contract.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(&COUNT);
        if !is_kept(&layout) {
            count(&TAKEN);
            // SAFETY: the caller keeps the contract of `alloc`.
            return unsafe { System.alloc(layout) };
        }
        take_spare().unwrap_or_else(|| {
            count(&TAKEN);
            // SAFETY: `KEPT` is not of size 0.
            unsafe { System.alloc(KEPT) }
        })
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        if !is_kept(&layout) {
            // SAFETY: `pointer` came from `System` with this layout, as the caller promises.
            return unsafe { System.dealloc(pointer, layout) };
        }
        if !keep_spare(pointer) {
            // SAFETY: every block of such a layout came from `System` as `KEPT`.
            unsafe { System.dealloc(pointer, KEPT) }
        }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if !is_kept(&layout) {
            count(&COUNT);
            count(&TAKEN);
            // SAFETY: the caller keeps the contract of `alloc_zeroed`.
            return unsafe { System.alloc_zeroed(layout) };
        }
        // SAFETY: the caller keeps the contract of `alloc`, which is that of `alloc_zeroed`.
        let pointer = unsafe { self.alloc(layout) };
        if !pointer.is_null() {
            // SAFETY: the block has `layout.size()` bytes at least.
            unsafe { pointer.write_bytes(0, layout.size()) };
        }
        pointer
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        // SAFETY: the caller promises that `new_size` rounded up to the alignment is a valid size.
        let new_layout = unsafe { Layout::from_size_align_unchecked(new_size, layout.align()) };
        match (is_kept(&layout), is_kept(&new_layout)) {
            (true, true) => {
                count(&COUNT);
                pointer
            }
            (false, false) => {
                count(&COUNT);
                count(&TAKEN);
                // SAFETY: `pointer` came from `System` with this layout, as the caller promises.
                unsafe { System.realloc(pointer, layout, new_size) }
            }
            _ => {
                // SAFETY: `new_layout` is valid and not of size 0, as the caller promises.
                let moved = unsafe { self.alloc(new_layout) };
                if !moved.is_null() {
                    // SAFETY: both blocks have the smaller size at least and are two; `pointer` is
                    // given back with the layout it came with.
                    unsafe {
                        core::ptr::copy_nonoverlapping(pointer, moved, layout.size().min(new_size));
                        self.dealloc(pointer, layout);
                    }
                }
                moved
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_of_the_size_of_a_loan_is_taken_once_and_reused_and_contents_survive_every_growth() {
        let allocator = CountingAllocator;
        let layout = |size| Layout::from_size_align(size, 8).unwrap();
        // SAFETY: each block is given back with the layout that it has then.
        unsafe {
            let first = allocator.alloc(layout(48));
            allocator.dealloc(first, layout(48));
            let before = allocations_of_system();
            for size in [40, 48, 64] {
                let again = allocator.alloc_zeroed(layout(size));
                assert_eq!(again, first);
                assert!((0..size).all(|at| again.add(at).read() == 0));
                again.write_bytes(7, size);
                allocator.dealloc(again, layout(size));
            }
            assert_eq!(allocations_of_system(), before, "from the thread's own blocks");
            let mut block = allocator.alloc(layout(16));
            block.write_bytes(9, 16);
            let mut size = 16;
            for new_size in [24, 40, 64, 65, 200, 64, 33, 32, 48] {
                block = allocator.realloc(block, layout(size), new_size);
                size = new_size;
                assert!((0..16).all(|at| block.add(at).read() == 9), "{new_size}");
            }
            allocator.dealloc(block, layout(size));
        }
    }
}
