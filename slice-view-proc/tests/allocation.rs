//! An image takes no memory once its like was drawn: every allocation of the process is counted.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]
#![allow(
    unsafe_code,
    reason = "an allocator can be replaced in no other way; this one counts and hands on"
)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};

use common::{noise, plane, samplings, volume};
use geometry::{Direction, SlicePlane};
use slice_view_proc::reslice::{Cpu, Resampler};

struct Counting;

/// Of every thread, as an image may be drawn by several.
static TAKEN: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call goes on to the system's allocator unchanged; counting neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        TAKEN.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is handed on.
        unsafe { System.dealloc(place, layout) }
    }
    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        TAKEN.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn taken(work: impl FnOnce()) -> u64 {
    let before = TAKEN.load(Ordering::Relaxed);
    work();
    TAKEN.load(Ordering::Relaxed) - before
}

/// The only test of its binary: one beside it would be counted too.
#[test]
fn an_image_takes_no_memory_once_its_like_was_drawn() {
    assert_eq!(taken(|| drop(black_box(vec![1_u8; 100]))), 1);
    let noisy = volume([40, 40, 40], noise);
    let planes = |size: u32| -> [SlicePlane; 2] {
        [19.3, 20.7].map(|z| {
            plane(
                [20.0, 20.0, z],
                [Direction::X, Direction::Y],
                30.0 / f64::from(size),
                [size, size],
            )
        })
    };
    for size in [64, 256] {
        let mut hu = vec![0.0; (size * size) as usize];
        for sampling in samplings() {
            let mut cpu = Cpu::default();
            cpu.prepare(&noisy.view(), &[sampling], &mut || {}).unwrap();
            let [first, next] = planes(size);
            cpu.reslice(&noisy.view(), &first, &sampling, &mut hu).unwrap();
            let count = taken(|| cpu.reslice(&noisy.view(), &next, &sampling, &mut hu).unwrap());
            assert_eq!(count, 0, "{size} x {size}, {sampling:?}");
        }
    }
}
